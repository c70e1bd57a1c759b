"""200 sessions on a cluster of two workers give the files of one machine, byte for byte; with one
of the workers killed in between, too."""

import json
import os
import shutil
import sys
import threading
import time

import pyarrow.parquet as pq
import pytest

from conftest import ROOT, files, roadbench

if shutil.which("java") is None:
    pytest.skip("there is no Java, which Spark needs", allow_module_level=True)

import roadbench.spark as on_spark
from cluster import HOST, Cluster
from pyspark.sql import SparkSession

SESSIONS = int(os.environ.get("ROADBENCH_SPARK_SESSIONS", "200"))
REJECTED = {"truncated": 1, "no_channel_map": 1, "duplicate_session_id": 1}


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """200 sessions, and three logs that cannot be used: simulated rides, each cut to many lengths."""
    rides, archive = tmp_path_factory.mktemp("rides"), tmp_path_factory.mktemp("archive")
    roadbench("simulate", ROOT / "python" / "tests" / "small.toml", "--out", rides)
    shutil.copytree(rides / "bikes", archive / "bikes")
    logs = sorted((rides / "sessions").rglob("*.parquet"))
    for number in range(SESSIONS):
        file = pq.ParquetFile(logs[number % len(logs)])
        ride, own = file.read(), file.metadata.metadata
        name = f"s{number:04}"
        own = {k: v for k, v in own.items() if k != b"ARROW:schema"} | {b"session_id": name}
        folder = archive / "sessions" / f"bike={own[b'bike_id'].decode()}"
        folder.mkdir(parents=True, exist_ok=True)
        cut = ride.slice(0, ride.num_rows - 10 * (number // len(logs)))
        pq.write_table(cut.replace_schema_metadata(own), folder / f"{name}.parquet")
    whole = folder / f"{name}.parquet"
    (folder / "x_cut.parquet").write_bytes(whole.read_bytes()[:3000])
    (folder / "x_words.log").write_text("no ride at all")
    shutil.copy(whole, folder / "x_again.parquet")
    return archive


@pytest.fixture(scope="module")
def alone(archive, tmp_path_factory):
    """The same archive on one machine."""
    out = tmp_path_factory.mktemp("alone")
    roadbench("run", archive, "--out", out, code=1)  # some are rejected
    return out


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    cluster = Cluster(tmp_path_factory.mktemp("cluster"))
    yield cluster
    cluster.stop()


@pytest.fixture(scope="module")
def spark(cluster):
    os.environ["PYSPARK_PYTHON"] = os.environ["PYSPARK_DRIVER_PYTHON"] = sys.executable
    session = (
        SparkSession.builder.master(cluster.url)
        .config("spark.driver.host", HOST)
        .config("spark.driver.bindAddress", HOST)
        .config("spark.driver.memory", "512m")
        .config("spark.executor.memory", "512m")
        .config("spark.ui.enabled", False)
        .config("spark.scheduler.minRegisteredResourcesRatio", "1.0")
        .getOrCreate()
    )
    yield session
    session.stop()


def accounted(done):
    assert (done["inputs"], done["computed"], done["rejected"]) == (SESSIONS + 3, SESSIONS, 3)
    assert done["rejected_by_code"] == REJECTED


def same_files(out, alone):
    ours, theirs = files(out), files(alone)
    assert ours.keys() == theirs.keys()
    assert [name for name in ours if ours[name] != theirs[name]] == []
    left = [p for p in out.rglob(".roadbench-*") if p.is_file()]
    assert left == [], "a killed worker's temporaries"


def test_a_cluster_gives_the_files_of_one_machine(spark, archive, alone, tmp_path):
    start = time.monotonic()
    done = on_spark.run(spark, archive, None, tmp_path / "out")
    print(f"\n{SESSIONS} sessions on two workers: {time.monotonic() - start:.1f} s")
    accounted(done)
    same_files(tmp_path / "out", alone)
    assert json.loads((tmp_path / "out" / "run.json").read_text()) == done
    # nothing has changed: neither for the cluster nor for one machine
    again = on_spark.run(spark, archive, None, tmp_path / "out")
    assert (again["computed"], again["unchanged"], again["rejected"]) == (0, SESSIONS, 3)
    said = roadbench("run", archive, "--out", tmp_path / "out", "--dry-run")
    assert f" 0 to compute, {SESSIONS} unchanged, 3 to reject" in said


def test_two_runs_on_one_output(spark, archive, tmp_path):
    from roadbench import _roadbench

    options = {"inputs": [str(archive)], "bikes": None, "out": str(tmp_path), "pipeline": "onroad",
               "maps": [], "force": False, "since": None}
    first = _roadbench.Driver(json.dumps(options))
    with pytest.raises(ValueError, match="another roadbench is writing"):
        on_spark.run(spark, archive, None, tmp_path)
    first.abandon()
    with pytest.raises(ValueError, match="holds no logs"):
        on_spark.run(spark, archive / "bikes", archive / "bikes", tmp_path)


def test_a_killed_worker(spark, cluster, archive, alone, tmp_path):
    out = tmp_path / "out"
    killed_at = []

    def kill():
        end = time.monotonic() + 300
        while time.monotonic() < end:
            there = len(list(out.glob("sessions/bike=*/s*.parquet")))
            if there >= SESSIONS // 4:
                cluster.kill(0)
                killed_at.append(there)
                return
            time.sleep(0.01)

    killer = threading.Thread(target=kill)
    killer.start()
    done = on_spark.run(spark, archive, None, out)
    killer.join()
    print(f"\none of two workers killed after {killed_at} of {SESSIONS} sessions: {done['seconds']:.1f} s")
    assert killed_at and killed_at[0] < SESSIONS, "it was killed in between"
    accounted(done)
    same_files(out, alone)
