"""The twins of a rig, line by line: which devices share a line, and which twin stands at its other end.

The same lines are read in memory (:mod:`rig.assembly.open_rig`) and over real ports (:mod:`rig.assembly.simulate`).
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TypeVar

from rig.description.device_settings import (
    TWIN_PORT,
    AxisSettings,
    EnvironmentSettings,
    FieldSettings,
    ReadoutSettings,
    StreamSettings,
)
from rig.description.driver_names import Ability, registered_part
from rig.description.rig_file import RigDescription, TwinSection
from rig.description.twin_truth import TwinReadout
from rig.devices.csv_imu import CsvImuSettings
from rig.devices.hp3458a import Hp3458aSettings
from rig.devices.meter_checks import MeterChecks
from rig.devices.scpi_daq import ScpiDaqSettings
from rig.devices.watlow_f4 import WatlowF4Settings
from rig.devices.watlow_f4t import WatlowF4TSettings
from rig.drivers.axis_twins import AXIS_TWINS
from rig.drivers.open import settings_as
from rig.errors import DescriptionError
from rig.twins.csv_imu import CsvImuTwin
from rig.twins.hp3458a import Hp3458aTwin, ScannedInput
from rig.twins.hp3488a import Hp3488aTwin
from rig.twins.imu import MotionSource
from rig.twins.known_voltages import REFERENCE, SHORT, KnownVoltages
from rig.twins.manual_field import FieldOperatorTwin
from rig.twins.modbus_slave import ModbusSlave
from rig.twins.prologix import GpibInstrument, PrologixTwin
from rig.twins.scpi_daq import ScpiDaqTwin
from rig.twins.scpi_port import ScpiPort
from rig.twins.strapped_down import StrappedDown
from rig.twins.twin import Twin
from rig.twins.vn100 import Vn100Twin
from rig.twins.watlow_f4 import WatlowF4Twin
from rig.twins.watlow_f4t import WatlowF4TTwin
from rig.twins.world import World
from rig.wire import hp3458a as meter_wire
from rig.wire import hp3488a as scanner_wire

Builder = TypeVar("Builder")


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
    """The lines of every device whose port says ``twin``. ``time_factor``: rig seconds in a second of the line.

    Raises: DescriptionError where a driver has no twin.
    """
    axes = {name: axis for name, axis in description.axes.items() if axis.port == TWIN_PORT}
    readouts = {name: meter for name, meter in description.readouts.items() if is_twin(meter)}
    chambers = {name: chamber for name, chamber in description.environment.items() if chamber.port == TWIN_PORT}
    return [
        *(_axes_line({name: axes[name] for name in line}, world, time_factor) for line in axis_lines(axes)),
        *(_readout_line(name, readout, world) for name, readout in readouts.items()),
        *(_environment_line(name, chamber, world, time_factor) for name, chamber in chambers.items()),
        *_stream_lines(description, world),
        *(_field_line(name, coil, world) for name, coil in description.field.items() if coil.port == TWIN_PORT),
    ]


def is_twin(readout: ReadoutSettings) -> bool:
    return getattr(readout, "resource", None) == TWIN_PORT


def _axes_line(axes: Mapping[str, AxisSettings], world: World, time_factor: float) -> TwinLine:
    keys = tuple(f"axes.{name}" for name in axes)
    builder = _twin("axes", AXIS_TWINS, axes[next(iter(axes))].driver, keys[0])
    return TwinLine(keys, builder(axes, world, time_factor))


def _readout_line(name: str, readout: ReadoutSettings, world: World) -> TwinLine:
    key = f"readouts.{name}"
    twin, address = _twin("readouts", READOUT_TWINS, readout.driver, key)(name, readout, world)
    return TwinLine((key,), twin, address)


def _environment_line(name: str, chamber: EnvironmentSettings, world: World, time_factor: float) -> TwinLine:
    key = f"environment.{name}"
    builder = _twin("environments", ENVIRONMENT_TWINS, chamber.driver, key)
    return TwinLine((key,), builder(name, chamber, world, time_factor))


def _stream_lines(description: RigDescription, world: World) -> Iterator[TwinLine]:
    streams = {name: stream for name, stream in description.streams.items() if stream.port == TWIN_PORT}
    source = StrappedDown(world, description.twin or TwinSection())
    for name, stream in streams.items():
        key = f"streams.{name}"
        yield TwinLine((key,), _twin("streams", STREAM_TWINS, stream.driver, key)(name, stream, source))


def _field_line(name: str, coil: FieldSettings, world: World) -> TwinLine:
    key = f"field.{name}"
    return TwinLine((key,), _twin("fields", FIELD_TWINS, coil.driver, key)(name, coil, world))


def _manual_field(name: str, coil: FieldSettings, world: World) -> Twin:
    return FieldOperatorTwin(name, coil.direction, world)


def _hp3458a(name: str, readout: ReadoutSettings, world: World) -> tuple[Twin, str]:
    meter = settings_as(Hp3458aSettings, readout)
    if meter.scanner_resource not in (None, TWIN_PORT):
        raise DescriptionError(
            f"readouts.{name}: scanner_resource: a meter's twin needs its scanner's twin; leave it out"
        )
    wiring = {entry.scanner_channel: f"{name}.{channel}" for channel, entry in meter.channels.items()}
    wiring |= _wired_checks(meter.checks)
    source = _known(name, meter.checks, world)
    scanner = Hp3488aTwin(dict.fromkeys(sorted({number // 100 for number in wiring}), "44470"))
    twin = Hp3458aTwin(ScannedInput(source, scanner, wiring))
    twin.own_degc = source.own_degc
    instruments: dict[int, GpibInstrument] = {
        meter_wire.DEFAULT_ADDRESS: twin,
        scanner_wire.DEFAULT_ADDRESS: scanner,
    }
    return PrologixTwin(instruments), f"prologix+{{port}}#{meter_wire.DEFAULT_ADDRESS}"


def _watlow_f4(name: str, chamber: EnvironmentSettings, world: World, time_factor: float) -> Twin:
    return WatlowF4Twin(name, world, unit=settings_as(WatlowF4Settings, chamber).unit, gap_s=time_factor)


def _scpi_daq(name: str, readout: ReadoutSettings, world: World) -> tuple[Twin, str]:
    daq = settings_as(ScpiDaqSettings, readout)
    wiring = {entry.channel: f"{name}.{channel}" for channel, entry in daq.channels.items()}
    source, wiring = _known(name, daq.checks, world), wiring | _wired_checks(daq.checks)
    unit = ScpiDaqTwin(source, wiring, model=daq.model, line_frequency_hz=daq.line_frequency_hz)
    return ScpiPort(unit), "{port}"


def _wired_checks(checks: MeterChecks) -> dict[int, str]:
    names = {"short": SHORT, "reference": REFERENCE}
    return {place: names[name] for name, place in checks.places().items() if place is not None}


def _known(name: str, checks: MeterChecks, world: World) -> KnownVoltages:
    return KnownVoltages(world, world.meters.get(name, TwinReadout()), checks.reference_v or 0.0)


def _watlow_f4t(name: str, chamber: EnvironmentSettings, world: World, time_factor: float) -> Twin:
    f4t = settings_as(WatlowF4TSettings, chamber)
    registers = WatlowF4TTwin(name, world, loop=f4t.loop, word_order=f4t.word_order, fahrenheit=f4t.values == "degf")
    return ModbusSlave(registers, unit=f4t.unit, framing=f4t.transport, gap_s=time_factor)


def _vn100(name: str, stream: StreamSettings, source: MotionSource) -> Twin:  # noqa: ARG001 the driver sets it up
    return Vn100Twin(name, source)


def _csv_imu(name: str, stream: StreamSettings, source: StrappedDown) -> Twin:
    board = settings_as(CsvImuSettings, stream)
    return CsvImuTwin(
        name,
        source,
        board.shape(),
        board.columns,
        board.rate_hz,
        board.counts,
        count={board.count.column: board.count.wraps_at} if board.count else {},
        time={board.time.column: (board.time.wraps_at, 1.0 / board.time.unit_s)} if board.time else {},
        reading=lambda column, at_s: source.reading(f"{name}.{column}", at_s),
    )


READOUT_TWINS: Mapping[str, Callable[[str, ReadoutSettings, World], tuple[Twin, str]]] = {
    "hp3458a": _hp3458a,
    "scpi-daq": _scpi_daq,
}
ENVIRONMENT_TWINS: Mapping[str, Callable[[str, EnvironmentSettings, World, float], Twin]] = {
    "watlow-f4": _watlow_f4,
    "watlow-f4t": _watlow_f4t,
}
STREAM_TWINS: Mapping[str, Callable[[str, StreamSettings, StrappedDown], Twin]] = {
    "csv-imu": _csv_imu,
    "vn100": _vn100,
}
FIELD_TWINS: Mapping[str, Callable[[str, FieldSettings, World], Twin]] = {"manual": _manual_field}


def _twin(ability: Ability, builders: Mapping[str, Builder], driver: str, key: str) -> Builder:
    builder: Builder | None = builders.get(driver) or registered_part(ability, "twin", driver)
    if builder is None:
        raise DescriptionError(f"{key}: driver: {driver!r} has no twin; give its real port")
    return builder
