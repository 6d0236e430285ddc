"""A line whose listener is seen to be at work: an engine that waits for an answer does not hang."""

from collections.abc import Callable

from rig.clock import Clock
from rig.link.byte_stream import ByteStream

SignOfLife = Callable[[], None]
LISTENING_S = 0.5
"""Between two signs of life while an answer is awaited, at most."""


class LivelyStream:
    """A :class:`rig.link.byte_stream.ByteStream` over another one, with a sign of life at every wait."""

    def __init__(self, stream: ByteStream, sign_of_life: SignOfLife) -> None:
        self.name = stream.name
        self.clock: Clock = stream.clock
        self._stream = stream
        self._sign_of_life = sign_of_life
        self.write = stream.write
        self.discard_input = stream.discard_input
        self.close = stream.close

    def read(self, deadline_s: float) -> bytes:
        """As of the line."""
        while True:
            self._sign_of_life()
            until_s = min(deadline_s, self.clock.monotonic_s() + LISTENING_S)
            data = self._stream.read(until_s)
            if data or until_s >= deadline_s:
                return data
