#!/usr/bin/env python3
"""Kills roadbench at random moments, and runs `report` beside `run`; see README.md."""

import argparse
import fcntl
import glob
import os
import random
import shutil
import signal
import sys
import tempfile
import threading
import time
from collections import Counter
from pathlib import Path

import pyarrow.parquet as pq

from common import Bench, contents, differences, put_logs, read, small_logs, tables, temporaries

NULLS = "8"  # fewer are refused


class Reader(threading.Thread):
    """Opens every table of an output again and again."""

    def __init__(self, out):
        super().__init__(daemon=True)
        self.out, self.must, self.opened = out, set(), 0
        self.faults, self.lock, self.is_over = [], threading.Lock(), False

    def run(self):
        while not self.is_over:
            with self.lock:  # between rounds the output is exchanged
                there = set(tables(self.out)) | self.must
                for path in sorted(there):
                    wrong = read(path)
                    self.opened += 1
                    # one that is there in neither state may come and go
                    if wrong and (wrong != "missing" or path in self.must):
                        self.faults.append(f"{os.path.relpath(path, self.out)}: {wrong}")
            time.sleep(0.005)


class Stand:
    """A folder with logs, their outputs and everything that is written beside them."""

    def __init__(self, options):
        self.root = Path(options.work or tempfile.mkdtemp(prefix="kills-")).resolve()
        self.place = self.root / "place"
        self.out, self.logs = self.place / "out", self.root / "logs"
        self.bench = Bench(options.roadbench, self.root / "tmp", options.core)
        self.old, self.new = self.root / "old", self.root / "new"
        self.names = small_logs(options.archive, self.old, options.logs, options.share)
        small_logs(options.archive, self.new, options.logs, options.share * 0.9)
        self.bikes = Path(options.archive).resolve() / "bikes"
        self.known, self.seconds = {}, {}

    def versions(self, which):
        """Logs by version: `old`, `new`, or `one`, where only the first is new."""
        folders = {n: self.new if which == "new" or (which == "one" and n == self.names[0]) else self.old for n in self.names}
        put_logs(folders, self.logs)

    def copies(self):
        return ["--figures", self.place / "figures", "--markdown", self.place / "markdown" / "summary.md"]

    def command(self, name):
        run = ["run", self.logs, "--bikes", self.bikes, "--out", self.out, "--jobs", "2"]
        everything = [*run, "--metrics", self.place / "metrics" / "roadbench.prom", *self.copies()]
        return {
            "run": everything,
            "signals": [*everything, "--signals"],
            "force": [*everything, "--force"],
            "plain": run,
            "report": ["report", self.out, *self.copies()],
            "verify": ["verify", self.out],
            "mend": ["verify", self.out, "--mend"],
            "forget": ["forget", self.out, "--session", self.names[0]],
            "forget_bike": ["forget", self.out, "--bike", self.bike()],
            "diagnose": ["diagnose", self.logs / f"{self.names[0]}.parquet", "--bikes", self.bikes, "--out", self.out,
                         "--nulls", NULLS, "--jobs", "1"],
        }[name]

    def bike(self):
        about = pq.ParquetFile(self.old / f"{self.names[0]}.parquet").metadata.metadata
        return about[b"bike_id"].decode()

    def clear(self):
        shutil.rmtree(self.place, ignore_errors=True)
        self.place.mkdir(parents=True)

    def use(self, template):
        self.clear()
        if template is not None:
            shutil.rmtree(self.place)
            shutil.copytree(template, self.place, symlinks=True)

    def made(self, key, template, versions, command, wanted=(0,), change=None):
        """The folder that an undisturbed command leaves, made once, and its contents."""
        if key not in self.known:
            self.use(template)
            self.versions(versions)
            if change:
                change()
            code, words, seconds = self.bench.run(self.command(command))
            if code not in wanted:
                sys.exit(f"undisturbed `{command}` ({key}) ended with {code}:\n{words}")
            self.seconds[command] = seconds
            to = self.root / "undisturbed" / key
            shutil.rmtree(to, ignore_errors=True)
            shutil.copytree(self.place, to)
            self.known[key] = (to, contents(to))
        return self.known[key]


