"""What the tables of meters have in common that read through channels of cards in slots."""

from collections.abc import Iterable, Mapping
from typing import Any, Protocol


class Ranged(Protocol):
    """A channel with a range of its own."""

    @property
    def range_v(self) -> float: ...


def card_of_slot(cards: Mapping[Any, str]) -> dict[int, str]:
    """Return slot to card, as ``cards`` of the rig file has them by the text of the slot."""
    return {int(slot): card for slot, card in cards.items()}


def ranges_v(channels: Iterable[Ranged]) -> list[float]:
    """Return every range that a channel uses, as often as it does."""
    return [channel.range_v for channel in channels]
