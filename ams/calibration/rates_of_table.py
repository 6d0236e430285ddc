"""What bends the scale factors of a package's gyros alike: rates of a table that are not what they are said to be.

A table that turns slower than it says by another part at one speed, or in one sense, than at the others bends every
gyro on it by the same ppm of the rate, and moves every scale factor by about as much. Gyros bend of themselves too,
each by an amount of its own. Where those that are bent are so alike nothing in their readings tells which it is.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ams.analysis.diagnostics.low_order import OF_GYROS, PPM
from ams.analysis.diagnostics.tested_terms import AnyGyro, tested_base
from ams.calibration.output.diagnosis import Diagnosis
from ams.findings import Finding
from ams.inputs.shared_errors import SharedError
from ams.models.gyro import velocity_of_dps
from ams.observations import Observations
from ams.rounding import significant
from ams.statistics.distributions import chi_square_tail

_UNLIKE = 0.05
"""The chance below which gyros are bent each by an amount of its own."""
_SAME = 0.01
"""Of the largest rate along an axis: rates that differ by more have ppm of their own."""


@dataclass(frozen=True)
class _Bent:
    """One gyro."""

    finding: Finding
    size_ppm: float
    """Of the rate, whatever the polarity."""
    standard_uncertainty_ppm: float
    largest_dps: float


def with_rates_of_table(
    found: Sequence[Sequence[Diagnosis]], rows: Observations, shared: Sequence[SharedError]
) -> list[list[Diagnosis]]:
    """Return the findings of a package of gyros, with terms that are alike beyond the declared rates said to be so.

    ``rows``: those of the solution. ``shared``: its errors, of which those of the rates hold a term that is within two
    standard uncertainties.
    """
    diagnoses = [axis for group in found for axis in group]
    if len(diagnoses) < 2 or rows.euler_rate_rad_s is None:
        return [list(group) for group in found]
    declared = [error.standard_uncertainty for error in shared if error.effect == "rate"]
    limit_ppm = 2e6 * float(np.linalg.norm(declared))
    alike = {id(said): extended for name in OF_GYROS for said, extended in _alike(diagnoses, name, rows, limit_ppm)}
    return [
        [replace(axis, findings=tuple(alike.get(id(said), said) for said in axis.findings)) for axis in group]
        for group in found
    ]


def _alike(
    diagnoses: Sequence[Diagnosis], name: str, rows: Observations, limit_ppm: float
) -> Iterator[tuple[Finding, Finding]]:
    """Yield the findings of one term that is told of several gyros and alike, each with what becomes of it."""
    every = [bent for axis in diagnoses if (bent := _bent(axis, name, rows)) is not None]
    seen_bent = [bent for bent in every if bent.finding.is_significant]
    largest = np.array([bent.largest_dps for bent in every])
    if len(seen_bent) < 2 or np.ptp(largest) > _SAME * largest.max():
        return
    sizes = np.array([bent.size_ppm for bent in every])
    weights = np.array([bent.standard_uncertainty_ppm for bent in every]) ** -2.0
    mean = float(weights @ sizes / weights.sum())
    square = float(weights @ (sizes - mean) ** 2)
    if chi_square_tail(square, len(every) - 1.0) < _UNLIKE or abs(mean) <= limit_ppm:
        return
    fact = (
        f"{len(every)} gyros of the package are bent alike, by {significant(abs(mean))} ± "
        f"{significant(2.0 * float(weights.sum()) ** -0.5)} ppm: the rates of the table do that to every gyro on it, "
        "and all scale factors are then off by as much, which the stated uncertainties do not hold; gyros of one kind "
        "may bend alike, and these readings do not tell which"
    )
    what_to_do = (
        "time whole turns of the table at several rates, in both senses, or turn one gyro on another table; an "
        "uncertainty of the rates that holds it brings it in (--rate-uncertainty-ppm of calrig fit, the standard of "
        "the axis in a rig file)"
    )
    for bent in seen_bent:
        yield bent.finding, replace(bent.finding.adding(fact, what_to_do), is_held=False)


def _bent(axis: Diagnosis, name: str, rows: Observations) -> _Bent | None:
    """Return what an axis shows of a term; None of another sensor, or where another term is told of it instead."""
    base = tested_base(axis.solved.problem.models[axis.row])
    if not isinstance(base, AnyGyro):
        return None
    terms = {said.details.get("test"): said for said in axis.findings if said.details.get("unit") == PPM}
    said = terms.get(name)
    if said is None or (not said.is_significant and any(other.is_significant for other in terms.values())):
        return None
    size, u = said.details.get("size"), said.details.get("standard_uncertainty")
    if not (isinstance(size, float) and isinstance(u, float) and u > 0.0):
        return None
    largest_dps = float(np.abs(velocity_of_dps(rows)[:, "xyz".index(base.nominal_axis)]).max())
    return _Bent(said, size, u, largest_dps)
