"""What comes and goes in step with the replications where the order of the points is another in each of them.

It is noise there, with the same course in every replication: each output shows it beside the effects of the points and
the parameters of each replication, which have hardly any of it in common. One wave at a time of one, two and three
periods is asked for, as one voltage on all outputs and by an amount of each output. Without it the first dwells of the
replications would be said to settle, and every dwell to know of the one before it.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.sensed_force import along_force
from ams.analysis.diagnostics.tested_terms import accelerometer_base
from ams.analysis.diagnostics.time_order import LEAST_DOF
from ams.arrays import FloatArray
from ams.calibration.together.in_step_found import WAVES, InStep, Way, waves_at, waves_of
from ams.statistics.distributions import f_tail

_WAYS: Final[tuple[Way, ...]] = ("meter", "outputs")
_SEEN: Final = 0.1
"""Of the square of a wave: of which less is left beside points and replications, is not asked for."""


class _Shown(NamedTuple):
    """Of one output, of unit variance."""

    axis: str
    per_g: float
    along: FloatArray
    """(6,) products of the waves with the residuals."""
    square: FloatArray
    """(6, 6) of the waves."""
    dof: float

    def of(self, waves: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
        """Return products and squares of some waves."""
        at = waves_at(waves)
        return self.along[at], self.square[np.ix_(at, at)]


def judge_between(outputs: Sequence[tuple[Evidence, int]], level: float) -> InStep | None:
    """Return what comes and goes in step with the replications, where it is shown at a ``level``; None: nothing is."""
    each = (_shown(evidence, index) for evidence, index in outputs)
    shown = [output for output in each if output is not None]
    if len(shown) < len(outputs):
        return None
    dof = sum(output.dof for output in shown)
    found = [(_chance(shown, way, wave, dof), way, wave) for way in _WAYS for wave in range(1, WAVES + 1)]
    p_value, way, _ = min(found)
    if not len(found) * p_value <= level:
        return None
    waves = tuple(wave for p, of_way, wave in sorted(found) if of_way == way and len(found) * p <= level)
    sizes, deviations = _estimated(shown, way, waves)
    pairs = sizes.reshape(-1, len(waves), 2)[:, 0]
    largest = int(np.argmax(np.linalg.norm(pairs, axis=1)))
    uncertainty = float(np.linalg.norm(deviations.reshape(-1, len(waves), 2)[largest, 0])) / 2.0**0.5
    axes = tuple(output.axis for output in shown)
    return InStep(way, waves, sizes, axes, uncertainty, dof, len(found) * p_value, is_alike=False)


def _shown(evidence: Evidence, output: int) -> _Shown | None:
    """Return what one output shows; None of one that is no accelerometer, or where the waves are hardly seen."""
    base, grid = accelerometer_base(evidence.models[output]), evidence.grid
    variance = float(evidence.precision_variance[output])
    if base is None or not variance > 0.0 or evidence.sums is None or grid.dof < LEAST_DOF:
        return None
    left = grid.projected(evidence.on_grid(waves_of(evidence.time_order, evidence.layout)))
    square = left.T @ left
    if not np.linalg.eigvalsh(square)[0] > _SEEN * 0.5 * evidence.layout.rows:
        return None
    along = left.T @ grid.residuals[:, output]
    per_g = float(np.linalg.norm(along_force(base, evidence.primary[output])))
    return _Shown(base.nominal_axis, per_g, along / variance, square / variance, float(grid.dof))


def _chance(shown: Sequence[_Shown], way: Way, wave: int, dof: float) -> float:
    """Return the chance of as much of one wave."""
    each = [output.of((wave,)) for output in shown]
    if way == "meter":
        each = [(np.sum([along for along, _ in each], axis=0), np.sum([square for _, square in each], axis=0))]
    explained = sum(float(along @ np.linalg.solve(square, along)) for along, square in each)
    numbers = 2.0 * len(each)
    return float(f_tail(explained / numbers, numbers, dof))


def _estimated(shown: Sequence[_Shown], way: Way, waves: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
    """Return sizes and standard uncertainties of waves, as :class:`InStep` has them."""
    each = [output.of(waves) for output in shown]
    if way == "meter":
        each = [(np.sum([along for along, _ in each], axis=0), np.sum([square for _, square in each], axis=0))]
    scales = [1.0] if way == "meter" else [output.per_g for output in shown]
    covariances = [np.linalg.inv(square) for _, square in each]
    sizes = [c @ along / scale for c, (along, _), scale in zip(covariances, each, scales, strict=True)]
    deviations = [np.sqrt(np.diagonal(c)) / scale for c, scale in zip(covariances, scales, strict=True)]
    return np.concatenate(sizes), np.concatenate(deviations)
