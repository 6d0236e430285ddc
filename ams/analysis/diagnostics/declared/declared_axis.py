"""Whether an axis senses along the direction that is declared of it: the words are those of the check of the mount.

The direction of an axis is that of the largest component of its sensitivities. Where that is another than the declared
one, by more than chance would have it, channels are interchanged or the package sits otherwise than declared; where the
polarity is declared and the vector points the other way, it is reversed. Every number of such an axis is true of
something else than its name says. An accelerometer whose sensitivity is far from the declared one reads right by its
own numbers and wrong by the data sheet's: the unit, the load or the sensor is another one.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from math import hypot
from typing import Final

import numpy as np

from ams.analysis.diagnostics.facts import undetermined_axis, undetermined_offset
from ams.arrays import FloatArray
from ams.calibration_result import AxisCalibration
from ams.findings import DECLARED_SIZE, Finding, leaves_nothing
from ams.frames import AXES
from ams.inputs.declared_direction import GAIN_RANGE, DeclaredDirection, NominalSensitivity
from ams.models.model import Model
from ams.rounding import significant
from ams.units import printed

KIND: Final = "axis-contradicted"
_FAR: Final = 5.0
"""Standard uncertainties: with two replications Student's factor at two would call a dead channel interchanged."""
_ROUNDING: Final = 1e-12
"""Of the constant output: what is left of a sensitivity by rounding."""
_CROSS_TALK: Final = 0.1
"""Of the declared sensitivity: a run's check of the mount calls less than that no response too."""
_ALIKE: Final = 0.75
"""A sensitivity within this part of that of another unit, or as much above, is likely in that unit."""
_PER_GRAVITY: Final = "CR"
"""This convention counts sensitivities of accelerometers per g of gravity, and a rig file declares polarity by the
specific force: signs are not held against each other."""
_COMPONENT = re.compile(r"k_([xyz])_[a-z0-9]+_per_[a-z0-9]+")
_UNITS: Final[Mapping[str, Mapping[float, str]]] = {
    "v": {1e6: "microvolts", 1e3: "millivolts", 1e-3: "kilovolts, or what is declared like millivolts"},
    "g": {1e6: "µg", 1e3: "mg", 9.80665: "m/s²"},
    "mps2": {1e3: "mm/s²", 102.0: "mg", 0.102: "g"},
    "dps": {3600.0: "°/h", 1e3: "thousandths of °/s", 60.0: "°/min", 0.01745: "rad/s"},
    "ut": {1e3: "nT", 10.0: "mG", 1e-2: "gauss", 1e-6: "tesla"},
}
"""Of the unit that is said, what was read over what is nominal, to the unit that would make them agree."""
_NOT_USABLE: Final = (
    "offset and sensitivity belong to something else than the name of this axis says; the result is not usable and "
    "there is no coefficient set"
)
_WHAT_TO_DO: Final = (
    "correct the wiring and measure again, or correct what is declared (channels and mount of the rig file, "
    "nominal_sensitivity_v_per_g, --axis) and solve again"
)


def direction_findings(
    model: Model, primary: FloatArray, covariance: FloatArray, dof: FloatArray, declared: DeclaredDirection
) -> Iterator[Finding]:
    """Yield what makes an axis unusable: it senses along another direction than declared, or along none."""
    silent = silent_axis(model, primary, declared)
    if silent is not None:
        yield silent
        return
    found = contradicted_axis(model, primary, covariance, declared)
    if found is not None:
        yield found
        return
    undetermined = tuple(undetermined_axis(model, primary, covariance, dof))
    yield from undetermined or undetermined_offset(model, primary, covariance)
    if not undetermined:
        yield from contradicted_size(model, primary, covariance, declared)


def undetermined_by_errors(
    findings: Sequence[Finding], model: Model, primary: FloatArray, covariance: FloatArray, dof: FloatArray
) -> tuple[Finding, ...]:
    """Return what makes an axis unusable once the errors that its own rows show are counted; nothing where it was.

    ``findings``: what was found before; ``primary``, ``dof``: (P,) and ``covariance``: (P, P) with these errors.
    """
    if any(map(leaves_nothing, findings)):
        return ()
    undetermined = tuple(undetermined_axis(model, primary, covariance, dof, by_errors=True))
    return undetermined or tuple(undetermined_offset(model, primary, covariance))


