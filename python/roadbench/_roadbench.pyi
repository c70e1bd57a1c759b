"""Types of the compiled part; ``roadbench`` and ``roadbench.spark`` are what to import."""

from collections.abc import Sequence
from os import PathLike
from typing import Any, final

__version__: str

@final
class Table:
    """An Arrow table. Give it to ``pyarrow.table``, ``polars.DataFrame``, DuckDB or whatever else
    takes ``__arrow_c_stream__``: it shares its memory with them."""

    @property
    def name(self) -> str: ...
    @property
    def num_rows(self) -> int: ...
    @property
    def num_columns(self) -> int: ...
    @property
    def column_names(self) -> list[str]: ...
    @property
    def schema(self) -> Schema: ...
    def __len__(self) -> int: ...
    def to_arrow(self) -> Any:
        """As ``pyarrow.Table``."""
    def to_polars(self) -> Any:
        """As ``polars.DataFrame``."""
    def to_pandas(self) -> Any:
        """As ``pandas.DataFrame``."""
    def _repr_html_(self) -> str: ...
    def __arrow_c_schema__(self) -> object: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...

@final
class Schema:
    """A table's columns, with units and descriptions as field metadata. ``pyarrow.schema`` takes
    it."""

    @property
    def names(self) -> list[str]: ...
    def unit(self, column: str) -> str | None:
        """Unit of a column; ``None`` where it has none."""
    def description(self, column: str) -> str | None:
        """What a column means."""
    def former(self, column: str) -> str | None:
        """Name of a column in the table's earlier version; ``None`` where it has kept it."""
    def kind(self, column: str) -> str:
        """Type of a column, as Arrow calls it: ``Utf8``, ``Float64``, ``Int64``, ``Boolean`` or a timestamp."""
    def nullable(self, column: str) -> bool:
        """Whether rows may lack a column."""
    @property
    def version(self) -> int:
        """Version of the table; columns have former names from version 2 on."""
    def __len__(self) -> int: ...
    def __arrow_c_schema__(self) -> object: ...

def run_session(
    path_or_table: Any,
    bike: str | PathLike[str],
    pipeline: str | PathLike[str],
    maps: Sequence[str | PathLike[str]],
    signals: bool,
    session_id: str | None,
) -> dict[str, Table]: ...
def diagnose_session(
    path_or_table: Any,
    bike: str | PathLike[str],
    pipeline: str | PathLike[str],
    maps: Sequence[str | PathLike[str]],
    settings: tuple[int, bool],
    session_id: str | None,
) -> tuple[dict[str, Table], str, str | None]: ...
def run(options: str) -> str: ...
def diagnose(options: str) -> str: ...
def plan(scenario: str, pipeline: str | PathLike[str]) -> str: ...
def compare(
    out: str | PathLike[str], a: str, b: str | None = None, same_tyres: bool = False
) -> Table: ...
def export(options: str) -> str | bytes: ...
def simulate(scenario: str, number: int) -> tuple[dict[str, Table], str, str | None]: ...
def schema(name: str) -> Schema: ...
def main(arguments: Sequence[str]) -> int: ...

@final
class Driver:
    """Plans a batch, holds its output, and keeps the accounts; options, tasks and answers are JSON."""

    def __new__(cls, options: str) -> Driver: ...
    def terms(self) -> str: ...
    def tasks(self) -> list[tuple[str, str]]: ...
    def close(self, answers: Sequence[str]) -> str: ...
    def abandon(self) -> None: ...

@final
class Worker:
    """Computes and writes sessions."""

    def __new__(cls, terms: str) -> Worker: ...
    def run(self, task: str) -> str: ...
