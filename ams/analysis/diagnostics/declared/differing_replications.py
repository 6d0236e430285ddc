"""Whether a replication has another sensitivity or offset than the others, by more than any scatter that is stated.

Every replication by itself has parameters of its own beside the effects of the points. What they differ by is held
against their median, with what the scatter of its own dwells makes uncertain of it, so that dwells that scatter widely
about the same parameters are no difference. Where most replications agree, those that do not are named; of two that
differ, and where no more than half agree, nothing says which is wrong.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import sqrt
from typing import Final

import numpy as np

from ams.analysis.diagnostics.declared.declared_axis import component_indices
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.size_words import within
from ams.analysis.diagnostics.take_back import redo_command
from ams.arrays import FloatArray, IntArray
from ams.findings import Finding
from ams.rounding import significant
from ams.statistics.distributions import f_tail, median

DIFFERING: Final = "replication against the others"
LARGEST: Final = 0.01
"""Of the sensitivity, and of one g as the output senses it: replications that differ by more are no calibration."""
_TINY: Final = float(np.finfo(float).tiny)
_OFFSET: Final = "offset_v"
_EXPANDED: Final = 2.0
"""Standard uncertainties that a difference is beyond its limit by."""
_OF_MEDIAN: Final = np.pi / 2.0
"""Variance of the median of many over that of their mean."""


@dataclass(frozen=True)
class ShiftLimits:
    """What an axis may shift by while it is calibrated, in parts of the sensitivity and in g; the declared, or 1 %."""

    sensitivity: float = LARGEST
    offset_g: float = LARGEST


@dataclass(frozen=True)
class _Quantity:
    """One quantity of one output, by replication."""

    name: str
    unit: str
    factor: float
    """From a part of the sensitivity, or a g, to the unit."""
    key: str
    """Of its limit in the rig file."""
    limit: float
    sizes: FloatArray
    """(n,) less their median; of two replications each less the other."""
    uncertainties: FloatArray
    """(n,) standard."""
    dof: FloatArray
    """(n,)"""

    def differing(self, level: float) -> IntArray:
        """Return the places of the replications that differ by more than the limit, the farthest first."""
        sizes, u = np.abs(self.sizes), np.maximum(self.uncertainties, _TINY)
        with np.errstate(over="ignore"):
            is_significant = f_tail((sizes / u) ** 2, 1.0, self.dof) * sizes.size <= level
        found = np.flatnonzero((sizes - _EXPANDED * self.uncertainties > self.limit) & is_significant)
        return found[np.argsort(-sizes[found], kind="stable")]

    def words(self, index: int, *, is_signed: bool) -> str:
        size, expanded = self.factor * self.sizes[index], _EXPANDED * self.factor * self.uncertainties[index]
        sign = ("−" if size < 0.0 else "+") if is_signed else ""
        return f"{sign}{within(abs(float(size)), float(expanded))} {self.unit}"


def differing_replications(evidence: Evidence, output: int, limits: ShiftLimits, level: float) -> Iterator[Finding]:
    """Yield a finding for the sensitivity and for the offset of an output by which replications differ beyond a limit.

    ``level``: the chance at which one of several tests is significant whatever the others say.
    """
    for quantity in _quantities(evidence, output, limits):
        differing = quantity.differing(level)
        if differing.size:
            yield _finding(evidence, quantity, differing.tolist())


def _quantities(evidence: Evidence, output: int, limits: ShiftLimits) -> Iterator[_Quantity]:
    """Yield what the replications differ in by more than its limit at all, certain or not."""
    sums, model, replications = evidence.sums, evidence.models[output], evidence.layout.replications
    if sums is None or sums.dof_precision <= 0:
        return
    free = tuple(name for name in model.primary_names if name not in model.fixed)
    names = free[: evidence.alone.shape[0]]
    at = list(component_indices(names).values())
    k = evidence.alone[at, output]
    k /= max(sqrt(k @ k), _TINY)
    length = median(sums.separate[:, at, output] @ k)
    if not length > 0.0:
        return
    along = np.zeros(len(names))
    along[at] = k / length
    directions = [("sensitivity", "%", 100.0, "largest_sensitivity_shift", limits.sensitivity, along)]
    if _OFFSET in names and names[at[0]].endswith("_v_per_g"):
        zero = np.zeros(len(names))
        zero[names.index(_OFFSET)] = 1.0 / length
        directions.append(("offset", "g", 1.0, "largest_offset_shift_v", limits.offset_g, zero))
    for name, unit, factor, key, limit, direction in directions:
        sizes = sums.contrasts[:, :, output] @ direction
        if not float(sizes.max() - sizes.min()) > limit:
            continue
        variances, dof = _dwell_variances(evidence, output)
        blocks = np.einsum("ripj->rpij", sums.contrast_covariance)[np.arange(replications), np.arange(replications)]
        unit_variances = np.einsum("i,rij,j->r", direction, blocks, direction)
        if replications == 2:
            sizes, times = sizes - sizes[::-1], 4.0
        else:
            sizes, times = sizes - np.median(sizes), _about_median(replications)
        uncertainties = np.sqrt(times * variances * np.maximum(unit_variances, 0.0))
        yield _Quantity(name, unit, factor, key, limit, sizes, uncertainties, dof)


def _about_median(replications: int) -> float:
    """Return the variance of what one of n differs from their median by, over that of what it does from their mean."""
    return (1.0 + _OF_MEDIAN / replications) / (1.0 - 1.0 / replications)


def _dwell_variances(evidence: Evidence, output: int) -> tuple[FloatArray, FloatArray]:
    """Return (n,) variance of a dwell of every replication and its degrees of freedom: its own where that is larger."""
    n, every = evidence.layout.replications, float(evidence.grid.dof)
    pooled = np.nan_to_num(evidence.precision_variance[output])
    squares = (evidence.grid.residuals[:, output] ** 2).reshape(n, -1).sum(axis=1)
    alone = squares * n / every if pooled > 0.0 else np.zeros(n)
    return np.maximum(alone, pooled), np.where(alone > pooled, every / n, every)


def _finding(evidence: Evidence, quantity: _Quantity, differing: list[int]) -> Finding:
    rows, labels = evidence.rows, evidence.layout.replication_labels
    is_named = len(labels) > 2 and 2 * len(differing) < len(labels)
    first = differing[0]
    limit = f"{significant(quantity.factor * quantity.limit)} {quantity.unit}"
    beyond = (
        f"that is more than {limit}, which is no scatter between replications, and the stated uncertainties do not "
        "hold it: the result is not usable as it is"
    )
    if is_named:
        each = [f"replication {labels[index]} by {quantity.words(index, is_signed=True)}" for index in differing]
        fact = f"the {quantity.name} differs from that of the other replications: {', '.join(each)}; {beyond}"
        again = ", ".join(redo_command(labels[index], rows.run) for index in differing)
    else:
        pair = len(labels) == 2
        span = significant(quantity.factor * float(np.ptp(quantity.sizes)))
        size = quantity.words(first, is_signed=False) if pair else f"{span} {quantity.unit} (largest less smallest)"
        which = f"replications {' and '.join(map(str, labels))}" if pair else "the replications"
        why = "of two replications nothing tells" if pair else "no more than half of them agree, and nothing tells"
        fact = f"the {quantity.name} of {which} differs by {size}: {beyond}; {why} which is wrong"
        again = ""
    details: dict[str, float | str | None] = {
        "test": DIFFERING,
        "quantity": quantity.name,
        "size": float(quantity.factor * quantity.sizes[first]),
        "standard_uncertainty": float(quantity.factor * quantity.uncertainties[first]),
        "unit": quantity.unit,
        **({"replication": float(labels[first])} if is_named else {}),
    }
    what_to_do = _what_to_do(evidence, again, quantity, is_named=is_named)
    return Finding("drift", fact, True, None, details=details, is_held=False, what_to_do=what_to_do)


def _what_to_do(evidence: Evidence, again: str, quantity: _Quantity, *, is_named: bool) -> str:
    """Return how it is measured again, or where it is declared that the sensor does as much."""
    rows = evidence.rows
    if not is_named:
        measured = "find what changed, and measure another replication"
    elif rows.step is not None:
        measured = f"find what changed, and measure again ({again})"
    else:
        measured = f"find what changed, and measure again, or leave these rows out of {rows.source} and solve again"
    return f"{measured}; a sensor that shifts by as much has it declared ({quantity.key})"
