"""A report made by the program from two rides with hostile texts, and a Chromium to read it with."""

import os
import shutil
import subprocess
import time
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("ROADBENCH", ROOT / "target/debug/roadbench"))

# Texts that want to be markup: in ids, names, paths and channel names.
CORPUS = [
    "</script><script>alert(1)</script>",
    "<img src=x onerror=alert(2)>",
    "\"><svg onload=alert(3)>",
    "' onmouseover='alert(4)",
    "{{ 7*7 }}{% raw %}${alert(5)}",
    "javascript:alert(6)",
    "<!--<script>\u2028alert(7)",
    "</title><b>bold</b>",
]


def hostile(source, target, session, bike, more):
    """A copy of a log with other names in its metadata, and a column that nobody knows."""
    table = pq.read_table(source)
    column = table.column("velocity_x")
    table = table.append_column(CORPUS[1], column)
    table = table.replace_schema_metadata(
        {**(table.schema.metadata or {}), "session_id": session, "bike_id": bike, **more}
    )
    pq.write_table(table, target)


@pytest.fixture(scope="session")
def report(tmp_path_factory):
    """The folder of the pages."""
    kept = os.environ.get("ROADBENCH_BROWSER_OUT")
    place = Path(kept) if kept else tmp_path_factory.mktemp("browser")
    out = place / "out"
    if not (out / "report/index.html").exists():
        logs, bikes = place / "logs", place / "bikes"
        logs.mkdir(parents=True)
        bikes.mkdir()
        bike = "tourer"
        shutil.copy(ROOT / "fixtures/archive/bikes/archive_01.toml", bikes / f"{bike}.toml")
        rides = ROOT / "fixtures/archive/sessions/bike=archive_01/date=2026-05-01"
        names = {"rider_id": CORPUS[0], "tyre_front": CORPUS[3], "tyre_rear": CORPUS[4], "site": CORPUS[6]}
        hostile(rides / "archive_s0001.parquet", logs / "one.parquet", CORPUS[1], bike, names)
        hostile(rides / "archive_s0002.parquet", logs / "two.parquet", CORPUS[2], bike, names)
        hostile(rides / "archive_s0001.parquet", logs / "three.parquet", CORPUS[7], bike, names)
        (logs / f"{CORPUS[1]}.csv").write_text(f"time;{CORPUS[2]}\n0;1\n")
        run = [PROGRAM, "run", logs, "--bikes", bikes, "--out", out, "--progress", "never"]
        done = subprocess.run(run, capture_output=True, text=True, timeout=600)
        assert done.returncode == 1, f"the CSV and an id with a slash are rejected: {done.stderr}"
        diagnose = [PROGRAM, "diagnose", logs / "two.parquet", "--bikes", bikes, "--out", out, "--nulls", "8"]
        done = subprocess.run(diagnose, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stderr
    return out / "report"


@pytest.fixture(scope="session")
def crowd(report, tmp_path_factory):
    """The same with 200 sessions more, of which nothing but their row is known: pages that share."""
    out = tmp_path_factory.mktemp("crowd") / "out"
    shutil.copytree(report.parent, out, ignore=shutil.ignore_patterns("report", "*.lock"))
    row = next((out / "sessions").glob("*/*.parquet"))
    table = pq.read_table(row, partitioning=None).slice(0, 1)
    for i in range(200):
        name = pa.array([f"more_{i:03}"], table.schema.field("session_id").type)
        at = table.schema.get_field_index("session_id")
        pq.write_table(table.set_column(at, table.schema.field(at), name), row.parent / f"more_{i:03}.parquet")
    done = subprocess.run([PROGRAM, "report", out], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    return out / "report"


@pytest.fixture(scope="session")
def archive(report, tmp_path_factory):
    """Of one session 1200 on 40 bikes, of which rows and coefficients are known: pages on demand."""
    out = tmp_path_factory.mktemp("archive") / "out"
    for name in ("sessions", "coefficients"):
        table = pq.read_table(next((report.parent / name).glob("*/*.parquet")), partitioning=None)
        table = table.filter(pc.equal(table["session_id"].cast("string"), table["session_id"][0].as_py()))
        at = [table.schema.get_field_index(column) for column in ("session_id", "bike_id")]
        for bike in range(40):
            folder = out / name / f"bike=bike_{bike:03}"
            folder.mkdir(parents=True)
            parts = []
            for session in range(30):
                one = table
                for place, text in zip(at, (f"ride_{bike:03}_{session:02}", f"bike_{bike:03}")):
                    field = table.schema.field(place)
                    one = one.set_column(place, field, pa.array([text] * len(table), field.type))
                parts.append(one)
            pq.write_table(pa.concat_tables(parts), folder / "all.parquet")
    done = subprocess.run([PROGRAM, "report", out], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert not list((out / "report").glob("ride_*")), "pages that nobody asked for"
    return out


class Browser:
    """Chromium, with what the tests ask of it again and again."""

    def __init__(self):
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium") or shutil.which("google-chrome")
        for argument in (
            "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
            "--disable-background-networking", "--disable-component-update", "--no-first-run",
            "--hide-scrollbars", "--window-size=1400,1000",
        ):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)
        self.cdp = self.driver.execute_cdp_cmd
        self.js = self.driver.execute_script
        # what an attack would call, counted before anything on the page runs
        count = "window.attacks = 0; window.alert = () => { window.attacks += 1; };"
        self.cdp("Page.addScriptToEvaluateOnNewDocument", {"source": count})
        self.size(1400, 1000)

    def size(self, width, height):
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.cdp("Emulation.setDeviceMetricsOverride", metrics)

    def media(self, kind="", scheme="light"):
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        self.cdp("Emulation.setEmulatedMedia", {"media": kind, "features": features})

    def open(self, page):
        self.driver.get_log("browser")
        self.driver.get_log("performance")
        self.driver.get(page.as_uri())
        # what is drawn is unpacked after the page is there
        ready = "const d = document.getElementById('data'); return !d || !!d.figures"
        self.wait(ready, what="the page's data")

    def wait(self, script, *arguments, what=None):
        """Until a script says something true; that."""
        end = time.monotonic() + 10
        while time.monotonic() < end:
            found = self.js(script, *arguments)
            if found:
                return found
            time.sleep(0.05)
        raise AssertionError(f"never: {what or script}")

    def settle(self):
        """Two frames and the observers' turn."""
        self.driver.execute_async_script(
            "const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 60)));"
        )


@pytest.fixture(scope="session")
def chromium():
    browser = Browser()
    yield browser
    browser.driver.quit()


@pytest.fixture
def browser(chromium):
    chromium.size(1400, 1000)
    chromium.media()
    return chromium
