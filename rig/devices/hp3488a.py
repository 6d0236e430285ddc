"""HP 3488A scanner before a meter: break before make, and every relay of the rig's cards read back.

Two inputs must never meet through the scanner: the meter would read a mixture of both. So the old channel is seen open
before the new one is closed, and before and behind every burst each relay of the cards is asked for, those that the rig
does not use as well: another program, a hand at the panel or a paired card may have closed one. There is no query for
all of them. The rig's cards are those of its channels and those that its file names; no other is touched.
"""

from collections.abc import Mapping, Sequence
from math import inf
from types import MappingProxyType
from typing import NoReturn

from rig.abilities.abilities import Wait
from rig.abilities.waiting import wait_until
from rig.clock import Clock
from rig.errors import DeviceFault, DeviceRefused, FileContradicted
from rig.link.gpib import GpibBus
from rig.wire import hp3488a as wire
from rig.wire.hp3488a import Status

READY_LIMIT_S = 2.0
LOOK_LASTS_S = 1.0
"""So long, where no relay was moved, the look behind one burst serves as that before the next."""

END = b"\r\n"
"""Behind every message: that the unit takes EOI alone for its end is not known."""


class Hp3488aScanner:
    """The scanner at ``address``, with the channels (slot and two digits) that the rig uses.

    ``declared``: the cards of slots by the rig file, none where it names none. They are the rig's, used or not.
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
        self._slots = sorted({*map(wire.slot_of, channels), *declared})
        self._watched: tuple[int, ...] = ()
        """Every channel of these cards, once they were asked for."""
        self._settle_s = settle_s
        self._clock = clock
        self._closed: int | None = None
        self._is_known = False
        self._seen_s = -inf
        """When all relays were last seen as they should be, rig seconds."""

    def identify(self) -> str:
        """Return the identity and the card in every slot of the rig. Raises: DeviceSilent, DeviceNonsense."""
        identity = self._bus.ask(self._address, b"ID?" + END, wire.parse_identity, idempotent=True)
        return ", ".join([identity, *(f"{card} in slot {slot}" for slot, card in self._cards().items())])

    def prepare(self, wait: Wait) -> None:
        """Open all relays of the rig's cards and see them open.

        Raises: DeviceFault, DeviceRefused, DeviceSilent, DeviceNonsense, FileContradicted.
        """
        self._is_known = False
        self._bus.ask(self._address, b"ERROR" + END, wire.parse_errors, idempotent=False)
        self._bus.ask(self._address, b"ID?" + END, wire.parse_identity, idempotent=True)
        cards = self._required_cards()
        for slot in cards:
            self._bus.send(self._address, wire.reset_card(slot) + END)
            self._settle(wait)
        self._watched = self._all_channels(cards, wait)
        self._require_closed(None)
        self._require_no_error("prepare")
        self._closed = None
        self._is_known = True

    def select(self, channel: int, wait: Wait) -> None:
        """Connect ``channel`` alone: open the old one, see it open, close the new one, see it alone closed."""
        if not self._is_known:
            self.prepare(wait)
        if self._closed != channel:
            self._is_known = False
            self._open(wait)
            self._bus.send(self._address, wire.close(channel) + END)
            self._settle(wait)
            self._closed = channel
            self._is_known = True
        elif self._clock.monotonic_s() - self._seen_s < LOOK_LASTS_S:
            self._require_connected(channel)
            return
        self.verify(channel)

    def release(self, wait: Wait) -> None:
        """Open whatever is closed, and see every relay open. Raises: DeviceFault."""
        if not self._is_known:
            self.prepare(wait)
        self._is_known = False
        self._open(wait)
        self._require_closed(None)
        self._is_known = True

    def verify(self, channel: int) -> None:
        """See that ``channel`` is closed and no other of the rig's cards. Raises: DeviceFault."""
        self._require_closed(channel)

    def forget(self) -> None:
        """Forget the state, which is in doubt: the next :meth:`select` starts from all relays open."""
        self._is_known = False

    def _open(self, wait: Wait) -> None:
        if self._closed is None:
            return
        self._bus.send(self._address, wire.open_channel(self._closed) + END)
        self._settle(wait)
        if self._is_closed(self._closed):
            self._contradicted(self._closed, "got closed, need open", "nothing else is closed beside it")
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

    def _has_ended(self) -> bool:
        return bool(self._bus.serial_poll(self._address) & (Status.READY | Status.ERROR))

    def _not_ready(self) -> str:
        return (
            f"{self.name}: scanner: not ready within {READY_LIMIT_S:g} s; the relays are in doubt; look at its display"
        )

    def _require_closed(self, channel: int | None) -> None:
        """See that of all relays ``channel`` alone is closed, or none. Raises: DeviceFault."""
        if channel is not None:
            self._require_connected(channel)
        for number in self._watched:
            if number != channel and self._is_closed(number):
                beside = "" if channel is None else f" beside {channel}: the meter is on both and reads a mixture"
                self._contradicted(number, f"got closed, need open{beside}", "no reading is taken or kept")
        self._seen_s = self._clock.monotonic_s()

    def _require_connected(self, channel: int) -> None:
        if not self._is_closed(channel):
            self._contradicted(channel, "got open, need closed", "no reading is taken from it")

    def _contradicted(self, channel: int, found: str, outcome: str) -> NoReturn:
        self._is_known = False
        raise DeviceFault(
            f"{self.name}: scanner channel {channel}: {found}; {outcome}; check the card (a relay may stick) and that"
            " nobody else uses the scanner, by its panel or by another program"
        )

    def _is_closed(self, channel: int) -> bool:
        return self._bus.ask(self._address, wire.view(channel) + END, wire.parse_view, idempotent=True)

    def _require_no_error(self, after: str) -> None:
        if errors := self._bus.ask(self._address, b"ERROR" + END, wire.parse_errors, idempotent=False):
            self._is_known = False
            raise DeviceRefused(
                f"{self.name}: scanner: {after}: {', '.join(errors)} error; the relays are in doubt;"
                " check that the channels of the rig file exist on its cards"
            )

    def _required_cards(self) -> dict[int, str]:
        """Return the card of every slot of the rig.

        A channel that its card lacks is refused: it answers nothing at all, so say which before it is waited for.
        """
        cards = self._cards()
        for slot, card in self._declared.items():
            if cards.get(slot, card) != card:
                raise FileContradicted(
                    f"{self.name}: slot {slot} of the scanner has a {cards[slot]}, the rig file says {card}"
                    f" (readouts.{self.name}: cards); nothing was switched; put that card in or correct the rig file"
                )
        for channel in self._channels:
            slot = wire.slot_of(channel)
            if not wire.has_channel(cards[slot], channel):
                raise FileContradicted(
                    f"{self.name}: scanner channel {channel}: card {cards[slot]} in slot {slot} has no such channel"
                    f" (readouts.{self.name}: channels; allowed: channels of {', '.join(wire.SWITCHED_BY)}); nothing"
                    " was switched; correct the rig file"
                )
        return cards

    def _all_channels(self, cards: Mapping[int, str], wait: Wait) -> tuple[int, ...]:
        """Return every channel of these cards. Raises: DeviceFault where a card is none of those known."""
        watched: list[int] = []
        for slot, card in cards.items():
            channels = wire.channels_of(slot, card)
            if card in wire.NAMED_ALIKE:
                channels = [channel for channel in channels if channel in self._channels or self._exists(channel, wait)]
                if {channel % 100 for channel in channels} not in wire.NAMED_ALIKE[card]:
                    raise DeviceFault(
                        f"{self.name}: scanner: the {card} in slot {slot} answers for channels"
                        f" {', '.join(map(str, channels))} alone, as no card of that name does; no reading is taken;"
                        " check the card and the line"
                    )
            watched += channels
        return tuple(watched)

    def _exists(self, channel: int, wait: Wait) -> bool:
        """Return whether a card that shares its name with smaller ones has the channel: VIEW is an error where not."""
        self._bus.send(self._address, wire.view(channel) + END)
        wait_until(self._has_ended, wait, (self._clock, self._bus.clock), READY_LIMIT_S, self._not_ready)
        if self._bus.serial_poll(self._address) & Status.ERROR:
            self._bus.ask(self._address, b"ERROR" + END, wire.parse_errors, idempotent=False)
            return False
        self._bus.read(self._address, wire.parse_view)
        return True

    def _cards(self) -> dict[int, str]:
        """Return the model of the card in every slot of the rig."""
        return {
            slot: self._bus.ask(self._address, wire.card_type(slot) + END, wire.parse_card_type, idempotent=True)
            for slot in self._slots
        }
