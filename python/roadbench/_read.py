"""The tables of an output folder as frames."""

from __future__ import annotations

import contextlib
import importlib.util
import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, overload

from roadbench import _roadbench, _versions
from roadbench._errors import Invalid, NoTable, call
from roadbench._folders import folder
from roadbench._frames import Frames, chosen, made, rows
from roadbench._select import Selection, selection
from roadbench._session import Session
from roadbench._types import Path


class Tables(Mapping[str, Any]):
    """The tables of an output folder by name, each read when it is asked for: what :func:`roadbench.read` gives.

    Every access reads the files as they are then, while nobody replaces them. In a ``with`` block they
    stay as they are until its end, so that all tables are of one state; a run that has ended waits for it.

    Example:
        >>> tables = roadbench.read("/tables")
        >>> list(tables)
        ['bikes', 'coefficients', 'evidence', ...]
        >>> tables["coefficients"]
        >>> tables.session("ride_01")
        >>> tables.units["coefficients"]["std_error"]
        'as given in the column unit'
        >>> with roadbench.read("/tables") as tables:
        ...     coefficients, sessions = tables["coefficients"], tables["sessions"]
    """

    def __init__(
        self,
        out: Path,
        frames: Frames | None = None,
        *,
        lazy: bool = False,
        sessions: str | Sequence[str] | None = None,
        bike: str | Sequence[str] | None = None,
        former_names: bool = False,
    ) -> None:
        if lazy and frames not in (None, "polars"):
            raise Invalid(f"lazy=True gives polars' lazy frames, not frames={frames!r}; leave one of them out")
        self.out = os.fspath(out)
        self.frames: Frames = chosen("polars" if lazy else frames)
        self.lazy = lazy
        self.former_names = former_names
        self._folder = folder(self.out)
        self._held: list[contextlib.ExitStack] = []
        self._wanted = selection(sessions, bike)
        if self._wanted != Selection():
            with self._still():
                self._wanted.places(self._folder, self.frames)  # an unknown id is refused at once

    def __enter__(self) -> Tables:
        self._held.append(contextlib.ExitStack())
        self._held[-1].enter_context(self._folder.still())
        return self

    def __exit__(self, *_: object) -> None:
        self._held.pop().close()

    def _still(self) -> contextlib.AbstractContextManager[None]:
        return contextlib.nullcontext() if self._held else self._folder.still()

    def __iter__(self) -> Iterator[str]:
        return iter(self._folder.names())

    def __len__(self) -> int:
        return len(self._folder.names())

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and bool(self._folder.files(name))

    def __getitem__(self, name: str) -> Any:
        return self.read(name)

    def __repr__(self) -> str:
        kind = "lazy polars" if self.lazy else self.frames
        return f"<roadbench.Tables {self.out} ({kind}): {', '.join(self) or 'none'}>"

    def read(self, name: str, *, columns: Sequence[str] | None = None, session: str | None = None) -> Any:
        """A table, or some of its columns, or the rows of one session.

        Of many sessions one is found without reading the others.

        Raises:
            NoTable: there is no such table (a ``KeyError``); the message says which there are.
        """
        where = dict(self._wanted.where)
        if session is not None:
            where["session_id"] = [session]
        with self._still():
            files = self._files(name)
            version = _versions.of(name)
            former = {} if version is None or not self.former_names else {old: c for c, old in version.former.items()}
            wanted = None if columns is None else list(dict.fromkeys(former.get(c, c) for c in columns))
            frame = self._folder.frame(files, self.frames, wanted, where, self.lazy, version)
        if version is not None and former:
            frame = _versions.with_former(frame, version, columns)
        if self.frames == "pandas":
            frame.attrs["units"] = self.units[name]
        return frame

    def session(self, id: str, *, bike: str | None = None) -> Session:
        """One session.

        Args:
            id: its id.
            bike: its motorcycle, where two have a session of that name.

        Raises:
            Invalid: there is no such session, or there are two; the message says which (a ``ValueError``).
        """
        bikes = self._wanted.bikes if bike is None else (bike,)
        with self._still():
            found = sorted({p.bike for p in Selection((id,), bikes).places(self._folder, self.frames)})
        if len(found) > 1:
            raise Invalid(f"{' and '.join(found)} have a session `{id}` each; say which with bike={found[0]!r}")
        return self._one(id, found[0])

    def sessions(self) -> list[Session]:
        """All sessions, in order of their start; each reads its tables when it is asked for them."""
        with self._still():
            if "sessions" in self:
                index = self._files("sessions")
                columns = ["session_id", "bike_id", "start_time"]
                frame = self._folder.frame(index, self.frames, columns, self._wanted.where, False, None)
                # a session without a start goes last
                found = sorted(rows(frame), key=lambda r: (r["start_time"] is None, str(r["start_time"]), r["session_id"]))
                keys = [(r["session_id"], r["bike_id"]) for r in found]
            else:
                places = self._wanted.places(self._folder, self.frames)
                keys = sorted({(p.session, p.bike) for p in places})
        return [self._one(session, bike) for session, bike in keys]

    def _one(self, id: str, bike: str) -> Session:
        tables = Tables(self.out, self.frames, lazy=self.lazy, former_names=self.former_names)
        tables._wanted = Selection((id,), (bike,))
        tables._folder, tables._held = self._folder, self._held  # in our `with` block it reads the same state
        return Session(_OfSession(tables), id, bike, out=self.out)

    def files(self, name: str) -> list[str]:
        """Paths of a table's files, for instance for ``polars.scan_parquet``; those that may have what is wanted."""
        with self._still():
            return self._files(name)

    def _files(self, name: str) -> list[str]:
        if files := self._folder.files(name):
            return self._wanted.files(files, self._folder, self.frames)
        tables = list(self)
        there = f"there are {', '.join(tables)}" if tables else "there is none"
        raise NoTable(f"{self.out} has no table `{name}`; {there}")

    @property
    def units(self) -> Mapping[str, dict[str, str]]:
        """Units by table and column, SI if not said otherwise; a column without a unit is left out."""
        return _Metadata(self, "unit")

    @property
    def descriptions(self) -> Mapping[str, dict[str, str]]:
        """What each column means, by table and column."""
        return _Metadata(self, "description")

    def describe(self, name: str | None = None) -> Any:
        """A frame of the columns of a table, with units and descriptions; of the tables where none is named."""
        if name is not None:
            fields = self._fields(name)
            return made(
                self.frames,
                {
                    "column": list(fields),
                    "unit": [f.get("unit") for f in fields.values()],
                    "description": [f.get("description") for f in fields.values()],
                },
            )
        names = list(self)
        return made(
            self.frames,
            {
                "table": names,
                "files": [len(self.files(name)) for name in names],
                "columns": [len(self._fields(name)) for name in names],
            },
        )

    def _fields(self, name: str) -> dict[str, dict[str, str]]:
        """Metadata of each column, from the first file; without pyarrow, and where that is of an earlier version of the
        table, those of this version of roadbench."""
        with self._still():
            files = self._files(name)
            if importlib.util.find_spec("pyarrow"):
                found, kinds = {}, {}
                for field in self._folder.schema(files[0]):
                    own = {k.decode(): v.decode() for k, v in (field.metadata or {}).items()}
                    found[field.name] = {k: own[k] for k in ("unit", "description") if k in own}
                    kinds[field.name] = str(field.type) == "bool"
                if _versions.groups(files[:1], _versions.of(name), lambda _: kinds)[0].is_current:
                    return found
        schema = call(_roadbench.schema, name)
        both = {c: {"unit": schema.unit(c), "description": schema.description(c)} for c in schema.names}
        return {c: {k: v for k, v in own.items() if v is not None} for c, own in both.items()}


