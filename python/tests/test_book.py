"""The examples of the chapter on Python run as they stand, one after the other; those on Spark have arguments that exist."""

import ast
import inspect
import shutil

import pytest

import roadbench
import roadbench.spark
from conftest import ARCHIVE, ROOT

CHAPTER = (ROOT / "book" / "src" / "python.md").read_text()
BEFORE, SPARK = CHAPTER.split("\n## On a Spark cluster\n")


def examples(text):
    """Blocks of Python, each with the line that it begins at."""
    parts = text.split("\n```")
    return [part.removeprefix("python\n") for part in parts[1::2] if part.startswith("python\n")]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """As the chapter asks for."""
    shutil.copytree(ARCHIVE, tmp_path / "archive")
    shutil.copytree(ARCHIVE / "bikes", tmp_path / "bikes")
    shutil.copy(next((ARCHIVE / "sessions").rglob("archive_s0001.parquet")), tmp_path / "ride.parquet")
    shutil.copy(ROOT / "fixtures" / "loggers" / "superbike.csv", tmp_path / "ride.csv")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    return tmp_path


def test_every_example_runs(folder, capsys):
    for needed in ("duckdb", "polars", "pandas", "pyarrow", "matplotlib", "altair", "vl_convert"):
        pytest.importorskip(needed)
    blocks = examples(BEFORE)
    assert len(blocks) > 14
    names, shown = {}, {}
    for number, block in enumerate(blocks, 1):
        for statement in ast.parse(block, f"python.md, example {number}").body:
            if isinstance(statement, ast.Expr):
                text = ast.unparse(statement)
                shown[text] = eval(compile(ast.Expression(statement.value), text, "eval"), names)
            else:
                exec(compile(ast.Module([statement], []), ast.unparse(statement), "exec"), names)
    # what the comments say comes out
    assert shown["session.units['sessions']['duration']"] == "s"
    assert shown["roadbench.schema('session').unit('roll')"] == "rad"
    assert shown["roadbench.schema('bikes').former('prior')"] == "taken"
    assert shown["list(session)"] == ["coefficients", "evidence", "manoeuvres", "warnings", "plots", "tyre_parameters", "sessions"]
    assert shown["(done['computed'], done['unchanged'], done['rejected_by_code'])"] == (12, 0, {})
    assert shown["roadbench.verify('tables').sound"] is True
    printed = capsys.readouterr().out
    assert "12 12 archive_s00" in printed and "no session `archive_s001`; did you mean `archive_s0" in printed
    assert (folder / "ride.html").stat().st_size > 700_000 and (folder / "ride.png").is_file()


def test_examples_on_spark_have_arguments_that_exist():
    calls = [node for block in examples(SPARK) for node in ast.walk(ast.parse(block)) if isinstance(node, ast.Call)]
    assert len(calls) == 2
    for call in calls:
        function = eval(ast.unparse(call.func), {"roadbench": roadbench})
        inspect.signature(function).bind(*call.args, **{word.arg: word.value for word in call.keywords})
