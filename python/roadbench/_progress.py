"""Progress of ``run`` and ``diagnose``.

The command line logs an event per log, as JSON lines. A call that shows progress has the same command do the work in a
child process, and reads its events: nothing is polled, and the work itself is the same.
"""

from __future__ import annotations

import datetime
import html
import importlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal, NamedTuple, cast

from roadbench._errors import Error, Internal, Invalid, OutputError
from roadbench._roadbench import __version__
from roadbench._types import Summary


class Progress(NamedTuple):
    """How far a run is, after each log."""

    done: int
    """Logs that are through, with those that were there already and those that were rejected."""
    total: int
    """Logs found."""
    session: str
    """The session's id; empty where the log does not say it."""
    log: str
    status: Literal["done", "unchanged", "rejected"]


Listener = Callable[[Progress], None]
Show = bool | Listener | None
_AGAIN = 0.2
"""Least time between two pictures of a bar, s."""


def listener(show: Show) -> Listener | None:
    """Who hears of it; nobody where no progress is to be shown."""
    if callable(show):
        return show
    if show is None:
        return Bar(_notebook) if _in_notebook() else None
    if show:
        return Bar(_notebook if _in_notebook() else _terminal)
    return None


def _in_notebook() -> bool:
    if "IPython" not in sys.modules:
        return False
    shell = sys.modules["IPython"].get_ipython()
    return shell is not None and hasattr(shell, "kernel")


class Bar:
    """A bar that is drawn anew a few times a second."""

    def __init__(self, place: Callable[[], Callable[[Bar], None]]) -> None:
        self._place = place
        self._draw: Callable[[Bar], None] | None = None
        self._drawn = self.began = time.monotonic()
        self.rejected = 0
        self.ended = False
        self.now = Progress(0, 0, "", "", "done")

    def __call__(self, now: Progress) -> None:
        self.now = now
        self.rejected += now.status == "rejected"
        if now.total < 2:
            return  # one log needs no bar
        if self._draw is None:
            self._draw = self._place()
        elif now.done < now.total and time.monotonic() - self._drawn < _AGAIN:
            return
        self._drawn = time.monotonic()
        self._draw(self)

    def end(self) -> None:
        """The run has ended, well or not."""
        self.ended = True
        if self._draw is not None:
            self._draw(self)

    def words(self) -> str:
        """The counts, and how long the rest will take at the same pace."""
        now, spent = self.now, time.monotonic() - self.began
        refused = f", {self.rejected} rejected" if self.rejected else ""
        left = spent / max(now.done, 1) * (now.total - now.done)
        rest = f", {left:.0f} s left" if now.done < now.total else "; tables of the fleet and report"
        return f"{now.done} of {now.total} logs{refused}{f' in {spent:.1f} s' if self.ended else rest}"


def _notebook() -> Callable[[Bar], None]:
    shown = importlib.import_module("IPython.display")
    handle = shown.display(shown.HTML(""), display_id=True)

    def draw(bar: Bar) -> None:
        value = f'<progress max="{bar.now.total}" value="{bar.now.done}"></progress>'
        handle.update(shown.HTML(f"{value} {html.escape(bar.words())}"))

    return draw


def _terminal() -> Callable[[Bar], None]:
    def draw(bar: Bar) -> None:
        filled = 30 * bar.now.done // bar.now.total
        end = "\n" if bar.ended else ""
        print(f"\r[{'=' * filled}{' ' * (30 - filled)}] {bar.words():60}", end=end, file=sys.stderr, flush=True)

    return draw


def watched(command: Literal["run", "diagnose"], options: dict[str, Any], hearer: Listener) -> Summary:
    """The command in a child process; ``hearer`` hears of every log."""
    environment = dict(os.environ)
    environment.pop("ROADBENCH_BIKES", None)  # a function's arguments are all it goes by
    began = datetime.datetime.now(datetime.UTC)
    child = subprocess.Popen(
        _arguments(command, options),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        errors="replace",
        env=environment,
        start_new_session=True,  # Ctrl-C comes to us alone, and we hand it on once
    )
    heard = _Heard(command, hearer)
    try:
        interrupted = _listen(child, heard)
    except BaseException:
        child.kill()  # whole files only, even so: the same call carries on
        child.wait()
        raise
    finally:
        if isinstance(hearer, Bar):
            hearer.end()
    if interrupted:
        raise KeyboardInterrupt
    heard.check(child.returncode)
    return _summary(options["out"], command, began, heard)


