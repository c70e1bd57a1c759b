"""Drawings (SVG) of charts: what is on the page, standing alone, in the colours of paper."""

import re
import subprocess
import time
from xml.etree import ElementTree

import pytest
from conftest import PROGRAM
from selenium.webdriver.common.action_chains import ActionChains
from test_explorer import FIGURES, choose, explored, place  # noqa: F401 (a fixture)
from test_report import chart, draw_all, over, scale, session_page

SVG = "{http://www.w3.org/2000/svg}"
# what a drawing may have: nothing that needs the page, a font file or the net
ELEMENTS = {"svg", "title", "rect", "g", "defs", "clipPath", "pattern", "path", "text", "circle"}
COLOUR = re.compile(r"#[0-9a-f]{6}|none|url\(#[cp]\d+\)")


def alone(text):
    """The tree of a drawing that needs nothing else."""
    tree = ElementTree.fromstring(text)
    assert tree.tag == SVG + "svg"
    ids = {e.get("id") for e in tree.iter() if e.get("id")}
    for e in tree.iter():
        assert e.tag.startswith(SVG) and e.tag.removeprefix(SVG) in ELEMENTS, e.tag
        assert not {"class", "style", "href", "src"} & set(e.attrib), e.attrib
        for name in ("fill", "stroke"):
            assert COLOUR.fullmatch(e.get(name, "none")), e.attrib
        for value in e.attrib.values():
            assert "NaN" not in value and "undefined" not in value and "var(" not in value, e.attrib
            for used in re.findall(r"url\(#(\w+)\)", value):
                assert used in ids, value
        if e.tag == SVG + "path":
            assert e.get("d").startswith("M"), e.attrib
    paper = tree.find(SVG + "rect")
    assert paper.get("fill") == "#ffffff"
    assert [paper.get(k) for k in ("width", "height")] == tree.get("viewBox").split()[2:]
    assert "sans-serif" in tree.get("font-family")
    return tree


def texts(tree):
    return [e.text for e in tree.iter(SVG + "text")]


def drawings(browser):
    script = "return [...document.querySelectorAll('.saves')].filter(s => s.drawing).map(s => s.drawing())"
    return browser.js(script)


def test_every_drawing_of_a_session_stands_alone_in_either_theme(report, browser):
    found = {}
    for scheme in ("light", "dark"):
        browser.media(scheme=scheme)
        browser.open(session_page(report))
        draw_all(browser)
        browser.settle()
        charts = browser.js("return [...document.querySelectorAll('[data-chart], [data-panel]')].filter(e => e.uplot).length")
        found[scheme] = drawings(browser)
        assert len(found[scheme]) == charts > 20
        # the page is as it was: its theme, and what draws on it
        print_mark = browser.js("return document.documentElement.dataset.print === undefined")
        native = browser.js(
            "return [CanvasRenderingContext2D.prototype.fill, CanvasRenderingContext2D.prototype.arc, Path2D].every(f => String(f).includes('[native code]'))"
        )
        assert print_mark and native
    assert found["light"] == found["dark"]
    for text in found["dark"]:
        alone(text)
    assert any("pattern" in text for text in found["dark"]), "segments that are not used are hatched"


def test_a_drawing_has_every_point_and_the_line_where_the_chart_has_them(report, browser):
    browser.open(session_page(report))
    holder = chart(browser, "[aria-label^='Rear · longitudinal']")
    text, points, line = browser.js(
        "const h = arguments[0], u = h.uplot, c = " + FIGURES + ".charts[+h.dataset.chart], at = (x, y) => [u.valToPos(x, 'x', true), u.valToPos(y, 'y', true)];"
        "return [h.closest('figure').querySelector('.saves').drawing(),"
        " c.clouds.flatMap(p => p.x.map((x, i) => at(x, p.y[i]))), c.lines[0].x.map((x, i) => at(x, c.lines[0].y[i]))]",
        holder,
    )
    tree = alone(text)
    shapes = [e for e in tree.iter(SVG + "path")]
    circles = [re.match(r"M([-\d.]+) ([-\d.]+)a([\d.]+) ", e.get("d")) for e in shapes]
    centres = sorted((float(m[1]) + float(m[3]), float(m[2])) for m in circles if m)
    assert len(centres) == len(points) > 100
    for (x, y), (a, b) in zip(centres, sorted(map(tuple, points)), strict=True):
        assert (x, y) == (pytest.approx(a, abs=0.03), pytest.approx(b, abs=0.03))
    # of the line every vertex that the chart draws is one of the fit's, and both ends are there
    lines = [e for e in shapes if e.get("stroke-width") == "2" and e.get("fill") == "none" and len(e.get("d")) > 200]
    assert lines
    vertices = [tuple(map(float, v)) for e in lines for v in re.findall(r"[ML]([-\d.]+) ([-\d.]+)", e.get("d"))]
    for x, y in vertices:
        assert min(abs(x - a) + abs(y - b) for a, b in line) < 2.5, (x, y)
    assert {"slip ratio", "longitudinal friction Fx/Fz", "Rear · longitudinal friction", "fit"} <= set(texts(tree))


