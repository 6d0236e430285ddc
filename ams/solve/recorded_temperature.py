"""What a temperature that was recorded, and that no model has, may have done to an estimate.

The record T less its mean acts on the offset by s₀ T and on what is sensed by s₁ T. What a fit of the model leaves of
the two columns tells both slopes; what it takes of them goes into the estimate unseen: d s, with d the estimator's
answer to a column. d s² dᵀ stands in the covariance, slopes as they were found: nothing where the temperature hardly
changed or did not go with the attitudes, about what the swing does where it did (13 × 12 points, 25 µg/°C, 0.02 to
0.2 °C in step with the replications: 0.93 to 0.99 of the intervals hold, 0.41 to 0.92 without it). A difference of
temperature that is constant is in no residual: the declared range of use has to hold it.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.models.model import Model
from ams.models.thermal import TEMPERATURE_NAMES
from ams.solve.components import ComponentColumns
from ams.solve.linear_form import LinearForm

NAME: Final = "recorded temperature"
_SMALLEST_CHANGE_DEGC: Final = 1e-6
_LEFT: Final = 1e-9
"""Of a column's square: with less the attitudes tell all of it, which is a finding of its own."""


def is_unmodelled(model: Model, temperature_degc: FloatArray | None) -> bool:
    """Return whether a temperature was recorded that is not one number and that the model does not have."""
    if temperature_degc is None or TEMPERATURE_NAMES[0] in model.primary_names:
        return False
    return bool(np.ptp(temperature_degc, axis=0).max() > _SMALLEST_CHANGE_DEGC)


def recorded_temperature(
    form: LinearForm, estimator: FloatArray, outputs: FloatArray, ordinary: FloatArray, temperature_degc: FloatArray
) -> ComponentColumns:
    """Return the component of (N, m) outputs with (P, m) ordinary estimates and a (P, N) or (m, P, N) estimator.

    The temperature is (N,), or (N, m) where the outputs were not measured together.
    """
    fitted = form.basis @ ordinary
    left, size = outputs - fitted, outputs.shape[1]
    warmth = np.broadcast_to((temperature_degc - temperature_degc.mean(axis=0)).T, (size, outputs.shape[0]))
    covariance = np.zeros((size, ordinary.shape[0], ordinary.shape[0]))
    for place, own in enumerate(np.broadcast_to(estimator, (size, *estimator.shape[-2:]))):
        sensed = fitted[:, place] - fitted[:, place].mean()
        columns = np.column_stack([warmth[place], warmth[place] * sensed])
        slopes = _slopes(columns - form.basis @ form.solve(columns), left[:, place], columns)
        effects = own @ columns * slopes
        covariance[place] = effects @ effects.T
    return ComponentColumns(NAME, covariance, np.full(size, np.inf))


def _slopes(apart: FloatArray, left: FloatArray, columns: FloatArray) -> Sequence[float] | FloatArray:
    """Return the two slopes that (N, 2) columns, less what the model takes up of them, have in what is left."""
    gram, whole = apart.T @ apart, np.einsum("nc,nc->c", columns, columns)
    told = np.diag(gram) > _LEFT * whole
    slopes = np.zeros(columns.shape[1])
    if told.any():
        kept = np.flatnonzero(told)
        slopes[kept] = np.linalg.lstsq(gram[np.ix_(kept, kept)], (apart.T @ left)[kept], rcond=None)[0]
    return slopes
