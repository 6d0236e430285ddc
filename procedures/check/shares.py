"""What takes how much of U95, in words."""

import math
from collections.abc import Mapping
from typing import Final

from ams.analysis.angle_uncertainty import ADDED
from ams.units import ARCSEC_PER_DEG

LOW_ORDER = "low-order terms"
LOW_ORDER_MEANS = (
    f"{LOW_ORDER}: what the terms of second and third order add, since a table that is off once or twice a turn and a "
    "sensor that bends look alike"
)
_SMALL: Final = 0.01
"""Of the square of U95: the least sources whose squares add up to less are told together."""


def shares_in_words(shares_deg: Mapping[str, float]) -> str:
    """Return each source with what it takes, arc seconds, the largest first, and what is left as ``all others``."""
    large, others_deg = large_and_others(shares_deg)
    return with_others(large, others_deg)


def large_and_others(shares_deg: Mapping[str, float]) -> tuple[str, float]:
    """Return the large sources in words, and what the small ones take together, degrees; 0 where none is small."""
    ordered = sorted(shares_deg.items(), key=lambda item: -abs(item[1]))
    squares = [math.copysign(share**2, share) for _, share in ordered]
    count, whole = len(ordered), sum(squares)
    while count and sum(map(abs, squares[count - 1 :])) < _SMALL * whole:
        count -= 1
    if len(ordered) - count == 1:
        count = len(ordered)
    words = [f"{LOW_ORDER if source == ADDED else source} {_arcsec(share)}" for source, share in ordered[:count]]
    return ", ".join(words), math.sqrt(abs(sum(squares[count:])))


def with_others(large: str, others_deg: float) -> str:
    """Return the large sources with what the small ones take together."""
    return f"{large}, all others {_arcsec(others_deg)}" if others_deg else large


def _arcsec(share_deg: float) -> str:
    return f"{share_deg * ARCSEC_PER_DEG:.2g}"


def explained(shares_deg: Mapping[str, float]) -> list[str]:
    """Return what a word of the shares means, where it stands among them."""
    return [LOW_ORDER_MEANS] if ADDED in shares_deg else []
