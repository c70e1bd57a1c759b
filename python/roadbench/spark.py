"""``roadbench run`` and ``roadbench diagnose`` spread over a Spark cluster.

The driver finds the logs, locks the output and keeps the accounts; each Spark task takes a few
sessions through :mod:`roadbench` and leaves each as one file, whole or not at all. When all are
there the driver takes them into the tables, as a run on one machine does, with the same bytes. A
killed worker, a killed driver or a task that runs twice leaves nothing torn and nothing double: the
same call goes on with what is missing.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Any, cast

from roadbench import _roadbench
from roadbench._archive import batch_options, listed
from roadbench._errors import Invalid, call
from roadbench._types import Path, Paths, Summary

if TYPE_CHECKING:
    import pyarrow as pa
    from pyspark.sql import SparkSession

__all__ = ["diagnose", "run"]

_GIVEN = "log string, task string"
_ANSWERED = "log string, answer string"


def run(
    spark: SparkSession,
    inputs: Paths,
    out: Path,
    *,
    bikes: Path | None = None,
    pipeline: Path = "onroad",
    maps: Paths = (),
    batch: int = 8,
    force: bool = False,
    since: float | None = None,
    signals: bool = False,
    model: Path | None = None,
) -> Summary:
    """Computes the sessions of an archive on the cluster, and writes the tables of ``roadbench run``.

    After ``spark`` the arguments are those of :func:`roadbench.run`, in the same order; ``batch`` stands in the place of
    ``jobs``. Progress is shown by Spark's own page.

    Logs and ``out`` are in an object store (``s3://``, ``gs://``, ``az://``; credentials as for the
    command line, on every machine), or on a file system that the driver and all workers see under
    the same paths; bike files, maps and pipeline are read on the driver only. All machines need this
    wheel.
    As on one machine, sessions that are there already and were made from the same are kept, a log
    that cannot be used has a row in ``rejected``, and a run that was cut short is carried on by the
    same call. Retries are Spark's own (``spark.task.maxFailures``, speculation, lost executors).

    The tables over the whole fleet (``fleet``, ``tyres``, ``bikes``, ...) and the report are made by
    the driver at the end.

    Args:
        spark: the session of an existing cluster, or a local one.
        inputs: logs, folders of logs or archives, glob patterns. Relative paths are made absolute.
        out: folder of the tables.
        bikes: folder of bike files; ``None`` takes the ``bikes`` beside an archive's sessions.
        pipeline: ``onroad``, ``offroad``, ``paper``, or path of a pipeline file.
        maps: paths of channel maps; none means those that come with roadbench.
        batch: sessions in one task: what is done again when a task is lost.
        force: compute sessions again that are there already.
        since: only logs that were written since then, as ``time.time()`` counts.
        signals: also write the estimated time series.
        model: the output of a diagnosis, or one session's model file, read on the driver only: what it identified is
            removed from the recordings.

    Returns:
        What is also in ``run.json`` beside the tables: ``inputs``, ``computed``, ``unchanged``,
        ``rejected``, ``rejected_by_code``, ``seconds`` and so on.

    Raises:
        Invalid: there is nothing to read, the bikes or the pipeline are not what they should be,
            or another run is writing to ``out`` (a ``ValueError``).
        OutputError: ``out`` cannot be written, or is not the same folder on all machines (an ``OSError``).

    Example:
        >>> from pyspark.sql import SparkSession
        >>> import roadbench.spark
        >>> spark = SparkSession.builder.getOrCreate()
        >>> done = roadbench.spark.run(spark, "/archive", "/tables")
        >>> done["computed"], done["rejected"]
        (1200, 3)
    """
    options = _options(inputs, out, bikes, pipeline, maps, force, since)
    options |= {"signals": signals, "model": None if model is None else _absolute(model)}
    return _run(spark, options, batch)


def diagnose(
    spark: SparkSession,
    inputs: Paths,
    out: Path,
    *,
    bikes: Path | None = None,
    pipeline: Path = "onroad",
    maps: Paths = (),
    batch: int = 1,
    force: bool = False,
    since: float | None = None,
    nulls: int = 24,
    advise: bool = False,
) -> Summary:
    """Diagnoses the sessions of an archive on the cluster, and writes what ``roadbench diagnose`` writes.

    What several sessions share is worked out by the driver at the end, with the report.

    Args:
        spark: as for :func:`run`, like all that is not named here.
        nulls: fault-free simulations of each ride, from which the thresholds come; 8 to 1000.
        advise: also simulate riding for every cause that a ride cannot show.

    Returns:
        The same as :func:`run`, but for ``run.json``, which is of runs.

    Raises:
        Invalid: as :func:`run`, or ``nulls`` are too few or too many.
        OutputError: as :func:`run`.
    """
    options = _options(inputs, out, bikes, pipeline, maps, force, since)
    return _run(spark, options | {"diagnose": True, "nulls": nulls, "advise": advise}, batch)


def _options(
    inputs: Paths, out: Path, bikes: Path | None, pipeline: Path, maps: Paths, force: bool, since: float | None
) -> dict[str, Any]:
    there = [_absolute(path) for path in listed(inputs)]
    return batch_options(there, _absolute(out), None if bikes is None else _absolute(bikes), pipeline, maps, force, since)


def _run(spark: SparkSession, options: dict[str, Any], batch: int) -> Summary:
    if batch < 1:
        raise Invalid(f"batch={batch}: a task has at least one session; take 1 or more")
    driver = call(_roadbench.Driver, json.dumps(options))
    try:
        answers = _distribute(spark, call(driver.terms), call(driver.tasks), batch)
        return cast(Summary, json.loads(call(driver.close, answers)))
    finally:
        driver.abandon()  # of the output's lock


def _absolute(path: Path) -> str:
    """A worker has another working folder; a URL is the same everywhere."""
    text = os.fspath(path)
    return text if "://" in text else os.path.abspath(text)


def _distribute(spark: SparkSession, terms: str, tasks: list[tuple[str, str]], batch: int) -> list[str]:
    if not tasks:
        return []
    context = spark.sparkContext
    count = max(-(-len(tasks) // batch), min(len(tasks), context.defaultParallelism))
    # the largest logs come first: every task takes each count-th one, so that tasks are alike
    shares = [tasks[i::count] for i in range(count)]
    # an RDD with a share in each partition: nothing is shuffled, so nothing is lost with a worker
    # but the task it was at
    given = context.parallelize(shares, count).flatMap(list)
    answered = spark.createDataFrame(given, _GIVEN).mapInArrow(partial(_work, terms), _ANSWERED)
    return [row.answer for row in answered.collect()]


def _work(terms: str, batches: Iterable[pa.RecordBatch]) -> Iterator[pa.RecordBatch]:
    """What a Spark task does."""
    import pyarrow as pa

    # a task has one core; a pool of threads per task would fight over it
    os.environ.setdefault("RAYON_NUM_THREADS", "1")
    worker = _roadbench.Worker(terms)
    for given in batches:
        for log, task in zip(given["log"].to_pylist(), given["task"].to_pylist(), strict=True):
            yield pa.RecordBatch.from_pydict({"log": [log], "answer": [worker.run(task)]})
