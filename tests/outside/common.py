"""What kills.py and power_cut.py share: small logs, commands, and what a folder holds."""

import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

try:
    import pyarrow.parquet as pq
except ImportError:
    sys.exit("pyarrow is needed (python3 -m venv, pip install pyarrow)")

# Held open, never read for their bytes.
LOCKS = {".roadbench.lock", ".roadbench/tables.lock"}


def small_logs(archive, to, count, share):
    """The smallest logs of an archive, cut to a share of their rows, of every motorcycle at least one."""
    logs = sorted(Path(archive).glob("sessions/**/*.parquet"), key=lambda p: (p.stat().st_size, p.name))
    by_bike = {}
    for log in logs:
        by_bike.setdefault(next((p for p in log.parts if p.startswith("bike=")), ""), []).append(log)
    # in turn, so that small numbers have every motorcycle
    turns = [some[i] for i in range(len(logs)) for _, some in sorted(by_bike.items()) if i < len(some)]
    taken = sorted(turns[:count], key=lambda p: p.name)
    if len(taken) < count:
        sys.exit(f"{archive}: only {len(taken)} logs below sessions/")
    to.mkdir(parents=True, exist_ok=True)
    for log in taken:
        file = pq.ParquetFile(log)
        about = {k: v for k, v in (file.metadata.metadata or {}).items() if k != b"ARROW:schema"}
        table = file.read().replace_schema_metadata(about)
        pq.write_table(table.slice(0, int(table.num_rows * share)), to / log.name)
    return [log.stem for log in taken]


def put_logs(versions, logs):
    """Puts versions of logs (name: folder) under the same paths, each whole; others go."""
    logs.mkdir(parents=True, exist_ok=True)
    for name, folder in versions.items():
        temporary = logs.parent / f"{name}.next"
        shutil.copyfile(folder / f"{name}.parquet", temporary)
        os.replace(temporary, logs / f"{name}.parquet")
    for there in logs.glob("*.parquet"):
        if there.stem not in versions:
            there.unlink()


class Bench:
    """The program under test, and where its temporaries go."""

    def __init__(self, binary, temporary, core):
        self.binary = str(Path(binary).resolve())
        self.token = f"outside-{os.getpid()}-{time.time_ns()}"
        temporary.mkdir(parents=True, exist_ok=True)
        self.temporary = temporary
        self.environment = {**os.environ, "TMPDIR": str(temporary), "ROADBENCH_OUTSIDE": self.token}
        if core is not None and hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, {core})

    def start(self, arguments, before=()):
        return subprocess.Popen(
            [*before, self.binary, *map(str, arguments)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=self.environment,
            start_new_session=True,
        )

    def run(self, arguments, before=(), timeout=300):
        """Exit code, words and seconds; the code is "hangs" after the timeout."""
        begun = time.monotonic()
        process = self.start(arguments, before)
        try:
            words = process.communicate(timeout=timeout)[0].decode(errors="replace")
            code = process.returncode
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            words, code = process.communicate()[0].decode(errors="replace"), "hangs"
        return code, words, time.monotonic() - begun

    def processes(self):
        """Of this bench: those that run still (Linux)."""
        mark, own = f"ROADBENCH_OUTSIDE={self.token}".encode(), []
        for entry in Path("/proc").glob("[0-9]*"):
            try:
                if mark in (entry / "environ").read_bytes():
                    if " Z " not in (entry / "stat").read_text(errors="replace"):
                        own.append(int(entry.name))
            except OSError:
                pass
        return own


def plain(path, data):
    """Bytes without what is another at every run: instants, durations, and how many were there already."""
    if path.endswith("run.json"):
        try:
            about = json.loads(data)
        except ValueError:
            return data
        for key in ("started", "seconds", "computed", "unchanged"):
            about.pop(key, None)
        return json.dumps(about, sort_keys=True).encode()
    if path.endswith(".prom"):
        changing = rb'roadbench_(run_seconds|run_start_time_seconds|sessions\{state="(computed|unchanged)"\}) '
        return b"\n".join(line for line in data.splitlines() if not re.match(changing, line))
    return data


def contents(folder):
    """Every file below a folder with the hash of its bytes, and every folder."""
    files, folders = {}, set()
    for at, inner, names in os.walk(folder):
        below = os.path.relpath(at, folder)
        below = "" if below == "." else below + "/"
        folders.update(below + name for name in inner)
        for name in names:
            path = below + name
            if path in LOCKS or path.removeprefix("out/") in LOCKS:
                continue
            data = Path(at, name).read_bytes()
            files[path] = hashlib.blake2b(plain(path, data), digest_size=12).hexdigest()
    return files, folders


def differences(now, wanted):
    """In words, of two results of `contents`."""
    now, wanted = now[0], wanted[0]
    told = [f"lacks {p}" for p in sorted(wanted.keys() - now.keys())]
    told += [f"has too many {p}" for p in sorted(now.keys() - wanted.keys())]
    return told + [f"other bytes {p}" for p in sorted(now.keys() & wanted.keys()) if now[p] != wanted[p]]


def is_temporary(name):
    return (name.startswith(".roadbench-") and name.endswith(".tmp")) or name.startswith("roadbench-copy-")


def temporaries(folder):
    """What is half-written below a folder, or was to be put in place."""
    found = []
    for at, inner, names in os.walk(folder):
        found += [os.path.relpath(os.path.join(at, n), folder) for n in inner + names if is_temporary(n)]
        if os.path.basename(at) == ".roadbench":
            found += [os.path.relpath(os.path.join(at, n), folder) for n in inner + names if n.startswith("next")]
            staged = [p for p in Path(at, "staged").rglob("*") if p.is_file()]
            found += [os.path.relpath(p, folder) for p in staged]
    return found


def tables(out):
    """The tables of an output, as a reader sees them."""
    for at, inner, names in os.walk(out):
        inner[:] = sorted(i for i in inner if not i.startswith("."))
        for name in sorted(names):
            if name.endswith(".parquet") and not name.startswith("."):
                yield os.path.join(at, name)


def read(path):
    """None where a table is read, else what is wrong: it is missing, or cannot be read."""
    try:
        with open(path, "rb") as file:
            pq.ParquetFile(file).read()
    except FileNotFoundError:
        return "missing"
    except Exception as e:  # whatever pyarrow says
        return f"unreadable: {e}"
    return None
