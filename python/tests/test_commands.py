"""Commands as functions, and tables as frames."""

import json

import pytest

import roadbench
from conftest import ARCHIVE, roadbench as command


def test_a_log_is_inspected_as_on_the_command_line(log):
    found = roadbench.inspect(log, bikes=ARCHIVE / "bikes")
    assert found == json.loads(command("inspect", log, "--json", "--bikes", ARCHIVE / "bikes"))
    assert {"velocity_x", "roll"} <= {c["channel"] for c in found["channels"]}


def test_what_a_command_refuses_is_an_error_with_its_words(tmp_path):
    with pytest.raises(roadbench.Error, match="file not found"):
        roadbench.inspect(tmp_path / "none.csv")
    assert issubclass(roadbench.Rejected, roadbench.Error)


def test_a_bike_file_is_written_and_not_over_another(tmp_path):
    given = {"class_": "naked", "front": "120/70ZR17", "rear": "180/55ZR17", "weight": 265}
    path = roadbench.bike_new("mine", folder=tmp_path, **given)
    assert "wheelbase" in open(path).read()
    with pytest.raises(roadbench.Error):
        roadbench.bike_new("mine", folder=tmp_path, **given)
    assert roadbench.bike_new("mine", folder=tmp_path, force=True, **given) == path


def test_a_map_is_drafted():
    draft = roadbench.map(ARCHIVE.parent / "loggers" / "superbike.csv")
    assert "[channel.roll]" in draft


def test_an_output_is_verified_reported_and_shortened(log, tmp_path):
    roadbench.run(log, tmp_path, bikes=ARCHIVE / "bikes")
    assert roadbench.verify(tmp_path).sound
    assert open(roadbench.report(tmp_path)).read().startswith("<!doctype html>")
    session = log.stem
    assert session in roadbench.forget(tmp_path, sessions=[session], dry_run=True)
    [table] = [t for t in (tmp_path / "coefficients").rglob("*.parquet") if "_none" not in str(t)]
    table.write_bytes(table.read_bytes()[:100])
    found = roadbench.verify(tmp_path)
    assert not found.sound and found.text


def test_tables_are_frames_and_shown_in_notebooks(log, bike):
    table = roadbench.run_session(log, bike)["coefficients"]
    frame = table.to_polars()
    assert frame.height == len(table) == table.to_arrow().num_rows == len(table.to_pandas())
    html = table._repr_html_()
    assert html.startswith("<table>") and html.count("<tr>") == 21
    assert ">value<" in html and "first 20" in html and 'title="' in html
