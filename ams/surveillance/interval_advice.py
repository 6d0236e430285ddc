"""How long until the next calibration: the control-chart method of ILAC-G24 / OIML D 10, on the sensor's own charts.

The interval is the longest after which, by rate and scatter, every characteristic is still inside the largest error
allowed: (|rate| + t·u(rate))·Δt + t·√2·s ≤ limit, all as angles, 95 %; t is Student's, by the degrees of freedom that
the scatter s is known by. It is never changed by more than a factor of two at once, and a step halves it, as does a
change beyond the limit from one calibration to the next where no rate is known; where half the interval is still too
long, the sentence says so. It is advice to the sensor's owner and no part of a certificate (ISO/IEC 17025, 7.8.4.3).

What all sensors of a run changed alike is in none of it where runs enough tell that a meter did so. Before, it may as
well be an age that all of them have: the advice then is the shorter one of with and without it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import itemgetter

import numpy as np

from ams.parameter_words import words_of_characteristic
from ams.statistics.intervals import t_quantile
from ams.surveillance.control_chart import Chart, History, history_of
from ams.surveillance.series import SECONDS_PER_YEAR, Population
from ams.surveillance.shared_changes import SharedChange, without_shared

LONGEST_MONTHS, SHORTEST_MONTHS = 60, 1


@dataclass(frozen=True)
class IntervalAdvice:
    """Months until the next calibration, and why."""

    months: int
    sentence: str


def cautious_interval(
    population: Population, history: History, shared: Sequence[SharedChange], limit_deg: float
) -> IntervalAdvice | None:
    """Return advice that is no longer than it was if changes that may be the sensors' own age were.

    ``population``: as measured. ``history``: of the sensor, without all of ``shared``. None as of ``advise_interval``.
    """
    advice, distinct = advise_interval(history, limit_deg), [change for change in shared if change.is_distinct]
    if advice is None or len(distinct) == len(shared):
        return advice
    of_measured = advise_interval(history_of(without_shared(population, distinct), history.sensor), limit_deg)
    if of_measured is None or of_measured.months >= advice.months:
        return advice
    sentence = (
        f"{of_measured.sentence} (what all sensors of a run changed alike counts as the sensor's own here: too few "
        "runs tell a meter that changed from an age that all have)"
    )
    return replace(of_measured, sentence=sentence)


def advise_interval(history: History, limit_deg: float) -> IntervalAdvice | None:
    """Return advice for a largest allowed error in degrees; None with fewer than two calibrations.

    None too where they follow one another in less than a month: then they are repetitions and say nothing of an
    interval.
    """
    times = np.array([label.created_utc.timestamp() for label in history.labels]) / SECONDS_PER_YEAR
    if times.size < 2:
        return None
    current = float(np.median(np.diff(times))) * 12.0
    if current < SHORTEST_MONTHS:
        return None
    current = float(np.round(current))
    if any(finding.kind == "step" and finding.seen == history.labels[-1] for finding in history.findings):
        return _advice(0.5 * current, current, "the last calibration found a step: look again after half the time")
    rated = [chart for chart in history.charts if chart.rate_per_year is not None]
    if not rated:
        name, change_deg = max(((chart.name, _newest_change_deg(chart)) for chart in history.charts), key=itemgetter(1))
        if change_deg > limit_deg:
            changed = f"{words_of_characteristic(name)} changed by {change_deg:.4f}° since the calibration before"
            return _advice(0.5 * current, current, f"{changed}, beyond {limit_deg:g}°: look again after half the time")
        return _advice(current, current, "fewer than five calibrations since the last step: keep the interval")
    worst, months, widest = "", np.inf, 0.0
    for chart in rated:
        assert chart.rate_per_year is not None
        assert chart.rate_standard_uncertainty is not None
        factor = float(t_quantile(0.95, chart.scatter_dof))
        rate = (abs(chart.rate_per_year) + factor * chart.rate_standard_uncertainty) * chart.deg_per_unit
        room = limit_deg - factor * np.sqrt(2.0) * chart.scatter * chart.deg_per_unit
        allowed = max(room, 0.0) / rate * 12.0 if rate > 0.0 else np.inf
        if allowed < months:
            worst, months, widest = words_of_characteristic(chart.name), allowed, limit_deg - room
    return _advice(months, current, _reason(worst, months, current, limit_deg, widest))


def _newest_change_deg(chart: Chart) -> float:
    """Return the newest change without what the meter did: a shorter interval of the sensor mends no meter."""
    of_sensor = chart.value - chart.shared
    return float(abs(of_sensor[-1] - of_sensor[-2])) * chart.deg_per_unit


def _reason(worst: str, months: float, current: float, limit_deg: float, scatter_deg: float) -> str:
    """Return why, and what the rule of at most a factor of two leaves undone."""
    if scatter_deg >= limit_deg:
        return (
            f"the scatter of {worst} between runs, {scatter_deg:.4f}° at the 95 % bound, takes all of {limit_deg:g}°: "
            "no interval keeps it inside; half the time is the least that is advised at once"
        )
    reaches = f"{worst} reaches {limit_deg:g}° after {months:.0f} months at the 95 % bound"
    if months < np.floor(0.5 * current):
        reaches = f"{worst} reaches {limit_deg:g}° after {months:.1f} months at the 95 % bound"
        return f"{reaches}, before that: half the time is the least that is advised at once, and it is still too long"
    return f"{reaches}; at most twice the time is advised at once" if months > 2.0 * current else reaches


def _advice(wanted: float, current: float, why: str) -> IntervalAdvice:
    bounded = min(max(wanted, 0.5 * current), 2.0 * current)
    months = int(min(max(np.floor(bounded + 1e-6), SHORTEST_MONTHS), LONGEST_MONTHS))
    return IntervalAdvice(months, f"{months} month{'s' * (months != 1)} (now {current:.0f}): {why}")
