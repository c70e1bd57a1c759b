"""Frames of polars, pandas and pyarrow alike."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from typing import Any, Literal

from roadbench._errors import Invalid, NotInstalled

Frames = Literal["polars", "pandas", "arrow"]
_LIBRARY = {"polars": "polars", "pandas": "pandas", "arrow": "pyarrow"}


def chosen(frames: Frames | None) -> Frames:
    """The library asked for, or the first of polars, pandas and pyarrow that is installed."""
    if frames is not None and frames not in _LIBRARY:
        raise Invalid(f"frames: {frames!r} is none of {', '.join(_LIBRARY)}")
    kinds: Sequence[Frames] = [frames] if frames else ["polars", "pandas", "arrow"]
    for kind in kinds:
        # pandas reads Parquet by pyarrow
        needs = {_LIBRARY[kind], "pyarrow"} if kind == "pandas" else {_LIBRARY[kind]}
        missing = sorted(name for name in needs if importlib.util.find_spec(name) is None)
        if not missing:
            return kind
        if frames:
            raise NotInstalled(f"frames={frames!r} needs {' and '.join(missing)}: pip install {' '.join(missing)}")
    raise NotInstalled("reading tables needs polars or pyarrow (for pandas too): pip install polars")


def made(frames: Frames, columns: dict[str, list[Any]]) -> Any:
    """A frame of columns."""
    if frames == "polars":
        import polars

        return polars.DataFrame(columns)
    if frames == "pandas":
        import pandas

        return pandas.DataFrame(columns)
    import pyarrow

    return pyarrow.table(columns)


def framed(table: Any, frames: Frames | None = None) -> Any:
    """A frame of whatever has ``__arrow_c_stream__``, such as a :class:`roadbench.Table`."""
    kind = chosen(frames)
    if kind == "polars":
        import polars

        return polars.DataFrame(table)
    import pyarrow

    arrow = pyarrow.table(table)
    return arrow if kind == "arrow" else arrow.to_pandas()


def columns(frame: Any) -> dict[str, list[Any]]:
    """Columns of any frame as lists."""
    if hasattr(frame, "collect_schema") and hasattr(frame, "collect"):  # a lazy one
        frame = frame.collect()
    if hasattr(frame, "to_pydict"):  # pyarrow
        return {name: frame[name].to_pylist() for name in frame.column_names}
    if hasattr(frame, "to_dict") and hasattr(frame, "iloc"):  # pandas
        return {name: frame[name].tolist() for name in frame.columns}
    if hasattr(frame, "get_columns"):  # polars
        return {series.name: series.to_list() for series in frame.get_columns()}
    kind: Frames = "arrow" if importlib.util.find_spec("pyarrow") else "polars"
    return columns(framed(frame, kind))  # what run_session gives, DuckDB's, ...


def rows(frame: Any) -> list[dict[str, Any]]:
    """Rows of any frame as dicts; what pandas has as NaN is ``None``."""
    by_name = columns(frame)
    clean = ([None if v != v else v for v in values] for values in by_name.values())
    return [dict(zip(by_name, row, strict=True)) for row in zip(*clean, strict=True)]
