#!/usr/bin/env python3
"""A night of many small sessions: processor time, elapsed time and peak memory of `run` and of `diagnose --nulls 0`.

    python tests/outside/night.py --roadbench target/debug/roadbench --rides /tmp/odd/archive --work /tmp/night --sessions 1000 --bikes 20

The sessions are pieces of the rides of another study (odd.py), which differ by a millimetre per second of noise, so that no two logs
have the same bytes. A first night has all of them, a second one has twenty more."""

import argparse
import random
import shutil
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from simulated import roadbench, rows

MORE = 20


def write(table, bike, number, seconds, options):
    draw = np.random.default_rng([options.seed, number])
    time = table.column("time").to_numpy()
    begin = draw.uniform(0.0, max(0.0, time[-1] - seconds))
    inside = np.flatnonzero((time >= begin) & (time < begin + seconds))
    piece = table.slice(inside[0], len(inside))
    at = piece.schema.get_field_index("velocity_x")
    noisy = piece.column(at).to_numpy() + draw.normal(0.0, 1e-3, len(inside))
    piece = piece.set_column(at, piece.schema.field(at), pa.array(noisy).cast(piece.schema.field(at).type))
    at = piece.schema.get_field_index("time")
    piece = piece.set_column(at, piece.schema.field(at), pa.array(piece.column(at).to_numpy() - time[inside[0]]))
    kept = {k: v for k, v in table.schema.metadata.items() if k != b"ARROW:schema"}
    day = f"2026-{1 + number // 28 % 12:02}-{1 + number % 28:02}"
    session = f"{bike}_{number:04}"
    about = {"session_id": session, "bike_id": bike, "start_time": f"{day}T{8 + number // 336 % 12:02}:{number % 60:02}:00Z"}
    piece = piece.replace_schema_metadata(kept | {k.encode(): v.encode() for k, v in about.items()})
    to = options.work / f"archive/sessions/bike={bike}/date={day}/{session}.parquet"
    to.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(piece, to)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--roadbench", default="target/debug/roadbench")
    parser.add_argument("--rides", type=Path, required=True)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--sessions", type=int, default=1000)
    parser.add_argument("--bikes", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=120.0, help="of each session")
    parser.add_argument("--jobs", default="2")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    options.work = options.work.resolve()
    shutil.rmtree(options.work, ignore_errors=True)
    sources = sorted(options.rides.glob("sessions/bike=*"))
    (options.work / "archive/bikes").mkdir(parents=True)
    by_bike = {}
    for k in range(options.bikes):
        source = sources[k % len(sources)]
        bike = f"b{k:02}"
        shutil.copyfile(options.rides / "bikes" / f"{source.name.removeprefix('bike=')}.toml", options.work / f"archive/bikes/{bike}.toml")
        by_bike[bike] = [pq.read_table(p, partitioning=None) for p in sorted(source.rglob("*.parquet"))]

    def put(first, last):
        for number in range(first, last):
            bike = f"b{number % options.bikes:02}"
            table = random.Random(number).choice(by_bike[bike])
            write(table, bike, number, options.seconds, options)

    out = options.work / "out"
    archive = options.work / "archive"
    for first, last in ((0, options.sessions), (options.sessions, options.sessions + MORE)):
        put(first, last)
        for command, more in (("run", []), ("diagnose", ["--nulls", "0"])):
            said, processor, elapsed, peak = roadbench(
                options.roadbench,
                ["--jobs", options.jobs, command, str(archive / "sessions"), "--bikes", str(archive / "bikes"), "--out", str(out), *more],
                options.work / f"{command}_{last}.txt",
            )
            (options.work / f"{command}_{last}.out").write_text(said)
            n = last - first
            print(f"{command} of {n} more sessions: processor {processor:.1f} s ({processor / n:.3f} s each), elapsed {elapsed:.1f} s, with its workers {peak:.0f} MB", flush=True)
    size = sum(p.stat().st_size for p in out.rglob("*") if p.is_file()) / 1e6
    print(f"{len(rows(out, 'sessions'))} sessions in the output, {len(rows(out, 'changes'))} rows of changes, {size:.0f} MB")


if __name__ == "__main__":
    main()