class _OfSession(Mapping[str, Any]):
    """Those of an output's tables that have rows of single sessions."""

    def __init__(self, tables: Tables) -> None:
        self.tables = tables

    def _has(self, name: str) -> bool:
        # tables over the whole fleet have no folder per motorcycle
        return any("/bike=" in file.replace("\\", "/") for file in self.tables._folder.files(name))

    def __iter__(self) -> Iterator[str]:
        return (name for name in self.tables if self._has(name))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and self._has(name)

    def __getitem__(self, name: str) -> Any:
        if name not in self:
            raise NoTable(f"a session of {self.tables.out} has no table `{name}`; there are {', '.join(self) or 'none'}")
        return self.tables[name]

    @property
    def units(self) -> Mapping[str, dict[str, str]]:
        return self.tables.units


class _Metadata(Mapping[str, dict[str, str]]):
    """One key of the columns' metadata, by table."""

    def __init__(self, tables: Tables, key: str) -> None:
        self._tables, self._key = tables, key

    def __getitem__(self, name: str) -> dict[str, str]:
        fields = self._tables._fields(name)
        return {column: own[self._key] for column, own in fields.items() if self._key in own}

    def __iter__(self) -> Iterator[str]:
        return iter(self._tables)

    def __len__(self) -> int:
        return len(self._tables)


