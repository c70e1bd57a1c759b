"""How long analysts' tools take to read one coefficient of all sessions of an output.

    python benches/readers.py OUT             the output as it is
    python benches/readers.py OUT --split DIR also as a file per session and table, written below DIR first

Needs polars, DuckDB, pandas and pyarrow; pyspark is timed where it is installed. Each reader is timed three times after
a first read, in one process; the least counts.
"""

import argparse
import time
from pathlib import Path

import duckdb
import pandas
import polars
import pyarrow.compute as pc
import pyarrow.parquet as pq

COEFFICIENT = "effective_rolling_radius"
#: Tables over sessions, but for those that are made on request.
SESSION_TABLES = ["coefficients", "evidence", "manoeuvres", "plots", "sessions", "warnings"]


def with_polars(out):
    rows = polars.scan_parquet(f"{out}/coefficients/**/*.parquet")
    rows = rows.filter(polars.col("coefficient") == COEFFICIENT)
    return len(rows.select("session_id", "tyre", "value").collect())


def with_duckdb(out):
    rows = f"select session_id, tyre, value from '{out}/coefficients/**/*.parquet'"
    return len(duckdb.sql(f"{rows} where coefficient = '{COEFFICIENT}'").fetchall())


def with_pandas(out):
    keep = [("coefficient", "==", COEFFICIENT)]
    return len(pandas.read_parquet(f"{out}/coefficients", columns=["session_id", "tyre", "value"], filters=keep))


def with_spark(spark):
    def read(out):
        rows = spark.read.parquet(f"{out}/coefficients").where(f"coefficient = '{COEFFICIENT}'")
        return len(rows.select("session_id", "tyre", "value").collect())

    return read


def split(out, to):
    """The same rows with a file per session and table, as a roadbench of before wrote them."""
    for table in SESSION_TABLES:
        for path in sorted((out / table).glob("bike=*/*.parquet")):
            rows = pq.ParquetFile(path).read()
            folder = to / table / path.parent.name
            folder.mkdir(parents=True, exist_ok=True)
            ids = rows["session_id"].cast("string")
            for session in pc.unique(ids).to_pylist():
                own = rows.filter(pc.equal(ids, session))
                pq.write_table(own, folder / f"{session}.parquet", compression="zstd")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("--split", type=Path)
    given = parser.parse_args()
    readers = {"polars": with_polars, "DuckDB": with_duckdb, "pandas": with_pandas}
    try:
        from pyspark.sql import SparkSession

        spark = SparkSession.builder.master("local[2]").config("spark.ui.enabled", False)
        spark = spark.config("spark.ui.showConsoleProgress", False).getOrCreate()
        spark.sparkContext.setLogLevel("ERROR")
        readers["Spark"] = with_spark(spark)
    except ImportError:
        print("no pyspark here: Spark is left out")
    places = [given.out]
    if given.split:
        if not given.split.exists():
            split(given.out, given.split)
        places.append(given.split)
    for place in places:
        files = [p for table in SESSION_TABLES for p in (place / table).rglob("*.parquet")]
        size = sum(p.stat().st_size for p in files)
        print(f"{place}: {len(files)} files, {size / 1e6:.1f} MB")
        for name, read in readers.items():
            found, least = read(place), float("inf")
            for _ in range(3):
                start = time.perf_counter()
                assert read(place) == found
                least = min(least, time.perf_counter() - start)
            print(f"  {name:8} {least:7.3f} s for {found} values")


if __name__ == "__main__":
    main()
