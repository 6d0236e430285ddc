"""The terms of second and third order of a gyro, in its rate along the nominal axis: K₂ω_i² and K₃ω_i³.

They are the nonlinearity of its scale factor (IEEE Std 528): how far the output lies from the straight line that comes
closest to it. As those of accelerometers (:mod:`ams.models.extended`) they stand in the equation without their best
linear approximation over the design, so that offset and sensitivities are those of that straight line, which is what
the standard calls the scale factor, and keep their intervals.
"""

from typing import Final

import numpy as np

from ams.arrays import Centring, FloatArray
from ams.models.extended import TERM_NAMES, linear_part
from ams.models.leverage import LEAST_LEVER, least_lever
from ams.models.sensor_model import LowOrder
from ams.remembered import remembered

RATE_TERM_NAMES: Final = ("k2_v_per_dps2", "k3_v_per_dps3")
LOW_ORDER_NAMES: Final = (*TERM_NAMES, *RATE_TERM_NAMES)
"""Of every sensor: they stand behind offset and sensitivities, and pages have them apart."""
_LEAST_LEFT: Final = 4
"""Points that must be left over: two replications are held to no less than the noise inside them with so many."""
_EXCITED: Final = 1e-3
"""Of its length: what is left of a term across the linear sensor and the term before it. The Earth's rotation beside a
table's rate of a few °/s, and what a servo holds a rate to, excite no term."""

_RATES: Final = 41


def rate_term_basis(velocity_dps: FloatArray, nominal_axis: str) -> FloatArray:
    """Return the (…, 2) terms at the (…, 3) angular velocity, in the order of ``RATE_TERM_NAMES``."""
    along = velocity_dps[..., "xyz".index(nominal_axis)]
    return np.stack([along**2, along**3], axis=-1)


@remembered(16)
def rate_centring_over(velocity_dps: FloatArray, points: int, nominal_axis: str) -> Centring | None:
    """Return the best linear approximations of the terms over the (N, 3) rows: of both, or of the square alone.

    None where the points do not determine the square beside the linear sensor and leave something over, or have the
    terms by chance alone (:mod:`ams.models.leverage`): at two rates that a servo does not hold exactly.
    """
    linear, terms = linear_part(velocity_dps), rate_term_basis(velocity_dps, nominal_axis)
    length = np.linalg.norm(linear, axis=0)
    q, r = np.linalg.qr(linear / np.where(length > 0.0, length, 1.0))
    if not length.all() or np.abs(np.diag(r)).min() < _EXCITED:
        return None
    rows = (np.linalg.solve(r, q.T @ terms) / length[:, None]).T
    span = np.linalg.norm(terms, axis=0)
    left = (terms - linear @ rows.T) / np.where(span > 0.0, span, 1.0)
    for count in (2, 1):
        smallest = float(np.linalg.svd(left[:, :count], compute_uv=False)[-1])
        has_rows_left = points >= linear.shape[1] + count + _LEAST_LEFT
        if has_rows_left and smallest > _EXCITED and _lever(velocity_dps, nominal_axis, rows[:count]) > LEAST_LEVER:
            return tuple((float(a), float(b), float(c), float(d)) for a, b, c, d in rows[:count])
    return None


def _lever(velocity_dps: FloatArray, nominal_axis: str, rows: FloatArray) -> float:
    """Return how much of the terms there is at (N, 3) rates, of what there is of them between these."""
    index, centring = "xyz".index(nominal_axis), tuple(map(tuple, rows.tolist()))
    between = np.zeros((_RATES, 3))
    between[:, index] = np.linspace(velocity_dps[:, index].min(), velocity_dps[:, index].max(), _RATES)
    at_points, within = (centred_rate_terms(where, nominal_axis, centring) for where in (velocity_dps, between))
    return least_lever(at_points, within)


def centred_rate_terms(velocity_dps: FloatArray, nominal_axis: str, centring: Centring) -> FloatArray:
    """Return the (…, t) terms less what ``centring`` takes off them: as many as it has rows."""
    terms = rate_term_basis(velocity_dps, nominal_axis)[..., : len(centring)]
    return np.asarray(terms - linear_part(velocity_dps) @ np.array(centring).T)


def slope_of_rate_terms(
    coefficients: FloatArray, velocity_dps: FloatArray, nominal_axis: str, centring: Centring
) -> FloatArray:
    """Return the (…, 3) derivatives of the centred terms' sum by the components of the (…, 3) angular velocity."""
    index = "xyz".index(nominal_axis)
    slope = np.broadcast_to(-coefficients @ np.array(centring)[:, 1:], velocity_dps.shape).copy()
    powers = np.arange(2, 2 + len(centring))
    slope[..., index] += (coefficients * powers * velocity_dps[..., index, None] ** (powers - 1)).sum(axis=-1)
    return slope


RATE_TERMS: Final = LowOrder(
    names=RATE_TERM_NAMES,
    basis=rate_term_basis,
    c=lambda axis: tuple("(" + " * ".join([f"f[{'xyz'.index(axis)}]"] * power) + ")" for power in (2, 3)),
)
"""How a set has them."""
