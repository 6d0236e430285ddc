"""The low-pass filter is the Chebyshev filter its settings say."""

import numpy as np
import pytest

from ams.attitude.filters import (
    LowPass,
    LowPassStream,
    delay_s,
    gain,
    low_pass,
    low_pass_in_step,
    settling_samples,
)
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


@pytest.mark.parametrize("order", [1, 2, 5])
def test_the_delay_is_that_of_a_ramp(order):
    settings = LowPass(0.5, 50.0, order, is_two_way=False)
    ramp = np.arange(3000) / 50.0
    late = ramp - low_pass(settings, ramp)
    assert late[-1] == pytest.approx(delay_s(settings), rel=1e-6)


def test_a_slow_wave_forwards_stands_where_it_was():
    settings = LowPass(0.5, 50.0, is_two_way=False)
    wave = np.sin(2 * np.pi * 0.05 * np.arange(4000) / 50.0)
    found = low_pass_in_step(settings, wave)
    good = ~found.is_transient
    assert good.sum() > 3500
    np.testing.assert_allclose(found.samples[good], wave[good], atol=0.01)
    assert np.abs(low_pass(settings, wave) - wave)[good].max() > 0.1  # without it the wave is late


@pytest.mark.parametrize(("order", "cutoff_hz"), [(1, 3.0), (4, 10.0), (4, 7.3), (5, 12.0)])
def test_of_a_ramp_nothing_of_the_delay_is_left(order, cutoff_hz):
    """The delay of such filters is no whole number of samples: half of one would be an angle of whatever turns."""
    ramp = np.arange(2000.0)
    found = low_pass_in_step(LowPass(cutoff_hz, 100.0, order, is_two_way=False), ramp)
    good = ~found.is_transient
    assert good[400:-60].all()
    np.testing.assert_allclose(found.samples[good][300:], ramp[good][300:], atol=1e-6)


@pytest.mark.parametrize("is_two_way", [False, True])
def test_what_a_wrong_start_leaves_is_marked(is_two_way):
    settings = LowPass(0.5, 50.0, is_two_way=is_two_way)
    level = np.zeros(3000)
    level[0] = 1.0  # a first sample that is wrong: a forward filter takes it for the past
    found = low_pass_in_step(settings, level)
    assert np.abs(found.samples[~found.is_transient]).max() < 1e-3
    assert found.is_transient[0]
    assert not found.is_transient[1500]
    assert found.is_transient[-1]


def test_a_step_is_settled_when_it_says():
    settings = LowPass(0.5, 50.0, 4, 0.5, is_two_way=False)
    step = np.concatenate([np.zeros(1), np.ones(4000)])
    off = np.abs(low_pass(settings, step)[1:] - 1.0) > 1e-3
    assert np.flatnonzero(off)[-1] + 1 == settling_samples(settings)


@pytest.mark.parametrize("is_two_way", [False, True])
def test_what_is_missing_is_bridged_and_marked(is_two_way):
    settings = LowPass(2.0, 50.0, is_two_way=is_two_way)
    ramp = np.column_stack([np.arange(2000.0), 5.0 - np.arange(2000.0)])
    holed = ramp.copy()
    holed[1000:1003, 1] = np.nan
    found = low_pass_in_step(settings, holed)
    assert np.flatnonzero(found.is_bridged).tolist() == [1000, 1001, 1002]
    assert found.is_transient[1000:1003].all()
    good = ~found.is_transient
    np.testing.assert_allclose(found.samples[good][200:-200], ramp[good][200:-200], atol=0.1)
    with pytest.raises(ObservationsError, match="no sample is a number"):
        low_pass_in_step(settings, np.full(100, np.nan))


def test_a_stream_in_chunks_is_the_whole_and_one_bad_sample_spoils_nothing():
    settings = LowPass(0.5, 20.0, is_two_way=False)
    samples = np.random.default_rng(2).normal(size=(300, 3))
    stream = LowPassStream(settings)
    parts = [stream.feed(samples[part]) for part in (slice(0, 1), slice(1, 1), slice(1, 120), slice(120, 300))]
    np.testing.assert_allclose(np.concatenate(parts), low_pass(settings, samples), atol=1e-12)
    samples[50, 1] = np.nan
    samples[:2] = np.nan
    again = LowPassStream(settings)
    found = np.concatenate([again.feed(samples[:1]), again.feed(samples[1:60]), again.feed(samples[60:])])
    assert np.isnan(found[:2]).all()
    held = samples[2:].copy()
    held[48] = held[47]
    np.testing.assert_allclose(found[2:], low_pass(settings, held), atol=1e-12)
