"""The twins of a rig, line by line: which devices share a line, and which twin stands at its other end.

The same lines are read in memory (:mod:`rig.assembly`) and over real ports (:mod:`rig.simulate`).
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TypeVar

from rig.description import RigDescription
from rig.devices.hp3458a import Hp3458aSettings
from rig.devices.indexing_table import IndexingTableSettings
from rig.devices.watlow_f4 import WatlowF4Settings
from rig.errors import DescriptionError
from rig.settings import TWIN_PORT, AxisSettings, EnvironmentSettings, ReadoutSettings
from rig.twins.hp3458a import Hp3458aTwin, ScannedInput
from rig.twins.hp3488a import Hp3488aTwin
from rig.twins.indexing_table import IndexingTableTwin
from rig.twins.prologix import GpibInstrument, PrologixTwin
from rig.twins.twin import Twin
from rig.twins.watlow_f4 import WatlowF4Twin
from rig.twins.world import World
from rig.wire import hp3458a as meter_wire
from rig.wire import hp3488a as scanner_wire
from rig.wire.indexing_table import TableCodec
from rig.wire.table_dialect import load_dialect

Settings = TypeVar("Settings")


@dataclass(frozen=True)
class TwinLine:
    """One line and the twin at its end."""

    keys: tuple[str, ...]
    """The devices on it by their tables in the rig file, such as ``axes.pitch`` and ``axes.roll``."""
    twin: Twin
    address: str = "{port}"
    """How the rig file writes the port, where a device's address is more than the port."""


def axis_lines(axes: Mapping[str, AxisSettings]) -> list[tuple[str, ...]]:
    """Names of the axes that share a line: same driver and port, each with a number of its own.

    Twins with equal numbers are two controllers; at real ports the rig file is refused for that.
    """
    lines: list[list[str]] = []
    for name, axis in axes.items():
        for line in lines:
            others = [axes[other] for other in line]
            same_port = (others[0].driver, others[0].port) == (axis.driver, axis.port)
            if same_port and axis.axis not in [other.axis for other in others]:
                line.append(name)
                break
        else:
            lines.append([name])
    return [tuple(line) for line in lines]


def twin_lines(description: RigDescription, world: World, time_factor: float = 1.0) -> list[TwinLine]:
    """The lines of every device whose port says ``twin``. Raises: DescriptionError where a driver has no twin."""
    axes = {name: axis for name, axis in description.axes.items() if axis.port == TWIN_PORT}
    return [
        *(_axes_line({name: axes[name] for name in line}, world) for line in axis_lines(axes)),
        *_readout_lines(description.readouts, world),
        *_environment_lines(description.environment, world, time_factor),
    ]


def _axes_line(axes: Mapping[str, AxisSettings], world: World) -> TwinLine:
    tables = {name: _as(IndexingTableSettings, axis, f"axes.{name}") for name, axis in axes.items()}
    finest = min(tables.values(), key=lambda settings: settings.increment_deg)
    codec = TableCodec(load_dialect(finest.dialect, finest.increment_deg))
    bodies = {axis.axis: name for name, axis in axes.items()}
    return TwinLine(tuple(f"axes.{name}" for name in axes), IndexingTableTwin(codec, bodies, world))


def _readout_lines(readouts: Mapping[str, ReadoutSettings], world: World) -> Iterable[TwinLine]:
    for name, readout in readouts.items():
        meter = _as(Hp3458aSettings, readout, f"readouts.{name}")
        if meter.resource != TWIN_PORT:
            continue
        if meter.scanner_resource not in (None, TWIN_PORT):
            raise DescriptionError(
                f"readouts.{name}: scanner_resource: a meter's twin needs its scanner's twin; leave it out"
            )
        wiring = {entry.scanner_channel: f"{name}.{channel}" for channel, entry in meter.channels.items()}
        slots = {number // 100 for number in wiring}
        scanner = Hp3488aTwin(dict.fromkeys(sorted(slots), "44470"))
        instruments: dict[int, GpibInstrument] = {
            meter_wire.DEFAULT_ADDRESS: Hp3458aTwin(ScannedInput(world, scanner, wiring)),
            scanner_wire.DEFAULT_ADDRESS: scanner,
        }
        yield TwinLine(
            (f"readouts.{name}",), PrologixTwin(instruments), f"prologix+{{port}}#{meter_wire.DEFAULT_ADDRESS}"
        )


def _environment_lines(
    environments: Mapping[str, EnvironmentSettings], world: World, time_factor: float
) -> Iterable[TwinLine]:
    for name, environment in environments.items():
        if environment.port == TWIN_PORT:
            unit = _as(WatlowF4Settings, environment, f"environment.{name}").unit
            yield TwinLine((f"environment.{name}",), WatlowF4Twin(name, world, unit=unit, gap_s=time_factor))


def _as(kind: type[Settings], settings: AxisSettings | ReadoutSettings | EnvironmentSettings, key: str) -> Settings:
    """The driver's own settings. Raises: DescriptionError for a driver without a twin."""
    if not isinstance(settings, kind):
        raise DescriptionError(f"{key}: driver: {settings.driver!r} has no twin; give its real port")
    return settings
