"""What the supervisor needs of whoever stops the axes when this process cannot."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from rig.errors import RigError


class Warden(Protocol):
    """Who stops the axes when this process cannot: the stop guard."""

    def expect_motion(self, moving: Sequence[str], ways: Mapping[str, tuple[int, int]]) -> None:
        """Before anything is told to move. ``ways``: of :class:`AimedStop`, by axis, where they are known."""

    def beat(self, moving: Sequence[str], silence_s: float) -> None:
        """Give a sign of life, and say what is not known to stand, and how long a silence would be too long."""

    def stop_now(self) -> bool:
        """Have every axis stopped by somebody else, without memory; False where nobody hears it."""

    def take_trouble(self) -> RigError | None:
        """Return why nothing may move on, once."""

    def why_stop(self) -> str:
        """Return the same as a text, as far as it is known now; empty where nothing is. It stays to be taken."""
