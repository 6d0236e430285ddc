"""What a temperature that was recorded, and that no model has, may have done to an estimate.

The record T less its mean acts on the offset by s₀ T and on what is sensed by s₁ T. What a fit of the model leaves of
the two columns tells both slopes; what it takes of them goes into the estimate unseen: d s, with d the estimator's
answer to a column. d s² dᵀ stands in the covariance, slopes as they were found: nothing where the temperature hardly
changed or did not go with the attitudes, about what the swing does where it did (13 × 12 points, 25 µg/°C, 0.02 to
0.2 °C in step with the replications: 0.93 to 0.99 of the intervals hold, 0.41 to 0.92 without it). A difference of
temperature that is constant is in no residual: the declared range of use has to hold it. Nor do residuals tell the
slope of a column that the model takes up nearly whole: noise divided by nearly nothing would stand for it. It is left
out, and where temperature and attitude go together, a finding says so.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.models.model import Model
from ams.models.thermal import TEMPERATURE_NAMES
from ams.remembered import remembered
from ams.solve.components import ComponentColumns
from ams.solve.linear_form import LinearForm

NAME: Final = "recorded temperature"
SMALLEST_CHANGE_DEGC: Final = 1e-6
"""A temperature that was recorded and changed by less is one number."""
_LEFT: Final = 0.01
"""Of a column's square: of what leaves less in the residuals no slope is told."""


def is_unmodelled(model: Model, temperature_degc: FloatArray | None) -> bool:
    """Return whether a temperature was recorded that is not one number and that the model does not have."""
    if temperature_degc is None or TEMPERATURE_NAMES[0] in model.primary_names:
        return False
    return swing_degc(temperature_degc) > SMALLEST_CHANGE_DEGC


@remembered(16)
def swing_degc(temperature_degc: FloatArray) -> float:
    """Return highest less lowest of (N,) temperatures; of (N, m) the largest of the columns'."""
    return float(np.ptp(temperature_degc, axis=0).max())


def recorded_temperature(
    form: LinearForm, estimator: FloatArray, outputs: FloatArray, ordinary: FloatArray, temperature_degc: FloatArray
) -> ComponentColumns:
    """Return the component of (N, m) outputs with (P, m) ordinary estimates and a (P, N) or (m, P, N) estimator.

    The temperature is (N,), or (N, m) where the outputs were not measured together.
    """
    fitted = form.fitted(ordinary)
    left, size = outputs - fitted, outputs.shape[1]
    covariance = np.empty((size, ordinary.shape[0], ordinary.shape[0]))
    for index in range(size):
        recorded = temperature_degc if temperature_degc.ndim == 1 else temperature_degc[:, index]
        warm = _warm(form.basis, form.estimator, recorded)
        swung = warm.column * (fitted[:, index] - float(warm.departing @ fitted[:, index]))
        swing = form.estimator @ swung
        taken_up = np.array([warm.taken_up, swing]).T
        slopes = _slopes(warm, swung, swung - form.fitted(swing), left[:, index])
        if estimator is form.estimator:
            answer = taken_up
        else:
            weighted = estimator if estimator.ndim == 2 else estimator[index]
            answer = np.stack([weighted @ warm.column, weighted @ swung], axis=1)
        effects = answer * slopes
        covariance[index] = effects @ effects.T
    return ComponentColumns(NAME, covariance, np.full(size, np.inf))


@dataclass(frozen=True)
class _Warm:
    """What a model makes of a recorded temperature, whatever the outputs are."""

    column: FloatArray
    """(N,) about its mean."""
    taken_up: FloatArray
    """(P,)"""
    apart: FloatArray
    """(N,) what the model leaves of it."""
    square: float
    """Of the column."""
    apart_square: float
    """Of what the model leaves of it."""
    departing: FloatArray
    """(N,) weights of the mean output at which the temperature departs, so that the column and its product with the
    output about that mean are at right angles. With the plain mean one reading that stands apart would make two
    columns of one."""


@remembered(16)
def _warm(basis: FloatArray, estimator: FloatArray, temperature_degc: FloatArray) -> _Warm:
    column = temperature_degc - temperature_degc.mean()
    taken_up, square = estimator @ column, float(column @ column)
    departing = column**2 / square if square > 0.0 else np.zeros_like(column)
    apart = column - basis @ taken_up
    return _Warm(column, taken_up, apart, square, float(apart @ apart), departing)


def _slopes(warm: _Warm, swung: FloatArray, swung_apart: FloatArray, left: FloatArray) -> FloatArray:
    """Return the (2,) slopes that the temperature, and (N,) its product with the output, have in what is left.

    ``swung_apart`` (N,) is what the model does not take up of the product. Where the two are one in the residuals that
    of the one that explains more; 0 for what leaves too little to tell.
    """
    squares = warm.apart_square, float(swung_apart @ swung_apart)
    along = float(warm.apart @ left), float(swung_apart @ left)
    both = float(warm.apart @ swung_apart)
    wholes = warm.square, float(swung @ swung)
    is_determined = [square > _LEFT * whole for square, whole in zip(squares, wholes, strict=True)]
    if all(is_determined) and both**2 < (1.0 - _LEFT) * squares[0] * squares[1]:
        crossed = squares[1] * along[0] - both * along[1], squares[0] * along[1] - both * along[0]
        return np.array(crossed) / (squares[0] * squares[1] - both**2)
    alone = np.where(is_determined, squares, np.inf)
    explained = np.square(along) / alone
    return np.where((explained == explained.max()) & is_determined, along / alone, 0.0)