def break_table(stand, rng):
    """Turns a bit of a table; which one."""
    some = rng.choice([t for t in tables(stand.out) if "/bike=" in t and "/rejected/" not in t])
    data = bytearray(Path(some).read_bytes())
    data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    Path(some).write_bytes(data)
    return os.path.relpath(some, stand.out)


def rounds(stand, options):
    """The kinds of rounds: name, weight, template, logs, command, how it is completed, what comes out."""
    old = stand.made("old", None, "old", "run")
    new = stand.made("new", None, "new", "run")
    one = stand.made("one", old[0], "one", "run")
    base = old[0]
    weights = dict.fromkeys(["run", "diagnose", "report", "verify", "forget"])
    for name in weights:
        weights[name] = getattr(options, name)
    kinds = []

    def add(group, name, template, versions, command, complete, result, allowed=(0,), change=False, between=None):
        kinds.append(dict(group=group, name=name, template=template, versions=versions, command=command,
                          complete=complete, result=result, allowed=allowed, change=change,
                          # what is there in every state that readers may see
                          between=(between or result)[1][0]))

    if weights["run"]:
        signals = stand.made("signals", base, "old", "signals")
        signals_new = stand.made("signals_new", signals[0], "new", "signals")
        add("run", "first", None, "old", "run", ["run"], old)
        add("run", "all", base, "new", "run", ["run"], new)
        add("run", "one", base, "one", "run", ["run"], one)
        add("run", "force", base, "old", "force", ["run"], old)
        add("run", "signals", signals[0], "new", "signals", ["signals"], signals_new)
    if weights["diagnose"]:
        diagnosed = stand.made("diagnosed", base, "old", "diagnose")
        again = stand.made("diagnosed_new", diagnosed[0], "new", "diagnose")
        add("diagnose", "first", base, "old", "diagnose", ["diagnose"], diagnosed)
        add("diagnose", "again", diagnosed[0], "new", "diagnose", ["diagnose"], again)
    if weights["report"]:
        reported = stand.made("reported", base, "old", "report")
        add("report", "again", base, "old", "report", ["report"], reported)
    if weights["verify"]:
        add("verify", "whole", base, "old", "verify", ["verify"], old)
        stand.made("verified", base, "old", "verify")
        stand.made("mended", base, "old", "mend")
        add("verify", "mend", base, "old", "mend", ["mend", "run"], old, change=True)
    if weights["forget"]:
        for name in ["forget", "forget_bike"]:
            gone = stand.made(name, base, "old", name)
            # a session that is out already cannot be named any more
            add("forget", name, base, "old", name, [name], gone, allowed=(0, 2))
            add("forget", f"{name}_run", base, "old", name, ["run"], old, between=gone)
        if weights["diagnose"]:
            gone = stand.made("forget_both", diagnosed[0], "old", "forget")
            add("forget", "forget_diagnosed", diagnosed[0], "old", "forget", ["forget"], gone, allowed=(0, 2))
    for kind in kinds:
        kind["weight"] = weights[kind["group"]] / sum(k["group"] == kind["group"] for k in kinds)
    return kinds


EVENTS = [".roadbench/staged/*/*", ".roadbench/behind*", ".roadbench/next", ".roadbench/next.json", ".roadbench/.*.tmp",
          "fleet*/.*.tmp", "report/.*.tmp", "*/*/.*.tmp"]


def kill(stand, arguments, seconds, rng):
    """Starts a command and kills it: at a random moment, or shortly after something was seen in the output."""
    process = stand.bench.start(arguments)
    reads_only = arguments[0] in ["verify", "report"]  # of those few events are to be seen
    event = rng.choice(EVENTS) if rng.random() < 0.5 and not reads_only else None
    begun = time.monotonic()
    delay = rng.uniform(0, seconds) if event is None else rng.expovariate(1 / 0.02)
    seen = lambda: set(glob.glob(str(stand.out / event)))
    before = seen() if event else set()
    if event is None:
        until = begun + delay
        while time.monotonic() < until and process.poll() is None:
            time.sleep(0.002)
    else:
        while time.monotonic() - begun < 3 * seconds and process.poll() is None:
            if seen() - before:
                time.sleep(delay)
                break
    is_early = process.poll() is None
    only_first = rng.random() < 0.3  # its workers are groups of their own anyhow
    try:
        if only_first:
            process.kill()
        else:
            os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    process.communicate()
    until = time.monotonic() + 15
    while (left := stand.bench.processes()) and time.monotonic() < until:
        time.sleep(0.02)
    return is_early, left, f"{event or 'time'} + {delay:.3f} s"


