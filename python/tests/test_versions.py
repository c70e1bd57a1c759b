"""Files of a table's earlier version are read under the names of today."""

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import roadbench
from conftest import on_disk
from roadbench import _frames

FRAMES = ("polars", "pandas", "arrow")
FORMER = {"slip_ratio_front_peak": "slip_front_peak", "slip_ratio_rear_peak": "slip_rear_peak"}


@pytest.fixture(scope="module")
def both(written, tmp_path_factory):
    """An output with two months of three tables: the first as version 1 had them, the second as they are."""
    out = tmp_path_factory.mktemp("both")
    for name in ("manoeuvres", "coefficients", "signals", "sessions"):
        now = on_disk(written, name)
        former = {**FORMER, "term": None} if name != "sessions" else {}
        then = now.select([c for c in now.column_names if former.get(c, c)])
        then = then.rename_columns([former.get(c, c) for c in then.column_names])
        if name == "signals":  # truth values were numbers
            onto = pa.array([1.0] * then.num_rows)
            then = then.set_column(then.column_names.index("contact_rear"), "contact_rear", onto)
        for month, table in (("2026-04", then), ("2026-05", now)):
            file = out / name / "bike=archive_01" / f"{month}.parquet"
            file.parent.mkdir(parents=True, exist_ok=True)
            pq.write_table(table, file)
    return out


def halves(frame):
    columns = _frames.columns(frame)
    half = len(next(iter(columns.values()))) // 2
    return [{name: values[at : at + half] for name, values in columns.items()} for at in (0, half)]


def clean(values):
    return [None if x != x else x for x in values]


@pytest.mark.parametrize("frames", FRAMES)
def test_both_versions_have_the_names_of_today(both, written, frames):
    pytest.importorskip({"arrow": "pyarrow"}.get(frames, frames))
    tables = roadbench.read(both, frames=frames)
    now = on_disk(written, "manoeuvres")
    then, today = halves(tables["manoeuvres"])
    assert list(then) == now.column_names
    for column in FORMER:
        values = now[column].to_pylist()
        assert clean(then[column]) == clean(today[column]) == values and any(values), column
    then, today = halves(tables["coefficients"])
    assert set(clean(then["term"])) == {None} and "crown radius" in today["term"]
    then, today = halves(tables["signals"])
    assert set(then["contact_rear"]) == {True}
    assert tables.units["manoeuvres"]["slip_ratio_front_peak"] == "1"
    assert tables.descriptions["coefficients"]["term"]
    part = tables.read("manoeuvres", columns=["slip_ratio_front_peak", "kind"])
    assert list(_frames.columns(part)) == ["slip_ratio_front_peak", "kind"]


@pytest.mark.parametrize("frames", FRAMES)
def test_former_names_are_there_if_asked_for(both, frames):
    pytest.importorskip({"arrow": "pyarrow"}.get(frames, frames))
    table = _frames.columns(roadbench.read(both, "manoeuvres", frames=frames, former_names=True))
    for column, former in FORMER.items():
        assert clean(table[former]) == clean(table[column])
    tables = roadbench.read(both, frames=frames, former_names=True)
    part = tables.read("manoeuvres", columns=["slip_front_peak", "kind"])
    assert list(_frames.columns(part)) == ["slip_front_peak", "kind"]
    assert "slip_front_peak" not in _frames.columns(roadbench.read(both, "manoeuvres", frames=frames))


def test_a_lazy_frame_reads_both(both):
    pl = pytest.importorskip("polars")
    lazy = roadbench.read(both, "manoeuvres", lazy=True, former_names=True)
    count = lazy.filter(pl.col("slip_front_peak") < 0).select(pl.len()).collect().item()
    eager = roadbench.read(both, "manoeuvres", frames="polars")
    assert count == eager.filter(pl.col("slip_ratio_front_peak") < 0).height > 0


def test_a_schema_knows_its_former_names():
    schema = roadbench.schema("bikes")
    assert (schema.version, schema.former("posterior"), schema.former("shift")) == (2, "found", None)
    assert (schema.kind("posterior"), schema.nullable("posterior")) == ("Float64", True)
    assert roadbench.schema("bikes.v1").names == schema.names and roadbench.schema("sessions").version == 1
