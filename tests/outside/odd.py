#!/usr/bin/env python3
"""100 rides with one odd manoeuvre and 100 without, of ten motorcycles: what `run` says in table `outlying_manoeuvres`.

    python tests/outside/odd.py --roadbench target/debug/roadbench --work /tmp/odd make
    python tests/outside/odd.py --roadbench target/debug/roadbench --work /tmp/odd run
    python tests/outside/odd.py --work /tmp/odd score

Six motorcycles are reduced-order ones, four nonlinear. Each rides each kind of odd manoeuvre once, and ten times nothing odd. A bump
is put into the log: the front wheel and, a wheelbase later, the rear one slow by a tenth for 0.08 s, and the frame is pushed back."""

import argparse
import json
import shutil
from collections import defaultdict
from pathlib import Path

import numpy as np

from simulated import Machine, Simulator, roadbench, rows


def odd(kind, number=2, **what):
    return {"odd_manoeuvres": [{"kind": kind, "number": number, **what}]}


# name, kind of the manoeuvre, quantities that may show it (none: no quantity is meant for it), what it does
ODD = [
    ("front stop, friction -15 %", "front_braking", {"friction_front"}, odd("front_braking", friction=-0.15)),
    ("front stop, friction -30 %", "front_braking", {"friction_front"}, odd("front_braking", friction=-0.3)),
    ("rear stop, friction -30 %", "rear_braking", {"friction_rear"}, odd("rear_braking", friction=-0.3)),
    ("coasting run, gust of 4 m/s", "coasting", {"resistance"}, odd("coasting", head_wind=4.0)),
    ("coasting run, gust of 8 m/s", "coasting", {"resistance"}, odd("coasting", head_wind=8.0)),
    ("corner, gust of 8 m/s", "cornering", set(), odd("cornering", head_wind=8.0)),
    ("front stop over a bump", "front_braking", set(), {}),
    ("coasting run over a bump", "coasting", set(), {}),
    ("front wheel locks", "front_braking", {"locked_front"}, odd("front_braking", slip=-1.0)),
    ("rear wheel locks", "rear_braking", {"locked_rear"}, odd("rear_braking", slip=-1.0)),
]  # fmt: skip
MACHINES = [Machine(f"r{i}", 20 + i) for i in range(6)]
MACHINES += [Machine(f"n{i}", 30 + i, "sports_small" if i % 2 else "sports_touring") for i in range(4)]
PLAN = {"kind": "naturalistic", "coasts": 6, "brakings": 5, "laps": 3}


def bump(at, delay):
    """Changes of the channels by a bump at an instant, s, that the rear wheel meets a delay later."""
    def push(t, begin):
        return np.clip(np.sin(np.pi * (t - begin) / 0.08), 0.0, None) * ((t >= begin) & (t < begin + 0.08))

    return {
        "wheel_speed_front": lambda t, x: x * (1.0 - 0.1 * push(t, at)),
        "wheel_speed_rear": lambda t, x: x * (1.0 - 0.1 * push(t, at + delay)),
        "acceleration_x": lambda t, x: x - 3.0 * push(t, at) - 3.0 * push(t, at + delay),
        "pitch": lambda t, x: x - 0.02 * push(t, at) + 0.02 * push(t, at + delay),
    }


def make(options):
    simulator = Simulator(options.roadbench, options.work / "archive")
    kept = options.work / "truth.json"
    # rides that are there are not repeated: remove the folder to begin again
    truth = json.loads(kept.read_text()) if kept.exists() else {}
    for number, machine in enumerate(MACHINES):
        for k in range(2 * len(ODD)):
            name, kind, _, does = ODD[k] if k < len(ODD) else ("nothing", None, set(), {})
            session, day = f"{machine.name}_{k:02}", f"2026-05-{k + 1:02}"
            if session in truth:
                continue
            # a motorcycle may fall, as with a front wheel that locks: another ride then
            for attempt in range(10):
                seed = 1_000_003 * options.seed + 10_000 * attempt + 100 * number + k
                ride = lambda fault: simulator.ride(machine, session, seed, day, "10:00:00", {}, PLAN, fault)
                if ridden := ride(does):
                    break
            else:
                print(f"{session}: fell ten times, left out")
                continue
            place = [s for s in ridden[1] if s["kind"] == kind][1:2]
            if "bump" in name and place:
                at = place[0]["start"] + 0.5 * (place[0]["end"] - place[0]["start"])
                ride({"channels": bump(at, 0.1)})
            span = [place[0]["start"], place[0]["end"]] if place else None
            truth[session] = {"odd": name, "place": span, "attempt": attempt}
            kept.write_text(json.dumps(truth))


def run(options):
    out = options.work / "out"
    shutil.rmtree(out, ignore_errors=True)
    said, processor, elapsed, peak = roadbench(
        options.roadbench,
        ["--jobs", "1", "run", str(options.work / "archive/sessions"), "--bikes", str(options.work / "archive/bikes"), "--out", str(out), "--pages", "none"],
        options.work / "run.txt",
    )
    print(said, f"processor {processor:.1f} s, elapsed {elapsed:.1f} s, peak {peak:.0f} MB")


def score(options):
    truth = json.loads((options.work / "truth.json").read_text())
    told = defaultdict(list)
    for row in rows(options.work / "out", "outlying_manoeuvres"):
        told[row["session_id"]].append(row)
    used = defaultdict(lambda: defaultdict(int))
    for row in rows(options.work / "out", "manoeuvres"):
        used[row["session_id"]][row["kind"]] += 1
    print("odd | motorcycle | rides | found at its place | said of it otherwise | rides with something said of another")
    for name, _, quantities, _ in [("nothing", None, set(), None), *ODD]:
        for kind, words in (("r", "reduced-order"), ("n", "nonlinear")):
            sessions = [s for s, t in truth.items() if t["odd"] == name and s[0] == kind and (t["place"] or name == "nothing")]
            there = lambda s, r: truth[s]["place"] and r["start"] < truth[s]["place"][1] and r["end"] > truth[s]["place"][0]
            found = sum(any(there(s, r) and r["quantity"] in quantities for r in told[s]) for s in sessions)
            otherwise = sum(any(there(s, r) and r["quantity"] not in quantities for r in told[s]) for s in sessions)
            others = sum(any(not there(s, r) for r in told[s]) for s in sessions)
            print(f"{name} | {words} | {len(sessions)} | {found} | {otherwise} | {others}")
            for s in sessions:
                lines = [f"{r['quantity']} {r['start']:.1f}-{r['end']:.1f} {r['difference']:+.4f} p {r['chance']}{'' if there(s, r) else ' ELSEWHERE'}" for r in told[s]]
                missed = quantities and not any(there(s, r) and r["quantity"] in quantities for r in told[s])
                if options.verbose and (lines or missed):
                    print(f"      {s} {truth[s]['place']}: {'; '.join(lines) or 'MISSED'}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--roadbench", default="target/debug/roadbench")
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--verbose", action="store_true")
    parser.add_argument("what", choices=["make", "run", "score"])
    options = parser.parse_args()
    options.work = options.work.resolve()
    {"make": make, "run": run, "score": score}[options.what](options)


if __name__ == "__main__":
    main()
