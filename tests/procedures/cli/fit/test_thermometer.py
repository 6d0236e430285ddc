"""What offset and sensitivity over temperature are stated at rests on a thermometer: it is counted, or said."""

from pathlib import Path

import calrig
import numpy as np
import pandas as pd
import pytest
from example_files import EXAMPLE_RIG

from ams.exports.formats import load_set
from ams.frames import specific_force
from ams.inference.inference import Inference, Package
from procedures.cli.attitude.untested import untested_temperature
from procedures.cli.main import run_command

PLATEAUS_DEGC = (10.0, 25.0, 40.0, 40.0, 25.0, 10.0)
LIMIT_DEGC, OFFSET_V_PER_DEGC = 0.6, 2e-5
SAID = "no uncertainty of the thermometer is declared"


def _readings() -> pd.DataFrame:
    points = np.array([(p, r) for p in (-60.0, -30.0, 0.0, 30.0, 60.0) for r in (-180.0, -90.0, 0.0, 90.0)])
    pitch, roll = np.tile(points, (len(PLATEAUS_DEGC), 1)).T
    temperature = np.repeat(PLATEAUS_DEGC, len(points))
    force = specific_force(np.deg2rad(pitch), np.deg2rad(roll))
    noise = np.random.default_rng(5).normal(0.0, 2e-5, force.shape)
    read = 0.002 + OFFSET_V_PER_DEGC * (temperature - 25.0)[:, None] + 2.5 * force + noise
    columns = {
        "replication": np.repeat(np.arange(1, len(PLATEAUS_DEGC) + 1), len(points)),
        "point": np.tile(np.arange(1, len(points) + 1), len(PLATEAUS_DEGC)),
        "pitch_deg": pitch, "roll_deg": roll, "temperature_degc": temperature,
        **{f"s{axis}_v": read[:, index] for index, axis in enumerate("xyz")},
    }  # fmt: skip
    return pd.DataFrame(columns)


def _rig(folder: Path, uncertainty: str) -> Path:
    """The example, its chamber with a standard of its own; the limit as the certificate states it, or nothing."""
    text = EXAMPLE_RIG.read_text(encoding="utf-8").replace(
        "[environment.air]\n", '[environment.air]\nstandard = "probe"\n'
    )
    text += f'\n[standards.probe]\nserial = "T1"\ncertificate = "T-1"\ndue = 2099-01-01\n{uncertainty}'
    path = folder / "rig.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("uncertainty", [f'uncertainty_degc = {LIMIT_DEGC}\nkind = "limit"\n', ""])
def test_a_thermometer_with_a_certificate_is_counted_and_one_without_is_said(tmp_path: Path, uncertainty: str) -> None:
    axes = {axis: f"s{axis}_v" for axis in "xyz"}
    found = calrig.fit(
        _readings(), axes, rig=_rig(tmp_path, uncertainty), temperature="estimate", reference_temperature_degc=25.0
    )
    (solved,) = found.sensors.values()
    remarks = " ".join(solved.calibration.remarks)
    (offset,) = (p for p in solved.calibration.axes["x"].parameters if p.name == "offset_v")
    of_probe = OFFSET_V_PER_DEGC * LIMIT_DEGC / np.sqrt(3.0)
    if uncertainty:
        assert SAID not in remarks
        assert offset.standard_uncertainty > of_probe
    else:
        assert SAID in remarks
        assert offset.standard_uncertainty < of_probe


USED_DEGC, AT_DEGC = (10.0, 30.0), 22.0
OFFSET_LIMIT = 3e-5
"""V/°C, as a data sheet limits it."""


def _used(folder: Path, limits: str) -> Path:
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    sensor = "[sensors.SN1047]\n"
    assert text.count(sensor) == 1
    path = folder / "rig.toml"
    path.write_text(
        text.replace(sensor, f"{sensor}use_temperature_degc = {list(USED_DEGC)}\n{limits}"), encoding="utf-8"
    )
    return path


def test_what_a_sensor_does_where_it_is_used_is_counted_or_said(tmp_path: Path) -> None:
    """GUM 4.3.7: a limit of 3e-5 V/°C over the 12 °C to the farther end of its use is a rectangle."""
    rows, axes = _readings().assign(temperature_degc=AT_DEGC), {"x": "sx_v"}
    found = {
        limits: next(iter(calrig.fit(rows, axes, rig=_used(tmp_path, limits)).sensors.values())).calibration
        for limits in ("", f"largest_offset_tc_v_per_degc = {OFFSET_LIMIT}\n")
    }
    unknown, limited = (
        next(p for p in solved.axes["x"].parameters if p.name == "offset_v").standard_uncertainty
        for solved in found.values()
    )
    added = np.sqrt(limited**2 - unknown**2)
    assert added == pytest.approx(OFFSET_LIMIT * (AT_DEGC - USED_DEGC[0]) / np.sqrt(3.0), rel=1e-6)
    said = ["is to be used at 10 to 30 °C" in " ".join(solved.warnings) for solved in found.values()]
    assert said == [True, False]


def test_the_set_of_a_file_is_valid_where_the_sensor_is_used(tmp_path: Path) -> None:
    csv, stored = tmp_path / "obs.csv", tmp_path / "set.json"
    _readings().assign(temperature_degc=AT_DEGC).to_csv(csv, index=False)
    rig = _used(tmp_path, f"largest_offset_tc_v_per_degc = {OFFSET_LIMIT}\n")
    line = ["fit", csv, "--axis", "x=sx_v", "--rig", rig, "--sensor", "SN1047", "--set", stored]
    assert run_command([str(word) for word in line]) == 0
    assert load_set(stored).validity.temperature_degc == USED_DEGC
    assert load_set(stored).document["temperature_recorded"] is True


def test_where_none_was_recorded_the_declared_range_is_the_validity_and_both_is_said(tmp_path: Path) -> None:
    """The key had no effect there: a row at 60 °C was answered without a flag."""
    csv, stored = tmp_path / "obs.csv", tmp_path / "set.json"
    _readings().drop(columns="temperature_degc").to_csv(csv, index=False)
    rig = _used(tmp_path, f"largest_offset_tc_v_per_degc = {OFFSET_LIMIT}\n")
    line = ["fit", csv, "--axis", "x=sx_v", "--rig", rig, "--sensor", "SN1047", "--set", stored]
    assert run_command([str(word) for word in line]) == 0
    coefficients = load_set(stored)
    assert coefficients.validity.temperature_degc == USED_DEGC
    assert coefficients.document["temperature_recorded"] is False
    warnings, remarks = (" ".join(coefficients.document[name]) for name in ("warnings", "remarks"))
    assert "used at 10 to 30 °C, as declared, and no temperature was recorded with the readings" in warnings
    assert "use is flagged outside 10 to 30 °C, which is declared and not measured" in remarks
    rows = {"x_v": np.full(3, 0.1), "roll_deg": np.zeros(3), "temperature_degc": np.array([20.0, 29.0, 60.0])}
    found = Inference(Package(coefficients, {"x": "x_v"}), reading_sd_v=1e-4).answer(rows)
    assert found.flags == ("", "", "temperature outside the validity of the set")
    (said,) = untested_temperature([Package(coefficients, {"x": "x_v"})])
    assert "no temperature was recorded in the calibration, its range of use is declared" in said


def test_without_terms_of_temperature_nothing_is_said_of_the_thermometer(tmp_path: Path) -> None:
    found = calrig.fit(_readings(), {"x": "sx_v"}, rig=_rig(tmp_path, ""))
    (solved,) = found.sensors.values()
    assert SAID not in " ".join(solved.calibration.remarks)
