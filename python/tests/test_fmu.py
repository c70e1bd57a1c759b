"""The simulation unit of FMI 3.0, checked, compiled and run by FMPy, which knows nothing of roadbench."""

import csv
import os
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

import roadbench
from conftest import ARCHIVE, roadbench as command

fmpy = pytest.importorskip("fmpy")
if not (shutil.which("cc") and shutil.which("c++")):
    pytest.skip("there is no C compiler", allow_module_level=True)

from fmpy.build import build_platform_binary
from fmpy.validation import validate_fmu

KINDS = ["CoSimulation", "ModelExchange"]
FORCES = ["force_x", "force_y", "moment_x", "moment_z"]


@pytest.fixture(scope="module", params=["front", "rear"])
def unit(request, written, log, tmp_path_factory):
    """The unit of a tyre as a file, and the folder where an importer has compiled it."""
    place = tmp_path_factory.mktemp("fmu")
    file = place / f"{request.param}.fmu"
    arguments = ["--session", log.stem, "--format", "fmu", "--tyre", request.param, "--bikes", ARCHIVE / "bikes"]
    command("export", written, *arguments, "--out", file)
    folder = Path(fmpy.extract(file, unzipdir=place / "unit"))
    with pytest.MonkeyPatch.context() as patch:
        # cmake and ninja are in the virtual environment
        patch.setenv("PATH", os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]))
        patch.setenv("CFLAGS", "-Werror")
        build_platform_binary(folder, generator="Ninja", all_warnings=True)
    return file, folder


def parameters(folder):
    variables = fmpy.read_model_description(str(folder)).modelVariables
    return [v for v in variables if v.causality == "parameter"]


def simulated(folder, kind, inputs, output, stop, step=1.0, **start):
    return fmpy.simulate_fmu(
        str(folder),
        stop_time=stop,
        step_size=step,
        output_interval=step,
        fmi_type=kind,
        input=inputs,
        output=output,
        start_values=start,
    )


def test_it_keeps_to_the_standard(unit, written, log):
    file, folder = unit
    assert validate_fmu(str(file)) == []
    again = roadbench.export(written, log.stem, "fmu", tyre=file.stem, bikes=ARCHIVE / "bikes")
    assert again == file.read_bytes()
    with pytest.raises(ValueError, match="one tyre"):
        roadbench.export(written, log.stem, "fmu", bikes=ARCHIVE / "bikes")


@pytest.mark.parametrize("kind", KINDS)
def test_its_forces_are_those_of_the_tables(unit, kind):
    """The tables are the library's own arithmetic."""
    _, folder = unit
    lines = [line for line in open(folder / "documentation" / "tables.csv") if line[0] != "#"]
    rows = list(csv.DictReader(lines))
    names = ["slip_ratio", "slip_angle", "camber", "load"]
    columns = ["slip_ratio_1", "slip_angle_rad", "camber_rad", "load_N"]
    inputs = np.zeros(len(rows), dtype=[(name, float) for name in ["time", *names]])
    inputs["time"] = np.arange(len(rows))
    for name, column in zip(names, columns):
        inputs[name] = [float(row[column]) for row in rows]
    inputs = np.append(inputs, inputs[-1:])
    inputs["time"][-1] = len(rows)
    # the table has no lag
    got = simulated(folder, kind, inputs, [*FORCES, "ridden"], len(rows), relaxation_length=0.0)
    # in co-simulation what a step begins with is read at its end
    got = got[1:] if kind == "CoSimulation" else got[:-1]
    for name, column in zip(FORCES, ["Fx_N", "Fy_N", "Mx_Nm", "Mz_Nm"]):
        want = np.array([float(row[column]) for row in rows])
        off = np.abs(got[name] - want).max() / np.abs(want).max()
        print(f"fmu {kind} {name}: {len(rows)} rows, largest difference {off:.1e} of the peak")
        assert off < 2e-5, name  # the table has six decimals of slips
    # the table's ends are rounded: what is on them may be either
    ends = {p.name: float(p.start) for p in parameters(folder) if p.name.endswith(("_min", "_max"))}
    x = inputs[:-1]
    inside = np.ones(len(rows), bool)
    for name in names:
        high = ends[f"{name}_max"]
        low = ends.get(f"{name}_min", -high)
        edge = 1e-5 * (high - low)
        inside &= (x[name] > low + edge) & (x[name] < high - edge)
    ridden = np.array([row["ridden"] == "1" for row in rows])
    unit_says = np.asarray(got["ridden"]).astype(bool)
    assert not (unit_says & ~ridden).any()
    assert (unit_says[inside] == ridden[inside]).all()
    assert inside.sum() > 500 and (~ridden).any()


@pytest.mark.parametrize("kind", KINDS)
def test_its_slip_angle_lags(unit, kind):
    """First order over the rolled distance (eq. 1), integrated by the unit or by the importer."""
    _, folder = unit
    start = {p.name: p.start for p in parameters(folder)}
    radius, length = float(start["rolling_radius"]), float(start["relaxation_length"])
    inputs = {"slip_angle": 0.02, "wheel_speed": 30.0}
    got = simulated(folder, kind, None, ["lagged_slip_angle", "force_y"], 0.05, 0.001, **inputs)
    want = 0.02 * (1.0 - np.exp(-radius * 30.0 / length * got["time"]))
    assert np.abs(got["lagged_slip_angle"] - want).max() < 2e-5
    assert got["force_y"][0] == 0.0
    assert got["force_y"][-1] < -100.0


def test_it_rolls_as_the_coefficients_say(unit):
    """Radius and rolling resistance under the load at rest are the fitted ones."""
    _, folder = unit
    own = {p.name: float(p.start) for p in parameters(folder)}
    got = simulated(folder, "CoSimulation", None, ["effective_radius", "rolling_force"], 1.0)
    assert got["effective_radius"][-1] == pytest.approx(own["rolling_radius"], rel=1e-12)
    want = -own["rolling_resistance"] * own["nominal_load"]
    assert got["rolling_force"][-1] == pytest.approx(want, rel=1e-12)
    lean = {"camber": 0.5, "load": 1.5 * own["nominal_load"]}
    leant = simulated(folder, "CoSimulation", None, ["effective_radius", "rolling_force"], 1.0, **lean)
    # on the shoulder of the crown, and pressed in
    pressed = own["nominal_load"] / own["vertical_stiffness"]
    shoulder = (own["overturning_stiffness"] + pressed) * (1.0 - np.cos(0.5))
    radius = own["rolling_radius"] - shoulder - 0.5 * own["deflection_share"] * pressed
    assert leant["effective_radius"][-1] == pytest.approx(radius, rel=1e-9)
    assert leant["rolling_force"][-1] == pytest.approx(1.5 * want, rel=1e-12)
