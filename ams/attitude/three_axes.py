"""Pitch and roll at rest from three accelerometers, block by block, with spread and redundancy.

Three outputs give a specific force û = K⁻¹(v − b) whose length should be one. The unit f that fits them best by
weighted least squares, TP (99) to (107), is û − λ C_w f with C_w the covariance that the outputs are weighed by: one
condition on three numbers, so every step solves a scalar equation and not a 2 × 2 system. From û itself as the start
the first step is the Gauss-Newton step and the error falls by the factor |û| − 1 with each further one. What length is
left over tests the three outputs against one another: r = |û|² − 1 over its standard deviation.

Arrays are channel-first and go through in blocks that stay in the processor's cache: memory does not grow with rows.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ams.arrays import BoolArray, FloatArray
from ams.attitude import flag_codes
from ams.attitude.flag_codes import Codes
from ams.attitude.force_covariance import (
    ForceErrors,
    ParameterErrors,
    PolynomialErrors,
    Weighing,
    errors_of_force,
    monomials,
    quadratic_form,
)
from ams.attitude.spread import beside_singular
from ams.errors import DesignError

Limit = Callable[[FloatArray, FloatArray], FloatArray]
"""From (C, m) parts of a variance and their (C, 1) or (C, m) degrees of freedom to the (m,) bound of a deviation, in
roots of the whole variance."""

Fitted = tuple[FloatArray, FloatArray, Weighing, Codes]
"""Sensed and fitted force, (3, n) each, what they were weighed by, and a code where there is no fit."""

BLOCK_ROWS: Final = 8192
"""As many as numpy's linear algebra takes for small: 16384 are shared out over threads, which on a busy machine wait
for one another and take five times the time."""
BENT_BLOCK_ROWS: Final = 2048
"""With terms of second and third order: some fifty monomials a row, which a larger block would drive out of the cache
and numpy's library would share out over threads that wait for one another."""
_MANY_MONOMIALS: Final = 12
LARGEST_SD_RAD: Final = float(np.deg2rad(5.0))
"""Above this standard deviation the linear propagation means nothing and the angle is called singular."""
SMALLEST_SLOPE: Final = 1e-6
"""Relative slope of outputs against angle below which an angle is singular whatever the noise."""
CLEARANCE_SD: Final = 3.0
"""A sign is told where what it is read from is so many standard deviations from zero."""
ROOT_CLEARANCE_SD: Final = 8.0
"""An angle closer to the singular attitude than this many of its standard deviations is called singular, where its
distance is a square root of what was read, as with one axis and two: of the square that is four. With three, that is
one and a half, one row in thirteen at the singular attitude itself had a number."""
SURELY_NOT: Final = 3.29
"""No bound at 99.9 % is below that of the normal distribution: a smaller ratio needs no degrees of freedom."""
_STEPS_AT_MOST: Final = 20
_ROUGH_STEPS: Final = 3
"""Of a bend taken off at the sensed force itself, which lies within the noise of the fitted one."""
_ROUNDING: Final = 1e-14
_SMALL_EXCESS: Final = 2e-5
_SETTLED: Final = 1e-9


@dataclass(frozen=True)
class AttitudeColumns:
    """Angles of N rows, NaN where the code says why; roll alone may be missing."""

    pitch_rad: FloatArray
    roll_rad: FloatArray
    codes: Codes
    """Bits of :mod:`ams.attitude.flag_codes`."""
    pitch_sd_rad: FloatArray
    roll_sd_rad: FloatArray
    redundancy_t: FloatArray
    """(N,) excess of |û|² over its standard deviation; NaN where there is no freedom to test."""
    reasons: Mapping[int, str] = field(default_factory=lambda: flag_codes.WORDS)
    """What the codes mean."""

    @classmethod
    def empty(cls, rows: int) -> "AttitudeColumns":
        """Make columns to be written block by block; nothing is redundant until it is written."""
        codes = np.empty(rows, dtype=np.uint32)
        pitch, roll, pitch_sd, roll_sd = np.empty((4, rows))
        return cls(pitch, roll, codes, pitch_sd, roll_sd, np.full(rows, np.nan))


