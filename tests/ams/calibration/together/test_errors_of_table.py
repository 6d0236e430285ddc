"""What errors of the table span is what their columns span, one for each index, however few points share one."""

from collections.abc import Mapping

import numpy as np
import pytest

from ams.arrays import FloatArray
from ams.calibration.together.errors_of_table import beside, errors_of_table, sensed
from ams.frames import specific_force, specific_force_by_pitch, specific_force_by_roll

_RNG = np.random.default_rng(11)
_PITCH = np.linspace(-1.25, 1.25, 9)
_ROLL = np.linspace(-2.8, 2.8, 11)


def _any(count: int, most: float) -> FloatArray:
    return _RNG.permutation(np.linspace(-most, most, count))


_GRID = np.repeat(_PITCH, 11), np.tile(_ROLL, 9)
_DESIGNS: Mapping[str, tuple[FloatArray, FloatArray]] = {
    "a grid": _GRID,
    "angles of their own": (_any(110, 1.2), _any(110, 3.0)),
    "a pitch of its own at each of some rolls": (_any(110, 1.2), np.tile(_ROLL, 10)),
    "a roll of its own at each of some pitches": (np.repeat(_PITCH, 12), _any(108, 3.0)),
    "two at a pitch": (np.repeat(_any(55, 1.2), 2), _any(110, 3.0)),
    "five at a pitch, eleven at a roll": (np.repeat(_any(22, 1.2), 5), np.tile(_ROLL, 10)),
    "chains of two at a pitch and two at a roll": (
        np.repeat(_any(56, 1.2), 2),
        np.repeat(_any(56, 3.0), 2)[[(each + 1) % 112 if each % 8 != 7 else each for each in range(112)]],
    ),
    "a grid and others": (np.append(_GRID[0], _any(40, 1.2)), np.append(_GRID[1], _any(40, 3.0))),
}  # fmt: skip


@pytest.mark.parametrize("design", _DESIGNS)
def test_what_is_left_of_readings_is_what_all_columns_leave(design: str) -> None:
    pitch, roll = _DESIGNS[design]
    force, points = specific_force(pitch, roll), pitch.size
    directions = np.array([[0.99, 0.02, -0.01], [-0.03, 1.0, 0.01], [0.01, -0.04, 0.98]])
    scale = np.array([1.0, 0.3, 2.0])
    every = _every_column(pitch, roll)
    of_output = [_orthonormal(force, order) for order in (1, 2, 2)]
    columns = sensed(
        [
            (beside(q, np.zeros((points, 3, 0)), errors_of_table(pitch, roll, None)), direction)
            for q, direction in zip(of_output, directions, strict=True)
        ]
    )
    spanned = columns.weighed(scale).spanned(0)
    whole = np.vstack(
        [each * _beside(q, every @ direction) for q, direction, each in zip(of_output, directions, scale, strict=True)]
    )
    left, sizes, _ = np.linalg.svd(whole, full_matrices=False)
    kept = left[:, sizes > 1e-3 * sizes[0]]
    reading = np.concatenate([_beside(q, _RNG.standard_normal((points, 4))) for q in of_output])
    assert spanned.rank == kept.shape[1]
    np.testing.assert_allclose(spanned.left_of(reading), reading - kept @ (kept.T @ reading), atol=1e-9)
    np.testing.assert_allclose(spanned.left_of(reading[:, 0]), spanned.left_of(reading)[:, 0], atol=1e-12)


def _every_column(pitch: FloatArray, roll: FloatArray) -> FloatArray:
    """(K, c, 3) by a radian of tilt, squareness, and an error at each angle that comes back."""
    across = np.stack([np.zeros_like(roll), np.cos(roll), -np.sin(roll)], axis=1)
    found = [across, np.sin(pitch)[:, None] * across]
    for angle, slope in ((pitch, specific_force_by_pitch(pitch, roll)), (roll, specific_force_by_roll(pitch, roll))):
        found += [slope * (np.abs(angle - index) < 1e-7)[:, None] for index in np.unique(np.round(angle, 9))]
    return np.stack(found, axis=1)


def _orthonormal(force: FloatArray, order: int) -> FloatArray:
    """(K, P) of a polynomial of the force."""
    x, y, z = force.T
    terms = [
        x**a * y**b * z**c for a in range(order + 1) for b in range(order + 1 - a) for c in range(order + 1 - a - b)
    ]
    left, sizes, _ = np.linalg.svd(np.stack(terms, axis=1), full_matrices=False)
    return np.asarray(left[:, sizes > 1e-9 * sizes[0]])


def _beside(q: FloatArray, columns: FloatArray) -> FloatArray:
    return np.asarray(columns - q @ (q.T @ columns))
