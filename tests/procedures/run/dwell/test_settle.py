"""Settled or not: false alarms as often as stated, a creep never mistaken for rest."""

import numpy as np
import pytest
from journals import START_UTC

from procedures.description.dwell_settings import Settle
from procedures.run.dwell.settle import FALSE_ALARM, Window, is_at_rest, readings_per_window, settle
from procedures.statistics import has_slope, median_variance_ratio, small_variance_ratio, t_limit
from rig.abilities.abilities import Burst, Wait
from rig.clock import VirtualClock


class Creeping:
    """A readout whose voltage creeps to its rest: v = creep · exp(−t/τ) + noise."""

    name, channels = "dmm", ("dmm.x",)

    def __init__(self, clock: VirtualClock, creep_v: float, tau_s: float, noise_v: float, seed: int = 0) -> None:
        self._clock, self._creep_v, self._tau_s, self._noise_v = clock, creep_v, tau_s, noise_v
        self._chance = np.random.default_rng(seed)

    def identify(self) -> str:
        return "creeping"

    def prepare(self) -> None: ...

    def checks(self) -> dict[str, float]:
        return {}

    def reading_s(self, nplc: float | None = None) -> float:
        return 0.05

    def read(self, channel: str, samples: int, wait: Wait, nplc: float | None = None) -> Burst:
        started_s = self._clock.monotonic_s()
        times_s = started_s + 0.05 * np.arange(samples)
        wait(0.05 * samples)
        values_v = self._creep_v * np.exp(-times_s / self._tau_s) + self._chance.normal(0.0, self._noise_v, samples)
        return Burst(channel, values_v, np.zeros(samples, dtype=bool), started_s, 0.05)


def _settled(
    creep_v: float, tau_s: float, noise_v: float, seed: int = 0, **settings: float
) -> tuple[bool, float, float]:
    """Whether it settled, when, and how much of the creep was left."""
    clock = VirtualClock(START_UTC)
    readout = Creeping(clock, creep_v, tau_s, noise_v, seed)
    found = settle(readout, "dmm.x", Settle(**settings), 1.0, clock, clock.sleep)  # type: ignore[arg-type]
    return found.is_settled, found.took_s, float(creep_v * np.exp(-clock.monotonic_s() / tau_s))


def test_a_package_at_rest_settles_at_the_earliest_time() -> None:
    assert _settled(0.0, 1.0, 0.0)[:2] == (True, pytest.approx(3.0))
    assert _settled(0.0, 1.0, 0.0, min_s=7.0)[:2] == (True, pytest.approx(7.5))


@pytest.mark.parametrize(("tau_s", "in_noise"), [(2.0, 2.0), (5.0, 5.0), (10.0, 12.0)])
def test_a_creep_of_500_times_the_noise_is_waited_out(tau_s: float, in_noise: float) -> None:
    runs = [_settled(1e-2, tau_s, 2e-5, seed) for seed in range(40)]
    assert all(is_settled for is_settled, _, _ in runs)
    assert max(left_v for _, _, left_v in runs) < in_noise * 2e-5


def test_what_never_rests_is_told_at_the_longest_time() -> None:
    is_settled, took_s, _ = _settled(1.0, 60.0, 1e-6, max_s=20.0)
    assert not is_settled
    assert 20.0 <= took_s < 22.0


def test_white_noise_raises_false_alarms_as_often_as_stated() -> None:
    chance = np.random.default_rng(11)
    times_s = np.concatenate([np.arange(10) * 0.05, 1.5 + np.arange(10) * 0.05])
    trials = 4000
    moving = sum(has_slope(times_s, chance.normal(2.5, 2e-5, 20), FALSE_ALARM) for _ in range(trials))
    assert moving / trials == pytest.approx(FALSE_ALARM, abs=4 * np.sqrt(FALSE_ALARM / trials))


def test_an_overloaded_window_is_never_at_rest() -> None:
    good = Window(np.arange(5.0), np.full(5, 2.5))
    bad = Window(np.arange(5.0) + 5, np.array([2.5, 2.5, np.nan, 2.5, 2.5]))
    assert is_at_rest([good, Window(good.times_s + 5, good.samples)], 2)
    assert not is_at_rest([good, bad], 2)
    assert not is_at_rest([good], 2)


@pytest.mark.parametrize(("reading_s", "count"), [(0.02, 10), (0.2, 7), (1.0, 5), (0.0, 10)])
def test_a_window_has_five_to_ten_readings(reading_s: float, count: int) -> None:
    assert readings_per_window(1.5, reading_s) == count


def test_limits_are_those_of_published_tables() -> None:
    assert t_limit(10, 0.05) == pytest.approx(2.228, abs=5e-4)  # NIST/SEMATECH e-Handbook 1.3.6.7.2
    assert t_limit(19, 0.01) == pytest.approx(2.861, abs=5e-4)
    assert small_variance_ratio(10, 0.05) * 10 == pytest.approx(3.940, abs=5e-4)  # 1.3.6.7.4, lower critical values
    assert small_variance_ratio(2, 0.1) == pytest.approx(0.211 / 2, abs=5e-4)
    assert median_variance_ratio(1) == pytest.approx(0.6745**2, abs=1e-4)


def test_a_tenth_of_the_variance_is_a_false_alarm_in_9_5_percent_of_dwells_of_three() -> None:
    """FAULTS 2: why the limit for stuck follows from the number of samples."""
    assert small_variance_ratio(2, 0.0952) == pytest.approx(0.1, abs=2e-4)