def test_a_drawing_shows_the_zoom_and_the_button_saves_it(report, browser):
    browser.open(session_page(report))
    holder = chart(browser, "[aria-label^='Rear · longitudinal']")
    script = "return arguments[0].closest('figure').querySelector('.saves').drawing()"
    home = browser.js(script, holder)
    drag = ActionChains(browser.driver).move_to_element_with_offset(over(holder), -60, -20)
    drag.click_and_hold().move_by_offset(110, 35).release().perform()
    browser.wait("return location.hash.includes('zoom=friction_x_rear')")
    near, link = scale(browser, holder), browser.driver.current_url
    zoomed = browser.js(script, holder)
    assert scale(browser, holder) == near
    assert [t for t in texts(alone(zoomed)) if t] != [t for t in texts(alone(home)) if t]
    time.sleep(0.4)  # the address follows a chart with some delay
    assert browser.driver.current_url == link
    # the button: its name, and what it gives
    browser.js("window.saved = []; URL.createObjectURL = blob => { window.saved.push(blob); return 'data:,'; }")
    button = browser.js("return [...arguments[0].closest('figure').querySelectorAll('.saves button')].find(b => b.textContent === 'SVG')", holder)
    assert button.get_attribute("aria-label") == "drawing of Rear · longitudinal friction"
    browser.js("arguments[0].click()", button)
    kind, length = browser.js("return [window.saved[0].type, window.saved[0].size]")
    assert kind == "image/svg+xml" and length >= len(zoomed)


def test_the_drawing_of_the_explorer_names_tyres_load_and_camber(explored, browser, tmp_path):  # noqa: F811
    browser.media(scheme="dark")
    browser.open(explored / "report/tyres.html")
    choose(browser, "tyre-a", place(browser, "archive_s0001", "front"))
    choose(browser, "tyre-b", place(browser, "archive_s0001", "rear"))
    choose(browser, "load", 1300)
    for view, label in [("lateral", "side force Fy over slip angle"), ("leaning", "side force Fy over camber"), ("combined", "side force Fy over longitudinal force Fx")]:
        choose(browser, "show", view)
        tree = alone(browser.js("return document.getElementById('data').drawing()"))
        title = tree.find(SVG + "title").text
        assert title.startswith(label) and "load 1300 N" in title, title
        assert ("camber 0°" in title) == (view != "leaning"), title
        key = " ".join(t for t in texts(tree) if t)
        assert "archive_s0001 front" in key and "archive_s0001 rear" in key and "Solid" in key or view == "combined", key
    assert browser.js("return getComputedStyle(document.body).backgroundColor") != "rgb(255, 255, 255)", "the page stays dark"
    # standing alone in a browser it shows its texts and asks for nothing
    file = tmp_path / "drawing.svg"
    file.write_text(browser.js("return document.getElementById('data').drawing()"), encoding="utf-8")
    browser.driver.get_log("browser")
    browser.driver.get(file.as_uri())
    assert browser.js("return document.documentElement.tagName") == "svg"
    assert browser.js("return [...document.querySelectorAll('text')].every(t => t.getBBox().width > 0)")
    assert browser.driver.get_log("browser") == []


def test_map_laps_and_g_g_diagram_are_drawn_too(browser, tmp_path):
    for command in (["simulate", "track", "--out", "track"], ["run", "track", "--out", "out", "--progress", "never"]):
        done = subprocess.run([PROGRAM, *command], cwd=tmp_path, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
    page = next(p for p in (tmp_path / "out/report").glob("*.html") if 'data-lap-chart="map"' in p.read_text(encoding="utf-8"))
    found = {}
    for scheme in ("light", "dark"):
        browser.media(scheme=scheme)
        browser.open(page)
        found[scheme] = browser.js(
            "return Object.fromEntries([...document.querySelectorAll('[data-lap-chart]')].map(e => e.closest('figure').querySelector('.saves')).filter(Boolean)"
            ".map(s => [s.closest('figure').querySelector('[data-lap-chart]').dataset.lapChart, s.drawing()]))"
        )
    assert found["light"] == found["dark"] and set(found["dark"]) == {"map", "behind", "gg"}
    trees = {name: alone(text) for name, text in found["dark"].items()}
    # corners are numbered as on the page; both lines over the distance are on one sheet
    corners = browser.js(f"return {FIGURES}.laps.corners.map(c => String(c.n))")
    assert set(corners) <= set(texts(trees["map"]))
    assert {"behind, s", "speed, km/h", "distance, m"} <= set(texts(trees["behind"]))
    points = browser.js(f"const l = {FIGURES}.laps.laps.find(l => l.best); return l.ax.filter((a, i) => a != null && l.ay[i] != null).length")
    dots = [e for e in trees["gg"].iter(SVG + "circle") if e.get("fill") != "none"]
    assert len(dots) == points > 50
