"""Files of a table's earlier version, under the names and types of this one."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from roadbench import _roadbench

_BOOL = "Boolean"


class Version(NamedTuple):
    """A table of this roadbench."""

    kinds: dict[str, str]
    """Type by column, as Arrow calls it, in order."""
    required: frozenset[str]
    """Columns that every row has."""
    former: dict[str, str]
    """Former name by column."""


class Group(NamedTuple):
    """Files of one version, and how they become this one's."""

    files: list[str]
    renamed: dict[str, str]
    """Name by former name."""
    bools: list[str]
    """Columns that were numbers, by their name."""
    missing: list[str]
    """Columns that they have not."""

    @property
    def is_current(self) -> bool:
        return not (self.renamed or self.bools or self.missing)


@functools.cache
def of(name: str) -> Version | None:
    """The table of that name, where it has had an earlier version."""
    try:
        schema = _roadbench.schema(name)
    except ValueError:
        return None  # of another program, or a folder of simulated truth
    if schema.version < 2:
        return None
    former = {column: old for column in schema.names if (old := schema.former(column)) is not None}
    kinds = {column: schema.kind(column) for column in schema.names}
    return Version(kinds, frozenset(c for c in schema.names if not schema.nullable(c)), former)


def groups(files: Sequence[str], version: Version | None, columns: Callable[[str], Mapping[str, bool]]) -> list[Group]:
    """Files by what is to be done with them. ``columns`` says of a file's columns whether they are truth values."""
    if version is None:
        return [Group(list(files), {}, [], [])]
    found: dict[tuple[Any, ...], Group] = {}
    for file in files:
        there = columns(file)
        renamed = {old: new for new, old in version.former.items() if old in there and new not in there}
        kept = {renamed.get(column, column): is_bool for column, is_bool in there.items()}
        group = Group([], {}, [], [])
        if version.required <= kept.keys():  # else it is another table in a folder of that name
            bools = [c for c, kind in version.kinds.items() if kind == _BOOL and not kept.get(c, True)]
            group = Group([], renamed, bools, [c for c in version.kinds if c not in kept])
        key = (tuple(group.renamed), tuple(group.bools), tuple(group.missing))
        found.setdefault(key, group).files.append(file)
    return list(found.values())


def by_polars(scan: Callable[[list[str]], Any], groups: Sequence[Group], version: Version | None) -> Any:
    """Lazy rows of all groups, as polars scans them."""
    import polars as pl

    types = {"Utf8": pl.String, "Float64": pl.Float64, "Int64": pl.Int64, _BOOL: pl.Boolean}

    def rows(group: Group) -> Any:
        if version is None or group.is_current:
            return scan(group.files)
        own = scan(group.files).rename(group.renamed)
        missing = [pl.lit(None, types.get(version.kinds[c], pl.Datetime("us", "UTC"))).alias(c) for c in group.missing]
        own = own.with_columns([pl.col(c).cast(pl.Boolean) for c in group.bools] + missing)
        return own.select(list(version.kinds))

    frames = [rows(group) for group in groups]
    return frames[0] if len(frames) == 1 else pl.concat(frames, how="diagonal_relaxed")


def by_arrow(read: Callable[[list[str], list[str] | None], Any], groups: Sequence[Group], version: Version | None,
             columns: list[str] | None) -> Any:  # fmt: skip
    """Rows of all groups as pyarrow reads them; ``read`` is given files and the columns that are wanted of them."""
    import pyarrow as pa

    types = {"Utf8": pa.string(), "Float64": pa.float64(), "Int64": pa.int64(), _BOOL: pa.bool_()}

    def rows(group: Group) -> Any:
        if version is None or group.is_current:
            return read(group.files, columns)
        former = {new: old for old, new in group.renamed.items()}
        wanted = list(version.kinds) if columns is None else columns
        own = read(group.files, [former.get(c, c) for c in wanted if c not in group.missing])
        own = own.rename_columns([group.renamed.get(c, c) for c in own.column_names])
        for column in group.bools:
            if column in own.column_names:
                place = own.column_names.index(column)
                own = own.set_column(place, column, own[column].cast(pa.bool_()))
        for column in (c for c in wanted if c in group.missing):
            kind = types.get(version.kinds[column], pa.timestamp("us", tz="UTC"))
            own = own.append_column(column, pa.nulls(own.num_rows, kind))
        return own.select(wanted)

    tables = [rows(group) for group in groups]
    return tables[0] if len(tables) == 1 else pa.concat_tables(tables, promote_options="default")


def with_former(frame: Any, version: Version, columns: Sequence[str] | None) -> Any:
    """A frame of any library with each renamed column under its former name, too; or the ``columns`` of it alone."""
    if hasattr(frame, "collect"):  # a lazy one
        names = frame.collect_schema().names()
    else:
        names = list(getattr(frame, "column_names", frame.columns))
    copies = {old: new for new, old in version.former.items() if new in names and old not in names}
    if hasattr(frame, "append_column"):  # pyarrow
        for old, new in copies.items():
            frame = frame.append_column(frame.schema.field(new).with_name(old), frame[new])
        return frame if columns is None else frame.select(list(columns))
    if hasattr(frame, "assign"):  # pandas
        frame = frame.assign(**{old: frame[new] for old, new in copies.items()})
        return frame if columns is None else frame[list(columns)]
    import polars as pl

    frame = frame.with_columns([pl.col(new).alias(old) for old, new in copies.items()])
    return frame if columns is None else frame.select(list(columns))
