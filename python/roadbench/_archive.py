"""Whole archives: ``run``, ``diagnose``, ``compare``, ``export``; and ``plan``, before there is one."""

from __future__ import annotations

import json
import math
import os
from typing import Any, Literal, cast, overload

from roadbench import _progress, _roadbench
from roadbench._errors import Invalid, call
from roadbench._roadbench import Table
from roadbench._types import CoefficientSet, Format, Path, Paths, Planned, Summary, TextFormat, Tyre


def run(
    inputs: Paths,
    out: Path,
    *,
    bikes: Path | None = None,
    pipeline: Path = "onroad",
    maps: Paths = (),
    jobs: int = 0,
    force: bool = False,
    since: float | None = None,
    signals: bool = False,
    model: Path | None = None,
    progress: _progress.Show = None,
) -> Summary:
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
        progress: a bar: ``True`` shows it, ``None`` only in a notebook, ``False`` never. A function is called with a
            :class:`Progress` after each log.

    Returns:
        What is also in ``run.json`` beside the tables: ``inputs``, ``computed``, ``unchanged``,
        ``rejected``, ``rejected_by_code``, ``seconds`` and so on.

    Raises:
        Invalid: there is nothing to read, an option is not what it should be, or another run is
            writing to ``out`` (a ``ValueError``).
        OutputError: ``out`` cannot be written (an ``OSError``).

    Example:
        >>> roadbench.run("/archive", "/tables")["computed"]
        1200
    """
    options = batch_options(inputs, out, bikes, pipeline, maps, force, since)
    options |= {"jobs": jobs, "signals": signals, "model": None if model is None else os.fspath(model)}
    return _batch("run", options, progress)


def diagnose(
    inputs: Paths,
    out: Path,
    *,
    bikes: Path | None = None,
    pipeline: Path = "onroad",
    maps: Paths = (),
    jobs: int = 0,
    force: bool = False,
    since: float | None = None,
    nulls: int = 24,
    advise: bool = False,
    progress: _progress.Show = None,
) -> Summary:
    """``roadbench diagnose``: what the model of each session of an archive gets wrong, and why.

    Sessions that were diagnosed with the same settings are kept; what several sessions share is worked
    out from all that ``out`` holds. ``out`` may be the folder of :func:`run`.

    Args:
        inputs, out, bikes, pipeline, maps, jobs, force, since, progress: as of :func:`run`.
        nulls: fault-free simulations of each ride, from which the thresholds come; 8 to 1000.
        advise: also simulate riding for every cause that a ride cannot show.

    Returns:
        ``inputs``, ``computed``, ``unchanged``, ``rejected``, ``rejected_by_code``, ``seconds`` and so on.

    Raises:
        Invalid, OutputError: as of :func:`run`.

    Example:
        >>> roadbench.diagnose("/archive", "/tables")["computed"]
        1200
        >>> roadbench.read("/tables", "causes").filter(polars.col("verdict") == "named")
    """
    options = batch_options(inputs, out, bikes, pipeline, maps, force, since)
    return _batch("diagnose", options | {"jobs": jobs, "nulls": nulls, "advise": advise}, progress)


def batch_options(
    inputs: Paths, out: Path, bikes: Path | None, pipeline: Path, maps: Paths, force: bool, since: float | None
) -> dict[str, Any]:
    """What every batch has in common, as the compiled part takes it."""
    if since is not None and not math.isfinite(since):
        raise Invalid(f"since={since} is no moment; give seconds as time.time() counts them")
    return {
        "inputs": listed(inputs),
        "bikes": None if bikes is None else os.fspath(bikes),
        "out": os.fspath(out),
        "pipeline": os.fspath(pipeline),
        "maps": listed(maps),
        "force": force,
        "since": since,
    }


def listed(paths: Paths) -> list[str]:
    """One path or several, as texts."""
    return [os.fspath(p) for p in ([paths] if isinstance(paths, str | os.PathLike) else paths)]


def _batch(command: Literal["run", "diagnose"], options: dict[str, Any], progress: _progress.Show) -> Summary:
    if (hearer := _progress.listener(progress)) is not None:
        return _progress.watched(command, options, hearer)
    native = _roadbench.run if command == "run" else _roadbench.diagnose
    return cast(Summary, json.loads(call(native, json.dumps(options))))


def plan(scenario: Path, *, pipeline: Path = "onroad") -> Planned:
    """What a ride would give of the tyres' side forces and show of the causes that :func:`diagnose` looks for, before it is
    ridden.

    Args:
        scenario: a built-in one (``archive``, ``perfect``, ``paper``, ...) or path of a scenario file; its
            first session is simulated. Scenarios of the nonlinear motorcycle (``slalom``, ...) give side forces only.
        pipeline: ``onroad``, or path of a pipeline file.

    Returns:
        ``scenario``, ``duration`` (s, ``None`` of a scenario of the nonlinear motorcycle), ``side_forces``,
        ``effects`` and ``pairs``: a dict each of the coefficients of the side forces, with the half width of the
        95 % interval over the value as planned and with a slalom (``half_width`` of ``planned`` and ``with_slalom``); of
        the effects, with the smallest size that is identified half of the time (``limit``, in ``unit``; ``None`` where the
        ride does not show it), and of the pairs of effects that the ride can hardly tell apart.

    Raises:
        Invalid: there is no such scenario, or its ride does not hold what a diagnosis needs (a ``ValueError``).

    Example:
        >>> {e["effect"]: e["limit"] for e in roadbench.plan("paper")["effects"]}
    """
    return cast(Planned, json.loads(call(_roadbench.plan, os.fspath(scenario), os.fspath(pipeline))))


def compare(out: Path, a: Path, b: str | None = None, *, same_tyres: bool = False) -> Table:
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
        Invalid: a folder is no output, or a set is empty, is not there, or shares sessions with the other (a ``ValueError``).

    Example:
        >>> roadbench.compare("/tables", "tyre=Sport A", "tyre=Sport B").to_polars()
    """
    return call(_roadbench.compare, os.fspath(out), os.fspath(a), b, same_tyres)


