"""A session as a figure, from the table ``plots``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from roadbench._catalogue import COVARIATES, PANELS, PLOTS, SERIES, Axis, Panel, Plot
from roadbench._errors import Invalid, NotInstalled
from roadbench._frames import columns
from roadbench._read import Tables
from roadbench._types import Path

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TIMELINE = "timeline"
PAGE = (
    *(f"{name}_{tyre}" for name in ("friction_x", "friction_y", "stiffness") for tyre in ("front", "rear")),
    "coast_down",
    "g_g",
    TIMELINE,
)
"""What is drawn where nothing is named."""

_WIDTH, _PLOT, _PANEL = 11.0, 3.3, 1.25  # inches
LINES = ("#1f3b57", "#d9822b", "#3c8d5a", "#8e5ea2")
OUTLIER = "#c0392b"  # as in the report

Rows = dict[str, Any]
"""Columns of some rows, as numpy arrays."""


def plot(
    source: Path | Mapping[str, Any],
    session: str | None = None,
    *,
    bike: str | None = None,
    plots: str | Sequence[str] | None = None,
    figure: Figure | None = None,
) -> Figure:
    """A session as a matplotlib figure, with what its page of the report shows.

    Args:
        source: the folder that :func:`run` wrote, what :func:`read` gives of it, or a :class:`Session`.
        session: the session's id; not needed where there is only one.
        bike: its motorcycle, where two have a session of that name.
        plots: names in the table ``plots``, such as ``friction_x_front``, ``slip_angle_rear`` or ``timeline``; ``None``
            draws friction over slip and over camber, stiffness over camber, coast-down, g-g diagram and time line.
        figure: draw into this one, for instance of ``pyplot.figure()``; else a new one is made, which belongs to no
            window: notebooks show it, ``figure.savefig("ride.png")`` writes it.

    Raises:
        NotInstalled: matplotlib is not (``pip install roadbench[plot]``; an ``ImportError``).
        Invalid: there is no such session or plot; the message says which there are (a ``ValueError``).

    Example:
        >>> roadbench.plot("/tables", "ride_01").savefig("ride_01.png")
        >>> roadbench.run_session("ride.parquet", bike="bikes/mt07.toml").plot("stiffness_rear")
    """
    try:
        from roadbench._figure import SessionFigure
    except ImportError as why:
        raise NotInstalled("roadbench.plot needs matplotlib: pip install roadbench[plot]") from why
    wanted, by_plot, name = chosen_plots(source, session, bike, plots)
    small = [each for each in wanted if each != TIMELINE]
    panels = panels_of(by_plot[TIMELINE]) if TIMELINE in wanted else []
    across = 2 if len(small) > 1 else 1
    high = [_PLOT] * -(-len(small) // across)
    if panels:
        high.append(_PANEL * len(panels) + 0.6)
    if not high:
        raise Invalid(f"the session {name} has nothing to draw")
    if figure is None:
        figure = SessionFigure(figsize=(_WIDTH, sum(high) + 0.5), dpi=100, layout="constrained")
    parts = figure.subfigures(len(high), 1, height_ratios=high, squeeze=False)[:, 0]
    for row, part in zip(range(0, len(small), across), parts, strict=False):
        axes = part.subplots(1, across, squeeze=False)[0]
        for ax in axes[len(small) - row :]:
            ax.set_axis_off()
        for ax, each in zip(axes, small[row : row + across], strict=False):
            _plot(ax, each, by_plot[each])
    if panels:
        _timeline(parts[-1], panels, split(by_plot[TIMELINE], "series"))
    figure.suptitle(name, fontweight="bold")
    return figure


def chosen_plots(
    source: Any, session: str | None, bike: str | None, plots: str | Sequence[str] | None
) -> tuple[list[str], dict[str, Rows], str]:
    """Names of the plots that are asked for, the session's rows by plot, and what it is called."""
    rows, name = _rows(source, session, bike)
    by_plot = split(rows, "plot")
    if plots is None:
        return [plot for plot in PAGE if plot in by_plot], by_plot, name
    wanted = [plots] if isinstance(plots, str) else list(plots)
    _all_there(wanted, by_plot)
    return wanted, by_plot, name


