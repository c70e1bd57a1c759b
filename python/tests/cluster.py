"""A Spark cluster on this machine, each worker with processes of its own that can be killed."""

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pyspark

HOST = "127.0.0.1"


def free_port():
    with socket.socket() as s:
        s.bind((HOST, 0))
        return s.getsockname()[1]


def descendants(pid):
    """A process and all that it started, as far as they live."""
    children = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            after = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue  # it has just ended
        children.setdefault(int(after[1]), []).append(int(stat.parent.name))
    found, todo = [], [pid]
    while todo:
        found.append(todo.pop())
        todo.extend(children.get(found[-1], []))
    return found


class Cluster:
    """A master and workers with one core each."""

    def __init__(self, folder, workers=2):
        self.url = f"spark://{HOST}:{free_port()}"
        self.folder = folder
        self.home = Path(pyspark.__file__).parent
        port = self.url.rpartition(":")[2]
        self.master = self._start("master", "master.Master", "--host", HOST, "--port", port)
        self._wait(HOST, int(port))
        self.workers = []
        for _ in range(workers):
            self.add_worker()

    def add_worker(self):
        i = len(self.workers)
        worker = self._start(
            f"worker{i}", "worker.Worker", "--host", HOST, "--cores", "1", "--memory", "1g",
            "--work-dir", str(self.folder / f"work{i}"), self.url,
        )  # fmt: skip
        self.workers.append(worker)

    def _start(self, name, kind, *arguments):
        command = [self.home / "bin" / "spark-class", f"org.apache.spark.deploy.{kind}"]
        environment = os.environ | {
            "SPARK_HOME": str(self.home),
            "SPARK_LOCAL_IP": HOST,
            "PYSPARK_PYTHON": sys.executable,
            "SPARK_DAEMON_MEMORY": "256m",
        }
        with open(self.folder / f"{name}.log", "wb") as log:
            return subprocess.Popen(
                [*command, "--webui-port", "0", *arguments],
                env=environment, stdout=log, stderr=subprocess.STDOUT,
            )  # fmt: skip

    @staticmethod
    def _wait(host, port):
        end = time.monotonic() + 60
        while True:
            try:
                socket.create_connection((host, port), timeout=1).close()
                return
            except OSError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.1)

    def kill(self, number):
        """As when its machine dies: the worker, its executor and their Pythons, at once."""
        self._kill(self.workers[number])

    def stop(self):
        for process in [*self.workers, self.master]:
            self._kill(process)

    @staticmethod
    def _kill(process):
        if process.poll() is None:
            for pid in descendants(process.pid):
                try:
                    os.kill(pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass
            process.wait(30)
