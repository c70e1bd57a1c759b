#!/usr/bin/env python3
"""Replays what roadbench writes up to every instant, as a power cut leaves it; see README.md."""

import argparse
import hashlib
import os
import random
import re
import shutil
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import common
from common import Bench, contents, differences, put_logs, read, small_logs, tables, temporaries

NULLS = "8"  # fewer are refused
CALLS = ("open,openat,openat2,creat,write,writev,pwrite64,pwritev,pwritev2,lseek,ftruncate,truncate,fallocate,rename,renameat,renameat2,"
         "unlink,unlinkat,mkdir,mkdirat,rmdir,fsync,fdatasync,sync,syncfs,sync_file_range,link,linkat,symlink,symlinkat,"
         "copy_file_range,sendfile,splice,mmap")


# what was recorded


def text(hexadecimal):
    r"""Bytes of what strace -xx writes: \x2f\x74..."""
    return bytes.fromhex(hexadecimal.replace("\\x", ""))


def calls(trace):
    """Calls that came back, in the order in which they did: name, arguments, what they gave back."""
    begun = {}
    with open(trace, encoding="ascii", errors="replace") as lines:
        for line in lines:
            process, _, rest = line.rstrip("\n").partition(" ")
            rest = rest.strip()
            if rest.endswith("<unfinished ...>"):
                begun[process] = rest.removesuffix("<unfinished ...>")
                continue
            if resumed := re.match(r"<\.\.\. \w+ resumed>(.*)", rest):
                rest = begun.pop(process, "") + resumed[1]
            if call := re.match(r"(\w+)\((.*)\)\s+= (-?\d+|0x[0-9a-f]+|\?)(.*)$", rest):
                if not call[3].startswith("-"):
                    yield call[1], call[2], call[3] + call[4]
    # one that never came back may have been done or not: a cut before it stands for that


STRING = r'"((?:\\x[0-9a-f]{2})*)"(\.\.\.)?'
AT = r"(?:AT_FDCWD|\d+)<((?:\\x[0-9a-f]{2})*)>"