@dataclass(frozen=True)
class Bend:
    """What sensors add to a straight line, as polynomials in the specific force."""

    powers: Sequence[tuple[int, int, int]]
    """(M,) of f_x, f_y, f_z."""
    coefficients_v: FloatArray
    """(3, M)"""


@dataclass(frozen=True)
class ThreeAxes:
    """Three accelerometers v = b + k·f + a bend, that stay the same from row to row."""

    inverse: FloatArray
    """(3, 3) K⁻¹."""
    offset_v: FloatArray
    """(3,)"""
    errors: PolynomialErrors
    limit: Limit
    """Bound of the redundancy's ratio, by Student."""
    gravity_relative_u: float = 0.0
    """Standard uncertainty of local gravity where the set is used, over gravity."""
    bend: Bend | None = None

    def angles(self, outputs_v: FloatArray) -> tuple[FloatArray, FloatArray, Codes]:
        """Return pitch and roll, (N,) rad, of (3, N) outputs without their spread, and what is known to be wrong."""
        rows = outputs_v.shape[1]
        pitch, roll = np.empty(rows), np.empty(rows)
        codes = np.empty(rows, dtype=np.uint32)
        for block in blocks(rows, self._block_rows):
            _, force, _, codes[block] = self._fitted(outputs_v[:, block])
            across = _across(force)
            pitch[block], roll[block] = np.arctan2(force[0], across), np.arctan2(-force[1], -force[2])
            vertical = across < SMALLEST_SLOPE
            if vertical.any():
                codes[block][vertical] |= flag_codes.ROLL_SINGULAR
                roll[block][vertical] = np.nan
        return pitch, roll, codes

    def attitude(self, outputs_v: FloatArray) -> AttitudeColumns:
        """Return the angles of (3, N) outputs with standard deviations, flags and the test of redundancy."""
        rows = outputs_v.shape[1]
        found = AttitudeColumns.empty(rows)
        for block in blocks(rows, self._block_rows):
            judged_into(
                found, block, self._fitted(outputs_v[:, block]), self.errors, self.limit, self.gravity_relative_u
            )
        return found

    @property
    def _block_rows(self) -> int:
        return BLOCK_ROWS if len(self.errors.powers) < _MANY_MONOMIALS else BENT_BLOCK_ROWS

    def _fitted(self, outputs_v: FloatArray) -> Fitted:
        straight = self.inverse @ (outputs_v - self.offset_v[:, None])
        if self.bend is None:
            return straight, *fitted(straight, self.errors)
        bend_g = self.inverse @ self.bend.coefficients_v
        sensed = straight
        for _ in range(_ROUGH_STEPS):
            sensed = straight - bend_g @ monomials(_unit(sensed), self.bend.powers)
        force, weighing, codes = fitted(sensed, self.errors)
        for _ in range(_STEPS_AT_MOST):
            before, sensed = sensed, straight - bend_g @ monomials(force, self.bend.powers)
            force, weighing, codes = fitted(sensed, self.errors)
            if not np.nanmax(np.abs(sensed - before), initial=0.0) > 1e-12:
                break
        return sensed, force, weighing, codes


def _unit(force: FloatArray) -> FloatArray:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(force / np.sqrt(np.einsum("in,in->n", force, force)))


def three_axes(
    k_v_per_g: FloatArray,
    offset_v: FloatArray,
    errors: ParameterErrors,
    limit: Limit,
    *,
    gravity_relative_u: float = 0.0,
    bend: Bend | None = None,
) -> ThreeAxes:
    """Return the inference for (3, 3) sensitivities and (3,) offsets.

    Raises: DesignError where the axes lie in one plane.
    """
    k = np.asarray(k_v_per_g, dtype=float)
    check_three_directions(k)
    offsets = np.asarray(offset_v, dtype=float)
    return ThreeAxes(np.linalg.inv(k), offsets, errors_of_force(k, errors), limit, gravity_relative_u, bend)


def check_three_directions(k_v_per_g: FloatArray) -> None:
    """Raise DesignError where (…, 3, 3) sensitivities lie in one plane."""
    if np.any(np.abs(np.linalg.det(k_v_per_g)) < SMALLEST_SLOPE * np.prod(np.linalg.norm(k_v_per_g, axis=-1), axis=-1)):
        raise DesignError("three-axis package: the three sensitive axes lie in one plane: use two of them")


