"""Advice on an interval needs an interval: repetitions of one day are none."""

from dataclasses import replace
from datetime import timedelta

import numpy as np
import pytest

from ams.archive.synthetic import Story, synthetic_archive
from ams.surveillance.control_chart import Chart, History, history_of
from ams.surveillance.interval_advice import advise_interval
from ams.surveillance.series import Population

LABEL = synthetic_archive(np.random.default_rng(5)).population.labels[0]
STORY = Story(sensors=12, drift_arcsec_per_year=0.0, drop_arcsec=0.0)


def _repeated(every: timedelta) -> Population:
    population = synthetic_archive(np.random.default_rng(5), STORY).population
    first = min(label.created_utc for label in population.labels)
    labels = [
        replace(label, created_utc=first + every * int((label.run_id or "").removeprefix("campaign-")))
        for label in population.labels
    ]
    return Population(labels, population.numbers)


def test_calibrations_half_a_year_apart_are_advised_on() -> None:
    population = _repeated(timedelta(days=182))
    sensor = population.labels[0].sensor
    advice = advise_interval(history_of(population, sensor), 1.0)
    assert advice is not None
    # 2 x 182 days at most: an interval is never more than doubled at once (ILAC-G24)
    assert 6 <= advice.months <= 12


def test_repetitions_within_a_day_say_nothing_of_an_interval() -> None:
    population = _repeated(timedelta(hours=1))
    assert advise_interval(history_of(population, population.labels[0].sensor), 1.0) is None


@pytest.mark.parametrize(
    ("dof", "t"), [(3.0, 3.182), (4.0, 2.776), (6.0, 2.447), (10.0, 2.228), (30.0, 2.042), (1000.0, 1.962)]
)
def test_a_scatter_that_is_known_by_few_calibrations_shortens_the_interval_by_students_t(dof: float, t: float) -> None:
    """t of 97.5 % from the printed tables; rate 10″ ± 1″ a year, scatter 2″, limit 30″, two years so far."""
    labels = tuple(replace(LABEL, created_utc=LABEL.created_utc + timedelta(days=730 * at)) for at in range(6))
    nothing, never = np.full(6, np.nan), np.zeros(6, dtype=bool)
    deg = 1.0 / 3600.0
    chart = Chart(
        "sensitivity_v_per_g.x",
        value=nothing, shared=nothing, standard_uncertainty=nothing, prediction_low=nothing, prediction_high=nothing,
        centre=nothing,
        scatter=2.0 * deg, scatter_dof=dof, is_alarm=never,
        rate_per_year=-10.0 * deg, rate_standard_uncertainty=deg, deg_per_unit=1.0,
    )  # fmt: skip
    history = History(labels[0].sensor, labels, (chart,), np.zeros((6, 3)), (), is_judged=True)
    advice = advise_interval(history, 30.0 * deg)
    assert advice is not None
    assert advice.months == int(12.0 * (30.0 - t * 2.0**0.5 * 2.0) / (10.0 + t * 1.0))


@pytest.mark.parametrize("calibrations", [5, 7, 10])
def test_a_sensor_alone_knows_its_scatter_by_its_calibrations_less_the_two_of_a_line(calibrations: int) -> None:
    population = synthetic_archive(np.random.default_rng(5), STORY).population
    start = population.rows_of(population.labels[0].sensor).start
    part = slice(start, start + calibrations)
    columns = {name: getattr(population.numbers, name)[part] for name in ("primary", "covariance", "scatter")}
    alone = Population(population.labels[part], replace(population.numbers, **columns))
    charts = history_of(alone, alone.labels[0].sensor).charts
    assert [chart.scatter_dof for chart in charts] == [calibrations - 2] * len(charts)


def _history_of(
    rate_deg: float, scatter_deg: float, values_deg: tuple[float, ...], *, is_rated: bool = True, meter_deg: float = 0.0
) -> History:
    """Return a history of yearly calibrations with one chart in degrees; the meter changed before the last."""
    count = len(values_deg)
    labels = tuple(replace(LABEL, created_utc=LABEL.created_utc + timedelta(days=365 * at)) for at in range(count))
    nothing, never = np.full(count, np.nan), np.zeros(count, dtype=bool)
    chart = Chart(
        "offset_v.x", value=np.array(values_deg), shared=meter_deg * (np.arange(count) == count - 1),
        standard_uncertainty=nothing, prediction_low=nothing,
        prediction_high=nothing, centre=nothing, scatter=scatter_deg, scatter_dof=1000.0, is_alarm=never,
        rate_per_year=rate_deg if is_rated else None, rate_standard_uncertainty=0.0 if is_rated else None,
        deg_per_unit=1.0,
    )  # fmt: skip
    return History(labels[0].sensor, labels, (chart,), np.zeros((count, 3)), (), is_judged=True)


def test_half_an_interval_that_is_still_too_long_says_so() -> None:
    advice = advise_interval(_history_of(0.2, 0.0, (0.0,) * 6), 0.02)
    assert advice is not None
    assert advice.months == 6  # half of the year so far; 0.02° are reached after 1.2 months
    assert "after 1.2 months" in advice.sentence
    assert advice.sentence.endswith("it is still too long")


def test_a_scatter_that_takes_all_of_the_limit_is_no_reach_after_no_months() -> None:
    advice = advise_interval(_history_of(0.001, 0.02, (0.0,) * 6), 0.02)
    assert advice is not None
    assert "0 months" not in advice.sentence
    assert "no interval keeps it inside" in advice.sentence


def test_a_change_beyond_the_limit_is_told_before_a_rate_is_known() -> None:
    """0.46° in a year, of a limit of 0.02°: the interval that let it pass is not kept."""
    advice = advise_interval(_history_of(0.0, 0.0, (0.0, 0.46), is_rated=False), 0.02)
    assert advice is not None
    assert advice.months == 6
    assert "changed by 0.4600° since the calibration before, beyond 0.02°" in advice.sentence
    kept = advise_interval(_history_of(0.0, 0.0, (0.0, 0.01), is_rated=False), 0.02)
    assert kept is not None
    assert kept.months == 12


def test_a_change_of_the_meter_is_no_reason_to_shorten_a_sensors_interval() -> None:
    """0.17° of 0.172° are the meter's, as of a gain of 0.003: the sensor itself changed by 0.002°, of 0.02° allowed."""
    advice = advise_interval(_history_of(0.0, 0.0, (0.0, 0.172), is_rated=False, meter_deg=0.17), 0.02)
    assert advice is not None
    assert advice.months == 12
    itself = advise_interval(_history_of(0.0, 0.0, (0.0, 0.472), is_rated=False, meter_deg=0.17), 0.02)
    assert itself is not None
    assert "changed by 0.3020° since the calibration before" in itself.sentence
