"""SR's straight lines: two levels, many levels, the flown chain."""

import numpy as np
import pytest

from ams.errors import DesignError, ObservationsError
from ams.models.linear import Line, compose, dwell_value, fit_line, magnet_difference

# SR 'Calibration and Conversion Equations': (regression gain, offset), scale, (calibration gain, offset).
FLOWN = {
    "accelerometer x": ((1.0030, -32.6208), 1333.0, (1.0032, 0.02066)),
    "accelerometer y": ((0.9826, 33.31), 1333.0, (1.0278, -0.0659)),
    "accelerometer z": ((0.9980, -9.81211), 1333.0, (1.0119, -0.0243)),
    "gyro x": ((0.9662439, -26.018), 14.375, (1.0443, 2.44732)),
    "gyro y": ((1.0212, 0.5418), 14.375, (0.9744, -0.561)),
    "gyro z": ((0.9896, 5.535), 14.375, (0.9962, -0.588447)),
}


@pytest.mark.parametrize("sensor", FLOWN)
def test_the_flown_chain_is_regression_then_scale_then_calibration(sensor):
    (r_gain, r_offset), counts, (c_gain, c_offset) = FLOWN[sensor]
    chain = compose([Line(r_gain, r_offset), Line(1 / counts, 0.0), Line(c_gain, c_offset)])
    raw = np.array([-1333.0, 0.0, 17.0, 1333.0])
    printed = (c_gain * (r_gain * raw + r_offset) / counts) + c_offset
    np.testing.assert_allclose(chain(raw), printed, rtol=1e-14, atol=1e-15)


def test_the_flown_accelerometer_x_reads_one_g_near_1333_counts():
    chain = compose([Line(1.0030, -32.6208), Line(1 / 1333, 0.0), Line(1.0032, 0.02066)])
    # By hand: 1.0030·1333 − 32.6208 = 1304.3782; /1333 = 0.978528…; ·1.0032 + 0.02066 = 1.002319…
    assert chain(np.array([1333.0]))[0] == pytest.approx(1.002319, abs=1e-6)


def test_two_levels_are_srs_two_equations():
    fit = fit_line(np.array([0.985, -1.021]), np.array([1.0, -1.0]))
    gain = 2.0 / (0.985 + 1.021)
    assert fit.line.gain == pytest.approx(gain, rel=1e-14)
    assert fit.line.offset == pytest.approx(1.0 - gain * 0.985, rel=1e-13)
    assert fit.degrees_of_freedom == 0
    assert fit.standard_error is None
    assert np.isnan(fit.covariance).all()
    with pytest.raises(DesignError, match="no degrees of freedom"):
        fit.half_width(np.array([0.0]))


# NIST StRD linear regression, dataset Norris (lower difficulty): certified values.
NORRIS = """0.1 0.2 338.8 337.4 118.1 118.2 888.0 884.6 9.2 10.1 228.1 226.5 668.5 666.3 998.5 996.3 449.1 448.6 778.9
777.0 559.2 558.2 0.3 0.4 0.1 0.6 778.1 775.5 668.8 666.9 339.3 338.0 448.9 447.5 10.8 11.6 557.7 556.0 228.3 228.1
998.0 995.8 888.8 887.6 119.6 120.2 0.3 0.3 0.6 0.3 557.6 556.8 339.3 339.1 888.0 887.2 998.5 999.0 778.9 779.0 10.2
11.1 117.6 118.3 228.9 229.2 668.4 669.1 449.2 448.9 0.2 0.5"""


def test_many_levels_agree_with_nist_norris():
    pairs = np.array(NORRIS.split(), dtype=float).reshape(-1, 2)
    fit = fit_line(pairs[:, 1], pairs[:, 0])
    assert pairs.shape == (36, 2)
    assert fit.line.gain == pytest.approx(1.00211681802045, rel=1e-12)
    assert fit.line.offset == pytest.approx(-0.262323073774029, rel=1e-11)
    assert np.sqrt(fit.covariance[0, 0]) == pytest.approx(0.429796848199937e-3, rel=1e-10)
    assert np.sqrt(fit.covariance[1, 1]) == pytest.approx(0.232818234301152, rel=1e-10)
    assert fit.standard_error == pytest.approx(0.884796396144373, rel=1e-11)
    assert fit.degrees_of_freedom == 34


def test_intervals_hold_the_truth_as_often_as_they_say():
    rng = np.random.default_rng(17)
    x = np.linspace(-2.0, 2.0, 7)
    line_held = new_held = 0
    for _ in range(2000):
        fit = fit_line(x, 1.5 * x + 0.2 + rng.normal(0, 0.1, x.size))
        at = np.array([1.3])
        truth = 1.5 * at + 0.2
        line_held += bool(abs(fit.line(at) - truth) < fit.half_width(at))
        new = truth + rng.normal(0, 0.1)
        new_held += bool(abs(fit.line(at) - new) < fit.half_width(at, new_reading_sd=fit.standard_error))
    assert 0.935 < line_held / 2000 < 0.965
    assert 0.935 < new_held / 2000 < 0.965


def test_a_dwell_value_is_not_moved_by_a_slow_drift():
    time_s = np.arange(300.0)
    drifting = dwell_value(time_s, 5.0 + 0.01 * (time_s - time_s.mean()))
    assert drifting.value == pytest.approx(5.0, abs=1e-12)
    assert drifting.slope_per_s == pytest.approx(0.01, rel=1e-12)
    assert drifting.standard_uncertainty < 1e-12


def test_a_dwell_value_has_the_uncertainty_of_a_mean():
    rng = np.random.default_rng(1)
    time_s = np.arange(50.0)
    dwells = [dwell_value(time_s, rng.normal(3.0, 0.2, 50)) for _ in range(3000)]
    assert np.std([d.value for d in dwells]) == pytest.approx(0.2 / np.sqrt(50), rel=0.05)
    assert np.mean([d.standard_uncertainty for d in dwells]) == pytest.approx(0.2 / np.sqrt(50), rel=0.02)


@pytest.mark.parametrize("time_s", [np.array([0.0, 1.0]), np.zeros(5)])
def test_a_dwell_needs_three_samples_at_different_times(time_s):
    with pytest.raises(ObservationsError, match="three samples"):
        dwell_value(time_s, np.zeros(time_s.size))


def test_levels_measured_alike_are_refused():
    with pytest.raises(DesignError, match="two different levels"):
        fit_line(np.array([1.0, 1.0, 1.0]), np.array([1.0, -1.0, 0.0]))


def test_the_magnets_field_is_the_mean_of_both_differences():
    found = magnet_difference(with_magnet=(1510.0, -1490.0), without_magnet=(310.0, -250.0))
    assert found.applied_field == 1220.0
    assert found.real == (290.0, -270.0)
    assert found.measured == (310.0, -250.0)


def test_a_magnet_that_moves_both_directions_alike_is_refused():
    with pytest.raises(ObservationsError, match="opposite senses"):
        magnet_difference(with_magnet=(500.0, 400.0), without_magnet=(300.0, 250.0))
