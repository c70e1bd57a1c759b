"""Where an output's files are: a folder here, or one in an object store."""

from __future__ import annotations

import contextlib
import os
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from roadbench._errors import NoOutput, NotInstalled
from roadbench._frames import Frames
from roadbench._versions import Version, by_arrow, by_polars, groups

_FINISHING = 10.0
"""Longest that a switch of tables which has begun is waited for, s."""

Where = Mapping[str, Sequence[str]]
"""Rows that are wanted: texts of a column. A table that has no such column is wanted whole."""


class Folder(Protocol):
    """An output's files."""

    def names(self) -> list[str]:
        """Tables that have a file."""

    def files(self, name: str) -> list[str]:
        """A table's files, in order."""

    def still(self) -> contextlib.AbstractContextManager[None]:
        """Meanwhile no command replaces the tables."""

    def frame(
        self, files: list[str], frames: Frames, columns: list[str] | None, where: Where, lazy: bool, version: Version | None
    ) -> Any:
        """Rows and columns of a table, whatever version of it the files are of."""

    def schema(self, file: str) -> Any:
        """A file's pyarrow schema."""

    def places(self, files: list[str], frames: Frames) -> list[tuple[str, str, str]]:
        """Session, motorcycle and file of each row."""


def folder(out: str) -> Folder:
    """Of a path or a URL."""
    return Remote(out) if "://" in out else Local(Path(out))


class Local:
    """A folder here."""

    def __init__(self, out: Path) -> None:
        self.out = out
        self._index = _Index()

    def _there(self) -> None:
        if not self.out.is_dir():
            raise NoOutput(f"{self.out}: no such folder; name the one that `roadbench.run` wrote")

    def names(self) -> list[str]:
        self._there()
        folders = (folder.name for folder in self.out.iterdir() if folder.is_dir())
        return sorted(name for name in folders if next(self._files(name), None))

    def files(self, name: str) -> list[str]:
        self._there()
        return sorted(map(str, self._files(name)))

    def _files(self, name: str) -> Iterator[Path]:
        if _hidden([name]) or Path(name).name != name:
            return  # what is below .roadbench is not in place yet
        for path in (self.out / name).rglob("*.parquet"):
            if not _hidden(path.relative_to(self.out).parts):
                yield path

    @contextlib.contextmanager
    def still(self) -> Iterator[None]:
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

    def frame(
        self, files: list[str], frames: Frames, columns: list[str] | None, where: Where, lazy: bool, version: Version | None
    ) -> Any:
        if frames != "polars":
            return _by_arrow(files, None, frames, columns, where, version)
        import polars as pl

        def there(file: str) -> dict[str, bool]:
            return {name: kind == pl.Boolean for name, kind in pl.read_parquet_schema(file).items()}

        found = groups(files, version, there)
        rows = by_polars(lambda some: pl.scan_parquet(some, hive_partitioning=False), found, version)
        return _rows(rows, columns, where, lazy)

    def schema(self, file: str) -> Any:
        import pyarrow.parquet as pq

        return pq.read_schema(file)

    def places(self, files: list[str], frames: Frames) -> list[tuple[str, str, str]]:
        stamps = {file: (os.stat(file).st_mtime_ns, os.stat(file).st_size) for file in files}
        return self._index.places(stamps, lambda: _places(files, None) if frames != "polars" else _places_by_polars(files))


class Remote:
    """A folder in an object store, through pyarrow. There are no locks: each file is whole, but two may be of
    different states while a run ends."""

    def __init__(self, url: str) -> None:
        try:
            from pyarrow import fs
        except ImportError as why:
            raise NotInstalled("reading from a URL needs pyarrow: pip install pyarrow") from why
        endpoint = os.environ.get("AWS_ENDPOINT") or os.environ.get("AWS_ENDPOINT_URL")
        if url.startswith("s3://") and endpoint and "?" not in url:
            scheme, _, host = endpoint.rpartition("://")
            url = f"{url}?endpoint_override={host.rstrip('/')}&scheme={scheme or 'https'}"
        self.store, path = fs.FileSystem.from_uri(url)
        self.path = path.rstrip("/")
        self._index = _Index()

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

    def frame(
        self, files: list[str], frames: Frames, columns: list[str] | None, where: Where, lazy: bool, version: Version | None
    ) -> Any:
        if not lazy:
            return _by_arrow(files, self.store, frames, columns, where, version)
        import polars as pl
        import pyarrow.dataset as ds

        def scan(some: list[str]) -> Any:
            return pl.scan_pyarrow_dataset(ds.dataset(some, filesystem=self.store, format="parquet"))

        found = groups(files, version, lambda file: _arrow_columns(file, self.store))
        return _rows(by_polars(scan, found, version), columns, where, lazy)

    def schema(self, file: str) -> Any:
        import pyarrow.parquet as pq

        return pq.read_schema(file, filesystem=self.store)

    def places(self, files: list[str], frames: Frames) -> list[tuple[str, str, str]]:
        found = self.store.get_file_info(files)
        return self._index.places({i.path: (i.mtime_ns, i.size) for i in found}, lambda: _places(files, self.store))


class _Index:
    """Where sessions are, read anew where a file has changed."""

    def __init__(self) -> None:
        self._stamps: Any = None
        self._places: list[tuple[str, str, str]] = []

    def places(self, stamps: Any, read: Callable[[], list[tuple[str, str, str]]]) -> list[tuple[str, str, str]]:
        if stamps != self._stamps:
            self._places, self._stamps = read(), stamps
        return self._places


def _places_by_polars(files: list[str]) -> list[tuple[str, str, str]]:
    import polars as pl

    rows = pl.scan_parquet(files, hive_partitioning=False, include_file_paths="file")
    return rows.select("session_id", "bike_id", "file").collect().rows()


def _rows(rows: Any, columns: list[str] | None, where: Where, lazy: bool) -> Any:
    """Of a lazy frame of polars."""
    import polars as pl

    there = set(rows.collect_schema().names())
    for column, texts in where.items():
        if column in there:
            rows = rows.filter(pl.col(column).is_in(list(texts)))
    rows = rows if columns is None else rows.select(columns)
    return rows if lazy else rows.collect()


def _arrow_columns(file: str, store: Any) -> dict[str, bool]:
    """Whether each column has truth values."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    return {field.name: pa.types.is_boolean(field.type) for field in pq.read_schema(file, filesystem=store)}


def _by_arrow(
    files: list[str], store: Any, frames: Frames, columns: list[str] | None, where: Where, version: Version | None
) -> Any:
    import pyarrow.parquet as pq

    only = None
    if where:
        there = set(pq.read_schema(files[0], filesystem=store).names)
        only = [(column, "in", list(texts)) for column, texts in where.items() if column in there] or None

    def read(some: list[str], wanted: list[str] | None) -> Any:
        return pq.read_table(some, filesystem=store, partitioning=None, columns=wanted, filters=only)

    found = groups(files, version, lambda file: _arrow_columns(file, store))
    table = by_arrow(read, found, version, columns)
    if frames == "arrow":
        return table
    if frames == "pandas":
        return table.to_pandas()
    import polars

    return polars.from_arrow(table)


def _places(files: list[str], store: Any) -> list[tuple[str, str, str]]:
    import pyarrow.dataset as ds

    columns = ["session_id", "bike_id", "__filename"]
    ids = ds.dataset(files, filesystem=store, format="parquet").to_table(columns=columns)
    return list(zip(*(ids[column].to_pylist() for column in columns), strict=True))


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
