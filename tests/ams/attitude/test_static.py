"""Angles from outputs: TP's closed forms, Monte Carlo spread, and a flag at every singular geometry."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulated_campaign import OFFSET_V, VECTOR_V_PER_G, Campaign
from stated_lines import line_sensor, sensors_as_solved

from ams.attitude.flag_codes import PITCH_SINGULAR, ROLL_SINGULAR, SECOND_ROOT
from ams.attitude.static import (
    pitch_roll_from_three,
    pitch_roll_from_two,
    pitch_with_known_roll,
)
from ams.calibration.calibrate import calibrate
from ams.errors import DesignError
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.models.accelerometer import vector_from_angles

DEG = np.pi / 180
NO_COVARIANCE = np.zeros((4, 4))


def line(axis, s=2.5, coning_deg=0.5, azimuth_deg=35.0, b=0.01, sd=1e-5, covariance=NO_COVARIANCE):
    return line_sensor(b, vector_from_angles(axis, s, coning_deg * DEG, azimuth_deg * DEG), covariance, sd)


def outputs(sensors, pitch, roll):
    force = specific_force(np.atleast_1d(pitch), np.atleast_1d(roll))
    return np.stack([s.offset_v + force @ s.k_v_per_g for s in sensors], axis=-1)


PACKAGE = [line("x"), line("y", -2.4, 0.8, -100.0), line("z", 2.6, 0.3, 170.0)]

pitches = st.floats(-80 * DEG, 80 * DEG)
rolls = st.floats(-179.9 * DEG, 179.9 * DEG)


@given(pitches, rolls)
def test_three_axes_find_every_attitude(pitch, roll):
    found = pitch_roll_from_three(PACKAGE, outputs(PACKAGE, pitch, roll))
    assert found.flags == ("",)
    assert found.pitch_rad[0] == pytest.approx(pitch, abs=1e-11)
    assert found.roll_rad[0] == pytest.approx(roll, abs=1e-10)


@given(pitches, st.floats(-80 * DEG, 80 * DEG), st.booleans())
def test_x_and_y_find_roll_on_the_side_that_is_asked_for(pitch, roll, upright):
    roll = roll if upright else np.arctan2(np.sin(np.pi - roll), np.cos(np.pi - roll))
    found = pitch_roll_from_two(PACKAGE[:2], outputs(PACKAGE[:2], pitch, roll), upright=upright)
    assert found.flags == ("",)
    assert found.pitch_rad[0] == pytest.approx(pitch, abs=1e-9)
    assert np.sin(found.roll_rad[0] - roll) == pytest.approx(0.0, abs=1e-8)
    assert np.cos(found.roll_rad[0] - roll) > 0


@given(pitches, st.floats(10 * DEG, 170 * DEG), st.booleans())
def test_x_and_z_find_roll_on_the_side_that_is_asked_for(pitch, roll, right_wing_down):
    sensors = [PACKAGE[0], PACKAGE[2]]
    roll = roll if right_wing_down else -roll
    found = pitch_roll_from_two(sensors, outputs(sensors, pitch, roll), right_wing_down=right_wing_down)
    assert found.pitch_rad[0] == pytest.approx(pitch, abs=1e-9)
    assert np.sin(found.roll_rad[0] - roll) == pytest.approx(0.0, abs=1e-8)
    assert np.cos(found.roll_rad[0] - roll) > 0


def test_one_axis_is_tp_76_without_roll():
    # TP (76): α = arcsin((v − b)/S) + φ, with A = 90°, Ω = φ.
    b, s, phi = 0.02, 2.5, 1.5 * DEG
    sensor = line("x", s, 1.5, 90.0, b)
    v = np.array([0.5, -1.1, 2.0])
    found = pitch_with_known_roll(sensor, v, np.zeros(3))
    np.testing.assert_allclose(found.pitch_rad, np.arcsin((v - b) / s) + phi, atol=1e-14)
    # TP (78)
    expected_sd = sensor.reading_sd_v / (s * np.abs(np.cos(found.pitch_rad - phi)))
    np.testing.assert_allclose(found.pitch_sd_rad, expected_sd, rtol=1e-12)


@settings(max_examples=50)
@given(st.floats(-1.2, 1.2), rolls, st.floats(0, 0.3), rolls)
def test_one_axis_with_roll_is_tp_79_and_81(pitch, roll, coning, azimuth):
    s, b, sigma_v, sigma_r = -2.5, 0.1, 2e-5, 3e-4
    sensor = line_sensor(b, vector_from_angles("x", s, coning, azimuth), NO_COVARIANCE, sigma_v)
    v = b + s * (np.cos(coning) * np.sin(pitch) - np.sin(coning) * np.cos(pitch) * np.sin(roll + azimuth))
    found = pitch_with_known_roll(sensor, np.array([v]), np.array([roll]), sigma_r)
    sine = np.sin(roll + azimuth)
    printed = np.arcsin((v - b) / s / np.sqrt(np.cos(coning) ** 2 + sine**2 * np.sin(coning) ** 2)) + np.arctan(
        np.tan(coning) * sine
    )
    assert found.pitch_rad[0] == pytest.approx(printed, abs=1e-9)
    assert found.pitch_rad[0] == pytest.approx(pitch, abs=1e-7)
    slope = abs(np.cos(coning) * np.cos(pitch) + np.sin(coning) * np.sin(pitch) * sine)
    by_roll = np.sin(coning) * np.cos(pitch) * np.cos(roll + azimuth)
    expected = np.sqrt(sigma_v**2 / s**2 + by_roll**2 * sigma_r**2) / slope
    assert found.pitch_sd_rad[0] == pytest.approx(expected, rel=1e-5)


def test_three_axes_have_the_spread_of_tp_108():
    # TP (108): σ_α² = σ_x² cos²α + σ_y² sin²α and σ_R² = σ_y²/cos²α for ordinary weights; weighted by the inverse
    # variances σ_α² is the harmonic form 1/(cos²α/σ_x² + sin²α/σ_y²), and both agree at σ_x = σ_y.
    sigma = 1e-5
    for sd_y in (sigma, 10 * sigma):
        sensors = [line("x", 1.0, 0, 0, 0, sigma), line("y", 1.0, 0, 0, 0, sd_y), line("z", 1.0, 0, 0, 0, sd_y)]
        pitch = np.linspace(-80, 80, 17) * DEG
        found = pitch_roll_from_three(sensors, outputs(sensors, pitch, np.full(17, 0.7)))
        harmonic = 1 / np.sqrt(np.cos(pitch) ** 2 / sigma**2 + np.sin(pitch) ** 2 / sd_y**2)
        np.testing.assert_allclose(found.pitch_sd_rad, harmonic, rtol=1e-9)
        np.testing.assert_allclose(found.roll_sd_rad, sd_y / np.cos(pitch), rtol=1e-9)


@pytest.mark.parametrize("count", [2, 3])
def test_stated_spread_is_the_spread_of_monte_carlo(count):
    rng = np.random.default_rng(6)
    covariance = np.diag([2e-5, 3e-5, 1e-5, 2e-5]) ** 2
    sensors = [
        line("x", sd=2e-5, covariance=covariance),
        line("y", -2.4, 0.8, -100.0, sd=1e-4, covariance=covariance),
        line("z", 2.6, 5.0, 170.0, sd=5e-5, covariance=covariance),
    ][:count]
    pitch, roll, n = 0.6, 0.5, 20000
    force = specific_force(np.array([pitch]), np.array([roll]))[0]
    true_volts = np.empty((n, count))
    for j, sensor in enumerate(sensors):
        # the calibration errs and the reading is noisy; the set in use is the nominal one
        error = rng.multivariate_normal(np.zeros(4), covariance, n) @ np.concatenate([[1.0], force])
        true_volts[:, j] = sensor.offset_v + force @ sensor.k_v_per_g + error + rng.normal(0, sensor.reading_sd_v, n)
    infer = pitch_roll_from_two if count == 2 else pitch_roll_from_three
    found = infer(sensors, true_volts)
    assert np.std(found.pitch_rad) == pytest.approx(found.pitch_sd_rad.mean(), rel=0.02)
    assert np.std(found.roll_rad) == pytest.approx(found.roll_sd_rad.mean(), rel=0.02)
    held = np.mean(np.abs(found.pitch_rad - pitch) < 1.96 * found.pitch_sd_rad)
    assert 0.945 < held < 0.955


def test_three_axes_keep_pitch_and_lose_roll_at_the_vertical():
    found = pitch_roll_from_three(PACKAGE, outputs(PACKAGE, [np.pi / 2, -np.pi / 2], [0.3, 0.3]))
    np.testing.assert_allclose(np.abs(found.pitch_rad), np.pi / 2, atol=1e-7)
    assert np.isnan(found.roll_rad).all()
    assert np.isnan(found.roll_sd_rad).all()
    assert found.flags == ("roll singular", "roll singular")


def test_x_and_y_flag_roll_of_ninety_degrees():
    sensors = [line("x", coning_deg=0.0), line("y", coning_deg=0.0)]
    found = pitch_roll_from_two(sensors, outputs(sensors, [0.2], [np.pi / 2]) + np.array([[0.0, 1e-7]]))
    assert np.isnan(found.roll_rad[0])
    assert int(found.codes[0]) & ~SECOND_ROOT == ROLL_SINGULAR


def test_x_and_z_flag_roll_of_zero():
    sensors = [line("x", coning_deg=0.0), line("z", coning_deg=0.0)]
    found = pitch_roll_from_two(sensors, outputs(sensors, [0.2], [0.0]) + np.array([[0.0, 1e-7]]))
    assert np.isnan(found.roll_rad[0])
    assert int(found.codes[0]) & ~SECOND_ROOT == ROLL_SINGULAR


def test_two_axes_lose_both_angles_at_the_vertical():
    found = pitch_roll_from_two(PACKAGE[:2], outputs(PACKAGE[:2], [np.pi / 2], [0.3]))
    assert np.isnan(found.roll_rad[0])
    assert int(found.codes[0]) & ~SECOND_ROOT == PITCH_SINGULAR | ROLL_SINGULAR


def test_an_output_beyond_one_g_is_no_angle():
    found = pitch_with_known_roll(line("x"), np.array([0.0, 2.6]), 0.0)
    assert found.flags == ("", "output beyond one g")
    assert np.isnan(found.pitch_rad[1])
    pair = pitch_roll_from_two(PACKAGE[:2], np.array([[2.0, 2.0]]))
    assert pair.flags == ("outputs beyond one g",)


def test_one_axis_flags_the_vertical():
    found = pitch_with_known_roll(line("x", coning_deg=0.0), np.array([2.51]), 0.0)
    assert found.flags[0].startswith("pitch singular")
    assert np.isnan(found.pitch_sd_rad[0])


def test_noise_free_sensors_have_no_spread():
    sensors = [line(axis, sd=0.0) for axis in "xyz"]
    found = pitch_roll_from_three(sensors, outputs(sensors, [0.3], [0.4]))
    assert found.flags == ("",)
    assert found.pitch_sd_rad[0] == 0.0


def test_a_calibration_can_be_used_as_it_was_solved():
    campaign = Campaign(replications=4)
    solved = calibrate(campaign.observe(np.random.default_rng(8)), CalibrationRequest(extended="no"))
    sensors = sensors_as_solved(solved, 5e-6)
    pitch, roll = np.array([0.3, -0.9]), np.array([1.0, -2.5])
    force = specific_force(pitch, roll)
    true_v = np.stack([OFFSET_V[a] + force @ VECTOR_V_PER_G[a] for a in "xyz"], axis=-1)
    found = pitch_roll_from_three(sensors, true_v)
    assert np.all(np.abs(found.pitch_rad - pitch) < 4 * found.pitch_sd_rad)
    assert np.all(np.abs(found.roll_rad - roll) < 4 * found.roll_sd_rad)
    assert np.all(found.pitch_sd_rad < 5e-6)


def test_parallel_or_coplanar_sensors_are_refused():
    with pytest.raises(DesignError, match="parallel"):
        pitch_roll_from_two([line("x"), line("x")], np.zeros((1, 2)))
    with pytest.raises(DesignError, match="one plane"):
        pitch_roll_from_three([line("x"), line("x"), line("y")], np.zeros((1, 3)))
    with pytest.raises(DesignError, match="got 2 sensors, needed 3"):
        pitch_roll_from_three([line("x"), line("y")], np.zeros((1, 2)))


@pytest.mark.parametrize("factor", [1e-3, 50.0])
def test_angles_do_not_depend_on_the_unit_of_an_output(factor: float) -> None:
    """One axis behind an amplifier: its output, reading and calibration scale together, and tell what they told."""
    calibrated = np.diag([1e-10, 4e-10, 9e-10, 1e-10])
    sensors = [replace(sensor, covariance=calibrated) for sensor in PACKAGE]
    y = sensors[1]
    amplified = replace(
        y, primary=factor * y.primary, covariance=factor**2 * y.covariance, reading_sd_v=factor * y.reading_sd_v
    )
    rng = np.random.default_rng(3)
    read = outputs(PACKAGE, *rng.uniform(-1.2, 1.2, (2, 20))) + 1e-3 * rng.standard_normal((20, 3))
    plain = pitch_roll_from_three(sensors, read)
    scaled = pitch_roll_from_three([sensors[0], amplified, sensors[2]], read * np.array([1.0, factor, 1.0]))
    for name in ("pitch_rad", "roll_rad", "pitch_sd_rad", "roll_half_95_rad"):
        np.testing.assert_allclose(getattr(scaled, name), getattr(plain, name), rtol=1e-9)