def events(trace, out):
    """Changes below `out`: (what, path, ...)."""
    root, unknown, positions = str(out), Counter(), {}

    def below(path):
        path = os.path.normpath(path)
        return "" if path == root else path[len(root) + 1:] if path.startswith(root + "/") else None

    for name, arguments, result in calls(trace):
        if name in ["sync", "syncfs"]:
            unknown[name] += 1
            continue
        names = [text(m[1]).decode(errors="surrogateescape") for m in re.finditer(r'"((?:\\x[0-9a-f]{2})*)"', arguments)] if name not in ["write", "pwrite64", "writev", "pwritev", "pwritev2"] else []
        at = re.match(AT, arguments)
        folder = text(at[1]).decode(errors="surrogateescape") if at else os.getcwd()
        if name in ["open", "openat", "creat"]:
            path = below(os.path.join(folder, names[0]))
            if path is None:
                continue
            number = int(re.match(r"\d+", result)[0])
            flags = "O_CREAT|O_TRUNC|O_WRONLY" if name == "creat" else arguments
            if "O_APPEND" in flags or "O_TMPFILE" in flags:
                unknown[f"{name} with O_APPEND or O_TMPFILE"] += 1
            positions[number] = 0
            yield "open", path, number, "O_CREAT" in flags, "O_TRUNC" in flags
        elif name in ["mkdir", "mkdirat"]:
            path = below(os.path.join(folder if name == "mkdirat" else os.getcwd(), names[0]))
            if path:
                yield "mkdir", path
        elif name in ["rmdir", "unlink", "unlinkat"]:
            path = below(os.path.join(folder if name == "unlinkat" else os.getcwd(), names[0]))
            if path is not None:
                yield "unlink", path
        elif name in ["rename", "renameat", "renameat2"]:
            fds = [text(m[1]).decode() for m in re.finditer(AT, arguments)] or [os.getcwd()] * 2
            old, new = (below(os.path.join(f, n)) for f, n in zip(fds, names))
            if (old is None) != (new is None):
                unknown[f"{name} across the output's border"] += 1
            elif old is not None:
                yield "rename", old, new
        elif at and (path := below(folder.removesuffix(" (deleted)"))) is not None:
            number = int(re.match(r"\d+", arguments)[0]) if arguments[0].isdigit() else -1
            if name in ["write", "pwrite64"]:
                data = re.match(AT + ", " + STRING + r", (\d+)(?:, (\d+))?", arguments)
                if not data or data[3]:
                    sys.exit(f"{name}: strace has cut its data")
                written = text(data[2])[: int(re.match(r"\d+", result)[0])]
                offset = int(data[5]) if name == "pwrite64" else positions.get(number, 0)
                if name == "write":
                    positions[number] = offset + len(written)
                yield "write", path, number, offset, written
            elif name == "lseek":
                positions[number] = int(re.match(r"\d+", result)[0])
            elif name == "ftruncate":
                yield "truncate", path, number, int(re.search(r", (\d+)$", arguments)[1])
            elif name in ["fsync", "fdatasync"]:
                yield "fsync", path, number
            elif name != "mmap":
                unknown[name] += 1
        elif name == "mmap":
            mapped = re.search(r"(\d+)<((?:\\x[0-9a-f]{2})*)>", arguments)
            if mapped and "MAP_SHARED" in arguments and "PROT_WRITE" in arguments:
                if below(text(mapped[2]).decode(errors="replace")) is not None:
                    unknown["mmap to write"] += 1
        elif name in ["link", "linkat", "symlink", "symlinkat", "truncate"]:
            if any(below(os.path.join(folder, n)) is not None for n in names):
                unknown[name] += 1
        elif name in ["copy_file_range", "sendfile", "splice"]:
            paths = [text(m[1]).decode(errors="replace") for m in re.finditer(r"\d+<((?:\\x[0-9a-f]{2})*)>", arguments)]
            if any(below(p) is not None for p in paths[-1:]):
                unknown[name] += 1
    if unknown:
        sys.exit(f"not modelled, but used below the output: {dict(unknown)}")


# what a disk has


class File:
    def __init__(self, data=b"", is_safe=False):
        self.data, self.safe = data, data if is_safe else None


class Folder:
    def __init__(self):
        self.now, self.safe = {}, {}  # names, and those that a power cut leaves


