"""Meters that read angles, on a serial line or a socket: references of attitude."""

from rig.abilities.abilities import Readout
from rig.clock import Clock
from rig.devices.angle_meter import AngleMeter, AngleMeterSettings
from rig.drivers.driver import Driver, ReadoutDriver
from rig.lines.open_lines import Lines
from rig.twins.angle_meter import AngleMeterTwin
from rig.twins.physics.world import World
from rig.twins.twin import Twin
from rig.wire.angle_dialect import AngleUnit, load_angle_dialect
from rig.wire.angle_lines import AngleCodec


def _open(name: str, settings: AngleMeterSettings, lines: Lines, clock: Clock) -> Readout:
    dialect = load_angle_dialect(settings.dialect)
    line = dialect.line.model_dump()
    line |= {} if settings.baud_rate is None else {"baud_rate": settings.baud_rate}
    return AngleMeter(name, settings, dialect, lines.stream(f"readouts.{name}", settings.resource, **line), clock)


def _twin(name: str, settings: AngleMeterSettings, world: World) -> tuple[Twin, str]:
    dialect = load_angle_dialect(settings.dialect)
    units = (settings.values, dialect.unit, *dialect.units.values())
    unit: AngleUnit = next(unit for unit in units if unit is not None)
    channel_of = {(channel.axis, channel.value): channel for channel in settings.channels.values()}

    def reading_deg(axis: int, value: str, now_s: float) -> float:
        channel = channel_of.get((axis, "x" if value == "x" else "y"))
        if channel is None:
            return 0.0
        return channel.reading_deg(world.read_attitude_deg(name, channel.about, now_s))

    return AngleMeterTwin(AngleCodec(dialect), unit, reading_deg), "{port}"


DRIVER = Driver("angle-meter", readout=ReadoutDriver(AngleMeterSettings, _open, _twin))
