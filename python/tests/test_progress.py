"""``progress``: the same run, the same result and the same errors, and a word after each log."""

import io
import json
import os
import shutil
import signal
import subprocess
import sys
import types

import pytest

import roadbench
from conftest import ARCHIVE, ROOT, files
from roadbench import _progress

BIKES = ARCHIVE / "bikes"
TIMES = {"started", "seconds"}


@pytest.fixture
def logs(tmp_path, log):
    """Two sessions, and a file that is none."""
    bad = tmp_path / "bad.log"
    bad.write_text("no ride at all")
    return [log, log.parent.parent / "date=2026-05-02" / "archive_s0003.parquet", bad]


def test_a_run_that_is_watched_is_the_same_run(logs, tmp_path):
    heard = []
    watched = roadbench.run(logs, tmp_path / "a", bikes=BIKES, progress=heard.append, jobs=1)
    alone = roadbench.run(logs, tmp_path / "b", bikes=BIKES, progress=False, jobs=1)
    assert files(tmp_path / "a") == files(tmp_path / "b")
    assert {k: v for k, v in watched.items() if k not in TIMES} == {k: v for k, v in alone.items() if k not in TIMES}
    assert watched == json.loads((tmp_path / "a" / "run.json").read_text())
    assert watched["rejected_by_code"] == {"no_channel_map": 1}
    assert [(p.done, p.total) for p in heard] == [(1, 3), (2, 3), (3, 3)]
    assert {p.session: p.status for p in heard} == {"": "rejected", "archive_s0001": "done", "archive_s0003": "done"}
    assert {p.log for p in heard} == {str(log) for log in logs}
    heard.clear()
    again = roadbench.run(logs, tmp_path / "a", bikes=BIKES, progress=heard.append)
    assert (again["computed"], again["unchanged"], again["rejected"]) == (0, 2, 1)
    assert sorted(p.status for p in heard) == ["rejected", "unchanged", "unchanged"]


def test_every_option_reaches_it(log, bike, tmp_path, monkeypatch):
    monkeypatch.setenv("ROADBENCH_BIKES", str(tmp_path / "nowhere"))  # of the command line, not of the function
    for file, folder in ((log, "sessions"), (bike, "bikes")):
        (tmp_path / "archive" / folder).mkdir(parents=True)
        shutil.copy2(file, tmp_path / "archive" / folder)
    moment = log.stat().st_mtime
    options = {"pipeline": "paper", "signals": True, "force": True, "jobs": 1, "progress": print}
    done = roadbench.run(tmp_path / "archive", tmp_path / "out", since=moment - 10, **options)
    assert done["computed"] == 1 and done["pipeline"]["name"] == "paper"
    assert next((tmp_path / "out" / "signals").rglob("archive_s0001.parquet"))
    again = roadbench.run(tmp_path / "archive", tmp_path / "out", **options)
    assert (again["computed"], again["unchanged"]) == (1, 0)  # by `force`
    none = roadbench.run(tmp_path / "archive", tmp_path / "out", since=moment + 10, **options)
    alone = roadbench.run(tmp_path / "archive", tmp_path / "out", since=moment + 10, **options | {"progress": False})
    assert (none["inputs"], none["computed"]) == (alone["inputs"], alone["computed"]) == (0, 0)


def test_a_diagnosis_is_watched_too(log, tmp_path):
    heard = []
    watched = roadbench.diagnose(log, tmp_path / "a", bikes=BIKES, nulls=8, progress=heard.append)
    alone = roadbench.diagnose(log, tmp_path / "b", bikes=BIKES, nulls=8)
    assert files(tmp_path / "a") == files(tmp_path / "b")
    left_out = TIMES | {"pipeline", "pipeline_hash"}
    assert {k: v for k, v in watched.items() if k not in TIMES} == {k: v for k, v in alone.items() if k not in left_out}
    assert [(p.done, p.total, p.session, p.status) for p in heard] == [(1, 1, "archive_s0001", "done")]


