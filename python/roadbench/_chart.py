"""A session as an interactive chart, from the table ``plots``; needs altair."""

from __future__ import annotations

import csv
import io
import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from roadbench import _plot
from roadbench._catalogue import SERIES, Axis, Panel, Plot
from roadbench._errors import Invalid, NotInstalled
from roadbench._types import Path

if TYPE_CHECKING:
    import altair

_WIDTH, _HEIGHT, _LONG, _PANEL = 330, 240, 760, 70  # pixels
_DIGITS = 6
"""Of a number in the chart: more than a screen shows, and few enough to keep notebooks small."""


def chart(
    source: Path | Mapping[str, Any],
    session: str | None = None,
    *,
    bike: str | None = None,
    plots: str | Sequence[str] | None = None,
) -> altair.VConcatChart:
    """A session as an interactive chart, with what :func:`plot` draws: samples, fits, 95 % bands and the time line.

    Drag to move, turn the wheel to zoom, double-click to go back; point at something for its numbers and units. The chart
    holds its data, so it can be saved: ``chart.save("ride.html")``.

    Args:
        source, session, bike, plots: as of :func:`plot`.

    Raises:
        NotInstalled: altair is not (``pip install altair``; an ``ImportError``).
        Invalid: there is no such session or plot; the message says which there are (a ``ValueError``).

    Example:
        >>> roadbench.chart("/tables", "ride_01")
        >>> roadbench.run_session("ride.parquet", bike="bikes/mt07.toml").chart("friction_x_rear")
    """
    try:
        import altair as alt
    except ImportError as why:
        raise NotInstalled("roadbench.chart needs altair: pip install altair") from why
    wanted, by_plot, name = _plot.chosen_plots(source, session, bike, plots)
    small = [_one(alt, each, by_plot[each]) for each in wanted if each != _plot.TIMELINE]
    with warnings.catch_warnings():
        # the time line's panels share one zoom on purpose
        warnings.filterwarnings("ignore", "Automatically deduplicated selection parameter", UserWarning)
        parts = [alt.hconcat(*small[i : i + 2]) for i in range(0, len(small), 2)]
        if _plot.TIMELINE in wanted:
            parts.append(_timeline(alt, by_plot[_plot.TIMELINE]))
        if not parts:
            raise Invalid(f"the session {name} has nothing to draw")
        whole: altair.VConcatChart = alt.vconcat(*parts, title=name, resolve=_own_colours(alt))
    return whole


def _own_colours(alt: Any, **more: Any) -> Any:
    """Plots don't share the scale of their colours. What belongs to a chart is given to it at once: altair copies a chart
    and all in it with every change."""
    return alt.Resolve(scale=alt.ScaleResolveMap(color="independent", **more))


def _one(alt: Any, name: str, rows: _plot.Rows) -> Any:
    """A plot: the bands and the lines, and the cloud of samples."""
    plot = _plot.of(name)
    by_series = _plot.split(rows, "series")
    x, y = _ends(alt, plot, rows)
    cloud = by_series.pop("data", None)
    layers = _lines(alt, plot, by_series, x, y, legend=cloud is None) if by_series else []
    if cloud is not None:
        layers += _cloud(alt, plot, cloud, x, y)
    # by its own name: altair takes equal ones for the same
    layers[-1] = layers[-1].add_params(alt.selection_interval(bind="scales", name=f"zoom_{name}"))
    size = _HEIGHT if plot.equal_scales else _WIDTH
    return alt.layer(*layers, title=plot.title, width=size, height=_HEIGHT, resolve=_own_colours(alt))


def _ends(alt: Any, plot: Plot, rows: _plot.Rows) -> tuple[Any, Callable[[str], Any]]:
    """Abscissa, and the ordinate by the name of a column, with titles and units."""
    scales = [alt.Scale(zero=False), alt.Scale(zero=plot.from_zero)]
    if plot.equal_scales:
        # a metre is as long both ways: the same ends on a square
        ends = [abs(v) * s for axis, s in (("x", plot.x.scale), ("y", plot.y.scale)) for v in rows[axis] if v == v]
        most = float(f"{1.05 * max(ends, default=1.0):.3g}")
        scales = [alt.Scale(domain=[-most, most]) for _ in scales]
    x, y = scales
    return alt.X("x:Q", title=str(plot.x), scale=x), lambda key: alt.Y(f"{key}:Q", title=str(plot.y), scale=y)


