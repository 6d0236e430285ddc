"""A set applied: attitude to outputs, and outputs of a three-axis package back to the specific force.

The set is used where it is valid, with the inputs its equation needs, or not at all: a request outside is refused
unless the caller says that he knows.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from ams.errors import OutsideValidity
from ams.frames import specific_force
from ams.sets.belonging import Serials, check_belonging
from ams.sets.coefficients import CoefficientSet
from ams.sets.equations import FloatArray, predicted_v
from ams.sets.vectors import inferred_force, is_package

ROUNDING_DEG = 1e-9
"""Degrees to radians and back may move an angle this far beyond an end of the range."""


def apply(
    coefficients: CoefficientSet,
    pitch_rad: ArrayLike,
    roll_rad: ArrayLike,
    temperature_degc: ArrayLike | None = None,
    *,
    beyond_validity: bool = False,
    chain_serial: Serials | None = None,
    site_gravity_mps2: float | None = None,
) -> dict[str, FloatArray]:
    """Outputs in volts per axis, of the shape that the inputs broadcast to.

    ``chain_serial`` (of every channel, or channel to serial) and ``site_gravity_mps2`` say where the set is used; what
    was calibrated with another chain or at another g is refused.

    Raises: OutsideValidity for an attitude or temperature outside the set's validity (unless ``beyond_validity``),
    for a missing temperature, for an input that is not finite, and for another chain or site.
    """
    check_belonging(coefficients, chain_serial, site_gravity_mps2)
    pitch, roll = np.broadcast_arrays(np.asarray(pitch_rad, dtype=float), np.asarray(roll_rad, dtype=float))
    temperature = _temperature(coefficients, temperature_degc)
    _check_finite(coefficients, {"pitch": pitch, "roll": roll, "temperature": temperature})
    if not beyond_validity:
        _check_attitude(coefficients, pitch, roll)
        _check_temperature(coefficients, temperature)
    f = specific_force(pitch, roll)
    return {name: predicted_v(numbers, f, temperature) for name, numbers in coefficients.axes.items()}


def sensed_force(
    coefficients: CoefficientSet,
    outputs_v: Mapping[str, ArrayLike],
    temperature_degc: ArrayLike | None = None,
    *,
    chain_serial: Serials | None = None,
    site_gravity_mps2: float | None = None,
) -> FloatArray:
    """(…, 3) specific force in package axes, local g, from the outputs of a three-axis package.

    Raises: OutsideValidity where the set has no three independent axes, an output is missing or a temperature is, and
    for another chain or site than was calibrated (see :func:`apply`).
    """
    check_belonging(coefficients, chain_serial, site_gravity_mps2)
    if not is_package(coefficients.axes) or set(outputs_v) != set(coefficients.axes):
        raise OutsideValidity(
            f"{coefficients.sensor}: specific force cannot be told from {', '.join(outputs_v)}: the set has the axes "
            f"{', '.join(coefficients.axes)}, needed are all of three independent ones; nothing was computed"
        )
    outputs = {name: np.asarray(outputs_v[name], dtype=float) for name in coefficients.axes}
    temperature = _temperature(coefficients, temperature_degc)
    _check_finite(coefficients, {**outputs, "temperature": temperature})
    return inferred_force(coefficients.axes, outputs, temperature)


def _temperature(coefficients: CoefficientSet, temperature_degc: ArrayLike | None) -> FloatArray | None:
    if temperature_degc is not None:
        return np.asarray(temperature_degc, dtype=float)
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


def _check_attitude(coefficients: CoefficientSet, pitch_rad: FloatArray, roll_rad: FloatArray) -> None:
    low, high = coefficients.validity.pitch_deg
    pitch_deg = np.degrees(pitch_rad)
    _check_range(coefficients, "pitch", "deg", pitch_deg, (low, high), (pitch_deg - low, high - pitch_deg))
    low, high = coefficients.validity.roll_deg
    roll_deg = np.degrees(roll_rad)
    above = (roll_deg - low + ROUNDING_DEG) % 360.0 - ROUNDING_DEG
    _check_range(coefficients, "roll", "deg", roll_deg, (low, high), (above, high - low - above))


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
    raise OutsideValidity(
        f"{coefficients.sensor}: {name} outside the validity of the set: got {worst:.6g} {unit}, calibrated from "
        f"{limits[0]:.6g} to {limits[1]:.6g} {unit}; nothing was computed; calibrate over the range you use, or say "
        "beyond_validity=True and answer for it"
    )
