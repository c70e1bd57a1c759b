"""The report in real Chromium: what a reader does with it, and what a log must not do to it."""

import json
import shlex
import subprocess
import time

import pytest
from conftest import CORPUS, PROGRAM
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

# A4 less usual margins, px
PAPER = 718


def pages(report):
    found = sorted(report.glob("*.html"))
    assert len(found) == 6, f"run, fleet, tyres, two sessions, one diagnosis: {found}"
    return found


def session_page(report):
    return next(p for p in pages(report) if p.name not in ("index.html", "fleet.html", "tyres.html") and not p.name.startswith("diagnosis"))


def chart(browser, selector="[data-chart]"):
    """The first such chart, in the window and drawn."""
    holder = browser.driver.find_element(By.CSS_SELECTOR, selector)
    browser.js("for (let e = arguments[0]; e; e = e.parentElement) if (e.tagName === 'DETAILS') e.open = true", holder)
    browser.settle()
    browser.js("arguments[0].scrollIntoView({block: 'center'})", holder)
    browser.wait("return arguments[0].uplot && arguments[0].uplot.over", holder, what="drawn")
    browser.settle()
    return holder


def draw_all(browser):
    """Every section open, every chart once in the window."""
    browser.js("document.querySelectorAll('details').forEach(e => { e.open = true; })")
    browser.settle()
    for holder in browser.driver.find_elements(By.CSS_SELECTOR, "[data-chart]"):
        browser.js("arguments[0].scrollIntoView()", holder)
        # a chart that is only passed by may stay undrawn
        if browser.js("return !arguments[0].uplot", holder):
            browser.settle()


def over(holder):
    return holder.find_element(By.CSS_SELECTOR, ".u-over")


def scale(browser, holder):
    return browser.js("const s = arguments[0].uplot.scales; return [s.x.min, s.x.max, s.y.min, s.y.max]", holder)


def hint(holder):
    tip = holder.find_element(By.CSS_SELECTOR, ".tip")
    return tip.text if tip.is_displayed() else ""


def ink(browser, holder):
    return browser.js("return arguments[0].querySelector('canvas').toDataURL()", holder)