def silent_axis(model: Model, primary: FloatArray, declared: DeclaredDirection) -> Finding | None:
    """Return a finding where an axis responds to nothing: what is left of its sensitivities is rounding, or cross-talk.

    By cross-talk an axis that is declared to read much more lies along another one, whose channel it picks up.
    """
    at = component_indices(model.primary_names)
    if not at or declared.axis not in at:
        return None
    values = primary.tolist()
    k = {axis: values[index] for axis, index in at.items()}
    size = hypot(*k.values())
    level = max((abs(value) for index, value in enumerate(values) if index not in at.values()), default=0.0)
    is_rounding = size <= _ROUNDING * level
    nominal = declared.sensitivity
    least = 0.0 if nominal is None else _CROSS_TALK * nominal.size
    if not (is_rounding or (size < least and max(k, key=lambda axis: abs(k[axis])) != declared.axis)):
        return None
    unit = "V" if nominal is None else printed(nominal.unit)
    beside = "" if nominal is None or is_rounding else f" ({_stated(nominal)}; what it shows is picked up from others)"
    fact = (
        f"it does not respond: of its output, {significant(level)} {unit}, {significant(size)} {unit} change with what "
        f"was visited{beside}: the channel is dead, or not connected; the result is not usable and there is no "
        "coefficient set"
    )
    what_to_do = "look at sensor, wiring and the channel of the meter, and measure again, or leave this axis out"
    details: dict[str, float | str | None] = {"sensitivity": size}
    return Finding("axis-undetermined", fact, True, None, details=details, what_to_do=what_to_do)


def contradicted_size(
    model: Model, primary: FloatArray, covariance: FloatArray, declared: DeclaredDirection
) -> Iterator[Finding]:
    """Yield a finding where the sensitivity is plainly outside the range about the nominal one.

    It is the one that a run's check of the mount has; here every dwell counts, and a run that went on in spite of that
    check carries it in its result.
    """
    nominal = declared.sensitivity
    indices = list(component_indices(model.primary_names).values())
    if nominal is None or not indices:
        return
    k = primary[indices]
    found = float(np.linalg.norm(k))
    if not found > 0.0:
        return
    along = k / found
    u = float(np.sqrt(max(float(along @ covariance[np.ix_(indices, indices)] @ along), 0.0)))
    low, high = (factor * nominal.size for factor in GAIN_RANGE)
    if not (found - _FAR * u > high or found + _FAR * u < low):
        return
    ratio, name = found / nominal.size, f"{nominal.unit}_per_{nominal.per}"
    fact = (
        f"the sensitivity is {significant(found, 4)} {nominal.printed_unit}, {_stated(nominal)}: "
        f"{significant(ratio, 3)} times that, allowed {GAIN_RANGE[0]:g} to {GAIN_RANGE[1]:g} times; "
        f"{_likely(nominal, ratio)}; offset and sensitivity stand in the unit of the numbers that were "
        "read, and the result is not usable as it is"
    )
    what_to_do = "correct the numbers or what is declared, and solve again"
    details: dict[str, float | str | None] = {f"{DECLARED_SIZE}{name}": nominal.size, f"sensitivity_{name}": found}
    yield Finding(KIND, fact, True, None, details=details, is_held=False, what_to_do=what_to_do)


def _stated(nominal: NominalSensitivity) -> str:
    size = f"{nominal.size:g} {nominal.printed_unit}"
    if nominal.is_of_unit:
        return f"numbers in {printed(nominal.unit)} have {size}"
    return f"declared are {size} (nominal_sensitivity_v_per_{nominal.per})"


def _likely(nominal: NominalSensitivity, ratio: float) -> str:
    """Return what is likely wrong, by how many times the nominal sensitivity was read."""
    for factor, unit in _UNITS.get(nominal.unit, {}).items():
        if _ALIKE * factor <= ratio <= factor / _ALIKE:
            return f"the numbers look like {unit}"
    if ratio < _CROSS_TALK:
        return "the channel hardly responds, or its numbers are in another unit"
    return "the range, the gain of an amplifier or the load resistor is another than declared, or the sensor is"