def _cloud(alt: Any, plot: Plot, cloud: _plot.Rows, x: Any, y: Callable[[str], Any]) -> list[Any]:
    """Samples, and the outliers that the fits left out as red crosses."""
    columns = _columns(cloud, plot, ("x", "y", "shade", "weight", "n"))
    tips = [_tip(alt, "x", plot.x), _tip(alt, "y", plot.y)]
    colour = alt.value("#5b7f9b")
    if plot.colour is not None and _any(columns["shade"]):
        tips.append(_tip(alt, "shade", plot.colour))
        colour = alt.Color("shade:Q", title=str(plot.colour), scale=alt.Scale(scheme="viridis", zero=False))
    tips.append(alt.Tooltip("weight:Q", title="robust weight", format=".2~f"))
    if _any(columns["n"]):
        tips.append(alt.Tooltip("n:Q", title="samples"))
    base = alt.Chart(_data(alt, columns)).encode(x=x, y=y("y"), tooltip=tips)
    used = base.transform_filter("datum.weight !== 0").mark_circle(size=14, opacity=0.6).encode(color=colour)
    out = base.transform_filter("datum.weight === 0").mark_point(
        shape="cross", angle=45, size=26, color=_plot.OUTLIER, filled=True
    )
    return [used, out]


def _lines(
    alt: Any, plot: Plot, by_series: dict[str, _plot.Rows], x: Any, y: Callable[[str], Any], *, legend: bool
) -> list[Any]:
    """Lines with their 95 % bands, and the part of a band that is scatter between manoeuvres."""
    lines: dict[str, list[Any]] = {}
    bands: dict[str, dict[str, list[Any]]] = {}
    for series, line in by_series.items():
        label = SERIES.get(series, series.replace("_", " "))
        columns = _columns(line, plot, ("x", "y", "y_low", "y_high", "scatter_low", "scatter_high"))
        columns["series"] = [label] * len(columns["x"])
        columns["order"] = list(range(len(columns["x"])))  # a curve that turns back is drawn in its order
        _add(lines, columns)
        for band in ("y", "scatter"):
            _add(bands.setdefault(band, {}), _outline(columns, band))
    labels = list(dict.fromkeys(lines["series"]))
    shades = alt.Scale(domain=labels, range=[_plot.LINES[i % len(_plot.LINES)] for i in range(len(labels))])
    unnamed = alt.Color("series:N", title=None, scale=shades, legend=None)
    # beside a cloud, whose colour has a legend of its own, the line says in its tooltip what it is
    named = alt.Color("series:N", title=None, scale=shades, legend=_legend(alt)) if legend else unnamed

    def base(data: dict[str, list[Any]]) -> Any:
        return alt.Chart(_data(alt, data)).encode(x=x, y=y("y"), order="order:Q", color=unnamed)

    tips = [alt.Tooltip("series:N", title="line"), _tip(alt, "x", plot.x), _tip(alt, "y", plot.y)]
    layers = []
    for (band, outline), opacity in zip(bands.items(), (0.16, 0.3), strict=True):
        if outline["x"]:
            layers.append(base(outline).mark_line(filled=True, opacity=opacity, interpolate="linear-closed"))
            if band == "y":
                tips += [_tip(alt, "y_low", plot.y, "95 % from"), _tip(alt, "y_high", plot.y, "95 % to")]
    line = base(lines).encode(tooltip=tips)
    # a line is hard to hit: points that nobody sees, under the pointer
    return [*layers, line.encode(color=named).mark_line(strokeWidth=2), line.mark_point(opacity=0, size=60)]


def _legend(alt: Any) -> Any:
    return alt.Legend(symbolOpacity=1.0, symbolType="stroke")


def _outline(columns: dict[str, list[Any]], band: str) -> dict[str, list[Any]]:
    """A band as a polygon: along its lower edge, and back along the upper one."""
    low, high = columns[f"{band}_low"], columns[f"{band}_high"]
    ok = [i for i in range(len(low)) if math.isfinite(low[i]) and math.isfinite(high[i])]
    out = {"x": [columns["x"][i] for i in ok + ok[::-1]], "y": [low[i] for i in ok] + [high[i] for i in ok[::-1]]}
    return out | {"series": columns["series"][:1] * len(out["x"]), "order": list(range(len(out["x"])))}


