"""Many sessions on a cluster of two workers give the files of one machine, byte for byte; with one
of the workers killed in between, too."""

import json
import os
import shutil
import sys
import threading
import time

import pytest

from conftest import SESSIONS, files, roadbench, staged

if shutil.which("java") is None:
    pytest.skip("there is no Java, which Spark needs", allow_module_level=True)

import roadbench.spark as on_spark
from cluster import HOST
from pyspark.sql import SparkSession

REJECTED = {"truncated": 1, "no_channel_map": 1, "duplicate_session_id": 1}


@pytest.fixture(scope="module")
def alone(archive, tmp_path_factory):
    """The same archive on one machine."""
    out = tmp_path_factory.mktemp("alone")
    roadbench("run", archive, "--out", out, code=1)  # some are rejected
    return out


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
    done = on_spark.run(spark, archive, tmp_path / "out")
    print(f"\n{SESSIONS} sessions on two workers: {time.monotonic() - start:.1f} s")
    accounted(done)
    same_files(tmp_path / "out", alone)
    assert json.loads((tmp_path / "out" / "run.json").read_text()) == done
    # nothing has changed: neither for the cluster nor for one machine
    again = on_spark.run(spark, archive, tmp_path / "out")
    assert (again["computed"], again["unchanged"], again["rejected"]) == (0, SESSIONS, 3)
    said = roadbench("run", archive, "--out", tmp_path / "out", "--dry-run")
    assert f" 0 to compute, {SESSIONS} unchanged, 3 to reject" in said


def test_two_runs_on_one_output(spark, archive, tmp_path):
    from roadbench import _roadbench

    options = {"inputs": [str(archive)], "bikes": None, "out": str(tmp_path), "pipeline": "onroad",
               "maps": [], "force": False, "since": None}
    first = _roadbench.Driver(json.dumps(options))
    with pytest.raises(ValueError, match="another roadbench is writing"):
        on_spark.run(spark, archive, tmp_path)
    first.abandon()
    with pytest.raises(ValueError, match="holds no logs"):
        on_spark.run(spark, archive / "bikes", tmp_path, bikes=archive / "bikes")


def test_a_killed_worker(spark, cluster, archive, alone, tmp_path):
    out = tmp_path / "out"
    killed_at = []

    def kill():
        end = time.monotonic() + 300
        while time.monotonic() < end:
            there = staged(out)
            if there >= SESSIONS // 4:
                cluster.kill(0)
                killed_at.append(there)
                return
            time.sleep(0.01)

    killer = threading.Thread(target=kill)
    killer.start()
    done = on_spark.run(spark, archive, out)
    killer.join()
    print(f"\none of two workers killed after {killed_at} of {SESSIONS} sessions: {done['seconds']:.1f} s")
    assert killed_at and killed_at[0] < SESSIONS, "it was killed in between"
    accounted(done)
    same_files(out, alone)
