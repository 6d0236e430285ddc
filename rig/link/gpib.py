"""The GPIB bus as drivers see it, whatever carries it: a Prologix adapter or a VISA library."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol, TypeVar

from rig.clock import Clock
from rig.errors import RequestRefused

Reply = TypeVar("Reply")

RESOURCE_FORMS = "twin, prologix+socket://host:port#address, prologix+/dev/…#address, visa:GPIB0::22::INSTR"


class GpibBus(Protocol):
    """One controller, many instruments by primary address. Not shared between threads or processes.

    Every method raises LinkLost when the port broke and LinkClosed when we closed it.
    """

    name: str
    clock: Clock
    """Time-outs are in this clock's seconds."""

    def send(self, address: int, message: bytes) -> None:
        """Make the instrument listen to ``message``."""

    def ask(
        self, address: int, message: bytes, parse: Callable[[bytes], Reply], *, idempotent: bool, timeout_s: float = 3.5
    ) -> Reply:
        """Send ``message``, make the instrument talk once, return what ``parse`` makes of its line.

        Raises: DeviceSilent, DeviceNonsense.
        """

    def read(self, address: int, parse: Callable[[bytes], Reply], *, timeout_s: float = 3.5) -> Reply:
        """Make the instrument talk once; never repeated, since it would eat a reading.

        Raises: DeviceSilent, DeviceNonsense.
        """

    def serial_poll(self, address: int) -> int:
        """Return the status byte. Raises: DeviceSilent, DeviceNonsense."""

    def clear(self, address: int) -> None:
        """Send a selected device clear."""

    def unasked_bytes(self) -> int:
        """Return how many bytes came so far that nobody asked for, those that wait now included."""

    def close(self) -> None: ...


@dataclass(frozen=True, slots=True)
class GpibResource:
    """Where an instrument is: what carries the bus, its port, the primary address on it."""

    carrier: Literal["twin", "prologix", "visa"]
    port: str
    """``twin``, the adapter's device path or URL, or the VISA board such as ``GPIB0``."""
    address: int

    @property
    def bus(self) -> tuple[str, str]:
        """Instruments with equal values share one controller."""
        return self.carrier, self.port


def parse_resource(text: str, twin_address: int) -> GpibResource:
    """Return a ``resource`` of a rig file. Raises: RequestRefused with the allowed forms."""
    if text == "twin":
        return GpibResource("twin", "twin", twin_address)
    try:
        if text.startswith("prologix+"):
            port, _, address = text.removeprefix("prologix+").rpartition("#")
            return GpibResource("prologix", _named(port), _primary(address))
        if text.startswith("visa:"):
            board, address, kind = text.removeprefix("visa:").split("::")
            if board.upper().startswith("GPIB") and kind.upper() == "INSTR":
                return GpibResource("visa", board, _primary(address))
    except ValueError as error:
        raise RequestRefused(f"resource {text!r}: {error or 'incomplete'} (allowed: {RESOURCE_FORMS})") from error
    raise RequestRefused(f"resource {text!r}: not a GPIB instrument (allowed: {RESOURCE_FORMS})")


def port_of(resource: str) -> str:
    """Return the port behind any ``resource`` of a rig file.

    It is that of its adapter, or itself where it is a stream's address.
    """
    return parse_resource(resource, 0).port if resource == "twin" or is_on_a_bus(resource) else resource


def is_on_a_bus(resource: str) -> bool:
    """Return whether a ``resource`` names an instrument on a GPIB bus."""
    return resource.startswith(("prologix+", "visa:"))


def _named(port: str) -> str:
    if not port:
        raise ValueError("no port or no address is given")
    return port


def _primary(text: str) -> int:
    if not (text.isdecimal() and int(text) <= 30):
        raise ValueError(f"GPIB address {text!r} is not a number from 0 to 30")
    return int(text)