def _rows(source: Any, session: str | None, bike: str | None) -> tuple[Rows, str]:
    """The session's rows of ``plots``, and what it is called."""
    if isinstance(source, Mapping) and not isinstance(source, Tables):
        if "plots" not in source:
            raise Invalid(f"there is no table `plots` among {', '.join(map(str, source))}")
        rows = _arrays(source["plots"])
    else:
        tables = source if isinstance(source, Tables) else Tables(source)
        if session is None:
            # which sessions there are, without their plots
            known = _arrays(tables.read("sessions", columns=["session_id", "bike_id"]))
            session, bike = _the_only(known, session, bike)
        rows = _arrays(tables.read("plots", session=session))
        if not len(rows["x"]):
            known = _arrays(tables.read("sessions", columns=["session_id", "bike_id"]))
            _the_only(known, session, bike)
            raise Invalid(f"the session {session} has nothing to draw")
    session, bike = _the_only(rows, session, bike)
    keep = (rows["session_id"] == session) & (rows["bike_id"] == bike)
    return {name: values[keep] for name, values in rows.items()}, f"{session} · {bike}"


def _the_only(rows: Rows, session: str | None, bike: str | None) -> tuple[str, str]:
    """Session and bike of the rows that are asked for; an error where there is none or more than one."""
    there = sorted(set(zip(map(str, rows["session_id"]), map(str, rows["bike_id"]), strict=True)))
    found = [(s, b) for s, b in there if session in (None, s) and bike in (None, b)]
    if len(found) == 1:
        return found[0]
    listed = ", ".join(f"{s} of {b}" for s, b in (found or there)[:8]) or "none"
    more = ", ..." if len(found or there) > 8 else ""
    if not found:
        raise Invalid(f"there is no session {session or ''}{f' of {bike}' if bike else ''}; there are {listed}{more}")
    raise Invalid(f"which session? Name one, and its bike where two have one of that name: {listed}{more}")


def _arrays(frame: Any) -> Rows:
    """Columns as numpy arrays: texts as objects, numbers as floats with NaN for null."""
    import numpy as np

    texts = ("session_id", "bike_id", "plot", "series")
    numbers = ("x", "y", "y_low", "y_high", "scatter_low", "scatter_high", "weight", "shade", "n")
    return {
        name: np.array(values, dtype=object if name in texts else float)
        for name, values in columns(frame).items()
        if name in texts or name in numbers
    }


def split(rows: Rows, by: str) -> dict[str, Rows]:
    """Rows by the text in one column, in order of appearance."""
    return {
        str(text): {name: values[rows[by] == text] for name, values in rows.items()}
        for text in dict.fromkeys(rows[by])
    }


def _all_there(wanted: Iterable[str], by_plot: Mapping[str, Rows]) -> None:
    for plot in wanted:
        if plot not in by_plot:
            raise Invalid(f"the session has no plot `{plot}`; there are {', '.join(by_plot)}")


def of(name: str) -> Plot:
    """What is known of a plot; off the road only the name is."""
    words = name.replace("_", " ").capitalize()
    fit, _, covariate = name.removeprefix("residual_").rpartition("_over_")
    if name.startswith("residual_") and fit in PLOTS and covariate in COVARIATES:
        y = PLOTS[fit].y
        return Plot(words, COVARIATES[covariate], y._replace(label=f"residual, {y.label}"), colour=None)
    return PLOTS.get(name) or Plot(words, Axis("x", "SI"), Axis("y", "SI"), colour=None)


