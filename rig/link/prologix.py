"""GPIB through a Prologix adapter (USB or Ethernet), on any byte stream.

The adapter remembers whatever its last user set, so every setting is written and read back each time. ``++savecfg 0``
first spares the EEPROM of a Prologix and writes that of an AR488, which is therefore asked for its real name before.
An instrument that another program left talking is silenced by what disturbs least: no automatic reading, interface
clear, device clear of the addressed instrument, reset of the adapter. A message and the ``++read eoi`` that fetches
its answer leave in one send. The answer to ``++ver`` is known, so after a doubt it serves as the sentinel: whatever
comes before it is stale. The settings are asked for then as well, and sent again where one is another: an adapter that
lost its power has those of somebody else, and its port may have stayed open.

Source: docs/devices/prologix.md (manual 6.107; manual and firmware of the AR488).
"""

from collections.abc import Callable
from typing import TypeVar

from rig.errors import DeviceNonsense, DeviceRefused, DeviceSilent
from rig.link.byte_stream import ByteStream
from rig.link.counts import ExchangeCounts
from rig.link.exchange import Exchange, Patience
from rig.wire import prologix as wire

Reply = TypeVar("Reply")

SILENCERS = (wire.NO_AUTO, wire.INTERFACE_CLEAR, wire.CLEAR, wire.RESET)
"""In the order of what they disturb."""
RESET_S = 5.5
REAL_VERSION_S = 1.0
ADAPTER_TIMEOUT_S = wire.TIMEOUT_RANGE_MS[1] / 1000.0
TALK_TIMEOUT_S = ADAPTER_TIMEOUT_S + 0.5
"""The adapter gives up first, so that it listens again when we ask again."""
PATIENCE = Patience(timeout_s=TALK_TIMEOUT_S, quiet_s=0.1, quiet_limit_s=2.0 * TALK_TIMEOUT_S)


_SETTINGS = b"".join(wire.setting(name, value) for name, value in wire.SETTINGS.items())