def _arguments(command: str, options: dict[str, Any]) -> list[str]:
    given = dict(options)
    inputs, maps, since = given.pop("inputs"), given.pop("maps"), given.pop("since")
    arguments = [sys.executable, "-m", "roadbench", command, "--log-format", "json", "--verbose"]
    for name, value in given.items():
        if value is True:
            arguments.append(f"--{name}")
        elif value is not None and value is not False:
            arguments += [f"--{name}", str(value)]
    arguments += [part for one in maps for part in ("--map", one)]
    if since is not None:
        try:
            moment = datetime.datetime.fromtimestamp(since, datetime.UTC)
        except (ValueError, OverflowError, OSError) as why:
            raise Invalid(f"since: {why}") from None
        arguments += ["--since", moment.strftime("%Y-%m-%dT%H:%M:%S.%fZ")]
    return [*arguments, "--", *inputs]


def _listen(child: subprocess.Popen[str], heard: _Heard) -> bool:
    """Hears the child out; whether Ctrl-C came meanwhile. The sessions under way are finished then."""
    assert child.stderr is not None
    interrupted = False
    while True:
        try:
            for line in child.stderr:
                heard.line(line)
            child.wait()
            return interrupted
        except KeyboardInterrupt:
            if interrupted:
                raise
            interrupted = True
            child.send_signal(signal.SIGINT)


class _Heard:
    """What a child has said."""

    def __init__(self, command: str, hearer: Listener) -> None:
        self._command, self._hearer = command, hearer
        self._total = self._done = 0
        self._words: list[str] = []
        self.codes: dict[str, int] = {}
        self.accounts: dict[str, Any] = {}
        self.requests: dict[str, int] = {}

    def line(self, line: str) -> None:
        """An event; anything else is kept in case that it is all we hear."""
        try:
            event = json.loads(line)
            message = event.get("message", "")
        except (ValueError, AttributeError):
            self._words.append(line.rstrip())
            return
        if event.get("level") == "ERROR":
            self._words.append(message)
        elif message == "planned":
            self._total = event["inputs"]
        elif "status" in event and "log" in event:
            self._finished(event)
        elif message == self._command and "computed" in event:
            self.accounts = event
        elif message == "object stores":
            self.requests = event

    def _finished(self, event: dict[str, Any]) -> None:
        self._done += 1
        if (code := event.get("code")) is not None:
            self.codes[code] = self.codes.get(code, 0) + 1
        self._hearer(Progress(self._done, self._total, event.get("session", ""), event["log"], event["status"]))

    def check(self, code: int) -> None:
        """An error where the command failed; logs that were rejected are none."""
        if self.accounts and code in (0, 1):
            return
        kinds: dict[int, type[Error]] = {2: Invalid, 3: OutputError}
        words = "\n".join(self._words).removeprefix("roadbench: ")
        raise kinds.get(code, Internal)(words or f"roadbench {self._command} ended with exit code {code}")


def _summary(out: str, command: str, began: datetime.datetime, heard: _Heard) -> Summary:
    """As the compiled part gives it: a run's stands in ``run.json``."""
    if command == "run" and "://" not in out:
        return cast(Summary, json.loads((Path(out) / "run.json").read_text(encoding="utf-8")))
    counts = ("inputs", "computed", "unchanged", "rejected", "left", "bytes", "seconds")
    found = {key: heard.accounts[key] for key in counts}
    found |= {"version": __version__, "started": began.isoformat().replace("+00:00", "Z")}
    found["rejected_by_code"] = dict(sorted(heard.codes.items()))
    if heard.requests:
        stores = ("get", "head", "list", "put", "delete", "failed")
        moved = {"bytes_read": heard.requests["read"], "bytes_written": heard.requests["written"]}
        found["requests"] = {key: heard.requests[key] for key in stores} | moved
    return cast(Summary, found)
