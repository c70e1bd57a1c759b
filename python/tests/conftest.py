"""What the tests share: the bundled archive, and the command line from the same wheel."""

import os
import shutil
import subprocess
import sys
import urllib.request
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

# Spark's virtual machines live for seconds: compiling for speed takes a third of their processor time
os.environ.setdefault("JAVA_TOOL_OPTIONS", "-XX:TieredStopAtLevel=1 -XX:+UseSerialGC")

ROOT = Path(__file__).parents[2]
ARCHIVE = ROOT / "fixtures" / "archive"


def roadbench(*arguments, timeout=600, code=0):
    """The command line; fails the test where the exit code is another one."""
    command = [sys.executable, "-m", "roadbench", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=timeout, check=False)
    assert done.returncode == code, done.stderr
    return done.stdout


#: Of the archive for Spark: enough for every worker to be killed between two of its tasks. 200 take five minutes more.
SESSIONS = int(os.environ.get("ROADBENCH_SPARK_SESSIONS", "48"))


def files(out):
    """Every table of an output folder: path below it, and bytes."""
    return {
        str(path.relative_to(out)): path.read_bytes() for path in sorted(out.rglob("*.parquet"))
    }


def staged(out):
    """Sessions that wait in an output folder."""
    return len(list(out.glob(".roadbench/staged/run/*.session")))


@pytest.fixture(scope="session")
def archive(tmp_path_factory):
    """Many sessions, and three logs that cannot be used: the bundled rides, each cut to many lengths of two minutes."""
    archive = tmp_path_factory.mktemp("archive")
    shutil.copytree(ARCHIVE / "bikes", archive / "bikes")
    logs = sorted((ARCHIVE / "sessions").rglob("*.parquet"))
    for number in range(SESSIONS):
        file = pq.ParquetFile(logs[number % len(logs)])
        ride, own = file.read(), file.metadata.metadata
        name = f"s{number:04}"
        own = {k: v for k, v in own.items() if k != b"ARROW:schema"} | {b"session_id": name}
        folder = archive / "sessions" / f"bike={own[b'bike_id'].decode()}"
        folder.mkdir(parents=True, exist_ok=True)
        cut = ride.slice(0, 6000 - 10 * (number // len(logs)))
        pq.write_table(cut.replace_schema_metadata(own), folder / f"{name}.parquet")
    whole = folder / f"{name}.parquet"
    (folder / "x_cut.parquet").write_bytes(whole.read_bytes()[:3000])
    (folder / "x_words.log").write_text("no ride at all")
    shutil.copy(whole, folder / "x_again.parquet")
    return archive


@pytest.fixture(scope="session")
def cluster(tmp_path_factory):
    from cluster import Cluster

    cluster = Cluster(tmp_path_factory.mktemp("cluster"))
    yield cluster
    cluster.stop()


@pytest.fixture(scope="session")
def log():
    """A session of the archive that is in the repository."""
    return sorted((ARCHIVE / "sessions" / "bike=archive_01").rglob("*.parquet"))[0]


@pytest.fixture(scope="session")
def bike():
    """Its bike."""
    return ARCHIVE / "bikes" / "archive_01.toml"


@pytest.fixture(scope="session")
def written(log, tmp_path_factory):
    """What the command line writes for that session."""
    out = tmp_path_factory.mktemp("written")
    roadbench("run", log, "--bikes", ARCHIVE / "bikes", "--out", out, "--signals")
    return out


@pytest.fixture(scope="session")
def fleet(tmp_path_factory):
    """What the command line writes for the whole archive: twelve sessions of two motorcycles."""
    out = tmp_path_factory.mktemp("fleet")
    roadbench("run", ARCHIVE, "--out", out)
    return out


def on_disk(out, name):
    """A table's rows as pyarrow reads them, file by file."""
    files = sorted((out / name).rglob("*.parquet"))
    return pa.concat_tables([pq.read_table(file, partitioning=None) for file in files])


@pytest.fixture
def bucket(monkeypatch):
    """An object store on this machine: puts a folder there, and gives its URL."""
    server = pytest.importorskip("moto.server")
    boto3 = pytest.importorskip("boto3")
    served = server.ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    served.start()
    host, port = served.get_host_and_port()
    for name, value in {"AWS_ENDPOINT": f"http://{host}:{port}", "AWS_ACCESS_KEY_ID": "test",
                        "AWS_SECRET_ACCESS_KEY": "test", "AWS_REGION": "us-east-1"}.items():  # fmt: skip
        monkeypatch.setenv(name, value)
    client = boto3.client("s3", endpoint_url=f"http://{host}:{port}", region_name="us-east-1")
    # the servers of one process share their objects
    urllib.request.urlopen(urllib.request.Request(f"http://{host}:{port}/moto-api/reset", method="POST")).close()
    client.create_bucket(Bucket="fleet")

    def put(folder):
        for path in folder.rglob("*.parquet"):
            client.upload_file(str(path), "fleet", f"tables/{path.relative_to(folder)}")
        return "s3://fleet/tables"

    yield put
    served.stop()
