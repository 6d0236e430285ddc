"""How long the engine reads a channel without a look at moving axes: the engine and its stop guard agree on it."""

from typing import Final

LONGEST_READING_S: Final = 120.0
"""The longest reading of a channel between two looks is shorter."""
