"""What people are told of the axes of a run that stands still."""

from collections.abc import Mapping, Sequence


def axes_in_words(positions_deg: Mapping[str, float], failures: Sequence[str]) -> str:
    """Return whether every axis was seen to stand, and where, degrees; what failed stands in the reason of the stop."""
    if failures:
        return "Not every axis was seen to stand: go and look before anything else."
    stood = ", ".join(f"{name} at {degrees:.4f}°" for name, degrees in positions_deg.items())
    return f"Every axis was told to stop and seen to stand{f': {stood}' if stood else ''}; the run moved nothing since."
