"""Where axes stand, as the commands of the bench tell it: a position that nobody knows is no number."""

from collections.abc import Mapping
from typing import Any

from rig.abilities.abilities import AxisState


def positions_document(states: Mapping[str, AxisState]) -> dict[str, Any]:
    """Return ``positions_deg``, None where it is not known, and then ``positions_unknown``: why not."""
    unknown = {name: state.unknown for name, state in states.items() if state.unknown}
    positions_deg = {name: None if name in unknown else state.position_deg for name, state in states.items()}
    return {"positions_deg": positions_deg, **({"positions_unknown": unknown} if unknown else {})}


def position_in_words(document: Mapping[str, Any], name: str, before: str = "") -> str:
    """Return the position of an axis of such a document, or why it is not known; ``before``: what goes before it."""
    position_deg = document["positions_deg"][name]
    return str(document["positions_unknown"][name]) if position_deg is None else f"{before}{position_deg:+.4f}°"
