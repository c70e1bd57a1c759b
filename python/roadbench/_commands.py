"""Commands of the command line as functions: what they print comes back, what they refuse is raised."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from typing import Any, NamedTuple

from roadbench._errors import Error

_Path = str | os.PathLike[str]


def _call(*arguments: Any, codes: Sequence[int] = (0,)) -> tuple[int, str]:
    """Exit code and what a command prints; another code than these is an :class:`Error` with its message."""
    command = [sys.executable, "-m", "roadbench", *(os.fspath(a) if isinstance(a, os.PathLike) else str(a) for a in arguments)]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8", check=False)
    if done.returncode not in codes:
        raise Error(done.stderr.strip().removeprefix("roadbench: ") or f"exit code {done.returncode}")
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


def inspect(
    log: _Path,
    *,
    bikes: _Path | None = None,
    maps: Sequence[_Path] = (),
    dbc: Sequence[_Path] = (),
    pipeline: _Path | None = None,
) -> dict[str, Any]:
    """``roadbench inspect``: a log's channels, rates and gaps, what is odd about it, and what it can estimate.

    Args:
        log: a log of any format.
        bikes: folder of bike files; with it units and signs are checked against the motorcycle.
        maps: channel maps; none means those that come with roadbench.
        dbc: CAN databases.
        pipeline: pipeline file.

    Raises:
        Error: the log cannot be read.

    Example:
        >>> [c["channel"] for c in roadbench.inspect("ride.csv")["channels"]]
    """
    options = _options(bikes=bikes, map=list(maps), dbc=list(dbc), pipeline=pipeline)
    return json.loads(_call("inspect", log, "--json", *options)[1])


def map(log: _Path, *, bike: _Path | None = None, dbc: Sequence[_Path] = ()) -> str:
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
    return _call("map", log, *_options(bike=bike, dbc=list(dbc)))[1]


def bike_new(name: str, folder: _Path = "bikes", *, force: bool = False, **given: Any) -> str:
    """``roadbench bike new``: a bike file from class, tyre sizes and weight.

    Args:
        name: the bike id that logs carry.
        folder: folder of bike files.
        force: write over a file that is there.
        given: the options of the command: ``class_`` (``"naked"``), ``model``, ``front`` and ``rear`` (``"120/70ZR17"``),
            ``weight`` (kg), ``scales``, ``lifted``, ``swung_front``, ``swung_rear``, ``set``.

    Returns:
        Path of the file.

    Raises:
        Error: something is missing or contradicts itself.

    Example:
        >>> roadbench.bike_new("mt07", class_="naked", front="120/70ZR17", rear="180/55ZR17", weight=265)
        'bikes/mt07.toml'
    """
    # several numbers of one option stand between commas; `set` may be repeated
    joined = {
        key.rstrip("_"): ",".join(str(v) for v in value) if isinstance(value, list | tuple) and key != "set" else value
        for key, value in given.items()
    }
    options = _options(**joined)
    _call("bike", "new", name, "--out", folder, *_options(force=force), *options)
    return os.path.join(os.fspath(folder), f"{name}.toml")


def report(out: _Path, *, bench: Sequence[str] = ()) -> str:
    """``roadbench report``: the HTML pages again from the tables.

    Args:
        out: the folder that :func:`run` wrote.
        bench: values or points of a tyre bench to show beside the estimates, as on the command line.

    Returns:
        Path of the first page.

    Raises:
        Error: the folder is no output.
    """
    _call("report", out, *_options(bench=list(bench)))
    return os.path.join(os.fspath(out), "report", "index.html")


class Verified(NamedTuple):
    """What :func:`verify` found."""

    #: Whether nothing is damaged, missing or out of date.
    sound: bool
    #: What the command prints.
    text: str


def verify(out: _Path, *, logs: bool = True, mend: bool = False) -> Verified:
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
    out: _Path,
    *,
    sessions: Sequence[str] = (),
    bikes: Sequence[str] = (),
    missing: bool = False,
    dry_run: bool = False,
) -> str:
    """``roadbench forget``: removes sessions from an output; the logs stay.

    Args:
        out: the folder or URL that :func:`run` wrote.
        sessions: ids of sessions.
        bikes: all sessions of these motorcycles.
        missing: every session whose log is not there any more.
        dry_run: only list them.

    Returns:
        What the command prints.

    Raises:
        Error: nothing was asked for, or there is no such session.
    """
    options = _options(session=list(sessions), bike=list(bikes), missing=missing, dry_run=dry_run)
    return _call("forget", out, *options)[1]
