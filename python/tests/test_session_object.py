"""A ``Session``: the same of ``run_session`` and of ``read``, and its numbers those that pyarrow reads from the files."""

import re

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest

import roadbench
from conftest import ARCHIVE, on_disk
from conftest import roadbench as command
from roadbench import _html

BIKES = ARCHIVE / "bikes"


@pytest.fixture(scope="module")
def memory(log, bike):
    return roadbench.run_session(log, bike)


@pytest.fixture(scope="module")
def disk(fleet, log):
    return roadbench.read(fleet).session(log.stem)


@pytest.fixture(params=["memory", "disk"])
def session(request):
    return request.getfixturevalue(request.param)


def of_session(out, name, session):
    table = on_disk(out, name)
    return table.filter(pc.equal(table["session_id"], session))


def test_what_it_is(session, fleet, log):
    theirs = of_session(fleet, "sessions", log.stem).to_pylist()[0]
    assert (session.id, session.bike) == (log.stem, "archive_01") == (theirs["session_id"], theirs["bike_id"])
    own = {key: session.info[key] for key in ("duration", "distance", "n_used", "n_manoeuvres", "tyre_front", "input_hash")}
    assert own == {key: theirs[key] for key in own}
    assert session.units["sessions"]["duration"] == "s" and "session_id" not in session.units["sessions"]


def test_its_tables(session, fleet, log):
    assert {"coefficients", "manoeuvres", "warnings", "plots", "sessions"} <= set(session) and len(session) == len(list(session))
    for name in ("coefficients", "manoeuvres", "warnings"):
        theirs = of_session(fleet, name, log.stem).drop_columns(["start_time"])
        ours = pa.table(getattr(session, name)).drop_columns(["start_time"])
        assert ours.to_pylist() == theirs.to_pylist() and theirs.num_rows > 0, name
        assert session.frame(name, "arrow").num_rows == len(session.frame(name, "pandas")) == theirs.num_rows
    # tables over the whole fleet are not a session's
    assert "tyres" not in session and session.get("tyres") is None
    with pytest.raises(roadbench.NoTable, match="no table `tyres`; there are .*coefficients"):
        session["tyres"]
    with pytest.raises(KeyError):
        session["coeficients"]


def test_in_memory_tables_are_those_of_the_compiled_part(memory):
    assert isinstance(memory["coefficients"], roadbench.Table)
    pl = pytest.importorskip("polars")
    assert isinstance(memory.coefficients, pl.DataFrame)


@pytest.mark.parametrize("frames", ["polars", "pandas", "arrow"])
def test_on_disk_tables_are_the_frames_of_read(fleet, log, frames):
    pytest.importorskip({"arrow": "pyarrow"}.get(frames, frames))
    session = roadbench.read(fleet, frames=frames).session(log.stem)
    assert type(session["coefficients"]) is type(session.coefficients) is type(roadbench.read(fleet, "tyres", frames=frames))
    assert session["coefficients"].shape[0] == 39
    assert "21 of 39 coefficients ok" in repr(session) and "2026-05-01 09:00 UTC" in session._repr_html_()


def test_lazy_tables_of_a_session(fleet, log):
    pl = pytest.importorskip("polars")
    session = roadbench.read(fleet, lazy=True).session(log.stem)
    assert isinstance(session.coefficients, pl.LazyFrame)
    assert session.frame("coefficients", "polars").height == 39 and "21 of 39" in repr(session)


def test_a_notebook_is_told_the_answer_first(session, fleet, log):
    rows = of_session(fleet, "coefficients", log.stem).to_pylist()
    ok = [row for row in rows if row["status"] == "ok"]
    html = session._repr_html_()
    first, table, rest = html.partition("<table>")
    assert f"{len(ok)} of {len(rows)} coefficients ok, 1 warning" in first and "91 of 194 manoeuvres used" in first and table
    answer, _, more = rest.partition("</table>")
    assert answer.count("<tr>") == 1 + len(ok)
    # values and intervals, to the digits that are shown
    cells = [re.findall("<td>(.*?)</td>", row) for row in answer.split("<tr>")[2:]]
    by_key = {(row["tyre"], row["coefficient"]): row for row in ok}
    for tyre, coefficient, symbol, value, between, unit in cells:
        row = by_key.pop((tyre, coefficient))
        low, high = between.split(" to ")
        half = (row["ci95_high"] - row["ci95_low"]) / 2
        for text, number in ((value, row["value"]), (low, row["ci95_low"]), (high, row["ci95_high"])):
            assert abs(float(text) - number) <= 0.05 * half, (coefficient, text)
        assert (symbol, unit) == (row["symbol"], "" if row["unit"] == "1" else row["unit"])
    assert not by_key
    for status, words in (("poorly_determined", "poorly determined"), ("assumed", "assumed")):
        assert f"<summary>{sum(row['status'] == status for row in rows)} {words}" in more
    assert "<script" not in html and "http" not in html


