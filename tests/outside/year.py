#!/usr/bin/env python3
"""A year of a fleet with planted faults: what `diagnose` says has changed, night by night, against what was planted.

    python tests/outside/year.py --roadbench target/debug/roadbench --work /tmp/year make
    python tests/outside/year.py --roadbench target/debug/roadbench --work /tmp/year nights
    python tests/outside/year.py --work /tmp/year score
    python tests/outside/year.py --work /tmp/small --small --seed 7 make      (then once and score: six other motorcycles)

16 motorcycles ride 20 times each, two rides a day, on ten days of a year. Twelve are reduced-order motorcycles, which are related
to the fitted model, four are nonlinear ones. Friction, drag, rolling resistance, brakes and wind of every ride are drawn anew,
and so are the zeros of its sensors. A night has the two rides of a day of each motorcycle: `run`, then `diagnose --nulls 0`, into one output.
`once` is `diagnose --nulls 0` of all rides at once, without `run`."""

import argparse
import copy
import json
import random
import shutil
from pathlib import Path

from simulated import Machine, Simulator, roadbench, rows, text

RIDES = 20
DAYS = ["2026-01-14", "2026-02-18", "2026-03-22", "2026-04-25", "2026-05-30", "2026-07-04", "2026-08-09", "2026-09-12", "2026-10-17", "2026-11-21"]
REPORTED = ("named", "ambiguous", "changed")
# what the front tyre of another model has, over the first one's
OTHER_TYRE = {"radius_ratio": 0.994, "b": 1.15, "c": 1.03, "d": 0.95, "cornering_stiffness": 1.12, "overturning_stiffness": 1.15}
WORN = {"radius_ratio": -0.006, "d": -0.05, "cornering_stiffness": 0.10}


