"""Ids are plain texts for every reader: they join, compare and group without casts; empty tables can be queried."""

import os
import shutil
import sys

import pytest

from conftest import ARCHIVE, ROOT

ID = "archive_s0001"


@pytest.fixture(scope="module")
def out(written):
    return written


def test_polars(out):
    pl = pytest.importorskip("polars")
    rows = pl.read_parquet(f"{out}/coefficients/**/*.parquet")
    assert rows["session_id"].dtype == pl.String and rows["tyre_model"].dtype == pl.String
    wanted = pl.DataFrame({"session_id": [ID]})
    assert rows.join(wanted, on="session_id").height == rows.height > 0
    assert rows.filter(pl.col("session_id").str.starts_with("archive_")).height == rows.height
    assert pl.scan_parquet(f"{out}/coefficients", hive_partitioning=True).collect().height == rows.height


def test_pandas(out):
    pd = pytest.importorskip("pandas")
    rows = pd.read_parquet(out / "coefficients")
    assert rows["session_id"].dtype != "category"
    assert rows["session_id"].str.startswith("archive_").all()
    assert len(rows.merge(pd.DataFrame({"session_id": [ID]}), on="session_id")) == len(rows) > 0
    # a group is a session that is there: categories would give those that are not, too
    assert set(rows.groupby("session_id")["value"].median().index) == {ID}
    models = rows[rows["tyre"] != "vehicle"].groupby(["tyre", "tyre_model"])["value"].count()
    assert len(models) == 2 and (models > 5).all()


def test_duckdb(out):
    duckdb = pytest.importorskip("duckdb")
    query = f"select session_id from '{out}/coefficients/*/*.parquet' where session_id like 'archive_%'"
    types = duckdb.sql(f"describe {query}").fetchall()
    assert types[0][1] == "VARCHAR"
    assert duckdb.sql(query).fetchall()[0][0] == ID
    bikes = duckdb.sql(f"select distinct bike from '{out}/coefficients/*/*.parquet'").fetchall()
    assert bikes == [("archive_01",)]


def test_spark(out):
    if shutil.which("java") is None:
        pytest.skip("there is no Java, which Spark needs")
    sql = pytest.importorskip("pyspark.sql")
    os.environ["PYSPARK_PYTHON"] = os.environ["PYSPARK_DRIVER_PYTHON"] = sys.executable
    build = sql.SparkSession.builder.master("local[1]").config("spark.ui.enabled", False)
    session = build.config("spark.driver.bindAddress", "127.0.0.1").config("spark.driver.host", "127.0.0.1").getOrCreate()
    try:
        rows = session.read.parquet(str(out / "coefficients"))
        assert dict(rows.dtypes)["session_id"] == "string"
        wanted = session.createDataFrame([(ID,)], ["session_id"])
        assert rows.join(wanted, "session_id").count() == rows.count() > 0
        assert session.read.parquet(str(out / "laps")).count() == 0
    finally:
        session.stop()


def test_the_truth_reads_alike():
    pl = pytest.importorskip("polars")
    truth = pl.read_parquet(ROOT / "fixtures" / "archive" / "truth" / "coefficients" / "**" / "*.parquet")
    assert truth["session_id"].dtype == pl.String and truth["session_id"].n_unique() == 12
    assert ARCHIVE.is_dir()


@pytest.mark.parametrize("table", ["laps", "lap_corners", "lap_points", "lap_coefficients", "lap_trends", "forces", "rejected", "fleet_events"])
def test_a_table_without_rows_can_be_queried(out, table):
    pl, pd, duckdb = (pytest.importorskip(name) for name in ("polars", "pandas", "duckdb"))
    assert pl.read_parquet(f"{out}/{table}/**/*.parquet").height == 0
    assert len(pd.read_parquet(out / table)) == 0
    assert duckdb.sql(f"select count(*) from '{out}/{table}/**/*.parquet'").fetchall() == [(0,)]
