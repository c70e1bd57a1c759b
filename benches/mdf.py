"""A 200 MB MDF 4 file: `roadbench inspect` and `convert` against asammdf, time and memory in one run.

    python benches/mdf.py target/release/roadbench [FOLDER]

Needs asammdf and pyarrow. The file is written by asammdf: 40 min, 100 channels in three groups (1000, 200 and 50 Hz), single
precision, once plain and once compressed; in FOLDER, if it is given, both are kept for the next time. Each step runs three
times in a process of its own, the two programs in turn; the least time, time of the processor and peak of memory are told.
Both do the same work: `inspect` describes every channel (samples, rate, gaps, least, middle and largest number), `convert`
brings the 16 channels of session.v1 onto one clock of 100 Hz and writes Parquet. roadbench does more on the way: it looks for
faults, and goes down from 1000 and 200 Hz behind a low-pass where asammdf interpolates."""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

MINUTES = 40
FAST = ["roll", "pitch", "yaw", "roll_rate", "yaw_rate", "acceleration_x", "acceleration_y"]
MIDDLE = ["wheel_speed_front", "wheel_speed_rear", "brake_pressure_front", "brake_pressure_rear", "steer_angle"]
SLOW = ["velocity_x", "velocity_y", "throttle", "gear"]
UNIT = {"roll": "rad", "pitch": "rad", "yaw": "rad", "roll_rate": "rad/s", "yaw_rate": "rad/s", "acceleration_x": "m/s^2",
        "acceleration_y": "m/s^2", "wheel_speed_front": "rad/s", "wheel_speed_rear": "rad/s", "brake_pressure_front": "bar",
        "brake_pressure_rear": "bar", "steer_angle": "rad", "velocity_x": "m/s", "velocity_y": "m/s", "throttle": "", "gear": ""}
GROUPS = [("fast", 1000, FAST, 10), ("middle", 200, MIDDLE, 30), ("slow", 50, SLOW, 60)]


def write(path, compression):
    import numpy as np
    from asammdf import MDF, Signal

    random = np.random.default_rng(1)
    mdf = MDF(version="4.10")
    for group, rate, names, count in GROUPS:
        t = np.arange(MINUTES * 60 * rate) / rate
        signals = []
        for i, name in enumerate(names + [f"{group}_{k}" for k in range(count - len(names))]):
            v = 20 + 8 * np.sin(t / 9)
            noise = random.standard_normal(len(t)) * 0.01
            values = {"velocity_x": v, "wheel_speed_front": v / 0.3, "wheel_speed_rear": v / 0.31, "gear": np.ones(len(t)),
                      "throttle": 0.5 + 0.2 * np.sin(t / 9)}.get(name, 0.3 * np.sin(t / (5 + i)))
            values = values + (0 if name == "gear" else noise)
            signals.append(Signal(values.astype(np.float32), t, name=name, unit=UNIT.get(name, "V")))
        mdf.append(signals, acq_name=group, comment=group, common_timebase=True)
    mdf.save(path, overwrite=True, compression=compression)


def asammdf_inspect(path):
    import numpy as np
    from asammdf import MDF

    rows = 0
    with MDF(path) as mdf:
        for g, group in enumerate(mdf.groups):
            for c, channel in enumerate(group.channels):
                if channel.channel_type == 2:
                    continue
                s = mdf.get(group=g, index=c)
                steps = np.diff(s.timestamps)
                period = np.median(steps)
                (steps > max(0.25, 2.5 * period)).sum()
                s.samples.min(), np.median(s.samples), s.samples.max()
                rows += 1
    print(rows, "channels")


def asammdf_convert(path, out):
    from asammdf import MDF

    with MDF(path) as mdf:
        frame = mdf.to_dataframe(channels=FAST + MIDDLE + SLOW, raster=0.01, time_from_zero=True)
    frame.to_parquet(out, compression="zstd")
    print(len(frame), "rows")


def run(command):
    """Wall time, time of the processor, peak memory."""
    began = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    error = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - began
    if status != 0:
        sys.exit(f"{command}: {error.decode()}")
    return wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def main():
    binary = sys.argv[1]
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        out = str(Path(temporary) / "out.parquet")
        own = [sys.executable, __file__, "--step"]
        for kind, compression in (("plain", 0), ("compressed", 2)):
            log = str(folder / f"{kind}.mf4")
            if not os.path.exists(log):
                new = str(folder / f"new_{kind}.mf4")
                subprocess.run([*own, "write", new, str(compression)], check=True, stdout=subprocess.DEVNULL)
                os.replace(new, log)
            print(f"{kind}: {os.path.getsize(log) / 1e6:.0f} MB")
            for step, ours, theirs in (
                ("inspect", [binary, "inspect", log, "--source"], [*own, "inspect", log]),
                ("convert", [binary, "convert", log, "--rate", "100", "--out", out], [*own, "convert", log, out]),
            ):
                runs = {"roadbench": [], "asammdf": []}
                for _ in range(3):
                    for name, command in (("roadbench", ours), ("asammdf", theirs)):
                        runs[name].append(run(command))
                best = {name: [min(column) for column in zip(*of_one)] for name, of_one in runs.items()}
                for name, (wall, cpu, memory) in best.items():
                    print(f"  {step:8} {name:10} {wall:6.2f} s, {cpu:6.2f} s of processor, {memory:5.0f} MB")
                wall, cpu, _ = (theirs / ours for ours, theirs in zip(best["roadbench"], best["asammdf"]))
                print(f"  {step:8} {wall:.1f} times as fast, {cpu:.1f} times by the processor's time", flush=True)


if len(sys.argv) > 2 and sys.argv[1] == "--step":
    step, *rest = sys.argv[2:]
    if step == "write":
        write(rest[0], int(rest[1]))
    elif step == "inspect":
        asammdf_inspect(rest[0])
    else:
        asammdf_convert(*rest)
else:
    main()
