"""Whether the sensitivities of all outputs of a package changed alike from one replication to the next.

A meter whose gain changes, or a supply, does the same to every output, in parts of what it reads. The search for
changes in mid-run tries every dwell and pays for all of them; each replication tells its sensitivities by itself, and
between replications there are few places. An output shows a gain in the departures of its sensitivities from those of
all replications, along their own direction and by the weights of their covariance; what all outputs show is joined by
its weights. Outputs that differ plainly in it have no gain together.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final, NamedTuple

import numpy as np

from ams.analysis.diagnostics.size_words import within
from ams.analysis.diagnostics.tested_terms import accelerometer_base
from ams.arrays import FloatArray
from ams.calibration.solving.columns import SolvedColumns
from ams.findings import Finding
from ams.solve.replicated import ReplicatedSums
from ams.statistics.distributions import f_tail
from ams.statistics.intervals import t_quantile

GAIN: Final = "gain of all outputs between replications"
_ALONG: Final = slice(1, 4)
"""Of the parameters: the sensitivities."""
_FEWEST: Final = 2
"""Outputs."""
_LEAST_REPLICATIONS: Final = 3
"""Contrasts between replications that are needed."""
_UNLIKE, _ALL_UNLIKE = 0.05, 0.01
"""Chance of outputs that differ as much and have one change together, and one gain in every replication."""
_PPM: Final = 1e6
"""Parts per million in one."""
_ROUNDING: Final = 1e-9
"""Of the sensitivity: replications that a coarse meter reads alike to the digit scatter by less, and tell no gain."""
_WAY_OUT: Final = "read a standard of voltage with the meter before and after a run, and look at the supply"


class OutputOfPackage(NamedTuple):
    """One output, and where it is among those that were solved as one."""

    axis: str
    solved: SolvedColumns
    row: int


@dataclass(frozen=True)
class _Gains:
    """Of one output."""

    axis: str
    departures: FloatArray
    """(n,) gain of every replication less that of all."""
    weights: FloatArray
    """(n, n)"""
    dof: float


@dataclass(frozen=True)
class _Change:
    at: int
    """Replications before it."""
    size: float
    uncertainty: float
    p_value: float
    """Over all places."""
    dof: float


def gain_finding(package: Sequence[OutputOfPackage], level: float) -> Finding | None:
    """Return what is said of a change of the gain that all outputs show; None where none is significant at a level."""
    if len(package) < _FEWEST:
        return None
    gains = [found for output in package if (found := _gains(output)) is not None]
    if len(gains) < _FEWEST:
        return None
    change = _likeliest(gains)
    if not change.p_value <= level or _differ(gains):
        return None
    alone = [_at(change.at, [output]) for output in gains]
    if _unlike(change, alone) < _UNLIKE:
        return None
    labels = package[0].solved.layout.replication_labels
    each = ", ".join(f"{output.axis} {_ppm(of_output)}" for output, of_output in zip(gains, alone, strict=True))
    fact = (
        f"the sensitivities of all outputs changed alike, most between replications {labels[change.at - 1]} and "
        f"{labels[change.at]}: by {_ppm(change)} ({each}); the gain of the meter, or what all outputs share (supply, "
        "temperature); the sensitivities are those of a mean gain, and the stated uncertainties do not hold the change"
    )
    details: dict[str, float | str | None] = {"test": GAIN, "size": _PPM * change.size, "unit": "ppm"}
    details["standard_uncertainty"] = _PPM * change.uncertainty
    return Finding("meter-gain", fact, True, change.p_value, (), details, is_held=False, what_to_do=_WAY_OUT)


def _ppm(change: _Change) -> str:
    return f"{within(_PPM * change.size, _PPM * float(t_quantile(0.95, change.dof)) * change.uncertainty)} ppm"


def _gains(output: OutputOfPackage) -> _Gains | None:
    """Return what an output says of the gain; None of one that is no linear sensor of force and nothing else."""
    solved, row = output.solved, output.row
    sums, model = solved.mixed.sums, solved.problem.models[row]
    if sums is None or accelerometer_base(model) is not model or sums.contrasts.shape[0] < _LEAST_REPLICATIONS:
        return None
    variance = float(sums.ss_precision[row]) / max(sums.dof_precision, 1)
    if not variance > (_ROUNDING * float(np.linalg.norm(solved.primary[row][_ALONG]))) ** 2:
        return None
    k, covariance = solved.primary[row][_ALONG], _of_a_replication(sums)
    weighed = np.linalg.solve(covariance, k)
    square = float(k @ weighed)
    departures = sums.contrasts[:, _ALONG, row] @ weighed / square
    return _Gains(output.axis, departures, _weights(sums, weighed / square, variance), float(sums.dof_precision))


def _of_a_replication(sums: ReplicatedSums) -> FloatArray:
    """Return the (3, 3) covariance of the sensitivities of a replication, for rows of unit variance."""
    return np.asarray(sums.contrast_covariance[0, _ALONG, 0, _ALONG] / (1.0 - 1.0 / sums.contrasts.shape[0]))


def _weights(sums: ReplicatedSums, direction: FloatArray, variance: float) -> FloatArray:
    """Return the (n, n) inverse of the covariance of the departures along a direction, beside their sum."""
    n = sums.contrasts.shape[0]
    if sums.is_balanced:
        return np.eye(n) / (variance * float(direction @ _of_a_replication(sums) @ direction))
    along = np.einsum("i,risj,j->rs", direction, sums.contrast_covariance[:, _ALONG, :, _ALONG], direction)
    return np.asarray(np.linalg.inv(along + np.trace(along) / n**2) / variance)  # contrasts do not touch their sum


def _likeliest(gains: Sequence[_Gains]) -> _Change:
    """Return the place of all at which a change explains most, with the chance over all."""
    weights, along = _together(gains)
    steps = _steps(along.size)
    squares, sizes = np.einsum("sr,rq,sq->s", steps, weights, steps), steps @ along
    at, dof = int(np.argmax(sizes**2 / squares)), sum(output.dof for output in gains)
    square = float(squares[at])
    size = float(sizes[at]) / square
    p_value = len(steps) * float(f_tail(size**2 * square, 1.0, dof))
    return _Change(at + 1, size, square**-0.5, min(1.0, p_value), dof)


def _at(after: int, gains: Sequence[_Gains]) -> _Change:
    """Return the change at one place, as some of the outputs show it."""
    weights, along = _together(gains)
    step, dof = _steps(along.size)[after - 1], sum(output.dof for output in gains)
    square = float(step @ weights @ step)
    size = float(step @ along) / square
    return _Change(after, size, square**-0.5, float(f_tail(size**2 * square, 1.0, dof)), dof)


@cache
def _steps(replications: int) -> FloatArray:
    """Return the (n − 1, n) changes after each replication but the last, about their mean."""
    is_after = np.arange(replications) > np.arange(replications - 1)[:, None]
    return np.asarray(is_after - is_after.mean(axis=1, keepdims=True))


def _together(gains: Sequence[_Gains]) -> tuple[FloatArray, FloatArray]:
    """Return the (n, n) weights of all outputs together, and (n,) their weighted departures."""
    weights = np.sum([output.weights for output in gains], axis=0)
    return weights, np.sum([output.weights @ output.departures for output in gains], axis=0)


def _unlike(change: _Change, alone: Sequence[_Change]) -> float:
    """Return the chance of outputs that differ as much in one change."""
    apart = sum(((each.size - change.size) / each.uncertainty) ** 2 for each in alone)
    return float(f_tail(apart / (len(alone) - 1), float(len(alone) - 1), change.dof))


def _differ(gains: Sequence[_Gains]) -> bool:
    """Return whether the outputs plainly have gains of their own in the replications."""
    weights, along = _together(gains)
    whole, dof = np.linalg.solve(weights, along), sum(output.dof for output in gains)
    apart = sum(float((output.departures - whole) @ output.weights @ (output.departures - whole)) for output in gains)
    numbers = float((len(gains) - 1) * (whole.size - 1))
    return float(f_tail(apart / numbers, numbers, dof)) < _ALL_UNLIKE
