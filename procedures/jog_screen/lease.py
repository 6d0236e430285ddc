"""The lease under which something may move: who asked for it is there and, where a key is held, it goes on repeating.

A terminal tells no release of a key, only its repeats; a page tells it, as long as anybody hears the page; and what is
hung or cut off tells nothing at all. So a motion lives from renewal to renewal, and whatever is lost (the key, the
screen, the page, the line to either) ends it. The time is that of the machine with its sleep: a lease ends in it.
"""

from rig.clock import Clock

TERMINAL, PAGE = "the terminal", "the page"
ANSWER_S = {TERMINAL: 0.3, PAGE: 0.25}
"""So long who asked may leave a question unanswered; a terminal is asked ten times a second, a page twenty times."""
FIRST_REPEAT_S = 0.7
"""Keyboards wait so long before they repeat a key that is held."""
REPEAT_S = 0.25
"""From repeat to repeat."""


class MotionLease:
    """``clock`` is the machine's: a lease is about people, whatever factor the rig's time has.

    ``seen_s``: the latest moment of which is known that who asked was there; None is now.
    """

    def __init__(self, clock: Clock, *, is_held: bool, whose: str = TERMINAL, seen_s: float | None = None) -> None:
        now_s = clock.boottime_s()
        self._clock = clock
        self._whose = whose
        self._patience_s = ANSWER_S[whose]
        self._answered_until_s = (now_s if seen_s is None else seen_s) + self._patience_s
        self._pressed_until_s = now_s + FIRST_REPEAT_S if is_held else float("inf")
        self._is_held = is_held
        self._ended = ""

    def answer(self, seen_s: float | None = None) -> None:
        """Renew the lease: who asked was there at that moment, or is now. A lease that is over stays over."""
        if not self.why_over():
            # What waited in buffers counts from its question, not from its arrival, and may come after a newer one.
            seen_s = self._clock.boottime_s() if seen_s is None else seen_s
            self._answered_until_s = max(self._answered_until_s, seen_s + self._patience_s)

    def press(self) -> None:
        """Renew a held lease: the key came again."""
        if self._is_held and not self.why_over():
            self._pressed_until_s = self._clock.boottime_s() + REPEAT_S

    def end(self, why: str) -> None:
        """End it before its time."""
        self._ended = self.why_over() or why

    def why_over(self) -> str:
        """Empty while it lasts."""
        now_s = self._clock.boottime_s()
        if self._ended:
            return self._ended
        if now_s > self._answered_until_s:
            return f"{self._whose} did not answer for {self._patience_s:g} s"
        return "the key was released" if now_s > self._pressed_until_s else ""
