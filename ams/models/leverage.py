"""Whether points tell the terms of a model, or what they happen to stand beside their nominal places does.

A term that is nothing at every nominal point, such as f_y f_z at four rolls a quarter of a turn apart, is a little at
those where a table of a real encoder stands, 0.001° beside them. Solved from that it is noise times a thousand, and
between the points, where it is large, so is what it makes of an output.
"""

from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.frames import specific_force

LEAST_LEVER: Final = 0.1
"""Of the root mean square over the range: what terms must have at the points. Designs that were laid out for the terms
have 0.8 to 1, three pitches by three rolls 0.17, four rolls that scatter by 1° 0.04."""
_PITCHES, _ROLLS = 13, 24
_ON_END: Final = 0.1
"""g across the roll axis: with less, roll says little of where a package stands."""
_ALIKE: Final = 1.01
"""Of the largest gap between rolls to the second: where none is larger than the others, they go round."""


def least_lever(at_points: FloatArray, within: FloatArray) -> float:
    """Return the least ratio over all combinations of t columns: root mean square at (N, t) points to (M, t) within.

    A combination that is nothing anywhere within has none: the ratio is then zero.
    """
    of_points, of_range = (columns.T @ columns / len(columns) for columns in (at_points, within))
    values, vectors = np.linalg.eigh(of_range)
    if not values[0] > np.finfo(float).eps * values[-1]:
        return 0.0
    whitened = vectors / np.sqrt(values)
    return float(np.sqrt(max(np.linalg.eigvalsh(whitened.T @ of_points @ whitened)[0], 0.0)))


def attitudes_between(force: FloatArray) -> FloatArray:
    """Return the (M, 3) specific force in g at attitudes all over the pitches and rolls of (N, 3) forces."""
    across = np.hypot(force[:, 1], force[:, 2])
    pitch_rad = np.arctan2(force[:, 0], across)
    off_end = force[across > _ON_END]
    start_rad, width_rad = _rolls_rad(np.arctan2(-off_end[:, 1], -off_end[:, 2]))
    pitch, roll = np.meshgrid(
        np.linspace(pitch_rad.min(), pitch_rad.max(), _PITCHES), start_rad + np.linspace(0.0, width_rad, _ROLLS)
    )
    return np.asarray(specific_force(pitch.ravel(), roll.ravel()))


def _rolls_rad(roll_rad: FloatArray) -> tuple[float, float]:
    """Return where rolls begin and how far they reach; they go round where no gap is larger than the others."""
    turn_rad = 2.0 * np.pi
    if not roll_rad.size:
        return 0.0, turn_rad
    ordered = np.sort(roll_rad % turn_rad)
    gaps_rad = np.diff(ordered, append=ordered[0] + turn_rad)
    largest = int(gaps_rad.argmax())
    *_, second_rad, largest_rad = (0.0, *np.sort(gaps_rad))
    width_rad = turn_rad if largest_rad <= _ALIKE * second_rad else turn_rad - largest_rad
    return float(ordered[(largest + 1) % ordered.size]), float(width_rad)
