"""roadbench against what a good engineer would write in a day: the same rides, time, error and coverage side by side.

    python benches/peer.py --roadbench target/release/roadbench [--sessions 24] [--seed 1]

Needs pyarrow, numpy, scipy and statsmodels. `roadbench simulate` rides the scenario `naturalistic`, each ride on another
motorcycle with other tyres; the script below and `roadbench run --jobs 1` see the logs and the bike files, not the truth.

The script: zeros of the sensors from riding straight on, a low-pass, segments by thresholds (coasting, front braking, rear
braking and driving, steady corners), the algebra of the paper (slips, wheel loads, forces), robust fits (statsmodels' RLM with
Tukey's bisquare, SciPy's least_squares), and intervals from a bootstrap of 200 resamples over manoeuvres in which the whole
chain is fitted again. With --draw-bike each resample also draws the numbers of the bike file from their uncertainties, which
is the better half of what roadbench passes on. Its segments are its own; the truth is opened by `score` only.

Processor time is that of child processes (user and system), one for the script and one for roadbench, start included, over the
number of sessions. `error` is the median of |estimate / truth - 1|, `cover` the share of 95 % intervals that hold the truth;
of roadbench over the rows with status `ok`, of the script over those it gave at all, and, `error*`, over the sessions in which
roadbench says `ok`."""

import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

G, RESAMPLES = 9.80665, 200
SCENARIO = Path(__file__).parents[1] / "pipelines" / "scenarios" / "naturalistic.toml"
SHOWN = [
    ("front", "effective_rolling_radius"), ("rear", "effective_rolling_radius"),
    ("vehicle", "drag"), ("vehicle", "rolling_resistance"),
    ("front", "slip_stiffness"), ("front", "mf_b"), ("front", "mf_c"), ("front", "mf_d"), ("front", "peak_slip"),
    ("rear", "slip_stiffness"), ("rear", "mf_b"), ("rear", "mf_c"), ("rear", "mf_d"), ("rear", "peak_slip"),
    ("front", "lateral_friction_ct"), ("front", "cornering_stiffness_0"), ("front", "camber_stiffness_0"),
    ("rear", "lateral_friction_ct"), ("rear", "cornering_stiffness_0"), ("rear", "camber_stiffness_0"),
    ("front", "overturning_stiffness"),
]  # fmt: skip


# ---- the script ----------------------------------------------------------------------------------------------------


def load(path):
    """Channels by name, low-passed, with the zeros of the sensors taken off; the bike's name."""
    import numpy as np
    import pyarrow.parquet as pq
    from scipy.signal import butter, sosfiltfilt

    table = pq.read_table(path, partitioning=None)
    x = {name: table[name].to_numpy(zero_copy_only=False).astype(float) for name in table.column_names if name != "time"}
    time = table["time"].to_numpy(zero_copy_only=False).astype(float)
    rate = 1.0 / np.median(np.diff(time))
    low = butter(2, 10.0, fs=rate, output="sos")
    x = {name: sosfiltfilt(low, v) for name, v in x.items() if np.isfinite(v).all()}
    x["neutral"] = table["gear"].to_numpy(zero_copy_only=False) == 0  # else the engine brakes
    x["rate"] = rate
    v = x["velocity_x"]
    x["ax_of_speed"] = np.gradient(v) * rate
    x["acceleration_x"] -= np.median((x["acceleration_x"] - x["ax_of_speed"])[v > 3])
    x["spin_f"], x["spin_r"] = (np.gradient(x[f"wheel_speed_{w}"]) * rate for w in ("front", "rear"))
    straight = (v > 4) & (np.abs(x["yaw_rate"]) < 0.03) & (np.abs(x["roll"]) < 0.03)
    for name in ("roll", "steer_angle", "yaw_rate", "acceleration_y", "velocity_y"):
        x[name] -= np.median(x[name][straight])
    return x


