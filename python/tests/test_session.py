"""``run_session`` gives what the command line writes, and says what is wrong as Python does."""

import pickle

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import roadbench
from conftest import ARCHIVE


@pytest.fixture(scope="module")
def tables(log, bike):
    return roadbench.run_session(log, bike, signals=True)


def test_same_tables_same_rows_same_schemas(written, log, tables):
    there = {p.parts[-3] for p in written.rglob("bike=[!_]*/*.parquet")}
    assert set(tables) == there == {
        "coefficients", "evidence", "manoeuvres", "warnings", "plots", "signals", "tyre_parameters", "sessions"
    }
    for name, table in tables.items():
        [path] = (written / name).rglob("bike=[!_]*/*.parquet")  # this session's month, in which it is alone
        on_disk = pq.read_table(path, partitioning=None)
        in_memory = pa.table(table)
        assert in_memory.schema.equals(on_disk.schema, check_metadata=True), name
        assert in_memory.equals(on_disk), name
        assert len(table) == on_disk.num_rows


def test_units_and_descriptions_come_along(tables):
    field = pa.table(tables["sessions"]).schema.field("duration")
    assert field.metadata[b"unit"] == b"s" and field.metadata[b"description"]
    assert tables["sessions"].schema.unit("duration") == "s"


def test_nothing_is_copied_on_the_way_out(tables):
    twice = [pa.table(tables["plots"])["x"].chunk(0).buffers()[1].address for _ in range(2)]
    assert twice[0] == twice[1]


def test_a_table_gives_what_its_file_gives(log, bike, tables):
    table = pq.read_table(log, partitioning=None)
    own = pq.ParquetFile(log).metadata.metadata
    named = table.replace_schema_metadata({k: v for k, v in own.items() if k != b"ARROW:schema"})
    again = roadbench.run_session(named, bike, signals=True)
    differ = ["input_hash", "path"]
    for name in tables:
        one, other = pa.table(tables[name]), pa.table(again[name])
        keep = [c for c in one.column_names if c not in differ]
        assert one.select(keep).equals(other.select(keep)), name
    assert pa.table(again["sessions"])["path"].to_pylist() == ["(table)"]
    # however it is cut into batches
    cut = pa.Table.from_batches(named.to_batches(max_chunksize=999))
    third = roadbench.run_session(cut, bike)
    assert pa.table(third["sessions"]).equals(pa.table(again["sessions"]))


def test_a_table_that_does_not_name_itself(log, bike):
    table = pq.read_table(log, partitioning=None)
    with pytest.raises(roadbench.Rejected) as why:
        roadbench.run_session(table, bike)
    assert why.value.code == "bad_session_id"
    row = pa.table(roadbench.run_session(table, bike, session_id="mine")["sessions"]).to_pylist()[0]
    assert (row["session_id"], row["bike_id"]) == ("mine", "archive_01")


def test_a_bike_as_text(log, bike, tables):
    again = roadbench.run_session(log, bike.read_text())
    assert pa.table(again["coefficients"]).equals(pa.table(tables["coefficients"]))


def test_polars(log, bike, tables):
    polars = pytest.importorskip("polars")
    frame = polars.DataFrame(tables["coefficients"])
    assert frame.height == len(tables["coefficients"])
    ok = frame.filter(polars.col("status") == "ok")
    assert ok.height == pa.table(tables["sessions"])["n_coefficients_ok"][0].as_py()
    ride = polars.read_parquet(log, hive_partitioning=False)
    again = roadbench.run_session(ride, bike, session_id=log.stem)
    values = [pa.table(t["coefficients"])["value"] for t in (tables, again)]
    assert values[0].equals(values[1])


def test_pandas(tables):
    pytest.importorskip("pandas")
    frame = pa.table(tables["coefficients"]).to_pandas()
    assert list(frame.columns) == tables["coefficients"].column_names


def test_duckdb(tables):
    duckdb = pytest.importorskip("duckdb")
    coefficients = tables["coefficients"]  # found by its name in the query
    [(count,)] = duckdb.sql("select count(*) from coefficients where status = 'ok'").fetchall()
    assert count == pa.table(tables["sessions"])["n_coefficients_ok"][0].as_py()
    assert len(coefficients) >= count


def test_a_log_that_cannot_be_used(tmp_path, log, bike):
    cut = tmp_path / "cut.parquet"
    cut.write_bytes(log.read_bytes()[:5000])
    with pytest.raises(roadbench.Rejected) as why:
        roadbench.run_session(cut, bike)
    why = why.value
    assert (why.stage, why.code) == ("ingest", "truncated")
    assert "cut.parquet" in why.message and why.message in str(why)
    again = pickle.loads(pickle.dumps(why))
    assert (again.stage, again.code, again.message) == (why.stage, why.code, why.message)
    with pytest.raises(roadbench.Rejected, match="missing_column"):
        roadbench.run_session(pa.table({"speed": [1.0]}), bike, session_id="s")


def test_what_is_the_callers_mistake(tmp_path, log, bike):
    with pytest.raises(ValueError, match="no-such.toml"):
        roadbench.run_session(log, tmp_path / "no-such.toml")
    with pytest.raises(ValueError, match="did you mean `mass`"):
        roadbench.run_session(log, bike.read_text().replace("mass =", "mas ="))
    with pytest.raises(ValueError, match="onroad, paper, offroad"):
        roadbench.run_session(log, bike, pipeline="onraod")
    with pytest.raises(ValueError, match="no-such-map.toml"):
        roadbench.run_session(log, bike, maps=[tmp_path / "no-such-map.toml"])
    with pytest.raises(TypeError):
        roadbench.run_session(7, bike)


def test_others_go_on_meanwhile(log, bike):
    """The GIL is released: a thread of Python's counts while a session is computed."""
    from threading import Event, Thread

    ticks, done = [], Event()

    def tick():
        while not done.wait(0.001):
            ticks.append(None)

    thread = Thread(target=tick)
    thread.start()
    roadbench.run_session(log, bike)
    done.set()
    thread.join()
    assert len(ticks) > 10


def test_schemas():
    schema = pa.schema(roadbench.schema("session"))
    assert schema.field("roll").metadata[b"unit"] == b"rad"
    assert schema.metadata[b"roadbench.schema"] == b"session.v1"
    assert roadbench.schema("sessions.v1").names[0] == "session_id"
    with pytest.raises(ValueError, match="coefficients"):
        roadbench.schema("coeficients")
    with pytest.raises(ValueError, match="there are session, "):
        roadbench.schema("bike")  # a file of keys, no table
    with pytest.raises(ValueError, match="did you mean `value`"):
        roadbench.schema("coefficients").unit("valu")


def test_version():
    assert roadbench.__version__ in (ARCHIVE.parents[1] / "Cargo.toml").read_text()
