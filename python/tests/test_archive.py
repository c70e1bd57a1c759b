"""``run``, ``diagnose``, ``plan`` and ``export`` give what the command line gives."""

import json

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import roadbench
from conftest import ARCHIVE, files, roadbench as command

NULLS = 8


@pytest.fixture(scope="module")
def diagnosed(log, tmp_path_factory):
    """What the command line writes of one session's diagnosis."""
    out = tmp_path_factory.mktemp("diagnosed")
    command("diagnose", log, "--bikes", ARCHIVE / "bikes", "--out", out, "--nulls", NULLS)
    return out


def test_run_writes_what_the_command_writes(written, log, tmp_path):
    done = roadbench.run(log, tmp_path, bikes=ARCHIVE / "bikes", signals=True)
    assert (done["inputs"], done["computed"], done["rejected"]) == (1, 1, 0)
    assert files(tmp_path) == files(written)
    assert json.loads((tmp_path / "run.json").read_text())["computed"] == 1


def test_diagnose_writes_what_the_command_writes(diagnosed, log, tmp_path):
    done = roadbench.diagnose([log], tmp_path, bikes=ARCHIVE / "bikes", nulls=NULLS)
    assert (done["inputs"], done["computed"]) == (1, 1)
    assert files(tmp_path) == files(diagnosed)


def test_a_diagnosed_session_is_read(diagnosed, log):
    session = roadbench.read(diagnosed, frames="arrow").session(log.stem)
    assert "causes" in session and session["causes"].num_rows > 0 and "sessions" not in session
    assert "no coefficients" in session._repr_html_() and [s.id for s in roadbench.read(diagnosed).sessions()] == [log.stem]
    with pytest.raises(roadbench.NoTable, match="no table `sessions`; there are .*causes"):
        session.info  # noqa: B018


def test_a_session_in_memory_is_diagnosed_as_on_disk(diagnosed, log, bike):
    found = roadbench.diagnose_session(log, bike, nulls=NULLS)
    assert set(found.tables) == {
        "causes",
        "discrepancies",
        "replays",
        "simulation_errors",
        "estimates",
        "effect_traces",
        "diagnoses",
    }
    for name, table in found.tables.items():
        [path] = (diagnosed / name).rglob("bike=[!_]*/*.parquet")
        assert pa.table(table).equals(pq.read_table(path, partitioning=None)), name
    assert log.stem in found.summary
    [model] = (diagnosed / "models").rglob("*.toml")
    assert found.model == model.read_text()


def test_what_a_diagnosis_identified_is_removed_as_on_the_command_line(diagnosed, log, tmp_path):
    (here, there) = (tmp_path / "here", tmp_path / "there")
    roadbench.run(log, here, bikes=ARCHIVE / "bikes", model=diagnosed)
    command("run", log, "--bikes", ARCHIVE / "bikes", "--out", there, "--model", diagnosed)
    assert files(here) == files(there)
    with pytest.raises(ValueError):
        roadbench.run(log, tmp_path / "none", bikes=ARCHIVE / "bikes", model=tmp_path / "none")


def test_too_few_nulls_are_refused(log, bike, tmp_path):
    with pytest.raises(ValueError, match="give 8 to 1000"):
        roadbench.diagnose_session(log, bike, nulls=2)
    with pytest.raises(ValueError, match="give 8 to 1000"):
        roadbench.diagnose(log, tmp_path / "out", bikes=ARCHIVE / "bikes", nulls=2)
    assert not (tmp_path / "out").exists()


def test_plan_is_that_of_the_command():
    plan = roadbench.plan("perfect")
    lines = [json.loads(line) for line in command("plan", "perfect", "--json").splitlines()]
    assert len(plan["side_forces"]) == 6
    assert lines == plan["side_forces"] + plan["effects"] + plan["pairs"]
    assert plan["duration"] > 60
    with pytest.raises(ValueError, match="no_such_ride"):
        roadbench.plan("no_such_ride")


def test_compare_is_that_of_the_command(tmp_path):
    logs = sorted((ARCHIVE / "sessions" / "bike=archive_01").rglob("*.parquet"))[:2]
    out = tmp_path / "out"
    roadbench.run(logs, out, bikes=ARCHIVE / "bikes")
    table = pa.table(roadbench.compare(out, logs[0].stem, "others"))
    lines = command("compare", out, logs[0].stem, "others", "--json").splitlines()
    assert table.num_rows == len(lines) > 20
    assert [json.loads(line)["verdict"] for line in lines] == table["verdict"].to_pylist()
    with pytest.raises(ValueError, match="did you mean"):
        roadbench.compare(out, "s0001", "others")


def test_export_is_that_of_the_command(written, log):
    arguments = ["export", written, "--session", log.stem, "--format", "tir", "--tyre", "front"]
    text = roadbench.export(written, log.stem, "tir", tyre="front", bikes=ARCHIVE / "bikes")
    assert text == command(*arguments, "--bikes", ARCHIVE / "bikes")
    with pytest.raises(ValueError, match="--tyre front"):
        roadbench.export(written, log.stem, "tir")
    with pytest.raises(ValueError, match="none of tir"):
        roadbench.export(written, log.stem, "tyre")
