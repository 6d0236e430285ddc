"""HP 3488A scanner before a meter: break before make, and every switch read back.

Two inputs must never meet through the scanner, so the old channel is seen open before the new one is closed. The
scanner has no query for all channels: a device clear opens them all, and :meth:`prepare` looks at each that is used.
"""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from rig.abilities.abilities import Wait
from rig.abilities.waiting import wait_until
from rig.clock import Clock
from rig.errors import DeviceFault, DeviceRefused, FileContradicted
from rig.link.gpib import GpibBus
from rig.wire import hp3488a as wire
from rig.wire.hp3488a import Status

READY_LIMIT_S = 2.0

END = b"\r\n"
"""Behind every message: that the unit takes EOI alone for its end is not known."""


class Hp3488aScanner:
    """The scanner at ``address``, with the channels (slot and two digits) that the rig uses.

    ``declared``: the cards of slots by the rig file, none where it names none.
    """

    def __init__(
        self,
        name: str,
        bus: GpibBus,
        address: int,
        channels: Sequence[int],
        settle_s: float,
        clock: Clock,
        declared: Mapping[int, str] = MappingProxyType({}),
    ) -> None:
        self.name = name
        self._bus = bus
        self._address = address
        self._channels = tuple(channels)
        self._declared = declared
        self._settle_s = settle_s
        self._clock = clock
        self._closed: int | None = None
        self._is_known = False

    def identify(self) -> str:
        """Return the identity and the card in every slot that is used. Raises: DeviceSilent, DeviceNonsense."""
        identity = self._bus.ask(self._address, b"ID?" + END, wire.parse_identity, idempotent=True)
        return ", ".join([identity, *(f"{card} in slot {slot}" for slot, card in self._cards().items())])

    def prepare(self, wait: Wait) -> None:
        """Open all relays and see them open. Raises: DeviceFault, DeviceRefused, DeviceSilent, DeviceNonsense."""
        self._is_known = False
        self._bus.clear(self._address)
        self._settle(wait)
        self._bus.ask(self._address, b"ERROR" + END, wire.parse_errors, idempotent=False)
        self._bus.ask(self._address, b"ID?" + END, wire.parse_identity, idempotent=True)
        self._require_cards()
        for channel in self._channels:
            self._require(channel, closed=False)
        self._require_no_error("prepare")
        self._closed = None
        self._is_known = True

    def select(self, channel: int, wait: Wait) -> None:
        """Connect ``channel`` alone: open the old one, see it open, close the new one, see it closed."""
        if not self._is_known:
            self.prepare(wait)
        if self._closed != channel:
            self._is_known = False
            self._open(wait)
            self._bus.send(self._address, wire.close(channel) + END)
            self._settle(wait)
            self._closed = channel
            self._is_known = True
        self.verify(channel)

    def release(self, wait: Wait) -> None:
        """Open whatever is closed, and see it open."""
        if not self._is_known:
            self.prepare(wait)
        self._is_known = False
        self._open(wait)
        self._is_known = True

    def verify(self, channel: int) -> None:
        """See that ``channel`` is closed. Raises: DeviceFault."""
        self._require(channel, closed=True)

    def forget(self) -> None:
        """Forget the state, which is in doubt: the next :meth:`select` starts from all relays open."""
        self._is_known = False

    def _open(self, wait: Wait) -> None:
        if self._closed is None:
            return
        self._bus.send(self._address, wire.open_channel(self._closed) + END)
        self._settle(wait)
        self._require(self._closed, closed=False)
        self._closed = None

    def _settle(self, wait: Wait) -> None:
        """Let the relay move, then see that the scanner is ready and content."""
        wait(self._settle_s)
        wait_until(self._is_ready, wait, (self._clock, self._bus.clock), READY_LIMIT_S, self._not_ready)

    def _is_ready(self) -> bool:
        status = self._bus.serial_poll(self._address)
        if status & Status.ERROR:
            self._require_no_error("the last command")
        return bool(status & Status.READY)

    def _not_ready(self) -> str:
        return (
            f"{self.name}: scanner: not ready within {READY_LIMIT_S:g} s; the relays are in doubt; look at its display"
        )

    def _require(self, channel: int, *, closed: bool) -> None:
        is_closed = self._bus.ask(self._address, wire.view(channel) + END, wire.parse_view, idempotent=True)
        if is_closed != closed:
            self._is_known = False
            raise DeviceFault(
                f"{self.name}: scanner channel {channel}: got {_word(is_closed)}, need {_word(closed)};"
                " no reading is taken from it; check the card and that nobody else uses the scanner"
            )

    def _require_no_error(self, after: str) -> None:
        if errors := self._bus.ask(self._address, b"ERROR" + END, wire.parse_errors, idempotent=False):
            self._is_known = False
            raise DeviceRefused(
                f"{self.name}: scanner: {after}: {', '.join(errors)} error; the relays are in doubt;"
                " check that the channels of the rig file exist on its cards"
            )

    def _require_cards(self) -> None:
        """Refuse a channel that no card has: it answers nothing at all, so say which before it is waited for."""
        cards = self._cards()
        for slot, card in self._declared.items():
            if cards.get(slot, card) != card:
                raise FileContradicted(
                    f"{self.name}: slot {slot} of the scanner has a {cards[slot]}, the rig file says {card}"
                    f" (readouts.{self.name}: cards); all relays are open; put that card in or correct the rig file"
                )
        for channel in self._channels:
            slot = wire.slot_of(channel)
            if not wire.has_channel(cards[slot], channel):
                raise FileContradicted(
                    f"{self.name}: scanner channel {channel}: card {cards[slot]} in slot {slot} has no such channel"
                    f" (readouts.{self.name}: channels; allowed: channels of {', '.join(wire.SWITCHED_BY)}); all relays"
                    " are open; correct the rig file"
                )

    def _cards(self) -> dict[int, str]:
        """Return the model of the card in every slot that is used."""
        return {
            slot: self._bus.ask(self._address, wire.card_type(slot) + END, wire.parse_card_type, idempotent=True)
            for slot in sorted({wire.slot_of(channel) for channel in self._channels})
        }


def _word(is_closed: bool) -> str:
    return "closed" if is_closed else "open"