@overload
def export(
    out: Path,
    session: str,
    format: Literal["fmu"],
    *,
    tyre: Tyre,
    bike: str | None = None,
    bikes: Path,
    set: CoefficientSet = "5.2",
    friction: float = 1.0,
    load: float | None = None,
    model: Path | None = None,
) -> bytes: ...
@overload
def export(
    out: Path,
    session: str,
    format: TextFormat,
    *,
    tyre: Tyre | None = None,
    bike: str | None = None,
    bikes: Path | None = None,
    set: CoefficientSet = "5.2",
    friction: float = 1.0,
    load: float | None = None,
    model: Path | None = None,
) -> str: ...
def export(
    out: Path,
    session: str,
    format: Format,
    *,
    tyre: Tyre | None = None,
    bike: str | None = None,
    bikes: Path | None = None,
    set: CoefficientSet = "5.2",
    friction: float = 1.0,
    load: float | None = None,
    model: Path | None = None,
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
        Invalid: the session is not there, or what the format needs is missing (a ``ValueError``).

    Example:
        >>> text = roadbench.export("/tables", "ride_01", "tir", tyre="front", bikes="bikes")
        >>> pathlib.Path("front.tir").write_text(text)
    """
    given = {"tyre": tyre, "bikes": bikes, "set": set, "friction": friction, "load": load, "model": model}
    return exported(out, session, format, bike, given)


def exported(out: Path, session: str, format: Format, bike: str | None, given: dict[str, Any]) -> str | bytes:
    """What :func:`export` gives, whatever the format."""
    paths = {key: None if given[key] is None else os.fspath(given[key]) for key in ("bikes", "model")}
    options = given | paths | {"out": os.fspath(out), "session": session, "bike": bike, "format": format}
    return call(_roadbench.export, json.dumps(options))
