"""Which designs fit the lattice and the limits of a rig's axes: what `calrig plan` tries.

Where a certificate lists the errors of an axis at angles (``index_table``), designs at these angles stand beside those
at any: what lies between two listed angles is known no better than the limit says.
"""

from collections.abc import Iterator
from math import ceil, floor

from procedures.check.candidate import STEEPEST_DEG, SearchRequest
from procedures.plan.sequential import CALIBRATION_OVER_USAGE
from rig.description.device_settings import AxisSettings
from rig.description.index_table import IndexTable

_FEWEST_PITCHES = 3
_SAME_DEG = 1e-5


def tables_on_the_lattice(request: SearchRequest) -> Iterator[dict[str, object]]:
    """Yield the designs that fit the lattice and the limits of the axes, as tables of a procedure."""
    if "pitch" not in request.rig.axes:
        return
    seen: list[dict[str, object]] = []
    for at_listed in (False, True):
        for table in _tables(request, at_listed=at_listed):
            if table not in seen:
                seen.append(table)
                yield table


def _tables(request: SearchRequest, *, at_listed: bool) -> Iterator[dict[str, object]]:
    for pitches, rolls in request.space.grids:
        sets = _sets(request, pitches, rolls, at_listed=at_listed)
        if len(sets["pitch_deg"]) >= _FEWEST_PITCHES:
            yield {"kind": "D", **sets}
    for pitches, rolls, every in request.space.fractions:
        sets = _sets(request, pitches, rolls, at_listed=at_listed)
        if len(sets["pitch_deg"]) >= _FEWEST_PITCHES and len(sets.get("roll_deg", ())) > every:
            yield {"kind": "fractional", "fractional": (every, every), **sets}
    for pitches, rolls, points in request.space.optimal:
        sets = _sets(request, pitches, rolls, at_listed=at_listed)
        if len(sets["pitch_deg"]) * len(sets.get("roll_deg", (0.0,))) > points:
            yield {"kind": "optimal", "points": points, "criterion": "I", **sets}


def _sets(request: SearchRequest, pitches: int, rolls: int, *, at_listed: bool) -> dict[str, tuple[float, ...]]:
    """Return the sets of angles of a design; without ``roll_deg`` where no axis rolls."""
    axes, (low, high) = request.rig.axes, request.usage.pitch_deg
    middle, half = 0.5 * (low + high), 0.5 * (high - low) * CALIBRATION_OVER_USAGE
    pitch_range = _within(axes["pitch"], max(middle - half, -STEEPEST_DEG), min(middle + half, STEEPEST_DEG))
    found = {"pitch_deg": _lattice(axes["pitch"], *pitch_range, pitches, at_listed=at_listed)}
    if "roll" in axes:
        found["roll_deg"] = _circle(axes["roll"], rolls, at_listed=at_listed)
    return {**found, "usage_pitch_deg": (low, high)}


def _within(axis: AxisSettings, low_deg: float, high_deg: float) -> tuple[float, float]:
    ends = sorted(axis.attitude_deg(limit) for limit in axis.limits_deg)
    room = abs(axis.approach_deg)
    return max(low_deg, ends[0] + room), min(high_deg, ends[1] - room)


def _lattice(axis: AxisSettings, low_deg: float, high_deg: float, count: int, *, at_listed: bool) -> tuple[float, ...]:
    """Return angles as evenly spread as the axis allows where it stops."""
    wanted = [low_deg + (high_deg - low_deg) * index / (count - 1) for index in range(count)]
    listed = _listed(axis, low_deg, high_deg) if at_listed else ()
    if listed:
        return tuple(dict.fromkeys(min(listed, key=lambda stop: abs(stop - angle)) for angle in wanted))
    return tuple(dict.fromkeys(_stop(axis, angle, low_deg, high_deg) for angle in wanted))


def _listed(axis: AxisSettings, low_deg: float, high_deg: float) -> tuple[float, ...]:
    """Return the attitudes of the certificate's list at which the axis stops, inside the range."""
    if not isinstance(axis.index_table, IndexTable):
        return ()
    step = axis.increment_deg
    return tuple(
        round(attitude, 6)
        for angle in axis.index_table.angle_deg
        for attitude in (axis.attitude_deg(angle + 360.0 * turns) for turns in (-1, 0, 1))
        if low_deg - _SAME_DEG <= attitude <= high_deg + _SAME_DEG
        and (step == 0.0 or abs(angle / step - round(angle / step)) * step < _SAME_DEG)
    )


def _stop(axis: AxisSettings, angle_deg: float, low_deg: float, high_deg: float) -> float:
    """Return the attitude nearest to an angle at which the axis stops, inside the range."""
    step = axis.increment_deg
    if step == 0.0:
        return round(angle_deg, 6)
    ends = sorted(axis.table_deg(end) for end in (low_deg, high_deg))
    step_number = min(
        max(round(axis.table_deg(angle_deg) / step), ceil(ends[0] / step - 1e-9)), floor(ends[1] / step + 1e-9)
    )
    return round(axis.attitude_deg(step_number * step), 6)


def _circle(axis: AxisSettings, count: int, *, at_listed: bool) -> tuple[float, ...]:
    """Return rolls all round, or over what the axis reaches where it does not go round."""
    low, high = _within(axis, -180.0, 180.0 - 360.0 / count)
    if (low, high) != (-180.0, 180.0 - 360.0 / count):
        low, high = _within(axis, -180.0, 180.0)
    return _lattice(axis, low, high, count, at_listed=at_listed)
