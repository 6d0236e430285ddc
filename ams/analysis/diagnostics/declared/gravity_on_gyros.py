"""Whether the zero of a gyro follows the specific force, where the attitudes of its calibration differ in it.

v = b + k·ω + S·G·f: the three components of the force, about their mean over the points, are tested together beside the
model and the nonlinearity of the scale factor. A row that turns is taken to have turned whole turns: of the force what
lies along the axis of turning is left, unless the mean attitude of the row is known. Source: IEEE Std 528, 1431.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.point_means import eliminate, independent
from ams.analysis.diagnostics.tested_terms import terms_of_gyro, tested_base
from ams.arrays import FloatArray
from ams.findings import Finding
from ams.models.accelerometer import LINEAR_COLUMNS
from ams.models.gyro import Gyro, GyroWithTerms, mean_from_level
from ams.observations import Observations
from ams.rounding import significant

GRAVITY: Final = "gravity on the zero"
_ALIKE_G: Final = 1e-3
"""Attitudes whose forces differ by less say nothing."""


@dataclass(frozen=True)
class GravityTest:
    """Of one gyro."""

    p_value: float
    size_dps_per_g: float
    """Length of G, as far as the attitudes show it."""


def gravity_on_zero(
    evidence: Evidence, output: int, known: FloatArray, *, beside_terms: bool = True
) -> GravityTest | None:
    """Test the zero of a gyro for gravity; None for other sensors, and where the attitudes say nothing.

    ``known``: (K, c) of the points that something else is told to do. ``beside_terms``: of the scale factor, which a
    gravity that turns with one axis alone passes for.
    """
    base = tested_base(evidence.models[output])
    if not isinstance(base, Gyro | GyroWithTerms) or not evidence.precision_variance[output] > 0.0:
        return None
    columns = force_columns(evidence)
    terms = terms_of_gyro(evidence, output, base)
    beside = terms[:, terms.any(axis=0)] if beside_terms else terms[:, :0]
    given = independent(
        np.hstack([evidence.basis if beside_terms else evidence.basis[:, :LINEAR_COLUMNS], beside, known])
    )
    tested = eliminate(evidence.means(output, given), columns, np.zeros((columns.shape[0], 0)))
    found = tested.together(range(columns.shape[1]))
    if found is None:
        return None
    volts_per_dps = float(np.linalg.norm(evidence.primary[output][1:4]))
    return GravityTest(found.p_value, float(np.linalg.norm(found.coefficients)) / volts_per_dps)


def force_columns(evidence: Evidence) -> FloatArray:
    """Return (K, c) the specific force of the points about its mean, in the directions in which they differ; g."""
    force = evidence.layout.mean_by_point(_mean_force_g(evidence.rows))
    _, lengths, along = np.linalg.svd(force - force.mean(axis=0), full_matrices=False)
    return np.asarray((force - force.mean(axis=0)) @ along[lengths > _ALIKE_G * np.sqrt(force.shape[0])].T)


def is_declared(found: GravityTest | None, level: float, limit_dps_per_g: float | None) -> bool:
    """Return whether a zero follows gravity, within the limit that is declared of it."""
    return found is not None and found.p_value <= level and found.size_dps_per_g <= (limit_dps_per_g or 0.0)


def gravity_finding(
    found: GravityTest | None, level: float, limit_dps_per_g: float | None, *, counts_earth: bool
) -> Finding | None:
    """Return that the zero follows gravity beyond the declared limit, or where none is declared; None elsewhere.

    ``counts_earth``: whether the rates have the Earth's or a budget for it: along the vertical that looks like gravity.
    """
    if found is None or not found.p_value <= level or found.size_dps_per_g <= (limit_dps_per_g or 0.0):
        return None
    beyond = (
        "and no limit of it is declared"
        if limit_dps_per_g is None
        else f"beyond the declared {significant(limit_dps_per_g)} °/s per g"
    )
    earth = "" if counts_earth else "; the Earth's rotation, 0.0042 °/s at most, looks alike where rates lack it"
    fact = (
        f"the zero follows the attitude to gravity: {significant(found.size_dps_per_g)} °/s per g, {beyond}; the "
        "offset holds for the mean force of the calibration only and the stated uncertainties do not hold what it "
        f"changes by elsewhere{earth}"
    )
    what_to_do = "declare the limit that the gyro has (largest_g_sensitivity_dps_per_g of the sensor, or of calrig fit)"
    details: dict[str, float | str | None] = {"test": GRAVITY, "size": found.size_dps_per_g, "unit": "dps per g"}
    return Finding("lack-of-fit", fact, True, found.p_value, details=details, is_held=False, what_to_do=what_to_do)


def _mean_force_g(rows: Observations) -> FloatArray:
    """Return (N, 3) the mean specific force on each row along the package axes."""
    return -mean_from_level(rows)[:, :, 2]
