"""GPIB through a VISA library: the same bus as through a Prologix adapter. Needs the extra ``calrig[visa]``.

Limit: pyvisa-py (0.8.1) on a Prologix adapter fetches a status byte with a read that makes the instrument talk, and
gives the adapter 50 ms for a reading; for such an adapter use ``prologix+…``.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TypeVar, cast

from rig.clock import Clock
from rig.errors import DeviceNonsense, DeviceSilent, LinkClosed, LinkLost, RequestRefused
from rig.link.exchange import shown

if TYPE_CHECKING:
    from pyvisa import ResourceManager
    from pyvisa.resources import GPIBInstrument

Reply = TypeVar("Reply")

TIMEOUT_S = 3.5
ATTEMPTS = 3
TERMINATOR = b"\r\n"


class VisaBus:
    """A :class:`rig.link.gpib.GpibBus` on a VISA board such as ``GPIB0``.

    ``library`` is pyvisa's name of the VISA to use: empty for the system's, ``@py`` for pyvisa-py.
    Raises: RequestRefused (no pyvisa, no such library).
    """

    def __init__(
        self, board: str, clock: Clock, library: str = "", sign_of_life: Callable[[], None] | None = None
    ) -> None:
        self.name = f"visa:{board}"
        self.clock = clock
        self._board = board
        self._manager = open_manager(library, self.name)
        self._instruments: dict[int, GPIBInstrument] = {}
        self._sign_of_life = sign_of_life or (lambda: None)
        self._is_closed = False

    def send(self, address: int, message: bytes) -> None:
        with self._translated(address, message):
            self._instrument(address).write_raw(message + TERMINATOR)

    def ask(
        self,
        address: int,
        message: bytes,
        parse: Callable[[bytes], Reply],
        *,
        idempotent: bool,
        timeout_s: float = TIMEOUT_S,
    ) -> Reply:
        for _ in range(ATTEMPTS - 1 if idempotent else 0):
            try:
                return self._ask_once(address, message, parse, timeout_s)
            except (DeviceSilent, DeviceNonsense):
                continue
        return self._ask_once(address, message, parse, timeout_s)

    def read(self, address: int, parse: Callable[[bytes], Reply], *, timeout_s: float = TIMEOUT_S) -> Reply:
        return self._read(address, b"", parse, timeout_s)

    def serial_poll(self, address: int) -> int:
        self._sign_of_life()
        with self._translated(address, b""):
            return int(self._instrument(address).read_stb()) & 0xFF

    def clear(self, address: int) -> None:
        with self._translated(address, b""):
            self._instrument(address).clear()

    def unasked_bytes(self) -> int:
        """Return none: an answer stays in its instrument until it is fetched."""
        return 0

    def close(self) -> None:
        self._is_closed = True
        for instrument in self._instruments.values():
            instrument.close()
        self._instruments.clear()
        self._manager.close()

    def _ask_once(self, address: int, message: bytes, parse: Callable[[bytes], Reply], timeout_s: float) -> Reply:
        self.send(address, message)
        return self._read(address, message, parse, timeout_s)

    def _read(self, address: int, message: bytes, parse: Callable[[bytes], Reply], timeout_s: float) -> Reply:
        self._sign_of_life()
        with self._translated(address, message):
            instrument = self._instrument(address)
            instrument.timeout = 1000.0 * timeout_s
            line = instrument.read_raw().removesuffix(b"\n").removesuffix(b"\r")
        try:
            return parse(line)
        except DeviceNonsense as error:
            raise DeviceNonsense(
                f"{self.name} address {address}: no answer to {shown(message)}: got {shown(line)}: {error};"
                " nothing was taken from it; check that this is the right device"
            ) from error

    def _instrument(self, address: int) -> "GPIBInstrument":
        if self._is_closed:
            raise LinkClosed(f"{self.name}: used after it was closed; nothing was sent; open it again")
        if address not in self._instruments:
            opened = self._manager.open_resource(f"{self._board}::{address}::INSTR")
            self._instruments[address] = cast("GPIBInstrument", opened)
        return self._instruments[address]

    @contextmanager
    def _translated(self, address: int, message: bytes) -> Iterator[None]:
        from pyvisa.constants import StatusCode
        from pyvisa.errors import VisaIOError

        try:
            yield
        except VisaIOError as error:
            where = f"{self.name} address {address}: {shown(message)}"
            if error.error_code == StatusCode.error_timeout:
                raise DeviceSilent(f"{where}: no answer in time: {error}; check power and address") from error
            raise LinkLost(f"{where}: {error}; what was sent last is in doubt; check the interface") from error


def open_manager(library: str, name: str) -> "ResourceManager":
    """Return pyvisa's resource manager.

    Raises: RequestRefused when pyvisa or the VISA library is not there.
    """
    try:
        from pyvisa import ResourceManager

        return ResourceManager(library)
    except (ImportError, OSError, ValueError) as error:
        raise RequestRefused(
            f"{name}: no VISA library: {error}; nothing was opened; install calrig[visa] and a VISA, or use prologix+…"
        ) from error
