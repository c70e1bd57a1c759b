"""``read`` with ``sessions``, ``bike`` and ``lazy``: the rows that pyarrow finds, and no file more than needed."""

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest

import roadbench
from conftest import on_disk

FRAMES = ("polars", "pandas", "arrow")
COLUMNS = ("session_id", "bike_id", "start_time", "n_samples")


def arrow(frame):
    """Any frame as pyarrow's."""
    return frame if isinstance(frame, pa.Table) else pa.Table.from_pandas(frame) if hasattr(frame, "iloc") else frame.to_arrow()


def values(frame):
    table = arrow(frame)
    return [table[name].to_pylist() for name in ("session_id", "coefficient", "n_samples")]


@pytest.fixture
def months(tmp_path):
    """An output's skeleton: two motorcycles with a session of one name, and two months."""
    schema = pa.schema(roadbench.schema("sessions"))
    places = [("b1", "2026-05", "one"), ("b1", "2026-06", "two"), ("b2", "2026-05", "one"), ("b3 x", "undated", "three")]
    for number, (bike, month, session) in enumerate(places):
        row = {name: [None] for name in schema.names} | {"session_id": [session], "bike_id": [bike]}
        row |= {"n_samples": [number]}
        for name in ("sessions", "warnings", "signals"):
            folder = tmp_path / "out" / name / f"bike={bike.replace(' ', '%20')}"
            folder.mkdir(parents=True, exist_ok=True)
            table = pa.table({n: pa.array(row[n], schema.field(n).type) for n in COLUMNS})
            # what is asked for by itself has a file per session
            pq.write_table(table, folder / f"{session if name == 'signals' else month}.parquet")
    return tmp_path / "out"


def spoil(out, table, kept):
    """All files of a table but these cannot be read any more."""
    spoilt = [file for file in (out / table).rglob("*.parquet") if file.relative_to(out / table).as_posix() not in kept]
    for file in spoilt:
        file.write_bytes(b"spoilt")
    return len(spoilt)


@pytest.mark.parametrize("frames", FRAMES)
def test_sessions_are_those_that_pyarrow_finds(fleet, frames):
    pytest.importorskip({"arrow": "pyarrow"}.get(frames, frames))
    wanted = ["archive_s0003", "archive_s0010"]
    every = on_disk(fleet, "coefficients")
    theirs = every.filter(pc.is_in(every["session_id"], pa.array(wanted)))
    ours = roadbench.read(fleet, "coefficients", frames=frames, sessions=wanted)
    assert values(ours) == values(theirs) and theirs.num_rows == 2 * 39
    one = roadbench.read(fleet, frames=frames, sessions="archive_s0003")
    assert arrow(one["sessions"]).num_rows == 1
    theirs = every.filter(pc.equal(every["bike_id"], "archive_02"))
    assert values(roadbench.read(fleet, "coefficients", frames=frames, bike="archive_02")) == values(theirs)
    # both at once, and some columns of it
    part = roadbench.read(fleet, frames=frames, sessions=wanted[:1], bike=["archive_01"]).read("coefficients", columns=["session_id"])
    assert arrow(part)["session_id"].to_pylist() == ["archive_s0003"] * 39 and arrow(part).num_columns == 1


def test_lazy_frames_give_the_same_rows(fleet):
    pl = pytest.importorskip("polars")
    tables = roadbench.read(fleet, lazy=True, sessions="archive_s0003")
    lazy = tables["coefficients"]
    assert isinstance(lazy, pl.LazyFrame)
    assert lazy.collect().equals(roadbench.read(fleet, "coefficients", frames="polars", sessions="archive_s0003"))
    every = on_disk(fleet, "plots")
    assert roadbench.read(fleet, "plots", lazy=True).select(pl.len()).collect().item() == every.num_rows
    # the filter of a query reaches the files
    assert "SELECTION" in lazy.filter(pl.col("status") == "ok").explain()
    with pytest.raises(roadbench.Invalid, match="leave one of them out"):
        roadbench.read(fleet, lazy=True, frames="arrow")