def killing(stand, options):
    kinds = rounds(stand, options)
    rng = random.Random(options.seed)
    reader = Reader(str(stand.out))
    reader.lock.acquire()
    reader.start()
    count, bugs = Counter(), []

    def bug(what, told, number):
        count[what] += 1
        bugs.append(f"round {number}: {what}: {told}")
        print(bugs[-1], flush=True)

    done = 0
    number = -1
    begun = time.monotonic()
    while done < options.count and (not options.minutes or time.monotonic() - begun < 60 * options.minutes):
        number += 1
        # each by itself, so that --only makes one again
        rng = random.Random(f"{options.seed} {number}")
        kind = rng.choices(kinds, [k["weight"] for k in kinds])[0]
        if options.only is not None and number != options.only:
            if number > options.only:
                break
            continue
        stand.use(kind["template"])
        stand.versions(kind["versions"])
        label = f"{kind['group']}/{kind['name']}"
        if kind["change"]:
            label += f" ({break_table(stand, rng)})"
        wanted = kind["result"][1]
        there = {p: os.path.relpath(p, stand.place) for p in tables(stand.out)}
        reader.must = {p for p, below in there.items() if below in wanted[0] and below in kind["between"]}
        faults = len(reader.faults)
        reader.lock.release()
        moments = []
        arguments = kind["command"]
        while True:
            is_early, left, when = kill(stand, stand.command(arguments), stand.seconds.get(arguments, stand.seconds["run"]), rng)
            moments.append(when if is_early else f"{when} (too late)")
            done += is_early
            count[f"kills of {kind['group']}" if is_early else "ended before they were killed"] += 1
            if left:
                bug("processes that go on", f"{label}: {len(left)} of them, 15 s after {when}", number)
                for process in left:
                    try:
                        os.kill(process, signal.SIGKILL)
                    except ProcessLookupError:
                        pass
            count["kills that left temporaries"] += bool(temporaries(stand.place))
            # what completes it may be killed, too
            arguments = kind["complete"][0]
            if rng.random() > 0.3 or len(moments) > 3:
                break
        label = f"{label}, killed at {'; '.join(moments)}"
        for command in kind["complete"]:
            code, words, _ = stand.bench.run(stand.command(command))
            if code not in kind["allowed"]:
                bug("commands that failed afterwards", f"{label}: {command} ended with {code}: {words.strip()[-500:]}", number)
            elif code:
                count[f"{command} afterwards ended with {code}"] += 1
        reader.lock.acquire()
        for fault in [] if kind["change"] else reader.faults[faults:][:3]:
            bug("tables unreadable or missing", f"{label}: {fault}", number)
        told = differences(contents(stand.place), wanted)
        if told:
            bug("outputs unequal", f"{label}: {len(told)}: {'; '.join(told[:4])}", number)
            # does the next night mend it?
            if kind["group"] == "forget" and kind["complete"] != ["run"]:
                code, _, _ = stand.bench.run(stand.command("verify"))
                count[f"of these, verify ends with {code}"] += 1
            if options.keep:
                to = stand.root / "kept" / str(number)
                shutil.rmtree(to, ignore_errors=True)
                shutil.copytree(stand.place, to)
        for left in temporaries(stand.place):
            bug("temporaries left over", f"{label}: {left}", number)
        for left in sorted(os.listdir(stand.bench.temporary)):
            bug("left over in TMPDIR", f"{label}: {left}", number)
        if os.listdir(stand.bench.temporary):
            shutil.rmtree(stand.bench.temporary)
            stand.bench.temporary.mkdir()
        code, words, _ = stand.bench.run(["verify", stand.out])
        if code and not told:
            bug("verify finds damage", f"{label}: {words.strip()[-300:]}", number)
        count["rounds"] += 1
        if count["rounds"] % 20 == 0:
            print(f"... {done} kills, {len(bugs)} findings, {reader.opened} tables read", flush=True)
    reader.is_over = True
    count["tables read along"] = reader.opened
    return count, bugs


