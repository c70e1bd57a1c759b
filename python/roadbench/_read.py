"""The tables of an output folder as frames."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from roadbench import _roadbench

Frames = Literal["polars", "pandas", "arrow"]
_LIBRARY = {"polars": "polars", "pandas": "pandas", "arrow": "pyarrow"}
_FINISHING = 10.0
"""Longest that a switch of tables which has begun is waited for, s."""


class NoTable(KeyError):
    """A table that an output does not have."""

    def __str__(self) -> str:
        return str(self.args[0])  # a KeyError would show its repr


def chosen(frames: Frames | None) -> Frames:
    """The library asked for, or the first of polars, pandas and pyarrow that is installed."""
    if frames is not None and frames not in _LIBRARY:
        raise ValueError(f"frames: {frames!r} is none of {', '.join(_LIBRARY)}")
    kinds: Sequence[Frames] = [frames] if frames else ["polars", "pandas", "arrow"]
    for kind in kinds:
        # pandas reads Parquet by pyarrow
        needs = {_LIBRARY[kind], "pyarrow"} if kind == "pandas" else {_LIBRARY[kind]}
        missing = sorted(name for name in needs if importlib.util.find_spec(name) is None)
        if not missing:
            return kind
        if frames:
            raise ImportError(f"frames={frames!r} needs {' and '.join(missing)}: pip install {' '.join(missing)}")
    raise ImportError("reading tables needs polars or pyarrow (for pandas too): pip install polars")


class Tables(Mapping[str, Any]):
    """The tables of an output folder by name, each read when it is asked for: what :func:`roadbench.read` gives.

    Every access reads the files as they are then, while nobody replaces them. In a ``with`` block they
    stay as they are until its end, so that all tables are of one state; a run that has ended waits for it.

    Example:
        >>> tables = roadbench.read("/tables")
        >>> list(tables)
        ['bikes', 'coefficients', 'evidence', ...]
        >>> tables["coefficients"]
        >>> tables.units["coefficients"]["std_error"]
        'as given in the column unit'
        >>> with roadbench.read("/tables") as tables:
        ...     coefficients, sessions = tables["coefficients"], tables["sessions"]
    """

    def __init__(self, out: str | os.PathLike[str], frames: Frames | None = None) -> None:
        self.out = os.fspath(out)
        self.frames = chosen(frames)
        self._folder = _Remote(self.out) if "://" in self.out else _Local(Path(self.out))
        self._held: list[contextlib.ExitStack] = []

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
        return f"<roadbench.Tables {self.out} ({self.frames}): {', '.join(self) or 'none'}>"

    def read(self, name: str, *, columns: Sequence[str] | None = None, session: str | None = None) -> Any:
        """A table, or some of its columns, or the rows of one session.

        Of many sessions one is found without reading the others.

        Raises:
            NoTable: there is no such table (a ``KeyError``); the message says which there are.
        """
        with self._still():
            files = self._files(name)
            columns = None if columns is None else list(columns)
            frame = self._folder.frame(files, self.frames, columns, session)
        if self.frames == "pandas":
            frame.attrs["units"] = self.units[name]
        return frame

    def files(self, name: str) -> list[str]:
        """Paths of a table's files, for instance for ``polars.scan_parquet``."""
        return list(self._files(name))

    def _files(self, name: str) -> list[str]:
        if files := self._folder.files(name):
            return files
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
            return _made(
                self.frames,
                {
                    "column": list(fields),
                    "unit": [f.get("unit") for f in fields.values()],
                    "description": [f.get("description") for f in fields.values()],
                },
            )
        names = list(self)
        return _made(
            self.frames,
            {
                "table": names,
                "files": [len(self.files(name)) for name in names],
                "columns": [len(self._fields(name)) for name in names],
            },
        )

    def _fields(self, name: str) -> dict[str, dict[str, str]]:
        """Metadata of each column, from the first file; without pyarrow those of this version of roadbench."""
        with self._still():
            files = self._files(name)
            if importlib.util.find_spec("pyarrow"):
                found = {}
                for field in self._folder.schema(files[0]):
                    own = {k.decode(): v.decode() for k, v in (field.metadata or {}).items()}
                    found[field.name] = {k: own[k] for k in ("unit", "description") if k in own}
                return found
        schema = _roadbench.schema(name)
        both = {c: {"unit": schema.unit(c), "description": schema.description(c)} for c in schema.names}
        return {c: {k: v for k, v in own.items() if v is not None} for c, own in both.items()}


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


def _made(frames: Frames, columns: dict[str, list[Any]]) -> Any:
    if frames == "polars":
        import polars

        return polars.DataFrame(columns)
    if frames == "pandas":
        import pandas

        return pandas.DataFrame(columns)
    import pyarrow

    return pyarrow.table(columns)


