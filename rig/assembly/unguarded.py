"""What nobody stops when calrig dies: told before any port is opened, and of open devices.

Whether the stop guard can stop an axis is known to the axis alone. So before any port is opened the axes are made
on lines in memory on which nobody answers; a driver that asks nothing while it is opened does not notice.
"""

from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from datetime import UTC, datetime

from rig.abilities.unstoppable import why_unstoppable
from rig.clock import VirtualClock
from rig.description.device_settings import TWIN_PORT, AxisSettings
from rig.description.rig_file import RigDescription
from rig.drivers.open import open_axes
from rig.drivers.twin_lines import axis_lines
from rig.errors import DescriptionError, RigError
from rig.guard.stop_guard import IS_POSSIBLE
from rig.lines.open_lines import Lines
from rig.link.terminal_stream import TERMINAL

NO_GUARD = (
    "this system has no stop guard: if this program is killed or the computer dies, nobody stops the axes; keep "
    "the machine's own stop button within reach"
)


class _Nobody:
    """The other side of a line on which nobody is: a :class:`rig.twins.twin.Twin`."""

    def receive(self, data: bytes, now_s: float) -> None: ...

    def transmit(self, now_s: float) -> bytes:  # noqa: ARG002
        return b""

    def next_event_s(self) -> float | None:
        return None


def unguarded_sentences(description: RigDescription) -> tuple[str, ...]:
    """Return what to say, before a motion, of axes that nobody stops when this program dies.

    Twins in this process die with it, and an operator's hand stops by itself. Raises: DescriptionError.
    """
    elsewhere = {name: axis for name, axis in description.axes.items() if axis.port not in (TWIN_PORT, TERMINAL)}
    if not elsewhere:
        return ()
    return tuple(unstoppable_axes(elsewhere)) if IS_POSSIBLE else (NO_GUARD,)


def unstoppable_axes(axes: Mapping[str, AxisSettings]) -> Iterator[str]:
    """Yield a sentence for each axis that the stop guard cannot stop, wherever its port is. Opens no port.

    Raises: DescriptionError where a driver's axis lacks a member that every axis has.
    """
    for names in axis_lines(axes):
        with ExitStack() as opened:
            nobody = {f"axes.{name}": _Nobody() for name in names}
            lines = Lines(VirtualClock(datetime(2024, 1, 1, tzinfo=UTC)), nobody, None, opened)
            try:
                found = open_axes({name: axes[name].model_copy(update={"port": TWIN_PORT}) for name in names}, lines)
            except DescriptionError:
                raise
            except RigError as error:
                yield f"axes.{names[0]}: whether anything stops it when calrig dies shows when it is opened: {error}"
                continue
            yield from filter(None, (why_unstoppable(axis, name) for name, axis in found.items()))
