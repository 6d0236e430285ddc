"""An age that all sensors have, and a meter that changed, are alike in few runs: no interval is longer by the doubt."""

import pytest
from yearly_laboratory import Laboratory, measured, read_otherwise

from ams.surveillance.control_chart import history_of
from ams.surveillance.interval_advice import IntervalAdvice, advise_interval, cautious_interval
from ams.surveillance.series import Population
from ams.surveillance.shared_changes import shared_changes, without_shared

LIMIT_ARCSEC, LIMIT_DEG = 36.0, 0.01


def advised(population: Population, sensor: str) -> IntervalAdvice:
    shared = shared_changes(population)
    history = history_of(without_shared(population, shared), sensor)
    advice = cautious_interval(population, history, shared, LIMIT_DEG)
    assert advice is not None
    return advice


def as_measured(population: Population, sensor: str) -> IntervalAdvice:
    advice = advise_interval(history_of(population, sensor), LIMIT_DEG)
    assert advice is not None
    return advice


@pytest.mark.parametrize("runs", [2, 3, 4, 5, 6, 7, 8])
@pytest.mark.parametrize("arcsec_a_year", [0.0, 4.0, 8.0, 15.0, 25.0, 60.0, 200.0])
def test_sensors_that_age_alike_are_calibrated_before_their_limit_or_after_half_the_time(
    arcsec_a_year: float, runs: int
) -> None:
    """36″ allowed, a scatter of 2″: 60″ a year were told as a meter's until the fifth run, and the year was kept."""
    sound = measured(Laboratory(sensors=6, checks=0, runs=runs), 3)
    aged = read_otherwise(sound, lambda _, run: arcsec_a_year * run)
    for sensor in ("SN0", "SN3"):
        months = advised(aged, sensor).months
        assert months <= as_measured(aged, sensor).months
        assert months == 6 or months / 12.0 * arcsec_a_year <= LIMIT_ARCSEC


@pytest.mark.parametrize("runs", [2, 3, 4, 5])
def test_a_meter_that_few_runs_tell_of_is_said_to_shorten_the_interval(runs: int) -> None:
    advice = advised(measured(Laboratory(sensors=6, checks=0, runs=runs, gain_arcsec=100.0), 1), "SN0")
    assert advice.months == 6
    assert "too few runs tell a meter that changed from an age that all have" in advice.sentence


@pytest.mark.parametrize("gain_arcsec", [0.0, 20.0, 100.0, 1000.0])
def test_a_meter_that_runs_enough_tell_of_shortens_no_interval(gain_arcsec: float) -> None:
    for seed in range(3):
        laboratory = Laboratory(sensors=6, checks=0, gain_arcsec=gain_arcsec)
        advice = advised(measured(laboratory, seed), "SN0")
        assert advice.months >= 12
        assert "too few runs" not in advice.sentence


def test_nothing_that_is_shared_leaves_the_advice_as_it_was() -> None:
    for seed in range(5):
        sound = measured(Laboratory(sensors=6, checks=0, runs=4), 20 + seed)
        assert advised(sound, "SN0") == as_measured(sound, "SN0")
