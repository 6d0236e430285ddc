"""What is known of the motion of every axis while nobody can look at it: the last look, and what was told since.

Kept over reconnections: when a line is lost, this is all there is to say until somebody stands before the machine.

An order is in doubt from the moment at which it is sent until the machine answers it, or is seen to have taken it up.
What was lost on its way and what is late on it look alike, and nothing that is sent behind it tells one from the other:
it may be carried past one that waits, by a line that does not keep their order or a controller that takes stops first.
Where a later order was answered, the one before is taken for lost after :data:`LATEST_S`; else it stays in doubt.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import datetime

from rig.local_time import at_both

LATEST_S = 60.0
"""What TCP sends again comes within this time though it is lost eight times in a row."""


@dataclass(frozen=True, slots=True)
class UnansweredOrder:
    """What may move an axis, and was neither acknowledged nor seen to be taken up."""

    order: str
    given_utc: datetime
    from_deg: float | None
    """Where the axis was read back last before it; None where it never was."""
    target_deg: float | None
    """Where it leads; None where it is no move to a place."""
    wanders_deg: float
    """By so much the read-back of an axis may change that took nothing up."""
    is_followed: bool = False
    """Whether a later order was answered."""

    def in_words(self) -> str:
        """Return the sentence, without its axis."""
        order = f"the order to {self.order} of {at_both(self.given_utc, to_the_second=True)}"
        return f"{order} was neither acknowledged nor seen to be taken up, and may still come"


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
    unanswered: tuple[UnansweredOrder, ...] = ()
    """Orders that it may carry out at any time; a stop ends none of them."""

    @property
    def in_doubt(self) -> tuple[UnansweredOrder, ...]:
        """Those that would move it: one to the place where it rests would not."""
        return tuple(
            order for order in self.unanswered if not (self.is_at_rest and self._is_at(order.target_deg, order))
        )

    def _is_at(self, attitude_deg: float | None, order: UnansweredOrder) -> bool:
        if attitude_deg is None or self.at_deg is None:
            return False
        return abs(self.at_deg - attitude_deg) <= order.wanders_deg

    def after_look(self, seen_utc: datetime, *, is_moving: bool) -> tuple[UnansweredOrder, ...]:
        """Return what of its orders is unanswered after a look that is noted here already."""

        def is_open(order: UnansweredOrder) -> bool:
            if order.is_followed:  # what moves it now is the later order
                return (seen_utc - order.given_utc).total_seconds() <= LATEST_S
            has_left = order.from_deg is not None and not self._is_at(order.from_deg, order)
            return not (is_moving or has_left)

        return tuple(filter(is_open, self.unanswered))

    @property
    def may_be_moved_by(self) -> str:
        """What may move it; empty where nothing may."""
        return self.order or " and ".join(order.order for order in self.in_doubt)

    def in_words(self, name: str) -> str:
        """Return the sentence for a person who has to decide whether to go and look."""
        return "; ".join((self._last_seen(name), *(order.in_words() for order in self.in_doubt)))

    def _last_seen(self, name: str) -> str:
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
        self._known[axis] = replace(self.known(axis), order=order, is_turn=is_turn, is_at_rest=False)

    def awaits_answer(self, axis: str, given_utc: datetime, target_deg: float | None, wanders_deg: float) -> None:
        """Note that the order which was noted last is on its way to the machine now; more of it as in the order."""
        before = self.known(axis)
        order = UnansweredOrder(before.order, given_utc, before.at_deg, target_deg, wanders_deg)
        self._known[axis] = replace(before, unanswered=(*before.unanswered, order))

    def answered(self, axis: str) -> None:
        """Note that the machine answered the last order."""
        before = self.known(axis)
        earlier = tuple(replace(order, is_followed=True) for order in before.unanswered[:-1])
        self._known[axis] = replace(before, unanswered=earlier)

    def withdrawn(self, axis: str) -> None:
        """Note that the last order was not sent after all."""
        before = self.known(axis)
        self._known[axis] = replace(before, unanswered=before.unanswered[:-1])

    def saw(self, axis: str, at_deg: float, seen_utc: datetime, *, is_at_rest: bool, is_moving: bool = False) -> None:
        """Note a look. ``is_moving``: by the word of the machine."""
        before = self.known(axis)
        order, is_turn = ("", False) if is_at_rest else (before.order, before.is_turn)
        now = KnownMotion(at_deg, seen_utc, is_at_rest, order, is_turn, before.unanswered)
        self._known[axis] = replace(now, unanswered=now.after_look(seen_utc, is_moving=is_moving))

    def known(self, axis: str) -> KnownMotion:
        return self._known.get(axis, KnownMotion())

    def in_words(self, axes: Iterable[str]) -> tuple[str, ...]:
        """Return a sentence for each axis."""
        return tuple(self.known(name).in_words(name) for name in axes)

    def in_doubt(self, axes: Iterable[str]) -> tuple[str, ...]:
        """Return a sentence for each order that may still move one of the axes, though it was never answered."""
        return tuple(f"{name}: {order.in_words()}" for name in axes for order in self.known(name).in_doubt)

    def waiting_settles(self, axes: Iterable[str]) -> bool:
        """Return whether one of these will be taken for lost after a time of looks."""
        return any(order.is_followed for name in axes for order in self.known(name).in_doubt)
