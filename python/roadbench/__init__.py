"""roadbench: motorcycle tyre coefficients, with honest uncertainty, from recorded riding logs.

Tables cross as Arrow, by the PyCapsule interface: whatever takes ``__arrow_c_stream__`` takes them,
and they share its memory.

Example:
    >>> import polars as pl, roadbench
    >>> tables = roadbench.run_session("ride.parquet", bike="bikes/mt07.toml")
    >>> pl.DataFrame(tables["coefficients"]).filter(pl.col("status") == "ok")

On a Spark cluster, over whole archives: :func:`roadbench.spark.run`.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, NamedTuple

from roadbench import _roadbench
from roadbench._errors import Rejected
from roadbench._roadbench import Schema, Table, __version__

__all__ = [
    "Rejected",
    "Schema",
    "Simulated",
    "Table",
    "__version__",
    "run_session",
    "schema",
    "simulate",
]


def run_session(
    path_or_table: Any,
    bike: str | os.PathLike[str],
    pipeline: str | os.PathLike[str] = "onroad",
    maps: Sequence[str | os.PathLike[str]] = (),
    *,
    signals: bool = False,
    session_id: str | None = None,
) -> dict[str, Table]:
    """One session through every stage, as ``roadbench run`` does it; nothing is written.

    The other threads go on meanwhile: the GIL is released.

    Args:
        path_or_table: a log of any format that ``roadbench run`` reads; or a table with the columns
            of ``schema("session")`` that has ``__arrow_c_stream__`` (pyarrow, polars, DuckDB, ...).
            A column without a ``unit`` in its field's metadata is SI. ``session_id``, ``bike_id``,
            ``start_time`` and so on are taken from the schema's metadata.
        bike: path of the bike file, or what such a file says.
        pipeline: ``onroad``, ``offroad``, ``paper``, or path of a pipeline file.
        maps: paths of channel maps; none means those that come with roadbench.
        signals: also give the estimated time series.
        session_id: name of a table that does not name itself.

    Returns:
        Tables by name, with the rows and schemas that ``roadbench run`` writes: ``sessions`` (one
        row), ``coefficients``, ``manoeuvres``, ``warnings``, ``plots``; ``forces`` off-road,
        ``signals`` if asked for. A log that does not name its bike takes the bike file's name. A
        session that came from a table has ``(table)`` as its path, and as its input's hash that of
        its numbers.

    Raises:
        Rejected: the log cannot be used.
        ValueError: the bike, the pipeline or a map is not what it should be.

    Example:
        >>> tables = roadbench.run_session("ride.parquet", bike="bikes/mt07.toml")
        >>> tables["coefficients"]
        <roadbench.Table coefficients: 37 rows, 22 columns>
        >>> coefficients = tables["coefficients"]
        >>> duckdb.sql("select symbol, value, std_error from coefficients where status = 'ok'")
    """
    return _roadbench.run_session(
        path_or_table, bike, os.fspath(pipeline), [os.fspath(m) for m in maps], signals, session_id
    )


class Simulated(NamedTuple):
    """A simulated session."""

    tables: dict[str, Table]
    """``session``: what the logger recorded; ``truth``, ``truth_segments``, ``truth_signals`` or
    ``truth_offroad``: what the scenario's motorcycle gives of it."""
    bike: str
    """What its bike file says."""
    fall: str | None
    """How it fell, if it did; its log ends there."""


def simulate(scenario: str | os.PathLike[str], number: int = 0) -> Simulated:
    """Rides one session of a scenario, with its truth; nothing is written.

    The same session as that of ``roadbench simulate``, number by number.

    Args:
        scenario: a built-in one (``archive``, ``perfect``, ``characterise``, ``motocross``, ...) or
            path of a scenario file.
        number: which of its sessions, from 0; those of a fleet are counted bike by bike.

    Raises:
        ValueError: there is no such scenario or session, or a key of the file is wrong.

    Example:
        >>> ride = roadbench.simulate("perfect")
        >>> tables = roadbench.run_session(ride.tables["session"], ride.bike)
        >>> polars.DataFrame(ride.tables["truth"])
    """
    return Simulated(*_roadbench.simulate(os.fspath(scenario), number))


def schema(name: str) -> Schema:
    """The columns of a table of the contract, with unit and description as field metadata.

    Args:
        name: ``session`` (what goes in), ``coefficients``, ``sessions``, ...

    Raises:
        ValueError: there is no such table; the message lists them.

    Example:
        >>> roadbench.schema("coefficients").unit("n_samples")
        '1'
        >>> pyarrow.schema(roadbench.schema("session")).field("roll").metadata
        {b'unit': b'rad', b'description': b'...'}
    """
    return _roadbench.schema(name)
