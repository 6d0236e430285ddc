"""Do intervals hold the truth where every dwell counts its readings by the noise of the dwells before it?

Simulated campaigns of one channel: readings drawn one by one, counted by the engine's own rule and noise, solved with
every dwell counting alike. The noise of a reading differs by a hundred times between the scenes, beyond the limits on
both sides, and changes in mid-run.
"""

import logging
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from simulated_columns import NOISE_V, POINTS, Scene, simulate

from ams.statistics.intervals import t_quantile
from procedures.description.dwell_settings import AdaptiveDwell, DwellSettings
from procedures.plan.adaptive import samples_of_next
from procedures.records.dwells import ChannelReading, NoiseReference

FloatArray = NDArray[np.float64]
CHANNEL = "dmm.x"
LIMITS = AdaptiveDwell(noise_arcsec=1.0, least_samples=3, most_samples=60)
DWELL = DwellSettings(samples=10, adaptive=LIMITS)
WANTED_V = NOISE_V


@dataclass(frozen=True)
class Dwells:
    """The dwells of one campaign."""

    error_v: FloatArray
    """(N,) of their means."""
    samples: FloatArray
    variance_v2: FloatArray
    """As the readings of each show it."""


def take(reading_v: FloatArray, rng: np.random.Generator) -> Dwells:
    """``reading_v``: (N,) the true noise of one reading, dwell by dwell."""
    noise, taken = NoiseReference(), []
    for sigma_v in reading_v:
        count = samples_of_next(noise.recent(CHANNEL), WANTED_V, DWELL, LIMITS)
        reading = ChannelReading(CHANNEL, sigma_v * rng.standard_normal(count), 0.0, 1.0)
        noise.learn({CHANNEL: reading})
        taken.append((reading.mean, count, reading.standard_deviation**2))
    return Dwells(*np.array(taken).T)


def steady(factor: float) -> Callable[[FloatArray], FloatArray]:
    return lambda part: np.full_like(part, factor)


def changing(before: float, after: float) -> Callable[[FloatArray], FloatArray]:
    """The noise changes inside the third of six replications."""
    return lambda part: np.where(part < 0.45, before, after)


BOTH = Scene(lack_of_fit=1.5, drift=2.0)
SCENES: dict[str, tuple[Callable[[FloatArray], FloatArray], Scene]] = {
    "nine readings are enough": (steady(3.0), Scene()),
    "ten times quieter than that: never below the least": (steady(0.3), BOTH),
    "ten times louder: never enough": (steady(30.0), BOTH),
    "noise that rises": (changing(2.0, 5.0), BOTH),
    "noise that falls": (changing(5.0, 2.0), Scene(lack_of_fit=1.5)),
    "noise that rises ten times, beyond both limits": (changing(1.0, 10.0), Scene(drift=2.0)),
}


def coverage(name: str, campaigns: int, seed: int = 1) -> tuple[NDArray[np.float64], float]:
    """Shares of 95 % intervals of b and k that hold the truth, and the mean number of readings."""
    noise_of, scene = SCENES[name]
    rng = np.random.default_rng(seed)
    part = (np.arange(scene.replications * POINTS) + 0.5) / (scene.replications * POINTS)
    taken = [take(noise_of(part) * NOISE_V, rng) for _ in range(campaigns)]
    simulated = simulate(scene, campaigns, rng, np.stack([dwells.error_v for dwells in taken], axis=1))
    solved = simulated.solved
    half = t_quantile(0.95, solved.primary_dof) * np.sqrt(np.diagonal(solved.primary_covariance, axis1=1, axis2=2))
    held = np.abs(solved.primary[:, :4] - simulated.truth) < half[:, :4]
    return held.mean(axis=0), float(np.mean([dwells.samples.mean() for dwells in taken]))


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if "rises ten" in name else pytest.mark.thorough) for name in SCENES]
)
def test_intervals_hold_the_truth_where_readings_are_counted_by_the_noise(name: str) -> None:
    held, _ = coverage(name, 150)
    assert held.mean() == pytest.approx(0.95, abs=0.035)


@pytest.mark.soak
@pytest.mark.timeout(900)
@pytest.mark.parametrize("name", SCENES)
def test_intervals_hold_the_truth_within_one_percent(name: str) -> None:
    held, samples = coverage(name, 4000, seed=2)
    logging.getLogger(__name__).info("%s: b and k %s, %.1f readings a dwell", name, np.round(held, 4), samples)
    assert held.mean() == pytest.approx(0.95, abs=0.01)
    assert held == pytest.approx(np.full(4, 0.95), abs=0.015)  # 4.4 standard errors of the count


def test_the_mean_is_known_as_well_as_wanted_and_no_scatter_is_kept_for_being_small() -> None:
    """Of 100 campaigns: the error of the means, and the noise as their readings show it against what it is."""
    rng = np.random.default_rng(3)
    taken = [take(np.full(100, 3.0 * NOISE_V), rng) for _ in range(100)]
    error_v = np.concatenate([dwells.error_v[10:] for dwells in taken])
    assert np.sqrt(np.mean(error_v**2)) == pytest.approx(WANTED_V, rel=0.05)
    shown_v2 = np.concatenate([dwells.variance_v2[10:] for dwells in taken])
    assert shown_v2.mean() == pytest.approx((3.0 * NOISE_V) ** 2, rel=0.02)


def test_a_noise_that_changes_is_followed_within_a_few_dwells() -> None:
    """Of 60 campaigns: 4 readings are enough before the fiftieth dwell, 25 from it on."""
    rng = np.random.default_rng(4)
    reading_v = np.where(np.arange(80) < 50, 2.0, 5.0) * NOISE_V
    counts = np.mean([take(reading_v, rng).samples for _ in range(60)], axis=0)
    assert counts[40:50].mean() == pytest.approx(4.0, rel=0.2)
    assert counts[60:].mean() == pytest.approx(25.0, rel=0.1)
