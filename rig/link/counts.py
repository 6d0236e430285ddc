"""What happened on one line so far, counted by whoever converses over it: the measure of a link that degrades."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ParamSpec, TypeVar

from rig.clock import Clock
from rig.errors import LinkClosed, LinkLost
from rig.link.byte_stream import ByteStream

Arguments = ParamSpec("Arguments")
Answer = TypeVar("Answer")


@dataclass(slots=True)
class ExchangeCounts:
    """Since the line was opened."""

    questions: int = 0
    repeated: int = 0
    silent: int = 0
    nonsense: int = 0
    stale_bytes: int = 0

    @property
    def errors(self) -> int:
        """Questions without a good answer, whether they were asked again or not."""
        return self.silent + self.nonsense


class CountedStream:
    """A line that carries the counts of the conversation over it, for whoever watches all lines of a rig.

    Several devices on one line each have counts of their own: one that fails shows, and the others do not hide it.
    """

    def __init__(self, stream: ByteStream) -> None:
        self.name = stream.name
        self.clock: Clock = stream.clock
        self.counts = ExchangeCounts()
        self.slaves: dict[str, ExchangeCounts] = {}
        """By what tells them apart on the line, such as ``unit 2``; empty where nothing has to."""
        self.is_lost = False
        """It was found to be gone or closed; to open it again is to open another stream."""
        self.write = self._heeding_loss(stream.write)
        self.read = self._heeding_loss(stream.read)
        self.discard_input = self._heeding_loss(stream.discard_input)
        self.close = stream.close

    def _heeding_loss(self, call: Callable[Arguments, Answer]) -> Callable[Arguments, Answer]:
        def heeded(*args: Arguments.args, **names: Arguments.kwargs) -> Answer:
            try:
                return call(*args, **names)
            except (LinkLost, LinkClosed):
                self.is_lost = True
                raise

        return heeded

    def by_slave(self, name: str) -> dict[str, ExchangeCounts]:
        """Return the counts by device.

        A device is called ``name`` and its own where it is one of several; a single device is the line.
        """
        if len(self.slaves) <= 1 and not self.counts.questions:
            return {name: next(iter(self.slaves.values()), self.counts)}
        line = {name: self.counts} if self.counts.questions or not self.slaves else {}
        return line | {f"{name}, {slave}": counts for slave, counts in self.slaves.items()}


def counts_of(stream: ByteStream, slave: str = "") -> ExchangeCounts:
    """Return the counts of the line, or of one device of several on it, where it carries some, else new ones."""
    if not isinstance(stream, CountedStream):
        return ExchangeCounts()
    return stream.slaves.setdefault(slave, ExchangeCounts()) if slave else stream.counts
