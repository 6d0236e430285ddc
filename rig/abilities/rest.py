"""Judge whether a read-back stands: looks in, a verdict out.

A closed loop holds its place by moving, so its last digits change for ever and two equal positions prove nothing; a
worn brake creeps by less than that from one look to the next. Rest is known where the looks of :data:`REST_S` stay in a
band of :data:`BAND_TOLERANCES` arrival tolerances and the straight line through them is too flat for a creep: its slope
with :data:`SURE_ERRORS` standard errors is below one arrival tolerance in :data:`CREEP_S`. Where the scatter is too
large for that, the looks of a longer time are taken, over which the error of a slope falls as time to the power 1.5.

In a read-back that does not change at all, a creep of less than one of its steps in :data:`REST_S` is not seen.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

REST_S = 1.0
"""The shortest time over which rest is seen."""
BAND_TOLERANCES = 2.0
"""Arrival tolerances: one to either side."""
CREEP_S = 2.0
"""What turns by one arrival tolerance in this time creeps: 0.0005 °/s with a tolerance of 0.001°."""
SURE_ERRORS = 4.0
SETTLING = 0.25
"""Of an arrival tolerance: what turns by less between two looks settles no more."""
_ENOUGH_LOOKS = 8
"""Scatter of fewer is known too badly for a slope to be held against it."""
_JUST_NOW_S = 0.5


@dataclass(frozen=True, slots=True)
class RestLook:
    """Where an axis was."""

    position_deg: float
    taken_s: float


def band_deg(tolerance_deg: float) -> float:
    """Return by how much the read-back of an axis at rest may wander, degrees, of its arrival tolerance."""
    return BAND_TOLERANCES * tolerance_deg


def creep_dps(tolerance_deg: float) -> float:
    """Return the speed, degrees per second, from which on an axis creeps, of its arrival tolerance."""
    return tolerance_deg / CREEP_S


def stands(looks: Sequence[RestLook], tolerance_deg: float) -> bool:
    """Return whether the newest looks, over a second or as long as their scatter asks for, show an axis at rest."""
    for recent in _longer_and_longer(looks):
        span_deg = _span_deg(recent)
        if span_deg > band_deg(tolerance_deg):
            return False
        if span_deg == 0.0:
            return True
        if len(recent) >= _ENOUGH_LOOKS:
            slope_dps, error_dps = _slope_dps(recent)
            if abs(slope_dps) + SURE_ERRORS * error_dps <= creep_dps(tolerance_deg):
                return True
    return False


def moves_between(before_deg: float, now_deg: float, bound_for_deg: float | None, tolerance_deg: float) -> bool:
    """Return whether two looks alone, with nothing else to tell it, show an axis that moves.

    ``bound_for_deg``: where a move goes that was not seen to end, NaN where nobody knows; one that settles slowly has
    not arrived before it is there, or hardly goes on. None of an axis that should rest: then its band is allowed.
    """
    turned_deg = abs(now_deg - before_deg)
    if bound_for_deg is None or abs(now_deg - bound_for_deg) <= tolerance_deg:
        return turned_deg > band_deg(tolerance_deg)
    return turned_deg > SETTLING * tolerance_deg


def moves_on(looks: Sequence[RestLook], tolerance_deg: float) -> bool:
    """Return whether the newest looks show for certain that an axis moves: by more than its band, or by a creep."""
    just_now = [look for look in looks if looks[-1].taken_s - look.taken_s <= _JUST_NOW_S]
    if _span_deg(just_now if len(just_now) > 1 else looks[-2:]) > band_deg(tolerance_deg):
        return True
    recent = next(_longer_and_longer(looks), ())  # a longer time may hold the motion that a stop has ended since
    if len(recent) < _ENOUGH_LOOKS:
        return False
    slope_dps, error_dps = _slope_dps(recent)
    return abs(slope_dps) - SURE_ERRORS * error_dps > creep_dps(tolerance_deg)


def unrest_in_words(looks: Sequence[RestLook], axis: str, tolerance_deg: float) -> str:
    """Return what the read-back did in the last second, and what it may do at rest; empty where it is younger."""
    recent = next(_longer_and_longer(looks), None)
    if recent is None:
        return ""
    return (
        f": its read-back ran over {_span_deg(recent):.3g}° within a second, at rest it stays within"
        f" {band_deg(tolerance_deg):.3g}° and creeps by less than {creep_dps(tolerance_deg):.3g} °/s"
        f" (axes.{axis}: arrival_tolerance_deg)"
    )


def _longer_and_longer(looks: Sequence[RestLook]) -> Iterator[Sequence[RestLook]]:
    """Return the newest looks over a second, two, four and so on, as far as they go back."""
    at_least_s = REST_S
    for first in reversed(range(len(looks))):
        if looks[-1].taken_s - looks[first].taken_s >= at_least_s:
            yield looks[first:]
            at_least_s *= 2.0


def _span_deg(looks: Sequence[RestLook]) -> float:
    positions_deg = [look.position_deg for look in looks]
    return max(positions_deg) - min(positions_deg)


def _slope_dps(looks: Sequence[RestLook]) -> tuple[float, float]:
    """Return the slope of the straight line through the looks and its standard error from their scatter about it."""
    times_s = np.array([look.taken_s for look in looks])
    times_s -= times_s.mean()
    positions_deg = np.array([look.position_deg for look in looks])
    positions_deg -= positions_deg.mean()
    squares_s2 = float(times_s @ times_s)
    slope_dps = float(times_s @ positions_deg) / squares_s2
    rest_deg = positions_deg - slope_dps * times_s
    return slope_dps, sqrt(float(rest_deg @ rest_deg) / (len(looks) - 2) / squares_s2)
