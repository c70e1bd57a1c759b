"""The book's notebooks run from their first cell to their last, and are kept without outputs."""

import ast
import json
import sys

import pytest

import roadbench
from conftest import ROOT, on_disk

NOTEBOOKS = sorted((ROOT / "book" / "notebooks").glob("*.ipynb"))


def cells(path):
    return [c for c in json.loads(path.read_text())["cells"] if c["cell_type"] == "code"]


def executed(path):
    """The cells in order, in one name space, without a kernel; what each ends with."""
    names, shown = {"__name__": "__main__"}, []
    for number, cell in enumerate(cells(path)):
        where = f"{path.name}, code cell {number + 1}"
        body = ast.parse("".join(cell["source"]), where)
        last = None
        if isinstance(body.body[-1], ast.Expr):
            last = ast.Expression(body.body.pop().value)
        exec(compile(body, where, "exec"), names)
        shown.append(None if last is None else eval(compile(last, where, "eval"), names))
    return names, shown


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_nothing_of_a_run_is_kept(path):
    for cell in cells(path):
        assert cell["outputs"] == [] and cell["execution_count"] is None


def test_the_first_fleet(monkeypatch, tmp_path):
    for needed in ("polars", "matplotlib", "altair"):
        pytest.importorskip(needed)
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setenv("MPLBACKEND", "agg")
    names, shown = executed(ROOT / "book" / "notebooks" / "first_fleet.ipynb")
    out, first = names["out"], on_disk(names["out"], "sessions").sort_by("start_time")["session_id"][0].as_py()
    assert shown[1] == {"inputs": 12, "computed": 12, "unchanged": 0, "rejected": 0}
    [ride] = [each for each in shown if isinstance(each, roadbench.Session)]
    rows = [row for row in on_disk(out, "coefficients").to_pylist() if row["session_id"] == first]
    count = {status: sum(row["status"] == status for row in rows) for status in ("ok", "poorly_determined")}
    assert ride.id == first and f"{count['ok']} of {len(rows)} coefficients ok" in ride._repr_html_()
    assert shown[4].height == count["poorly_determined"] > 0
    [picture] = [figure._repr_png_() for figure in shown if hasattr(figure, "_repr_png_")]
    assert picture.startswith(b"\x89PNG")
    charts = [each.to_dict() for each in shown if isinstance(each, sys.modules["altair"].TopLevelMixin)]
    assert len(charts) == 2 and "hconcat" in charts[0]["vconcat"][0]
    fitted = [r for r in on_disk(out, "coefficients").to_pylist() if (r["status"], r["coefficient"]) == ("ok", "cornering_stiffness_0")]
    [bars] = charts[1]["datasets"].values()
    assert sorted(bar["value"] for bar in bars) == sorted(row["value"] for row in fitted) and len(fitted) > 12
    assert (out / "cornering.html").stat().st_size > 5_000
    assert any("The front tyre of B: rolling radius 4.8 % larger" in sentence for sentence in shown[9])
    assert "[LONGITUDINAL_COEFFICIENTS]" in names["text"]
    [(intervals, coverage, error)] = shown[-1].rows()
    assert intervals > 200 and 0.9 < coverage <= 1.0 and error < 0.1
