"""``chart``: the numbers of the table ``plots``, in the units that the axes name."""

import csv
import io
import math
import re
import sys

import pytest

import roadbench
from conftest import on_disk
from roadbench import _catalogue, _plot

alt = pytest.importorskip("altair")
DEGREES = 180.0 / math.pi


@pytest.fixture(scope="module")
def rows(written, log):
    """The table as pyarrow reads it."""
    return [row for row in on_disk(written, "plots").to_pylist() if row["session_id"] == log.stem]


def series(rows, plot, name):
    return [row for row in rows if (row["plot"], row["series"]) == (plot, name)]


def views(spec, data=None):
    """Every plot of a chart: what has layers; with its data, which altair lifts where all parts share them."""
    data = spec.get("data", data)
    if "layer" in spec:
        return [spec | {"data": data}]
    return [view for key in ("vconcat", "hconcat") for part in spec.get(key, []) for view in views(part, data)]


def drawn(chart, title):
    """A plot's layers, each with its data as the chart holds them."""
    spec = chart.to_dict()
    [view] = [view for view in views(spec) if view.get("title") == title]
    return [(layer, data(spec, view, layer)) for layer in view["layer"]]


def data(spec, view, layer):
    name = layer.get("data", view["data"])["name"]
    return list(csv.DictReader(io.StringIO(spec["datasets"][name])))


def numbers(rows, column):
    return [float(row[column]) if row[column] else None for row in rows]


def near(values, scale=1.0):
    return [None if v is None else pytest.approx(v * scale, rel=1e-5, abs=1e-12) for v in values]


def mark(layers, kind, **more):
    [found] = [(layer, rows) for layer, rows in layers if layer["mark"]["type"] == kind and more.items() <= layer["mark"].items()]
    return found


def test_samples_fit_and_band_are_those_of_the_table(written, log, rows):
    layers = drawn(roadbench.chart(written, log.stem, plots="slip_angle_rear"), "Rear · slip angle")
    cloud, fit = series(rows, "slip_angle_rear", "data"), series(rows, "slip_angle_rear", "fit")
    assert len(cloud) > 100 and len(fit) > 50
    _, points = mark(layers, "circle")
    for column, key, scale in (("x", "x", DEGREES), ("y", "y", DEGREES), ("shade", "shade", 1.0), ("weight", "weight", 1.0)):
        assert numbers(points, column) == near([row[key] for row in cloud], scale), column
    line, values = mark(layers, "line", strokeWidth=2)
    assert line["encoding"]["order"]["field"] == "order"
    for column, key in (("x", "x"), ("y", "y"), ("y_low", "y_low"), ("y_high", "y_high")):
        assert numbers(values, column) == near([row[key] for row in fit], DEGREES), column
    # each band is a polygon: along its lower edge, and back along the upper one
    for opacity, low, high in ((0.16, "y_low", "y_high"), (0.3, "scatter_low", "scatter_high")):
        _, edge = mark(layers, "line", filled=True, opacity=opacity)
        there = [row for row in fit if row[low] is not None]
        assert numbers(edge, "y") == near([row[low] for row in there] + [row[high] for row in there[::-1]], DEGREES)
        assert numbers(edge, "x") == near([row["x"] for row in there + there[::-1]], DEGREES)


def test_outliers_are_crosses(written, log, rows):
    layers = drawn(roadbench.chart(written, log.stem, plots="friction_x_rear"), "Rear · longitudinal friction")
    crosses, points = mark(layers, "point", shape="cross")
    assert crosses["transform"] == [{"filter": "datum.weight === 0"}]
    out = [row for row in series(rows, "friction_x_rear", "data") if row["weight"] == 0]
    assert sum(row["weight"] == "0" for row in points) == len(out) > 0