@overload
def read(
    out: Path,
    table: None = None,
    *,
    frames: Frames | None = None,
    lazy: bool = False,
    sessions: str | Sequence[str] | None = None,
    bike: str | Sequence[str] | None = None,
    former_names: bool = False,
) -> Tables: ...
@overload
def read(
    out: Path,
    table: str,
    *,
    frames: Frames | None = None,
    lazy: bool = False,
    sessions: str | Sequence[str] | None = None,
    bike: str | Sequence[str] | None = None,
    former_names: bool = False,
) -> Any: ...
def read(
    out: Path,
    table: str | None = None,
    *,
    frames: Frames | None = None,
    lazy: bool = False,
    sessions: str | Sequence[str] | None = None,
    bike: str | Sequence[str] | None = None,
    former_names: bool = False,
) -> Any:
    """The tables of an output folder as frames, with their units.

    Runs may write to the folder meanwhile: a table is read as a whole, the earlier or the new one.

    Args:
        out: what :func:`run` or :func:`diagnose` wrote to: a folder, or a URL (``s3://``, ``gs://``) where pyarrow
            is installed.
        table: read this one at once.
        frames: ``polars``, ``pandas`` or ``arrow``; ``None`` takes the first of them that is installed.
        lazy: polars' lazy frames, which read when they are collected, and only what is needed then. Collect them in a
            ``with`` block where a run may end meanwhile.
        sessions: only rows of these; an id or several. Files without them are not opened, but for the table
            ``sessions``, which says where they are.
        bike: only rows of this motorcycle; an id or several. Files of others are not opened.
        former_names: give each renamed column under its former name, too. Scripts that were written for version 1 of a
            table go on with it, for one version of roadbench. Without it columns have the names of today, whatever
            version of roadbench wrote the files.

    Returns:
        The table; or, where none is named, a :class:`Tables`: a mapping that reads a table when it is asked for,
        with ``.session(id)``, ``.sessions()``, ``.units``, ``.descriptions`` and ``.describe()``. Motorcycle and session
        are the columns ``bike_id`` and ``session_id``; a pandas frame has its units in ``.attrs["units"]``, a pyarrow
        table in its fields' metadata. A table that has no such column is not narrowed by it: tables over the whole fleet
        are those of all sessions.

    Raises:
        NoTable: there is no such table (a ``KeyError``); the message says which there are.
        NoOutput: there is no such folder (a ``FileNotFoundError``).
        Invalid: there is no such session or motorcycle; the message says which is like it (a ``ValueError``).
        NotInstalled: the library that was asked for is not installed (an ``ImportError``).

    Example:
        >>> tables = roadbench.read("/tables")
        >>> tables["coefficients"].filter(polars.col("status") == "ok")
        >>> tables.units["sessions"]["duration"]
        's'
        >>> tables.describe("coefficients")
        >>> roadbench.read("/tables", "manoeuvres", frames="pandas")
        >>> roadbench.read("/tables", "signals", lazy=True, sessions="ride_01").select("time", "roll").collect()
    """
    tables = Tables(out, frames, lazy=lazy, sessions=sessions, bike=bike, former_names=former_names)
    return tables if table is None else tables[table]
