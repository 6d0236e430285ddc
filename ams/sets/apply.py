"""A set applied: attitude to outputs, and outputs of a three-axis package back to the specific force.

The set is used where it is valid, with the inputs its equation needs, or not at all: a request outside is refused
unless the caller says that he knows.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ams.arrays import FloatArray
from ams.errors import OutsideValidity
from ams.frames import Exposure
from ams.models.possible_temperature import POSSIBLE, impossible_temperatures, likely_unit
from ams.models.sensor_model import SetForm
from ams.sets.applicability import Serials, check_applicability
from ams.sets.coefficients import CoefficientSet
from ams.sets.equations import predicted_v
from ams.sets.sensed_quantity import field_at
from ams.sets.vectors import inferred_force, resolves
from ams.units import with_unit

ROUNDING_DEG = 1e-9
"""Degrees to radians and back may move an angle this far beyond an end of the range."""
LEVEL_SLACK = 1e-6
"""Of the range of a level, beyond its ends: these were measured, and 1 g lies a part in 1e8 beyond a table's 90°."""


def apply(
    coefficients: CoefficientSet,
    pitch_rad: ArrayLike = 0.0,
    roll_rad: ArrayLike = 0.0,
    temperature_degc: ArrayLike | None = None,
    *,
    yaw_rad: ArrayLike | None = None,
    euler_rate_rad_s: ArrayLike | None = None,
    level: ArrayLike | None = None,
    beyond_validity: bool = False,
    chain_serial: Serials | None = None,
    site_gravity_mps2: float | None = None,
) -> dict[str, FloatArray]:
    """Return the outputs in volts per axis, of the shape that the inputs broadcast to.

    Sets of straight lines take ``level``, (…, 3): the quantity itself along the package's axes, in the set's unit, and
    give outputs in the unit of their readings. CR's sets need ``yaw_rad``, its gyros also the rates of pitch, yaw and
    roll, (…, 3), ``euler_rate_rad_s``.

    ``chain_serial`` (of every channel, or channel to serial) and ``site_gravity_mps2`` say where the set is used; what
    was calibrated with another chain or at another g is refused.

    Raises: OutsideValidity for an attitude, level or temperature outside the set's validity (unless
    ``beyond_validity``), for a missing temperature, for an input that is not finite, and for another chain or site.
    """
    check_applicability(coefficients, chain_serial, site_gravity_mps2)
    attitude = _attitude(coefficients, pitch_rad, roll_rad, yaw_rad, euler_rate_rad_s)
    if level is not None:
        found = np.asarray(level, dtype=float)
        if found.ndim == 0 or found.shape[-1] != 3:
            raise OutsideValidity(
                f"{coefficients.sensor}: level: got an array of shape {found.shape}, needed (…, 3) along the package's "
                "axes; nothing was computed"
            )
        _check_finite(coefficients, {"level": found})
        attitude = replace(attitude, package_level=found)
    temperature = _temperature(coefficients, temperature_degc)
    _check_finite(coefficients, {"temperature": temperature})
    named = {(numbers.model, numbers.units): numbers.form for numbers in coefficients.axes.values()}
    fields = {name: (form, field_at(*name, attitude)) for name, form in named.items()}
    if not beyond_validity:
        _check_attitude(coefficients, attitude, list(fields.values()))
        _check_temperature(coefficients, temperature)
    return {
        name: predicted_v(numbers, fields[numbers.model, numbers.units][1], temperature)
        for name, numbers in coefficients.axes.items()
    }


def _attitude(
    coefficients: CoefficientSet,
    pitch_rad: ArrayLike,
    roll_rad: ArrayLike,
    yaw_rad: ArrayLike | None,
    euler_rate_rad_s: ArrayLike | None,
) -> Exposure:
    """Return the attitude from the angles and rates given.

    Raises: OutsideValidity for a value that is not finite, or a yaw that the set's model would ignore.
    """
    named = {"pitch": pitch_rad, "roll": roll_rad, "yaw": 0.0 if yaw_rad is None else yaw_rad}
    angles = dict(zip(named, np.broadcast_arrays(*(np.asarray(v, dtype=float) for v in named.values())), strict=True))
    rates = None if euler_rate_rad_s is None else np.asarray(euler_rate_rad_s, dtype=float)
    _check_finite(coefficients, {**angles, "rates": rates})
    if coefficients.convention == "TP" and np.any(angles["yaw"] != 0.0):
        raise OutsideValidity(
            f"{coefficients.sensor}: yaw_rad: the model {coefficients.model} has no yaw, allowed 0 or none; nothing "
            "was computed; use a set of the model pitch-yaw-roll"
        )
    yaw = None if yaw_rad is None else angles["yaw"]
    return Exposure(angles["pitch"], angles["roll"], yaw, euler_rate_rad_s=rates)