def _plot(ax: Axes, name: str, rows: Rows) -> None:
    import numpy as np

    plot = of(name)
    by_series = split(rows, "series")
    cloud = by_series.pop("data", None)
    if cloud is not None:
        x, y = cloud["x"] * plot.x.scale, cloud["y"] * plot.y.scale
        out = cloud["weight"] == 0.0
        shade = cloud["shade"]
        if plot.colour and np.isfinite(shade[~out]).any():
            points = ax.scatter(
                x[~out], y[~out], c=shade[~out] * plot.colour.scale, s=9, cmap="viridis", alpha=0.65, linewidths=0
            )
            bar = ax.figure.colorbar(points, ax=ax, pad=0.01, aspect=30)
            bar.set_label(str(plot.colour), fontsize="small")
            bar.ax.tick_params(labelsize="small")
            if bar.solids:
                bar.solids.set_alpha(1.0)
        else:
            ax.scatter(x[~out], y[~out], color="#5b7f9b", s=9, alpha=0.5, linewidths=0)
        if out.any():
            label = f"outliers ({int(out.sum())})"
            ax.scatter(x[out], y[out], marker="x", s=18, color=OUTLIER, linewidths=0.9, label=label)
    for number, (series, line) in enumerate(by_series.items()):
        colour = LINES[number % len(LINES)]
        x, y = line["x"] * plot.x.scale, line["y"] * plot.y.scale
        low, high = line["y_low"] * plot.y.scale, line["y_high"] * plot.y.scale
        label = SERIES.get(series, series.replace("_", " "))
        none = np.full_like(x, np.nan)
        scatter = [line.get(name, none) * plot.y.scale for name in ("scatter_low", "scatter_high")]
        bands = [(low, high, 0.16, "95 % interval"), (*scatter, 0.3, "of it scatter between manoeuvres")]
        for low, high, alpha, words in bands:
            ok = np.isfinite(low) & np.isfinite(high)
            if ok.any():
                edge = np.r_[x[ok], x[ok][::-1]], np.r_[low[ok], high[ok][::-1]]
                ax.fill(*edge, color=colour, alpha=alpha, linewidth=0, label=words if number == 0 else None)
        ax.plot(x, y, color=colour, linewidth=1.8, label=label)
    ax.set(title=plot.title, xlabel=str(plot.x), ylabel=str(plot.y))
    ax.grid(alpha=0.25)
    if plot.from_zero:
        ax.set_ylim(bottom=0.0)
    if plot.equal_scales:
        ax.set_aspect("equal", adjustable="datalim")
    if ax.get_legend_handles_labels()[0]:
        ax.legend(fontsize="small", framealpha=0.7)


def panels_of(rows: Rows) -> list[Panel]:
    there = set(rows["series"])
    return [panel for panel in PANELS if there.intersection(panel.series)]


def _timeline(part: Any, panels: list[Panel], by_series: dict[str, Rows]) -> None:
    import numpy as np

    axes = part.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for ax, panel in zip(axes, panels, strict=True):
        lines = {series: label for series, label in panel.series.items() if series in by_series}
        for number, (series, label) in enumerate(lines.items()):
            colour, scale = LINES[number % len(LINES)], panel.axis.scale
            row = by_series[series]
            x, y, low, high = (row[c] * s for c, s in (("x", 1.0), ("y", scale), ("y_low", scale), ("y_high", scale)))
            if np.isfinite(low).any():
                ax.fill_between(x, low, high, color=colour, alpha=0.25, linewidth=0)
            ax.plot(x, y, color=colour, linewidth=0.8, label=label)
        unit = f"\n({panel.axis.unit})" if panel.axis.unit else ""
        ax.set_ylabel(panel.axis.label.replace(" ", "\n", 1) + unit, fontsize="small")
        ax.tick_params(labelsize="small")
        ax.grid(alpha=0.25)
        ax.margins(x=0)
        if len(lines) > 1:
            ax.legend(fontsize="x-small", loc="upper right", ncols=len(lines), framealpha=0.7)
    axes[0].set_title("Time line: mean, least and largest value of each span", fontsize="medium")
    axes[-1].set_xlabel("time (s)")
    part.align_ylabels(axes)
