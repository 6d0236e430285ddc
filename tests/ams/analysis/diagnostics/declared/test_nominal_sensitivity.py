"""Laws of the nominal sensitivity: numbers in a unit of what is sensed change by one with one of it, or are no such.

Factors between units are those of the SI brochure and of NIST SP 811 (1 rad = 180/π °, 1 G = 100 µT,
1 gₙ = 9.80665 m/s²).
"""

from math import degrees

import numpy as np
import pytest

from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.findings import leaves_nothing
from ams.inputs.declared_direction import DeclaredDirection, NominalSensitivity
from ams.inputs.request import CalibrationRequest
from ams.models.straight_line import StraightLine
from ams.observations import Observations

FACTORS = {
    ("dps", "dps"): {"rad/s": 1.0 / degrees(1.0), "°/h": 3600.0},
    ("ut", "ut"): {"nT": 1000.0, "mG": 10.0, "gauss": 0.01},
    ("g", "g"): {"mg": 1000.0, "m/s²": 9.80665},
    ("mps2", "g"): {"look like g": 1.0},
}


def _calibrated(slope: float, unit: str, per: str, nominal: float, seed: int = 0, noise: float = 1e-4) -> Calibration:
    chance = np.random.default_rng(seed)
    level = np.tile(np.array([-1.0, 1.0]), 4)
    rows = Observations(
        np.repeat(np.arange(4), 2),
        np.tile(np.arange(2), 4),
        np.zeros(8),
        np.zeros(8),
        {"x": slope * level + 0.01 + noise * chance.standard_normal(8)},
        units={"x": unit},
        reference_level=level,
    )
    declared = DeclaredDirection("x", sensitivity=NominalSensitivity(nominal, unit, per))
    request = CalibrationRequest(
        nominal_axes={"x": "x"}, models={"x": StraightLine("x", per, unit)}, declared={"x": declared}
    )
    return calibrate(rows, request)


@pytest.mark.parametrize(
    ("unit", "per", "named", "factor"),
    [(*units, named, factor) for units, all_ in FACTORS.items() for named, factor in all_.items()],
)
def test_numbers_in_another_unit_are_told_with_the_unit_they_look_like(
    unit: str, per: str, named: str, factor: float
) -> None:
    nominal = 9.80665 if unit == "mps2" else 1.0
    solved = _calibrated(1.03 * factor, unit, per, nominal, noise=1e-4 * factor)
    (found,) = [finding for finding in solved.axes["x"].findings if finding.kind == "axis-contradicted"]
    assert named in found.text
    assert not found.is_held
    assert not leaves_nothing(found)
    assert solved.verdict == "not usable"


@pytest.mark.parametrize("slope", [0.55, 0.9, -1.0, 1.0, 1.9])
def test_a_sensor_that_has_its_unit_within_a_factor_of_two_is_told_nothing(slope: float) -> None:
    findings = _calibrated(slope, "dps", "dps", 1.0).axes["x"].findings
    assert not [finding for finding in findings if finding.kind == "axis-contradicted"]


def test_a_dead_channel_is_never_told_from_zero_and_usable() -> None:
    """One in a hundred looks as if it sensed something: numbers in °/s that sense so little are none."""
    for seed in range(400):
        findings = _calibrated(0.0, "dps", "dps", 1.0, seed).axes["x"].findings
        assert any(not finding.is_held or leaves_nothing(finding) for finding in findings), seed
