"""Whether rates that came from a file lack the Earth's, as the readings of a gyro show.

The Earth turns under a table by 15.04° an hour. A gyro reads k·R Ω beside the rates of the stage, R the mean rotation
from level axes into those of the package: of a row that turns, taken to have turned whole turns, what lies along its
axis is left. Where one axis turns after the other that is an offset of the rows that turn, in both senses alike, and
passes for a nonlinearity of the scale factor, an asymmetry of it, a lack of fit, or for what gravity does to the zero.

That the Earth turns is certain. So it goes before what is only imagined where a vector of its length explains that, and
beside it where both are needed.
"""

from dataclasses import dataclass
from math import degrees, sqrt
from typing import Final

import numpy as np

from ams.analysis.diagnostics.declared.gravity_on_gyros import force_columns
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.point_means import Joint, PointMeans, eliminate, independent, spanned
from ams.analysis.diagnostics.tested_terms import terms_of_gyro, tested_base
from ams.arrays import FloatArray
from ams.attitude.earth_rate import EARTH_RATE_RAD_S
from ams.findings import Finding
from ams.models.accelerometer import LINEAR_COLUMNS
from ams.models.gyro import Gyro, GyroWithTerms, mean_from_level
from ams.rounding import significant
from ams.statistics.distributions import chi_square_tail

EARTH_ON_RATES: Final = "rotation of the Earth"
_EARTH_DPS: Final = degrees(EARTH_RATE_RAD_S)
_SEEN: Final = 0.1
"""Of the direction that is seen best: of others a coned axis sees a little, and nothing is told of them."""
_CONTRADICTED: Final = 0.01
"""The chance below which a rate is none of the Earth's length."""
_NEEDED: Final = 0.05
"""The chance above which terms of the scale factor explain as well what the Earth does."""


@dataclass(frozen=True)
class EarthOnRates:
    """Of one gyro."""

    columns: FloatArray
    """(N, c) what one °/s along each direction of level axes that is seen makes, volts."""
    size_dps: float
    """Length of the rate, as far as it is seen."""
    standard_uncertainty_dps: float
    p_value: float
    """Beside a linear gyro; beside the terms too where alone it is longer."""
    beside_terms: float
    """The chance of it beside all terms of the scale factor as well; 1 where they leave nothing of it."""
    beside_gravity: float
    """The chance of it beside what gravity does to the zero; 1 where that leaves nothing of it."""


def earth_on_rates(evidence: Evidence, output: int, known: FloatArray) -> EarthOnRates | None:
    """Return what the readings of a gyro show of a rate that is the Earth's, by its length.

    ``known``: (K, c) of the points that something else is told to do. None of other sensors, where
    the attitudes do not show it, and where what is shown is longer than it.
    """
    base = tested_base(evidence.models[output])
    if not isinstance(base, Gyro | GyroWithTerms) or not evidence.precision_variance[output] > 0.0:
        return None
    rows = np.einsum("i,nij->nj", evidence.primary[output][1:LINEAR_COLUMNS], mean_from_level(evidence.rows))
    linear, fitted = evidence.basis[:, :LINEAR_COLUMNS], evidence.basis[:, LINEAR_COLUMNS:]
    linear = independent(np.hstack([linear, known]))
    across = spanned(linear)
    level = evidence.layout.mean_by_point(rows)
    _, lengths, along = np.linalg.svd(level - across @ (across.T @ level), full_matrices=False)
    directions = along[lengths > _SEEN * np.linalg.norm(level)].T
    terms = terms_of_gyro(evidence, output, base)
    terms = terms[:, terms.any(axis=0)]
    columns = np.hstack([terms, level @ directions])
    means = evidence.means(output, linear, fitted @ evidence.alone[LINEAR_COLUMNS:, output])
    tested = eliminate(means, columns, evidence.basis)
    count = terms.shape[1]
    of_earth = range(count, columns.shape[1])
    found, beside = tested.together(of_earth), tested.together(of_earth, tuple(range(count)))
    if found is not None and beside is not None and _is_longer(found):
        found = beside
    if found is None or _is_longer(found):
        return None
    size = float(np.linalg.norm(found.coefficients))
    unit = found.coefficients / size
    return EarthOnRates(
        rows @ directions,
        size,
        sqrt(float(unit @ found.covariance @ unit)),
        found.p_value,
        1.0 if beside is None else beside.p_value,
        _beside_gravity(evidence, means, level @ directions, terms),
    )


def _beside_gravity(evidence: Evidence, means: PointMeans, level: FloatArray, terms: FloatArray) -> float:
    """Return the chance of (K, c) columns of the Earth beside gravity on the zero, as far as that leaves them."""
    force = force_columns(evidence)
    across = spanned(np.hstack([means.basis, force]))
    _, lengths, along = np.linalg.svd(level - across @ (across.T @ level), full_matrices=False)
    left = level @ along[lengths > _SEEN * np.linalg.norm(level)].T
    count = left.shape[1]
    tested = eliminate(means, np.hstack([left, force]), np.hstack([evidence.basis, terms]))
    found = tested.together(range(count), tuple(range(count, count + force.shape[1])))
    return 1.0 if found is None else found.p_value


def _is_longer(found: Joint) -> bool:
    """Return whether a rate is plainly longer than the Earth's."""
    size = float(np.linalg.norm(found.coefficients))
    beyond = found.coefficients * max(1.0 - _EARTH_DPS / size, 0.0)
    square = float(beyond @ np.linalg.solve(found.covariance, beyond))
    return bool(chi_square_tail(square, 1.0) < _CONTRADICTED)


def earth_finding(found: EarthOnRates, level: float) -> Finding:
    """Return that the rates lack the Earth's, or where its chance beside gravity is above ``level`` either of both."""
    or_gravity = (
        "" if found.beside_gravity <= level else ", or gravity acts on the zero: these points do not tell which"
    )
    as_well = (
        "; a nonlinearity or an asymmetry of the scale factor explains these points as well, and is told only where "
        "the Earth does not explain it"
        if found.beside_terms > _NEEDED
        else ""
    )
    fact = (
        f"the rates lack the Earth's{or_gravity}: the readings show {significant(found.size_dps)} ± "
        f"{significant(2.0 * found.standard_uncertainty_dps)} °/s that stand on the ground, of the {_EARTH_DPS:.4f} "
        f"°/s that it turns by{as_well}; part of it is in the offset, and in no stated uncertainty"
    )
    what_to_do = (
        "put the Earth's rotation into the rates of the file (latitude and heading of the table tell it), or solve "
        "without --rates-include-earth, so that it is in the uncertainties, or calibrate by a run, which takes "
        "rig.latitude_deg and rig.heading_deg"
        f"{'; or declare the limit that the gyro has (largest_g_sensitivity_dps_per_g)' if or_gravity else ''}"
    )
    details: dict[str, float | str | None] = {"test": EARTH_ON_RATES, "size": found.size_dps, "unit": "dps"}
    details["standard_uncertainty"] = found.standard_uncertainty_dps
    return Finding("rate-undeclared", fact, True, found.p_value, details=details, is_held=False, what_to_do=what_to_do)
