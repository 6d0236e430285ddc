"""Looks at a turning axis: a rate is as well known as it says; one beyond its limit is at fault at once."""

import numpy as np
import pytest

from ams.arrays import FloatArray
from procedures.plan.steps import Turn
from procedures.run.dwell.turning import LOOK_S, Measured, RateWatch, mean_of_sweeps
from rig.abilities.abilities import TurnLook
from rig.errors import DeviceFault

ASKED_DPS = 40.0


def _watch(step_deg: float = 1e-4) -> RateWatch:
    return RateWatch("yaw", Turn("yaw", ASKED_DPS, 15.0, 1, None, 1, 0.02), step_deg)


def _measured(angles_deg: FloatArray, step_deg: float) -> Measured:
    watch = _watch(step_deg)
    watch.taken = [TurnLook(float(angle), LOOK_S * number, 0.0) for number, angle in enumerate(angles_deg)]
    return watch.measured(0)


@pytest.mark.parametrize("step_deg", [1e-4, 0.02])
def test_a_rate_is_as_uncertain_as_it_scatters_from_turn_to_turn(step_deg: float) -> None:
    """Both ends of a turn are read, with noise or to a whole step: 30 looks, 2000 turns."""
    chance = np.random.default_rng(11)
    even_deg = ASKED_DPS * LOOK_S * np.arange(30)
    noise_deg = 0.003 if step_deg < 0.003 else 0.0
    found = []
    for _ in range(2000):
        read_deg = even_deg + chance.uniform(0.0, 360.0) + chance.normal(0.0, noise_deg, even_deg.size)
        found.append(_measured(np.round(read_deg / step_deg) * step_deg, step_deg))
    scatter_dps = np.std([rate.rate_dps for rate in found])
    stated_dps = np.sqrt(np.mean([rate.uncertainty_dps**2 for rate in found]))
    if noise_deg:
        assert stated_dps == pytest.approx(scatter_dps, rel=0.05)
    assert stated_dps == pytest.approx(np.sqrt(2.0 * max(noise_deg**2, step_deg**2 / 12.0)) / 14.5, rel=0.05)


def test_the_mean_of_sweeps_is_as_uncertain_as_it_scatters() -> None:
    chance = np.random.default_rng(12)
    stated_dps = np.array([0.02, 0.03, 0.01, 0.02, 0.02])
    found = [
        mean_of_sweeps([Measured(ASKED_DPS + chance.normal(0.0, u), u, 90.0) for u in stated_dps]) for _ in range(4000)
    ]
    assert {rate.turned_deg for rate in found} == {450.0}
    assert np.mean([rate.rate_dps for rate in found]) == pytest.approx(ASKED_DPS, abs=1e-3)
    assert found[0].uncertainty_dps == pytest.approx(np.std([rate.rate_dps for rate in found]), rel=0.05)


def _gathers_speed(watch: RateWatch, *rates_dps: float) -> None:
    angle_deg = 0.0
    watch.reaches_speed(TurnLook(angle_deg, 0.0, 0.0))
    for number, rate_dps in enumerate(rates_dps, 1):
        angle_deg += rate_dps * LOOK_S
        watch.reaches_speed(TurnLook(angle_deg, number * LOOK_S, 0.0))


def test_an_axis_that_is_faster_than_its_limit_before_it_is_at_speed_is_at_fault_at_once() -> None:
    """The pages state 125 %: an overshoot inside it is awaited, and one look beyond it is enough."""
    _gathers_speed(_watch(), 20.0, 49.0)
    with pytest.raises(DeviceFault, match=r"yaw: turns at 51 °/s, over its limit of 50 °/s; .* decelerate to rest"):
        _gathers_speed(_watch(), 20.0, 51.0)
