"""roadbench: motorcycle tyre coefficients, with honest uncertainty, from recorded riding logs.

Tables cross as Arrow, by the PyCapsule interface: whatever takes ``__arrow_c_stream__`` takes them,
and they share its memory.

Example:
    >>> import polars as pl, roadbench
    >>> tables = roadbench.run_session("ride.parquet", bike="bikes/mt07.toml")
    >>> pl.DataFrame(tables["coefficients"]).filter(pl.col("status") == "ok")

Over whole archives: :func:`run` and :func:`diagnose`; on a Spark cluster :func:`roadbench.spark.run`. Their
tables as frames: :func:`read`; a session as a figure: :func:`plot`.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, overload

from roadbench import _plot, _roadbench
from roadbench._commands import Verified, bike_new, forget, inspect, map, report, verify
from roadbench._errors import Error, Rejected
from roadbench._read import Frames, NoTable, Tables
from roadbench._roadbench import Schema, Table, __version__

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "Diagnosed",
    "Error",
    "NoTable",
    "Rejected",
    "Schema",
    "Simulated",
    "Table",
    "Tables",
    "Verified",
    "__version__",
    "bike_new",
    "compare",
    "diagnose",
    "diagnose_session",
    "export",
    "forget",
    "inspect",
    "map",
    "plan",
    "plot",
    "read",
    "report",
    "run",
    "run_session",
    "schema",
    "simulate",
    "verify",
]

_Path = str | os.PathLike[str]


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


class Diagnosed(NamedTuple):
    """What ``roadbench diagnose`` finds in a session."""

    tables: dict[str, Table]
    """``causes``, ``discrepancies``, ``diagnoses`` (one row) and, on the road, ``replays`` and ``simulation_errors``."""
    summary: str
    """The verdict in words."""
    model: str | None
    """The extended model, as ``roadbench run --model`` takes it; ``None`` off-road."""


def diagnose_session(
    path_or_table: Any,
    bike: _Path,
    pipeline: _Path = "onroad",
    maps: Sequence[_Path] = (),
    *,
    nulls: int = 24,
    advise: bool = False,
    session_id: str | None = None,
) -> Diagnosed:
    """What the model of one session gets wrong, and why, as ``roadbench diagnose`` finds it; nothing is
    written.

    The other threads go on meanwhile: the GIL is released. A ride takes some tens of seconds.

    Args:
        path_or_table: as of :func:`run_session`.
        bike: path of the bike file, or what such a file says.
        pipeline: ``onroad``, ``offroad``, ``paper``, or path of a pipeline file.
        maps: paths of channel maps; none means those that come with roadbench.
        nulls: simulated nulls, from which the thresholds come; 8 to 1000.
        advise: also simulate riding for every cause that the ride cannot show.
        session_id: name of a table that does not name itself.

    Raises:
        Rejected: the log cannot be used, or does not hold what a diagnosis needs.
        ValueError: the bike, the pipeline, a map or ``nulls`` is not what it should be.

    Example:
        >>> found = roadbench.diagnose_session("ride.parquet", bike="bikes/mt07.toml")
        >>> print(found.summary)
        >>> polars.DataFrame(found.tables["causes"]).filter(polars.col("verdict") == "named")
    """
    given = [os.fspath(m) for m in maps]
    return Diagnosed(
        *_roadbench.diagnose_session(
            path_or_table, bike, os.fspath(pipeline), given, (nulls, advise), session_id
        )
    )


def run(
    inputs: _Path | Sequence[_Path],
    out: _Path,
    bikes: _Path | None = None,
    pipeline: _Path = "onroad",
    *,
    maps: Sequence[_Path] = (),
    jobs: int = 0,
    force: bool = False,
    since: float | None = None,
    signals: bool = False,
    model: _Path | None = None,
) -> dict[str, Any]:
    """``roadbench run``: the sessions of an archive into tables and a report.

    Sessions that ``out`` holds already and that were made from the same are kept. After Ctrl-C the
    sessions under way are finished; the same call carries on.

    Args:
        inputs: logs, folders of logs or archives, glob patterns; here or in an object store.
        out: folder or URL of the tables.
        bikes: folder of bike files; ``None`` takes the ``bikes`` beside an archive's sessions.
        pipeline: ``onroad``, ``offroad``, ``paper``, or path of a pipeline file.
        maps: paths of channel maps; none means those that come with roadbench.
        jobs: sessions that are worked on at the same time; 0 takes one per core.
        force: compute sessions again that are there already.
        since: only logs that were written since then, as ``time.time()`` counts.
        signals: also write the estimated time series.
        model: the output of :func:`diagnose`, or one session's model file: what it identified is removed from the
            recordings.

    Returns:
        What is also in ``run.json`` beside the tables: ``inputs``, ``computed``, ``unchanged``,
        ``rejected``, ``rejected_by_code``, ``seconds`` and so on.

    Raises:
        ValueError: there is nothing to read, an option is not what it should be, or another run is
            writing to ``out``.
        OSError: ``out`` cannot be written.

    Example:
        >>> roadbench.run("/archive", "/tables")["computed"]
        1200
    """
    options = _batch(inputs, out, bikes, pipeline, maps, jobs, force, since)
    return json.loads(_roadbench.run(json.dumps(options | {"signals": signals, "model": None if model is None else os.fspath(model)})))


def diagnose(
    inputs: _Path | Sequence[_Path],
    out: _Path,
    bikes: _Path | None = None,
    pipeline: _Path = "onroad",
    *,
    maps: Sequence[_Path] = (),
    jobs: int = 0,
    force: bool = False,
    since: float | None = None,
    nulls: int = 24,
    advise: bool = False,
) -> dict[str, Any]:
    """``roadbench diagnose``: what the model of each session of an archive gets wrong, and why.

    Sessions that were diagnosed with the same settings are kept; what several sessions share is worked
    out from all that ``out`` holds. ``out`` may be the folder of :func:`run`.

    Args:
        inputs, out, bikes, pipeline, maps, jobs, force, since: as of :func:`run`.
        nulls: simulated nulls of each ride, from which the thresholds come; 8 to 1000.
        advise: also simulate riding for every cause that a ride cannot show.

    Returns:
        ``inputs``, ``computed``, ``unchanged``, ``rejected``, ``rejected_by_code``, ``seconds`` and so on.

    Raises:
        ValueError, OSError: as of :func:`run`.

    Example:
        >>> roadbench.diagnose("/archive", "/tables")["computed"]
        1200
        >>> polars.read_parquet("/tables/causes/**/*.parquet").filter(polars.col("verdict") == "named")
    """
    options = _batch(inputs, out, bikes, pipeline, maps, jobs, force, since)
    return json.loads(_roadbench.diagnose(json.dumps(options | {"nulls": nulls, "advise": advise})))


def _batch(
    inputs: _Path | Sequence[_Path],
    out: _Path,
    bikes: _Path | None,
    pipeline: _Path,
    maps: Sequence[_Path],
    jobs: int,
    force: bool,
    since: float | None,
) -> dict[str, Any]:
    """What ``run`` and ``diagnose`` have in common, as the compiled part takes it."""
    if isinstance(inputs, str | os.PathLike):
        inputs = [inputs]
    return {
        "inputs": [os.fspath(i) for i in inputs],
        "bikes": None if bikes is None else os.fspath(bikes),
        "out": os.fspath(out),
        "pipeline": os.fspath(pipeline),
        "maps": [os.fspath(m) for m in maps],
        "jobs": jobs,
        "force": force,
        "since": since,
    }


def plan(scenario: _Path, pipeline: _Path = "onroad") -> dict[str, Any]:
    """What a ride would give of the tyres' side forces and show of the causes that :func:`diagnose` looks for, before it is
    ridden.

    Args:
        scenario: a built-in one (``archive``, ``perfect``, ``paper``, ...) or path of a scenario file; its
            first session is simulated. Scenarios of the nonlinear motorcycle (``slalom``, ...) give side forces only.
        pipeline: ``onroad``, or path of a pipeline file.

    Returns:
        ``scenario``, ``duration`` (s, ``None`` of a scenario of the nonlinear motorcycle), ``side_forces``,
        ``effects`` and ``pairs``: a dict each of the coefficients of the side forces, with the half width of the
        95 % interval over the value as planned and with a slalom (``half_width`` of ``planned`` and ``with_slalom``); of the effects, with the
        smallest size that is named half of the time (``limit``, in ``unit``; ``None`` where the ride does
        not show it), and of the pairs of effects that the ride can hardly tell apart.

    Raises:
        ValueError: there is no such scenario, or its ride does not hold what a diagnosis needs.

    Example:
        >>> {e["effect"]: e["limit"] for e in roadbench.plan("paper")["effects"]}
    """
    return json.loads(_roadbench.plan(os.fspath(scenario), os.fspath(pipeline)))


def compare(out: _Path, a: _Path, b: str | None = None, *, same_tyres: bool = False) -> Table:
    """``roadbench compare``: how much two sets of sessions differ, coefficient by coefficient.

    Errors that both sides share (bike file, sensors and model of one motorcycle) cancel; the spread between sessions does not.

    Args:
        out: the folder that :func:`run` wrote.
        a: sessions of side A, as on the command line: ids, ``tyre=``, ``front=``, ``rear=``, ``bike=``, ``rider=``,
            ``site=``, days such as ``2026-05-01..2026-05-03``, parted by commas, or ``others``. Without ``b``, the folder of
            a second output that ``out`` is compared with.
        b: sessions of side B.
        same_tyres: tyres whose model no log gives are one on both sides; else they count as two.

    Returns:
        Table ``comparison``: one row per tyre and coefficient, with the values of both sides, the difference, its interval and
        the verdict.

    Raises:
        ValueError: a folder is no output, or a set is empty, is not there, or shares sessions with the other.

    Example:
        >>> polars.DataFrame(roadbench.compare("/tables", "tyre=Sport A", "tyre=Sport B"))
    """
    return _roadbench.compare(os.fspath(out), os.fspath(a), b, same_tyres)


@overload
def export(
    out: _Path,
    session: str,
    format: Literal["fmu"],
    *,
    tyre: Literal["front", "rear"],
    bikes: _Path,
    bike: str | None = None,
    friction: float = 1.0,
    model: _Path | None = None,
) -> bytes: ...
@overload
def export(
    out: _Path,
    session: str,
    format: Literal["tir", "toml", "csv", "c", "tydex", "simulator"],
    *,
    tyre: Literal["front", "rear"] | None = None,
    bike: str | None = None,
    bikes: _Path | None = None,
    set: Literal["5.2", "6.2", "reduced"] = "5.2",
    friction: float = 1.0,
    load: float | None = None,
    model: _Path | None = None,
) -> str: ...
def export(
    out: _Path,
    session: str,
    format: Literal["tir", "toml", "csv", "c", "fmu", "tydex", "simulator"],
    *,
    tyre: Literal["front", "rear"] | None = None,
    bike: str | None = None,
    bikes: _Path | None = None,
    set: Literal["5.2", "6.2", "reduced"] = "5.2",
    friction: float = 1.0,
    load: float | None = None,
    model: _Path | None = None,
) -> str | bytes:
    """A session's fitted tyres as a file for other programs, as ``roadbench export`` writes it: its text, or its
    bytes where it is an ``fmu``.

    Args:
        out: the folder that :func:`run` wrote.
        session: the session's id.
        format: ``tir`` (Magic Formula property file), ``toml`` (coefficients with intervals), ``csv``
            (look-up tables), ``c`` (a C99 header), ``fmu`` (a simulation unit of FMI 3.0), ``tydex`` (as a bench
            would measure it) or ``simulator`` (as ``roadbench simulate`` takes it).
        tyre: which tyre; ``toml``, ``csv`` and ``c`` hold both where it is ``None``, the others one.
        bike: the session's bike, where two bikes have a session of that name.
        bikes: folder of bike files, for what no ride gives; all but ``tir``, ``toml`` and ``csv`` need it.
        set: which set of coefficients a ``tir`` file has.
        friction: road friction of the ride.
        load: nominal load of a ``tir`` file and of the combined ``csv`` table instead of the bike's static one, N.
        model: output of a diagnosis, or one session's model: what it found of the tyres is added to them.

    Raises:
        ValueError: the session is not there, or what the format needs is missing.

    Example:
        >>> text = roadbench.export("/tables", "ride_01", "tir", tyre="front", bikes="bikes")
        >>> pathlib.Path("front.tir").write_text(text)
    """
    options = {
        "out": os.fspath(out),
        "session": session,
        "bike": bike,
        "format": format,
        "tyre": tyre,
        "bikes": None if bikes is None else os.fspath(bikes),
        "set": set,
        "model": None if model is None else os.fspath(model),
        "friction": friction,
        "load": load,
    }
    return _roadbench.export(json.dumps(options))


@overload
def read(out: _Path, table: None = None, *, frames: Frames | None = None) -> Tables: ...
@overload
def read(out: _Path, table: str, *, frames: Frames | None = None) -> Any: ...
def read(out: _Path, table: str | None = None, *, frames: Frames | None = None) -> Any:
    """The tables of an output folder as frames, with their units.

    Runs may write to the folder meanwhile: a table is read as a whole, of before or of after.

    Args:
        out: what :func:`run` or :func:`diagnose` wrote to: a folder, or a URL (``s3://``, ``gs://``) where pyarrow
            is installed.
        table: read this one at once.
        frames: ``polars``, ``pandas`` or ``arrow``; ``None`` takes the first of them that is installed.

    Returns:
        The table; or, where none is named, a :class:`Tables`: a mapping that reads a table when it is asked for,
        with ``.units``, ``.descriptions`` and ``.describe()``. Motorcycle and session are the columns ``bike_id`` and
        ``session_id``; a pandas frame has its units in ``.attrs["units"]``, a pyarrow table in its fields' metadata.

    Raises:
        NoTable: there is no such table (a ``KeyError``); the message says which there are.
        FileNotFoundError: there is no such folder.
        ImportError: the library that was asked for is not installed.

    Example:
        >>> tables = roadbench.read("/tables")
        >>> tables["coefficients"].filter(polars.col("status") == "ok")
        >>> tables.units["sessions"]["duration"]
        's'
        >>> tables.describe("coefficients")
        >>> roadbench.read("/tables", "manoeuvres", frames="pandas")
    """
    tables = Tables(out, frames)
    return tables if table is None else tables[table]


def plot(
    source: _Path | Tables | Mapping[str, Any],
    session: str | None = None,
    *,
    bike: str | None = None,
    plots: str | Sequence[str] | None = None,
    figure: Figure | None = None,
) -> Figure:
    """A session as a matplotlib figure, with what its page of the report shows.

    Args:
        source: the folder that :func:`run` wrote, what :func:`read` gives of it, or the tables of
            :func:`run_session`.
        session: the session's id; not needed where there is only one.
        bike: its motorcycle, where two have a session of that name.
        plots: names in the table ``plots``, such as ``friction_x_front``, ``slip_angle_rear`` or ``timeline``; ``None``
            draws friction over slip and over camber, stiffness over camber, coast-down, g-g diagram and time line.
        figure: draw into this one, for instance of ``pyplot.figure()``; else a new one is made, which belongs to no
            window: notebooks show it, ``figure.savefig("ride.png")`` writes it.

    Raises:
        ImportError: matplotlib is not installed (``pip install roadbench[plot]``).
        ValueError: there is no such session or plot; the message says which there are.

    Example:
        >>> roadbench.plot("/tables", "ride_01").savefig("ride_01.png")
        >>> roadbench.plot(roadbench.run_session("ride.parquet", bike="bikes/mt07.toml"), plots="stiffness_rear")
    """
    return _plot.draw(source, session, bike, plots, figure)


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
