"""Half-widths of angles that are told because they lie beyond a bound.

Beside a singular attitude an angle is told where it was read beyond a bound, and chance carries some rows over it. It
is the error of the angle itself that carried them: of the rows told, 1.96 standard deviations hold 84 % where the
attitude lies one standard deviation before the bound, and none where it lies two before it. The half-width just beyond
is therefore that of a normal distribution cut off at the bound: of the rows told it holds 95 % wherever the attitude
lies. From the bound to 4.5 standard deviations beyond it holds up to 97.5 %: readings that fall short are withheld, and
a half-width that reaches inwards reaches as far outwards. Distances are in standard deviations of what was
read; a row before the bound (less than 0) keeps its own.

Source: Lee, Sun, Sun, Taylor, Exact post-selection inference, Annals of Statistics 44 (2016), the truncated pivot.
"""

from functools import cache
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.statistics.distributions import normal_quantile, normal_share

_BOTH_SIDES: Final = 1.959964
_ONE_SIDE: Final = 0.05
"""Beyond this tail above nothing misses below as well: half-widths next to the bound reach far beyond it."""
_ONE_OF_TWO: Final = 0.025
_FURTHEST_SD: Final = 12.0
"""Before the bound: from further in no row is told."""
_LARGEST_FACTOR: Final = 1.3
"""Where the median lies at the singular attitude itself the factor has no bound; with this one the simulated rows of
docs/studies/attitude.md hold 93.7 % and more.
"""


def factor_along(beyond_sd: FloatArray, share: FloatArray | float = 1.0) -> FloatArray:
    """Return what to widen an interval by that was read ``beyond_sd`` beyond a bound along its own angle.

    ``share`` is how much of the standard deviation of the angle lies along the distance from the bound, 0 to 1.
    """
    return _shared(np.maximum(_reach(beyond_sd, _ONE_SIDE) / _BOTH_SIDES, 1.0), share)


def factor_of_root(beyond_sd: FloatArray, share: FloatArray | float = 1.0) -> FloatArray:
    """Return the same where the angle goes with the root of what was read: it is the steeper towards the bound."""
    return _shared(np.maximum(_reach(beyond_sd, _ONE_OF_TWO) / _BOTH_SIDES, 1.0), share)


def factor_across(distance_sd: FloatArray, beyond_sd: FloatArray) -> FloatArray:
    """Return what to widen the interval of an angle about the singular attitude by, ``distance_sd`` away from it.

    Its standard deviation is one over the distance, and rows that chance carried over the bound lie nearer than they
    were read: by the median of the normal distribution cut off at the bound.
    """
    carried = np.maximum(_reach(beyond_sd, 0.5), 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.sqrt(distance_sd / (distance_sd - carried))
    return np.where(carried < distance_sd, np.minimum(factor, _LARGEST_FACTOR), _LARGEST_FACTOR)


def along_distance(covariance: FloatArray, slopes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the standard deviation of a distance, (n,), and the share that errors of s angles have in it, (n, s).

    ``covariance`` is (n, s, s) of the angles, ``slopes`` (n, s) of the distance by these.
    """
    common = np.einsum("nst,nt->ns", covariance, slopes)
    with np.errstate(divide="ignore", invalid="ignore"):
        sd = np.sqrt(np.einsum("ns,ns->n", slopes, common))
        share = np.abs(common) / (sd[:, None] * np.sqrt(np.einsum("nss->ns", covariance)))
    return sd, np.minimum(np.nan_to_num(share), 1.0)


def _shared(factor: FloatArray, share: FloatArray | float) -> FloatArray:
    return np.asarray(np.sqrt(1.0 + np.square(share) * (np.square(factor) - 1.0)))


def _reach(beyond_sd: FloatArray, tail: float) -> FloatArray:
    """Return how far below what was read an attitude lies of which so much of what is told is read further out."""
    beyond, reach_by_beyond = _table(tail)
    # Next to the bound the tail falls as an exponential: the reach goes with one over the distance beyond.
    near = np.maximum(beyond_sd, beyond[0])
    return np.where(beyond_sd < 0.0, 0.0, np.interp(near, beyond, reach_by_beyond) / near)


@cache
def _table(tail: float) -> tuple[FloatArray, FloatArray]:
    """Return distances beyond the bound, and the reach times these."""
    before_bound = np.linspace(_FURTHEST_SD, -_FURTHEST_SD, 2401)
    reach = -normal_quantile(tail * normal_share(-before_bound))
    beyond = reach - before_bound
    return beyond, reach * beyond
