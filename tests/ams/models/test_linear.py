"""SR's straight lines: two levels, many levels, a magnet in place of a coil."""

import numpy as np
import pytest

from ams.errors import DesignError, ObservationsError
from ams.models.linear import fit_line, magnet_difference


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
