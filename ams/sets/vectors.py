"""Test vectors: inputs and expected outputs inside a set, so that whoever applies it can see that he does it right.

Forward vectors spread over the validity range, ends included. Inverse vectors take outputs back to angles; they exist
where three axes together determine the specific force: f = K⁻¹(v − b), the rows of K being the axes' k. Terms of higher
order bend an output by so little that f ← f + K⁻¹(v − v̂(f)) finds the force in a few steps.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ams.arrays import FloatArray
from ams.errors import VectorsDisagree
from ams.frames import Exposure, wrap_deg
from ams.models.sensor_model import RATE_INPUTS
from ams.sets.canonical import Document, Json, listed, number, table
from ams.sets.equations import AxisNumbers, are_lines, derived_direction, predicted_v
from ams.sets.sensed_quantity import field_at
from ams.units import UNITS, with_unit

TOLERANCE_RELATIVE = 1e-12
TOLERANCE_TEXT = "outputs: of |offset_v| + |k_x| + |k_y| + |k_z| of the axis; angles: of 180 degrees"
INVERSE_TOLERANCE_RELATIVE = 1e-10
"""Of levels out of outputs, whose zero may be many times what the level makes."""
DERIVED_TOLERANCE_RELATIVE = 1e-9
"""Derived parameters come from k by square roots and arc tangents, in degrees."""
LENGTH_TEXT = (
    "the length of f is one times gravity over that of the calibration: where it differs by more than the "
    "uncertainties explain, an output is wrong and the angles with it"
)
INVERSE_TEXT = (
    "K has one row (k_x, k_y, k_z) for each axis; f = K^-1 (outputs - offsets) (offsets and K at the temperature); "
    "pitch = atan2(f_x, sqrt(f_y^2 + f_z^2)); roll = atan2(-f_y, -f_z); " + LENGTH_TEXT
)
BENT_INVERSE_TEXT = (
    "K has one row (k_x, k_y, k_z) for each axis; f = 0 at first, then f = f + K^-1 (outputs - equation(f)), the "
    "differences divided by the factor of temperature, until f stays as it is; "
    "pitch = atan2(f_x, sqrt(f_y^2 + f_z^2)); roll = atan2(-f_y, -f_z); " + LENGTH_TEXT
)
LEVEL_INVERSE_TEXT = (
    "K has one row (k_x, k_y, k_z) for each axis; level = K^-1 (outputs - zero levels), along x, y, z of the package"
)
LEVEL = "level_"
"""How the inputs of straight lines begin, and their validity: level_x_ut."""
RATES_IN_RANGE = 0.4
"""Rates of the angles are drawn from this part of the range, so that they add up inside it along every axis."""
NO_INVERSE_TEXT = (
    "none: it takes three axes in TP's convention, nearly linear in the specific force, that together determine it"
)
NO_LEVEL_INVERSE_TEXT = "none for all three directions: it takes three axes; along one axis level = A*output + B"
LEVEL_TOLERANCE_TEXT = (
    "outputs: of |zero level| + |k_x| + |k_y| + |k_z| of the axis; levels: of the largest of a vector"
)
LARGEST_CONDITION_NUMBER = 30.0
LARGEST_CONTRACTION = 0.05
"""Of what is left of an error of the force in one step of the search."""
INVERSE_STEPS = 14
"""The first finds the linear solution; 0.05 to the power of 13 is far below the resolution of a double."""
LARGEST_INVERSE_PITCH_DEG = 80.0
SPREAD = (
    (0.5, 0.5, 0.5),
    (0.0, 0.5, 0.0),
    (1.0, 0.5, 1.0),
    (0.5, 0.25, 0.25),
    (0.5, 0.75, 0.75),
    (0.71, 0.13, 0.9),
    (0.18, 0.87, 0.1),
    (0.37, 0.62, 0.6),
    (0.93, 0.41, 0.3),
)
"""Fractions of the validity ranges of pitch, roll and temperature."""


ROUNDING_DEG = 1e-6
"""Angles went through radians; no angle is outside by less."""


@dataclass(frozen=True)
class Validity:
    """Where a set may be used, ends included."""

    pitch_deg: tuple[float, float]
    roll_deg: tuple[float, float]
    temperature_degc: tuple[float, float] | None
    yaw_deg: tuple[float, float] | None = None
    rate_dps: tuple[float, float] | None = None
    """Of the angular velocity along each package axis."""
    levels: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """``level_x_ut`` and so on: what each straight line was exposed to along its axis."""

    @property
    def goes_round(self) -> bool:
        """Whether every roll angle is valid."""
        return self.roll_deg[1] - self.roll_deg[0] >= 360.0

    def roll_margins_deg(self, roll_deg: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return how far angles lie above the lower end and below the upper, negative outside; roll goes round."""
        low, high = self.roll_deg
        above = (roll_deg - low + ROUNDING_DEG) % 360.0 - ROUNDING_DEG
        return above, high - low - above