class _Local:
    """A folder here."""

    def __init__(self, out: Path) -> None:
        self.out = out

    def names(self) -> list[str]:
        if not self.out.is_dir():
            raise FileNotFoundError(f"{self.out}: no such folder")
        folders = (folder.name for folder in self.out.iterdir() if folder.is_dir())
        return sorted(name for name in folders if next(self._files(name), None))

    def files(self, name: str) -> list[str]:
        if not self.out.is_dir():
            raise FileNotFoundError(f"{self.out}: no such folder")
        return sorted(map(str, self._files(name)))

    def _files(self, name: str) -> Iterator[Path]:
        if _hidden([name]) or Path(name).name != name:
            return  # what is below .roadbench is not in place yet
        for path in (self.out / name).rglob("*.parquet"):
            if not _hidden(path.relative_to(self.out).parts):
                yield path

    @contextlib.contextmanager
    def still(self) -> Iterator[None]:
        """Meanwhile no command replaces the tables."""
        deadline = time.monotonic() + _FINISHING
        with contextlib.ExitStack() as held:
            while True:
                _lock_shared(held, self.out / ".roadbench" / "tables.lock")
                if not (self.out / ".roadbench" / "next.json").is_file():
                    break
                if time.monotonic() > deadline:
                    warnings.warn(
                        f"{self.out}: a run waits to put its tables in place, or was killed at it (then any next "
                        "command, such as `roadbench report`, carries it on); what is read may be of two states",
                        stacklevel=4,
                    )
                    break
                held.close()  # somebody is about to, and waits for us
                time.sleep(0.02)
            yield

    def frame(self, files: list[str], frames: Frames, columns: list[str] | None, session: str | None) -> Any:
        if frames != "polars":
            return _by_arrow(files, None, frames, columns, session)
        import polars as pl

        rows = pl.scan_parquet(files, hive_partitioning=False)
        if session is not None:
            rows = rows.filter(pl.col("session_id") == session)
        return (rows if columns is None else rows.select(columns)).collect()

    def schema(self, file: str) -> Any:
        import pyarrow.parquet as pq

        return pq.read_schema(file)


class _Remote:
    """A folder in an object store, through pyarrow. There are no locks: each file is whole, but two may be of
    different states while a run ends."""

    def __init__(self, url: str) -> None:
        try:
            from pyarrow import fs
        except ImportError:
            raise ImportError("reading from a URL needs pyarrow: pip install pyarrow") from None
        endpoint = os.environ.get("AWS_ENDPOINT") or os.environ.get("AWS_ENDPOINT_URL")
        if url.startswith("s3://") and endpoint and "?" not in url:
            scheme, _, host = endpoint.rpartition("://")
            url = f"{url}?endpoint_override={host.rstrip('/')}&scheme={scheme or 'https'}"
        self.store, path = fs.FileSystem.from_uri(url)
        self.path = path.rstrip("/")

    def names(self) -> list[str]:
        return sorted(self._tables())

    def files(self, name: str) -> list[str]:
        return sorted(self._tables().get(name, []))

    def _tables(self) -> dict[str, list[str]]:
        from pyarrow import fs

        found: dict[str, list[str]] = {}
        for info in self.store.get_file_info(fs.FileSelector(self.path, recursive=True)):
            parts = info.path.removeprefix(self.path + "/").split("/")
            if info.is_file and len(parts) > 1 and parts[-1].endswith(".parquet") and not _hidden(parts):
                found.setdefault(parts[0], []).append(info.path)
        return found

    def still(self) -> contextlib.AbstractContextManager[None]:
        return contextlib.nullcontext()

    def frame(self, files: list[str], frames: Frames, columns: list[str] | None, session: str | None) -> Any:
        return _by_arrow(files, self.store, frames, columns, session)

    def schema(self, file: str) -> Any:
        import pyarrow.parquet as pq

        return pq.read_schema(file, filesystem=self.store)


def _by_arrow(
    files: list[str], store: Any, frames: Frames, columns: list[str] | None, session: str | None
) -> Any:
    import pyarrow.parquet as pq

    only = None if session is None else [("session_id", "=", session)]
    table = pq.read_table(files, filesystem=store, partitioning=None, columns=columns, filters=only)
    if frames == "arrow":
        return table
    if frames == "pandas":
        return table.to_pandas()
    import polars

    return polars.from_arrow(table)


def _hidden(parts: Sequence[str]) -> bool:
    return any(part.startswith(".") for part in parts)


def _lock_shared(held: contextlib.ExitStack, path: Path) -> None:
    """Waits while somebody replaces the tables, and keeps others from it; nothing where nothing was ever replaced,
    or where the file system knows no locks."""
    try:
        import fcntl
    except ImportError:  # Windows
        return
    try:
        file = held.enter_context(path.open("rb"))
        fcntl.flock(file, fcntl.LOCK_SH)
    except OSError:
        return
