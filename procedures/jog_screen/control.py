"""Who has a bench from a browser: one page at a time, and what it asks for moves while it answers.

The bench counts ticks, twenty a second; a page answers each with its number and with what is held on it. A lease lasts
from the tick that was answered, not from the answer: whatever the network, the server and their buffers do to it on the
way, a motion ends so long after the last moment at which its page was there. An order that took longer is refused.
"""

import math
from collections.abc import Mapping
from threading import Lock
from typing import Protocol

from procedures.jog_screen.lease import ANSWER_S, PAGE
from procedures.jog_screen.values import Asker, ClearStatistics, GoTo, Home, Request, Snapshot, Turn
from rig.clock import Clock

LATEST_S = ANSWER_S[PAGE]
"""An order that is older begins nothing."""
TICKS_KEPT = 64
SILENT_S = 5.0
"""A page that was not heard for so long has the bench no more; its motions ended long before."""
IDLE_S = 600.0
"""Nor has one on which nothing was asked for."""
LINGER_S = 30.0
"""So long the rig stays open for the next page, or for the same one when it was loaded again."""
Order = Mapping[str, object]


class Leases(Protocol):
    """What keeps motions alive (:class:`procedures.jog_screen.guard.Guard`)."""

    def answer(self, client: str, seen_s: float | None) -> None: ...
    def leave(self, client: str, why: str) -> None: ...
    def let_go(self, client: str, but: str = "") -> bool: ...


class Hands(Protocol):
    """What does it (:class:`procedures.jog_screen.worker.Bench`)."""

    @property
    def guard(self) -> Leases: ...
    def ask(self, request: Request, asker: Asker, seen_s: float | None) -> None: ...
    def stop(self, why: str, asker: Asker) -> None: ...
    def refuse(self, why: str, asker: Asker) -> None: ...
    def note(self, kind: str, text: str, asker: Asker) -> None: ...


