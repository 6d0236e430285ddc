"""Whether the package turns on its mount, or the table, with the angle of roll: all its outputs by one rotation.

Cables that pull, and a mount that gives to them, turn a package by t R/360° at roll R, t a fixed rotation vector of the
package: every output s reads R/360° t·(∂f/∂turn k_s) more. At ±180° that jumps, as no force does, so that the points
tell it from what a sensor does by its force and from index errors of the axes; yet K₂, K_pp − K_oo, K_io and the
squareness of the table each take a part of it, and are blamed for it where it is not asked for.

One t of all outputs is estimated from the means of the points. Beside it stands what each output may show by itself,
any polynomial of the force up to fourth order, the other terms of low order and what the order of the points leaves;
and what all of them show of the table, its squareness, its tilt and any curve of index errors of each axis. What t
explains beside all that is held against Fisher's F. About x it is a curve of index errors of roll as well, and alone
tells nothing here.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.over_time.order_columns import left_by_order
from ams.analysis.diagnostics.point_means import spanned
from ams.analysis.diagnostics.sensed_force import turned_by
from ams.analysis.diagnostics.step_patterns import force
from ams.analysis.diagnostics.tested_terms import terms_of_accelerometer
from ams.arrays import FloatArray
from ams.calibration.together.errors_of_table import (
    NOTHING,
    SQUARENESS_AND_TILT,
    Sensed,
    SharedColumns,
    Spanned,
    beside,
    errors_of_table,
    sensed,
    sensed_nominally,
)
from ams.calibration.together.roll_turn_found import RollTurn, turned_with_roll
from ams.calibration.together.shown_outputs import (
    LEAST_DOF,
    MAY_SHOW,
    OutputSeen,
    ShownOutput,
    attitude_where_read,
    rolled_base,
    shown_output,
)
from ams.calibration.together.table_limit import of_higher_order
from ams.remembered import remembered
from ams.statistics.distributions import f_tail

_FEWEST: Final = 2
"""Outputs."""
_OTHERS_SHOW: Final = 0.05
"""Chance of as much without the output that shows it most."""
_PASSES: Final = 3
"""That find what each output scatters by."""
_TURN: Final = 3
"""The first of the columns that all outputs share; squareness and tilt of the table follow, and its index errors."""


def judge_roll_turn(outputs: Sequence[OutputSeen], level: float) -> RollTurn | None:
    """Return the rotation that goes with roll, where the outputs show it together at a ``level``; None: they do not."""
    if len(outputs) < _FEWEST:
        return None
    each = (_shown(evidence, index) for evidence, index in outputs)
    shown = [output for output in each if output is not None]
    if not _have_room(shown) or not _may_show(shown, MAY_SHOW * level):
        return None
    columns = sensed([(output.design, output.k / output.per_g) for output in shown])
    square, along, dof = _beside(shown, columns)
    explained, seen = _explained(square.sum(axis=0), along.sum(axis=0))
    p_value = float(f_tail(explained / max(seen, 1), float(max(seen, 1)), dof))
    if not (seen and p_value <= level):
        return None
    square, along, dof = _beside(shown, columns.without_indices(_TURN + SQUARENESS_AND_TILT))
    covariance = np.linalg.pinv(square.sum(axis=0), rcond=NOTHING, hermitian=True)
    turn_rad = covariance @ along.sum(axis=0)
    return RollTurn(turn_rad, covariance, dof, p_value, len(outputs), _lone_axis(shown, columns, turn_rad))


def _have_room(shown: Sequence[ShownOutput[SharedColumns]]) -> bool:
    """Return whether two outputs or more of the same points leave degrees of freedom beside all that they share."""
    if len(shown) < _FEWEST or len({output.left.size for output in shown}) > 1:
        return False
    return bool(sum(output.dof for output in shown) >= shown[0].design.width + LEAST_DOF)


def _lone_axis(shown: Sequence[ShownOutput[SharedColumns]], columns: Sensed, turn_rad: FloatArray) -> str:
    """Return the nominal axis of the output without which the others do not show a turn; empty: they do.

    Each beside its own terms: what the others say against errors of the table is nothing that they show.
    """
    square, along, dof = _beside(shown, columns.without_indices(_TURN))
    squares, products = (square @ turn_rad) @ turn_rad, along @ turn_rad
    most = int(np.argmax(squares))
    whole, product = (float(np.delete(each, most).sum()) for each in (squares, products))
    is_shown = whole > 0.0 and product > 0.0 and float(f_tail(product**2 / whole, 1.0, dof)) <= _OTHERS_SHOW
    return "" if is_shown else shown[most].axis


def _shown(evidence: Evidence, output: int) -> ShownOutput[SharedColumns] | None:
    """Return what one output shows; None of one that tells nothing of it."""
    base = rolled_base(evidence, output)
    if base is None:
        return None
    terms, in_order = terms_of_accelerometer(evidence, base), left_by_order(evidence, base, evidence.layout.points)
    design = _design(*turned_by(base, attitude_where_read(evidence, base)), evidence.basis, terms, in_order)
    return shown_output(evidence, output, base, design, design.q)


@remembered(16)
def _design(
    pitch_rad: FloatArray,
    roll_rad: FloatArray,
    yaw_rad: FloatArray | None,
    basis: FloatArray,
    terms: FloatArray,
    in_order: FloatArray,
) -> SharedColumns:
    turned = turned_with_roll(pitch_rad, roll_rad, yaw_rad).reshape(-1, 3, 3).transpose(0, 2, 1)
    q = spanned(np.hstack([basis, terms, in_order, of_higher_order(force(pitch_rad, roll_rad, yaw_rad))]))
    return beside(q, turned, errors_of_table(pitch_rad, roll_rad, yaw_rad))


def _may_show(shown: Sequence[ShownOutput[SharedColumns]], level: float) -> bool:
    """Return whether the outputs may show it at a level: each by its nominal axis, all of one weight."""
    axes = tuple(output.axis for output in shown)
    kept, square = _nominal(axes, tuple(output.design for output in shown))
    variance, dof = np.array([output.variance for output in shown]), sum(output.dof for output in shown)
    along = sum(part.T @ output.left for part, output in zip(kept, shown, strict=True))
    explained, seen = _explained(np.tensordot(variance, square, 1), np.asarray(along))
    return bool(seen) and float(f_tail(explained / seen, float(seen), dof)) <= level


@remembered(16)
def _nominal(axes: tuple[str, ...], designs: tuple[SharedColumns, ...]) -> tuple[FloatArray, FloatArray]:
    """Return (s, K, 3) what the table leaves of the turn along nominal axes, and (s, 3, 3) its products."""
    kept = _left_of_turn(sensed_nominally(axes, designs))[0]
    return kept, kept.transpose(0, 2, 1) @ kept


def _left_of_turn(columns: Sensed) -> tuple[FloatArray, Spanned]:
    """Return what the other columns leave of those of the turn, (s, K, 3), and what they span."""
    spans = columns.spanned(_TURN)
    turn = columns.of_many[:, :, :_TURN].reshape(-1, _TURN)
    left = spans.left_of(turn)
    left[:, np.vecdot(left.T, left.T) <= NOTHING * np.vecdot(turn.T, turn.T)] = 0.0
    return left.reshape(*columns.of_many.shape[:2], _TURN), spans


def _beside(shown: Sequence[ShownOutput[SharedColumns]], columns: Sensed) -> tuple[FloatArray, FloatArray, float]:
    """Return (s, 3, 3) squares and (s, 3) products of the turn over the variances, beside the others that all share.

    With the degrees of freedom of the variances: what an output scatters by is known once the turn is taken from it.
    """
    variance = np.array([output.variance for output in shown])
    for _ in range(_PASSES):
        scale = variance**-0.5
        left, spans = _left_of_turn(columns.weighed(scale))
        reading = np.concatenate([output.left * each for output, each in zip(shown, scale, strict=True)])
        by_output = spans.left_of(reading).reshape(left.shape[:2])
        square, along = left.transpose(0, 2, 1) @ left, np.einsum("ska,sk->sa", left, by_output)
        whole = square.sum(axis=0)
        turn = np.linalg.pinv(whole, rcond=NOTHING, hermitian=True) @ along.sum(axis=0)
        rest = by_output - left @ turn
        taken = spans.rank + int(np.linalg.matrix_rank(whole, NOTHING * np.abs(whole).max(), hermitian=True))
        dof = sum(output.dof for output in shown) - taken
        variance = variance * np.vecdot(rest, rest) * (len(shown) / dof)
    inflation = float(np.vecdot(rest, rest).sum()) / dof
    return square / inflation, along / inflation, dof


def _explained(square: FloatArray, along: FloatArray) -> tuple[float, int]:
    """Return what a rotation explains, and how many of its components are seen."""
    values, vectors = np.linalg.eigh(square)
    is_seen = values > NOTHING * max(float(values[-1]), 0.0)
    return float(((vectors.T @ along)[is_seen] ** 2 / values[is_seen]).sum()), int(is_seen.sum())
