"""One session: its tables, and what is done with them."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path as _File
from typing import TYPE_CHECKING, Any, Literal, cast, overload
from urllib.parse import quote

from roadbench import _archive, _html
from roadbench._errors import Invalid, NotInstalled, NoTable
from roadbench._frames import Frames, framed, rows
from roadbench._roadbench import Table
from roadbench._types import CoefficientSet, Format, Path, TextFormat, Tyre

if TYPE_CHECKING:
    import altair
    from matplotlib.figure import Figure


class Session(Mapping[str, Any]):
    """One session of :func:`roadbench.run_session`, or of ``roadbench.read(out).session("ride_01")``.

    It is a mapping of its tables by name. Of :func:`run_session` they are a :class:`Table` each; of an output they are
    frames, as :func:`roadbench.read` gives them, and read when they are asked for. In a notebook it shows what was found.

    Example:
        >>> session = roadbench.run_session("ride.parquet", bike="bikes/mt07.toml")
        >>> session
        <roadbench.Session ride of mt07: 21 of 39 coefficients ok, 1 warning>
        >>> session.coefficients.filter(polars.col("status") == "ok")
        >>> session.plot("stiffness_rear")
        >>> session.export("tir", tyre="rear")
    """

    def __init__(
        self, tables: Mapping[str, Any], id: str | None = None, bike: str | None = None,
        *, out: str | None = None, bike_file: Path | None = None,
    ) -> None:  # fmt: skip
        self._tables, self._id, self._bike = tables, id, bike
        self._out, self._bike_file = out, bike_file
        self._info: dict[str, Any] | None = None

    def __eq__(self, other: object) -> bool:
        return self is other  # a mapping would compare frame by frame

    def __hash__(self) -> int:
        return id(self)

    def __getitem__(self, name: str) -> Any:
        if name in self._tables:
            return self._tables[name]
        raise NoTable(f"the session {self.id} has no table `{name}`; there are {', '.join(self)}")

    def __iter__(self) -> Iterator[str]:
        return iter(self._tables)

    def __len__(self) -> int:
        return len(self._tables)

    @property
    def id(self) -> str:
        """The session's id."""
        return str(self.info["session_id"]) if self._id is None else self._id

    @property
    def bike(self) -> str:
        """Id of its motorcycle."""
        return str(self.info["bike_id"]) if self._bike is None else self._bike

    @property
    def info(self) -> dict[str, Any]:
        """Its row of the table ``sessions``: when, how long, which tyres, how much was found."""
        if self._info is None:
            found = rows(self["sessions"])
            if len(found) != 1:
                raise Invalid(f"the table `sessions` has {len(found)} rows of the session {self._id}; run again over its log")
            self._info = found[0]
        return dict(self._info)

    @property
    def coefficients(self) -> Any:
        """The table ``coefficients`` as a frame."""
        return self.frame("coefficients")

    @property
    def manoeuvres(self) -> Any:
        """The table ``manoeuvres`` as a frame."""
        return self.frame("manoeuvres")

    @property
    def warnings(self) -> Any:
        """The table ``warnings`` as a frame."""
        return self.frame("warnings")

    def frame(self, name: str, frames: Frames | None = None) -> Any:
        """A table as a frame.

        Args:
            name: of the table.
            frames: ``polars``, ``pandas`` or ``arrow``; ``None`` takes what :func:`roadbench.read` was given, else the
                first that is installed.
        """
        table = self[name]
        if frames is None and not isinstance(table, Table):
            return table
        if hasattr(table, "collect") and not hasattr(table, "get_columns"):
            table = table.collect()  # a lazy one
        return framed(table, frames)

    @property
    def units(self) -> Mapping[str, dict[str, str]]:
        """Units by table and column, SI if not said otherwise; a column without a unit is left out."""
        if (units := getattr(self._tables, "units", None)) is not None:
            return cast(Mapping[str, dict[str, str]], units)
        schemas = {name: table.schema for name, table in self.items()}
        pairs = {name: [(c, schema.unit(c)) for c in schema.names] for name, schema in schemas.items()}
        return {name: {column: unit for column, unit in each if unit is not None} for name, each in pairs.items()}

    def plot(self, plots: str | Sequence[str] | None = None, *, figure: Figure | None = None) -> Figure:
        """As a matplotlib figure; see :func:`roadbench.plot`."""
        from roadbench import _plot  # which knows of sessions itself

        return _plot.plot(self, plots=plots, figure=figure)

    def chart(self, plots: str | Sequence[str] | None = None) -> altair.VConcatChart:
        """As an interactive chart; see :func:`roadbench.chart`."""
        from roadbench import _chart

        return _chart.chart(self, plots=plots)

    @overload
    def export(
        self, format: Literal["fmu"], *, tyre: Tyre, bikes: Path | None = None, set: CoefficientSet = "5.2",
        friction: float = 1.0, load: float | None = None, model: Path | None = None,
    ) -> bytes: ...  # fmt: skip
    @overload
    def export(
        self, format: TextFormat, *, tyre: Tyre | None = None, bikes: Path | None = None, set: CoefficientSet = "5.2",
        friction: float = 1.0, load: float | None = None, model: Path | None = None,
    ) -> str: ...  # fmt: skip
    def export(
        self,
        format: Format,
        *,
        tyre: Tyre | None = None,
        bikes: Path | None = None,
        set: CoefficientSet = "5.2",
        friction: float = 1.0,
        load: float | None = None,
        model: Path | None = None,
    ) -> str | bytes:
        """Its fitted tyres as a file for other programs; see :func:`roadbench.export`.

        A session of :func:`run_session` knows its bike file; one of an output needs ``bikes`` where the format does.
        """
        how: dict[str, Any] = {"tyre": tyre, "set": set, "friction": friction, "load": load, "model": model}
        if self._out is not None:
            return _archive.exported(self._out, self.id, format, self.bike, how | {"bikes": bikes})
        with self._written() as (out, own):
            return _archive.exported(out, self.id, format, self.bike, how | {"bikes": own if bikes is None else bikes})

    @contextlib.contextmanager
    def _written(self) -> Iterator[tuple[_File, _File | None]]:
        """The tables as an output for a while, and a folder with the bike file."""
        try:
            import pyarrow
            import pyarrow.parquet as pq
        except ImportError as why:
            raise NotInstalled("export of a session in memory needs pyarrow: pip install pyarrow") from why
        with tempfile.TemporaryDirectory(prefix="roadbench-") as place:
            for name, table in self.items():
                part = _File(place, "out", name, f"bike={quote(self.bike)}")
                part.mkdir(parents=True)
                pq.write_table(pyarrow.table(table), part / "undated.parquet")
            bikes = None
            if self._bike_file is not None:
                bikes = _File(place, "bikes")
                bikes.mkdir()
                (bikes / f"{self.bike}.toml").write_text(_text(self._bike_file), encoding="utf-8")
            yield _File(place, "out"), bikes

    def __repr__(self) -> str:
        return f"<roadbench.Session {_html.line(self)}>"

    def _repr_html_(self) -> str:
        return _html.session(self)


def _text(bike_file: Path) -> str:
    """Of a path, or the text itself, as :func:`roadbench.run_session` takes both."""
    text = os.fspath(bike_file)
    return text if "=" in text and "\n" in text else _File(text).read_text(encoding="utf-8")