@pytest.mark.parametrize(
    ("call", "how", "kind", "words"),
    [
        (roadbench.run, {"pipeline": "onraod"}, ValueError, "onroad, paper, offroad"),
        (roadbench.run, {"inputs": BIKES}, ValueError, "holds no logs"),
        (roadbench.run, {"out": ROOT / "README.md"}, roadbench.Error, "README.md"),
        (roadbench.run, {"since": float("nan")}, ValueError, "since"),
        (roadbench.diagnose, {"nulls": 2}, ValueError, "8"),
    ],
)
@pytest.mark.parametrize("progress", [False, print])
def test_the_same_errors(log, tmp_path, call, how, kind, words, progress):
    given = {"inputs": log, "out": tmp_path / "out", "bikes": BIKES} | how
    with pytest.raises(roadbench.Error, match=words) as why:
        call(**given, progress=progress)
    assert isinstance(why.value, kind) and not str(why.value).startswith("{")


def test_an_error_of_the_listener_ends_the_run(logs, tmp_path):
    def listener(progress):
        raise LookupError(progress.log)

    with pytest.raises(LookupError):
        roadbench.run(logs, tmp_path / "a", bikes=BIKES, progress=listener)
    # nothing is left half: the same call carries on
    assert roadbench.run(logs, tmp_path / "a", bikes=BIKES)["rejected"] == 1


SCRIPT = """
import roadbench, sys
try:
    roadbench.run(sys.argv[1], sys.argv[2], jobs=1, progress=lambda p: print(p.done, p.total, flush=True))
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


def test_a_run_with_a_bar(logs, tmp_path, capfd):
    done = roadbench.run(logs, tmp_path / "a", bikes=BIKES, progress=True)
    pictures = capfd.readouterr().err.split("\r")
    assert done["computed"] == 2 and pictures[-1].startswith(f"[{'=' * 30}] 3 of 3 logs, 1 rejected in ")
    assert pictures[-1].endswith("\n") and "{" not in "".join(pictures)


@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of Unix")
def test_ctrl_c_finishes_the_sessions_under_way(tmp_path):
    command = [sys.executable, "-c", SCRIPT, str(ARCHIVE), str(tmp_path / "out")]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=os.environ)
    assert child.stdout.readline() == "1 12\n"
    child.send_signal(signal.SIGINT)
    heard = child.stdout.read().splitlines()
    assert child.wait(60) == 0 and heard[-1] == "interrupted" and len(heard) < 11
    done = roadbench.run(ARCHIVE, tmp_path / "out")
    assert done["unchanged"] >= 1 and done["unchanged"] + done["computed"] == 12


def steps(bar, *statuses):
    for number, status in enumerate(statuses, 1):
        bar(roadbench.Progress(number, len(statuses), f"s{number}", f"s{number}.csv", status))
    bar.end()


def test_a_bar_at_a_terminal(monkeypatch):
    stderr = io.StringIO()
    monkeypatch.setattr("sys.stderr", stderr)
    steps(_progress.listener(True), "done", "rejected", "done", "unchanged")
    pictures = stderr.getvalue().split("\r")[1:]
    assert pictures[0].startswith("[=======                       ] 1 of 4 logs, ")
    # those in between come too fast for anybody to see
    assert len(pictures) == 3 and pictures[1].startswith(f"[{'=' * 30}] 4 of 4 logs, 1 rejected; tables of the fleet")
    assert pictures[2].startswith(f"[{'=' * 30}] 4 of 4 logs, 1 rejected in 0.0 s ") and pictures[2].endswith("\n")
    assert not pictures[1].endswith("\n")
    # one log needs none
    stderr.seek(0)
    stderr.truncate()
    steps(_progress.listener(True), "done")
    assert stderr.getvalue() == ""


def notebook(monkeypatch):
    """As in a kernel of Jupyter; what is shown there."""
    shown = []
    handle = types.SimpleNamespace(update=shown.append)
    display = types.ModuleType("IPython.display")
    display.HTML = str
    display.display = lambda html, display_id: handle
    module = types.ModuleType("IPython")
    module.get_ipython = lambda: types.SimpleNamespace(kernel=object())
    module.display = display
    monkeypatch.setitem(sys.modules, "IPython", module)
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    return shown


def test_a_bar_in_a_notebook_comes_by_itself(monkeypatch):
    assert _progress.listener(None) is None  # here there is no kernel
    shown = notebook(monkeypatch)
    steps(_progress.listener(None), "done", "done", "done")
    assert len(shown) == 3 and '<progress max="3" value="3"></progress> 3 of 3 logs in ' in shown[-1]
    assert _progress.listener(False) is None