@dataclass(frozen=True)
class VectorAgreement:
    """How well the test vectors were reproduced."""

    forward: int
    inverse: int
    largest_relative_error: float
    """Over all vectors, relative as the set says; at most 1e-12."""


def make_vectors(axes: Mapping[str, AxisNumbers], validity: Validity) -> Document:
    """Return the document's section ``test_vectors``, computed from the numbers."""
    with_temperature = any(numbers.needs_temperature for numbers in axes.values())
    forward = [_forward(axes, validity, fractions, with_temperature) for fractions in SPREAD]
    inverse = [vector for vector in forward if _is_invertible(axes, vector)]
    return {
        "tolerance_relative": TOLERANCE_RELATIVE,
        "tolerance_text": LEVEL_TOLERANCE_TEXT if are_lines(axes) else TOLERANCE_TEXT,
        "forward": list(forward),
        "inverse": list(inverse) or None,
        "inverse_text": _inverse_text(axes, has_inverse=bool(inverse)),
    }


def check_vectors(axes: Mapping[str, AxisNumbers], section: Mapping[str, Json], where: str) -> VectorAgreement:
    """Recompute every vector from the numbers.

    Raises: VectorsDisagree naming the axis, the attitude, both values and the tolerance.
    """
    forward, inverse = _tables(section["forward"]), _tables(section["inverse"])
    for numbers in axes.values():
        _check_derived(numbers, where)
    errors = [_forward_error(numbers, vector, where) for vector in forward for numbers in axes.values()]
    errors += [_inverse_error(axes, vector, where) for vector in inverse]
    return VectorAgreement(len(forward), len(inverse), max(errors))


def inferred_force(
    axes: Mapping[str, AxisNumbers], outputs_v: Mapping[str, FloatArray], temperature_degc: FloatArray | None
) -> FloatArray:
    """Return the (…, 3) specific force from the outputs of three axes, local g."""
    above = [
        (outputs_v[name] - numbers.offset_v(temperature_degc)) / numbers.gain(temperature_degc)
        for name, numbers in axes.items()
    ]
    inverse = np.linalg.inv(_matrix(axes)).T
    force = np.asarray(np.stack(np.broadcast_arrays(*above), axis=-1) @ inverse)
    if is_straight(axes):
        return force
    for _ in range(INVERSE_STEPS - 1):
        left = [
            (outputs_v[name] - predicted_v(numbers, force, temperature_degc)) / numbers.gain(temperature_degc)
            for name, numbers in axes.items()
        ]
        force = force + np.stack(np.broadcast_arrays(*left), axis=-1) @ inverse
    return force


def is_straight(axes: Mapping[str, AxisNumbers]) -> bool:
    """Return whether every axis is linear in what it senses."""
    return all(numbers.is_linear for numbers in axes.values())