def sensed_level(
    coefficients: CoefficientSet, outputs: Mapping[str, ArrayLike], *, chain_serial: Serials | None = None
) -> FloatArray:
    """Return what three straight lines sense, (…, 3) along the package's axes, in the set's unit.

    Raises: OutsideValidity where the set is no three of them, an output is missing, or for another chain.
    """
    check_applicability(coefficients, chain_serial, None)
    if not (coefficients.is_of_lines and resolves(coefficients.axes)) or set(outputs) != set(coefficients.axes):
        raise OutsideValidity(
            f"{coefficients.sensor}: a level in all directions cannot be told from {', '.join(outputs)}: the set has "
            f"the axes {', '.join(coefficients.axes)} by {coefficients.model}, needed are three straight lines; "
            "nothing was computed"
        )
    readings = {name: np.asarray(outputs[name], dtype=float) for name in coefficients.axes}
    _check_finite(coefficients, {**readings})
    return inferred_force(coefficients.axes, readings, None)


def _temperature(coefficients: CoefficientSet, temperature_degc: ArrayLike | None) -> FloatArray | None:
    if temperature_degc is not None:
        given = np.asarray(temperature_degc, dtype=float)
        beyond = impossible_temperatures(given)
        if beyond.any():
            raise OutsideValidity(
                f"{coefficients.sensor}: temperature: got {given[beyond].ravel()[0]:g} °C, allowed {POSSIBLE}; nothing "
                f"was computed; {likely_unit(given)}"
            )
        return given
    if coefficients.needs_temperature:
        raise OutsideValidity(
            f"{coefficients.sensor}: temperature_degc is missing: the set has temperature coefficients; "
            "nothing was computed; give the sensor's own temperature"
        )
    return None


def _check_finite(coefficients: CoefficientSet, inputs: Mapping[str, FloatArray | None]) -> None:
    for name, values in inputs.items():
        if values is not None and not np.isfinite(values).all():
            raise OutsideValidity(
                f"{coefficients.sensor}: {name}: {int((~np.isfinite(values)).sum())} of {values.size} values are not "
                "finite; nothing was computed; leave them out"
            )


def _check_attitude(
    coefficients: CoefficientSet, attitude: Exposure, fields: Sequence[tuple[SetForm, FloatArray]]
) -> None:
    if attitude.package_level is not None:
        _check_levels(coefficients, attitude.package_level)
        return
    validity, angles = coefficients.validity, {"pitch": np.degrees(attitude.pitch_rad)}
    if attitude.yaw_rad is not None and validity.yaw_deg is not None:
        angles["yaw"] = np.degrees(attitude.yaw_rad)
    ranges = {"pitch": validity.pitch_deg, "yaw": validity.yaw_deg}
    turning = [field for form, field in fields if form.senses_rates]
    if turning:
        _check_rates(coefficients, turning[0])
        return
    for name, angle_deg in angles.items():
        limits = ranges[name]
        assert limits is not None
        _check_range(coefficients, name, "deg", angle_deg, limits, (angle_deg - limits[0], limits[1] - angle_deg))
    if not all(form.senses_roll for form, _ in fields):
        return
    roll_deg = np.degrees(attitude.roll_rad)
    _check_range(coefficients, "roll", "deg", roll_deg, validity.roll_deg, validity.roll_margins_deg(roll_deg))


def _check_levels(coefficients: CoefficientSet, level: FloatArray) -> None:
    for index, name in enumerate(next(iter(coefficients.axes.values())).form.inputs):
        limits = coefficients.validity.levels.get(name)
        if limits is not None:
            quantity, unit = name.rsplit("_", 1)
            along, slack = level[..., index], LEVEL_SLACK * (limits[1] - limits[0])
            margins = along - limits[0] + slack, limits[1] - along + slack
            _check_range(coefficients, quantity, unit, along, limits, margins)


def _check_rates(coefficients: CoefficientSet, rate_dps: FloatArray) -> None:
    """Refuse rates beyond the set's validity.

    Angles do not matter to a gyro, the angular velocity along its package's axes does.
    """
    limits = coefficients.validity.rate_dps
    if limits is not None:
        _check_range(coefficients, "rate", "dps", rate_dps, limits, (rate_dps - limits[0], limits[1] - rate_dps))


def _check_temperature(coefficients: CoefficientSet, temperature_degc: FloatArray | None) -> None:
    limits = coefficients.validity.temperature_degc
    if temperature_degc is None or limits is None:
        return
    margins = temperature_degc - limits[0], limits[1] - temperature_degc
    _check_range(coefficients, "temperature", "degc", temperature_degc, limits, margins)


def _check_range(
    coefficients: CoefficientSet,
    name: str,
    unit: str,
    values: FloatArray,
    limits: tuple[float, float],
    margins: tuple[FloatArray, FloatArray],
) -> None:
    margin = np.minimum(*margins)
    if margin.size == 0 or margin.min() >= -ROUNDING_DEG:
        return
    worst = float(values.flat[int(margin.argmin())])
    got, low, high = _in_distinct_digits(worst, limits)
    raise OutsideValidity(
        f"{coefficients.sensor}: {name} outside the validity of the set: got {with_unit(got, unit)}, "
        f"calibrated from {low} to {with_unit(high, unit)}; nothing was computed; calibrate "
        "over the range you use, or say beyond_validity=True and answer for it"
    )


def _in_distinct_digits(value: float, limits: tuple[float, float]) -> tuple[str, str, str]:
    """Return a value and the limits that it lies beyond in six digits, or in as many as show the difference."""
    for digits in range(6, 17):
        value_text, low, high = (f"{number:.{digits}g}" for number in (value, *limits))
        if value_text not in (low, high):
            break
    return value_text, low, high