def _timeline(alt: Any, rows: _plot.Rows) -> Any:
    """Panels above each other, which move and zoom in time together."""
    by_series = _plot.split(rows, "series")
    zoom = alt.selection_interval(bind="scales", encodings=["x"], name="zoom_timeline")
    panels = _plot.panels_of(rows)
    drawn = [_panel(alt, panel, by_series, zoom, panel is panels[-1]) for panel in panels]
    return alt.vconcat(*drawn, spacing=4, resolve=_own_colours(alt, x="shared"))


def _panel(alt: Any, panel: Panel, by_series: dict[str, _plot.Rows], zoom: Any, last: bool) -> Any:
    plot = Plot("", Axis("time", "s"), panel.axis)
    values: dict[str, list[Any]] = {}
    there = {series: label for series, label in panel.series.items() if series in by_series}
    for series, label in there.items():
        columns = _columns(by_series[series], plot, ("x", "y", "y_low", "y_high"))
        _add(values, columns | {"series": [label] * len(columns["x"])})
    axis = alt.Axis() if last else alt.Axis(labels=False, title=None, ticks=False)
    x = alt.X("x:Q", title="time (s)", axis=axis, scale=alt.Scale(nice=False))
    labels = list(there.values())
    shades = alt.Scale(domain=labels, range=[_plot.LINES[i % len(_plot.LINES)] for i in range(len(labels))])
    legend = _legend(alt) if len(labels) > 1 else None
    tips = [alt.Tooltip("series:N", title="signal"), _tip(alt, "x", plot.x), _tip(alt, "y", plot.y, "mean")]
    tips += [_tip(alt, "y_low", plot.y, "least"), _tip(alt, "y_high", plot.y, "largest")]
    title = [panel.axis.label, f"({panel.axis.unit})"] if panel.axis.unit else panel.axis.label
    low, mean = (alt.Y(f"{key}:Q", title=title, scale=alt.Scale(zero=False)) for key in ("y_low", "y"))
    base = alt.Chart(_data(alt, values)).encode(x=x, color=alt.Color("series:N", title=None, scale=shades, legend=legend))
    layers = (
        base.mark_area(opacity=0.25).encode(y=low, y2="y_high:Q"),
        base.mark_line(strokeWidth=1).encode(y=mean),
        base.mark_point(opacity=0, size=30).encode(y=mean, tooltip=tips).add_params(zoom),
    )
    return alt.layer(*layers, width=_LONG, height=_PANEL)


def _tip(alt: Any, key: str, axis: Axis, label: str | None = None) -> Any:
    words = str(axis) if label is None else f"{label} ({axis.unit})" if axis.unit and axis.unit not in label else label
    return alt.Tooltip(f"{key}:Q", title=words, format=".4~g")


def _columns(rows: _plot.Rows, plot: Plot, names: Sequence[str]) -> dict[str, list[Any]]:
    """Columns in the units that are shown."""
    scales = {"x": plot.x.scale, "shade": plot.colour.scale if plot.colour else 1.0, "weight": 1.0, "n": 1.0}
    missing = [math.nan] * len(rows["x"])
    return {
        name: (rows[name] * scales.get(name, plot.y.scale)).tolist() if name in rows else missing for name in names
    }


def _add(to: dict[str, list[Any]], columns: dict[str, list[Any]]) -> None:
    for name, values in columns.items():
        to.setdefault(name, []).extend(values)


def _any(values: list[float]) -> bool:
    return any(math.isfinite(value) for value in values)


def _data(alt: Any, columns: dict[str, list[Any]]) -> Any:
    """Data of a chart, as text: a third of the size of JSON, and altair need not check it value by value."""
    text = io.StringIO()
    write = csv.writer(text, lineterminator="\n")
    write.writerow(columns)
    write.writerows(zip(*([_short(value) for value in values] for values in columns.values()), strict=True))
    parse = {name: "string" if name == "series" else "number" for name in columns}
    return alt.InlineData(values=text.getvalue(), format=alt.CsvDataFormat(type="csv", parse=parse))


def _short(value: Any) -> Any:
    """Without digits that nobody sees; nothing where there is no number."""
    if not isinstance(value, float):
        return value
    return f"{value:.{_DIGITS}g}" if math.isfinite(value) else ""