def site(k):
    return "north" if (k // 2) % 3 == 1 else "south"


def rider(k):
    return "anna" if k * 7 % 5 < 2 else "ben"


def tyre(end, factors):
    # the rear crown follows the front one's in this simulator
    return {f"{end}.{key}": factor for key, factor in factors.items() if f"{end}.{key}" != "rear.overturning_stiffness"}


# What is planted: motorcycle, name, rides that have it, how the table calls them, causes that are right, what it does.
# A cause that starts with a tyre's end is any number of that tyre.
PLANTED = [
    ("r03", "wind 2.5 m/s", {7}, {"ride"}, {"wind"}, {"effects": {"wind": 2.5}}),
    ("r03", "wind -1.5 m/s", {14, 15}, {"day", "ride"}, {"wind"}, {"effects": {"wind": -1.5}}),
    ("r04", "slope 0.005 at a site", {k for k in range(RIDES) if site(k) == "north"}, {"site"}, {"road_grade"}, {"effects": {"road_grade": 0.005}}),
    ("r05", "a rider leans 0.06 m/rad", {k for k in range(RIDES) if rider(k) == "anna"}, {"rider"}, {"rider_lean"}, {"effects": {"rider_lean": 0.06}}),
    ("r06", "front pads 10 % weaker", set(range(8, RIDES)), {"since"}, {"brake_gain_front"}, {"factors": {"brake_gain_front": 0.9}}),
    ("r06", "pads lose 0.03 per 50 kJ", set(range(15, RIDES)), {"since"}, {"pad_heat"}, {"effects": {"pad_heat": 0.03}}),
    ("r07", "velocity 30 ms later", set(range(9, RIDES)), {"since"}, {"latency"}, {"effects": {"latency": 0.03}}),
    ("r07", "roll zero 15 mrad", set(range(15, RIDES)), {"since"}, {"roll_zero"}, {"effects": {"roll_zero": 0.015}}),
    ("r08", "front tyre of another model", set(range(8, RIDES)), {"since"}, {"front"}, {"factors": tyre("front", OTHER_TYRE)}),
    ("r08", "rear tyre of another model, said by the log", set(range(14, RIDES)), {"since", "tyre_rear"}, {"rear"}, {"factors": tyre("rear", OTHER_TYRE)}),
    ("r09", "both tyres wear", set(range(RIDES)), {"drift"}, {"front", "rear"}, {"wear": True}),
    ("r10", "log of another motorcycle", {12}, {"ride"}, {"*"}, {}),
    ("r11", "bike file: centre of mass 5 cm, wheel inertia half as much again", set(), set(), set(), {}),
    ("r12", "cold tyres, 0.12", {10, 11}, {"day", "ride"}, {"tyre_warm_up"}, {"effects": {"tyre_warm_up": 0.12}}),
    ("r12", "oil under one front stop, -30 %", {16}, {"outlying"}, {"front"}, {"odd_manoeuvres": [{"kind": "front_braking", "number": 2, "friction": -0.3}]}),
    ("n03", "wind 2.5 m/s", {7}, {"ride"}, {"wind"}, {"wind": 2.5}),
    ("n03", "slope 0.005 at a site", {k for k in range(RIDES) if site(k) == "north"}, {"site"}, {"road_grade"}, {"grade": 0.005}),
    ("n04", "steering zero 10 mrad", {4}, {"ride"}, {"steer_zero"}, {"zero": ("steer_angle", 0.01)}),
    ("n04", "rear tyre of another model", set(range(10, RIDES)), {"since"}, {"rear"}, {"rear_tyre": "mf62_rear_190_55"}),
    ("n04", "front brake 10 % weaker", set(range(15, RIDES)), {"since"}, {"brake_gain_front"}, {"pads": 1 / 0.9}),
]  # fmt: skip
MACHINES = [Machine(f"r{i:02}", 40 + i) for i in range(1, 13)]
MACHINES += [Machine(f"n{i:02}", 60 + i, "sports_small" if i % 2 else "sports_touring") for i in range(1, 5)]


def small(seed):
    """A second year, so that rules are not fitted to the first: six other motorcycles of 12 rides each."""
    global RIDES, MACHINES, PLANTED
    RIDES = 12
    MACHINES = [Machine(f"s{i:02}", 1000 * seed + i) for i in range(1, 5)]
    MACHINES += [Machine(f"t{i:02}", 1000 * seed + 10 + i, "sports_touring" if i % 2 else "sports_small") for i in range(1, 3)]
    PLANTED = [
        ("s02", "wind 2.5 m/s", {5}, {"ride"}, {"wind"}, {"effects": {"wind": 2.5}}),
        ("s02", "roll zero 15 mrad", set(range(8, RIDES)), {"since"}, {"roll_zero"}, {"effects": {"roll_zero": 0.015}}),
        ("s03", "pads lose 0.03 per 50 kJ", set(range(7, RIDES)), {"since"}, {"pad_heat"}, {"effects": {"pad_heat": 0.03}}),
        ("s03", "front pads 10 % weaker", {k for k in range(RIDES) if rider(k) == "anna"}, {"rider"}, {"brake_gain_front"}, {"factors": {"brake_gain_front": 0.9}}),
        ("s04", "velocity 30 ms later", set(range(6, RIDES)), {"since"}, {"latency"}, {"effects": {"latency": 0.03}}),
        ("t02", "steering zero 10 mrad", {4}, {"ride"}, {"steer_zero"}, {"zero": ("steer_angle", 0.01)}),
        ("t02", "rear tyre of another model", set(range(6, RIDES)), {"since"}, {"rear"}, {"rear_tyre": "mf62_rear_190_55"}),
    ]  # fmt: skip


def fault(machine, k, draw):
    """What a ride is like: the scatter of every day, and what is planted."""
    of = {"effects": {"wind": draw.gauss(0.0, 0.2)}, "factors": {}, "wind": draw.gauss(0.0, 0.2), "pads": 1.0 + draw.gauss(0.0, 0.015)}
    of["friction"] = 1.0 + draw.gauss(0.0, 0.01)
    for path, sd in (("friction", 0.01), ("drag", 0.03), ("rolling_resistance", 0.05), ("brake_gain_front", 0.015), ("brake_gain_rear", 0.015)):
        of["factors"][path] = 1.0 + draw.gauss(0.0, sd)
    zero = None
    for _, _, rides, _, _, does in (p for p in PLANTED if p[0] == machine.name and k in p[2]):
        for path, factor in does.get("factors", {}).items():
            of["factors"][path] = of["factors"].get(path, 1.0) * factor
        for name, size in does.get("effects", {}).items():
            of["effects"][name] = of["effects"].get(name, 0.0) + size
        of["wind"] += does.get("wind", 0.0)
        of["pads"] *= does.get("pads", 1.0)
        if does.get("wear"):
            for end in ("front", "rear"):
                for path, change in tyre(end, WORN).items():
                    of["factors"][path] = of["factors"].get(path, 1.0) * (1.0 + change * k / (RIDES - 1))
        for key in ("grade", "rear_tyre", "odd_manoeuvres"):
            if key in does:
                of[key] = does[key]
        zero = does.get("zero", zero)
    of["channels"] = {}
    if machine.model:
        for channel, by in (("brake_pressure_front", of["pads"]), ("brake_pressure_rear", 1.0 + draw.gauss(0.0, 0.015))):
            of["channels"][channel] = lambda _, x, by=by: x * by
    if zero:
        of["channels"][zero[0]] = lambda _, x, by=zero[1]: x + by
    return of


def make(options):
    simulator = Simulator(options.roadbench, options.work / "all")
    for number, machine in enumerate(MACHINES):
        for k in range(RIDES):
            session, day, clock = f"{machine.name}_{k:02}", DAYS[k // 2], ["09:30:00", "14:10:00"][k % 2]
            path = options.work / f"all/sessions/bike={machine.name}/date={day}/{session}.parquet"
            if path.exists():
                continue
            plan = {"kind": "naturalistic", "coasts": 6, "brakings": 5, "laps": 6}
            if k % 4 == 2:
                plan = {"kind": "paper", "coasts": 8, "brakings": 4, "laps": 6}
            about = {"site": site(k), "rider_id": rider(k)}
            if machine.name == "r08":
                about |= {"tyre_rear": "Model B" if k >= 14 else "Model A"}
            ridden = machine
            if (machine.name, k) == ("r10", 12):
                # the log of r01 under another name
                ridden = Machine("r01", 41)
                ridden.name = "r10"
            of = fault(machine, k, random.Random(f"day {options.seed} {session}"))
            simulator.ride(ridden, session, options.seed * 1_000_003 + 1000 * number + k, day, clock, about, plan, of)
    bike = options.work / "all/bikes/r11.toml"
    machine = next((m for m in MACHINES if m.name == "r11"), None)
    if machine is None:
        return
    wrong = copy.deepcopy(machine.file) | {"uncertainty": machine.uncertainty}
    wrong["cg_height"] += 0.05
    for end in ("front", "rear"):
        wrong[end]["wheel_inertia"] = 1.5 * wrong[end]["wheel_inertia"]
    bike.write_text(text(wrong))


def nights(options):
    archive, out = options.work / "archive", options.work / "out"
    kept = options.work / "nights.json"
    # nights that are there are not repeated: remove nights.json, archive and out to begin again
    told = json.loads(kept.read_text()) if kept.exists() else []
    shutil.copytree(options.work / "all/bikes", archive / "bikes", dirs_exist_ok=True)
    first = told[-1]["ride"] + 1 if told else 0
    for k in (k for k in range(1, RIDES, 2) if k >= first):
        for log in (options.work / "all/sessions").rglob("*.parquet"):
            to = archive / log.relative_to(options.work / "all")
            if int(log.stem[-2:]) <= k and not to.exists():
                to.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(log, to)
        night = {"ride": k}
        for command, more in (("run", ["--pages", "none"] if k + 1 < RIDES else []), ("diagnose", ["--nulls", "0"])):
            said, processor, elapsed, peak = roadbench(
                options.roadbench,
                ["--jobs", "1", command, str(archive / "sessions"), "--bikes", str(archive / "bikes"), "--out", str(out), *more],
                options.work / f"{command}_{k:02}.txt",
            )
            (options.work / f"{command}_{k:02}.out").write_text(said)
            night[command] = {"processor": processor, "elapsed": elapsed, "peak": peak}
        for table in ("changes", "fleet_events", "outlying_manoeuvres"):
            night[table] = rows(out, table)
        told.append(night)
        print(k, {c: night[c] for c in ("run", "diagnose")}, flush=True)
        kept.write_text(json.dumps(told, default=str))


def once(options):
    out = options.work / "out"
    said, processor, elapsed, peak = roadbench(
        options.roadbench,
        ["--jobs", "1", "diagnose", str(options.work / "all/sessions"), "--bikes", str(options.work / "all/bikes"), "--nulls", "0", "--out", str(out)],
        options.work / "once.txt",
    )
    (options.work / "once.out").write_text(said)
    night = {"ride": RIDES - 1, "run": {"processor": 0.0, "elapsed": 0.0, "peak": 0.0}, "diagnose": {"processor": processor, "elapsed": elapsed, "peak": peak}}
    night |= {"changes": rows(out, "changes"), "fleet_events": [], "outlying_manoeuvres": []}
    (options.work / "nights.json").write_text(json.dumps([night], default=str))


def is_right(causes, row):
    names = [row["cause"], *(row["rivals"] or "").split(", ")]
    return "*" in causes or any(n and (n in causes or any(n.endswith(f"_{c}") for c in causes)) for n in names)


def rides_of(row, bike):
    """The rides that a row of `changes` is of; those of a set by what they have in common."""
    first, kind = int(row["session_id"][-2:]), row["rides"]
    if kind == "ride":
        return {first}
    if kind == "since":
        return set(range(first, RIDES))
    if kind == "drift":
        return set(range(RIDES))
    common = row["in_common"] or ""
    is_rest = common.startswith("all but ")
    groups = {"site": site, "rider": rider, "day": lambda k: DAYS[k // 2], "tyre_rear": lambda k: "Model B" if k >= 14 else "Model A"}
    of = groups.get(kind, lambda k: "")
    return {k for k in range(RIDES) if (of(k) in common) != is_rest}


def score(options):
    told = json.loads((options.work / "nights.json").read_text())
    last = told[-1]
    changes = [r for r in last["changes"] if r["verdict"] in REPORTED]
    used = set()
    print("planted | found | first reported | as")
    for bike, name, rides, kinds, causes, _ in PLANTED:
        if "outlying" in kinds:
            found = [r for r in last["outlying_manoeuvres"] if r["bike_id"] == bike]
            print(f"{bike} {name} | {[(r['session_id'], r['quantity'], r['start'], r['difference']) for r in found]}")
            # the coefficients of that ride may show it, too
            for i, r in enumerate(changes):
                if r["bike_id"] == bike and rides_of(r, bike) == rides and is_right(causes, r):
                    used.add(i)
                    print(f"      {r['rides']} {r['session_id']}: {r['sentence']} [rivals {r['rivals']}; fdr {r['false_discovery_rate']:.2g}]")
            continue
        same = lambda r: r["bike_id"] == bike and rides and len(rides_of(r, bike) & rides) >= max(1, len(rides) / 2) and len(rides_of(r, bike) - rides) <= len(rides) / 2
        own = [(i, r) for i, r in enumerate(changes) if same(r)]
        right = [(i, r) for i, r in own if is_right(causes, r)]
        used |= {i for i, _ in own}
        first = next((t["ride"] for t in told for r in t["changes"] if r["verdict"] in REPORTED and r["bike_id"] == bike and rides_of(r, bike) & rides and is_right(causes, r)), None)
        late = None if first is None else first - min(rides)
        verdict = "right" if right else "other cause" if own else "not seen"
        print(f"{bike} {name} | {verdict} | {late} rides late")
        for _, r in own:
            print(f"      {r['rides']} {r['session_id']}: {r['sentence']} [rivals {r['rivals']}; fdr {r['false_discovery_rate']:.2g}]")
    print(f"\nrows of nothing planted, last night, {len(changes) - len(used)} of {len(changes)}:")
    for i, r in enumerate(changes):
        if i not in used:
            print(f"      {r['bike_id']} {r['rides']} {r['in_common']} {r['session_id']}: {r['sentence']} [fdr {r['false_discovery_rate']:.2g}; {r['moved']}]")
    print("\nreports of nothing planted on earlier nights (motorcycles without faults):")
    for t in told:
        for r in t["changes"]:
            if r["verdict"] in REPORTED and not any(p[0] == r["bike_id"] and p[2] for p in PLANTED):
                print(f"      after ride {t['ride']}: {r['bike_id']} {r['session_id']} {r['rides']} {r['sentence']}")
    print("\nevents of the coefficients:")
    for r in last["fleet_events"]:
        print("     ", {k: v for k, v in r.items() if v is not None and k in ("bike_id", "kind", "tyre", "from_session", "session_id", "description", "sentence", "coefficient", "start_time")})
    print("\noutlying manoeuvres:", [(r["session_id"], r["quantity"], round(r["start"], 1), round(r["difference"], 4)) for r in last["outlying_manoeuvres"]])
    for command in ("run", "diagnose"):
        of = [t[command] for t in told]
        print(command, "processor s in all", round(sum(o["processor"] for o in of), 1), "last night", {k: round(v, 1) for k, v in of[-1].items()}, "peak MB", round(max(o["peak"] for o in of)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--roadbench", default="target/debug/roadbench")
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--small", action="store_true", help="six other motorcycles, twelve rides each")
    parser.add_argument("what", choices=["make", "nights", "once", "score"])
    options = parser.parse_args()
    options.work = options.work.resolve()
    if options.small:
        small(options.seed)
    {"make": make, "nights": nights, "once": once, "score": score}[options.what](options)


if __name__ == "__main__":
    main()
