"""``read`` gives the tables of an output as frames, with units, also while a run writes to it."""

import threading
import time

import pyarrow.parquet as pq
import pytest

import roadbench
from conftest import ARCHIVE, ROOT
from roadbench import _folders, _read

fcntl = pytest.importorskip("fcntl")
FRAMES = ("polars", "pandas", "arrow")


def rows_on_disk(out, name):
    return sum(pq.read_metadata(path).num_rows for path in (out / name).rglob("*.parquet"))


@pytest.fixture
def output(tmp_path):
    """An output's skeleton: one table with a file per motorcycle, and what is not in place yet."""
    out = tmp_path / "out"
    for bike, rows in (("a", 2), ("b", 3)):
        folder = out / "warnings" / f"bike={bike}"
        folder.mkdir(parents=True)
        table = pq.read_table(next((ARCHIVE / "truth").rglob("*.parquet")), partitioning=None)
        pq.write_table(table.slice(0, rows), folder / "undated.parquet")
    waits = out / ".roadbench" / "next" / "coefficients"
    waits.mkdir(parents=True)
    (waits / "undated.parquet").write_bytes(b"half")
    (out / ".roadbench" / "tables.lock").touch()
    return out


@pytest.mark.parametrize("frames", FRAMES)
def test_every_library_gives_every_table(written, frames):
    pytest.importorskip({"arrow": "pyarrow"}.get(frames, frames))
    tables = roadbench.read(written, frames=frames)
    assert {"coefficients", "manoeuvres", "plots", "sessions", "signals", "tyres"} <= set(tables)
    for name in tables:
        assert tables[name].shape[0] == rows_on_disk(written, name), name
    one = roadbench.read(written, "coefficients", frames=frames)
    columns = one.column_names if frames == "arrow" else list(one.columns)
    assert columns == list(tables.descriptions["coefficients"]) and "bike" not in columns
    assert tables.describe("coefficients").shape == (len(columns), 3)
    assert tables.describe().shape == (len(tables), 3)


def test_units_are_those_of_the_files(written):
    tables = roadbench.read(written)
    assert tables.units["sessions"]["duration"] == "s"
    assert "session_id" not in tables.units["sessions"]
    assert tables.descriptions["sessions"]["duration"] == "Length of the session."
    assert roadbench.read(written, "sessions", frames="pandas").attrs["units"]["duration"] == "s"
    field = roadbench.read(written, "sessions", frames="arrow").schema.field("duration")
    assert field.metadata[b"unit"] == b"s"


def test_without_pyarrow_units_are_those_of_the_contract(written, monkeypatch):
    found = dict(roadbench.read(written).units)
    find = _read.importlib.util.find_spec
    monkeypatch.setattr(_read.importlib.util, "find_spec", lambda name: None if name == "pyarrow" else find(name))
    assert dict(roadbench.read(written).units) == found
    with pytest.raises(ImportError, match="pip install pyarrow"):
        roadbench.read(written, frames="arrow")
    with pytest.raises(ImportError, match="'pandas' needs pyarrow"):
        roadbench.read(written, frames="pandas")


def test_part_of_a_table(written, log):
    tables = roadbench.read(written, frames="arrow")
    part = tables.read("plots", columns=["plot", "x"], session=log.stem)
    assert part.column_names == ["plot", "x"] and part.num_rows == rows_on_disk(written, "plots")
    for frames in FRAMES:
        assert roadbench.read(written, frames=frames).read("plots", session="another").shape[0] == 0
    assert all(path.endswith(".parquet") for path in tables.files("plots"))


def test_what_is_not_there(written, tmp_path):
    tables = roadbench.read(written)
    with pytest.raises(KeyError, match="no table `coeficients`; there are .*coefficients, ") as why:
        tables["coeficients"]
    assert isinstance(why.value, roadbench.NoTable) and not str(why.value).startswith("'")
    assert "causes" not in tables and tables.get("causes") is None
    with pytest.raises(FileNotFoundError, match="no such folder"):
        roadbench.read(tmp_path / "nowhere", "sessions")
    with pytest.raises(roadbench.NoTable, match="there is none"):
        roadbench.read(tmp_path, "sessions")
    with pytest.raises(ValueError, match="none of polars, pandas, arrow"):
        roadbench.read(written, frames="spark")


def test_only_what_is_in_place(output):
    assert list(roadbench.read(output)) == ["warnings"]
    assert roadbench.read(output, "warnings").shape[0] == 5


def test_reading_waits_for_who_replaces_the_tables(output):
    with (output / ".roadbench" / "tables.lock").open() as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        rows = []
        reader = threading.Thread(target=lambda: rows.append(roadbench.read(output, "warnings").shape[0]))
        reader.start()
        reader.join(0.3)
        assert reader.is_alive() and not rows
        fcntl.flock(lock, fcntl.LOCK_UN)
        reader.join(10)
    assert rows == [5]


def test_in_a_with_block_tables_stay_as_they_are(output):
    lock = (output / ".roadbench" / "tables.lock").open()
    with roadbench.read(output) as tables:
        with pytest.raises(BlockingIOError):
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        (output / ".roadbench" / "next.json").write_text("{}")  # who replaces them waits for us
        start = time.monotonic()
        assert tables["warnings"].shape[0] == 5 and time.monotonic() - start < 5
    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)


def test_a_run_that_was_killed_is_told(output, monkeypatch):
    monkeypatch.setattr(_folders, "_FINISHING", 0.1)
    (output / ".roadbench" / "next.json").write_text("{}")
    with pytest.warns(UserWarning, match="was killed at it"):
        assert roadbench.read(output, "warnings").shape[0] == 5


def test_while_a_run_works_along(log, tmp_path):
    """Every table that is read is of before or of after."""
    out = tmp_path / "out"
    roadbench.run(log, out, bikes=ARCHIVE / "bikes")
    before = roadbench.read(out, "coefficients").shape[0]
    run = threading.Thread(target=lambda: roadbench.run(ARCHIVE, out))
    run.start()
    seen = []
    while run.is_alive():
        with roadbench.read(out, frames="arrow") as tables:
            seen.append((tables["coefficients"].num_rows, tables["sessions"].num_rows))
        time.sleep(0.01)  # a run that ends is not kept out for ever
    run.join()
    after = roadbench.read(out, "coefficients").shape[0]
    assert after == 12 * before and set(seen) <= {(before, 1), (after, 12)}
    assert len(seen) > 5


def test_from_an_object_store(output, bucket):
    tables = roadbench.read(bucket(output))
    assert list(tables) == ["warnings"] and tables["warnings"].shape[0] == 5
    assert tables.descriptions["warnings"]


def test_the_truth_of_an_archive_is_read_too():
    truth = roadbench.read(ROOT / "fixtures" / "archive" / "truth")
    assert set(truth) == {"coefficients", "segments"}