@pytest.mark.parametrize("lazy", [False, True])
@pytest.mark.parametrize(
    ("wanted", "kept", "numbers"),
    [
        ({"bike": "b1"}, {"bike=b1/2026-05.parquet", "bike=b1/2026-06.parquet"}, [0, 1]),
        ({"sessions": "two"}, {"bike=b1/2026-06.parquet"}, [1]),
        ({"sessions": ["one"], "bike": "b2"}, {"bike=b2/2026-05.parquet"}, [2]),
        ({"sessions": "one"}, {"bike=b1/2026-05.parquet", "bike=b2/2026-05.parquet"}, [0, 2]),
        ({"bike": "b3 x"}, {"bike=b3%20x/undated.parquet"}, [3]),
    ],
)
def test_only_the_files_that_are_needed_are_read(months, wanted, kept, numbers, lazy):
    pytest.importorskip("polars")
    assert spoil(months, "warnings", kept) == 4 - len(kept)
    tables = roadbench.read(months, frames="polars", lazy=lazy, **wanted)
    assert {file.split("warnings/")[1] for file in tables.files("warnings")} == kept
    found = tables["warnings"]
    assert (found.collect() if lazy else found)["n_samples"].to_list() == numbers
    with pytest.raises(Exception, match="(?i)parquet"):
        roadbench.read(months, "warnings")


@pytest.mark.parametrize("frames", ["polars", "arrow"])
def test_a_session_that_moves_is_found_where_it_is(months, frames):
    """The places of sessions are kept, until a file changes."""
    tables = roadbench.read(months, frames=frames, sessions="two")
    assert arrow(tables["warnings"])["n_samples"].to_pylist() == [1]
    for name in ("sessions", "warnings"):
        (months / name / "bike=b1" / "2026-06.parquet").rename(months / name / "bike=b1" / "2026-07.parquet")
    assert arrow(tables["warnings"])["n_samples"].to_pylist() == [1]
    assert [file.split("bike=")[1] for file in tables.files("warnings")] == ["b1/2026-07.parquet"]


def test_a_file_per_session_is_found_by_its_name(months):
    assert spoil(months, "signals", {"bike=b1/two.parquet"}) == 3
    assert roadbench.read(months, "signals", frames="arrow", sessions="two")["n_samples"].to_pylist() == [1]


def test_a_bike_needs_no_file_of_another(months):
    for name in ("sessions", "warnings"):
        spoil(months, name, {"bike=b2/2026-05.parquet"})
    assert roadbench.read(months, "sessions", frames="arrow", bike="b2")["n_samples"].to_pylist() == [2]


def test_tables_over_the_fleet_go_by_motorcycle_only(fleet):
    every = on_disk(fleet, "tyres")
    of_bike = every.filter(pc.equal(every["bike_id"], "archive_01")).num_rows
    assert 0 < of_bike < every.num_rows
    assert roadbench.read(fleet, "tyres", frames="arrow", bike="archive_01").num_rows == of_bike
    assert roadbench.read(fleet, "tyres", frames="arrow", sessions="archive_s0001").num_rows == every.num_rows
    # a table without rows stays one with columns
    laps = roadbench.read(fleet, "laps", frames="arrow", sessions="archive_s0001")
    assert laps.num_rows == 0 and "session_id" in laps.column_names


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        ({"sessions": "archiv_s0004"}, "no session `archiv_s0004`; did you mean `archive_s0004`"),
        ({"sessions": ["archive_s0001", "S0012"]}, "no session `S0012`; did you mean `archive_s0012`"),
        ({"bike": "archive_1"}, "no motorcycle `archive_1`; did you mean `archive_01`"),
        ({"sessions": "archive_s0011", "bike": "archive_01"}, "no session `archive_s0011` of archive_01; did you mean"),
        ({"sessions": "?"}, "there are archive_s0001, archive_s0002, .*, ..."),
    ],
)
@pytest.mark.parametrize("frames", ["polars", "arrow"])
def test_an_unknown_id_is_told_at_once(fleet, wanted, message, frames):
    with pytest.raises(roadbench.Invalid, match=message) as why:
        roadbench.read(fleet, frames=frames, **wanted)
    assert isinstance(why.value, roadbench.Error) and isinstance(why.value, ValueError)


def test_no_index_no_selection(tmp_path):
    (tmp_path / "tyres").mkdir()
    with pytest.raises(roadbench.NoTable, match="no table `sessions`"):
        roadbench.read(tmp_path, sessions="one")


@pytest.mark.parametrize("frames", FRAMES)
def test_from_an_object_store(months, bucket, frames):
    spoil(months, "warnings", {"bike=b1/2026-06.parquet"})
    tables = roadbench.read(bucket(months), frames=frames, sessions="two")
    assert arrow(tables["warnings"])["n_samples"].to_pylist() == [1]
    assert [s.id for s in tables.sessions()] == ["two"]
    if frames == "polars":
        lazy = roadbench.read(tables.out, "warnings", lazy=True, bike="b1", sessions="two")
        assert lazy.collect()["n_samples"].to_list() == [1]
    with pytest.raises(roadbench.Invalid, match="did you mean `three`"):
        roadbench.read(tables.out, sessions="thre")
