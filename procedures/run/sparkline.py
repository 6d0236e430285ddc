"""A small curve as the points of an SVG polyline: pure, and drawn without a plotting library at a bad moment."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

WIDTH, HEIGHT = 260.0, 44.0
ROUNDING = 1e-6
"""A relative span below this is a constant, drawn through the middle."""


@dataclass(frozen=True, slots=True)
class Sparkline:
    """One quantity over the last minutes."""

    name: str
    unit: str
    points: str
    """``x,y x,y …`` in a box of WIDTH by HEIGHT."""
    low: str
    high: str
    last: str


def sparkline(name: str, unit: str, minutes: Sequence[float], values: Sequence[float]) -> Sparkline:
    """Return values over minutes as a line; those that are not finite leave no point."""
    pairs = [(minute, value) for minute, value in zip(minutes, values, strict=True) if isfinite(value)]
    if not pairs:
        return Sparkline(name, unit, "", "–", "–", "–")
    first, low, high = pairs[0][0], min(value for _, value in pairs), max(value for _, value in pairs)
    wide, tall = (pairs[-1][0] - first) or 1.0, high - low
    is_flat = tall <= ROUNDING * max(abs(low), abs(high))
    heights = [0.5 if is_flat else (value - low) / tall for _, value in pairs]
    points = " ".join(
        f"{WIDTH * (minute - first) / wide:.1f},{HEIGHT * (1.0 - height):.1f}"
        for (minute, _), height in zip(pairs, heights, strict=True)
    )
    return Sparkline(name, unit, points, f"{low:.4g}", f"{high:.4g}", f"{pairs[-1][1]:.4g}")
