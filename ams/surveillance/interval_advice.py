"""How long until the next calibration: the control-chart method of ILAC-G24 / OIML D 10, on the sensor's own charts.

The interval is the longest after which, by rate and scatter, every characteristic is still inside the largest error
allowed: (|rate| + t·u(rate))·Δt + t·√2·s ≤ limit, all as angles, 95 %; t is Student's, by the degrees of freedom that
the scatter s is known by. It is never changed by more than a factor of two at once, and a step halves it. It is advice
to the sensor's owner and no part of a certificate (ISO/IEC 17025, 7.8.4.3).
"""

from dataclasses import dataclass

import numpy as np

from ams.parameter_words import words_of_characteristic
from ams.statistics.intervals import t_quantile
from ams.surveillance.control_chart import History
from ams.surveillance.series import SECONDS_PER_YEAR

LONGEST_MONTHS, SHORTEST_MONTHS = 60, 1


@dataclass(frozen=True)
class IntervalAdvice:
    """Months until the next calibration, and why."""

    months: int
    sentence: str


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
    if any(finding.kind == "step" and finding.at == history.labels[-1] for finding in history.findings):
        return _advice(0.5 * current, current, "the last calibration found a step: look again after half the time")
    rated = [chart for chart in history.charts if chart.rate_per_year is not None]
    if not rated:
        return _advice(current, current, "fewer than five calibrations since the last step: keep the interval")
    worst, months = "", np.inf
    for chart in rated:
        assert chart.rate_per_year is not None
        assert chart.rate_standard_uncertainty is not None
        factor = float(t_quantile(0.95, chart.scatter_dof))
        rate = (abs(chart.rate_per_year) + factor * chart.rate_standard_uncertainty) * chart.deg_per_unit
        room = limit_deg - factor * np.sqrt(2.0) * chart.scatter * chart.deg_per_unit
        allowed = max(room, 0.0) / rate * 12.0 if rate > 0.0 else np.inf
        if allowed < months:
            worst, months = words_of_characteristic(chart.name), allowed
    return _advice(months, current, f"{worst} reaches {limit_deg:g}° after {months:.0f} months at the 95 % bound")


def _advice(wanted: float, current: float, why: str) -> IntervalAdvice:
    bounded = min(max(wanted, 0.5 * current), 2.0 * current)
    months = int(min(max(np.floor(bounded + 1e-6), SHORTEST_MONTHS), LONGEST_MONTHS))
    return IntervalAdvice(months, f"{months} month{'s' * (months != 1)} (now {current:.0f}): {why}")