class Control:
    """One thread hears the pages, another one counts the ticks."""

    def __init__(self, hands: Hands, clock: Clock) -> None:
        self._hands = hands
        self._clock = clock
        self._lock = Lock()
        self._ticks: dict[int, float] = {}
        """When each of the latest went out."""
        self._last_tick = 0
        self.holder: Asker | None = None
        self._heard_s = self._requested_s = self._free_s = clock.boottime_s()
        self._press: int | None = None
        """The newest press of a button of the holder; None before its first beat: what was pressed then counts not."""
        self.is_over = False
        """Whether the rig can be given back."""

    def tick(self) -> int:
        """Return the number of a new question to the page."""
        self._last_tick += 1
        self._ticks[self._last_tick] = self._clock.boottime_s()
        self._ticks.pop(self._last_tick - TICKS_KEPT, None)
        return self._last_tick

    def look(self) -> None:
        """Take the bench from a page that is gone or idle, and end when nobody has it."""
        with self._lock:
            now_s, holder = self._clock.boottime_s(), self.holder
            if holder is None:
                self.is_over = self.is_over or now_s - self._free_s > LINGER_S
            elif now_s - self._heard_s > SILENT_S:
                self._lose(holder, f"its page was not heard for {SILENT_S:g} s")
            elif now_s - self._requested_s > IDLE_S:
                self._lose(holder, f"nothing was asked for in {IDLE_S / 60.0:g} minutes")

    def hear(self, order: Order, asker: Asker) -> None:
        """Take what a page says. A stop is taken from every page, before anything else."""
        if order.get("say") == "stop":
            self._hands.stop(f"{asker.name} pressed stop", asker)
            return
        with self._lock:
            if order.get("say") == "take":
                self._take(asker)
            elif self._has(asker):
                self._hear_holder(order, asker)
            elif order.get("say") == "do":
                whose = self.holder.name if self.holder else "nobody"
                self._hands.refuse(f"{asker.name} does not have the bench, {whose} has it; nothing moved", asker)

    def _hear_holder(self, order: Order, asker: Asker) -> None:
        match order.get("say"):
            case "beat":
                self._beat(order, asker)
            case "do":
                self._do(order, asker)
            case "give":
                self._lose(asker, "given back")
                self.is_over = True
            case "gone":
                self._lose(asker, "its page was closed, or is cut off")

    def _has(self, asker: Asker) -> bool:
        return self.holder is not None and self.holder.client == asker.client

    def _take(self, asker: Asker) -> None:
        if self._has(asker):
            return
        if self.holder is not None:
            self._hands.refuse(f"{asker.name} asks for the bench; {self.holder.name} has it", asker)
            return
        self.holder, self.is_over = asker, False
        self._heard_s = self._requested_s = self._clock.boottime_s()
        self._press = None
        self._hands.note("take", f"{asker.name} has the bench", asker)

    def _lose(self, asker: Asker, why: str) -> None:
        self._hands.guard.leave(asker.client, why)
        self.holder, self._free_s = None, self._clock.boottime_s()
        self._hands.note("give", f"{asker.name} has the bench no more: {why}", asker)

    def _beat(self, order: Order, asker: Asker) -> None:
        """Renew what moves by the page, begin what was pressed since, end what was let go."""
        self._heard_s = self._clock.boottime_s()
        seen_s, press, held = self._moment_of(order), _whole(order.get("press")), order.get("held")
        if self._press is not None and press < self._press:
            return  # it was on the way for longer than one that came before it
        is_new, self._press = self._press is not None and press > self._press, press
        if order.get("away"):
            self._hands.guard.leave(asker.client, "the page was left")
            return
        axis = str(held.get("axis", "")) if isinstance(held, Mapping) else ""
        has_let_go = self._hands.guard.let_go(asker.client, "" if is_new else axis)
        if seen_s is None:
            return
        self._hands.guard.answer(asker.client, seen_s)
        if is_new and isinstance(held, Mapping) and not has_let_go and self._is_fresh(seen_s, asker):
            self._ask(Turn(axis, _number(held.get("rate_dps")), is_held=True), asker, seen_s)

    def _do(self, order: Order, asker: Asker) -> None:
        self._heard_s = self._clock.boottime_s()
        seen_s = self._moment_of(order)
        if seen_s is None or not self._is_fresh(seen_s, asker):
            return
        axis, degrees = str(order.get("axis")), _number(order.get("degrees"))
        match order.get("act"):
            case "step":
                self._ask(GoTo(axis, degrees, is_step=True), asker, seen_s)
            case "goto":
                self._ask(GoTo(axis, degrees), asker, seen_s)
            case "home":
                self._ask(Home(axis), asker, seen_s)
            case "snapshot":
                self._ask(Snapshot(), asker, seen_s)
            case "clear":
                self._ask(ClearStatistics(), asker, seen_s)
            case _:
                self._hands.refuse("an order that is none; nothing moved", asker)

    def _ask(self, request: Request, asker: Asker, seen_s: float) -> None:
        self._requested_s = self._clock.boottime_s()
        self._hands.ask(request, asker, seen_s)

    def _moment_of(self, order: Order) -> float | None:
        """Return when the page was there; None for a tick that never was, or was long ago."""
        return self._ticks.get(_whole(order.get("tick")))

    def _is_fresh(self, seen_s: float, asker: Asker) -> bool:
        late_s = self._clock.boottime_s() - seen_s
        if late_s > LATEST_S:
            text = f"the order of {asker.name} came {late_s:.1f} s late, allowed are {LATEST_S:g} s; nothing moved"
            self._hands.refuse(text, asker)
        return late_s <= LATEST_S


def _whole(value: object) -> int:
    return value if isinstance(value, int) else 0


def _number(value: object) -> float:
    """Return a number; what is none becomes one that every axis refuses."""
    try:
        return float(value) if isinstance(value, int | float) else math.nan
    except OverflowError:  # JSON bounds no whole number
        return math.nan
