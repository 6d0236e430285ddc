"""The angles that a set tells of clean outputs, by ways that the product does not take.

One axis by bisection over pitch, two by the null space of the axes and a quadratic equation, three by Lagrange's
multiplier of |f| = 1. Terms of higher order are taken off until nothing changes.
"""

from collections.abc import Mapping

import numpy as np

from ams.frames import specific_force
from ams.sets.apply import apply
from ams.sets.coefficients import CoefficientSet

AS_NEAR = 0.5
"""Where the nearer of two attitudes is more than so much of the way to the other, nobody tells which is meant."""


def inferred_errors_deg(
    applied: CoefficientSet, outputs: Mapping[str, np.ndarray], pitch: np.ndarray, roll: np.ndarray, slack: float = 0.0
) -> dict[str, np.ndarray]:
    """Return angle to (K, 2) degrees told less true by each attitude that may be meant; NaN where none is fitted.

    ``slack``: by how much |f|² of two outputs may exceed 1 and still be read as 1.
    """
    k = np.stack([numbers.direction_v_per_g for numbers in applied.axes.values()])
    known = specific_force(pitch, roll)
    offset = [float(numbers.offset_v(None)) for numbers in applied.axes.values()]
    u = np.stack([outputs[axis] for axis in applied.axes], axis=-1) - offset
    inferred = np.stack([known, known], axis=1)
    for _ in range(4):
        for root in range(2):
            at = np.where(np.isnan(inferred[:, root]), known, inferred[:, root])
            angles = np.arcsin(np.clip(at[:, 0], -1.0, 1.0)), np.arctan2(-at[:, 1], -at[:, 2])
            whole = apply(applied, *angles, None, beyond_validity=True)
            bend = np.stack([whole[axis] for axis in applied.axes], axis=-1) - offset - specific_force(*angles) @ k.T
            inferred[:, root] = _roots(k, u - bend, pitch, roll, slack)[:, root]
    far = np.linalg.norm(inferred - known[:, None], axis=-1)
    order = np.argsort(np.where(np.isnan(far), np.inf, far), axis=1)
    inferred, far = np.take_along_axis(inferred, order[:, :, None], axis=1), np.take_along_axis(far, order, axis=1)
    inferred[:, 1] = np.where((far[:, 0] > AS_NEAR * far[:, 1])[:, None], inferred[:, 1], inferred[:, 0])
    tilt = np.arctan2(inferred[..., 0], np.hypot(inferred[..., 1], inferred[..., 2])) - np.arcsin(known[:, 0])[:, None]
    turn = np.arctan2(-inferred[..., 1], -inferred[..., 2]) - roll[:, None]
    errors = {"pitch": np.rad2deg(tilt), "roll": np.rad2deg((turn + np.pi) % (2.0 * np.pi) - np.pi)}
    return {"pitch": errors["pitch"]} if len(k) == 1 else errors


def _roots(k: np.ndarray, u: np.ndarray, pitch: np.ndarray, roll: np.ndarray, slack: float) -> np.ndarray:
    """Return (K, 2, 3) the attitudes that linear outputs fit, twice the same where there is one."""
    if len(k) == 1:
        return np.stack([_by_bisection(k[0], u[:, 0], pitch, roll)] * 2, axis=1)
    if len(k) == 3:
        return np.stack([_by_multiplier(k / np.linalg.norm(k, axis=1)[:, None], u / np.linalg.norm(k, axis=1))] * 2, 1)
    along = np.linalg.svd(k)[2][2]
    nearest = np.linalg.lstsq(k, u.T, rcond=None)[0].T
    slope, rest = nearest @ along, np.sum(nearest**2, axis=1) - 1.0
    square = slope**2 - rest
    half = np.sqrt(np.where(square < -slack, np.nan, np.maximum(square, 0.0)))
    return np.stack([nearest + (-slope + sign * half)[:, None] * along for sign in (1.0, -1.0)], axis=1)


def _by_multiplier(k: np.ndarray, u: np.ndarray) -> np.ndarray:
    multiplier = np.zeros(len(u))
    for _ in range(30):
        inverse = np.linalg.inv(k.T @ k + multiplier[:, None, None] * np.eye(3))
        f = np.einsum("nij,nj->ni", inverse, u @ k)
        slope = -2.0 * np.einsum("ni,nij,nj->n", f, inverse, f)
        multiplier = multiplier - (np.sum(f**2, axis=1) - 1.0) / slope
    return f


def _by_bisection(k: np.ndarray, u: np.ndarray, pitch: np.ndarray, roll: np.ndarray) -> np.ndarray:
    """Return the crossing nearest to the known pitch, within 40 degrees of it."""
    offsets = np.deg2rad(np.linspace(-40.0, 40.0, 401))
    grid = pitch[:, None] + offsets
    value = np.einsum("nmi,i->nm", specific_force(grid, np.broadcast_to(roll[:, None], grid.shape)), k) - u[:, None]
    crosses = np.signbit(value[:, :-1]) != np.signbit(value[:, 1:])
    far = np.where(crosses, np.abs(offsets[:-1] + offsets[1:])[None], np.inf)
    column, rows = np.argmin(far, axis=1), np.arange(len(u))
    low, high = grid[rows, column], grid[rows, column + 1]
    for _ in range(50):
        middle = 0.5 * (low + high)
        is_same = np.signbit(specific_force(middle, roll) @ k - u) == np.signbit(value[rows, column])
        low, high = np.where(is_same, middle, low), np.where(is_same, high, middle)
    return np.where(crosses.any(axis=1)[:, None], specific_force(low, roll), np.nan)
