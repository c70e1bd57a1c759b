"""The tyre explorer, and links and downloads of charts: against what the program exports, and as a reader uses them."""

import csv
import io
import math
import subprocess

import pytest
from conftest import PROGRAM, ROOT
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from test_report import chart, over, scale, session_page

BIKES = ROOT / "fixtures/archive/bikes"
# of the page's script; the data are unpacked there
FIGURES = "document.getElementById('data').figures"


@pytest.fixture(scope="module")
def explored(tmp_path_factory):
    """An output of three rides of the archive, its page of tyres."""
    out = tmp_path_factory.mktemp("explorer") / "out"
    rides = ROOT / "fixtures/archive/sessions"
    logs = [
        rides / "bike=archive_01/date=2026-05-01/archive_s0001.parquet",
        rides / "bike=archive_01/date=2026-05-01/archive_s0002.parquet",
        rides / "bike=archive_02/date=2026-05-04/archive_s0008.parquet",
    ]
    done = subprocess.run([PROGRAM, "run", *logs, "--bikes", BIKES, "--out", out], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    return out


def place(browser, session, tyre):
    name = f"{session} {tyre}"
    return browser.js(f"return {FIGURES}.tyres.findIndex(t => t.name.startsWith(arguments[0]))", name)


def choose(browser, id, value):
    script = "const e = document.getElementById(arguments[0]); e.value = arguments[1]; e.dispatchEvent(new Event('input'))"
    browser.js(script, id, str(value))
    browser.settle()


def downloaded(browser):
    lines = list(csv.reader(io.StringIO(browser.js("return document.getElementById('data').csv()"))))
    assert len(set(lines[0])) == len(lines[0]), lines[0]
    return [dict(zip(lines[0], line, strict=True)) for line in lines[1:]]


def test_the_page_computes_what_the_program_exports(explored, browser):
    browser.open(explored / "report/tyres.html")
    for session, tyre in [("archive_s0001", "front"), ("archive_s0001", "rear"), ("archive_s0008", "rear")]:
        command = [PROGRAM, "export", explored, "--session", session, "--format", "csv", "--tyre", tyre, "--bikes", BIKES]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr
        rows = list(csv.DictReader(line for line in done.stdout.splitlines() if not line.startswith("#")))
        assert {r["table"] for r in rows} == {"longitudinal", "lateral", "combined"}
        given = [[float(r[k]) for k in ("slip_ratio_1", "slip_angle_rad", "camber_rad", "load_N")] for r in rows]
        forces = f"const t = {FIGURES}.tyres[arguments[0]]; return arguments[1].map(([s, a, g, l]) => t.forces(s, a, g, l, 1))"
        found = browser.js(forces, place(browser, session, tyre), given)
        for row, inputs, outputs in zip(rows, given, found, strict=True):
            # slips and angles of the file have six decimals, on a stiffness of some ten per load
            for column, value, scale in zip(("Fx_N", "Fy_N", "Mx_Nm", "Mz_Nm"), outputs, (1, 1, 0.1, 0.1)):
                assert value == pytest.approx(float(row[column]), abs=4e-5 * inputs[3] * scale), (row, column)
        # the intervals too: the page has every fourth point of the charts' bands
        reach = (
            f"const t = {FIGURES}.tyres[arguments[0]], {{ along, across }} = document.getElementById('data').intervals;"
            "return arguments[1].map(([s, a, g, l]) => s ? along(t, s, { gamma: g, load: l, mu: 1 }) : across(t, a, g, l, 1))"
        )
        # a longitudinal force has none far from the loads under which the wheel was braked, on both
        far = [i for r, i in zip(rows, given, strict=True) if r["table"] == "longitudinal" and not r["Fx_ci95_low_N"] and -0.05 <= i[0] < 0]
        assert tyre == "front" or far, (session, tyre)
        loads = browser.js(f"return {FIGURES}.tyres[arguments[0]].ridden.bounded", place(browser, session, tyre))
        for inputs, found in zip(far, browser.js(reach, place(browser, session, tyre), far), strict=True):
            assert found is None and not loads[0] <= inputs[3] <= loads[1], (session, tyre, inputs, loads, found)
        known = [(r, i) for r, i in zip(rows, given, strict=True) if r["Fx_ci95_low_N"] or r["Fy_ci95_low_N"]]
        assert len(known) > 300 and {r["table"] for r, _ in known} == {"longitudinal", "lateral"}
        compared = 0
        for (row, inputs), found in zip(known, browser.js(reach, place(browser, session, tyre), [i for _, i in known]), strict=True):
            force = "Fx" if row["table"] == "longitudinal" else "Fy"
            if found is None or (force == "Fx") != (inputs[0] != 0):
                continue  # at the very end of a curve, whose place is rounded
            y, low, high = (float(row[f"{force}{end}_N"]) for end in ("", "_ci95_low", "_ci95_high"))
            assert found == pytest.approx([y - low, high - y], rel=0.1, abs=2e-4 * inputs[3]), (row, found)
            compared += 1
        assert compared > 0.9 * len(known), (compared, len(known))


def test_the_bands_are_those_of_the_table(explored, browser):
    """Upright, the stiffness and its interval are the coefficient's; at the peak, the friction's."""
    import pyarrow.parquet as pq

    browser.open(explored / "report/tyres.html")
    table = pq.read_table(explored / "coefficients", partitioning=None).to_pylist()
    known = {(r["session_id"], r["tyre"], r["coefficient"]): r for r in table}
    for session, tyre in [("archive_s0001", "front"), ("archive_s0008", "front")]:
        i = place(browser, session, tyre)
        y, b = browser.js(
            f"const t = {FIGURES}.tyres[arguments[0]], b = t.off('stiffness', 0); return [t.kAlpha(0), b && [b.low, b.high]]", i
        )
        row = known[session, tyre, "cornering_stiffness_0"]
        assert row["status"] == "ok" and y == pytest.approx(row["value"], rel=1e-6)
        assert [y - b[0], y + b[1]] == pytest.approx([row["ci95_low"], row["ci95_high"]], rel=2e-3)
        choose(browser, "tyre-a", i)
        choose(browser, "camber", 0)
        load = browser.js(f"return {FIGURES}.tyres[{i}].parameters.load_at_rest")
        cells = browser.js(
            "const r = [...document.querySelectorAll('#numbers-body tr')].find(r => r.textContent.startsWith('Cornering'));"
            "return [...r.querySelectorAll('td')].map(e => e.textContent)"
        )
        chosen = float(browser.js("return document.getElementById('load').value"))
        per_degree = chosen * math.pi / 180
        assert float(cells[0]) == pytest.approx(row["value"] * per_degree, abs=0.06), (cells, load)
        ends = [float(end) for end in cells[1].split(" to ")]
        assert ends == pytest.approx([row[end] * per_degree for end in ("ci95_low", "ci95_high")], rel=3e-3), cells


def test_intervals_of_side_forces_contain_the_truth(explored, browser):
    """Leaning by 30 degrees, at three slip angles: the simulated tyres are of the model itself."""
    import pyarrow.parquet as pq

    truth = pq.read_table(ROOT / "fixtures/archive/truth/coefficients", partitioning=None).to_pylist()
    true = {(r["session_id"], r["tyre"], r["coefficient"]): r["value"] for r in truth}
    browser.open(explored / "report/tyres.html")
    choose(browser, "tyre-b", "")
    choose(browser, "show", "leaning")
    choose(browser, "load", 1200)
    checked = 0
    for session, tyre in [(s, t) for s in ("archive_s0001", "archive_s0008") for t in ("front", "rear")]:
        choose(browser, "tyre-a", place(browser, session, tyre))
        ct, c1, c3, ratio = (true[session, tyre, k] for k in ("lateral_friction_ct", "slip_camber_c1", "slip_camber_c3", "side_force_ratio"))
        for angle in (-1, 0, 1):
            choose(browser, "angle", angle)
            for row in downloaded(browser):
                camber = float(row["camber (deg)"])
                if abs(abs(camber) - 30) > 1 or not row["ci95_low"]:
                    continue
                g, alpha = math.radians(camber), math.radians(angle)
                stiffness = -ct * math.tan(g) / (c1 * g + c3 * g**3 + ratio * g)
                force = -stiffness * (alpha + ratio * g) * 1200
                low, high = float(row["ci95_low"]), float(row["ci95_high"])
                assert low <= force <= high, (session, tyre, row, force)
                assert high - low < 1.6 * abs(force), "no interval that says nothing"
                checked += 1
    assert checked > 40, checked


def test_sliders_views_and_links(explored, browser):
    page = explored / "report/tyres.html"
    browser.open(page)
    front = place(browser, "archive_s0001", "front")
    rear = place(browser, "archive_s0001", "rear")
    choose(browser, "tyre-a", front)
    choose(browser, "tyre-b", rear)
    for view, control in [("longitudinal", "load"), ("lateral", "camber"), ("leaning", "angle"), ("combined", "mu"), ("yaw", "slip"), ("overturning", "load")]:
        choose(browser, "show", view)
        rows = downloaded(browser)
        assert {r["tyre"].split(" (")[0] for r in rows} == {"archive_s0001 front", "archive_s0001 rear"}, view
        assert all(math.isfinite(float(list(r.values())[3])) for r in rows)
        assert not browser.driver.find_element(By.ID, f"{control}-row").get_attribute("hidden")
        before = browser.js("return document.querySelector('#explorer canvas').toDataURL()")
        slider = browser.driver.find_element(By.ID, control)
        value = float(slider.get_attribute("value"))
        choose(browser, control, value + 10 * float(slider.get_attribute("step")))
        assert browser.js("return document.querySelector('#explorer canvas').toDataURL()") != before, view
    # half the load, about half the force: in the file that is downloaded
    choose(browser, "show", "lateral")
    choose(browser, "slip", 0)
    choose(browser, "camber", 0)
    choose(browser, "mu", 1)
    force = lambda: max(float(r["side force Fy (N)"]) for r in downloaded(browser) if "front" in r["tyre"])
    choose(browser, "load", 1000)
    one = force()
    choose(browser, "load", 2000)
    assert force() == pytest.approx(2 * one, rel=1e-9)
    banded = [r for r in downloaded(browser) if r["ci95_low"]]
    assert banded and all(float(r["ci95_low"]) <= float(r["side force Fy (N)"]) <= float(r["ci95_high"]) for r in banded)
    # the address is a link to all that
    choose(browser, "show", "leaning")
    choose(browser, "load", 1700)
    link = browser.driver.current_url
    browser.driver.get("about:blank")
    browser.driver.get(link)
    browser.wait(f"const d = document.getElementById('data'); return d && d.csv && {FIGURES}")
    state = browser.js("return ['tyre-a', 'tyre-b', 'show', 'load'].map(i => document.getElementById(i).value)")
    assert state == [str(front), str(rear), "leaning", "1700"]
    # the session's page leads to its own tyres
    browser.open(explored / "report/archive_s0001.html")
    browser.driver.find_element(By.PARTIAL_LINK_TEXT, "Explore the tyres").click()
    browser.wait("const d = document.getElementById('data'); return d && !!d.csv")
    assert browser.js("return [document.getElementById('tyre-a').value, document.getElementById('tyre-b').value]") == [str(front), str(rear)]
    # keyboard and screen reader: each control has a name, the chart says what it shows
    unnamed = browser.js(
        "return [...document.querySelectorAll('select, input, button')].filter(e => !(e.labels && e.labels.length) && !e.getAttribute('aria-label') && !e.textContent.trim()).length"
    )
    assert unnamed == 0
    assert "archive_s0001 front" in browser.driver.find_element(By.ID, "explorer").get_attribute("aria-label")


def test_a_link_to_an_unknown_tyre_says_so_and_a_load_beyond_the_ride_is_dashed(explored, browser):
    page = explored / "report/tyres.html"
    browser.driver.get("about:blank")
    browser.driver.get(page.as_uri() + "#a=nobody/x/front&show=longitudinal&mu=NaN")
    browser.wait("const d = document.getElementById('data'); return d && !!d.csv")
    browser.settle()
    assert "nobody/x/front" in browser.driver.find_element(By.ID, "missing").text
    assert browser.js("return document.getElementById('mu').value") == "1"
    choose(browser, "tyre-a", place(browser, "archive_s0001", "front"))
    choose(browser, "tyre-b", "")
    assert browser.driver.find_element(By.ID, "missing").text == ""
    assert any(r["ridden"] == "true" for r in downloaded(browser))
    choose(browser, "load", 4000)
    assert not any(r["ridden"] == "true" for r in downloaded(browser))
    # the skip link is no link to a tyre
    browser.js("location.hash = '#main'")
    browser.settle()
    assert browser.js("return document.getElementById('load').value") == "4000"


def test_hover_names_both_tyres_with_intervals(explored, browser):
    browser.open(explored / "report/tyres.html")
    choose(browser, "tyre-a", place(browser, "archive_s0001", "front"))
    choose(browser, "tyre-b", place(browser, "archive_s0001", "rear"))
    choose(browser, "show", "lateral")
    holder = browser.driver.find_element(By.ID, "explorer")
    ActionChains(browser.driver).move_to_element_with_offset(over(holder), 8, 0).perform()
    text = holder.find_element(By.CSS_SELECTOR, ".tip").text
    assert "archive_s0001 front" in text and "archive_s0001 rear" in text and "95 % interval" in text and " N" in text, text


def test_a_zoom_a_manoeuvre_and_the_data_of_a_chart(report, browser):
    page = session_page(report)
    browser.open(page)
    holder = chart(browser, "[aria-label^='Rear · longitudinal']")
    home = scale(browser, holder)
    drag = ActionChains(browser.driver).move_to_element_with_offset(over(holder), -60, -20)
    drag.click_and_hold().move_by_offset(110, 35).release().perform()
    browser.wait("return location.hash.includes('zoom=friction_x_rear')")
    near = scale(browser, holder)
    button = browser.driver.find_element(By.CSS_SELECTOR, "button[data-manoeuvre]")
    browser.js("arguments[0].click()", button)
    link = browser.driver.current_url
    browser.driver.get("about:blank")
    browser.driver.get(link)
    holder = browser.wait("const h = document.querySelector(\"[aria-label^='Rear · longitudinal']\"); return h && h.uplot && h")
    browser.settle()
    assert scale(browser, holder) == pytest.approx(near, rel=1e-4) and near != pytest.approx(home)
    assert not browser.driver.find_element(By.ID, "picked").get_attribute("hidden")
    # back at home, the link has no zoom
    ActionChains(browser.driver).double_click(over(holder)).perform()
    browser.wait("return !location.hash.includes('zoom=')")
    # the data are the chart's own
    points, text = browser.js(
        "const h = arguments[0], c = " + FIGURES + ".charts[+h.dataset.chart];"
        "return [c.clouds.reduce((n, p) => n + p.x.length, 0) + c.lines.reduce((n, l) => n + l.x.length, 0),"
        " h.closest('figure').querySelector('.saves').csv()]",
        holder,
    )
    rows = list(csv.DictReader(io.StringIO(text)))
    assert len(rows) == points and {"series", "slip ratio", "low", "high", "weight"} <= set(rows[0])
    fit = [r for r in rows if r["series"] == "fit" and r["low"]]
    assert fit and all(float(r["low"]) <= float(r["longitudinal friction Fx/Fz"]) <= float(r["high"]) for r in fit)


def test_rides_of_a_motorcycle_lead_to_one_another(explored, browser):
    links = {}
    for session in ("archive_s0001", "archive_s0002", "archive_s0008"):
        browser.open(explored / f"report/{session}.html")
        links[session] = browser.js("return [...document.querySelectorAll('.beside a')].map(a => [a.rel, a.getAttribute('href')])")
    assert links["archive_s0001"] == [["next", "archive_s0002.html"]]
    assert links["archive_s0002"] == [["prev", "archive_s0001.html"]]
    assert links["archive_s0008"] == []


def test_all_rides_of_a_motorcycle_are_one_tyre(explored, browser):
    """It comes first, with the values and intervals of the table `tyres`; a motorcycle of one ride has none."""
    import pyarrow.parquet as pq

    rows = pq.read_table(explored / "tyres", partitioning=None).to_pylist()
    pooled = {(r["tyre"], r["coefficient"]): r for r in rows if r["bike_id"] == "archive_01"}
    browser.open(explored / "report/tyres.html")
    assert place(browser, "archive_01", "front") == 0 and place(browser, "archive_02", "front") == -1
    assert browser.js("return document.getElementById('tyre-a').selectedOptions[0].textContent").startswith("archive_01 front, all 2 rides")
    for tyre in ("front", "rear"):
        i = place(browser, "archive_01", tyre)
        for coefficient, band, of in [("cornering_stiffness_0", "stiffness", "1"), ("camber_stiffness_0", "camber", "t.parameters.side_force_ratio")]:
            row = pooled[tyre, coefficient]
            y, low, high = browser.js(
                f"const t = {FIGURES}.tyres[arguments[0]], b = t.off(arguments[1], 0), y = {of} * t.kAlpha(0); return [y, y - b.low, y + b.high]", i, band
            )
            assert y == pytest.approx(row["value"], rel=1e-6)
            assert [low, high] == pytest.approx([row["ci95_low"], row["ci95_high"]], rel=3e-3)
        row = pooled[tyre, "mf_d"]
        choose(browser, "tyre-a", i)
        choose(browser, "show", "longitudinal")
        radius = (
            "const r = [...document.querySelectorAll('#numbers-body tr')].find(r => r.textContent.startsWith('Radius'));"
            "return [...r.querySelectorAll('td')].map(e => e.textContent)"
        )
        # far from the loads of braking it has no interval, and the page says why
        choose(browser, "load", 4000)
        assert browser.js(radius)[1].startswith("far from the loads"), browser.js(radius)
        assert "No band at this load" in browser.driver.find_element(By.ID, "caption").text
        assert not any(r["ci95_low"] for r in downloaded(browser) if "all 2 rides" in r["tyre"])
        rest = browser.js(f"return {FIGURES}.tyres[arguments[0]].parameters.load_at_rest", i)
        choose(browser, "load", 10 * round(rest / 10))
        cells = browser.js(radius)
        load = float(browser.js("return document.getElementById('load').value"))
        assert float(cells[0]) == pytest.approx(row["value"] * load, abs=1)
        assert [float(end) for end in cells[1].split(" to ")] == pytest.approx([row[end] * load for end in ("ci95_low", "ci95_high")], abs=1)
    # a link to it
    link = browser.driver.current_url
    assert "archive_01%2F%2Frear" in link
    browser.driver.get("about:blank")
    browser.driver.get(link)
    browser.wait(f"const d = document.getElementById('data'); return d && d.csv && {FIGURES}")
    assert browser.js("return document.getElementById('tyre-a').value") == str(place(browser, "archive_01", "rear"))


def test_the_slip_of_the_peak_has_its_interval(explored, browser):
    """At the load at rest it is that of the session's page, as a slip ratio in per cent."""
    import pyarrow.parquet as pq

    table = pq.read_table(explored / "coefficients", partitioning=None).to_pylist()
    known = {(r["session_id"], r["tyre"]): r for r in table if r["coefficient"] == "peak_slip"}
    kappa = lambda sigma: 100 * sigma / (1 + sigma)
    browser.open(explored / "report/tyres.html")
    i = place(browser, "archive_s0001", "rear")
    row = known["archive_s0001", "rear"]
    assert row["status"] == "ok"
    choose(browser, "tyre-a", i)
    choose(browser, "tyre-b", "")
    rest = browser.js(f"return {FIGURES}.tyres[arguments[0]].parameters.load_at_rest", i)
    choose(browser, "load", 10 * round(rest / 10))
    cells = browser.js(
        "const r = [...document.querySelectorAll('#numbers-body tr')].find(r => r.textContent.startsWith('Slip there'));"
        "return [...r.querySelectorAll('td')].map(e => e.textContent)"
    )
    found = [float(cells[0]), *(float(end) for end in cells[1].split(" to "))]
    assert found == pytest.approx([kappa(row[k]) for k in ("value", "ci95_low", "ci95_high")], abs=0.2), cells
