"""Sensors that stay the same from row to row, as the kernels that work block by block want them.

Every parameter of a set multiplies a polynomial in the specific force: one for the offset, f for the sensitivities,
the terms of second and third order less what their centring takes off. Written over one list of monomials for all axes,
the covariance of a set and the bend of its sensors are found once, and not at every row.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np

from ams.arrays import FloatArray, block_diagonal
from ams.attitude import flag_codes
from ams.attitude.few_axes import OneAxis, TwoAxes
from ams.attitude.force_covariance import LINE_BASIS, ParameterErrors, Polynomial
from ams.attitude.redundancy import at_offset_or_rail, may_be_wrong, name_suspects
from ams.attitude.static import Sensor, redundancy_limit
from ams.attitude.three_axes import AttitudeColumns, Bend, three_axes
from ams.calibration_result import VarianceComponent
from ams.inference.package.calibrated import CalibratedPackage, CalibratedSensor
from ams.models.extended import CUBIC_NAME, Q_NAMES
from ams.sets.sensed_quantity import PER_G

Kernel = Callable[[FloatArray, FloatArray], AttitudeColumns]
"""From (A, n) outputs in volts and (n,) roll in radians, which only one axis alone uses."""

_BENT: Final[tuple[Polynomial, ...]] = (
    *LINE_BASIS,
    *({powers: 1.0} for powers in ((2, 0, 0), (1, 1, 0), (1, 0, 1), (0, 2, 0), (0, 1, 1), (0, 0, 2))),
    *({powers: 1.0} for powers in ((3, 0, 0), (0, 3, 0), (0, 0, 3))),
)
_QUADRATIC: Final[Mapping[str, Mapping[tuple[int, int, int], float]]] = dict(
    zip(
        Q_NAMES,
        (
            {(2, 0, 0): 1.0, (0, 0, 2): -1.0},
            {(1, 1, 0): 2.0},
            {(1, 0, 1): 2.0},
            {(0, 2, 0): 1.0, (0, 0, 2): -1.0},
            {(0, 1, 1): 2.0},
        ),
        strict=True,
    )
)
_AT_OFFSET_SD: Final = 5.0
LARGEST_COMMON_GAIN: Final = 0.1
"""By which supply, meter or gravity may scale all outputs: a row that is no more than that from one g names no axis."""
_LINEAR: Final = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))


def kernel_of(
    sensors: Sequence[CalibratedSensor],
    package: CalibratedPackage | None,
    *,
    upright: bool,
    right_wing_down: bool,
) -> Kernel | None:
    """Return what solves many rows of one, two or three such sensors; None where a bend needs three axes.

    Raises: DesignError where the axes resolve too few directions.
    """
    if len(sensors) < 3 and not all(sensor.is_linear for sensor in sensors):
        return None
    errors = output_errors_of(sensors, package)
    k = np.stack([sensor.k_v_per_g for sensor in sensors])
    offset_v = np.array([sensor.offset_v for sensor in sensors])
    if len(sensors) == 3:
        bend = None if all(sensor.is_linear for sensor in sensors) else _bend_of(sensors)
        three = three_axes(k, offset_v, errors, redundancy_limit, bend=bend)
        sd_v = _level_sd_v(sensors, 1)

        def solve(outputs_v: FloatArray, _: FloatArray) -> AttitudeColumns:
            found = three.attitude(outputs_v)
            name_suspects_in(found.codes, outputs_v, k, offset_v, sd_v)
            return found

        return solve
    if len(sensors) == 2:
        two = TwoAxes(k, offset_v, errors, upright, right_wing_down)
        return lambda outputs_v, _: two.attitude(outputs_v)
    sensor = OneAxis(k[0], float(offset_v[0]), errors)
    return lambda outputs_v, roll_rad: sensor.attitude(outputs_v[0], roll_rad)


def name_suspects_of(sensors: Sequence[Sensor], codes: flag_codes.Codes, outputs_v: FloatArray) -> None:
    """Name the axis in the codes of (3, N) outputs that disagree, where one can be named."""
    if not np.any(codes & flag_codes.REDUNDANCY):
        return
    k, offset_v = np.stack([sensor.k_v_per_g for sensor in sensors]), np.array([sensor.offset_v for sensor in sensors])
    name_suspects_in(codes, outputs_v, k, offset_v, _level_sd_v(sensors, codes.size))


def name_suspects_in(
    codes: flag_codes.Codes, outputs_v: FloatArray, k_v_per_g: FloatArray, offset_v: FloatArray, sd_v: FloatArray
) -> None:
    """Do the same for sensors by their numbers; ``sd_v`` is (3,) of an output."""
    rows = np.flatnonzero(codes & flag_codes.REDUNDANCY)
    if rows.size:
        deviation_v = outputs_v[:, rows] - offset_v[:, None]
        force = np.linalg.inv(k_v_per_g) @ deviation_v
        is_beyond = np.abs(np.sqrt(np.einsum("in,in->n", force, force)) - 1.0) > LARGEST_COMMON_GAIN
        rows, deviation_v = rows[is_beyond], deviation_v[:, is_beyond]
    if rows.size:
        at_limit = at_offset_or_rail(deviation_v, np.zeros(3), _AT_OFFSET_SD * sd_v)
        possible = may_be_wrong(k_v_per_g, deviation_v, sd_v)
        codes[rows] = name_suspects(codes[rows], at_limit, possible)


def _level_sd_v(sensors: Sequence[Sensor], rows: int) -> FloatArray:
    """Return the (A,) standard deviations of what the sensors read at level, over the temperatures of the rows."""
    level = np.tile([0.0, 0.0, -1.0], (rows, 1))
    return np.sqrt([float(np.mean(sensor.output_variance_v2(level))) for sensor in sensors])


def output_errors_of(sensors: Sequence[CalibratedSensor], package: CalibratedPackage | None) -> ParameterErrors:
    """Return the errors of the outputs; without a package's covariance the axes' calibrations are independent."""
    basis = LINE_BASIS if all(set(sensor.names) <= {"offset_v", *PER_G} for sensor in sensors) else _BENT
    turns = [_onto(basis, sensor) for sensor in sensors]
    if package is not None:
        whole = block_diagonal(turns)
        parts = [(whole @ part.covariance @ whole.T, part.dof) for part in package.components]
    else:
        parts = []
        for index, (sensor, turn) in enumerate(zip(sensors, turns, strict=True)):
            alone = [turn if other == index else turns[other][:, :0] for other in range(len(turns))]
            block = block_diagonal(alone)
            for part in sensor.components or (VarianceComponent("", sensor.covariance, np.inf),):
                parts.append((block @ part.covariance @ block.T, part.dof))
    reading_v2 = np.array([float(sensor.reading_sd_v) ** 2 for sensor in sensors])
    return ParameterErrors(
        np.stack([part for part, _ in parts]), np.array([dof for _, dof in parts]), reading_v2, basis
    )


def _bend_of(sensors: Sequence[CalibratedSensor]) -> Bend:
    values = []
    for sensor in sensors:
        terms = np.where([name in _QUADRATIC or name == CUBIC_NAME for name in sensor.names], sensor.primary, 0.0)
        values.append(_onto(_BENT, sensor) @ terms)
    return Bend(tuple(next(iter(polynomial)) for polynomial in _BENT), np.stack(values))


def _onto(basis: Sequence[Polynomial], sensor: CalibratedSensor) -> FloatArray:
    """Return the (len(basis), P) coefficients of what the parameters multiply."""
    row_of = {next(iter(polynomial)): row for row, polynomial in enumerate(basis)}
    turn = np.zeros((len(basis), len(sensor.names)))
    for column, name in enumerate(sensor.names):
        for powers, value in _polynomial(sensor, name).items():
            turn[row_of[powers], column] += value
    return turn


def _polynomial(sensor: CalibratedSensor, name: str) -> Polynomial:
    """Return what a parameter multiplies; a temperature coefficient nothing, at the reference temperature."""
    if name in ("offset_v", *PER_G):
        return {_LINEAR[("offset_v", *PER_G).index(name)]: 1.0}
    if name != CUBIC_NAME and name not in _QUADRATIC:
        return {}
    along = "xyz".index(sensor.nominal_axis)
    cubic = {(3 * (along == 0), 3 * (along == 1), 3 * (along == 2)): 1.0}
    found = dict(cubic if name == CUBIC_NAME else _QUADRATIC[name])
    if sensor.centring:
        row = sensor.centring[[*Q_NAMES, CUBIC_NAME].index(name)]
        found |= {powers: -value for powers, value in zip(_LINEAR, row, strict=True)}
    return found
