"""Angles of CR's two packages through their sets: the report's own motions, and what CR's iteration gives."""

from collections.abc import Sequence

import numpy as np
from cr_iteration import covariance_rad2, iterate_dwell, predict
from cr_outputs import MISALIGNMENT, TABLE_3_MODEL, TABLE_3_STING
from solved_sets import package_set
from stated_lines import answered_in_both_ways, stated_set

from ams.models.cr import model_gravity_g, sting_gravity_g

DEG = np.pi / 180.0
FINEST_V = 1e-12
"""Readings so fine that no attitude of these motions is beside a singular one."""


def matrix(truth: dict[str, Sequence[float]]) -> np.ndarray:
    """Return the (3, 3) sensitivities to gravity of CR's table 3."""
    return np.stack([t[1] * MISALIGNMENT[axis](*np.deg2rad(t[2:])) for axis, t in truth.items()])


def answered_of(pitch: np.ndarray, yaw: np.ndarray, roll: np.ndarray) -> dict[str, np.ndarray]:
    gravity = sting_gravity_g(pitch, yaw)
    sting_v = gravity @ matrix(TABLE_3_STING).T + [t[0] for t in TABLE_3_STING.values()]
    model_v = model_gravity_g(gravity, roll) @ matrix(TABLE_3_MODEL).T + [t[0] for t in TABLE_3_MODEL.values()]
    sets = package_set("sting"), package_set("model")
    return dict(answered_in_both_ways(sets[0], sting_v, FINEST_V, model_set=sets[1], model_v=model_v).angle_rad)


def test_angles_follow_the_reports_profile() -> None:
    # CR IV-B: Θ = Ψ = Φ from 0 to 10 degrees, figures 7 and 8: errors at rounding level.
    angle = np.linspace(0, 10, 1001)[1:] * DEG
    for name, values in answered_of(angle, angle, angle).items():
        np.testing.assert_allclose(values, angle, rtol=0.0, atol=1e-9 * DEG, err_msg=name)


def test_angles_follow_the_reports_harmonic_profile() -> None:
    # CR table 4's motion; where pitch passes zero yaw is amplified by 1 / sin Θ, which the 0.01° of the ramp bounds.
    time_s = np.arange(16_000) / 1000.0
    pitch, yaw, roll = (10.0 * DEG * np.sin(2.0 * np.pi * rate_hz * time_s) for rate_hz in (0.125, 0.0625, 0.25))
    rows = np.abs(pitch) > 0.01 * DEG
    found = answered_of(pitch[rows], yaw[rows], roll[rows])
    for name, truth in (("pitch", pitch), ("yaw", yaw), ("roll", roll)):
        np.testing.assert_allclose(found[name], truth[rows], rtol=0.0, atol=1e-9 * DEG, err_msg=name)


def test_readings_that_are_all_as_uncertain_give_what_crs_iteration_gives() -> None:
    """Of six noisy outputs no attitude fits all: least squares of both ways is one, and so is its covariance."""
    chance, sd_v = np.random.default_rng(13), 1e-4
    k_sting, k_model = matrix(TABLE_3_STING), matrix(TABLE_3_MODEL)
    truth = chance.uniform((0.1, -1.0, -3.0), (1.2, 1.0, 3.0), (40, 3))
    noisy = np.stack([predict(k_sting, k_model, angles)[0] for angles in truth]) + sd_v * chance.normal(size=(40, 6))
    sting, model = (stated_set(kind, np.zeros(3), -k, 0.0) for kind, k in (("sting", k_sting), ("model", k_model)))
    found = answered_in_both_ways(sting, noisy[:, :3], sd_v, model_set=model, model_v=noisy[:, 3:])
    for row, start in enumerate(truth):
        angles = iterate_dwell(k_sting, k_model, noisy[row], start)
        sds = np.sqrt(np.diag(covariance_rad2(k_sting, k_model, angles, sd_v)))
        for name, angle, sd in zip(("pitch", "yaw", "roll"), angles, sds, strict=True):
            np.testing.assert_allclose(found.angle_rad[name][row], angle, atol=1e-9)
            np.testing.assert_allclose(found.sd_rad[name][row], sd, rtol=1e-6)
