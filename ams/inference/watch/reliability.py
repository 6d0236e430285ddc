"""What rows of packages cannot tell of their outputs, and how far angles are wrong by it: their reliability.

Internal reliability is the smallest error of one output that the test of redundancy finds with a given probability,
external reliability what an error of that size does to the angles. Source: Baarda, A testing procedure for use in
geodetic networks (Netherlands Geodetic Commission, Publications on Geodesy, New Series 2(5), 1968).

Baarda's test is a single one, linear, of independent readings, and its noncentrality a number of a table. Here the same
test is made of every row, what the calibration is wrong by is in all rows alike, and where an axis lies level its error
changes the length of what is sensed by its square. So an error is put into every row, the attitude is fitted anew, and
what is left is held against the limits of the test over draws of calibrations and readings.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.inference.inference import Inference
from ams.inference.rows.angle_stream import AngleStream
from ams.inference.rows.possible_rows import possible_readings
from ams.inference.watch.faulted_rows import FaultedRows
from ams.inference.watch.watched_axes import LARGEST_SHARE_BY_CHANCE, can_be_watched, watch_of
from ams.units import in_arcsec

FOUND_SHARE: Final = 0.95
"""Of files with an error, in which it is found."""
MOST_ROWS: Final = 100
"""That are looked at, evenly spaced over all."""
_DRAWS: Final = 1000
_STEPS: Final = 80
_GROWTH: Final = 1.3
_CLOSE: Final = 1.01
_LARGEST_G: Final = 1.0
_SMALL_G: Final = 1e-4
"""Where the search begins at most: below what is found. From above it would end at an error of twice what an axis
senses, of the other sign, which mirrors the attitude and is found no more."""
_COVERAGE: Final = 2.0
_PACKAGES: Final = ("sting", "model")


@dataclass(frozen=True)
class AngleChange:
    """By how much an angle is wrong, in the row in which that is most."""

    angle: str
    """pitch, yaw or roll."""
    change_deg: float
    expanded_uncertainty_deg: float
    """Stated there, k = 2."""

    @property
    def is_beyond_stated(self) -> bool:
        """Whether the angle is wrong by more than is stated of it."""
        return self.change_deg > self.expanded_uncertainty_deg


@dataclass(frozen=True)
class UnseenError:
    """What the rows do not tell of one output."""

    sensor: str
    package: str
    """``sting`` or ``model`` of two; empty of one."""
    axis: str
    found_v: float | None
    """The smallest constant error that is found; None: none up to 1 g."""
    found_arcsec: float | None
    """The same over the sensitivity: what a level axis would have to turn by."""
    changes: tuple[AngleChange, ...]
    """By that error."""
    dead_found_share: float
    """Of files in which the axis senses nothing and reads its offset, those in which that is found."""
    dead_changes: tuple[AngleChange, ...]
    """By that."""

    @property
    def is_dead_unseen(self) -> bool:
        """Whether a dead axis is found less often than is asked of an error."""
        return self.dead_found_share < FOUND_SHARE


@dataclass(frozen=True)
class Unseen:
    """What rows do not tell of any output."""

    rows: int
    outputs: tuple[UnseenError, ...]
    found_share: float = FOUND_SHARE
    """Of files with an error, in which the errors stated are found."""


def unseen_of(angles: AngleStream, chance: np.random.Generator) -> Unseen | None:
    """Return what the rows of a stream do not tell, once all have come.

    None where its outputs do not test one another, or where the rows prove a package wrong: there the angles are known
    to be off.
    """
    watched = watch_of(angles)
    if watched is None or not watched.rows or watched.proven():
        return None
    found = unseen_errors(watched.inference, watched.kept_readings(), chance)
    return None if found is None else replace(found, rows=watched.rows)


def unseen_errors(
    inference: Inference, readings: Mapping[str, FloatArray], chance: np.random.Generator
) -> Unseen | None:
    """Return what (N,) readings do not tell of the outputs, by at most 100 of their rows.

    An error is found where more than one row in a hundred is flagged, and one at least. None where the outputs do not
    test one another (packages of other than three accelerometers), where no row is whole, or nothing is uncertain.
    """
    size = readings[inference.needed[0]].size
    packages = (inference.package, *([] if inference.model_package is None else [inference.model_package]))
    if not size or not all(can_be_watched(package) for package in packages):
        return None
    kept = np.unique(np.linspace(0, size - 1, min(size, MOST_ROWS)).round().astype(int))
    thinned = possible_readings({name: values[kept] for name, values in readings.items()}, packages)
    is_whole = np.logical_and.reduce([np.isfinite(thinned[name]) for name in inference.needed])
    if not is_whole.any():
        return None
    whole = {name: values[is_whole] for name, values in thinned.items()}
    rows = FaultedRows(inference, whole)
    if not rows.is_uncertain:
        return None
    noise, answered = rows.noise(_DRAWS, chance), inference.answer(whole).columns
    return Unseen(size, tuple(_unseen(rows, noise, answered, output) for output in range(rows.predicted_v.shape[1])))


def _unseen(rows: FaultedRows, noise: FloatArray, answered: Mapping[str, FloatArray], output: int) -> UnseenError:
    """Return what is not told of one output, whichever sign its error has."""
    which, axis_index = divmod(output, 3)
    package, k_v_per_g = rows.packages[which], float(rows.sensitivity_v_per_g[output])
    limits = rows.limits(output)
    found_g = _found_g(rows, noise, limits, output)
    dead_v = np.zeros((1, *rows.predicted_v.shape))
    dead_v[0, :, output] = -rows.predicted_v[:, output]
    shifted_v = np.zeros((2, *rows.predicted_v.shape))
    shifted_v[:, :, output] = np.array([[found_g], [-found_g]]) * k_v_per_g
    is_found = found_g < _LARGEST_G
    return UnseenError(
        package.coefficients.sensor,
        _PACKAGES[which] if len(rows.packages) == 2 else "",
        tuple(package.columns)[axis_index],
        found_g * k_v_per_g if is_found else None,
        in_arcsec(found_g) if is_found else None,
        _largest(rows.changes_rad(shifted_v), answered) if is_found else (),
        float(_found_shares(rows.unexplained(dead_v), noise, limits)[0]),
        _largest(rows.changes_rad(dead_v), answered),
    )


def _found_g(rows: FaultedRows, noise: FloatArray, limits: FloatArray, output: int) -> float:
    """Return the smallest constant error of an output that is found whichever its sign, over its sensitivity."""
    signs = np.array([1.0, -1.0]) * rows.sensitivity_v_per_g[output]
    steepest = float(np.sqrt(np.max(np.sum(rows.linear(output) ** 2, axis=1))))
    size = np.full(2, min(1.0 / max(steepest, 1e-300), _SMALL_G))
    low, high = np.zeros(2), np.full(2, np.inf)
    for _ in range(_STEPS):
        errors_v = np.zeros((2, *rows.predicted_v.shape))
        errors_v[:, :, output] = (size * signs)[:, None]
        is_found = _found_shares(rows.unexplained(errors_v), noise, limits) >= FOUND_SHARE
        low, high = np.where(is_found, low, size), np.where(is_found, size, high)
        if np.all((high <= _CLOSE * low) | (low >= _LARGEST_G)):
            break
        grown = np.where(np.isinf(high), _GROWTH * size, size / _GROWTH**2)
        size = np.where(np.isfinite(high) & (low > 0.0), np.sqrt(low * high), grown)
    return float(np.min([_LARGEST_G, np.max(high)]))


def _found_shares(unexplained: FloatArray, noise: FloatArray, limits: FloatArray) -> FloatArray:
    """Return the (m,) shares of draws in which (m, N, d) errors make more rows disagree than chance does."""
    least = int(LARGEST_SHARE_BY_CHANCE * len(limits)) + 1
    of_noise = np.einsum("ndk,ndk->nk", noise, noise)
    shares = []
    for left in unexplained:
        square = of_noise + 2.0 * np.einsum("nd,ndk->nk", left, noise) + np.sum(left**2, axis=1)[:, None]
        # What fits no attitude at all is flagged as that.
        is_flagged: BoolArray = ~(square <= limits[:, None])
        shares.append(np.mean(np.count_nonzero(is_flagged, axis=0) >= least))
    return np.array(shares)


def _largest(changes_rad: Mapping[str, FloatArray], answered: Mapping[str, FloatArray]) -> tuple[AngleChange, ...]:
    """Return the largest of (m, N) changes of each angle in rows in which it is told."""
    found = []
    for angle, by_row in changes_rad.items():
        most_deg = np.rad2deg(np.max(np.nan_to_num(by_row), axis=0))
        most_deg = np.where(np.isfinite(answered[f"{angle}_deg"]), most_deg, -1.0)
        row = int(np.argmax(most_deg))
        if most_deg[row] >= 0.0:
            found.append(AngleChange(angle, float(most_deg[row]), _COVERAGE * float(answered[f"{angle}_sd_deg"][row])))
    return tuple(found)
