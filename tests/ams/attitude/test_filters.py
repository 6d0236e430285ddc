"""The low-pass filter is the Chebyshev filter its settings say."""

import numpy as np
import pytest

from ams.attitude.filters import LowPass, LowPassStream, delay_s, settling_samples
from ams.errors import ObservationsError


def filtered(settings, samples):
    return LowPassStream(settings).feed(samples)


def delay_samples(settings):
    """Return the delay, which the all-pass makes a whole number of samples."""
    late = delay_s(settings) * settings.sample_rate_hz
    assert late == pytest.approx(round(late), abs=1e-9)
    return round(late)


def gain(settings, frequency_hz):
    """Return the amplitude gain as it is: the transform of what one sample leaves, once the filter is at rest."""
    impulse = np.zeros(40_000)
    impulse[1] = 1.0
    turns = np.outer(frequency_hz / settings.sample_rate_hz, np.arange(impulse.size))
    return np.abs(np.exp(-2j * np.pi * turns) @ filtered(settings, impulse))


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
def test_gain_is_the_chebyshev_polynomial(order):
    settings = LowPass(0.5, 20.0, order, 0.5)
    frequency = np.array([0.05, 0.2, 0.45, 0.5, 0.8, 2.0])
    np.testing.assert_allclose(gain(settings, frequency), chebyshev_gain(settings, frequency), rtol=1e-7, atol=1e-12)


@pytest.mark.parametrize("order", [3, 4])
def test_a_settled_signal_passes_unchanged(order):
    samples = np.column_stack([np.full(400, 2.5), np.full(400, -1.0)])
    np.testing.assert_allclose(filtered(LowPass(0.5, 20.0, order, 0.5), samples), samples, rtol=1e-9)


def test_a_slow_wave_passes_at_its_own_time_and_a_fast_one_does_not():
    time_s, settings = np.arange(4000) / 50.0, LowPass(0.5, 50.0)
    slow, fast = np.sin(2 * np.pi * 0.05 * time_s), np.sin(2 * np.pi * 5.0 * time_s)
    late = delay_samples(settings)
    found = filtered(settings, slow + fast)[late:]
    np.testing.assert_allclose(found[1000:], slow[1000:-late], atol=0.01)
    assert np.abs(found[1000:-late] - slow[1000 + late : -late]).max() > 0.1  # without the delay the wave is late


@pytest.mark.parametrize("cutoff_hz", [0.0, -1.0, 10.0, float("nan")])
def test_a_cut_off_outside_the_band_is_refused(cutoff_hz):
    with pytest.raises(ObservationsError, match="half the sample rate"):
        LowPass(cutoff_hz, 20.0)


@pytest.mark.parametrize("settings", [{"order": 0}, {"order": 13}, {"ripple_db": 0.0}])
def test_a_filter_that_cannot_be_built_is_refused(settings):
    with pytest.raises(ObservationsError, match="allowed order 1 to 12"):
        LowPass(0.5, 20.0, **settings)


@pytest.mark.parametrize(("order", "cutoff_hz"), [(1, 0.5), (2, 0.5), (1, 3.0), (4, 10.0), (4, 7.3), (5, 12.0)])
def test_of_a_ramp_nothing_of_the_delay_is_left(order, cutoff_hz):
    """The delay of such filters is no whole number of samples: half of one would be an angle of whatever turns."""
    settings, ramp = LowPass(cutoff_hz, 100.0, order), np.arange(4000.0)
    late = delay_samples(settings)
    np.testing.assert_allclose(filtered(settings, ramp)[late:][2000:], ramp[2000:-late], atol=1e-6)


def test_a_wrong_start_is_forgotten_when_it_says():
    settings, level = LowPass(0.5, 50.0), np.zeros(3000)
    level[0] = 1.0  # a first sample that is wrong: the filter takes it for the past
    assert np.abs(filtered(settings, level)[settling_samples(settings) + 1 :]).max() < 1e-3


def test_a_step_is_settled_when_it_says():
    settings = LowPass(0.5, 50.0, 4, 0.5)
    step = np.concatenate([np.zeros(1), np.ones(4000)])
    off = np.abs(filtered(settings, step)[1:] - 1.0) > 1e-3
    assert np.flatnonzero(off)[-1] + 1 == settling_samples(settings)


def test_a_stream_in_chunks_is_the_whole_and_one_bad_sample_spoils_nothing():
    settings = LowPass(0.5, 20.0)
    samples = np.random.default_rng(2).normal(size=(300, 3))
    stream = LowPassStream(settings)
    parts = [stream.feed(samples[part]) for part in (slice(0, 1), slice(1, 1), slice(1, 120), slice(120, 300))]
    np.testing.assert_allclose(np.concatenate(parts), filtered(settings, samples), atol=1e-12)
    samples[50, 1] = np.nan
    samples[:2] = np.nan
    again = LowPassStream(settings)
    found = np.concatenate([again.feed(samples[:1]), again.feed(samples[1:60]), again.feed(samples[60:])])
    assert np.isnan(found[:2]).all()
    held = samples[2:].copy()
    held[48] = held[47]
    np.testing.assert_allclose(found[2:], filtered(settings, held), atol=1e-12)
