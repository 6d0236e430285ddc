"""Which reading of a package is wrong, once its outputs are known to disagree.

One row of one package of three axes tells that an axis is wrong and never which: with any one left out nothing is left
to test. An axis can be named by a reading that stands at its offset or at a rail, by the others alone having no
attitude that could give their outputs, or by many rows of different attitude (:mod:`ams.inference.watch.faulty_axis`).
Packages of more readings are tested by what is left of
their residuals: degrees of freedom are the valid readings less the rank of the attitude's Jacobian; a reading is
suspect where the rest agree without it. Arrays are channel-first.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ams.arrays import BoolArray, FloatArray, IntArray
from ams.attitude.flag_codes import REDUNDANCY, SUSPECTS, Codes
from ams.statistics.distributions import f_tail

LEVEL: Final = 0.999
_SMALLEST_SINGULAR: Final = 1e-6
_OTHERS: Final = ((1, 2), (0, 2), (0, 1))


def at_offset_or_rail(
    outputs_v: FloatArray, offset_v: FloatArray, tolerance_v: FloatArray, rails_v: FloatArray | None = None
) -> BoolArray:
    """Return which of (S, N) outputs read their offset (a line unplugged) or a rail, (S, 2) lowest and highest volts.

    A good axis that lies level reads its offset too: this names an axis only where outputs disagree.
    """
    found = np.abs(outputs_v - offset_v[:, None]) <= tolerance_v[:, None]
    if rails_v is not None:
        low, high = rails_v.T
        found |= (outputs_v <= (low + tolerance_v)[:, None]) | (outputs_v >= (high - tolerance_v)[:, None])
    return np.asarray(found)


def may_be_wrong(
    k_v_per_g: FloatArray, deviation_v: FloatArray, sd_v: FloatArray, clearance_sd: float = 4.0
) -> BoolArray:
    """Return which of three axes may be the wrong one in (3, N) outputs less offsets: the others have an attitude."""
    found = np.empty(deviation_v.shape, dtype=bool)
    for axis, others in enumerate(_OTHERS):
        inverse = np.linalg.pinv(k_v_per_g[list(others)])
        nearest = inverse @ deviation_v[list(others)]
        slopes = 2.0 * inverse.T @ nearest
        slopes *= slopes
        spread = np.sqrt(sd_v[list(others)] ** 2 @ slopes)
        found[axis] = np.einsum("in,in->n", nearest, nearest) <= 1.0 + clearance_sd * spread
    return found


def name_suspects(codes: Codes, at_limit: BoolArray, possible: BoolArray) -> Codes:
    """Return the codes with the axis named in rows that disagree, where there is exactly one that it can be."""
    named = codes.copy()
    disagree = (codes & REDUNDANCY) != 0
    for evidence in (at_limit & possible, possible):
        alone = disagree & (evidence.sum(axis=0) == 1)
        for axis, bit in enumerate(SUSPECTS):
            named[alone & evidence[axis]] |= np.uint32(bit)
        disagree &= ~alone
    return named


@dataclass(frozen=True)
class Disagreement:
    """What is left of the readings of n rows when their attitude has been fitted."""

    chi_square: FloatArray
    dof: IntArray
    """Valid readings less the rank of the attitude's Jacobian."""

    def is_above(self, calibration_dof: float | FloatArray, level: float = LEVEL) -> BoolArray:
        """Return whether χ² is more than the covariance allows, which was known with some degrees of freedom itself."""
        counted_dof = np.maximum(self.dof, 1)
        other = np.minimum(np.asarray(calibration_dof, dtype=float), 1e7)
        chance = f_tail(self.chi_square / counted_dof, counted_dof, other)
        return np.asarray((self.dof > 0) & (chance < 1.0 - level))


def disagreement(
    residuals: FloatArray, columns: FloatArray, covariance: FloatArray, is_valid: BoolArray
) -> Disagreement:
    """Test (n, R) residuals of a fit with (n, R, P) derivatives by the attitude and (n, R, R) covariance.

    It counts what the attitude cannot explain, so any fit near the right one will do. Readings that are not valid are
    left out.
    """
    chi_square, dof = np.zeros(len(residuals)), np.zeros(len(residuals), dtype=np.int64)
    for rows, readings in _patterns(is_valid):
        if not readings.size:
            continue
        lower = np.linalg.cholesky(covariance[np.ix_(rows, readings, readings)])
        left = np.linalg.solve(lower, residuals[np.ix_(rows, readings)][..., None])[..., 0]
        basis, singular, _ = np.linalg.svd(np.linalg.solve(lower, columns[rows][:, readings]), full_matrices=False)
        is_seen = singular > _SMALLEST_SINGULAR * singular[:, :1]
        explained = np.einsum("nrp,nr->np", basis, left) * is_seen
        chi_square[rows] = np.sum(left**2, axis=1) - np.sum(explained**2, axis=1)
        dof[rows] = readings.size - is_seen.sum(axis=1)
    return Disagreement(np.maximum(chi_square, 0.0), dof)


def explaining(
    residuals: FloatArray,
    columns: FloatArray,
    covariance: FloatArray,
    is_valid: BoolArray,
    calibration_dof: float | FloatArray = np.inf,
    level: float = LEVEL,
) -> BoolArray:
    """Return which of (n, R) readings the rest agree without, in rows that disagree; several where none can be told."""
    found = np.zeros(residuals.shape, dtype=bool)
    whole = disagreement(residuals, columns, covariance, is_valid)
    rows = np.flatnonzero(whole.is_above(calibration_dof, level))
    of_calibration = np.broadcast_to(np.asarray(calibration_dof, dtype=float), len(residuals))
    for reading in range(residuals.shape[1]):
        without = is_valid[rows].copy()
        without[:, reading] = False
        rest = disagreement(residuals[rows], columns[rows], covariance[rows], without)
        is_freed = (rest.dof > 0) & ~rest.is_above(of_calibration[rows], level) & is_valid[rows, reading]
        found[rows, reading] = is_freed
    return found


def _patterns(is_valid: BoolArray) -> Iterator[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Yield rows that have the same valid readings, with these."""
    patterns, index = np.unique(is_valid, axis=0, return_inverse=True)
    for number, pattern in enumerate(patterns):
        yield np.flatnonzero(index.ravel() == number), np.flatnonzero(pattern)