def blocks(rows: int, block_rows: int = BLOCK_ROWS) -> list[slice]:
    """Return the rows in pieces that stay in the processor's cache."""
    return [slice(start, min(start + block_rows, rows)) for start in range(0, rows, block_rows)]


def fitted(sensed: FloatArray, errors: ForceErrors) -> tuple[FloatArray, Weighing, Codes]:
    """Return the (3, n) unit force that fits (3, n) sensed ones best, its weighing, a code where there is none."""
    square = np.einsum("in,in->n", sensed, sensed)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        weighing = errors.weighing(sensed, square)
        force, unsettled = onto_unit_sphere(sensed, square, weighing)
    codes = np.zeros(sensed.shape[1], dtype=np.uint32)
    if unsettled.size:
        codes[unsettled] = flag_codes.UNSETTLED
        missing = ~np.isfinite(square)
        codes[missing] = flag_codes.NOT_FINITE
        force[:, missing] = np.nan
    return force, weighing, codes


def onto_unit_sphere(sensed: FloatArray, square: FloatArray, weighing: Weighing) -> tuple[FloatArray, NDArray[np.intp]]:
    """Return the (3, n) unit vectors that fit best and the places of those that did not settle; ``square`` is |û|²."""
    first = weighing.times(sensed)
    excess = 0.5 * square - 0.5
    first *= excess / np.einsum("in,in->n", sensed, first)
    before = np.subtract(sensed, first, out=first)
    force = _step(sensed, weighing, before)
    # Two steps leave about the third power of the excess: nothing, for readings that belong to the set.
    if np.max(np.abs(excess), initial=0.0) < _SMALL_EXCESS:
        return force, np.empty(0, dtype=np.intp)
    left = np.flatnonzero(~_is_close(sensed, before, force))
    if not left.size:
        return force, left
    before = force[:, left]
    force[:, left] = again = _step(sensed[:, left], weighing.of(left), before)
    left = left[~_is_close(sensed[:, left], before, again)]
    if not left.size:
        return force, left
    force[:, left], is_settled = _patiently(sensed[:, left], weighing.of(left))
    return force, left[~is_settled]


def _is_close(sensed: FloatArray, before: FloatArray, force: FloatArray) -> BoolArray:
    """Return whether another step would be lost in rounding.

    It is smaller than this one by about |û − f|, ten times that where axes are far from square or far from equally
    sharp.
    """
    moved, away = force - before, sensed - force
    return np.asarray(np.einsum("in,in->n", moved, moved) * np.einsum("in,in->n", away, away) < _ROUNDING**2)


def _patiently(sensed: FloatArray, weighing: Weighing) -> tuple[FloatArray, BoolArray]:
    """Solve where outputs are far from any attitude: the length is brought back to one at every step."""
    unit = sensed / np.sqrt(np.einsum("in,in->n", sensed, sensed))
    change = np.full(unit.shape[1], np.inf)
    for _ in range(_STEPS_AT_MOST):
        before, unit = unit, _step(sensed, weighing, unit)
        unit = unit / np.sqrt(np.einsum("in,in->n", unit, unit))
        change = np.max(np.abs(unit - before), axis=0)
        if np.all(change < 1e-13):
            break
    return unit, np.asarray(change < _SETTLED)


def _step(sensed: FloatArray, weighing: Weighing, force: FloatArray) -> FloatArray:
    """Take one step of f = û − λ C_w f with |f| = 1 held to first order about the last f."""
    direction = weighing.times(force)
    factor = np.einsum("in,in->n", force, sensed)
    factor -= 0.5
    factor -= 0.5 * np.einsum("in,in->n", force, force)
    factor /= np.einsum("in,in->n", force, direction)
    direction *= factor
    return np.subtract(sensed, direction, out=direction)


