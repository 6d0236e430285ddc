"""What a rig declares of its instruments reaches the uncertainty of every kind, by the amount that theory gives.

Stored runs are solved again under other declarations; the numbers to compare with are worked out here by hand.
"""

from dataclasses import replace
from math import hypot, radians, sqrt
from pathlib import Path
from typing import Any

import pytest
from case_shares import rest_to_thorough
from stored_runs import DATA, StoredCase

from ams.calibration_result import AxisCalibration
from procedures.journal.journal_reader import JournalReader
from procedures.kinds.solve import solve_record
from procedures.solution.record import RunRecord, read_record
from procedures.solution.request import SolvedSensor
from rig.description.rig_file import Level, LevelReading, RigDescription

VERSION = DATA / "runs_0_1_0"


def _record(kind: str, folder: Path) -> RunRecord:
    with JournalReader.open(StoredCase(VERSION / kind).copy("finished", folder / "run")) as reader:
        return read_record(reader)


def _solved(record: RunRecord, sensor: str, **changes: Any) -> SolvedSensor:
    rig: RigDescription = record.rig.model_copy(update=changes)
    solved = solve_record(replace(record, rig=rig))[sensor]
    assert solved.calibration is not None, solved.failure
    return solved


def _axis(solved: SolvedSensor, axis: str) -> AxisCalibration:
    assert solved.calibration is not None
    return solved.calibration.axes[axis]


def _parameter(solved: SolvedSensor, axis: str, index: int) -> tuple[float, float]:
    estimate = _axis(solved, axis).parameters[index]
    assert estimate.value is not None
    assert estimate.standard_uncertainty is not None
    return estimate.value, estimate.standard_uncertainty


@pytest.mark.parametrize(("axis", "u_ut"), rest_to_thorough(["x", "y", "z"], [0.05, 0.4, 20.0], every=4))
def test_a_coil_s_error_is_one_of_scale_in_the_gain(tmp_path: Path, u_ut: float, axis: str) -> None:
    """u(A)/A = u_B/B, and nothing of it is lost among the replications."""
    record = _record("two_level", tmp_path)
    coil = record.rig.field["coil"]
    bare, declared = (
        _solved(
            record, "MicroMag3", attitude_reference=None,
            field={"coil": coil.model_copy(update={"uncertainty_ut": each})},
        )
        for each in (0.0, u_ut)
    )  # fmt: skip
    slope, of_slope = _axis(bare, axis).primary[1], (1, 1)
    grown = _axis(declared, axis).primary_covariance[of_slope] - _axis(bare, axis).primary_covariance[of_slope]
    assert _axis(declared, axis).primary[1] == slope
    assert sqrt(grown) == pytest.approx(abs(slope) * u_ut / 40.0, rel=1e-6)
    gain, u_bare = _parameter(bare, axis, 0)
    if u_ut > 10.0:
        assert any("does not follow the reference" in text for text in _axis(declared, axis).warnings)
        return
    assert _parameter(declared, axis, 0) == (gain, pytest.approx(hypot(u_bare, abs(gain) * u_ut / 40.0), rel=1e-6))
    lines = {line.source: line for line in declared.budgets[axis].lines}
    assert lines["scale of field coil"].contributions["gain_ut_per_ut"] == pytest.approx(abs(gain) * u_ut / 40.0)


@pytest.mark.parametrize(("axes", "tilts"), [(("pitch",), 1), (("pitch", "yaw", "roll"), 2)])
def test_an_attitude_s_error_near_the_vertical_is_half_its_square(
    tmp_path: Path, axes: tuple[str, ...], tilts: int
) -> None:
    """1 − cos θ of the level for each of the two tilts that lead away from the vertical, always to the same side."""
    record, theta = _record("tumble_up_down", tmp_path), 2.0
    reference = record.rig.attitude_reference
    assert reference is not None
    channels = {axis: channel for axis, channel in reference.channels.items() if axis in axes}
    bare, declared = (
        _solved(record, "SCA3000", attitude_reference=reference.model_copy(update={
            "uncertainty_deg": each, "channels": channels,
        }))
        for each in (1e-9, theta)
    )  # fmt: skip
    (gain, u_bare), (same, u) = (_parameter(solved, "x", 0) for solved in (bare, declared))
    assert same == gain
    assert sqrt(u**2 - u_bare**2) == pytest.approx(gain * tilts * radians(theta) ** 2 / 2.0, rel=2e-3)
    assert declared.budgets["x"].lines[-1].source == "indices of the table"


def test_a_table_s_error_across_a_gyro_is_itself_in_its_direction(tmp_path: Path) -> None:
    """A package that stands turned by θ about the roll axis senses sin θ of a turn about the axis beside."""
    record, theta = _record("rates_gyro", tmp_path), 0.5
    roll = record.rig.axes["roll"].model_copy(update={"uncertainty_arcsec": 3600.0 * theta * sqrt(3.0)})
    bare = _solved(record, "ENC03J")
    declared = _solved(record, "ENC03J", axes={**record.rig.axes, "roll": roll})
    for axis, beside in (("y", 3), ("z", 2)):
        variance = _axis(declared, axis).primary_covariance - _axis(bare, axis).primary_covariance
        sensitivity = _parameter(bare, axis, 1)[0]
        assert sqrt(variance[beside, beside]) == pytest.approx(sensitivity * radians(theta), rel=1e-3)
    assert _parameter(declared, "x", 3)[1] == pytest.approx(theta, rel=1e-3), "its azimuth turns with the package"
    assert "indices of the table" in {line.source for line in declared.budgets["x"].lines}


def test_the_level_of_the_base_stands_in_the_budget_of_a_line(tmp_path: Path) -> None:
    """Two minutes of arc, near the vertical: half the square of a limit over √3."""
    record = _record("tumble_up_down", tmp_path)
    tilted = LevelReading(about_pitch_arcsec=7200.0, about_roll_arcsec=0.0)
    solved = _solved(record, "SCA3000", attitude_reference=None, level=Level(before=tilted))
    gain = _parameter(solved, "x", 0)[0]
    (line,) = (line for line in solved.budgets["x"].lines if line.source == "level of the base about pitch")
    u_rad = radians(7200.0 / 3600.0) / sqrt(3.0)
    assert line.contributions["gain_g_per_g"] == pytest.approx(gain * u_rad**2 / 2.0, rel=0.02)
    assert "read up to 7200″" in line.stated
