"""What a covariance of few degrees of freedom lacks beside that of noise: it sees nothing in most directions."""

import numpy as np

from ams.arrays import FloatArray


def short_of(covariance: FloatArray, root: FloatArray, least: FloatArray) -> FloatArray:
    """Return (…, P, P) what covariances lack in every direction where they are less than ``least`` times that of noise.

    ``root``: (…, P, P) of the covariance of noise, lower triangular. ``least``: (…).
    """
    inverse = np.linalg.inv(root)
    seen, directions = np.linalg.eigh(inverse @ covariance @ np.swapaxes(inverse, -1, -2))
    turned = root @ directions
    short = np.maximum(least[..., None] - seen, 0.0)
    return np.asarray((turned * short[..., None, :]) @ np.swapaxes(turned, -1, -2))
