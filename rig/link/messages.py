"""One instrument that talks in messages, wherever it hangs: on a line of its own (a LAN socket) or on a GPIB bus."""

from collections.abc import Callable
from typing import Protocol, TypeVar

from rig.clock import Clock
from rig.link.byte_stream import ByteStream
from rig.link.exchange import Exchange, Patience
from rig.link.gpib import GpibBus

Reply = TypeVar("Reply")

TALK_TIMEOUT_S = 3.5
PATIENCE = Patience(timeout_s=TALK_TIMEOUT_S, quiet_s=0.2)


class MessageLine(Protocol):
    """Messages to one instrument and its answers.

    Every method raises LinkLost when the port broke and LinkClosed when we closed it.
    """

    name: str
    clock: Clock
    """Time-outs are in this clock's seconds."""

    def tell(self, message: bytes) -> None:
        """Send what has no answer."""

    def ask(
        self, message: bytes, parse: Callable[[bytes], Reply], *, idempotent: bool, timeout_s: float = TALK_TIMEOUT_S
    ) -> Reply:
        """Send ``message`` and return what ``parse`` makes of the answer. Raises: DeviceSilent, DeviceNonsense."""

    def hear(self, message: bytes, parse: Callable[[bytes], Reply], *, timeout_s: float = TALK_TIMEOUT_S) -> Reply:
        """Return what ``parse`` makes of the answer to ``message``, which was told before: it takes its time.

        Never repeated. Raises: DeviceSilent, DeviceNonsense.
        """

    def clear(self) -> None:
        """End the conversation that is under way: what it still owes is not taken for the next answer."""


class StreamMessages:
    """A :class:`MessageLine` on a byte stream of its own; messages end with a line feed."""

    def __init__(self, stream: ByteStream, patience: Patience = PATIENCE) -> None:
        self.name = stream.name
        self.clock = stream.clock
        self.exchange = Exchange(stream, terminator=b"\n", patience=patience)

    def tell(self, message: bytes) -> None:
        self.exchange.tell(message + b"\n")

    def ask(
        self, message: bytes, parse: Callable[[bytes], Reply], *, idempotent: bool, timeout_s: float = TALK_TIMEOUT_S
    ) -> Reply:
        return self.exchange.ask(
            message + b"\n", lambda line: parse(line.removesuffix(b"\r")), idempotent=idempotent, timeout_s=timeout_s
        )

    def hear(self, message: bytes, parse: Callable[[bytes], Reply], *, timeout_s: float = TALK_TIMEOUT_S) -> Reply:
        return self.exchange.hear(message, lambda line: parse(line.removesuffix(b"\r")), timeout_s)

    def clear(self) -> None:
        self.exchange.doubt()


class GpibMessages:
    """A :class:`MessageLine` to one address of a bus."""

    def __init__(self, bus: GpibBus, address: int) -> None:
        self.name = f"{bus.name} address {address}"
        self.clock = bus.clock
        self._bus = bus
        self._address = address

    def tell(self, message: bytes) -> None:
        self._bus.send(self._address, message)

    def ask(
        self, message: bytes, parse: Callable[[bytes], Reply], *, idempotent: bool, timeout_s: float = TALK_TIMEOUT_S
    ) -> Reply:
        return self._bus.ask(self._address, message, parse, idempotent=idempotent, timeout_s=timeout_s)

    def hear(self, message: bytes, parse: Callable[[bytes], Reply], *, timeout_s: float = TALK_TIMEOUT_S) -> Reply:  # noqa: ARG002 the bus names the question
        return self._bus.read(self._address, parse, timeout_s=timeout_s)

    def clear(self) -> None:
        self._bus.clear(self._address)
