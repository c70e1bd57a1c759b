"""The same cluster over an object store: logs and tables are URLs, a worker and the driver are killed, and the tables are
those of one machine."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from conftest import files, roadbench as command

if shutil.which("java") is None:
    pytest.skip("there is no Java, which Spark needs", allow_module_level=True)

import boto3
import roadbench
from cluster import HOST, descendants, free_port

#: Sessions of the archive that are put into the store.
SOME = 24
BUCKET = "fleet"
NULLS = 8


class Store:
    """A bucket of a server that speaks S3, and how to reach it."""

    def __init__(self, folder):
        endpoint = f"http://{HOST}:{free_port()}"
        self.environment = {
            "AWS_ACCESS_KEY_ID": "me",
            "AWS_SECRET_ACCESS_KEY": "secret",
            "AWS_REGION": "us-east-1",
            "AWS_ENDPOINT": endpoint,
            "AWS_ALLOW_HTTP": "true",
            "ROADBENCH_LOCK_SECONDS": "10",
        }
        server = [Path(sys.executable).parent / "moto_server", "-H", HOST, "-p", endpoint.rpartition(":")[2]]
        with open(folder / "store.log", "wb") as log:
            self.server = subprocess.Popen(server, stdout=log, stderr=subprocess.STDOUT)
        self.s3 = boto3.client(
            "s3",
            endpoint_url=endpoint,
            region_name="us-east-1",
            aws_access_key_id="me",
            aws_secret_access_key="secret",
        )
        end = time.monotonic() + 60
        while True:
            try:
                self.s3.create_bucket(Bucket=BUCKET)
                return
            except Exception:  # not there yet
                if time.monotonic() > end:
                    raise
                time.sleep(0.2)

    def put(self, folder, prefix, keep):
        for path in sorted(folder.rglob("*")):
            if path.is_file() and keep(path):
                key = f"{prefix}/{path.relative_to(folder)}"
                self.s3.put_object(Bucket=BUCKET, Key=key, Body=path.read_bytes())

    def below(self, prefix):
        """Key below the prefix, and bytes."""
        pages = self.s3.get_paginator("list_objects_v2").paginate(Bucket=BUCKET, Prefix=f"{prefix}/")
        keys = [entry["Key"] for page in pages for entry in page.get("Contents", [])]
        get = lambda key: self.s3.get_object(Bucket=BUCKET, Key=key)["Body"].read()  # noqa: E731
        return {key.removeprefix(f"{prefix}/"): get(key) for key in keys}

    def count(self, prefix):
        pages = self.s3.get_paginator("list_objects_v2").paginate(Bucket=BUCKET, Prefix=prefix)
        return sum(len(page.get("Contents", [])) for page in pages)

    def tables(self, prefix):
        return {name: bytes for name, bytes in self.below(prefix).items() if name.endswith(".parquet")}


@pytest.fixture(scope="module")
def store(tmp_path_factory, archive):
    store = Store(tmp_path_factory.mktemp("store"))
    kept = {f"s{number:04}" for number in range(SOME)}
    store.put(archive, "in", lambda path: path.stem in kept or path.suffix == ".toml")
    yield store
    store.server.kill()
    store.server.wait(30)


@pytest.fixture(scope="module")
def alone(store, archive, tmp_path_factory):
    """One machine, from the store into a folder."""
    out = tmp_path_factory.mktemp("alone_from_store")
    subprocess.run(
        [sys.executable, "-m", "roadbench", "run", f"s3://{BUCKET}/in", "--out", out],
        env=os.environ | store.environment, check=True, capture_output=True,
    )  # fmt: skip
    return out


def submit(cluster, store, folder, *arguments):
    """The driver as a process of its own, as spark-submit starts it."""
    home = cluster.home
    executors = [f"--conf=spark.executorEnv.{k}={v}" for k, v in store.environment.items()]
    given = [
        home / "bin" / "spark-submit", "--master", cluster.url,
        f"--conf=spark.driver.host={HOST}", f"--conf=spark.driver.bindAddress={HOST}",
        "--conf=spark.ui.enabled=false", "--driver-memory=512m", "--executor-memory=512m",
        "--conf=spark.scheduler.minRegisteredResourcesRatio=1.0", *executors,
        Path(roadbench.__file__).parent / "submit.py", *arguments,
    ]  # fmt: skip
    environment = os.environ | store.environment | {
        "SPARK_HOME": str(home),
        "SPARK_LOCAL_IP": HOST,
        "PYSPARK_PYTHON": sys.executable,
        "PYSPARK_DRIVER_PYTHON": sys.executable,
    }
    log = open(folder / "driver.log", "ab")  # the process outlives this function
    return subprocess.Popen(given, env=environment, stdout=log, stderr=subprocess.STDOUT)


def wait_for(store, prefix, number, process):
    """Until so many sessions wait in the output."""
    end = time.monotonic() + 300
    while time.monotonic() < end and process.poll() is None:
        there = store.count(f"{prefix}/.roadbench/staged/run/")
        if there >= number:
            return there
        time.sleep(0.05)
    return store.count(f"{prefix}/.roadbench/staged/run/")


def test_a_worker_and_the_driver_are_killed(cluster, store, alone, tmp_path):
    out = f"s3://{BUCKET}/out"
    cluster.add_worker()  # another test may have killed one
    run = [f"s3://{BUCKET}/in", "--out", out, "--batch", "4"]
    start = time.monotonic()
    driver = submit(cluster, store, tmp_path, *run)
    at_worker = wait_for(store, "out", SOME // 6, driver)
    cluster.kill(-1)
    at_driver = wait_for(store, "out", SOME // 2, driver)
    for pid in descendants(driver.pid):
        os.kill(pid, signal.SIGKILL)
    driver.wait(60)
    assert 0 < at_worker <= at_driver < SOME, "both were killed in between"
    assert not any(name.startswith("sessions/") for name in store.tables("out")), "nothing half"

    time.sleep(11)  # the killed driver's lock ends
    again = submit(cluster, store, tmp_path, *run)
    assert again.wait(300) == 0, (tmp_path / "driver.log").read_text()[-3000:]
    print(f"\n{SOME} sessions by URL, worker killed at {at_worker}, driver at {at_driver}: {time.monotonic() - start:.0f} s")
    assert store.tables("out") == files(alone)
    own = {".roadbench/checksums.json", ".roadbench/output.json"}
    left = [name for name in store.below("out") if name.startswith(".roadbench/") and name not in own]
    assert left == []

    # nothing has changed: nothing is computed
    assert submit(cluster, store, tmp_path, *run).wait(300) == 0
    done = json.loads(store.below("out")["run.json"])
    assert (done["computed"], done["unchanged"]) == (0, SOME)


def test_a_diagnosis_by_url(cluster, store, archive, tmp_path):
    few = tmp_path / "few"
    shutil.copytree(archive / "bikes", few / "bikes")
    for log in sorted((archive / "sessions").rglob("s000[0-2].parquet")):
        to = few / log.relative_to(archive)
        to.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(log, to)
    store.put(few, "few", lambda path: True)
    command("diagnose", few, "--out", tmp_path / "alone", "--nulls", NULLS)
    where = [f"s3://{BUCKET}/few", "--out", f"s3://{BUCKET}/causes"]
    done = submit(cluster, store, tmp_path, *where, "--diagnose", "--nulls", str(NULLS), "--batch", "1")
    assert done.wait(300) == 0, (tmp_path / "driver.log").read_text()[-3000:]
    there, here = store.tables("causes"), files(tmp_path / "alone")
    assert there.keys() == here.keys()
    # the log's name and the store's name of its bytes are others
    same = [name for name in here if not name.startswith("diagnoses/")]
    assert [name for name in same if there[name] != here[name]] == []
