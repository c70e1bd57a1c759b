"""The book's notebooks run from their first cell to their last, and are kept without outputs."""

import ast
import json

import pytest

from conftest import ROOT

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
    pytest.importorskip("polars")
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setenv("MPLBACKEND", "agg")
    names, shown = executed(ROOT / "book" / "notebooks" / "first_fleet.ipynb")
    assert shown[1] == {"inputs": 12, "computed": 12, "unchanged": 0, "rejected": 0}
    pictures = [figure._repr_png_() for figure in shown if hasattr(figure, "_repr_png_")]
    assert len(pictures) == 2 and all(p.startswith(b"\x89PNG") for p in pictures)
    assert (names["out"] / "cornering.png").stat().st_size > 10_000
    assert "[LONGITUDINAL_COEFFICIENTS]" in names["text"]
    [(intervals, hold, error)] = shown[-1].rows()
    assert intervals > 200 and 0.9 < hold <= 1.0 and error < 0.1
