"""The picture in README.md is one of the report as the program writes it now.

`ROADBENCH_BLESS=1 .ci/browser -k screenshot` takes it anew.
"""

import base64
import os
import subprocess

from conftest import PROGRAM, ROOT

PICTURE = ROOT / "reports/example.png"
RIDE = ROOT / "fixtures/archive/sessions/bike=archive_01/date=2026-05-01/archive_s0001.parquet"
WIDTH, HEIGHT = 1240, 1060
# Brightness of cells 20 pixels wide and high, 0 to 1: fonts and their smoothing differ from machine to machine, a curve,
# a table or a line of text that is not there any more changes more.
FURTHEST, MEAN = 0.25, 0.02

# A picture's cells, as numbers from 0 to 1.
CELLS = """
const [data, done] = arguments, image = new Image();
image.onload = () => {
  const canvas = document.createElement("canvas"), n = 20;
  [canvas.width, canvas.height] = [image.width, image.height];
  const pen = canvas.getContext("2d");
  pen.drawImage(image, 0, 0);
  const pixels = pen.getImageData(0, 0, image.width, image.height).data, cells = [];
  for (let y = 0; y + n <= image.height; y += n)
    for (let x = 0; x + n <= image.width; x += n) {
      let sum = 0;
      for (let i = 0; i < n * n; i++) {
        const at = 4 * ((y + Math.floor(i / n)) * image.width + x + i % n);
        sum += pixels[at] + pixels[at + 1] + pixels[at + 2];
      }
      cells.push(sum / (765 * n * n));
    }
  done([image.width, image.height, cells]);
};
image.src = "data:image/png;base64," + data;
"""


def test_screenshot(browser, tmp_path):
    run = [PROGRAM, "run", RIDE, "--bikes", ROOT / "fixtures/archive/bikes", "--out", tmp_path / "out"]
    done = subprocess.run(run, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    browser.size(WIDTH, HEIGHT)
    browser.open(tmp_path / "out/report/archive_s0001.html")
    browser.wait(
        "const h = [...document.querySelectorAll('h2, h3')].find(h => h.textContent.trim() == 'Tyres');"
        "if (h) window.scrollTo(0, h.getBoundingClientRect().top + scrollY - 64); return !!h;",
        what="the heading of the tyres",
    )
    browser.settle()
    browser.settle()
    taken = browser.cdp("Page.captureScreenshot", {"format": "png"})["data"]
    if os.environ.get("ROADBENCH_BLESS"):
        PICTURE.write_bytes(base64.b64decode(taken))
    kept = base64.b64encode(PICTURE.read_bytes()).decode()
    new, old = (browser.driver.execute_async_script(CELLS, data) for data in (taken, kept))
    assert new[:2] == old[:2] == [WIDTH, HEIGHT]
    apart = [abs(a - b) for a, b in zip(new[2], old[2])]
    mean = sum(apart) / len(apart)
    print(f"screenshot: cells differ by {mean:.4f} in the mean, {max(apart):.3f} at most")
    assert mean < MEAN and max(apart) < FURTHEST, (
        f"reports/example.png is not what the program shows ({mean:.4f}, {max(apart):.3f}): "
        "`ROADBENCH_BLESS=1 .ci/browser -k screenshot` takes it anew"
    )
