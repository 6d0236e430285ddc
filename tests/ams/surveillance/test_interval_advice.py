"""Advice on an interval needs an interval: repetitions of one day are none."""

from dataclasses import replace
from datetime import timedelta

import numpy as np

from ams.archive.synthetic import Story, synthetic_archive
from ams.surveillance.control_chart import history_of
from ams.surveillance.interval_advice import advise_interval
from ams.surveillance.series import Population

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
