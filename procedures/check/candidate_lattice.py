"""Which designs fit the lattice and the limits of a rig's axes: what `calrig plan` tries."""

from collections.abc import Iterator
from math import ceil, floor

from procedures.check.candidate import STEEPEST_DEG, Asked
from procedures.plan.sequential import CALIBRATION_OVER_USAGE
from rig.description.device_settings import AxisSettings


def tables_on_the_lattice(asked: Asked) -> Iterator[dict[str, object]]:
    """Yield the designs that fit the lattice and the limits of the axes, as tables of a procedure."""
    axes, (low, high) = asked.rig.axes, asked.usage.pitch_deg
    if "pitch" not in axes:
        return
    middle, half = 0.5 * (low + high), 0.5 * (high - low) * CALIBRATION_OVER_USAGE
    pitch_range = _within(axes["pitch"], max(middle - half, -STEEPEST_DEG), min(middle + half, STEEPEST_DEG))
    seen = set()
    for pitches, rolls, *fraction in (*asked.space.grids, *asked.space.fractions):
        pitch = _lattice(axes["pitch"], *pitch_range, pitches)
        roll = _circle(axes["roll"], rolls) if "roll" in axes else (0.0,)
        key = (pitch, roll, tuple(fraction))
        if len(pitch) < 3 or key in seen or (fraction and len(roll) <= fraction[0]):
            continue
        seen.add(key)
        kind = {"kind": "fractional", "fractional": (fraction[0], fraction[0])} if fraction else {"kind": "D"}
        with_roll = {"roll_deg": roll} if "roll" in axes else {}
        yield {**kind, "pitch_deg": pitch, **with_roll, "usage_pitch_deg": (low, high)}
    for pitches, rolls, points in asked.space.optimal:
        pitch = _lattice(axes["pitch"], *pitch_range, pitches)
        roll = _circle(axes["roll"], rolls) if "roll" in axes else (0.0,)
        if len(pitch) * len(roll) > points:
            with_roll = {"roll_deg": roll} if "roll" in axes else {}
            chosen = {"kind": "optimal", "points": points, "criterion": "I"}
            yield {**chosen, "pitch_deg": pitch, **with_roll, "usage_pitch_deg": (low, high)}


def _within(axis: AxisSettings, low_deg: float, high_deg: float) -> tuple[float, float]:
    ends = sorted(axis.attitude_deg(limit) for limit in axis.limits_deg)
    room = abs(axis.approach_deg)
    return max(low_deg, ends[0] + room), min(high_deg, ends[1] - room)


def _lattice(axis: AxisSettings, low_deg: float, high_deg: float, count: int) -> tuple[float, ...]:
    """Return angles as evenly spread as the axis allows where it stops."""
    wanted = [low_deg + (high_deg - low_deg) * place / (count - 1) for place in range(count)]
    return tuple(dict.fromkeys(_stop(axis, angle, low_deg, high_deg) for angle in wanted))


def _stop(axis: AxisSettings, angle_deg: float, low_deg: float, high_deg: float) -> float:
    """Return the attitude nearest to an angle at which the axis stops, inside the range."""
    step = axis.increment_deg
    if step == 0.0:
        return round(angle_deg, 6)
    ends = sorted(axis.table_deg(end) for end in (low_deg, high_deg))
    place = min(max(round(axis.table_deg(angle_deg) / step), ceil(ends[0] / step - 1e-9)), floor(ends[1] / step + 1e-9))
    return round(axis.attitude_deg(place * step), 6)


def _circle(axis: AxisSettings, count: int) -> tuple[float, ...]:
    """Return rolls all round, or over what the axis reaches where it does not go round."""
    low, high = _within(axis, -180.0, 180.0 - 360.0 / count)
    if (low, high) != (-180.0, 180.0 - 360.0 / count):
        low, high = _within(axis, -180.0, 180.0)
    return _lattice(axis, low, high, count)
