"""What happened on one line so far, counted by whoever converses over it: the measure of a link that degrades."""

from dataclasses import dataclass

from rig.clock import Clock
from rig.link.byte_stream import ByteStream


@dataclass(slots=True)
class ExchangeCounts:
    """Since the line was opened."""

    asked: int = 0
    repeated: int = 0
    silent: int = 0
    nonsense: int = 0
    stale_bytes: int = 0

    @property
    def errors(self) -> int:
        """Questions without a good answer, whether they were asked again or not."""
        return self.silent + self.nonsense


class CountedStream:
    """A line that carries the counts of the conversation over it, for whoever watches all lines of a rig."""

    def __init__(self, stream: ByteStream) -> None:
        self.name = stream.name
        self.clock: Clock = stream.clock
        self.counts = ExchangeCounts()
        self.write = stream.write
        self.read = stream.read
        self.discard_input = stream.discard_input
        self.close = stream.close


def counts_of(stream: ByteStream) -> ExchangeCounts:
    """Those of the line where it carries some, else new ones."""
    return stream.counts if isinstance(stream, CountedStream) else ExchangeCounts()
