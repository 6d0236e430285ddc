"""What a linear drift inside the replications leaves in the parameters.

A drift of one volt over a replication, none in its middle, is fitted by least squares as if it were the sensor: what
the parameters take of it is their bias, order by order. Forward-reverse visits every attitude at two times that are
symmetric about the middle, and leaves nothing.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ams.models.model import Model
from procedures.description.procedure_file import Order
from procedures.plan.designs import Design, DesignPoint
from procedures.plan.order import sequence, visits
from procedures.plan.specific_force import columns_of

COMPARED: tuple[Order, ...] = ("there-and-back", "forward-reverse", "neighbours", "serpentine", "raster")
"""Orders whose travel is short; of those by chance one draw stands for all."""
TIME_CONFOUNDED = 0.5
"""Correlation of time with a term of the model from which on a drift is said to pass for it."""
_SEED = 0


def drift_bias(model: Model, design: Design, nominal_v_per_g: float) -> dict[str, Mapping[str, float]]:
    """Return order to primary parameter to its bias, in its unit, by a drift of one volt over a replication.

    ``design``: with one point an attitude.
    """
    return {order: _bias(model, design, order, nominal_v_per_g) for order in COMPARED}


def _bias(model: Model, design: Design, order: Order, nominal_v_per_g: float) -> Mapping[str, float]:
    points = sequence(visits(design, order), order, np.random.default_rng([_SEED, 1]))
    drift_v = (np.arange(len(points)) + 0.5) / len(points) - 0.5
    found = np.linalg.lstsq(columns_of(model, points, nominal_v_per_g), drift_v, rcond=None)[0]
    return dict(zip(model.primary_names, found.tolist(), strict=True))


def time_correlation(model: Model, points: Sequence[DesignPoint], nominal_v_per_g: float) -> float:
    """Return the largest correlation, without sign, of time with a term of the model, in the order of ``points``.

    Near 1, a drift passes for a parameter.
    """
    terms = columns_of(model, points, nominal_v_per_g)
    time = np.arange(len(points)) - (len(points) - 1) / 2.0
    varying = terms - terms.mean(axis=0)
    length = np.linalg.norm(varying, axis=0)
    kept = length > 1e-9 * length.max()
    with_time = np.abs(time @ varying[:, kept]) / (np.linalg.norm(time) * length[kept])
    return float(with_time.max(initial=0.0))
