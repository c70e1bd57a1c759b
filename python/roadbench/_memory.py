"""Single sessions in memory: nothing is written."""

from __future__ import annotations

import os
from typing import Any, NamedTuple

from roadbench import _roadbench
from roadbench._archive import listed
from roadbench._errors import call
from roadbench._roadbench import Schema, Table
from roadbench._session import Session
from roadbench._types import Path, Paths


def run_session(
    log: Any,
    bike: Path,
    *,
    pipeline: Path = "onroad",
    maps: Paths = (),
    signals: bool = False,
    session_id: str | None = None,
) -> Session:
    """One session through every stage, as ``roadbench run`` does it; nothing is written.

    The other threads go on meanwhile: the GIL is released.

    Args:
        log: path of a log of any format that ``roadbench run`` reads; or a table with the columns
            of ``schema("session")`` that has ``__arrow_c_stream__`` (pyarrow, polars, DuckDB, ...).
            A column without a ``unit`` in its field's metadata is SI. ``session_id``, ``bike_id``,
            ``start_time`` and so on are taken from the schema's metadata.
        bike: path of the bike file, or what such a file says.
        pipeline: ``onroad``, ``offroad``, ``paper``, or path of a pipeline file.
        maps: paths of channel maps; none means those that come with roadbench.
        signals: also give the estimated time series.
        session_id: name of a table that does not name itself.

    Returns:
        A :class:`Session`, a mapping of tables by name, with the rows and schemas that ``roadbench run`` writes:
        ``sessions`` (one row), ``coefficients``, ``evidence``, ``manoeuvres``, ``warnings``, ``plots``, ``tyre_parameters``;
        ``outlying_manoeuvres`` where some are, ``forces`` off-road, ``signals`` if asked for. A log that does not name its bike takes the bike file's name. A
        session that came from a table has ``(table)`` as its path, and as its input's hash that of
        its numbers.

    Raises:
        Rejected: the log cannot be used.
        Invalid: the bike, the pipeline or a map is not what it should be (a ``ValueError``).

    Example:
        >>> session = roadbench.run_session("ride.parquet", bike="bikes/mt07.toml")
        >>> session["coefficients"]
        <roadbench.Table coefficients: 39 rows, 27 columns>
        >>> session.coefficients.filter(polars.col("status") == "ok")
        >>> session.plot()
    """
    tables = call(_roadbench.run_session, log, bike, os.fspath(pipeline), listed(maps), signals, session_id)
    return Session(tables, bike_file=bike)


class Diagnosed(NamedTuple):
    """What ``roadbench diagnose`` finds in a session."""

    tables: dict[str, Table]
    """``causes``, ``discrepancies``, ``diagnoses`` (one row) and, on the road, ``replays`` and ``simulation_errors``."""
    summary: str
    """The verdict in words."""
    model: str | None
    """The extended model, as ``roadbench run --model`` takes it; ``None`` off-road."""


def diagnose_session(
    log: Any,
    bike: Path,
    *,
    pipeline: Path = "onroad",
    maps: Paths = (),
    nulls: int = 24,
    advise: bool = False,
    session_id: str | None = None,
) -> Diagnosed:
    """What the model of one session gets wrong, and why, as ``roadbench diagnose`` finds it; nothing is
    written.

    The other threads go on meanwhile: the GIL is released. A ride takes some tens of seconds.

    Args:
        log, bike, pipeline, maps, session_id: as of :func:`run_session`.
        nulls: fault-free simulations, from which the thresholds come; 8 to 1000.
        advise: also simulate riding for every cause that the ride cannot show.

    Raises:
        Rejected: the log cannot be used, or does not hold what a diagnosis needs.
        Invalid: the bike, the pipeline, a map or ``nulls`` is not what it should be (a ``ValueError``).

    Example:
        >>> found = roadbench.diagnose_session("ride.parquet", bike="bikes/mt07.toml")
        >>> print(found.summary)
        >>> found.tables["causes"].to_polars().filter(polars.col("verdict") == "named")
    """
    settings = (nulls, advise)
    return Diagnosed(
        *call(_roadbench.diagnose_session, log, bike, os.fspath(pipeline), listed(maps), settings, session_id)
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


def simulate(scenario: Path, *, number: int = 0) -> Simulated:
    """Rides one session of a scenario, with its truth; nothing is written.

    The same session as that of ``roadbench simulate``, number by number.

    Args:
        scenario: a built-in one (``archive``, ``perfect``, ``characterise``, ``motocross``, ...) or
            path of a scenario file.
        number: which of its sessions, from 0; those of a fleet are counted bike by bike.

    Raises:
        Invalid: there is no such scenario or session, or a key of the file is wrong (a ``ValueError``).

    Example:
        >>> ride = roadbench.simulate("perfect")
        >>> session = roadbench.run_session(ride.tables["session"], ride.bike)
        >>> ride.tables["truth"].to_polars()
    """
    return Simulated(*call(_roadbench.simulate, os.fspath(scenario), number))


def schema(name: str) -> Schema:
    """The columns of a table of the contract, with unit and description as field metadata.

    Args:
        name: ``session`` (what goes in), ``coefficients``, ``sessions``, ...

    Raises:
        Invalid: there is no such table; the message lists them (a ``ValueError``).

    Example:
        >>> roadbench.schema("coefficients").unit("n_samples")
        '1'
        >>> pyarrow.schema(roadbench.schema("session")).field("roll").metadata
        {b'unit': b'rad', b'description': b'...'}
    """
    return call(_roadbench.schema, name)
