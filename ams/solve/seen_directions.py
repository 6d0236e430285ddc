"""Of several errors that turn a package, what a model leaves of them to be seen, and what it absorbs."""

from typing import Final

import numpy as np

from ams.arrays import FloatArray

_LEFT: Final = 0.01
"""Of the square of a pattern: of which a model leaves less, nothing is seen. Sensitivities absorb the seat of a lone
position but for the ten thousandth by which a temperature that scatters tells them apart, and that is no evidence."""


def seen_directions(information: FloatArray, whole: FloatArray) -> FloatArray:
    """Return (q, r) directions of q errors that are seen beside a model, each of unit information.

    ``information``: (q, q) products of what the model leaves of the patterns, over the variance of readings; ``whole``:
    (q,) squares of the patterns over the same. Errors may be of any size and unit: the share that is left decides.
    """
    length = np.sqrt(whole)
    per_length = np.divide(1.0, length, out=np.zeros_like(length), where=length > 0.0)
    values, vectors = np.linalg.eigh(information * np.multiply.outer(per_length, per_length))
    is_seen = values > _LEFT
    return np.asarray(per_length[:, None] * vectors[:, is_seen] / np.sqrt(values[is_seen]))
