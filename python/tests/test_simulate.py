"""``simulate`` gives the sessions and the truth of ``roadbench simulate``."""

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import roadbench
from conftest import ROOT
from conftest import roadbench as command

SMALL = ROOT / "python" / "tests" / "small.toml"


def test_the_session_and_truth_of_the_command_line(tmp_path):
    command("simulate", SMALL, "--out", tmp_path)
    ride = roadbench.simulate(SMALL, number=3)
    assert set(ride.tables) == {"session", "truth", "truth_segments"}
    assert ride.bike == (tmp_path / "bikes" / "small_02.toml").read_text()
    assert ride.fall is None
    [log] = (tmp_path / "sessions").rglob("small_s0004.parquet")
    session = pa.table(ride.tables["session"])
    assert session.equals(pq.ParquetFile(log).read())
    assert session.schema.metadata[b"session_id"] == b"small_s0004"
    for folder, name in [("coefficients", "truth"), ("segments", "truth_segments")]:
        path = tmp_path / "truth" / folder / "bike=small_02" / "small_s0004.parquet"
        assert pa.table(ride.tables[name]).equals(pq.ParquetFile(path).read())


def test_what_is_simulated_can_be_computed():
    ride = roadbench.simulate(SMALL)
    tables = roadbench.run_session(ride.tables["session"], ride.bike)
    row = pa.table(tables["sessions"]).to_pylist()[0]
    assert (row["session_id"], row["bike_id"]) == ("small_s0001", "small_01")
    assert row["n_coefficients_ok"] > 0


def test_what_is_not_there():
    with pytest.raises(ValueError, match="8 sessions"):
        roadbench.simulate(SMALL, number=8)
    with pytest.raises(ValueError, match="no-such"):
        roadbench.simulate("no-such")
