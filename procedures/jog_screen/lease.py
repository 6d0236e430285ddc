"""The lease under which an axis may turn: a living terminal and, where a key is held, a key that goes on repeating.

A terminal tells no release of a key, only its repeats; and a hung or lost terminal tells nothing at all. So a rate
lives from renewal to renewal, and whatever is lost (the key, the screen, the line to the terminal) ends it.
"""

from rig.clock import Clock

TERMINAL_S = 0.3
"""So long a terminal may leave a question unanswered; it is asked every tenth of a second."""
FIRST_REPEAT_S = 0.7
"""Keyboards wait so long before they repeat a key that is held."""
REPEAT_S = 0.25
"""From repeat to repeat."""


class RateLease:
    """``clock`` is the machine's: a lease is about people, whatever factor the rig's time has."""

    def __init__(self, clock: Clock, *, is_held: bool) -> None:
        now_s = clock.monotonic_s()
        self._clock = clock
        self._answered_until_s = now_s + TERMINAL_S
        self._pressed_until_s = now_s + FIRST_REPEAT_S if is_held else float("inf")
        self._is_held = is_held

    def answer(self) -> None:
        """Renew the lease: the terminal answered. A lease that is over stays over."""
        if not self.why_over():
            self._answered_until_s = self._clock.monotonic_s() + TERMINAL_S

    def press(self) -> None:
        """Renew a held lease: the key came again."""
        if self._is_held and not self.why_over():
            self._pressed_until_s = self._clock.monotonic_s() + REPEAT_S

    def why_over(self) -> str:
        """Empty while it lasts."""
        now_s = self._clock.monotonic_s()
        if now_s > self._answered_until_s:
            return f"the terminal did not answer for {TERMINAL_S:g} s"
        return "the key was released" if now_s > self._pressed_until_s else ""
