"""A zero that follows gravity beyond what is declared is told; one within the limit, or a steady zero, is not."""

import numpy as np
import pytest

from ams.analysis.diagnostics.declared.gravity_on_gyros import GRAVITY
from ams.calibration.calibrate import calibrate
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import G_SENSITIVITY, SharedError
from ams.observations import Observations

_G = np.array([0.006, -0.008, 0.0])
"""°/s per g along x, y, z: of length 0.01."""
_VOLTS_PER_DPS = 0.05


def _rows(g_sensitivity_dps_per_g: np.ndarray, *, alike: bool = False, seed: int = 5) -> Observations:
    """Six replications of a gyro along z on a table that turns roll, pitch or yaw, stopped at rolls of 0, 90, 180°."""
    noise = np.random.default_rng(seed)
    points = []
    for stage, roll_deg in (("roll", 0), ("pitch", 0), ("pitch", 180), ("yaw", 0), ("yaw", 180), ("yaw", 90)):
        roll = 0.0 if alike else np.deg2rad(roll_deg)
        for rate in (-100.0, -60.0, -20.0, 0.0, 20.0, 60.0, 100.0):
            euler_dps = rate * np.array([stage == "pitch", stage == "yaw", stage == "roll"])
            c, s = np.cos(roll), np.sin(roll)
            omega = np.array([euler_dps[2], c * euler_dps[0] + s * euler_dps[1], c * euler_dps[1] - s * euler_dps[0]])
            is_level = stage == "yaw" or rate == 0.0
            force = np.array([0.0, -s, -c]) if is_level else np.zeros(3)  # over whole turns the rest has no mean
            dps = omega @ np.array([0.002, -0.004, 1.0]) + (0.0 if alike else g_sensitivity_dps_per_g @ force)
            points.append((roll, *euler_dps, -0.02 + _VOLTS_PER_DPS * dps))
    roll, *euler_dps, output = np.tile(np.array(points), (6, 1)).T
    still = np.zeros(roll.size)
    return Observations(
        np.repeat(np.arange(6), len(points)),
        np.tile(np.arange(len(points)), 6),
        still,
        roll,
        {"z": output + 20e-6 * noise.standard_normal(roll.size)},
        yaw_rad=still,
        euler_rate_rad_s=np.deg2rad(np.stack(euler_dps, axis=1)),
    )


def _solved(rows: Observations, limit_dps_per_g: float | None) -> tuple[list[Finding], tuple[Finding, ...]]:
    limit = () if limit_dps_per_g is None else (limit_dps_per_g,)
    errors = tuple(SharedError(G_SENSITIVITY, "specific-force", each / 3.0**0.5, "limit") for each in limit)
    found = calibrate(rows, CalibrationRequest(model="gyro", shared_errors={"z": errors})).axes["z"].findings
    return [each for each in found if each.details.get("test") == GRAVITY], found


@pytest.mark.parametrize(("limit", "words"), [(0.0005, "beyond the declared 0.0005"), (None, "no limit of it is")])
def test_what_contradicts_the_declared_limit_is_told(limit: float | None, words: str) -> None:
    (told,), every = _solved(_rows(_G), limit)
    assert "the zero follows the attitude to gravity" in told.text
    assert words in told.text
    assert "largest_g_sensitivity_dps_per_g" in told.text
    assert not told.is_held
    assert told.details["size"] == pytest.approx(0.008, rel=0.1)  # x lies level in all that stand: not to be seen
    assert not any("lack of fit" in each.text and "it is contained" in each.text for each in every)


def test_what_the_declared_limit_holds_is_not_told() -> None:
    assert _solved(_rows(_G), 0.02)[0] == []


def test_a_zero_that_gravity_leaves_alone_is_not_blamed() -> None:
    assert all(_solved(_rows(0.0 * _G, seed=seed), None)[0] == [] for seed in range(12))


def test_attitudes_of_one_gravity_say_nothing() -> None:
    rows = _rows(_G, alike=True)
    assert _solved(rows, None)[0] == []