class PrologixBus:
    """A :class:`rig.link.gpib.GpibBus`; the only owner of its adapter."""

    def __init__(self, stream: ByteStream) -> None:
        self.name = stream.name
        self.clock = stream.clock
        self._exchange = Exchange(stream, terminator=b"\n", patience=PATIENCE, resynchronise=self._resynchronise)
        self._address: int | None = None
        self._version = ""
        self._sparing = b""
        """What spares the EEPROM of a Prologix, which goes before its settings; empty for a clone."""
        self._is_set_up = False
        self._set_up()

    @property
    def counts(self) -> ExchangeCounts:
        return self._exchange.counts

    def send(self, address: int, message: bytes) -> None:
        self._exchange.tell(self._addressed(address) + wire.message(message))

    def ask(
        self,
        address: int,
        message: bytes,
        parse: Callable[[bytes], Reply],
        *,
        idempotent: bool,
        timeout_s: float = TALK_TIMEOUT_S,
    ) -> Reply:
        request = self._addressed(address) + wire.message(message) + wire.READ_TO_EOI
        return self._query(request, parse, idempotent, timeout_s)

    def read(self, address: int, parse: Callable[[bytes], Reply], *, timeout_s: float = TALK_TIMEOUT_S) -> Reply:
        return self._query(self._addressed(address) + wire.READ_TO_EOI, parse, False, timeout_s)

    def serial_poll(self, address: int) -> int:
        return self._query(wire.serial_poll(address), wire.parse_status_byte, True, TALK_TIMEOUT_S)

    def clear(self, address: int) -> None:
        self._exchange.tell(self._addressed(address) + wire.CLEAR)

    def unasked_bytes(self) -> int:
        self._exchange.take_waiting()
        return self._exchange.counts.stale_bytes

    def close(self) -> None:
        self._exchange.stream.close()

    def _set_up(self) -> None:
        self._version = self._first_version()
        if wire.CLONE not in self._version:
            self._tell_apart()
        self._exchange.tell(self._sparing + _SETTINGS)
        self._exchange.tell(wire.INTERFACE_CLEAR)
        self._require_settings(
            lambda name: self._query(wire.setting_query(name), wire.parse_number, True, TALK_TIMEOUT_S)
        )
        self._is_set_up = True

    def _require_settings(self, value_of: Callable[[str], int]) -> None:
        for name, value in wire.SETTINGS.items():
            got = value_of(name)
            if got != value:
                raise DeviceRefused(
                    f"{self.name}: adapter setting ++{name}: got {got}, need {value}, which was written just before;"
                    " nothing was sent to an instrument; renew the adapter's firmware or use one that accepts it"
                )

    def _first_version(self) -> str:
        """Return the answer to ``++ver``, once nothing on the bus talks. Raises: DeviceSilent, DeviceNonsense."""
        question = b"\n" + wire.VERSION
        try:
            return self._query(question, wire.parse_version, True, TALK_TIMEOUT_S)
        except DeviceNonsense as error:
            first = error
        for silencer in SILENCERS:
            self._exchange.stream.write(b"\n" + silencer)
            if silencer is wire.RESET:
                self.clock.sleep(RESET_S)
            try:
                return self._query(question, wire.parse_version, False, TALK_TIMEOUT_S)
            except (DeviceSilent, DeviceNonsense):
                continue
        tried = ", ".join(silencer.decode("ascii").strip() for silencer in SILENCERS)
        try:
            self._exchange.wait_for_quiet()
        except DeviceNonsense as error:
            raise DeviceNonsense(
                f"{self.name}: an instrument on the bus talks without end, or another device sends on this line:"
                f" {tried} did not silence it; nothing was set; switch it off and on (a 3458A that runs freely"
                " with END OFF does so), or take it off the bus"
            ) from error
        raise first

    def _tell_apart(self) -> None:
        """Find a clone under another name: its EEPROM is written by the command that spares a Prologix's."""
        try:
            real = self._query(wire.REAL_VERSION, wire.parse_real_version, False, REAL_VERSION_S)
        except (DeviceSilent, DeviceNonsense):
            real = ""
        if wire.CLONE not in real:
            self._sparing = wire.setting("savecfg", 0)

    def _addressed(self, address: int) -> bytes:
        """Return what must go before a message to ``address``."""
        if address == self._address:
            return b""
        self._address = address
        return wire.address(address)

    def _query(self, request: bytes, parse: Callable[[bytes], Reply], idempotent: bool, timeout_s: float) -> Reply:
        try:
            return self._exchange.ask(
                request, lambda line: parse(line.removesuffix(b"\r")), idempotent=idempotent, timeout_s=timeout_s
            )
        except (DeviceSilent, DeviceNonsense):
            self._address = None
            raise

    def _resynchronise(self) -> None:
        """Ask for the version, whose answer is known; what comes before it belongs to nobody. Raises: DeviceSilent."""
        if not self._version:
            self._exchange.wait_for_quiet()
            return
        self._exchange.stream.write(b"\n" + self._sparing + wire.VERSION)
        self._exchange.skip_to(self._version.encode("ascii") + b"\r\n", 2.0 * TALK_TIMEOUT_S, wire.VERSION)
        self._exchange.wait_for_quiet()
        if self._is_set_up:
            self._set_again()

    def _set_again(self) -> None:
        """See that it has its settings still: it may have restarted while its port stayed open.

        They are asked for first, as ``++mode 1`` takes the instruments behind a clone out of remote.
        """
        if any(self._said(name) != value for name, value in wire.SETTINGS.items()):
            self._exchange.stream.write(_SETTINGS)
            self._require_settings(self._said)

    def _said(self, name: str) -> int:
        """Ask for a setting while the line is brought to a known state."""
        question = wire.setting_query(name)
        self._exchange.stream.write(question)
        return wire.parse_number(self._exchange.read_line(TALK_TIMEOUT_S, question).removesuffix(b"\r"))
