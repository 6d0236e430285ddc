"""A zero that follows gravity beyond what is declared is told; one within the limit, or a steady zero, is not."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

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


EARTH = "rotation of the Earth"


def _turning(g_dps_per_g: float, ground_dps: np.ndarray, seed: int) -> Observations:
    """Three gyros on a table that turns pitch, yaw or roll at four rolls; gravity and the ground by rotations alone."""
    noise, steps = np.random.default_rng(seed), np.arange(0.0, 360.0, 5.0)
    turns = [(roll, axis) for roll in (0.0, 90.0, 180.0, -90.0) for axis in (1, 0, 2) if axis < 2 or roll == 0.0]
    points = [(roll, axis, rate) for roll, axis in turns for rate in (-40.0, -10.0, 10.0, 40.0)]
    seen, felt = [], []
    for roll, axis, rate in points:
        angles = np.zeros((steps.size, 3))  # pitch, yaw, roll
        angles[:, 2] = roll
        angles[:, axis] += steps * np.sign(rate)
        to_package = Rotation.from_euler("YZX", angles, degrees=True).inv()
        rolled = Rotation.from_euler("X", angles[:, 2:], degrees=True).inv()
        stage = np.array([[0.0, rate, 0.0], [0.0, 0.0, rate], [rate, 0.0, 0.0]][axis])
        seen.append(
            rolled.apply(np.tile(stage, (steps.size, 1))).mean(axis=0) + to_package.apply(ground_dps).mean(axis=0)
        )
        felt.append(to_package.apply([0.0, 0.0, -1.0]).mean(axis=0))
    order = np.concatenate([noise.permutation(len(points)) for _ in range(4)])
    outputs = {}
    for index, axis in enumerate("xyz"):
        along = noise.standard_normal(3)
        dps = np.array(seen) @ (np.eye(3)[index] + 0.005 * noise.standard_normal(3))
        dps = dps + g_dps_per_g * np.array(felt) @ (along / np.linalg.norm(along))
        outputs[axis] = 0.02 + 1.25 * dps[order] + 3e-4 * noise.standard_normal(order.size)
    rate_dps = np.zeros((len(points), 3))
    for row, (_, axis, rate) in enumerate(points):
        rate_dps[row, axis] = rate
    still, rolls = np.zeros(order.size), np.deg2rad([roll for roll, *_ in points])
    return Observations(
        np.repeat(np.arange(4), len(points)), order, still, rolls[order], outputs,
        yaw_rad=still, euler_rate_rad_s=np.deg2rad(rate_dps[order]), time_s=30.0 * np.arange(order.size),
    )  # fmt: skip


def _told(g_dps_per_g: float, ground_dps: np.ndarray, limit_dps_per_g: float | None, seed: int) -> list[Finding]:
    limit = () if limit_dps_per_g is None else (limit_dps_per_g,)
    errors = tuple(SharedError(G_SENSITIVITY, "specific-force", each / 3.0**0.5, "limit") for each in limit)
    request = CalibrationRequest(model="gyro", shared_errors=dict.fromkeys("xyz", errors))
    axes = calibrate(_turning(g_dps_per_g, ground_dps, seed), request).axes.values()
    return [said for axis in axes for said in axis.findings if said.is_significant]


@pytest.mark.parametrize("g_dps_per_g", [0.001, 0.004, 0.008])
def test_gravity_within_its_declared_limit_is_not_taken_for_the_earth(g_dps_per_g: float) -> None:
    for seed in range(4):
        kinds = {said.kind for said in _told(g_dps_per_g, np.zeros(3), 0.01, seed)}
        assert not kinds & {"rate-undeclared", "lack-of-fit", "quadratic", "asymmetry"}


def test_gravity_of_which_nothing_is_declared_is_not_told_as_the_earth_alone() -> None:
    for seed in range(4):
        told = _told(0.004, np.zeros(3), None, seed)
        assert any(said.details.get("test") == GRAVITY for said in told)
        earth = [said for said in told if said.details.get("test") == EARTH]
        assert all("or gravity acts on the zero: these points do not tell which" in said.text for said in earth)


def test_an_earth_that_the_rates_lack_is_told_whatever_gravity_may_do() -> None:
    for seed in range(4):
        told = _told(0.0, np.array([0.0022, -0.0021, -0.0029]), 0.01, seed)
        named = [said for said in told if said.details.get("test") == EARTH]
        assert any("or gravity" not in said.text for said in named)