class Disk:
    """Files and folders as the program sees them, what of them is safe, and the changes of names that may be lost.

    A rename is done whole or not at all, as journals have it; it is safe once the folder of the new name is synced.
    """

    def __init__(self, folder=None):
        self.root, self.open, self.pending = Folder(), {}, []
        if folder is not None:
            self.load(self.root, folder)

    def load(self, into, folder):
        for entry in sorted(os.scandir(folder), key=lambda e: e.name):
            if entry.is_dir():
                one = Folder()
                self.load(one, entry.path)
            else:
                one = File(Path(entry.path).read_bytes(), is_safe=True)
            into.now[entry.name] = into.safe[entry.name] = one

    def at(self, path):
        one = self.root
        for name in path.split("/") if path else []:
            one = one.now.get(name) if isinstance(one, Folder) else None
        return one

    def parent(self, path):
        folder, _, name = path.rpartition("/")
        return self.at(folder), name

    def do(self, event):
        """Whether anything has changed."""
        what, path, *rest = event
        if what == "open":
            number, creates, truncates = rest
            one = self.at(path)
            is_new = one is None and creates
            if is_new:
                folder, name = self.parent(path)
                one = folder.now[name] = File()
                self.pending.append(("link", folder, name, one))
            self.open[number] = one
            if truncates and not is_new and one.data:
                one.data = b""
                return True
            return is_new
        if what == "mkdir":
            folder, name = self.parent(path)
            if folder is None:
                return False  # the output's own folder
            one = folder.now[name] = Folder()
            self.pending.append(("link", folder, name, one))
        elif what == "unlink":
            folder, name = self.parent(path)
            self.pending.append(("unlink", folder, name, folder.now.pop(name)))
        elif what == "rename":
            (old, old_name), (new, new_name) = self.parent(path), self.parent(rest[0])
            one = new.now[new_name] = old.now.pop(old_name)
            self.pending.append(("rename", new, new_name, one, old, old_name))
        elif what == "write":
            number, offset, data = rest
            one = self.open[number]
            one.data = one.data[:offset].ljust(offset, b"\0") + data + one.data[offset + len(data):]
        elif what == "truncate":
            number, length = rest
            one = self.open[number]
            if len(one.data) == length:
                return False
            one.data = one.data[:length].ljust(length, b"\0")
        elif what == "fsync":
            one = self.open.get(rest[0]) if path and not isinstance(self.at(path), Folder) else self.at(path)
            if isinstance(one, Folder):
                self.sync(one)
            elif one is not None:
                one.safe = one.data
        return True

    def is_safe(self, folder):
        """Whether a folder is found after a power cut."""
        waits = [self.root]
        while waits:
            one = waits.pop()
            if one is folder:
                return True
            waits += [o for o in one.safe.values() if isinstance(o, Folder)]
        return False

    def sync(self, folder):
        left = []
        for op in self.pending:
            if op[1] is not folder:
                left.append(op)
            elif op[0] == "rename" and op[4] is not folder and not self.is_safe(folder):
                left.append(op)
            else:
                names = [f.safe for f in ([op[1], op[4]] if op[0] == "rename" else [op[1]])]
                if op[0] == "rename":  # its old name does not come back
                    left = [o for o in left if not (o[0] == "link" and o[1] is op[4] and o[2] == op[5] and o[3] is op[3])]
                change(op, *names)
        self.pending = left

    def kept(self, wanted):
        """The changes of names that are kept, those among them that others need too."""
        keep = set(i for i, op in enumerate(self.pending) if wanted(i))
        for i in range(len(self.pending) - 1, -1, -1):
            if i not in keep:
                continue
            op = self.pending[i]
            folders = [op[1]] + ([op[4]] if op[0] == "rename" else [])
            for j in range(i):
                other = self.pending[j]
                makes = other[0] in ["link", "rename"] and any(other[3] is f for f in folders)
                # a folder goes only when it is empty
                empties = op[0] == "unlink" and isinstance(op[3], Folder) and (other[1] is op[3] or (other[0] == "rename" and other[4] is op[3]))
                if makes or empties:
                    keep.add(j)
        return [op for i, op in enumerate(self.pending) if i in keep]

    def tree(self, kept, data):
        """Paths and bytes (None of folders) after a cut."""
        names = {}

        def of(folder):
            return names.setdefault(id(folder), dict(folder.safe))

        for op in kept:
            change(op, of(op[1]), *([of(op[4])] if op[0] == "rename" else []))
        found = {}

        def walk(folder, below):
            for name, one in of(folder).items():
                if isinstance(one, Folder):
                    found[below + name] = None
                    walk(one, f"{below}{name}/")
                else:
                    found[below + name] = data(one)

        walk(self.root, "")
        return found

    def now(self):
        return self.tree(self.kept(lambda i: True), lambda f: f.data)

    def cuts(self, rng, many):
        """What a cut at this instant may leave: model and tree."""
        def lost(with_what):
            return lambda f: f.data if f.safe == f.data else f.safe if f.safe is not None and with_what != "zeros" else (
                bytes(len(f.data)) if with_what == "zeros" else b"")

        yield "all on disk", self.now()
        every, none = self.kept(lambda i: True), []
        for data in ["zeros", "empty"]:
            yield f"names kept, unsynced data {data}", self.tree(every, lost(data))
            yield f"unsynced names lost, unsynced data {data}", self.tree(none, lost(data))
        for _ in range(many if self.pending else 0):
            how = lambda f: f.data if f.safe == f.data else rng.choice(
                [f.data, bytes(len(f.data)), b"", f.data[: len(f.data) // 2], f.safe or b""])
            yield "some names kept", self.tree(self.kept(lambda i: rng.random() < 0.5), how)


def change(op, new, old=None):
    """Does a change of names to those of a folder, or of two."""
    what, _, name, one = op[:4]
    if what == "link":
        new[name] = one
    elif what == "unlink":
        if new.get(name) is one:
            del new[name]
    else:
        if old.get(op[5]) is one:
            del old[op[5]]
        new[name] = one


# what comes of it


class Stand:
    def __init__(self, options):
        self.root = Path(options.work or tempfile.mkdtemp(prefix="power-cut-")).resolve()
        self.out, self.logs = self.root / "out", self.root / "logs"
        self.bench = Bench(options.roadbench, self.root / "tmp", options.core)
        self.names = small_logs(options.archive, self.root / "old", options.logs, options.share)
        small_logs(options.archive, self.root / "new", options.logs, options.share * 0.9)
        self.bikes = Path(options.archive).resolve() / "bikes"
        self.signals = ["--signals"] if options.signals else []

    def put(self, new=(), without=()):
        put_logs({n: self.root / ("new" if n in new else "old") for n in self.names if n not in without}, self.logs)

    def command(self, name):
        return {
            "run": ["run", self.logs, "--bikes", self.bikes, "--out", self.out, "--jobs", "2", *self.signals],
            "forget": ["forget", self.out, "--session", self.names[0]],
            "diagnose": ["diagnose", self.logs / f"{self.names[0]}.parquet", "--bikes", self.bikes, "--out", self.out,
                         "--nulls", NULLS, "--jobs", "1"],
        }[name]

    def must(self, name, before=()):
        code, words, _ = self.bench.run(self.command(name), before)
        if code:
            sys.exit(f"undisturbed {name} ended with {code}: {words}")

    def record(self, name, trace):
        strace = ["strace", "-f", "-y", "-qq", "-xx", "-s", str(1 << 26), "-o", trace, "-e", f"trace={CALLS}", "-e", "signal=none"]
        self.must(name, strace)

    def use(self, template):
        shutil.rmtree(self.out, ignore_errors=True)
        if template:
            shutil.copytree(template, self.out)

    def put_tree(self, tree):
        shutil.rmtree(self.out, ignore_errors=True)
        self.out.mkdir()
        for path, data in sorted(tree.items()):
            if data is None:
                (self.out / path).mkdir(parents=True, exist_ok=True)
            else:
                (self.out / path).write_bytes(data)

    def keep(self, name):
        to = self.root / "undisturbed" / name
        shutil.rmtree(to, ignore_errors=True)
        shutil.copytree(self.out, to)
        return to

    def summary(self):
        file = self.root / "summary.md"
        file.unlink(missing_ok=True)
        code, words, _ = self.bench.run(["report", self.out, "--markdown", file])
        return code, words, file.read_bytes() if file.is_file() else None


def scenarios(stand, wanted):
    """Name, template, what is put before, command, what comes next and which exit codes it may have."""
    first, forgotten = stand.names[0], [stand.names[0]]
    everything = {
        "first": (None, {}, "run", {}, [("run", (0,))]),
        "second": ("first", {"new": [first]}, "run", {"new": [first]}, [("run", (0,))]),
        # one that is out already cannot be named any more
        "forget": ("first", {}, "forget", {"without": forgotten}, [("forget", (0, 2)), ("run", (0,))]),
        "forget_run": ("first", {}, "forget", {}, [("run", (0,))]),
        "diagnose": ("first", {}, "diagnose", {}, [("diagnose", (0,))]),
    }
    return [(name, *everything[name]) for name in wanted]


def states(stand, trace, template, options, rng):
    """Every different state: tree, models and instants that lead to it."""
    disk = Disk(template)
    found, prefixes, told = {}, 0, Counter()

    def note(model, tree, instant):
        key = hashlib.blake2b(digest_size=16)
        for path, data in sorted(tree.items()):
            key.update(f"{path}\0{'' if data is None else hashlib.blake2b(data).hexdigest()}\0".encode())
        found.setdefault(key.digest(), (tree, [])) [1].append((model, instant))
        told[model] += 1

    last = "the beginning"
    for number, event in enumerate(events(trace, stand.out)):
        if number == 0:
            for model, tree in disk.cuts(rng, 0):
                note(model, tree, last)
        if not disk.do(event):
            continue
        prefixes += 1
        last = f"{prefixes}: {event[0]} {event[1]}" + (f" -> {event[2]}" if event[0] == "rename" else "")
        for model, tree in disk.cuts(rng, options.random):
            note(model, tree, last)
    now, (files, folders) = disk.now(), contents(stand.out)
    # the model is right: at the end it has what the disk has
    there = {p: common.plain(p, d) for p, d in now.items() if d is not None and p not in common.LOCKS}
    hashes = {p: hashlib.blake2b(d, digest_size=12).hexdigest() for p, d in there.items()}
    if hashes != files or {p for p, d in now.items() if d is None} != folders:
        sys.exit(f"the replayed output is not the recorded one: {differences((hashes, set()), (files, set()))[:5]}")
    safe = disk.tree([], lambda f: f.safe or b"")
    unsafe = sorted(p for p in now.keys() | safe.keys() if p not in common.LOCKS and (now.get(p) != safe.get(p) or (p in now) != (p in safe)))
    return list(found.values()), prefixes, unsafe


def test(stand, options):
    rng = random.Random(options.seed)
    total, bugs = Counter(), []
    templates = {}
    for name, template, before, command, after, nexts in scenarios(stand, options.nights.split(",")):
        if template and template not in templates:
            stand.use(None)
            stand.put()
            stand.must("run")
            templates[template] = stand.keep(template)
        base = templates.get(template)
        stand.use(base)
        stand.put(**before)
        texts = {}
        if base:
            texts[stand.summary()[2]] = "old"
        stand.use(base)
        trace = stand.root / f"{name}.strace"
        stand.record(command, trace)
        recorded = stand.keep(f"{name}_recorded")
        every, prefixes, unsafe = states(stand, trace, base, options, rng)
        # what an undisturbed sequence gives
        texts[stand.summary()[2]] = "new"
        stand.use(base)
        stand.put(**before)
        stand.must(command)
        told = differences(contents(stand.out), contents(recorded))
        if told:
            sys.exit(f"{name}: the same command does not give the same output: {told}")
        stand.put(**after)
        for other, _ in nexts:
            if other != command:
                stand.must(other)
        wanted = contents(stand.keep(f"{name}_wanted"))
        count = Counter({"instants": prefixes, "states": len(every)})
        if unsafe:
            print(f"{name}: when the command has ended, not safe from a power cut: {len(unsafe)}: {', '.join(unsafe[:12])}")
            count["paths that are not safe when the command has ended"] = len(unsafe)
        some = every if len(every) <= options.limit else sorted(rng.sample(range(len(every)), options.limit))
        some = [every[i] for i in some] if some is not every else every
        print(f"{name}: {prefixes} instants, {len(every)} states, {len(some)} of them are tried", flush=True)
        seen = Counter()

        def bug(what, told, where):
            count[what] += 1
            seen[what] += 1
            models = ", ".join(sorted({m for m, _ in where}))
            bugs.append(f"{name}: {what}: after {where[0][1]} ({models}): {told}")
            if seen[what] <= options.tell:
                print(bugs[-1], flush=True)

        for number, (tree, where) in enumerate(some):
            count["states tried"] += 1
            stand.put(**before)
            stand.put_tree(tree)
            bad = {os.path.relpath(p, stand.out): wrong for p in tables(stand.out) if (wrong := read(p))}
            count["unreadable tables"] += len(bad)
            code, words, _ = stand.bench.run(["verify", stand.out, "--no-logs"])
            named = [p for p in bad if p in words]
            if code not in (0, 1):
                bug("verify failed", f"{code}: {words.strip()[-300:]}", where)
            if len(named) < len(bad):
                bug("unreadable tables that verify does not name", str(sorted(bad.keys() - set(named))), where)
            damage = re.findall(r"^(changed|missing|unreadable|orphan|orphan_rows) +(\S+)", words, re.M)
            if damage:
                bug("states that verify calls damaged", f"{damage[:4]}", where)
            if options.reports and rng.random() < 0.5:
                code, words, summary = stand.summary()
                nothing = not any(tables(stand.out / "sessions"))
                if code and not nothing:
                    bug("reports that failed", f"{code}: {words.strip()[-300:]}", where)
                elif not code and summary not in texts and not nothing:
                    bug("reports of neither state", f"{hashlib.blake2b(summary).hexdigest()[:8]}", where)
                count["reports in between"] += 1
            stand.put(**after)
            for other, codes in nexts:
                code, words, _ = stand.bench.run(stand.command(other))
                if code not in codes:
                    bug("next commands that failed", f"{other} ended with {code}: {words.strip()[-300:]}", where)
                elif code:
                    count[f"next {other} ended with {code}"] += 1
            told = differences(contents(stand.out), wanted)
            if told:
                bug("outputs unequal", f"{len(told)}: {'; '.join(told[:4])}", where)
            left = temporaries(stand.out)
            if left:
                bug("temporaries left over", ", ".join(left[:4]), where)
            code, words, _ = stand.bench.run(["verify", stand.out])
            if code:
                bug("verify finds damage at the end", words.strip()[-300:], where)
            if (bad or told) and options.keep:
                stand.put_tree(tree)
                stand.keep(f"{name}_state_{number}")
            if (number + 1) % 100 == 0:
                print(f"... {number + 1} states of {name}", flush=True)
        for what, n in sorted(count.items()):
            print(f"{n:8} {name}: {what}")
        total.update(count)
    return total, bugs


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--roadbench", required=True, metavar="BIN")
    here = Path(__file__).resolve().parents[2] / "fixtures" / "archive"
    parser.add_argument("--archive", default=here, metavar="DIR", help="with sessions/ and bikes/; by default fixtures/archive")
    parser.add_argument("--nights", default="first,second,forget", help="of: first, second, forget, forget_run, diagnose")
    parser.add_argument("--limit", type=int, default=1000, help="states of a night that are tried, drawn by the seed")
    parser.add_argument("--random", type=int, default=3, help="random subsets of names at every instant")
    parser.add_argument("--reports", action="store_true", help="in half of the states a report comes before the next run")
    parser.add_argument("--signals", action="store_true", help="tables with a file per session, too")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--logs", type=int, default=3)
    parser.add_argument("--share", type=float, default=0.3, help="of each log's rows")
    parser.add_argument("--tell", type=int, default=5, help="findings of a kind that are printed as they come")
    parser.add_argument("--keep", action="store_true", help="keep states that gave findings in WORK/undisturbed")
    parser.add_argument("--work", help="folder for all that is written; by default a temporary one")
    parser.add_argument("--core", type=int, help="keep to this processor core")
    options = parser.parse_args()
    if not shutil.which("strace"):
        sys.exit("strace is not installed: without it nothing can be recorded")
    stand = Stand(options)
    begun = time.monotonic()
    total, bugs = test(stand, options)
    print(f"{stand.bench.run(['--version'])[1].strip()}, seed {options.seed}, {time.monotonic() - begun:.0f} s, all nights:")
    for what, n in sorted(total.items()):
        print(f"{n:8} {what}")
    print(f"{len(bugs)} findings")
    if not options.work and not bugs:
        shutil.rmtree(stand.root)
    sys.exit(bool(bugs))


if __name__ == "__main__":
    main()
