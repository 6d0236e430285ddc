"""What a gyro does between three rates, which no row tells: a bend or an asymmetry of its scale factor.

Where a gyro turned at one rate in both senses and stood still, K₂ω² and an asymmetry ½K₁′|ω| go through the same
outputs, and whichever is in the equation leaves nothing over. Between these rates they differ, by K₂r²/4 at most, at
half the rate: where the senses differ by 1 500 ppm that is 188 ppm of the largest output. The rows that show how large
the term is show as well how far the two lie apart, and that is a limit for what an output is off by: it is in the
covariance, as one error of all readings, whatever a test says of the term. A bend of third order is zero at all three
rates beside a straight line; nothing tells its size, and the verdict says so.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.calibration.solving.model_choice import ModelChoice
from ams.inputs.shared_errors import BETWEEN_RATES, SHOWN_BY_ROWS, SharedError
from ams.models.extended import linear_part
from ams.models.gyro import GyroWithTerms, velocity_of_dps
from ams.models.rate_terms import RATE_TERM_NAMES, centred_rate_terms
from ams.observations import Observations
from ams.rounding import significant
from ams.sets.verdict_conditions import THREE_RATES

_SAME: Final = 0.02
"""Of an asymmetry's length, beside the linear sensor: what terms in the equation leave of it at three rates is less."""
_CARRIES: Final = 0.9
"""Of a limit, as a standard uncertainty: an asymmetry reaches it at half the rate, and beside noise as large as itself
a rectangle's 0.58 would hold it in 0.85."""
_RATES: Final = 101


def errors_between_rates(
    rows: Observations, choices: Mapping[str, ModelChoice], primary: Mapping[str, FloatArray]
) -> tuple[dict[str, ModelChoice], dict[str, tuple[SharedError, ...]]]:
    """Return the choices with what is said of such rates, and by axis what its outputs may be off by between them.

    ``primary``: axis to its primary parameters as they were solved.
    """
    said, errors = dict(choices), dict[str, tuple[SharedError, ...]]()
    for label, choice in choices.items():
        model = choice.model
        if not isinstance(model, GyroWithTerms):
            continue
        velocity_dps = velocity_of_dps(rows)
        apart = _apart(velocity_dps, model)
        if apart is None:
            continue
        limit_v = apart * abs(float(primary[label][model.primary_names.index(RATE_TERM_NAMES[0])]))
        largest = float(np.abs(velocity_dps[:, "xyz".index(model.nominal_axis)]).max())
        sensitivity = float(np.linalg.norm(primary[label][1:4]))
        ppm = 1e6 * limit_v / (sensitivity * largest)
        stated = f"{_CARRIES:g} of a limit of {significant(1e6 * limit_v)} µV between the rates, {SHOWN_BY_ROWS}"
        errors[label] = (
            SharedError(
                BETWEEN_RATES, "departure", _CARRIES * limit_v, stated=stated, is_of_one_channel=True, is_weighed=False
            ),
        )
        remark = (
            f"{THREE_RATES}: 0 and ±{largest:.4g} °/s: K₂ and K₁′ (asymmetry) go through the same outputs there, and "
            f"differ between by up to {significant(ppm)} ppm of the largest of {label}, which is in the uncertainty; a "
            "bend of third order shows at none of them and is in no figure stated here; turn at a rate between as well"
        )
        said[label] = replace(choice, remarks=(*choice.remarks, remark))
    return said, errors


def _apart(velocity_dps: FloatArray, model: GyroWithTerms) -> float | None:
    """Return how far K₂ and the asymmetry that passes for it lie apart at most, for K₂ = 1; None where rows tell."""
    index = "xyz".index(model.nominal_axis)
    within = np.zeros((_RATES, 3))
    within[:, index] = np.linspace(velocity_dps[:, index].min(), velocity_dps[:, index].max(), _RATES)
    linear, (basis, between) = linear_part(velocity_dps), (_basis(at, model) for at in (velocity_dps, within))
    asymmetry = np.abs(velocity_dps[:, index])
    alone, whole = (_left(columns, asymmetry) for columns in (linear, basis))
    if not alone > 0.0 or whole > _SAME * alone:
        return None
    passes_for = np.linalg.lstsq(basis, asymmetry, rcond=None)[0]
    return float(np.abs(np.abs(within[:, index]) - between @ passes_for).max() / abs(passes_for[4]))


def _basis(velocity_dps: FloatArray, model: GyroWithTerms) -> FloatArray:
    """Return the (N, 4 + t) columns of the equation."""
    terms = centred_rate_terms(velocity_dps, model.nominal_axis, model.centring)
    return np.concatenate([linear_part(velocity_dps), terms], axis=1)


def _left(columns: FloatArray, of: FloatArray) -> float:
    size = np.linalg.norm(columns, axis=0)
    scaled = columns / np.where(size > 0.0, size, 1.0)
    return float(np.linalg.norm(of - scaled @ np.linalg.lstsq(scaled, of, rcond=None)[0]))
