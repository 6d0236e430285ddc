"""What a device lacks of its ability, found when it is opened and not in the night in which it is needed.

A driver of another distribution is bound to :mod:`rig.devices.abilities` by its members alone.
"""

from collections.abc import Iterator

from rig.devices.abilities import Axis, Environment, Field, RateAxis, Readout, Stoppable, Stream
from rig.errors import DescriptionError

Device = Axis | Readout | Environment | Stream | Field
ABILITIES: dict[str, type] = {
    "axes": Axis,
    "readouts": Readout,
    "environment": Environment,
    "streams": Stream,
    "field": Field,
}
"""Table of a rig file to the ability that its devices must have whole."""


def require_members(device: object, key: str, driver: str) -> None:
    """Refuse a device (``axes.pitch``) that lacks a member of its ability.

    A rate does not end by itself, so an axis that turns must say how somebody else stops it. Raises: DescriptionError.
    """
    wanted = [ABILITIES[key.partition(".")[0]]]
    if hasattr(device, "start_rate"):
        wanted += [RateAxis, Stoppable]
    missing = list(dict.fromkeys(name for ability in wanted for name in _members(ability) if not hasattr(device, name)))
    if missing:
        raise DescriptionError(
            f"{key}: driver: {driver!r}: what it opens has no {', '.join(missing)}; nothing moved; the driver must be"
            " completed by its author (docs/drivers.md: the members of each ability)"
        )


def why_unstoppable(axis: object, name: str) -> str:
    """Return what to say of an axis that nobody stops when calrig dies; empty where the stop guard can."""
    if not isinstance(axis, Stoppable):
        why = "its driver has no stop_steps"
    elif not axis.stop_steps():
        why = "its machine has no stop"
    else:
        return ""
    return (
        f"axes.{name}: nothing stops it when calrig dies: {why}; a move that was started goes on to its target; keep"
        " the machine's own stop button within reach"
    )


def _members(ability: type) -> Iterator[str]:
    """Yield what a protocol asks for: values that are only declared, and methods."""
    yield from ability.__annotations__
    yield from (name for name, member in vars(ability).items() if callable(member) and not name.startswith("_"))
