"""The five terms of noise at rest, from records whose spectrum is drawn by the definition of each."""

import numpy as np
import pytest

from ams.errors import ObservationsError
from ams.statistics.noise import AllanDeviation, allan_deviation
from ams.statistics.noise_terms import TERMS, columns_of, noise_terms

COUNT = 1 << 13


def record(chance: np.random.Generator, truth: tuple[float, float, float, float, float]) -> np.ndarray:
    """One value a second; flicker by its spectrum B²/(2πf), two-sided, shaped over twice the length."""
    q, n, b, k, r = truth
    frequency = np.fft.rfftfreq(2 * COUNT)
    frequency[0] = frequency[1]
    drawn = chance.normal(size=frequency.size) + 1j * chance.normal(size=frequency.size)
    flicker = np.fft.irfft(drawn * b * np.sqrt(COUNT / (2.0 * np.pi * frequency)), 2 * COUNT)[:COUNT]
    quantised = np.diff(q * chance.normal(size=COUNT + 1))
    walk = np.cumsum(k * chance.normal(size=COUNT))
    return quantised + n * chance.normal(size=COUNT) + flicker + walk + r * np.arange(COUNT)


def test_an_exact_allan_variance_gives_its_own_terms() -> None:
    truth = np.array([3.0, 1.0, 0.2, 5e-3, 2e-5])
    tau_s = 2.0 ** np.arange(14)
    variance = columns_of(tau_s) @ truth**2
    exact = AllanDeviation(tau_s, np.sqrt(variance), np.ones(14))
    found = noise_terms(exact, 1 << 16, 1.0)
    assert [term.name for term in found] == list(TERMS)
    centres = [np.sqrt((term.low**2 + term.high**2) / 2.0) for term in found if term.value is not None]
    said = [value for term, value in zip(found, truth, strict=True) if term.value is not None]
    assert len(said) >= 3
    np.testing.assert_allclose(centres, said, rtol=1e-6)


@pytest.mark.parametrize(
    "truth", [(3.0, 1.0, 0.02, 1e-3, 0.0), (0.0, 1.0, 0.3, 3e-3, 0.0), (0.0, 1.0, 0.0, 0.01, 2e-4)]
)
def test_intervals_cover_the_terms(truth: tuple[float, float, float, float, float]) -> None:
    """90 to 100 % of 95 % intervals: neighbouring averaging times go together, which the weights do not know."""
    chance, inside = np.random.default_rng(4), np.zeros(5)
    for _ in range(60):
        terms = noise_terms(allan_deviation(record(chance, truth), 1.0), COUNT, 1.0)
        inside += [term.low <= value <= term.high for term, value in zip(terms, truth, strict=True)]
    assert np.all(inside / 60 >= 0.85), inside / 60


def test_white_noise_is_told_and_nothing_else_invented() -> None:
    chance, found = np.random.default_rng(5), np.zeros(5)
    for _ in range(60):
        terms = noise_terms(allan_deviation(chance.normal(size=COUNT), 1.0), COUNT, 1.0)
        found += [term.value is not None for term in terms]
    assert found[1] == 60
    assert np.all(found[[0, 2, 3, 4]] <= 6), found


def test_a_short_rest_is_refused() -> None:
    with pytest.raises(ObservationsError, match="needed 6 for five terms"):
        noise_terms(allan_deviation(np.random.default_rng(1).normal(size=40), 1.0), 40, 1.0)