def test_what_a_log_says_is_no_markup(memory):
    row = memory.frame("coefficients", "arrow").to_pylist()[0] | {"status": "ok", "coefficient": "<b>&"}
    fake = {"coefficients": pa.Table.from_pylist([row]), "sessions": memory["sessions"]}
    html = _html.session(roadbench.Session(fake, "<i>", "b"))
    assert "&lt;b&gt;&amp;" in html and "<i>" not in html and "1 of 1 coefficients ok" in html


@pytest.mark.parametrize(
    ("value", "low", "high", "text"),
    [(0.290137, 0.289872, 0.290401, "0.29014"), (8.872, 6.4, 13.9, "8.9"), (1234.5, 1000.0, 1500.0, "1234"), (0.5, None, None, "0.5")],
)
def test_digits_are_those_that_the_interval_leaves(value, low, high, text):
    assert _html.number(value, low, high) == text


def test_it_is_drawn(session):
    pytest.importorskip("matplotlib")
    figure = session.plot(["slip_angle_front", "timeline"])
    assert [ax.get_title() for ax in figure.axes if ax.get_title()][0] == "Front · slip angle"
    with pytest.raises(roadbench.Invalid, match="no plot `friction`"):
        session.plot("friction")


@pytest.mark.parametrize("format", ["tir", "toml", "c", "simulator", "fmu"])
def test_it_is_exported_as_on_the_command_line(memory, disk, fleet, log, format, tmp_path):
    file = tmp_path / "tyre"
    arguments = ["export", fleet, "--session", log.stem, "--format", format, "--tyre", "rear"]
    command(*arguments, "--bikes", BIKES, "--out", file)
    theirs = file.read_bytes()
    for ours in (memory.export(format, tyre="rear"), disk.export(format, tyre="rear", bikes=BIKES)):
        assert (ours if format == "fmu" else ours.encode()) == theirs
    assert type(ours) is (bytes if format == "fmu" else str)


def test_export_says_what_it_needs(disk, memory, bike):
    with pytest.raises(roadbench.Invalid, match="--bikes FOLDER"):
        disk.export("c")
    with pytest.raises(roadbench.Invalid, match="--tyre front"):
        memory.export("tir")
    # of the text of a bike file, too
    table = pq.read_table(sorted((ARCHIVE / "sessions").rglob("*.parquet"))[0], partitioning=None)
    named = roadbench.run_session(table, bike.read_text(), session_id="a b")
    assert "a b" in named.export("tir", tyre="front")


def test_all_sessions_in_order_of_their_start(fleet):
    theirs = on_disk(fleet, "sessions").sort_by("start_time")["session_id"].to_pylist()
    tables = roadbench.read(fleet)
    assert [session.id for session in tables.sessions()] == theirs and len(theirs) == 12
    of_bike = roadbench.read(fleet, bike="archive_02", frames="arrow").sessions()
    assert {session.bike for session in of_bike} == {"archive_02"} and len(of_bike) == 6
    assert sum(session.coefficients.num_rows for session in of_bike) == 6 * 39


def test_which_session(fleet):
    tables = roadbench.read(fleet, bike="archive_01")
    with pytest.raises(roadbench.Invalid, match="no session `s0002` of archive_01; did you mean `archive_s0002`"):
        tables.session("s0002")
    with pytest.raises(roadbench.Invalid, match="no session `archive_s0012` of archive_01"):
        tables.session("archive_s0012")


def test_two_motorcycles_with_a_session_of_one_name(tmp_path):
    schema = pa.schema([field.with_nullable(True) for field in pa.schema(roadbench.schema("sessions"))])
    for number, bike in enumerate(("b1", "b2")):
        folder = tmp_path / "sessions" / f"bike={bike}"
        folder.mkdir(parents=True)
        row = {name: None for name in schema.names} | {"session_id": "one", "bike_id": bike, "n_used": number}
        pq.write_table(pa.Table.from_pylist([row], schema), folder / "undated.parquet")
    tables = roadbench.read(tmp_path)
    with pytest.raises(roadbench.Invalid, match="b1 and b2 have a session `one` each; say which with bike='b1'"):
        tables.session("one")
    assert tables.session("one", bike="b2").info["n_used"] == 1
    assert [(s.id, s.bike) for s in tables.sessions()] == [("one", "b1"), ("one", "b2")]


def test_in_a_with_block_a_session_reads_the_same_state(fleet, log, tmp_path):
    fcntl = pytest.importorskip("fcntl")
    import shutil
    import time

    out = tmp_path / "out"
    shutil.copytree(fleet, out)
    lock = (out / ".roadbench" / "tables.lock").open()
    with roadbench.read(out) as tables:
        session = tables.session(log.stem)
        (out / ".roadbench" / "next.json").write_text("{}")  # who replaces them waits for us
        start = time.monotonic()
        assert session.coefficients.shape[0] == 39 and time.monotonic() - start < 5
        with pytest.raises(BlockingIOError):
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
