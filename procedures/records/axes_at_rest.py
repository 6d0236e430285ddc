"""What people are told of the axes of a run that stands still."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType


def axes_in_words(
    positions_deg: Mapping[str, float],
    failures: Sequence[str],
    in_doubt: Sequence[str] = (),
    unknown: Mapping[str, str] = MappingProxyType({}),
) -> str:
    """Return whether every axis was seen to stand, and where, degrees; what failed stands in the reason of the stop.

    ``in_doubt``: orders that no machine answered, a sentence each. ``unknown``: axis to why nobody knows where it is.
    """
    if failures:
        return "Not every axis was seen to stand: go and look before anything else."
    stood = ", ".join(f"{name} at {degrees:.4f}°" for name, degrees in positions_deg.items() if name not in unknown)
    unseen = "".join(f"; {name}: {why}" for name, why in unknown.items())
    every = "Every other axis" if unknown else "Every axis"
    stands = f"{every} was told to stop and seen to stand{f': {stood}' if stood else ''}"
    seen = f"{stands if stood or not unknown else 'Every axis was told to stop'}{unseen}; the run moved nothing since"
    in_reserve = "but an order that no machine answered may still come: go and look before hands go in"
    return f"{seen}, {in_reserve}." if in_doubt else f"{seen}."
