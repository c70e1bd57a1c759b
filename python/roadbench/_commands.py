"""Commands of the command line as functions: what they print comes back, what they refuse is raised."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from typing import Any, Literal, NamedTuple, cast

from roadbench._archive import listed
from roadbench._errors import Error, Invalid, OutputError
from roadbench._types import Inspected, InspectedSource, Path, Paths

_KINDS: dict[int, type[Error]] = {2: Invalid, 3: OutputError}
"""By the exit codes of the command line."""


def _call(*arguments: Any, codes: Sequence[int] = (0,)) -> tuple[int, str]:
    """Exit code and what a command prints; another code than these is an :class:`Error` with its message."""
    command = [sys.executable, "-m", "roadbench", *(os.fspath(a) if isinstance(a, os.PathLike) else str(a) for a in arguments)]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8", check=False)
    if done.returncode not in codes:
        words = done.stderr.strip().removeprefix("roadbench: ") or f"exit code {done.returncode}"
        raise _KINDS.get(done.returncode, Error)(words)
    return done.returncode, done.stdout


def _options(**given: Any) -> list[Any]:
    """``name=value`` as ``--name value``; a list repeats it, ``True`` is a switch, ``None`` and ``False`` are nothing."""
    out: list[Any] = []
    for name, value in given.items():
        option = "--" + name.replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            out.append(option)
        else:
            values = value if isinstance(value, list | tuple) else [value]
            for each in values:
                out += [option, each]
    return out


def _several(given: str | Sequence[str]) -> list[str]:
    """One text or several: a text is no list of letters."""
    return [given] if isinstance(given, str) else list(given)


def inspect(
    log: Path,
    *,
    bikes: Path | None = None,
    pipeline: Path | None = None,
    maps: Paths = (),
    dbc: Paths = (),
) -> Inspected | InspectedSource:
    """``roadbench inspect``: a log's channels, rates and gaps, what is odd about it, and what it can estimate.

    Args:
        log: a log of any format.
        bikes: folder of bike files; with it units and signs are checked against the motorcycle.
        pipeline: pipeline file; ``None`` takes the built-in one.
        maps: channel maps; none means those that come with roadbench.
        dbc: CAN databases.

    Returns:
        ``session``, ``channels``, ``warnings``, ``rejected``, ``estimates`` and ``costs``; of a log that no channel map
        fits its own channels and a ``proposed_map``.

    Raises:
        Error: the log cannot be read.

    Example:
        >>> [c["channel"] for c in roadbench.inspect("ride.csv", bikes="bikes")["channels"]]
    """
    options = _options(bikes=bikes, pipeline=pipeline, map=listed(maps), dbc=listed(dbc))
    return cast(Inspected | InspectedSource, json.loads(_call("inspect", log, "--json", *options)[1]))


def map(log: Path, *, bike: Path | None = None, dbc: Paths = ()) -> str:
    """``roadbench map``: the draft of a channel map, from names, units and the motion in the log itself.

    Args:
        log: a log that no map fits.
        bike: bike file, for wheel speeds in km/h.
        dbc: CAN databases.

    Returns:
        The map as TOML; its comments say by which figure each entry was decided.

    Raises:
        Error: the log cannot be read.
    """
    return _call("map", log, *_options(bike=bike, dbc=listed(dbc)))[1]


def bike_new(
    name: str,
    *,
    folder: Path = "bikes",
    force: bool = False,
    class_: Literal["sports", "naked", "touring", "off-road", "scooter", "bicycle", "e-bike"] | None = None,
    model: str | None = None,
    front: str | None = None,
    rear: str | None = None,
    weight: float | None = None,
    scales: tuple[float, float] | None = None,
    lifted: tuple[float, float] | None = None,
    swung_front: tuple[float, float, float] | None = None,
    swung_rear: tuple[float, float, float] | None = None,
    set: Sequence[str] = (),
) -> str:
    """``roadbench bike new``: a bike file from class, tyre sizes and weight.

    Args:
        name: the bike id that logs carry.
        folder: folder of bike files.
        force: write over a file that is there.
        class_: class of the motorcycle.
        model: make and model; a few are known with their data sheets, the others need a class.
        front, rear: tyres as printed: ``"120/70ZR17"``.
        weight: motorcycle and rider in gear, kg.
        scales: loads of front and rear wheel on scales, rider seated, kg.
        lifted: how far the rear axle was lifted, m, and the front wheel's load then, kg.
        swung_front, swung_rear: the wheel swung about a bar inside its rim: mass kg, bar to axle m, period s.
        set: keys of the bike file that you know: ``["cg_height=0.60+-0.02"]``.

    Returns:
        Path of the file.

    Raises:
        Error: something is missing or contradicts itself.

    Example:
        >>> roadbench.bike_new("mt07", class_="naked", front="120/70ZR17", rear="180/55ZR17", weight=265)
        'bikes/mt07.toml'
    """
    given = {"class": class_, "model": model, "front": front, "rear": rear, "weight": weight, "set": list(set)}
    measured = {"scales": scales, "lifted": lifted, "swung_front": swung_front, "swung_rear": swung_rear}
    # several numbers of one option stand between commas
    joined = {key: None if value is None else ",".join(str(v) for v in value) for key, value in measured.items()}
    options = _options(out=folder, force=force, **given, **joined)
    _call("bike", "new", name, *options)
    return os.path.join(os.fspath(folder), f"{name}.toml")


def report(out: Path, *, bench: str | Sequence[str] = ()) -> str:
    """``roadbench report``: the HTML pages again from the tables.

    Args:
        out: the folder that :func:`run` wrote.
        bench: values or points of a tyre bench to show beside the estimates, as on the command line.

    Returns:
        Path of the first page.

    Raises:
        Error: the folder is no output.
    """
    _call("report", out, *_options(bench=_several(bench)))
    return os.path.join(os.fspath(out), "report", "index.html")


class Verified(NamedTuple):
    """What :func:`verify` found."""

    #: Whether nothing is damaged, missing or out of date.
    sound: bool
    #: What the command prints.
    text: str


def verify(out: Path, *, logs: bool = True, mend: bool = False) -> Verified:
    """``roadbench verify``: whether an output is whole.

    Args:
        out: the folder or URL that :func:`run` wrote.
        logs: also read the logs.
        mend: remove damaged tables; the next run computes their sessions again.

    Raises:
        Error: the folder is no output.
    """
    code, text = _call("verify", out, *_options(no_logs=not logs, mend=mend), codes=(0, 1))
    return Verified(code == 0, text)


def forget(
    out: Path,
    *,
    sessions: str | Sequence[str] = (),
    bike: str | Sequence[str] = (),
    missing: bool = False,
    dry_run: bool = False,
) -> str:
    """``roadbench forget``: removes sessions from an output; the logs stay.

    Args:
        out: the folder or URL that :func:`run` wrote.
        sessions: an id or several.
        bike: all sessions of this motorcycle, or of several.
        missing: every session whose log is not there any more.
        dry_run: only list them.

    Returns:
        What the command prints.

    Raises:
        Error: nothing was asked for, or there is no such session.
    """
    options = _options(session=_several(sessions), bike=_several(bike), missing=missing, dry_run=dry_run)
    return _call("forget", out, *options)[1]
