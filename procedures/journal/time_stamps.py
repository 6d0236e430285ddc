"""How far the time of change of a file or folder is to be believed."""

from typing import Final

SETTLED_NS: Final = 200_000_000
"""What changed more recently than this is read again: two changes may share one time stamp."""