def contradicted_axis(
    model: Model, primary: FloatArray, covariance: FloatArray, declared: DeclaredDirection
) -> Finding | None:
    """Return a finding where the sensitivities point along another axis than declared, or the other way."""
    at = component_indices(model.primary_names)
    if declared.axis not in at:
        return None
    k = {axis: float(primary[index]) for axis, index in at.items()}
    nearest = max(k, key=lambda axis: abs(k[axis]))
    weights = np.zeros(primary.size)
    weights[at[nearest]] = 1.0 if k[nearest] > 0.0 else -1.0
    if nearest != declared.axis:
        weights[at[declared.axis]] = -1.0 if k[declared.axis] > 0.0 else 1.0
    ahead, u = float(weights @ primary), float(np.sqrt(max(float(weights @ covariance @ weights), 0.0)))
    is_per_gravity = model.convention == _PER_GRAVITY and model.primary_names[at[declared.axis]].endswith("_per_g")
    polarity = None if is_per_gravity else declared.polarity
    sign = polarity or 1
    sense = (1 if k[nearest] > 0.0 else -1) * sign
    is_another = nearest != declared.axis
    is_reversed = not is_another and polarity is not None and sense != declared.sense
    if not (is_another or is_reversed) or not ahead > _FAR * u:
        return None
    length = hypot(*k.values())
    along = sign * declared.sense * k[declared.axis] / length
    away_deg = float(np.rad2deg(np.arccos(np.clip(along if polarity else abs(along), -1.0, 1.0))))
    reads_as = f"{'+' if sense > 0 else '-'}{nearest}" if polarity else nearest
    stated = declared.signed_axis if polarity else declared.axis
    what = (
        "another axis: channels are interchanged, an input is open or shorted and follows another channel, or the "
        "package sits otherwise than declared"
        if is_another
        else "polarity reversed"
    )
    fact = f"declared along {stated}, but it reads as {reads_as} ({away_deg:.1f}° away): {what}; {_NOT_USABLE}"
    details: dict[str, float | str | None] = {"declared": stated, "reads_as": reads_as, "away_deg": away_deg}
    return Finding(KIND, fact, True, None, details=details, what_to_do=_WHAT_TO_DO)


def handedness(axes: Mapping[str, AxisCalibration], declared: Mapping[str, DeclaredDirection]) -> Iterator[str]:
    """Yield a remark where x, y, z are left-handed and a polarity is not declared, so that nothing contradicts it."""
    are_signs_declared = all(axis in declared and declared[axis].polarity is not None for axis in AXES)
    if set(axes) != set(AXES) or are_signs_declared or any(map(_is_unusable, axes.values())):
        return
    vectors = [_components(axes[axis].primary_names, axes[axis].primary) for axis in AXES]
    if any(set(vector) != set(AXES) for vector in vectors):
        return
    matrix = np.array([[vector[axis] for axis in AXES] for vector in vectors])
    declared_signs = [entry.polarity or 1 for entry in declared.values()]
    if not float(np.prod(declared_signs) * np.linalg.det(matrix)) < 0.0:
        return
    yield (
        "the axes x, y, z are left-handed as they read: one of them has the opposite polarity, or all three have; no "
        "rig file declares their polarity (nominal_sensitivity_v_per_g), so nothing says whether it is meant"
    )


def _is_unusable(axis: AxisCalibration) -> bool:
    return any(leaves_nothing(finding) for finding in axis.findings)


def _components(names: tuple[str, ...], primary: FloatArray) -> dict[str, float]:
    return {name: float(primary[index]) for name, index in component_indices(names).items()}


@cache
def component_indices(names: tuple[str, ...]) -> Mapping[str, int]:
    """Return axis to the place of its sensitivity among the primary parameters."""
    return {match[1]: index for index, name in enumerate(names) if (match := _COMPONENT.fullmatch(name))}
