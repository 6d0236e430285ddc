"""What all sensors saw at once: a slip of the table, a tilt of its base, the meter, or a sensor by itself.

Two visits to the same K attitudes differ by Δe, (K, A) over all axes of all sensors. What is common is fitted to it by
weighted least squares, k_s being the sensitive axis of axis s in table axes:

    Δe_s = k_s·(roll slip ∂f/∂R + pitch slip ∂f/∂α + tilt of the base (0, cos R, −sin R) + fixture −δθ × f)
           + gain of its meter·e_s + offset of its meter + own_s

A tilt of the base about its lateral axis is a pitch slip, a fixture that turns about its forward axis a roll slip: they
are one column each. A rotation about the vertical is never seen.

Judged in this order:

1. *Own.* A change that one axis alone shows is its sensor's, whatever would look the same
   (:mod:`ams.surveillance.lone_axis`). A sensor that does not do what the others do is taken out, the worst first,
   while a majority is left: by F of what its leaving takes away against what is left, or against the known scatter
   where that is more. Of two sensors one is blamed only where the other saw nothing at all, and could have.
2. *Common.* What one sensor alone shows is judged as of a lone sensor. Of the single causes the one that fits best is
   named where it is significant (Bonferroni over them); where none fits alone, rotation, gain and offset are judged in
   this order, each beside those before it.
3. *Confounded.* Every other cause that the data do not contradict is said with it. A lone sensor has its own axes'
   offsets and sensitivities among the causes, one by one and all together, as a temperature changes them: nothing but
   their pattern over the attitudes tells them from a rotation, which is one only if K⁻¹ΔK is antisymmetric and Δb = 0.
   Sensors of one make may do so alike: an offset and a sensitivity common to all x axes, all y axes, all z axes. At
   one attitude or two these fit whatever all sensors do alike, and at one pitch an offset of all x axes is a turn of
   the pitch axis. A turn is told from them by its form alone: it is that of one axis, and larger than the recorded
   change of temperature can have made.
   Beside what all sensors do alike it is told where it is nearly all of the change
   (92 % of the sum of squares): a slip of 72″ beside a drift of 10″ of all sensors.

Two scatters are believed: that of every reading, and that of seating the table anew, which turns all sensors alike and
therefore stands in the covariance between them. What the sensors do by themselves beyond that (a little drift of each)
is learned from what the common part leaves over, so a rig whose sensors all drift is judged more coarsely.
Source: TP (2), (4), (5) for f; weighted least squares and F tests as in any text.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ams.surveillance.common_mode_causes import (
    FEWEST_LEFT,
    LIKE_AXES,
    Cause,
    Scale,
    causes_of,
    common_names,
    of_meter,
    of_temperature,
    rotation,
    scale_of,
)
from ams.surveillance.common_mode_columns import (
    MODEL_ERROR,
    SAME,
    Estimate,
    Visits,
    WatchedAxes,
    Whitened,
    columns_of,
    model_error,
    sensitivity_of,
    whiten,
)
from ams.surveillance.lone_axis import lone_axis, lone_sensor, others_are_blind
from ams.surveillance.loose_mount import CONSISTENT, UNATTRIBUTED, Attribution, LeftOver, mount_or_sensor
from ams.surveillance.turns import AXES_OF_TABLE, BASE, FIXTURE, PITCH, ROLL, YAW, force_changes

LEAST_SENSOR_CHANGE = 5.0 * MODEL_ERROR
"""Of a rotation that all saw: a sensor that differs by less than this may only be known too coarsely."""
_SINGLE_TURNS = ((ROLL,), (PITCH,), (YAW,), (BASE,))
_OF_A_LONE = "offset and sensitivity of its axes"
_BESIDE_A_TURN = 0.08
"""Of the sum of squares of a change: what a turn of one axis may leave and still be nearly all of it."""
Fit = tuple[Cause, float, int]
"""A cause with the sum of squares that it leaves, and its rank."""


@dataclass(frozen=True)
class SensorChange:
    """A sensor that did what the others did not."""

    sensor: str
    p_value: float
    axis: str
    """Whose change is largest."""
    largest_rad: float
    """As an angle at full sensitivity, signed."""
    attribution: Attribution = UNATTRIBUTED
    """Whether its mount turned or the sensor changed."""
    also: tuple[Cause, ...] = ()
    """What all sensors share that would look the same: no other axis sees it."""


@dataclass(frozen=True)
class CommonMode:
    """What is behind the difference of two visits."""

    stated: tuple[Cause, ...]
    """Empty: nothing common changed significantly. Several: no single cause fits, and each of these is significant."""
    p_value: float
    """Of the common part, corrected for the number of causes tried."""
    also: tuple[Cause, ...]
    """Causes that look the same as the one told at these attitudes."""
    estimates: Mapping[str, Estimate]
    """Of the parts of what is told."""
    sensor_changes: tuple[SensorChange, ...]
    agreeing: tuple[str, ...]
    """Sensors that the common part was taken from."""
    rotation_rad: float = 0.0
    """Largest angle, over the attitudes, by which the direction of gravity turned in the packages."""
    seen_by: str = ""
    """The one sensor that shows it, which is judged as a lone one; empty where several do."""
    carried_by: str = ROLL
    """The innermost axis of the table: a package that turned about it on its mount looks like a slip of it."""


def judge_visits(axes: WatchedAxes, visits: Visits, false_alarm: float) -> CommonMode:
    """Return what changed between two visits, each test at ``false_alarm``."""
    of_all = _common(axes, visits, axes.sensors, false_alarm)
    if (lone := _of_lone_axis(axes, visits, of_all)) is not None:
        return lone
    changes: list[SensorChange] = []
    agreeing = axes.sensors
    while (found := _odd_sensor(axes, visits, agreeing, false_alarm)) is not None:
        name, p_value = found
        agreeing = tuple(sensor for sensor in agreeing if sensor != name)
        changes.append(SensorChange(name, p_value, "", 0.0))
    common = of_all if agreeing == axes.sensors else _common(axes, visits, agreeing, false_alarm)
    common = _by_who_sees_it(axes, visits, common, false_alarm)
    carried_by = ROLL if any(axes.is_rolled[axes.sensor.index(name)] for name in common.agreeing) else YAW
    turned = replace(common, rotation_rad=_rotation_rad(axes, visits, common), carried_by=carried_by)
    sized = (_sized(axes, visits, change, common) for change in changes)
    real = tuple(change for change in sized if abs(change.largest_rad) > LEAST_SENSOR_CHANGE * turned.rotation_rad)
    odd = {change.sensor for change in real}
    standing = (name for name in axes.sensors if name not in odd and _is_reached(axes, name, turned))
    return replace(turned, sensor_changes=real, agreeing=tuple(standing))


def _is_reached(axes: WatchedAxes, sensor: str, common: CommonMode) -> bool:
    """Return whether what is told turns a sensor: roll, and a fixture on it, turn none that stands on a sting."""
    if axes.is_rolled[axes.sensor.index(sensor)] or common.carried_by != ROLL:
        return True
    return not all(cause.name in (ROLL, FIXTURE) for cause in common.stated) or not common.stated


def _of_lone_axis(axes: WatchedAxes, visits: Visits, common: CommonMode) -> CommonMode | None:
    """Return a change that one axis of one sensor alone shows as that of the sensor; None where there is none.

    ``common``: what all sensors show together.
    """
    if len(axes.sensors) == 1 or visits.is_momentary or not common.stated:
        return None
    found = lone_axis(axes, visits, common.stated)
    if found is None:
        return None
    others = tuple(name for name in axes.sensors if name != found.sensor)
    nothing = CommonMode((), common.p_value, (), {}, (), others)
    change = SensorChange(found.sensor, common.p_value, "", 0.0, also=found.also)
    return replace(nothing, sensor_changes=(_sized(axes, visits, change, nothing),))


def _by_who_sees_it(axes: WatchedAxes, visits: Visits, common: CommonMode, false_alarm: float) -> CommonMode:
    """Return what is common as it is judged of a lone sensor, where only one sensor shows it."""
    if not common.stated or len(common.agreeing) == 1 or visits.is_momentary:
        return common
    name = lone_sensor(axes, visits, common.agreeing, common.stated)
    alone = common if name is None else _common(axes, visits, (name,), false_alarm)
    return replace(alone, seen_by=name) if name is not None and alone.stated else common


def _odd_sensor(
    axes: WatchedAxes, visits: Visits, among: Sequence[str], false_alarm: float
) -> tuple[str, float] | None:
    """Return the sensor that differs most from the rest, if any does, and with what chance."""
    if len(among) < 2 or 2 * (len(among) - 1) < len(axes.sensors):
        return None
    whole = whiten(axes, visits, among)
    left, _ = whole.left(common_names(whole))
    found: list[tuple[float, float, str]] = []
    for name in among:
        rest = tuple(other for other in among if other != name)
        other = whiten(axes, visits, rest)
        names = common_names(other) if len(rest) > 1 else ()
        left_other, rank = other.left(names)
        scale = scale_of(left_other, other.y.size - rank, visits.degrees_of_freedom)
        if len(rest) == 1 and scale.p_value(left_other, other.y.size) < CONSISTENT:
            continue
        if len(rest) == 1 and others_are_blind(axes, visits, name):
            continue
        before = float(whole.y @ whole.y) if len(rest) == 1 else left
        gained, count = before - left_other, whole.y.size - other.y.size
        found.append((scale.p_value(gained, count), -gained, name))
    p_value, _, name = min(found, default=(1.0, 0.0, ""))
    return (name, p_value) if p_value * len(among) < false_alarm else None


def _common(axes: WatchedAxes, visits: Visits, among: Sequence[str], false_alarm: float) -> CommonMode:
    data = whiten(axes, visits, among)
    nothing = CommonMode((), 1.0, (), {}, (), tuple(among))
    if data.y.size == 0:
        return nothing
    names = common_names(data)
    least, rank = data.left(names)
    scale = scale_of(least, data.y.size - rank, visits.degrees_of_freedom)
    if len(among) == 1:  # nothing tells what a lone sensor does by itself
        scale = Scale(1.0, visits.degrees_of_freedom)
    bare, _ = data.left(())
    causes = tuple(causes_of(data))
    fits = [(cause, *data.left(cause.parts)) for cause in causes]
    chances = [scale.p_value(bare - left, used) for _, left, used in fits]
    tries = len({round(chance, 12) for chance in chances}) + 1
    p_value = min(1.0, tries * min([*chances, scale.p_value(bare - least, rank)]))
    if p_value >= false_alarm:
        return replace(nothing, p_value=p_value)
    consistent = [
        (used, left, index)
        for index, (cause, left, used) in enumerate(fits)
        if _chance_of(data, (cause, left, used), scale, is_lone=len(among) == 1) >= CONSISTENT
    ]
    untold = replace(nothing, p_value=p_value)
    if not consistent:
        nearly = _nearly_all(data, axes, visits, fits, bare, untold)
        return nearly or _together(data, among, scale, p_value, false_alarm)
    fewest, least_left, _ = min(consistent)
    close = least_left + SAME * max(least_left, 1.0)
    index = next(index for used, left, index in consistent if used == fewest and left <= close)
    stated = causes[index]
    chosen = CommonMode((stated,), p_value, (), data.estimates(stated.parts, scale.variance), (), tuple(among))
    stands = {index for *_, index in consistent} | {at for at, (_, left, _) in enumerate(fits) if left <= close}
    chosen = replace(chosen, also=_also(data, axes, visits, chosen, fewest, [fits[at] for at in sorted(stands)]))
    is_open = fewest >= data.fits_all or (
        fewest > 1 and len(among) > 1 and any(cause.kind != stated.kind for cause in chosen.also)
    )
    return (_nearly_all(data, axes, visits, fits, bare, untold) if is_open else None) or chosen


def _nearly_all(
    data: Whitened, axes: WatchedAxes, visits: Visits, fits: Sequence[Fit], bare: float, nothing: CommonMode
) -> CommonMode | None:
    """Return the turn of one axis that is nearly all of a change which no cause explains but those that explain any.

    Sensors that drift alike beside a slip leave no single cause; what is left beside the turn is in its uncertainty.
    """
    if visits.pitch_rad.size < 2 or data.y.size < FEWEST_LEFT:
        return None
    turns = sorted(
        (left, index)
        for index, (cause, left, _) in enumerate(fits)
        if cause.parts in _SINGLE_TURNS and left <= _BESIDE_A_TURN * bare
    )
    if not turns:
        return None
    left, index = turns[0]
    stated = fits[index][0]
    estimates = data.estimates(stated.parts, max(1.0, left / (data.y.size - 1)))
    found = replace(nothing, stated=(stated,), estimates=estimates)
    if _rotation_rad(axes, visits, found) < visits.warmth_g:
        return None
    others = [fits[other][0] for _, other in turns[1:]]
    if len(nothing.agreeing) == 1:
        others += [cause for cause, *_ in fits if cause.name == _OF_A_LONE]
    return replace(found, also=tuple(others))


def _chance_of(data: Whitened, fit: Fit, scale: Scale, *, is_lone: bool) -> float:
    """Return the chance of what is left beside a cause, were it the only one.

    A lone sensor has no common part: its cause is judged against all its data.
    """
    cause, left, used = fit
    if is_lone:
        return scale.p_value(left, data.y.size - used)
    with_all, most = data.left(tuple(dict.fromkeys((*common_names(data), *cause.parts))))
    return scale.p_value(left - with_all, most - used)


def _also(
    data: Whitened,
    axes: WatchedAxes,
    visits: Visits,
    chosen: CommonMode,
    fewest: int,
    standing: Sequence[Fit],
) -> tuple[Cause, ...]:
    """Return the causes, of those ``standing``, that look the same as the one chosen, whose rank is ``fewest``.

    What fits everything contradicts nothing: it stands beside a turn of several angles, not beside that of one axis,
    unless the recorded temperature changed enough for it, or one reading is all that there is. So does a temperature
    that would have moved the axes of one name alone.
    """
    (stated,) = chosen.stated
    is_turn = stated.kind == "table-rotation"
    is_single = len(chosen.agreeing) == 1 and fewest >= data.fits_all
    is_doubted = is_single or fewest > 1 or _rotation_rad(axes, visits, chosen) < visits.warmth_g
    is_plain = is_turn and not is_doubted and _is_all_there_is(data, stated, visits.degrees_of_freedom)
    others = [
        cause
        for cause, _, used in standing
        if is_doubted or (used < data.fits_all and not (is_plain and cause.name.endswith(LIKE_AXES)))
    ]
    if fewest >= data.fits_all and not is_turn:
        others.append(rotation(data))  # with a change of anything else beside it
    return tuple(cause for cause in others if not set(stated.parts) <= set(cause.parts))  # a wider one says no more


def _is_all_there_is(data: Whitened, stated: Cause, known_dof: float) -> bool:
    """Return whether nothing that a temperature does to all sensors alike is seen beside a cause."""
    every = tuple(name for cause in of_temperature(data) for name in cause.parts)
    least, rank = data.left(tuple(dict.fromkeys((*common_names(data), *every))))
    (left, used), (beside, most) = data.left(stated.parts), data.left(tuple(dict.fromkeys((*stated.parts, *every))))
    return scale_of(least, data.y.size - rank, known_dof).p_value(left - beside, most - used) >= CONSISTENT


def _together(data: Whitened, among: Sequence[str], scale: Scale, p_value: float, false_alarm: float) -> CommonMode:
    """Judge rotation, gain and offset in this order, each beside the others, where there are data enough for all.

    A rotation is always judged beside what a temperature may do to all sensors alike, which is told where it is seen.
    """
    names = common_names(data)
    if len(among) == 1 or data.y.size - data.left(names)[1] < FEWEST_LEFT:
        sensor_cause = Cause("sensor-change", " and ".join(among), ())
        return CommonMode((sensor_cause,), p_value, (), {}, (), tuple(among))
    meters = [name for name in data.columns if name.startswith(("gain", "offset"))]
    groups = [rotation(data), *(of_meter(name) for name in meters)]
    warmth = list(of_temperature(data))[-1:]  # of all offsets and sensitivities; none of a single dwell

    def is_seen(group: Cause, others: Sequence[Cause]) -> bool:
        beside = tuple(name for other in others if other != group for name in other.parts)
        (without, low), (whole, high) = data.left(beside), data.left((*beside, *group.parts))
        return scale.p_value(without - whole, high - low) < false_alarm

    all_of_them = [*groups, *warmth]
    beside = all_of_them if any(is_seen(cause, groups) for cause in warmth) else groups
    causes = [group for group in beside if is_seen(group, all_of_them if group is groups[0] else beside)]
    if not causes:
        causes = beside = warmth or groups[:1]
    every = tuple(name for group in beside for name in group.parts)
    estimates = data.estimates(every, scale.variance)
    parts = {name for cause in causes for name in cause.parts}
    kept = {name: estimate for name, estimate in estimates.items() if name in parts}
    return CommonMode(tuple(causes), p_value, (), kept, (), tuple(among))


def _rotation_rad(axes: WatchedAxes, visits: Visits, common: CommonMode) -> float:
    angles = []
    for rolls in set(axes.is_rolled.tolist()):
        moved = force_changes(visits.pitch_rad, visits.roll_rad if rolls else None, visits.yaw_rad).items()
        turned = [common.estimates[name].value * change for name, change in moved if name in common.estimates]
        angles.append(np.linalg.norm(sum(turned, np.zeros((visits.pitch_rad.size, 3))), axis=1).max(initial=0.0))
    return float(max(angles))


def _sized(axes: WatchedAxes, visits: Visits, found: SensorChange, common: CommonMode) -> SensorChange:
    """Return what a sensor changed beyond the common part, its largest as an angle."""
    kept = np.array([name == found.sensor for name in axes.sensor], dtype=bool)
    columns = columns_of(axes, visits, np.ones_like(kept), is_lone=False)
    shared = sum(
        (estimate.value * columns[name] for name, estimate in common.estimates.items() if name in columns),
        np.zeros_like(visits.change),
    )
    angle = np.where(np.isfinite(visits.change) & kept, (visits.change - shared) / sensitivity_of(axes), 0.0)
    worst = np.unravel_index(int(np.argmax(np.abs(angle))), angle.shape)
    imperfect = (model_error(axes, visits)[:, None] * sensitivity_of(axes)) ** 2
    seated = visits.seating_rad**2 * sum(columns[name] ** 2 for name in AXES_OF_TABLE if name in columns)
    drifted = 0.0 if visits.drifted is None else visits.drifted**2
    change, variance = (visits.change - shared)[:, kept], (visits.variance + imperfect + seated + drifted)[:, kept]
    freedom = visits.degrees_of_freedom
    roll = visits.roll_rad if axes.is_rolled[kept].all() else np.zeros_like(visits.roll_rad)
    left = LeftOver(visits.pitch_rad, roll, change, variance, axes.k[kept], freedom, visits.yaw_rad)
    culprit = mount_or_sensor(left)
    return replace(found, axis=axes.axis[int(worst[1])], largest_rad=float(angle[worst]), attribution=culprit)
