"""What year.py, odd.py and night.py share: rides of motorcycles that are drawn, by `roadbench simulate`.

Every ride is a scenario of its own with a seed of its own, so that a motorcycle may have other tyres, pads, winds and sensors
from ride to ride. The motorcycles are drawn here, and the bike file says of each what its owner would believe.
"""

import copy
import os
import random
import shutil
import subprocess
import sys
import time
import tomllib
from pathlib import Path

try:
    import pyarrow as pa
    import pyarrow.parquet as pq
except ImportError:
    sys.exit("pyarrow is needed (python3 -m venv, pip install pyarrow)")

REPOSITORY = Path(__file__).resolve().parents[2]
REDUCED = tomllib.loads((REPOSITORY / "fixtures/archive/scenario.toml").read_text())
NONLINEAR = tomllib.loads((REPOSITORY / "pipelines/scenarios/characterise.toml").read_text())
# what every motorcycle has before it is drawn; `spread` of the archive's scenario is about these
TRUTH = {
    "drag": 0.35,
    "rolling_resistance": 0.015,
    "friction": 1.0,
    "brake_gain_front": 2.4e-4,
    "brake_gain_rear": 1.6e-4,
    "front.radius_ratio": 0.99, "front.b": 13.0, "front.c": 1.55, "front.d": 1.05, "front.e1": 0.3,
    "front.cornering_stiffness": 12.5, "front.stiffness_decay": 0.6, "front.overturning_stiffness": 0.045,
    "rear.radius_ratio": 0.99, "rear.b": 12.0, "rear.c": 1.50, "rear.d": 1.08, "rear.e1": 0.25, "rear.e2": -0.1,
    "rear.cornering_stiffness": 13.2, "rear.stiffness_decay": 0.8,
}
# what the archive's bike files assume, needed to draw the truth around it
ASSUMED = {
    "front.side_force_ratio": 0.095, "rear.side_force_ratio": 0.078,
    "front.vertical_stiffness": 130000.0, "rear.vertical_stiffness": 141000.0,
}


def text(table, path=""):
    """A TOML file of nested dictionaries, lists of dictionaries inline."""
    def value(x):
        if isinstance(x, bool):
            return str(x).lower()
        if isinstance(x, str):
            return '"' + x.replace("\\", "\\\\").replace('"', '\\"') + '"'
        if isinstance(x, list):
            return "[" + ", ".join(map(value, x)) + "]"
        if isinstance(x, dict):
            return "{ " + ", ".join(f"{key(k)} = {value(v)}" for k, v in x.items()) + " }"
        return repr(x)

    def key(k):
        return f'"{k}"' if "." in k else k

    plain = [f"{key(k)} = {value(v)}" for k, v in table.items() if not isinstance(v, dict)]
    out = "\n".join(plain) + "\n"
    for k, v in table.items():
        if isinstance(v, dict):
            out += f"\n[{path}{key(k)}]\n" + text(v, f"{path}{key(k)}.")
    return out


def put(table, path, value):
    """A value at a dotted path."""
    *folders, last = path.split(".")
    for folder in folders:
        table = table.setdefault(folder, {})
    table[last] = value


def get(table, path):
    for part in path.split("."):
        table = table[part]
    return table


class Machine:
    """A motorcycle that is drawn: what it is, and what its bike file says."""

    def __init__(self, name, seed, model=None):
        self.name, self.seed, self.model = name, seed, model
        draw = random.Random(f"machine {name} {seed}")
        if model:
            return
        self.truth = dict(TRUTH)
        self.file = {k: v for k, v in copy.deepcopy(REDUCED["bike"]).items() if k != "uncertainty"}
        for path, value in ASSUMED.items():
            put(self.file, path, value)
        for path, half in REDUCED["spread"].items():
            factor = 1.0 + half * draw.uniform(-1.0, 1.0)
            if path.startswith("truth."):
                self.truth[path.removeprefix("truth.")] *= factor
            else:
                put(self.file, path, float(f"{get(self.file, path) * factor:.4g}"))
        self.real = copy.deepcopy(self.file)
        self.uncertainty = dict(REDUCED["bike"]["uncertainty"])
        for path, sd in self.uncertainty.items():
            put(self.real, path, get(self.file, path) + sd * draw.gauss(0.0, 1.0))