def angles_of(f: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return pitch in [−π/2, π/2] and roll in (−π, π] of a specific force of any length."""
    x, y, z = np.moveaxis(f, -1, 0)
    return np.arctan2(x, np.hypot(y, z)), np.arctan2(-y, -z)


def is_package(axes: Mapping[str, AxisNumbers]) -> bool:
    """Return whether three axes in TP's convention determine the specific force: well conditioned, and hardly bent."""
    return all(numbers.form.convention == "TP" for numbers in axes.values()) and resolves(axes)


def resolves(axes: Mapping[str, AxisNumbers]) -> bool:
    """Return whether three axes determine what they sense in all directions: well conditioned, and hardly bent."""
    return (
        len(axes) == 3
        and all(numbers.model_output is None for numbers in axes.values())
        and bool(np.linalg.cond(_matrix(axes)) < LARGEST_CONDITION_NUMBER)
        and _contraction(axes) <= LARGEST_CONTRACTION
    )


def _contraction(axes: Mapping[str, AxisNumbers]) -> float:
    bends = [numbers.largest_bend_v_per_g for numbers in axes.values()]
    return float(np.linalg.norm(np.linalg.inv(_matrix(axes)), 2) * np.linalg.norm(bends))


def outputs_key(axes: Mapping[str, AxisNumbers]) -> str:
    """Return the key of the outputs in a vector, ``outputs_v`` or in the unit that a set's outputs have."""
    return f"outputs_{next(iter(axes.values())).form.measured_unit}"


def _inverse_text(axes: Mapping[str, AxisNumbers], *, has_inverse: bool) -> str:
    if are_lines(axes):
        return LEVEL_INVERSE_TEXT if has_inverse else NO_LEVEL_INVERSE_TEXT
    if not has_inverse:
        return NO_INVERSE_TEXT
    return INVERSE_TEXT if is_straight(axes) else BENT_INVERSE_TEXT


def _matrix(axes: Mapping[str, AxisNumbers]) -> FloatArray:
    return np.stack([numbers.direction for numbers in axes.values()])


def _forward(
    axes: Mapping[str, AxisNumbers], validity: Validity, fractions: tuple[float, float, float], with_temperature: bool
) -> Document:
    inputs = {name: None for numbers in axes.values() for name in numbers.form.inputs}
    if are_lines(axes):
        vector: Document = _levels(inputs, validity, fractions)
        vector[outputs_key(axes)] = {name: _output_v(numbers, vector) for name, numbers in axes.items()}
        return vector
    vector = {
        "pitch_deg": _between(validity.pitch_deg, fractions[0]),
        "roll_deg": _between(validity.roll_deg, fractions[1]),
    }
    if "yaw_deg" in inputs:
        vector["yaw_deg"] = _between(validity.yaw_deg or (0.0, 0.0), fractions[2])
    for name, fraction in zip(RATE_INPUTS, fractions, strict=True):
        if name in inputs:
            vector[name] = _between(validity.rate_dps or (0.0, 0.0), fraction) * RATES_IN_RANGE
    if with_temperature and validity.temperature_degc is not None:
        vector["temperature_degc"] = _between(validity.temperature_degc, fractions[2])
    vector["outputs_v"] = {name: _output_v(numbers, vector) for name, numbers in axes.items()}
    return vector


def _levels(inputs: Iterable[str], validity: Validity, fractions: tuple[float, float, float]) -> Document:
    """Return a level along every package axis; one without a sensor of its own takes the widest range of the others."""
    widest = max(validity.levels.values(), key=lambda limits: limits[1] - limits[0], default=(-1.0, 1.0))
    pairs = zip(inputs, fractions, strict=True)
    return {name: _between(validity.levels.get(name, widest), fraction) for name, fraction in pairs}


def _between(limits: tuple[float, float], fraction: float) -> float:
    """Return a point of the range, rounded to a micro-unit but never beyond an end."""
    return min(max(round(limits[0] + fraction * (limits[1] - limits[0]), 6), limits[0]), limits[1])


def _output_v(numbers: AxisNumbers, vector: Mapping[str, Json]) -> float:
    field_there = field_at(numbers.model, numbers.units, _exposure(vector))
    return float(predicted_v(numbers, field_there, _temperature(vector)))


def _exposure(vector: Mapping[str, Json]) -> Exposure:
    levels = [number(value) for name, value in vector.items() if name.startswith(LEVEL)]
    if levels:
        return Exposure(np.zeros(()), np.zeros(()), package_level=np.array(levels))
    angles = {name: np.radians(number(vector[name])) for name in ("pitch_deg", "roll_deg", "yaw_deg") if name in vector}
    rates = [np.radians(number(vector[name])) for name in RATE_INPUTS if name in vector]
    return Exposure(
        angles["pitch_deg"],
        angles["roll_deg"],
        angles.get("yaw_deg"),
        euler_rate_rad_s=np.array(rates) if rates else None,
    )


def _temperature(vector: Mapping[str, Json]) -> FloatArray | None:
    return np.asarray(number(vector["temperature_degc"])) if "temperature_degc" in vector else None


def _is_invertible(axes: Mapping[str, AxisNumbers], vector: Mapping[str, Json]) -> bool:
    if are_lines(axes):
        return resolves(axes)
    return is_package(axes) and abs(number(vector["pitch_deg"])) <= LARGEST_INVERSE_PITCH_DEG


def _check_derived(numbers: AxisNumbers, where: str) -> None:
    derived = derived_direction(numbers)
    if derived is None:
        return
    error = float(np.abs(derived - numbers.direction).max()) / numbers.scale_v
    if not error <= DERIVED_TOLERANCE_RELATIVE:
        raise VectorsDisagree(
            f"{where}: axis {numbers.axis}: sensitivity and angles do not belong to the primary k: relative difference "
            f"{error:.1e}, allowed {DERIVED_TOLERANCE_RELATIVE:.0e}; do not use this set; solve the run again"
        )


def _forward_error(numbers: AxisNumbers, vector: Mapping[str, Json], where: str) -> float:
    unit = numbers.form.measured_unit
    expected_v, got_v = number(table(vector[f"outputs_{unit}"])[numbers.axis]), _output_v(numbers, vector)
    error = abs(got_v - expected_v) / numbers.scale_v
    printed = UNITS.get(unit, unit)
    if not error <= TOLERANCE_RELATIVE:
        raise VectorsDisagree(
            f"{where}: axis {numbers.axis}: test vector at {_attitude(vector)} is not reproduced by the coefficients: "
            f"got {got_v!r} {printed}, expected {expected_v!r} {printed}, relative difference {error:.1e}, allowed "
            f"{TOLERANCE_RELATIVE:.0e}; do not use this set; it was assembled wrongly or for another convention"
        )
    return error


def _inverse_error(axes: Mapping[str, AxisNumbers], vector: Mapping[str, Json], where: str) -> float:
    outputs_v = {name: np.asarray(number(value)) for name, value in table(vector[outputs_key(axes)]).items()}
    if are_lines(axes):
        return _level_error(vector, inferred_force(axes, outputs_v, None), where)
    pitch_rad, roll_rad = angles_of(inferred_force(axes, outputs_v, _temperature(vector)))
    turn_deg = float(np.degrees(roll_rad)) - number(vector["roll_deg"])
    errors = (float(np.degrees(pitch_rad)) - number(vector["pitch_deg"]), wrap_deg(turn_deg))
    error = max(abs(errors[0]), abs(errors[1])) / 180.0
    if not error <= TOLERANCE_RELATIVE:
        raise VectorsDisagree(
            f"{where}: inverse test vector at {_attitude(vector)} is not reproduced by the coefficients: got "
            f"{float(np.degrees(pitch_rad))!r}° pitch, {float(np.degrees(roll_rad))!r}° roll; "
            "do not use this set; it was assembled wrongly or for another convention"
        )
    return error


def _level_error(vector: Mapping[str, Json], found: FloatArray, where: str) -> float:
    expected = np.array([number(value) for name, value in vector.items() if name.startswith(LEVEL)])
    scale = float(np.abs(expected).max())
    error = float(np.abs(found - expected).max()) / scale if scale > 0.0 else 0.0
    if not error <= INVERSE_TOLERANCE_RELATIVE:
        raise VectorsDisagree(
            f"{where}: inverse test vector at {_attitude(vector)} is not reproduced by the coefficients: got "
            f"{', '.join(map(repr, found.tolist()))}; do not use this set; it was assembled wrongly"
        )
    return error


def _attitude(vector: Mapping[str, Json]) -> str:
    parts = [
        f"{name.rsplit('_', 1)[0]} {with_unit(str(value), name.rsplit('_', 1)[1])}"
        for name, value in vector.items()
        if not name.startswith("outputs_")
    ]
    return ", ".join(parts)


def _tables(value: Json) -> list[Document]:
    return [table(entry) for entry in listed(value)]
