"""Axes that nobody stops when calrig dies: the stop guard can send only what their drivers give it."""

from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from datetime import UTC, datetime

from rig.clock import VirtualClock
from rig.description.device_settings import TWIN_PORT
from rig.description.rig_file import RigDescription
from rig.devices.abilities import Axis, Stoppable
from rig.drivers.open import open_axes
from rig.drivers.twin_lines import axis_lines, twin_lines, without_twin
from rig.lines.open_lines import Lines
from rig.link.terminal_stream import TERMINAL
from rig.twins.world import World

WHY = (
    "nobody stops it when this program dies: its driver has no stop_steps (docs/drivers.md); keep the machine's own"
    " stop button within reach"
)


def unguarded(description: RigDescription, axes: Mapping[str, Axis]) -> tuple[str, ...]:
    """Return those of the open ``axes`` on real lines that have nothing for the stop guard."""
    return tuple(
        name
        for name, axis in axes.items()
        if description.axes[name].port not in (TWIN_PORT, TERMINAL) and not isinstance(axis, Stoppable)
    )


def unguarded_by_their_drivers(description: RigDescription) -> tuple[str, ...]:
    """Return the same before anything is opened, by the twins of the axes; those without a twin are left out."""
    if all(axis.port in (TWIN_PORT, TERMINAL) for axis in description.axes.values()):
        return ()
    alone = without_twin(description)
    on_twins = description.all_on_twins()
    on_twins = on_twins.model_copy(
        update={"axes": {name: axis for name, axis in on_twins.axes.items() if f"axes.{name}" not in alone}}
        | {table: {} for table in ("readouts", "environment", "streams", "field")}
    )
    twins = {key: line.twin for line in twin_lines(on_twins, World(on_twins)) for key in line.keys}
    opened: dict[str, Axis] = {}
    with ExitStack() as closing:
        lines = Lines(VirtualClock(datetime(2024, 1, 1, tzinfo=UTC)), twins, None, closing)
        for names in axis_lines(on_twins.axes):
            opened |= open_axes({name: on_twins.axes[name] for name in names}, lines)
    return unguarded(description, opened)


def sentence(names: Iterable[str]) -> str:
    """Return what to say of them; empty where there is none."""
    told = ", ".join(f"axes.{name}" for name in names)
    return told and f"{told}: {WHY}"
