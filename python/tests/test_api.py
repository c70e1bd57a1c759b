"""What calls look like: arguments by name and in one order, typed results, one parent of all errors."""

import inspect
import shutil
import subprocess
import sys
import typing

import pytest

import roadbench
import roadbench.spark as on_spark
from conftest import ARCHIVE, ROOT, files
from roadbench import _roadbench, _types

ORDER = (
    "tyre", "bike", "bikes", "pipeline", "maps", "dbc", "jobs", "batch", "force", "since", "signals", "nulls", "advise",
    "set", "friction", "load", "model", "session_id", "progress",
)  # fmt: skip
BATCHES = (roadbench.run, roadbench.diagnose, on_spark.run, on_spark.diagnose)
ACTED_ON = {
    "run": ["inputs", "out"],
    "diagnose": ["inputs", "out"],
    "run_session": ["log", "bike"],
    "diagnose_session": ["log", "bike"],
    "read": ["out", "table"],
    "plot": ["source", "session"],
    "chart": ["source", "session"],
    "export": ["out", "session", "format"],
    "compare": ["out", "a", "b"],
    "plan": ["scenario"],
    "simulate": ["scenario"],
    "schema": ["name"],
    "inspect": ["log"],
    "map": ["log"],
    "bike_new": ["name"],
    "report": ["out"],
    "verify": ["out"],
    "forget": ["out"],
}


def names(function, kind):
    return [p.name for p in inspect.signature(function).parameters.values() if p.kind is kind]


def test_what_is_acted_on_goes_by_position_and_all_else_by_name():
    functions = {n: getattr(roadbench, n) for n in roadbench.__all__ if inspect.isfunction(getattr(roadbench, n))}
    assert {n: names(f, inspect.Parameter.POSITIONAL_OR_KEYWORD) for n, f in functions.items()} == ACTED_ON


@pytest.mark.parametrize("function", [*BATCHES, roadbench.run_session, roadbench.diagnose_session, roadbench.inspect, roadbench.export])
def test_one_order(function):
    given = names(function, inspect.Parameter.KEYWORD_ONLY)
    assert given == [name for name in ORDER if name in given], function


@pytest.mark.parametrize(("here", "there"), [BATCHES[::2], BATCHES[1::2]])
def test_on_spark_as_on_one_machine(here, there):
    ours, theirs = (list(inspect.signature(f).parameters.values()) for f in (here, there))
    assert theirs[0].name == "spark"
    by_name = {p.name: p for p in theirs}
    assert [p.name for p in ours if p.name != "progress"] == [n.replace("batch", "jobs") for n in list(by_name)[1:]]
    for p in ours:
        if p.name not in ("jobs", "progress"):
            assert (p.kind, p.default) == (by_name[p.name].kind, by_name[p.name].default), p.name


def fits(value, kind, where="result"):
    """Fails where a value is not of a type of ours, keys and all."""
    if typing.is_typeddict(kind):
        hints = typing.get_type_hints(kind)
        assert kind.__required_keys__ <= value.keys() <= hints.keys(), (where, kind.__required_keys__ ^ value.keys())
        for key, each in value.items():
            fits(each, hints[key], f"{where}.{key}")
    elif (origin := typing.get_origin(kind)) is typing.NotRequired:
        fits(value, typing.get_args(kind)[0], where)
    elif origin is list:
        assert isinstance(value, list), where
        for each in value:
            fits(each, typing.get_args(kind)[0], where)
    elif origin is dict:
        assert isinstance(value, dict), where
    elif origin is typing.Literal:
        assert value in typing.get_args(kind), (where, value)
    elif origin is not None:  # something or nothing
        [inner] = [one for one in typing.get_args(kind) if one is not type(None)]
        if value is not None:
            fits(value, inner, where)
    else:
        assert isinstance(value, kind) or (kind is float and isinstance(value, int)), (where, value)


def test_results_are_of_their_types(written, log, tmp_path):
    done = roadbench.run(log, tmp_path, bikes=ARCHIVE / "bikes")
    fits(done, _types.Summary)
    with pytest.raises(AssertionError):
        fits(done | {"more": 1}, _types.Summary)
    with pytest.raises(AssertionError):
        fits(done | {"computed": "1"}, _types.Summary)
    fits(roadbench.inspect(log, bikes=ARCHIVE / "bikes"), _types.Inspected)
    fits(roadbench.inspect(log), _types.Inspected)
    fits(roadbench.plan("perfect"), _types.Planned)


def test_a_log_that_no_map_fits_is_inspected_by_its_own_channels(tmp_path):
    rows = "\n".join(f"{t / 10},{t},{t % 7}" for t in range(200))
    (tmp_path / "odd.csv").write_text(f"zeit,tempo,dings\n{rows}\n")
    found = roadbench.inspect(tmp_path / "odd.csv")
    fits(found, _types.InspectedSource)
    assert [c["name"] for c in found["channels"]][-2:] == ["tempo", "dings"]


