"""A change that one axis or one sensor alone shows, in rigs whose packages do not all have the axes to see its cause.

What all sensors share (a turn of the table, gain or offset of a meter) is told by more than one axis. At level y alone
feels a turn about roll, and z alone the gain of a meter: where one package has that axis, its drift is a turn or a gain
of the same size, and no other axis speaks for or against it. A cause is shared only where the others show it without
the one that shows most of it: a sensor that cannot see a cause does not vote for it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ams.arrays import BoolArray
from ams.surveillance.common_mode_causes import LIKE_AXES, Cause, Scale, causes_of, common_names, scale_of
from ams.surveillance.common_mode_columns import Visits, WatchedAxes, Whitened, whiten
from ams.surveillance.loose_mount import CONSISTENT


@dataclass(frozen=True)
class LoneAxis:
    """The only axis that shows a change."""

    sensor: str
    also: tuple[Cause, ...]
    """Shared causes that would look the same: no other axis contradicts them."""


def lone_axis(axes: WatchedAxes, visits: Visits, stated: Sequence[Cause]) -> LoneAxis | None:
    """Return the axis without which nothing of the ``stated`` causes is seen; None where others show it as well.

    Of several the one that leaves least.
    """
    found = []
    for index, sensor in enumerate(axes.sensor):
        of_axis = np.arange(len(axes.sensor)) == index
        rest = _without(axes, visits, axes.sensors, of_axis)
        if not any(_is_seen(cause, rest, visits) for cause in stated):
            found.append((rest.left(())[0], index, sensor))
    if not found:
        return None
    _, index, sensor = min(found)
    return LoneAxis(sensor, tuple(_shared(axes, visits, np.arange(len(axes.sensor)) == index)))


def lone_sensor(axes: WatchedAxes, visits: Visits, among: Sequence[str], stated: Sequence[Cause]) -> str | None:
    """Return the sensor without which the others ``among`` show nothing of the ``stated`` causes."""
    for name in among:
        rest = _without(axes, visits, among, np.array([sensor == name for sensor in axes.sensor]))
        if not any(_is_seen(cause, rest, visits) for cause in stated):
            return name
    return None


def others_are_blind(axes: WatchedAxes, visits: Visits, sensor: str) -> bool:
    """Return whether something that all sensors share explains what one shows, and the others could not see it."""
    return any(_shared(axes, visits, np.array([name == sensor for name in axes.sensor])))


def _shared(axes: WatchedAxes, visits: Visits, of_alone: BoolArray) -> Iterator[Cause]:
    """Yield the shared causes that explain what some axes show, and of which the others would show nothing.

    A temperature that moves the axes of one name alike is none of them: nothing is alike of one axis.
    """
    alone, rest = (_without(axes, visits, axes.sensors, left_out) for left_out in (~of_alone, of_alone))
    scale, bare = Scale(1.0, visits.degrees_of_freedom), rest.left(())[0]
    for cause in causes_of(alone):
        left, used = alone.left(cause.parts)
        if cause.name.endswith(LIKE_AXES) or not used:
            continue
        sizes = alone.estimates(cause.parts, 1.0)
        foretold = sum((sizes[name].value * rest.columns[name] for name in cause.parts), np.zeros_like(rest.y))
        worse = float((rest.y - foretold) @ (rest.y - foretold)) - bare
        if min(scale.p_value(left, alone.y.size - used), scale.p_value(worse, 1)) >= CONSISTENT:
            yield cause


def _without(axes: WatchedAxes, visits: Visits, among: Sequence[str], left_out: BoolArray) -> Whitened:
    return whiten(axes, replace(visits, change=np.where(left_out, np.nan, visits.change)), among)


def _is_seen(cause: Cause, rest: Whitened, visits: Visits) -> bool:
    """Return whether sensors show a cause; of a change without a name, whether they show anything common."""
    names = common_names(rest)
    left, rank = rest.left(names)
    scale = scale_of(left, rest.y.size - rank, visits.degrees_of_freedom)
    (bare, _), (beside, used) = rest.left(()), rest.left(cause.parts or names)
    return scale.p_value(bare - beside, used) < CONSISTENT