def test_axes_and_tooltips_have_units(written, log):
    chart = roadbench.chart(written, log.stem, plots=["friction_y_front", "overturning", "g_g"])
    layers = drawn(chart, "Front · lateral friction over camber")
    points, _ = mark(layers, "circle")
    assert points["encoding"]["x"]["title"] == "camber (°)"
    assert points["encoding"]["color"]["title"] == "wheel load (N)"
    assert [tip["title"] for tip in points["encoding"]["tooltip"]][:3] == ["camber (°)", "lateral friction Fy/Fz", "wheel load (N)"]
    line, _ = mark(drawn(roadbench.chart(written, log.stem, plots="overturning"), "Overturning"), "line", strokeWidth=2)
    tips = [tip["title"] for tip in line["encoding"]["tooltip"]]
    assert tips == ["line", "roll (°)", "overturning arm Mx/(m g) (mm)", "95 % from (mm)", "95 % to (mm)"]
    square, _ = mark(drawn(chart, "g-g diagram"), "circle")
    ends = [square["encoding"][axis]["scale"]["domain"] for axis in "xy"]
    assert ends[0] == ends[1] and ends[0][0] == -ends[0][1]


def test_it_zooms(written, log):
    spec = roadbench.chart(written, log.stem).to_dict()
    zooms = {param["name"]: param for param in spec["params"] if param["bind"] == "scales"}
    shown = [view["title"] for view in views(spec) if "title" in view]
    assert len(zooms) == len(shown) + 1 and {"zoom_friction_x_front", "zoom_timeline"} <= set(zooms)
    # the panels of the time line move together, and in time only
    assert zooms["zoom_timeline"]["select"]["encodings"] == ["x"]
    panels = [view for view in views(spec) if "title" not in view]
    inside = [{layer.get("name") for layer in panel["layer"]} & set(zooms["zoom_timeline"]["views"]) for panel in panels]
    assert len(panels) > 5 and all(len(names) == 1 for names in inside)


def test_the_time_line(written, log, rows):
    spec = roadbench.chart(written, log.stem, plots="timeline").to_dict()
    panels = {view["layer"][1]["encoding"]["y"]["title"][0]: view for view in views(spec)}
    assert {"speed", "roll", "brake pressure"} <= set(panels)
    area, line, points = panels["roll"]["layer"]
    theirs = series(rows, "timeline", "roll")
    values = data(spec, panels["roll"], line)
    for column in ("y", "y_low", "y_high"):
        assert numbers(values, column) == near([row[column] for row in theirs], DEGREES)
    assert (area["encoding"]["y"]["field"], area["encoding"]["y2"]["field"]) == ("y_low", "y_high")
    assert [tip["title"] for tip in points["encoding"]["tooltip"]] == ["signal", "time (s)", "mean (°)", "least (°)", "largest (°)"]
    both = data(spec, panels["brake pressure"], panels["brake pressure"]["layer"][1])
    assert {row["series"] for row in both} == {"front", "rear"}


def test_every_plot_can_be_drawn(written, log, rows):
    names = sorted({row["plot"] for row in rows})
    spec = roadbench.chart(written, plots=names).to_dict()  # altair holds it against Vega-Lite's schema
    titles = [view["title"] for view in views(spec) if "title" in view]
    assert len(titles) == len(names) - 1 and {_catalogue.PLOTS[n].title for n in names if n in _catalogue.PLOTS} <= set(titles)


def test_of_any_source(written, log, bike):
    of_folder = roadbench.chart(written, log.stem, plots="coast_down").to_dict()
    session = roadbench.run_session(log, bike)
    for other in (session.chart("coast_down"), roadbench.read(written, lazy=True).session(log.stem).chart("coast_down")):
        assert other.to_dict()["datasets"] == of_folder["datasets"]
    default = roadbench.chart(session)
    assert len(views(default.to_dict())) > len(_plot.PAGE)
    assert len(default.to_json(indent=None)) < 1_500_000


def test_what_is_not_there(written, log, monkeypatch):
    with pytest.raises(roadbench.Invalid, match="no plot `friction`; there are .*friction_x_front"):
        roadbench.chart(written, log.stem, plots="friction")
    with pytest.raises(roadbench.Invalid, match="no session nobody"):
        roadbench.chart(written, "nobody")
    monkeypatch.setitem(sys.modules, "altair", None)
    with pytest.raises(roadbench.NotInstalled, match="pip install altair") as why:
        roadbench.chart(written, log.stem)
    assert isinstance(why.value, ImportError)


def test_a_saved_chart_needs_no_network(written, log, tmp_path):
    pytest.importorskip("vl_convert")
    file = tmp_path / "ride.html"
    roadbench.chart(written, log.stem, plots="coast_down").save(file, inline=True)
    text = file.read_text()
    assert not re.search(r'<(script|link)[^>]+(src|href)=', text) and len(text) > 500_000
