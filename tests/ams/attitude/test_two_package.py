"""CR's attitude from two packages: closed form, iteration, singular attitudes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ams.attitude.two_package import angles_from_gravity, closed_form, iterate_dwell
from ams.errors import SolveError
from ams.frames import AXES
from ams.models.cr import CrPair, CrSensor, model_gravity_g, sting_gravity_g

DEG = np.pi / 180
# CR table 3
PAIR = CrPair(
    {
        "x": CrSensor("x", 1.25, 0.51, 0.05 * DEG, 0.06 * DEG),
        "y": CrSensor("y", 1.27, 0.47, 0.12 * DEG, 0.15 * DEG),
        "z": CrSensor("z", 1.19, 0.54, 0.11 * DEG, 0.11 * DEG),
    },
    {
        "x": CrSensor("x", 1.26, 0.52, 0.08 * DEG, 0.08 * DEG),
        "y": CrSensor("y", 1.28, 0.49, 0.10 * DEG, 0.09 * DEG),
        "z": CrSensor("z", 1.20, 0.53, 0.09 * DEG, 0.12 * DEG),
    },
)


def outputs(pitch, yaw, roll):
    gravity = sting_gravity_g(np.atleast_1d(pitch), np.atleast_1d(yaw))
    turned = model_gravity_g(gravity, np.atleast_1d(roll))
    sting = {a: s.bias_v + gravity @ s.k for a, s in PAIR.sting.items()}
    return sting, {a: s.bias_v + turned @ s.k for a, s in PAIR.model.items()}


def away(low, high):
    return st.floats(low, high) | st.floats(-high, -low)


@given(away(0.01, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_closed_form_finds_every_attitude_within_its_branch(pitch, yaw, roll):
    found = closed_form(PAIR, *outputs(pitch, yaw, roll))
    assert found.flags == ("",)
    assert found.pitch_rad[0] == pytest.approx(pitch, abs=1e-10)
    assert found.yaw_rad[0] == pytest.approx(yaw, abs=1e-9)
    assert np.cos(found.roll_rad[0] - roll) == pytest.approx(1.0, abs=1e-14)


def test_closed_form_follows_the_reports_profile():
    # CR IV-B: Θ = Ψ = Φ from 0 to 10 degrees, figures 7 and 8: errors at rounding level.
    angle = np.linspace(0, 10, 1001)[1:] * DEG
    found = closed_form(PAIR, *outputs(angle, angle, angle))
    for values in (found.pitch_rad, found.yaw_rad, found.roll_rad):
        np.testing.assert_allclose(values, angle, rtol=0.0, atol=1e-9 * DEG)


def test_closed_form_follows_the_reports_harmonic_profile():
    # CR table 4's motion; where pitch passes zero yaw is amplified by 1 / sin Θ, which the 0.01° of the ramp bounds.
    time_s = np.arange(16_000) / 1000.0
    pitch, yaw, roll = (10.0 * DEG * np.sin(2.0 * np.pi * rate_hz * time_s) for rate_hz in (0.125, 0.0625, 0.25))
    away_from_zero = np.abs(pitch) > 0.01 * DEG
    wanted = [entry[away_from_zero] for entry in (pitch, yaw, roll)]
    found = closed_form(PAIR, *outputs(*wanted))
    for values, truth in zip((found.pitch_rad, found.yaw_rad, found.roll_rad), wanted, strict=True):
        np.testing.assert_allclose(values, truth, rtol=0.0, atol=1e-9 * DEG)


@pytest.mark.parametrize(
    ("pitch", "yaw", "words", "lost"),
    [
        (0.0, 0.3, "yaw singular", "yaw_rad"),
        (0.4, np.pi / 2, "sign of pitch", "pitch_rad"),
        (np.pi / 2, 0.0, "roll singular", "roll_rad"),
    ],
)
def test_singular_attitudes_are_flagged_and_not_stated(pitch, yaw, words, lost):
    gravity = sting_gravity_g(np.array([pitch]), np.array([yaw]))
    found = angles_from_gravity(gravity, model_gravity_g(gravity, np.array([0.2])))
    assert words in found.flags[0]
    assert np.isnan(getattr(found, lost)[0])


def test_at_no_pitch_the_other_angles_are_still_given():
    gravity = sting_gravity_g(np.array([0.0]), np.array([0.0]))
    found = angles_from_gravity(gravity, model_gravity_g(gravity, np.array([0.2])))
    assert found.pitch_rad[0] == 0.0
    assert found.roll_rad[0] == pytest.approx(0.2)


def test_iteration_agrees_with_the_closed_form_without_noise():
    angles = np.array([0.15, -0.2, 0.4])
    sting, model = outputs(*angles)
    found = iterate_dwell(PAIR, sting, model, sd_v=1e-4)
    np.testing.assert_allclose(found.angles_rad, angles, atol=1e-11)
    far = iterate_dwell(PAIR, sting, model, sd_v=1e-4, start_rad=np.array([0.05, 0.0, 0.0]))
    np.testing.assert_allclose(far.angles_rad, angles, atol=1e-10)


def test_iteration_states_the_spread_that_monte_carlo_finds():
    rng = np.random.default_rng(12)
    angles, sd, count = np.array([0.25, -0.3, 0.6]), 1e-4, 8
    sting, model = outputs(*angles)
    found = []
    for _ in range(1500):
        noisy = [{a: v + rng.normal(0, sd, count) for a, v in package.items()} for package in (sting, model)]
        found.append(iterate_dwell(PAIR, *noisy, sd_v=sd))
    spread = np.cov(np.array([f.angles_rad for f in found]).T)
    stated = found[0].covariance_rad2
    np.testing.assert_allclose(np.sqrt(np.diag(spread)), np.sqrt(np.diag(stated)), rtol=0.06)
    assert np.mean([f.standard_error for f in found]) == pytest.approx(1.0, abs=0.01)


def test_iteration_uses_both_packages_and_is_never_worse_than_the_closed_form():
    rng = np.random.default_rng(13)
    angles, sd = np.array([0.25, -0.3, 0.6]), 1e-4
    sting, model = outputs(*angles)
    both, closed = [], []
    for _ in range(1000):
        noisy = [{a: v + rng.normal(0, sd, 1) for a, v in package.items()} for package in (sting, model)]
        both.append(iterate_dwell(PAIR, *noisy, sd_v=sd).angles_rad)
        c = closed_form(PAIR, *noisy)
        closed.append([c.pitch_rad[0], c.yaw_rad[0], c.roll_rad[0]])
    assert np.all(np.std(both, axis=0) < 1.02 * np.std(closed, axis=0))
    assert np.std(both, axis=0)[0] < 0.8 * np.std(closed, axis=0)[0]


def test_iteration_refuses_a_singular_attitude_in_words():
    with pytest.raises(SolveError, match="pitch is zero"):
        iterate_dwell(PAIR, *outputs(0.0, 0.0, 0.1), sd_v=1e-4)
    with pytest.raises(SolveError, match="singular attitude"):
        iterate_dwell(PAIR, *outputs(0.0, 0.0, 0.1), sd_v=1e-4, start_rad=np.zeros(3))
    assert AXES == ("x", "y", "z")