class Simulator:
    """Writes rides below `archive` as `roadbench simulate` makes them."""

    def __init__(self, binary, archive):
        self.binary, self.archive = str(Path(binary).resolve()), Path(archive)
        self.scratch = self.archive.parent / "scratch"

    def ride(self, machine, session, seed, day, clock, about, plan, fault):
        """One ride; `fault` has any of truth, effects, odd_manoeuvres, factors, wind, grade, friction, front_tyre, rear_tyre, channels.
        The log's path and the truth's manoeuvres; None where the motorcycle fell."""
        scenario = self.reduced(machine, seed, plan, fault) if not machine.model else self.nonlinear(machine, seed, plan, fault)
        shutil.rmtree(self.scratch, ignore_errors=True)
        self.scratch.mkdir(parents=True)
        (self.scratch / "scenario.toml").write_text(text(scenario))
        done = subprocess.run(
            [self.binary, "-q", "--jobs", "1", "simulate", "scenario.toml", "--out", "ridden"],
            cwd=self.scratch, capture_output=True, text=True,
        )
        if "fell over" in done.stderr:
            return None
        if done.returncode:
            sys.exit(f"{session}: {done.stderr}")
        log = next((self.scratch / "ridden/sessions").rglob("*.parquet"))
        bikes = self.archive / "bikes"
        bikes.mkdir(parents=True, exist_ok=True)
        if not (bikes / f"{machine.name}.toml").exists():
            if machine.model:
                shutil.copyfile(next((self.scratch / "ridden/bikes").glob("*.toml")), bikes / f"{machine.name}.toml")
            else:
                (bikes / f"{machine.name}.toml").write_text(text(machine.file | {"uncertainty": machine.uncertainty}))
        segments = next((self.scratch / "ridden/truth/segments").rglob("*.parquet"))
        table = pq.read_table(log)
        for channel, change in fault.get("channels", {}).items():
            at = table.schema.get_field_index(channel)
            values = change(table.column("time").to_numpy(), table.column(channel).to_numpy())
            table = table.set_column(at, table.schema.field(at), pa.array(values).cast(table.schema.field(at).type))
        kept = {k: v for k, v in (table.schema.metadata or {}).items() if k != b"ARROW:schema"}
        about = {"start_time": f"{day}T{clock}Z", "session_id": session, "bike_id": machine.name} | about
        table = table.replace_schema_metadata(kept | {k.encode(): v.encode() for k, v in about.items()})
        to = self.archive / f"sessions/bike={machine.name}/date={day}/{session}.parquet"
        to.parent.mkdir(parents=True, exist_ok=True)
        pq.write_table(table, to)
        return to, pq.read_table(segments).to_pylist()

    @staticmethod
    def reduced(machine, seed, plan, fault):
        scenario = {k: copy.deepcopy(v) for k, v in REDUCED.items() if k not in ("bike", "spread", "plans", "fleet")}
        scenario |= {"name": machine.name, "seed": seed, "plans": [plan]}
        scenario["odd_manoeuvres"] = fault.get("odd_manoeuvres", [])
        scenario["fleet"] = {"bikes": 1, "sessions_per_bike": 1}
        # nothing is drawn by the program: no spread, no uncertainty
        scenario["bike"] = copy.deepcopy(machine.real) | {"uncertainty": {k: 0.0 for k in machine.uncertainty}}
        truth = machine.truth | fault.get("truth", {})
        for path, factor in fault.get("factors", {}).items():
            truth[path] *= factor
        scenario["truth"] = {}
        for path, value in truth.items():
            put(scenario["truth"], path, value)
        scenario["effects"] = fault.get("effects", {})
        return scenario

    @staticmethod
    def nonlinear(machine, seed, plan, fault):
        scenario = copy.deepcopy(NONLINEAR) | {"name": machine.name, "seed": seed, "sessions": 1, "motorcycle": machine.model}
        scenario["manoeuvres"] = [{"kind": "plan", "plan": plan}]
        scenario["odd_manoeuvres"] = fault.get("odd_manoeuvres", [])
        scenario["wind"] = [fault.get("wind", 0.0), 0.0]
        scenario["road"] = {"friction": 0.75 * fault.get("friction", 1.0), "grade": fault.get("grade", 0.0)}
        for end in ("front_tyre", "rear_tyre"):
            if end in fault:
                scenario[end] = fault[end]
        return scenario


def memory(pid):
    """Memory of a process and its children, MB: what is in RAM, shared parts counted in each."""
    sizes = 0.0
    for status in Path("/proc").glob("[0-9]*/status"):
        try:
            of = dict(line.split(":", 1) for line in status.read_text().splitlines() if ":" in line)
        except OSError:
            continue  # it has ended
        if str(pid) in (of["Pid"].strip(), of["PPid"].strip()):
            sizes += float(of.get("VmRSS", "0 kB").split()[0]) / 1024
    return sizes


def roadbench(binary, arguments, log):
    """Runs the program (Linux): standard output, processor seconds with its workers', elapsed seconds, and the largest sum of
    memory of it and its workers, MB. The kernel's own maximum of a child begins with this script's memory."""
    begin, peak = time.monotonic(), 0.0
    with open(log, "w") as errors, open(f"{log}.said", "w") as said:
        process = subprocess.Popen([binary, *arguments], stdout=said, stderr=errors)
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            peak = max(peak, memory(process.pid))
            time.sleep(0.2)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode > 1:
        sys.exit(f"{' '.join(arguments)}: {Path(log).read_text()[-2000:]}")
    return Path(f"{log}.said").read_text(), usage.ru_utime + usage.ru_stime, time.monotonic() - begin, peak


def rows(out, table):
    """All rows of a table of an output, months of all motorcycles together."""
    files = sorted(Path(out, table).rglob("*.parquet"))
    return [row for file in files for row in pq.read_table(file, partitioning=None).to_pylist()]