def test_pages_load_without_errors_or_requests(report, browser):
    for page in pages(report):
        browser.open(page)
        # every chart is drawn once
        draw_all(browser)
        browser.settle()
        log = browser.driver.get_log("browser")
        assert not log, f"{page.name}: {log}"
        events = [json.loads(e["message"])["message"] for e in browser.driver.get_log("performance")]
        asked = [e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"]
        others = [url for url in asked if url != page.as_uri() and not url.startswith("data:")]
        assert asked and not others, f"{page.name} asks for {others}"
        ready = browser.js("return performance.getEntriesByType('navigation')[0].loadEventEnd")
        print(f"{page.stat().st_size / 1e6:.2f} MB, ready after {ready:.0f} ms: {page.name}")
        assert ready < 5000, "far more than the second it may take on an idle machine"


def test_hover_shows_values_with_units(report, browser):
    browser.open(session_page(report))
    holder = chart(browser, "[aria-label^='Front · longitudinal']")
    # onto a point, so that the point speaks too
    x, y = browser.js(
        "const h = arguments[0], u = h.uplot, d = document.getElementById('data').figures;"
        "const c = d.charts[+h.dataset.chart].clouds[0], i = c.x.length >> 1;"
        "return [u.valToPos(c.x[i], 'x') - u.over.clientWidth / 2, u.valToPos(c.y[i], 'y') - u.over.clientHeight / 2]",
        holder,
    )
    ActionChains(browser.driver).move_to_element_with_offset(over(holder), round(x), round(y)).perform()
    text = hint(holder)
    assert "slip ratio" in text and "fit" in text and "95 % interval" in text, text
    assert "manoeuvre" in text and "wheel load" in text and text.count(" N") == 1, text
    holder = chart(browser, "[aria-label^='Coast-down']")
    ActionChains(browser.driver).move_to_element(over(holder)).perform()
    assert "m²/s²" in hint(holder) and " N" in hint(holder), hint(holder)


def test_legend_toggles_a_series(report, browser):
    browser.open(session_page(report))
    holder = chart(browser, "[aria-label^='Front · stiffness']")
    button = holder.find_element(By.XPATH, "following-sibling::div[contains(@class,'legend')]//button")
    before = ink(browser, holder)
    button.click()
    browser.settle()
    assert button.get_attribute("aria-pressed") == "false" and ink(browser, holder) != before
    button.click()
    browser.settle()
    assert button.get_attribute("aria-pressed") == "true" and ink(browser, holder) == before


def test_zoom_and_reset(report, browser):
    browser.open(session_page(report))
    for selector in ("[aria-label^='Rear · longitudinal']", "[data-panel]"):
        holder = chart(browser, selector)
        home = scale(browser, holder)
        drag = ActionChains(browser.driver).move_to_element_with_offset(over(holder), -60, -20)
        drag.click_and_hold().move_by_offset(110, 35).release().perform()
        browser.settle()
        near = scale(browser, holder)
        assert near[1] - near[0] < 0.6 * (home[1] - home[0]), (home, near)
        ActionChains(browser.driver).double_click(over(holder)).perform()
        browser.settle()
        assert scale(browser, holder) == pytest.approx(home)


def test_keyboard_does_what_the_mouse_does(report, browser):
    browser.open(session_page(report))
    holder = chart(browser, "[aria-label^='Rear · longitudinal']")
    home = scale(browser, holder)
    browser.js("arguments[0].focus()", holder)
    keys = lambda *k: (ActionChains(browser.driver).send_keys(*k).perform(), browser.settle())
    keys(Keys.ARROW_RIGHT)
    assert "slip ratio" in hint(holder)
    first = hint(holder)
    keys(*[Keys.ARROW_RIGHT] * 5)
    assert hint(holder) != first
    assert "slip ratio" in browser.driver.find_element(By.CSS_SELECTOR, "[aria-live]").get_attribute("textContent")
    keys("+")
    near = scale(browser, holder)
    assert near[1] - near[0] == pytest.approx(0.7 * (home[1] - home[0]))
    keys("-", Keys.ESCAPE)
    assert scale(browser, holder) == pytest.approx(home) and not hint(holder)
    # every chart and every tool can be reached by Tab
    unreachable = browser.js(
        "return [...document.querySelectorAll('[data-chart],[data-panel],button,a[href],summary')]"
        ".filter(e => e.tabIndex < 0).length"
    )
    assert unreachable == 0


def test_a_manoeuvre_is_picked_out_everywhere(report, browser):
    browser.open(session_page(report))
    holder = chart(browser, "[aria-label^='Front · longitudinal']")
    plain = ink(browser, holder)
    button = browser.driver.find_element(By.CSS_SELECTOR, "button[data-manoeuvre]")
    browser.js("arguments[0].click()", button)
    browser.settle()
    note = browser.driver.find_element(By.ID, "picked")
    assert note.is_displayed() and "highlighted on every chart" in note.text
    assert ink(browser, holder) != plain
    ActionChains(browser.driver).send_keys(Keys.ESCAPE).perform()
    browser.settle()
    assert not note.is_displayed() and ink(browser, holder) == plain
    # from the time line, by a click on a segment; and back by another
    panel = chart(browser, "[data-panel]")
    at = browser.js(
        "const u = arguments[0].uplot, s = document.getElementById('data').figures.segments.find(s => s.kind === 'cornering');"
        "return u.valToPos((s.start + s.end) / 2, 'x') - u.over.clientWidth / 2",
        panel,
    )
    ActionChains(browser.driver).move_to_element_with_offset(over(panel), round(at), 5).click().perform()
    browser.settle()
    assert note.is_displayed() and "cornering" in note.text, note.text
    cursors = browser.js("return [...document.querySelectorAll('[data-panel]')].map(e => e.uplot.cursor.left)")
    assert len(cursors) > 4 and max(cursors) - min(cursors) < 1.5 and min(cursors) > 0, "cursors go together"


def test_a_point_of_the_fleet_leads_to_its_session(report, browser):
    browser.open(report / "fleet.html")
    holder = chart(browser)
    x, y = browser.js(
        "const h = arguments[0], u = h.uplot, c = document.getElementById('data').figures.charts[+h.dataset.chart].clouds[0];"
        "return [u.valToPos(c.x[0], 'x') - u.over.clientWidth / 2, u.valToPos(c.y[0], 'y') - u.over.clientHeight / 2]",
        holder,
    )
    move = ActionChains(browser.driver).move_to_element_with_offset(over(holder), round(x), round(y))
    move.perform()
    assert "95 % interval" in hint(holder), hint(holder)
    ActionChains(browser.driver).click().perform()
    browser.wait("return location.pathname.endsWith('.html') && !location.pathname.endsWith('fleet.html')")


def test_hostile_texts_stay_texts(report, browser):
    seen = ""
    for page in pages(report):
        browser.open(page)
        draw_all(browser)
        browser.settle()
        assert browser.js("return window.attacks") == 0, page.name
        markup = browser.js(
            "return [...document.querySelectorAll('img, iframe, object, embed, b:not(.tip b), script[src], link, "
            "[onerror], [onload], [onmouseover], [onclick], [href^=\"javascript:\"]')].map(e => e.outerHTML)"
        )
        assert not markup, f"{page.name}: {markup}"
        assert browser.js("return document.querySelectorAll('script:not([type])').length") <= 3
        seen += browser.js("return document.documentElement.textContent") + browser.driver.title
    for text in (CORPUS[0], CORPUS[1], CORPUS[2], CORPUS[3], CORPUS[4], CORPUS[7]):
        assert text in seen, f"{text!r} is nowhere: the test would prove nothing"


def test_nothing_is_wider_than_a_phone(report, browser):
    for page in pages(report):
        browser.size(400, 800)
        browser.open(page)
        draw_all(browser)
        browser.settle()
        width = browser.js("return document.documentElement.scrollWidth")
        assert width <= 400, f"{page.name}: {width} px"
        cut = browser.js(
            "return [...document.querySelectorAll('canvas')].map(c => c.getBoundingClientRect()).filter(r => r.width && (r.left < 0 || r.right > 400.5)).length"
        )
        assert cut == 0, f"{page.name}: {cut} charts stick out"


def test_paper_shows_whole_charts(report, browser):
    for page in pages(report):
        browser.open(page)
        browser.size(PAPER, 1000)
        browser.media("print")
        browser.js("window.dispatchEvent(new Event('beforeprint'))")
        browser.settle()
        charts = browser.js(
            "return [...document.querySelectorAll('[data-chart], [data-panel]')].map(h => ["
            "  h.getAttribute('aria-label'), !!h.querySelector('canvas'), h.getBoundingClientRect().width,"
            "  h.querySelector('canvas')?.getBoundingClientRect().right])"
        )
        for name, drawn, width, right in charts:
            assert width == 0 or drawn, f"{page.name}: {name} is not drawn"
            assert width == 0 or right <= PAPER + 1, f"{page.name}: {name} ends at {right} px of {PAPER}"
        assert browser.js("return document.documentElement.scrollWidth") <= PAPER + 1, page.name
        browser.js("window.dispatchEvent(new Event('afterprint'))")
        browser.media()
        pdf = browser.cdp("Page.printToPDF", {"printBackground": True})["data"]
        assert len(pdf) > 20_000, "the pages as PDF"


def test_pages_of_many_sessions_share_their_script(crowd, report, browser):
    page = crowd / session_page(report).name
    assert page.stat().st_size + 85_000 < session_page(report).stat().st_size
    browser.open(page)
    chart(browser)
    log = browser.driver.get_log("browser")
    assert not log, log
    events = [json.loads(e["message"])["message"] for e in browser.driver.get_log("performance")]
    asked = {e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"}
    beside = {p.as_uri() for p in (crowd / "assets").iterdir()}
    assert len(beside) == 2 and asked == beside | {page.as_uri()}, asked
    for size in (1400, 400):
        browser.size(size, 900)
        browser.settle()
        assert browser.js("return document.documentElement.scrollWidth") <= size
    # the same file elsewhere lacks them, but not its tables
    assert browser.js("return document.querySelectorAll('.coefficients tbody tr').length") > 30


def rows(browser, part="#sessions"):
    return browser.driver.find_elements(By.CSS_SELECTOR, f"{part} tbody tr")


def told(browser, part="#sessions"):
    return browser.driver.find_element(By.CSS_SELECTOR, f"{part} output").text


def firsts(browser, part="#sessions"):
    return browser.js(f"return [...document.querySelectorAll('{part} tbody th')].map(e => e.textContent)")


def test_a_long_list_comes_by_fifties_and_is_searched(crowd, browser):
    browser.open(crowd / "index.html")
    browser.wait("return document.querySelector('#sessions output')")
    assert not browser.driver.get_log("browser")
    assert (len(rows(browser)), told(browser)) == (50, "1 to 50 of 202")
    first, back, on, last = browser.driver.find_elements(By.CSS_SELECTOR, "#sessions .tools button")
    assert not back.is_enabled() and not first.is_enabled()
    on.click()
    assert told(browser) == "51 to 100 of 202"
    last.click()
    assert (len(rows(browser)), told(browser)) == (2, "201 to 202 of 202") and not on.is_enabled()
    field = browser.driver.find_element(By.CSS_SELECTOR, "#sessions input")
    field.send_keys("TOURER more_15")
    assert (len(rows(browser)), told(browser)) == (10, "1 to 10 of 10")
    links = [a.get_attribute("href") for a in browser.driver.find_elements(By.CSS_SELECTOR, "#sessions tbody a")]
    assert links[0] == (crowd / "more_150.html").as_uri()
    field.clear()
    field.send_keys("</title><b>")
    assert len(rows(browser)) <= 1 and browser.js("return window.attacks + document.querySelectorAll('#sessions b').length") == 0
    field.clear()
    field.send_keys("more")
    # paper has all that was found, up to a thousand
    browser.js("window.dispatchEvent(new Event('beforeprint'))")
    assert len(rows(browser)) == 200
    browser.js("window.dispatchEvent(new Event('afterprint'))")
    assert len(rows(browser)) == 50
    browser.cdp("Emulation.setScriptExecutionDisabled", {"value": True})
    try:
        browser.driver.get((crowd / "index.html").as_uri())
        # without scripts nothing tells that the page is there
        end = time.monotonic() + 20
        while len(rows(browser)) < 50 and time.monotonic() < end:
            time.sleep(0.2)
        assert len(rows(browser)) == 50
        note = browser.driver.find_element(By.CSS_SELECTOR, "#sessions noscript p")
        assert "The first 50 of 202" in note.get_attribute("textContent") and note.size["height"] > 10
    finally:
        browser.cdp("Emulation.setScriptExecutionDisabled", {"value": False})


def test_a_long_list_is_sorted_and_turned_by_keys(crowd, browser):
    browser.open(crowd / "index.html")
    browser.wait("return document.querySelector('#sessions output')")
    heads = browser.driver.find_elements(By.CSS_SELECTOR, "#sessions thead th")
    as_it_is = firsts(browser)
    heads[0].find_element(By.TAG_NAME, "button").click()
    assert heads[0].get_attribute("aria-sort") == "ascending"
    up = firsts(browser)
    assert up == sorted(up, key=str.lower)
    heads[0].find_element(By.TAG_NAME, "button").click()
    assert heads[0].get_attribute("aria-sort") == "descending" and firsts(browser)[0] == "more_199"
    # durations go by their seconds, the longest first
    heads[3].find_element(By.TAG_NAME, "button").click()
    assert heads[3].get_attribute("aria-sort") == "descending" and not heads[0].get_attribute("aria-sort")
    times = browser.js("return [...document.querySelectorAll('#sessions tbody td:nth-child(4)')].map(e => e.textContent)")
    seconds = [sum(int(float(n)) * {"h": 3600, "min": 60, "s": 1}[u] for n, u in zip(t.split()[::2], t.split()[1::2])) for t in times]
    assert seconds == sorted(seconds, reverse=True), times
    field = browser.driver.find_element(By.CSS_SELECTOR, "#sessions input")
    keys = lambda *k: ActionChains(browser.driver).send_keys(*k).perform()
    field.click()
    keys(Keys.PAGE_DOWN)
    assert told(browser) == "51 to 100 of 202"
    keys(Keys.PAGE_UP)
    assert told(browser) == "1 to 50 of 202"
    browser.driver.find_elements(By.CSS_SELECTOR, "#sessions .tools button")[2].send_keys(Keys.END)
    assert told(browser) == "201 to 202 of 202"
    # on a button that has nothing more to do the keys still work
    keys(Keys.HOME)
    assert told(browser) == "1 to 50 of 202"
    # a phone has no heads: it has a choice instead, and shorter pages
    browser.size(400, 900)
    browser.settle()
    choice = browser.driver.find_element(By.CSS_SELECTOR, "#sessions select")
    assert choice.is_displayed() and told(browser) == "1 to 20 of 202"
    browser.js("arguments[0].value = '-1 1'; arguments[0].dispatchEvent(new Event('change'))", choice)
    assert firsts(browser) == as_it_is[:20]


def test_sections_fold_and_open_for_links_and_paper(report, browser):
    page = session_page(report)
    for width, most in ((1280, 5600), (400, 9000)):
        browser.size(width, 900)
        browser.open(page)
        browser.settle()
        assert browser.js("return document.documentElement.scrollHeight") < most, width
    browser.size(1280, 900)
    browser.settle()
    is_open = lambda id: browser.js(f"return document.querySelector('#{id} > details').open")
    assert is_open("coefficients") and is_open("fits") and not is_open("timeline") and not is_open("manoeuvres")
    assert browser.driver.find_element(By.CSS_SELECTOR, ".verdict").rect["y"] < 300
    browser.driver.find_element(By.CSS_SELECTOR, "nav a[href='#timeline']").click()
    browser.wait("return document.querySelector('#timeline > details').open")
    top = browser.js("return document.getElementById('timeline').getBoundingClientRect().top")
    assert 0 <= top < 400, top
    browser.wait("return document.querySelector('#timeline canvas')", what="drawn once it is seen")
    # the same link again, after somebody closed it
    browser.js("document.querySelector('#timeline > details').open = false")
    browser.driver.find_element(By.CSS_SELECTOR, "nav a[href='#timeline']").click()
    browser.wait("return document.querySelector('#timeline > details').open")
    # an address with a place in it
    browser.driver.get("about:blank")
    browser.driver.get(page.as_uri() + "#manoeuvres")
    browser.wait("return document.querySelector('#manoeuvres > details').open")
    closed = "return document.querySelectorAll('details.fold:not([open])').length"
    before = browser.js(closed)
    browser.js("window.dispatchEvent(new Event('beforeprint'))")
    assert before > 3 and browser.js(closed) == 0
    browser.js("window.dispatchEvent(new Event('afterprint'))")
    assert browser.js(closed) == before


def test_a_page_on_demand_is_a_command_until_it_is_there(archive, browser):
    index = archive / "report/index.html"
    browser.open(index)
    browser.wait("return document.querySelector('#sessions output')")
    height, nodes = browser.js("return [document.documentElement.scrollHeight, document.getElementsByTagName('*').length]")
    assert height < 6000 and nodes < 5000, (height, nodes)
    assert told(browser) == "1 to 50 of 1200" and told(browser, "#bikes") == "1 to 20 of 40"
    assert not browser.driver.find_elements(By.CSS_SELECTOR, "#sessions tbody a")
    browser.driver.find_element(By.CSS_SELECTOR, "#sessions tbody button").click()
    command = browser.driver.find_element(By.CSS_SELECTOR, ".demand code").text
    session = firsts(browser)[0]
    assert command.startswith(f"roadbench report {archive} --open=") and session in command, command
    done = subprocess.run([PROGRAM, *shlex.split(command)[1:]], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == str(archive / "report" / f"{session}.html")
    # the page of the run was not written again, and yet it links to the new page
    browser.open(index)
    browser.wait("return document.querySelector('#sessions tbody a')").click()
    browser.wait("return document.querySelector('h1').textContent === arguments[0]", session)
    assert len([l for l in browser.driver.get_log("browser") if l["level"] == "SEVERE"]) == 0
    # and a bike's page
    browser.open(archive / "report/bike_bike_007.html")
    browser.wait("return document.querySelector('#sessions output')")
    assert len(rows(browser)) == 30 and browser.js("return document.documentElement.scrollWidth") <= 1400


CONTRAST = """
const parse = c => { const m = c.match(/[\\d.]+/g).map(Number); return m.length > 3 ? m : [...m, 1]; };
const light = c => { const f = c.slice(0, 3).map(v => (v /= 255) <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4); return 0.2126 * f[0] + 0.7152 * f[1] + 0.0722 * f[2]; };
const ground = e => { for (; e; e = e.parentElement) { const c = getComputedStyle(e).backgroundColor; if (c.startsWith("rgb") && parse(c)[3] === 1) return parse(c); } return [255, 255, 255, 1]; };
const poor = [];
for (const e of document.body.querySelectorAll("*")) {
  if (!e.checkVisibility({ opacityProperty: true, visibilityProperty: true }) || e.closest("svg, .unseen, .skip")) continue;
  if (![...e.childNodes].some(n => n.nodeType === 3 && n.data.trim())) continue;
  const a = light(parse(getComputedStyle(e).color)), b = light(ground(e));
  const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  if (ratio < 4.5 && !(e.classList.contains("swatch"))) poor.push([ratio.toFixed(2), e.tagName, e.className, e.textContent.slice(0, 40)]);
}
return poor;
"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_texts_have_contrast(report, browser, scheme):
    for page in pages(report):
        browser.media(scheme=scheme)
        browser.open(page)
        browser.settle()
        poor = browser.js(CONTRAST)
        assert not poor, f"{page.name}: {poor[:5]}"
    ground = browser.js("return getComputedStyle(document.body).backgroundColor")
    assert (sum(map(int, ground[4:-1].split(","))) < 200) == (scheme == "dark"), ground


def test_charts_follow_the_theme(report, browser):
    browser.open(session_page(report))
    holder = chart(browser)
    light = ink(browser, holder)
    browser.media(scheme="dark")
    browser.settle()
    assert ink(browser, holder) != light
