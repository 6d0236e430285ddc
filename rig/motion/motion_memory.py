"""What is known of the motion of every axis while nobody can look at it: the last look, and what was told since.

Kept over reconnections: when a line is lost, this is all there is to say until somebody stands before the machine.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import datetime

from rig.local_time import at_both


@dataclass(frozen=True, slots=True)
class KnownMotion:
    """Of one axis."""

    at_deg: float | None = None
    """Read back at the last look; None before the first."""
    seen_utc: datetime | None = None
    is_at_rest: bool = False
    """Whether it was seen there at rest, as it was to be."""
    order: str = ""
    """What may move it and was sent since it was last seen at rest; empty where nothing was."""
    is_turn: bool = False
    """Whether that leads it on and on, at a rate."""

    def in_words(self, name: str) -> str:
        """Return the sentence for a person who has to decide whether to go and look."""
        if self.at_deg is None or self.seen_utc is None:
            sent = f"; it was told to {self.order}" if self.order else ", and nothing that moves it was sent"
            return f"{name} has not been read since the rig was opened{sent}"
        read_back = f"{self.at_deg:.4f}°, {at_both(self.seen_utc, to_the_second=True)}"
        if self.is_at_rest:
            return f"{name} was last read at rest at {read_back}, and nothing that moves it was sent since"
        sent = f"it was told to {self.order}, and " if self.order else ""
        return f"whether {name} stands is not known: {sent}its last read-back is {read_back}"


class MotionMemory:
    """Of the axes of one rig. Told by the supervisor, read by whoever has to say what is known."""

    def __init__(self) -> None:
        self._known: dict[str, KnownMotion] = {}

    def sent(self, axis: str, order: str, *, is_turn: bool = False) -> None:
        """Note an order that may move the axis, before it is sent."""
        before = self._known.get(axis, KnownMotion())
        self._known[axis] = replace(before, order=order, is_turn=is_turn, is_at_rest=False)

    def saw(self, axis: str, at_deg: float, seen_utc: datetime, *, is_at_rest: bool) -> None:
        """Note a look."""
        before = KnownMotion() if is_at_rest else self._known.get(axis, KnownMotion())
        self._known[axis] = KnownMotion(at_deg, seen_utc, is_at_rest, before.order, before.is_turn)

    def known(self, axis: str) -> KnownMotion:
        return self._known.get(axis, KnownMotion())

    def in_words(self, axes: Iterable[str]) -> tuple[str, ...]:
        """Return a sentence for each axis."""
        return tuple(self.known(name).in_words(name) for name in axes)