def segments(mask, rate, shortest, step):
    """Runs of a mask that last: the places of their samples, every `step`-th, without the ends."""
    import numpy as np

    edges = np.flatnonzero(np.diff(np.r_[0, mask.astype(int), 0]))
    trim = int(0.15 * rate)
    runs = [(a + trim, b - trim) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return [np.arange(a, b, step) for a, b in runs if b - a > shortest * rate]


def pick(x):
    """Manoeuvres by kind: a list of sample numbers for each."""
    import numpy as np

    v, ax, rate = x["velocity_x"], x["acceleration_x"], x["rate"]
    front, rear = x["brake_pressure_front"] > 1e5, x["brake_pressure_rear"] > 1e5
    straight = (np.abs(x["roll"]) < 0.06) & (np.abs(x["yaw_rate"]) < 0.08) & (v > 3)
    shut = x["throttle"] < 0.004
    return {
        "coast": segments(straight & shut & x["neutral"] & ~front & ~rear & (ax < 0.0), rate, 1.5, 8),
        "front": segments(straight & front & ~rear & (ax < -0.5), rate, 0.6, 2),
        "rear": segments(straight & rear & ~front & (ax < -0.5), rate, 0.6, 2),
        "drive": segments(straight & ~shut & ~front & ~rear & (ax > 0.3), rate, 0.8, 8),
        "corner": segments(
            (np.abs(x["roll"]) > 0.1) & (np.abs(x["roll_rate"]) < 0.1) & (np.abs(ax) < 1.0) & ~front & ~rear & (v > 3),
            rate, 1.0, 8,
        ),
    }  # fmt: skip


def robust(y, columns):
    """Coefficients by Tukey's bisquare."""
    import numpy as np
    import statsmodels.api as sm

    return sm.RLM(y, np.column_stack(columns), M=sm.robust.norms.TukeyBiweight()).fit(maxiter=30).params


def curve(theta, s):
    import numpy as np

    b, c, d, e1, e2 = theta
    bs = b * s
    return d * np.sin(c * np.arctan(bs - (e1 + e2 * np.sign(s)) * (bs - np.arctan(bs))))


def friction_curve(slip, mu, both, start):
    """The Magic Formula through a cloud; `e2` only where there is driving and braking."""
    import numpy as np
    from scipy.optimize import least_squares

    def whole(theta):
        return theta if both else np.r_[theta, 0.0]

    low, high = [1, 1, 0.1, -6, -4], [80, 2.4, 2.5, 1, 4]
    n = 5 if both else 4
    starts = [start] if start is not None else [[12, 1.4, 1.0, 0.0, 0.0], [20, 1.2, 0.8, -1.0, 0.0]]
    ends = [
        least_squares(
            lambda t: curve(whole(t), slip) - mu, np.clip(first[:n], np.array(low[:n]) + 1e-6, np.array(high[:n]) - 1e-6),
            bounds=(low[:n], high[:n]), loss="soft_l1", f_scale=0.03, x_scale=[10, 1, 1, 1, 1][:n],
        )
        for first in starts
    ]  # fmt: skip
    return whole(min(ends, key=lambda end: end.cost).x)


def fit(x, bike, runs, start=None):
    """Every coefficient that the runs give, by tyre and name."""
    import numpy as np

    m, l, lf, h = (bike[k] for k in ("mass", "wheelbase", "cg_to_front", "cg_height"))
    eps, wheels = bike["caster_angle"], (bike["front"], bike["rear"])
    lr, weight = l - lf, m * G
    inertia = [w["wheel_inertia"] for w in wheels]
    ratio = [w["side_force_ratio"] for w in wheels]
    found = {}

    def at(kinds):
        rows = [run for kind in kinds for run in runs[kind]]
        if len(rows) < 3:
            return None
        rows = np.concatenate(rows)
        return {k: (s[rows] if np.ndim(s) else s) for k, s in x.items()}

    coast = at(["coast"])
    if coast is None:
        return found
    v = coast["velocity_x"]
    radius = [float(robust(v, [coast[f"wheel_speed_{w}"]])[0]) for w in ("front", "rear")]
    found["front", "effective_rolling_radius"], found["rear", "effective_rolling_radius"] = radius
    heavy = m + sum(i / r**2 for i, r in zip(inertia, radius, strict=True))
    drag, rolling = robust(-heavy * coast["acceleration_x"], [v**2, np.full(len(v), weight)])
    found["vehicle", "drag"], found["vehicle", "rolling_resistance"] = drag, rolling

    for k, tyre in enumerate(("front", "rear")):
        z = at(["front"] if k == 0 else ["rear", "drive"])
        if z is None:
            continue
        v, ax = z["velocity_x"], z["acceleration_x"]
        transfer = (m * ax + drag * v**2) * h / l + (inertia[0] * z["spin_f"] + inertia[1] * z["spin_r"]) / l
        load = weight * (lr if k == 0 else lf) / l + (-transfer if k == 0 else transfer)
        other = inertia[1 - k] * z["spin_r" if k == 0 else "spin_f"] / radius[1 - k]  # what turns the free wheel
        mu = (m * ax + drag * v**2 + other) / load
        slip = z[f"wheel_speed_{tyre}"] * radius[k] / v - 1.0
        ok = (load > 0.15 * weight) & (v > 3)
        theta = friction_curve(slip[ok], mu[ok], k == 1, None if start is None else start.get((tyre, "theta")))
        b, c, d, e1, e2 = theta
        s = np.linspace(0.005, 0.6, 600)
        at_peak = s[np.argmax(-curve(theta, -s))]
        at_peak /= 1.0 - at_peak  # theoretical slip in braking, as roadbench gives it
        found |= {
            (tyre, "mf_b"): b, (tyre, "mf_c"): c, (tyre, "mf_d"): d, (tyre, "theta"): theta,
            (tyre, "slip_stiffness"): b * c * d, (tyre, "peak_slip"): at_peak,
        }  # fmt: skip

    z = at(["corner"])
    if z is None:
        return found
    v, turn, roll, steer = z["velocity_x"], z["yaw_rate"], z["roll"], z["steer_angle"]
    sin, cos, tan = np.sin, np.cos, np.tan
    camber = [np.arcsin(cos(steer) * sin(roll) - cos(roll) * sin(steer) * sin(eps)), roll]
    ground = np.arctan(sin(steer) * cos(eps) / (cos(roll) * cos(steer) + sin(roll) * sin(steer) * sin(eps)))
    along, across = v - turn * h * sin(roll), z["velocity_y"] + h * cos(roll) * z["roll_rate"]
    alpha = [np.arctan((across + lf * turn) / along) - ground, np.arctan((across - lr * turn) / along)]
    ay = z["acceleration_y"]
    load = [weight * lr / l, weight * lf / l]
    force = [m * ay * lr / l / cos(ground), m * ay * lf / l]
    for k, tyre in enumerate(("front", "rear")):
        ct = robust(force[k] / load[k], [tan(camber[k])])[0]
        c1, _ = robust(alpha[k], [camber[k], camber[k] ** 3])
        k_alpha = -ct / (c1 + ratio[k])
        found |= {
            (tyre, "lateral_friction_ct"): ct,
            (tyre, "cornering_stiffness_0"): k_alpha,
            (tyre, "camber_stiffness_0"): ratio[k] * k_alpha,
        }
    spin = inertia[0] * z["wheel_speed_front"] + inertia[1] * z["wheel_speed_rear"]
    moment = -m * h * (G * sin(roll) + ay * cos(roll)) - spin * turn * cos(roll)
    crown = wheels[1]["width"] / wheels[0]["width"]
    arm = load[0] * tan(camber[0]) + crown * load[1] * tan(camber[1])
    found["front", "overturning_stiffness"] = -robust(moment, [arm])[0]
    return found


def drawn(bike, random):
    """The bike file's numbers, each somewhere within its uncertainty."""
    out = json.loads(json.dumps(bike))
    for key, sd in bike.get("uncertainty", {}).items():
        *place, last = key.split(".")
        table = out
        for name in place:
            table = table.get(name, {})
        if last in table:
            table[last] += sd * random.standard_normal()
    return out


def script(archive, draw_bike):
    """Every session of an archive: estimate and interval by tyre and coefficient, as JSON."""
    import warnings

    import numpy as np

    warnings.filterwarnings("ignore")  # of iterations that end early in a resample
    random = np.random.default_rng(0)
    answers = {}
    for path in sorted((archive / "sessions").rglob("*.parquet")):
        bike = next(part for part in path.parts if part.startswith("bike=")).removeprefix("bike=")
        bike = tomllib.loads((archive / "bikes" / f"{bike}.toml").read_text())
        x = load(path)
        runs = pick(x)
        best = fit(x, bike, runs)
        again = []
        for _ in range(RESAMPLES):
            some = {
                kind: [all_[i] for i in random.integers(0, len(all_), len(all_))] if all_ else []
                for kind, all_ in runs.items()
            }
            again.append(fit(x, drawn(bike, random) if draw_bike else bike, some, best))
        answers[path.stem] = [
            [*name, float(value), *map(float, np.percentile([a[name] for a in again if name in a] or [np.nan], [2.5, 97.5]))]
            for name, value in best.items()
            if name[1] != "theta"
        ]
    return answers


# ---- the comparison ------------------------------------------------------------------------------------------------


def timed(command, **environment):
    """Processor time of a child, s, and what it printed."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    one = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS", "POLARS_MAX_THREADS")}
    done = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, env=os.environ | one | environment, check=False)
    if done.returncode not in (0, 1):
        sys.exit(f"{command[0]} ended with {done.returncode}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done.stdout


def table(folder):
    import pyarrow.parquet as pq

    return [row for path in sorted(folder.rglob("*.parquet")) for row in pq.read_table(path, partitioning=None).to_pylist()]


def score(rows, truth, sessions=None):
    """Median error in %, coverage in % and number of estimates by coefficient, of rows (session, tyre, name, value, ends)."""
    out = {}
    for key in SHOWN:
        errors, covered = [], []
        for session, *name, value, low, high in rows:
            if tuple(name) != key or (sessions is not None and session not in sessions[key]):
                continue
            true = truth[session][key]
            errors.append(100.0 * abs(value / true - 1.0))
            if low is not None and low == low:
                covered.append(low <= true <= high)
        out[key] = (
            statistics.median(errors) if errors else None,
            100.0 * sum(covered) / len(covered) if covered else None,
            len(errors),
        )
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--roadbench", metavar="BIN", default="target/release/roadbench")
    parser.add_argument("--sessions", type=int, metavar="N", default=24)
    parser.add_argument("--seed", type=int, metavar="S", default=1)
    parser.add_argument("--work", type=Path, metavar="DIR", help="keep rides and tables here")
    parser.add_argument("--script", type=Path, metavar="ARCHIVE", help=argparse.SUPPRESS)
    parser.add_argument("--draw-bike", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.script:
        print(json.dumps(script(given.script, given.draw_bike)))
        return
    with tempfile.TemporaryDirectory() as temporary:
        work = given.work or Path(temporary)
        work.mkdir(parents=True, exist_ok=True)
        compare(given, work)


def compare(given, work):
    archive, out, scenario = work / "archive", work / "out", work / "scenario.toml"
    text = SCENARIO.read_text().replace("seed = 11\n", f"seed = {given.seed}\n")
    scenario.write_text(text)
    timed([given.roadbench, "simulate", scenario, "--bikes", given.sessions, "--out", archive])
    ours, _ = timed([given.roadbench, "run", archive, "--out", out, "--jobs", 1, "--force"])
    me = [sys.executable, __file__, "--script", archive]
    theirs, plain = timed(me)
    theirs_drawn, draws = timed([*me, "--draw-bike"])

    truth = {}
    for r in table(archive / "truth" / "coefficients"):
        truth.setdefault(r["session_id"], {})[r["tyre"], r["coefficient"]] = r["value"]
    rows, there = [], {}
    for r in table(out / "coefficients"):
        there.setdefault(r["session_id"], {})[r["tyre"], r["coefficient"]] = r
    for known in truth.values():
        for t in ("front", "rear"):
            known[t, "slip_stiffness"] = known[t, "mf_b"] * known[t, "mf_c"] * known[t, "mf_d"]
    determined = {key: set() for key in SHOWN}
    for session, found in there.items():
        for key in SHOWN:
            if key[1] == "slip_stiffness":  # a product: no interval of its own
                bcd = [found[key[0], f"mf_{letter}"] for letter in "bcd"]
                if all(r["value"] is not None for r in bcd):
                    value = bcd[0]["value"] * bcd[1]["value"] * bcd[2]["value"]
                    rows.append((session, *key, value, None, None))
                    determined[key].add(session)
            elif found[key]["status"] == "ok":
                r = found[key]
                rows.append((session, *key, r["value"], r["ci95_low"], r["ci95_high"]))
                determined[key].add(session)
    both = []
    for answer in (plain, draws):
        answer = json.loads(answer)
        both.append([(session, *row) for session, found in answer.items() for row in found])
    columns = [score(rows, truth), score(both[0], truth), score(both[0], truth, determined), score(both[1], truth)]
    n = len(truth)
    version = subprocess.run([given.roadbench, "--version"], capture_output=True, text=True, check=False).stdout
    print(f"{n} sessions, seed {given.seed}; {', '.join(version.splitlines())}\n")
    print("| | roadbench | script | script, drawing the bike file too |\n|---|---|---|---|")
    print(f"| processor time of a session | {ours / n:.2f} s | {theirs / n:.2f} s | {theirs_drawn / n:.2f} s |\n")
    print("| coefficient | roadbench: error | cover | determined | script: error | error* | cover | given | cover, bike drawn |")
    print("|---|---|---|---|---|---|---|---|---|")

    def percent(value, digits=0):
        return "-" if value is None else f"{value:.{digits}f} %"

    for key in SHOWN:
        (e, c, k), (se, sc, sk), (same, _, _), (_, dc, _) = (column[key] for column in columns)
        cells = [percent(e, 2), percent(c), percent(100 * k / n), percent(se, 2), percent(same, 2), percent(sc),
                 percent(100 * sk / n), percent(dc)]  # fmt: skip
        print(f"| {' '.join(key).replace('_', ' ')} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
