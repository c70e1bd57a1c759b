"""``plot`` draws what a session's page of the report shows."""

import re
import sys

import pytest

import roadbench
from conftest import ROOT
from roadbench import _catalogue, _plot

pytest.importorskip("matplotlib")


def titles(figure):
    return [ax.get_title() for ax in figure.axes if ax.get_title()]


def test_a_page(written, log, tmp_path):
    figure = roadbench.plot(written, log.stem)
    assert figure.get_suptitle() == f"{log.stem} · archive_01"
    found = titles(figure)
    assert found[:2] == ["Front · longitudinal friction", "Rear · longitudinal friction"]
    assert {"Front · stiffness", "Rear · stiffness", "Coast-down", "g-g diagram"} <= set(found)
    labels = {ax.get_xlabel() for ax in figure.axes} | {ax.get_ylabel() for ax in figure.axes}
    assert {"slip ratio", "camber (°)", "speed squared (m²/s²)", "wheel load (N)", "time (s)"} <= labels
    figure.savefig(tmp_path / "page.png")
    assert (tmp_path / "page.png").stat().st_size > 50_000


def test_outliers_and_bands_are_marked(written, log):
    figure = roadbench.plot(written, log.stem, plots="friction_x_rear")
    [ax] = [ax for ax in figure.axes if ax.get_title()]
    rows = roadbench.read(written, "plots", frames="pandas")
    cloud = rows[(rows["plot"] == "friction_x_rear") & (rows["series"] == "data")]
    out = int((cloud["weight"] == 0).sum())
    assert out > 0
    legend = [text.get_text() for text in ax.get_legend().get_texts()]
    assert legend == [f"outliers ({out})", "95 % interval", "of it scatter between manoeuvres", "fit"]
    points = sum(len(c.get_offsets()) for c in ax.collections if type(c).__name__ == "PathCollection")
    assert points == len(cloud)
    assert len([patch for patch in ax.patches if type(patch).__name__ == "Polygon"]) == 2


def test_every_plot_of_a_session_can_be_drawn(written, log):
    rows = roadbench.read(written, "plots", frames="pandas")
    names = sorted(set(rows["plot"]))
    figure = roadbench.plot(written, plots=names)  # the only session
    assert len(titles(figure)) == len(names)
    # and none goes by its bare name
    labels = {ax.get_xlabel() for ax in figure.axes} | {ax.get_ylabel() for ax in figure.axes}
    assert not {"x (SI)", "y (SI)"} & labels


@pytest.mark.parametrize("frames", ["polars", "pandas", "arrow"])
def test_from_frames_that_were_read(written, log, frames):
    tables = roadbench.read(written, frames=frames)
    assert len(titles(roadbench.plot(tables, log.stem, bike="archive_01", plots=["stiffness_rear"]))) == 1


def test_a_session_in_memory(log, bike):
    figure = roadbench.plot(roadbench.run_session(log, bike), plots=["slip_angle_front", "timeline"])
    assert titles(figure)[0] == "Front · slip angle"


def test_into_a_given_figure(written, log):
    from matplotlib.figure import Figure

    mine = Figure(layout="constrained")
    assert roadbench.plot(written, log.stem, plots=["g_g"], figure=mine) is mine


def test_what_is_not_there(written, log):
    with pytest.raises(ValueError, match=f"no session nobody; there are {log.stem} of archive_01"):
        roadbench.plot(written, "nobody")
    with pytest.raises(ValueError, match="no plot `friction`; there are .*friction_x_front"):
        roadbench.plot(written, log.stem, plots=["friction"])
    with pytest.raises(ValueError, match="no table `plots` among coefficients"):
        roadbench.plot({"coefficients": None})


def test_without_matplotlib(written, log, monkeypatch):
    for name in [name for name in sys.modules if name.split(".")[0] == "matplotlib"] + ["roadbench._figure"]:
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ImportError, match=r"pip install roadbench\[plot\]"):
        roadbench.plot(written, log.stem)


def test_axes_are_those_of_the_report():
    """The report has its own catalogue, in Rust: the same quantities in the same units."""
    source = "".join((ROOT / "src" / "report" / "plots" / f"{name}.rs").read_text() for name in ("fits", "ride", "offroad"))
    theirs = set(re.findall(r'Axis::new\(\s*"([^"]+)", "([^"]*)"', source))
    theirs |= {(label, "°") for label in re.findall(r'Axis::degrees\("([^"]+)"\)', source)}
    theirs |= {(label, "N") for label in re.findall(r'panel!\("([^"]+)"', source)}
    plots = _catalogue.PLOTS.values()
    ours = {(a.label, a.unit) for p in plots for a in (p.x, p.y)} | {(p.axis.label, p.axis.unit) for p in _catalogue.PANELS}
    of_situations = {("time", "s"), ("force on the bike", "N"), ("force on the tyre", "N")}  # off the road
    assert len(theirs) > 20 and theirs - ours == of_situations
    assert set(_plot.PAGE) <= set(_catalogue.PLOTS) | {"timeline"}
