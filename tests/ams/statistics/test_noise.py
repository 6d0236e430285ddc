"""Allan deviation against NIST's published values and against noise of known law."""

import numpy as np
import pytest

from ams.errors import ObservationsError
from ams.statistics.noise import allan_deviation, read_coefficients


def nist_test_suite():
    """NIST SP 1065, 12.4: the 1000-point frequency data set by n ← 16807 n mod (2³¹ − 1), n₀ = 1234567890."""
    values, n = [], 1234567890
    for _ in range(1000):
        values.append(n / 2147483647)
        n = 16807 * n % 2147483647
    return np.array(values)


def test_nist_sp_1065_table_31():
    # Overlapping Allan deviation at averaging factors 1, 10 and 100.
    found = allan_deviation(nist_test_suite(), 1.0, [1, 10, 100])
    np.testing.assert_allclose(found.deviation, [2.922319e-01, 9.159953e-02, 3.241343e-02], rtol=2e-6)


def test_white_noise_reads_its_random_walk():
    rng = np.random.default_rng(2)
    found = allan_deviation(rng.normal(0, 0.3, 200_000), 0.01)
    expected = 0.3 / np.sqrt(found.tau_s / 0.01)
    assert np.all(np.abs(found.deviation / expected - 1) < 4 * found.relative_uncertainty + 0.01)
    assert read_coefficients(found).random_walk_per_sqrt_s == pytest.approx(0.3 * np.sqrt(0.01), rel=0.01)
    assert not read_coefficients(found).is_bottom_reached or found.deviation[-1] < 0.01


def test_a_walking_bias_rises_with_the_root_of_time():
    rng = np.random.default_rng(3)
    runs = [allan_deviation(np.cumsum(rng.normal(0, 1e-3, 4000)), 1.0, [64, 256]).deviation for _ in range(40)]
    mean = np.sqrt(np.mean(np.square(runs), axis=0))
    np.testing.assert_allclose(mean, 1e-3 * np.sqrt(np.array([64, 256]) / 3), rtol=0.12)


def test_a_steady_drift_is_drift_times_time_over_root_two():
    found = allan_deviation(np.arange(500) * 2e-3, 1.0, [1, 10, 100])
    np.testing.assert_allclose(found.deviation, 2e-3 * found.tau_s / np.sqrt(2), rtol=1e-9)


def test_the_stated_uncertainty_is_the_scatter_of_repeated_records():
    rng = np.random.default_rng(4)
    runs = [allan_deviation(rng.normal(size=1000), 1.0, [1, 16, 64]) for _ in range(300)]
    scatter = np.std([r.deviation for r in runs], axis=0) / np.mean([r.deviation for r in runs], axis=0)
    np.testing.assert_allclose(runs[0].relative_uncertainty, scatter, rtol=0.25)


def test_the_bottom_is_found_between_white_noise_and_walk():
    rng = np.random.default_rng(5)
    values = rng.normal(0, 1.0, 100_000) + np.cumsum(rng.normal(0, 3e-3, 100_000))
    found = read_coefficients(allan_deviation(values, 1.0))
    assert found.is_bottom_reached
    assert 128 <= found.bias_instability_tau_s <= 2048  # the laws cross at σ√3/K ≈ 577 s
    assert found.random_walk_per_sqrt_s == pytest.approx(1.0, rel=0.05)


@pytest.mark.parametrize("values", [np.zeros(2), np.array([1.0, np.nan, 2.0])])
def test_bad_records_are_refused(values):
    with pytest.raises(ObservationsError, match="three or more finite values"):
        allan_deviation(values, 1.0)


def test_an_averaging_time_beyond_half_the_record_is_refused():
    with pytest.raises(ObservationsError, match="allowed 1 to 50"):
        allan_deviation(np.zeros(100), 1.0, [51])
