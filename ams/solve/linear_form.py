"""The exact, start-free solution of a model that is linear in its primary parameters.

Ordinary or weighted least squares by an orthogonal factorisation, factored once and used for every sensor axis and
every right-hand side. Source: TP (43) to (50) with a gradient that does not depend on the parameters.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ams.arrays import FloatArray
from ams.errors import DesignError
from ams.models.model import Stimulus
from ams.remembered import remembered

RANK_TOLERANCE = 1e-9
_PART_OF_A_DIRECTION = 0.05
_ROUNDING = 1e-12
"""Of the longest column: a column shorter than this is zero but for rounding, such as sin R at roll 0° and 180°."""


@dataclass(frozen=True)
class LinearForm:
    """Factors of one (weighted) basis."""

    basis: FloatArray
    """(N, P) as given, not weighted."""
    weights: FloatArray | None
    """(N,) relative weights of the rows, or None for equal ones."""
    estimator: FloatArray
    """(P, N) with estimate = estimator @ y."""
    unscaled_covariance: FloatArray
    """(P, P) R⁻¹ of TP (50): covariance for rows of unit variance (and unit weight)."""
    condition_number: float
    """Of the basis with its columns scaled to unit length: how much the points amplify an error."""
    repeats: int = 1
    """How often the first N / repeats rows of the basis stand in it, one block below the other."""
    repeated_block: FloatArray | None = None

    @property
    def block(self) -> FloatArray:
        """Return the (N / repeats, P) rows that the basis repeats; all of them where it repeats none."""
        return self.basis if self.repeated_block is None else self.repeated_block

    def fitted(self, estimate: FloatArray) -> FloatArray:
        """Return the (N, …) outputs of (P, …) parameters."""
        once = self.block @ estimate
        return np.asarray(once if self.repeats == 1 else np.concatenate([once] * self.repeats))

    def solve(self, outputs: FloatArray) -> FloatArray:
        """Estimate from (N,) or (N, m) outputs; refined once, so that rounding stays at that of the data."""
        first = self.estimator @ outputs
        return np.asarray(first + self.estimator @ (outputs - self.basis @ first))


def factor(
    basis: FloatArray, names: Sequence[str], stimulus: Stimulus, weights: FloatArray | None = None, times: int = 1
) -> LinearForm:
    """Factor a basis of shape (N, P), of which ``times`` are to stand one below the other where nothing is weighted.

    Raises:
        DesignError: fewer rows than parameters, or the points leave a direction of the parameters undetermined.
    """
    rows, size = basis.shape
    if rows < size:
        raise DesignError(
            f"design: {rows} observations cannot determine {size} parameters ({', '.join(names)}): "
            f"allowed {size} distinct points or more; nothing was solved; add points"
        )
    if weights is None:
        form, principal = _unweighted(basis, times)
        _refuse_rank_deficiency(principal, names, stimulus)
        return form
    assert times == 1
    root = np.sqrt(weights)[:, None]
    q, r = np.linalg.qr(root * basis)
    principal = _principal(r)
    _refuse_rank_deficiency(principal, names, stimulus)
    inverse = np.linalg.inv(r)
    return LinearForm(basis, weights, inverse @ q.T * root.T, inverse @ inverse.T, principal.condition_number)


class _Principal(NamedTuple):
    """Of columns at unit length."""

    condition_number: float
    """Infinite where the rows leave a direction undetermined."""
    missing: FloatArray
    """(d, P) directions that the rows leave undetermined."""


@remembered(16)
def _unweighted(basis: FloatArray, times: int) -> tuple[LinearForm, _Principal]:
    """Return the form of a basis that stands that many times, one block below the other.

    Its numbers are NaN where the rows leave a direction undetermined.
    """
    q, r = orthogonal(basis)
    principal = _principal(r)
    inverse = np.linalg.inv(r) if principal.missing.size == 0 else np.full(r.shape, np.nan)
    estimator, covariance = inverse @ q.T, inverse @ inverse.T
    if times == 1:
        return LinearForm(basis.copy(), None, estimator, covariance, principal.condition_number), principal
    repeated = np.tile(basis, (times, 1)), None, np.tile(estimator / times, times), covariance / times
    return LinearForm(*repeated, principal.condition_number, times, basis.copy()), principal


@remembered(16)
def orthogonal(basis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the (N, P) orthonormal and (P, P) triangular factors of a basis that many outputs share."""
    q, r = np.linalg.qr(basis)
    return q, r


def _refuse_rank_deficiency(principal: _Principal, names: Sequence[str], stimulus: Stimulus) -> None:
    """Raise a DesignError where a parameter is not determined."""
    missing = principal.missing
    if missing.size == 0:
        return
    touched = np.abs(missing).max(axis=0) > _PART_OF_A_DIRECTION
    undetermined = [name for name, is_touched in zip(names, touched, strict=True) if is_touched]
    raise DesignError(
        f"design: rank {len(names) - len(missing)} of {len(names)}: the points cannot determine "
        f"{' and '.join(undetermined)}: {_values_in_words(stimulus)}; nothing was solved; {_advice(stimulus)}"
    )


def _principal(r: FloatArray) -> _Principal:
    """Return what columns determine, by their triangular factor."""
    length = np.linalg.norm(r, axis=0)
    _, singular, directions = np.linalg.svd(r / np.where(length > _ROUNDING * length.max(), length, np.inf))
    missing = directions[singular <= RANK_TOLERANCE * singular[0]]
    return _Principal(float(singular[0] / singular[-1]) if missing.size == 0 else np.inf, missing)


def _distinct_deg(angle_rad: FloatArray) -> FloatArray:
    return np.unique(np.round(np.rad2deg(angle_rad), 6))


def _values_in_words(stimulus: Stimulus) -> str:
    if stimulus.reference_level is not None:
        return f"the reference has {np.unique(stimulus.reference_level).size} different levels"
    angles = {"pitch": stimulus.pitch_rad, "yaw": stimulus.yaw_rad, "roll": stimulus.roll_rad}
    phrases = []
    for name, angle in angles.items():
        if angle is None:
            continue
        values = _distinct_deg(angle)
        if values.size == 1:
            phrases.append(f"{name} has one value only ({values[0]:g}°)")
        else:
            phrases.append(f"{name} has {values.size} values from {values[0]:g}° to {values[-1]:g}°")
    return ", ".join(phrases)


def _advice(stimulus: Stimulus) -> str:
    if stimulus.reference_level is not None:
        return "measure at two or more different levels"
    if stimulus.euler_rate_rad_s is not None:
        return "turn the package about all three of its axes, in both senses"
    if stimulus.yaw_rad is not None:
        return "add attitudes at other pitch, yaw and roll angles: gravity must turn about at least two axes"
    is_single_pitch = _distinct_deg(stimulus.pitch_rad).size == 1
    if _distinct_deg(stimulus.roll_rad).size == 1:
        azimuth = (
            "with one roll angle coning and azimuth cannot be determined: add roll angles, or use model pitch-only"
        )
        return f"{azimuth}; add pitch angles as well" if is_single_pitch else azimuth
    if is_single_pitch:
        return "with one pitch angle offset and sensitivity cannot be told apart: add pitch angles"
    return "add attitudes at other pitch and roll angles"
