"""A sensitive axis that turns with temperature: angles away from the mean were off, and it was "contained"."""

import numpy as np
import pytest

from ams.calibration.calibrate import calibrate
from ams.findings import Finding
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

POINTS = np.array([(p, r) for p in range(-60, 61, 15) for r in range(-180, 180, 45)], dtype=float)
PLATEAUS_DEGC = (10.0, 25.0, 40.0, 40.0, 25.0, 10.0)
REFERENCE_DEGC = 25.0
NOISE_G = 7.3e-6
"""1.5″ a dwell."""
TEST = "sensitive axis over temperature"


def _findings(turn_per_degc: float, seed: int, visit_rad: float = 0.0) -> list[list[Finding]]:
    """x turns towards y. Each visit to a plateau may turn by chance as well."""
    chance = np.random.default_rng(seed)
    order = np.concatenate([chance.permutation(len(POINTS)) for _ in PLATEAUS_DEGC])
    pitch, roll = np.deg2rad(POINTS[order]).T
    temperature = np.repeat(PLATEAUS_DEGC, len(POINTS))
    rise = temperature - REFERENCE_DEGC
    force = specific_force(pitch, roll)
    turned = turn_per_degc * rise + visit_rad * np.repeat(chance.standard_normal(len(PLATEAUS_DEGC)), len(POINTS))
    along = 2.5 * (force + 0.003 * np.roll(force, 1, axis=1))
    along[:, 0] += 2.5 * turned * force[:, 1]
    read = 0.002 + 2e-5 * rise[:, None] + along * (1.0 - 3e-5 * rise[:, None])
    read = read + 2.5 * NOISE_G * chance.standard_normal(read.shape)
    rows = Observations(
        np.repeat(np.arange(1, len(PLATEAUS_DEGC) + 1), len(POINTS)), order + 1, pitch, roll,
        dict(zip("xyz", read.T, strict=True)), temperature_degc=temperature,
        time_s=60.0 * np.arange(len(order)),
    )  # fmt: skip
    request = CalibrationRequest(temperature="estimate", reference_temperature_degc=REFERENCE_DEGC)
    return [[f for f in axis.findings if f.is_significant] for axis in calibrate(rows, request).axes.values()]


def _turning(findings: list[Finding]) -> list[Finding]:
    return [finding for finding in findings if finding.details.get("test") == TEST]


@pytest.mark.parametrize("ppm_per_degc", [1.0, 3.0])
def test_an_axis_that_turns_with_temperature_is_named_with_its_size(ppm_per_degc: float) -> None:
    for seed in range(6):
        of_x, of_y, of_z = _findings(1e-6 * ppm_per_degc, seed)
        (told,) = _turning(of_x)
        size, u = (float(told.details[name] or 0.0) for name in ("size", "standard_uncertainty"))
        assert size == pytest.approx(2.5e-6 * ppm_per_degc, abs=4.0 * u)
        assert not told.is_held
        assert not any(finding.kind == "drift" for finding in of_x)
        assert not _turning(of_y)
        assert not _turning(of_z)


def test_axes_that_stay_or_turn_by_chance_at_every_visit_are_not_put_down_to_temperature() -> None:
    still = [bool(_turning(axis)) for seed in range(20) for axis in _findings(0.0, 100 + seed)]
    by_chance = [bool(_turning(axis)) for seed in range(20) for axis in _findings(0.0, 200 + seed, visit_rad=2e-5)]
    assert np.mean(still) <= 0.02
    assert np.mean(by_chance) <= 0.05