def judged_into(
    found: AttitudeColumns,
    block: slice,
    fit: Fitted,
    errors: ForceErrors,
    limit: Limit,
    gravity_relative_u: float,
) -> None:
    """Write angles, spread, redundancy and codes of a block of fitted forces into its rows."""
    sensed, force, weighing, codes = fit
    with np.errstate(divide="ignore", invalid="ignore"):
        meridian, parallel, across = turns(force)
        along_pitch, along_roll = gains(force, meridian, parallel, weighing.times(force))
        covariance = errors.total(force)
        pitch_sd = np.sqrt(quadratic_form(covariance, along_pitch))
        along_sd = np.sqrt(quadratic_form(covariance, along_roll))
        roll_sd = along_sd / across
        excess = np.einsum("in,in->n", sensed, sensed) - 1.0
        variance = 4.0 * quadratic_form(covariance, sensed) + 4.0 * gravity_relative_u**2
        ratio = excess / np.sqrt(variance)
        disagree = suspicious(ratio, sensed, force, errors, limit, gravity_relative_u)
    pitch_lost = ~(pitch_sd <= LARGEST_SD_RAD)
    roll_lost = ~(roll_sd <= LARGEST_SD_RAD) | (across < SMALLEST_SLOPE)
    if roll_lost.any():
        pitch_sd = beside_singular(pitch_sd, along_sd, roll_lost)
    if disagree.size:
        codes[disagree] |= flag_codes.REDUNDANCY
    _write_flags(codes, pitch_lost, roll_lost)
    found.redundancy_t[block], found.codes[block] = ratio, codes
    pitch, roll = np.arctan2(force[0], across), np.arctan2(-force[1], -force[2])
    hopeless = (codes & flag_codes.LOST) != 0
    for lost, angle, sd in ((pitch_lost, pitch, pitch_sd), (roll_lost, roll, roll_sd)):
        gone = lost | hopeless
        if gone.any():
            angle[gone], sd[gone] = np.nan, np.nan
    found.pitch_rad[block], found.pitch_sd_rad[block] = pitch, pitch_sd
    found.roll_rad[block], found.roll_sd_rad[block] = roll, roll_sd


def _write_flags(codes: Codes, pitch_lost: BoolArray, roll_lost: BoolArray) -> None:
    """Flag lost angles as singular, only where there is a solution to read them off."""
    for lost, code in ((pitch_lost, flag_codes.PITCH_SINGULAR), (roll_lost, flag_codes.ROLL_SINGULAR)):
        if lost.any():
            codes[lost & ((codes & flag_codes.LOST) == 0)] |= np.uint32(code)


def turns(force: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return ∂f/∂α, ∂f/(cos α ∂R), (3, n), and cos α, (n,): both directions stay regular at α = ±90°."""
    across = _across(force)
    meridian, parallel = np.empty_like(force), np.empty_like(force)
    inverse = 1.0 / across
    y, z = force[1] * inverse, force[2] * inverse
    vertical = across == 0.0
    if vertical.any():
        y[vertical], z[vertical] = 0.0, -1.0
    meridian[0] = across
    np.multiply(-force[0], y, out=meridian[1])
    np.multiply(-force[0], z, out=meridian[2])
    parallel[0], parallel[1] = 0.0, z
    np.negative(y, out=parallel[2])
    return meridian, parallel, across


def gains(
    force: FloatArray, meridian: FloatArray, parallel: FloatArray, direction: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return what the two turns take from an error of û, (3, n) each: its projection along C_w f onto the tangent."""
    over = 1.0 / np.einsum("in,in->n", force, direction)
    by_pitch = np.einsum("in,in->n", meridian, direction) * over
    by_roll = np.einsum("in,in->n", parallel, direction) * over
    return meridian - by_pitch * force, parallel - by_roll * force


def suspicious(
    ratio: FloatArray,
    sensed: FloatArray,
    force: FloatArray,
    errors: ForceErrors,
    limit: Limit,
    gravity_relative_u: float,
) -> NDArray[np.intp]:
    """Return the places whose |û| is further from one than the errors allow. Source: Welch-Satterthwaite, Student."""
    rows = np.flatnonzero(np.abs(ratio) > SURELY_NOT)
    if not rows.size:
        return rows
    parts = 4.0 * quadratic_form(errors.parts(force, rows), sensed[:, rows])
    known = np.full((1, rows.size), 4.0 * gravity_relative_u**2)
    dof = errors.dof(rows)
    bound = limit(np.concatenate([parts, known]), np.concatenate([dof, np.full((1, dof.shape[1]), np.inf)]))
    return rows[np.abs(ratio[rows]) > bound]


def _across(force: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(force[1] * force[1] + force[2] * force[2]))