def state(path):
    """The whole of a report's copies: bytes of the Markdown, and every figure."""
    markdown, figures = path / "summary.md", path / "figures"
    return (markdown.read_bytes() if markdown.is_file() else None), contents(figures)[0]


def values(out):
    """The coefficients' rows of every session."""
    found = {}
    for path in tables(out / "coefficients"):
        table = pq.read_table(path, partitioning=None)
        for row in table.to_pylist():
            found.setdefault(row["session_id"], []).append(str(row))
    return found


def slow_reader(stand, is_over):
    """Reads the tables until a run has waited for it a while: other reports come meanwhile."""
    lock, waits = stand.out / ".roadbench" / "tables.lock", stand.out / ".roadbench" / "next.json"
    if not lock.exists():
        return
    with open(lock, "rb") as file:
        fcntl.flock(file, fcntl.LOCK_SH)
        while not waits.exists() and not is_over.is_set():
            time.sleep(0.02)
        time.sleep(0.5)


def together(stand, options):
    """`report` as often as it goes while `run` changes every session."""
    known = {}
    for name in ["old", "new"]:
        folder = stand.made(name, None, name, "run")[0]
        stand.use(folder)
        at = stand.root / "known" / name
        shutil.rmtree(at, ignore_errors=True)
        code, words, _ = stand.bench.run(["report", stand.out, "--markdown", at / "summary.md", "--figures", at / "figures"])
        if code:
            sys.exit(f"undisturbed report: {words}")
        known[name] = (*state(at), contents(stand.place), values(stand.out))
    same = [s for s in known["old"][3] if known["old"][3][s] == known["new"][3].get(s)]
    if same or known["old"][0] == known["new"][0]:
        sys.exit(f"the versions of the logs give the same values ({same}): this would show nothing")
    alike = [f for f in known["old"][1] if known["old"][1][f] == known["new"][1].get(f)]
    count, bugs = Counter({"figures that differ": len(known["old"][1]) - len(alike)}), []
    rng = random.Random(options.seed)
    stand.use(stand.root / "undisturbed" / "old")
    results = stand.root / "reports"

    def bug(what, told):
        count[what] += 1
        bugs.append(f"{what}: {told}")
        if count[what] <= 5:
            print(bugs[-1], flush=True)

    def reports(until, round_, which, found):
        number = 0
        while not until.is_set() or number == 0:
            at = results / f"{round_}-{which}-{number}"
            arguments = ["report", stand.out, "--markdown", at / "summary.md", "--figures", at / "figures"]
            begun = time.monotonic()
            code, words, _ = stand.bench.run(arguments)
            found.append((begun, code, words, at, until.is_set()))
            number += 1

    for round_ in range(options.both):
        version = ["new", "old"][round_ % 2]
        stand.versions(version)
        shutil.rmtree(results, ignore_errors=True)
        until, found = threading.Event(), []
        threads = [threading.Thread(target=reports, args=(until, round_, i, found)) for i in range(options.reporters)]
        for thread in threads:
            thread.start()
        time.sleep(rng.uniform(0, 1))
        run = stand.command("run")
        if rng.random() < options.slow:
            threads.append(threading.Thread(target=slow_reader, args=(stand, until)))
            threads[-1].start()
        begun = time.monotonic()
        if options.both_kill and rng.random() < options.both_kill:
            is_early, _, when = kill(stand, run, stand.seconds["run"], rng)
            count["runs killed" if is_early else "runs not killed in time"] += 1
            time.sleep(rng.uniform(0, 1))  # reports of what was left
        else:
            when = None
            code, words, seconds = stand.bench.run(run, timeout=900)
            count["longest run, s"] = max(count["longest run, s"], round(seconds, 1))
            if code:
                bug("runs that failed", f"round {round_}: {code}: {words.strip()[-300:]}")
        until.set()
        for thread in threads:
            thread.join()
        seen = Counter()
        for at_time, code, words, at, _ in sorted(found, key=lambda f: f[0]):
            count["reports"] += 1
            after = f"round {round_} ({version}{', run killed at ' + when if when else ''}), {at_time - begun:+.2f} s"
            if code:
                bug("reports that failed", f"{after}: {code}: {words.strip()[-300:]}")
                continue
            markdown, figures = state(at)
            text = next((n for n in known if known[n][0] == markdown), "neither")
            if text == "neither":
                parts = Counter()
                lines = (markdown or b"").decode().splitlines()
                olds, news = (set(known[n][0].decode().splitlines()) for n in ["old", "new"])
                for line in lines:
                    parts["old" if line in olds - news else "new" if line in news - olds else "other" if line not in olds | news else "both"] += 1
                bug("reports of neither state", f"{after}: lines {dict(parts)}")
            drawn = {n for n in known if known[n][1] == figures}
            if not drawn:
                both = {f: [n for n in known if known[n][1].get(f) == h] for f, h in figures.items()}
                parts = Counter("/".join(b) or "neither" for b in both.values())
                lacks = len(known["old"][1].keys() - figures.keys())
                bug("figures of neither state", f"{after}: {dict(parts)}, {lacks} missing; e.g. {[f for f, b in both.items() if not b][:3]}")
            elif text != "neither" and text not in drawn:
                bug("Markdown and figures of two states", f"{after}: {text}, {drawn}")
            seen[text] += 1
        count["rounds with reports of both states"] += len(seen.keys() & {"old", "new"}) == 2
        if when:
            code, words, _ = stand.bench.run(run)
            if code:
                bug("runs that failed", f"round {round_}, after {when}: {code}: {words.strip()[-300:]}")
        # pages too: both have written them
        told = differences(contents(stand.out), contents(stand.root / "undisturbed" / version / "out"))
        if told:
            bug("outputs unequal", f"round {round_} ({version}): {len(told)}: {'; '.join(told[:4])}")
            stand.use(stand.root / "undisturbed" / version)
        for left in temporaries(stand.place):
            bug("temporaries left over", f"round {round_}: {left}")
    return count, bugs


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--roadbench", required=True, metavar="BIN")
    parser.add_argument("--archive", required=True, metavar="DIR", help="with sessions/ and bikes/, as fixtures/archive")
    parser.add_argument("--count", type=int, default=1000, help="kills")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, help="no new round after so many")
    parser.add_argument("--only", type=int, metavar="ROUND", help="only this round of the seed")
    parser.add_argument("--keep", action="store_true", help="keep the places of findings in WORK/kept")
    parser.add_argument("--both", type=int, metavar="N", help="no kills: N runs with reports beside them")
    parser.add_argument("--reporters", type=int, default=1, help="with --both: reports at the same time")
    parser.add_argument("--both-kill", type=float, metavar="SHARE", help="with --both: so many runs are killed")
    parser.add_argument("--slow", type=float, default=0.3, metavar="SHARE", help="with --both: in so many rounds a reader is slow, and the run waits for it")
    parser.add_argument("--logs", type=int, default=3)
    parser.add_argument("--share", type=float, default=0.3, help="of each log's rows")
    parser.add_argument("--work", help="folder for all that is written; by default a temporary one")
    parser.add_argument("--core", type=int, help="keep to this processor core")
    for name, weight in [("run", 4), ("diagnose", 1), ("report", 2), ("verify", 1), ("forget", 2)]:
        parser.add_argument(f"--{name}", type=float, default=weight, metavar="WEIGHT")
    options = parser.parse_args()
    stand = Stand(options)
    begun = time.monotonic()
    count, bugs = (together if options.both else killing)(stand, options)
    print(f"{stand.bench.run(['--version'])[1].strip()}, seed {options.seed}, {time.monotonic() - begun:.0f} s")
    for what, n in sorted(count.items()):
        print(f"{n:8} {what}")
    print(f"{len(bugs)} findings")
    if not options.work and not bugs:
        shutil.rmtree(stand.root)
    sys.exit(bool(bugs))


if __name__ == "__main__":
    main()
