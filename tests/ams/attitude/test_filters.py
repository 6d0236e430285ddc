"""The low-pass filter is the Chebyshev filter its settings say."""

import numpy as np
import pytest

from ams.attitude.filters import LowPass, gain, low_pass
from ams.errors import ObservationsError


def chebyshev_gain(settings, frequency_hz):
    """|H| = 1/√(1 + ε² T_n²(Ω)) relative to zero frequency, Ω the ratio of the tangents of the bilinear transform."""
    epsilon = np.sqrt(10 ** (settings.ripple_db / 10) - 1)
    ratio = np.tan(np.pi * frequency_hz / settings.sample_rate_hz) / np.tan(
        np.pi * settings.cutoff_hz / settings.sample_rate_hz
    )
    polynomial = np.where(
        ratio <= 1,
        np.cos(settings.order * np.arccos(np.minimum(ratio, 1))),
        np.cosh(settings.order * np.arccosh(np.maximum(ratio, 1))),
    )
    at_rest = 1 / np.sqrt(1 + epsilon**2) if settings.order % 2 == 0 else 1.0
    return 1 / np.sqrt(1 + epsilon**2 * polynomial**2) / at_rest


@pytest.mark.parametrize("order", [1, 3, 4, 7])
@pytest.mark.parametrize("is_two_way", [False, True])
def test_gain_is_the_chebyshev_polynomial(order, is_two_way):
    settings = LowPass(0.5, 20.0, order, 0.5, is_two_way)
    frequency = np.array([0.05, 0.2, 0.45, 0.5, 0.8, 2.0])
    expected = chebyshev_gain(settings, frequency)
    np.testing.assert_allclose(gain(settings, frequency), expected**2 if is_two_way else expected, rtol=1e-7)


@pytest.mark.parametrize("is_two_way", [False, True])
@pytest.mark.parametrize("order", [3, 4])
def test_a_settled_signal_passes_unchanged(is_two_way, order):
    samples = np.column_stack([np.full(400, 2.5), np.full(400, -1.0)])
    np.testing.assert_allclose(low_pass(LowPass(0.5, 20.0, order, 0.5, is_two_way), samples), samples, rtol=1e-9)


def test_a_slow_wave_passes_and_a_fast_one_does_not():
    time_s = np.arange(4000) / 50.0
    slow, fast = np.sin(2 * np.pi * 0.1 * time_s), np.sin(2 * np.pi * 5.0 * time_s)
    found = low_pass(LowPass(0.5, 50.0), slow + fast)
    middle = slice(1000, 3000)
    np.testing.assert_allclose(found[middle], slow[middle], atol=0.03)
    assert np.std(found[middle] - slow[middle] * gain(LowPass(0.5, 50.0), np.array([0.1]))[0]) < 1e-4


def test_forwards_only_it_looks_at_the_past_only():
    samples = np.random.default_rng(1).normal(size=300)
    settings = LowPass(0.5, 20.0, is_two_way=False)
    np.testing.assert_allclose(low_pass(settings, samples)[:150], low_pass(settings, samples[:150]), atol=1e-14)


@pytest.mark.parametrize("cutoff_hz", [0.0, -1.0, 10.0, float("nan")])
def test_a_cut_off_outside_the_band_is_refused(cutoff_hz):
    with pytest.raises(ObservationsError, match="half the sample rate"):
        LowPass(cutoff_hz, 20.0)


@pytest.mark.parametrize("settings", [{"order": 0}, {"order": 13}, {"ripple_db": 0.0}])
def test_a_filter_that_cannot_be_built_is_refused(settings):
    with pytest.raises(ObservationsError, match="allowed order 1 to 12"):
        LowPass(0.5, 20.0, **settings)


def test_bad_samples_are_refused():
    with pytest.raises(ObservationsError, match="not finite"):
        low_pass(LowPass(0.5, 20.0), np.array([1.0, np.nan, 1.0]))
    with pytest.raises(ObservationsError, match="12 or more"):
        low_pass(LowPass(0.5, 20.0), np.zeros(11))