def test_what_is_refused_is_an_error_of_ours_and_of_python(written, log, bike, tmp_path):
    refused = [
        (ValueError, lambda: roadbench.run_session(log, tmp_path / "none.toml")),
        (TypeError, lambda: roadbench.run_session(7, bike)),
        (ValueError, lambda: roadbench.diagnose_session(log, bike, nulls=2)),
        (ValueError, lambda: roadbench.run(tmp_path, tmp_path / "out", bikes=ARCHIVE / "bikes")),
        (OSError, lambda: roadbench.run(log, ROOT / "README.md", bikes=ARCHIVE / "bikes")),
        (ValueError, lambda: roadbench.plan("no such")),
        (ValueError, lambda: roadbench.simulate("perfect", number=10**6)),
        (ValueError, lambda: roadbench.schema("no such")),
        (ValueError, lambda: roadbench.compare(written, "nobody", "others")),
        (ValueError, lambda: roadbench.export(written, "nobody", "toml")),
        (ValueError, lambda: roadbench.read(written, frames="spark")),
        (FileNotFoundError, lambda: roadbench.read(tmp_path / "none", "sessions")),
        (KeyError, lambda: roadbench.read(written, "no such")),
        (ValueError, lambda: roadbench.plot(written, "nobody")),
        (ValueError, lambda: roadbench.verify(tmp_path / "none")),
        (ValueError, lambda: on_spark.run(None, log, tmp_path / "out", batch=0)),
        (ValueError, lambda: on_spark.run(None, tmp_path, tmp_path / "out", bikes=ARCHIVE / "bikes")),
    ]
    for kind, call in refused:
        with pytest.raises(roadbench.Error) as why:
            call()
        assert isinstance(why.value, kind) and len(str(why.value)) > 10, why.value
    every = [getattr(roadbench, name) for name in roadbench.__all__]
    ours = [one for one in every if inspect.isclass(one) and issubclass(one, BaseException)]
    assert len(ours) == 9 and all(issubclass(one, roadbench.Error) for one in ours)


def test_on_a_cluster_what_was_identified_is_removed_too(log, bike, tmp_path, monkeypatch):
    """Without Spark: its tasks one after the other in this process."""
    model = tmp_path / "model.toml"
    found = roadbench.diagnose_session(log, bike, nulls=8)
    model.write_text(found.model)

    def alone(spark, terms, tasks, batch):
        worker = _roadbench.Worker(terms)
        return [worker.run(task) for _, task in tasks]

    monkeypatch.setattr(on_spark, "_distribute", alone)
    done = on_spark.run(None, log, tmp_path / "there", bikes=ARCHIVE / "bikes", model=model)
    roadbench.run(log, tmp_path / "here", bikes=ARCHIVE / "bikes", model=model)
    assert done["computed"] == 1 and files(tmp_path / "there") == files(tmp_path / "here")
    roadbench.run(log, tmp_path / "without", bikes=ARCHIVE / "bikes")
    assert files(tmp_path / "without") != files(tmp_path / "here")


TYPED = """
import roadbench
def f() -> None:
    session = roadbench.run_session("a", bike="b")
    text: str = session.export("tir", tyre="front")
    data: bytes = session.export("fmu", tyre="front")
    number: int = roadbench.run("a", "b")["computed"]
    limit: float | None = roadbench.plan("a")["effects"][0]["limit"]
    tables: roadbench.Tables = roadbench.read("a", lazy=True, sessions="s")
    one: roadbench.Session = tables.session("s")
"""
WRONG = """
import roadbench
def f() -> None:
    roadbench.run("a", "b", "c")
    roadbench.run("a", "b")["computd"]
    roadbench.export("a", "s", "tyre")
    text: str = roadbench.export("a", "s", "fmu", tyre="rear", bikes="b")
    roadbench.bike_new("a", clas="naked")
"""


def test_types_hold(tmp_path):
    pytest.importorskip("mypy")
    for name, text in (("typed", TYPED), ("wrong", WRONG)):
        (tmp_path / f"{name}.py").write_text(text)
    # by itself: beside it in site-packages lies what mypy would take for the standard library's
    shutil.copytree(roadbench.__path__[0], tmp_path / "roadbench", ignore=shutil.ignore_patterns("*.so", "*.pyd"))
    command = [sys.executable, "-m", "mypy", "--strict", "--disable-error-code", "import-untyped", "--cache-dir", tmp_path / "cache"]

    def mypy(*what):
        return subprocess.run([*command, *what], capture_output=True, text=True, cwd=tmp_path, check=False)

    whole = mypy("-p", "roadbench", "-m", "typed")
    assert whole.returncode == 0, whole.stdout
    wrong = mypy("-m", "wrong").stdout
    for line in (4, 5, 6, 7, 8):
        assert f"wrong.py:{line}: error" in wrong, wrong
