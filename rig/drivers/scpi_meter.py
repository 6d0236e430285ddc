"""Single multimeters that speak SCPI, on a GPIB, a LAN socket or a serial line."""

from rig.abilities.abilities import Readout
from rig.clock import Clock
from rig.description.device_settings import TWIN_PORT
from rig.devices.scpi_meter import ScpiMeter, ScpiMeterSettings
from rig.drivers.driver import Driver, ReadoutDriver
from rig.drivers.message_lines import message_line
from rig.lines.open_lines import Lines
from rig.twins.physics.world import World
from rig.twins.scpi_meter import ScpiMeterTwin
from rig.twins.scpi_port import ScpiPort
from rig.twins.twin import Twin

DEFAULT_ADDRESS = 22


def _open(name: str, settings: ScpiMeterSettings, lines: Lines, clock: Clock) -> Readout:
    line = message_line(
        f"readouts.{name}", settings.resource, lines, DEFAULT_ADDRESS, baud_rate=settings.baud_rate,
        parity=settings.parity, data_bits=settings.data_bits, stop_bits=float(settings.stop_bits),
    )  # fmt: skip
    is_serial = "+" not in settings.resource and ":" not in settings.resource and settings.resource != TWIN_PORT
    return ScpiMeter(name, settings, line, clock, needs_remote=is_serial and settings.model == "34401A")


def _twin(name: str, settings: ScpiMeterSettings, world: World) -> tuple[Twin, str]:
    channel = f"{name}.{settings.channel_names()[0]}"
    unit = ScpiMeterTwin(
        lambda now_s: world.read_voltage_v(channel, now_s),
        model=settings.model,
        line_frequency_hz=settings.line_frequency_hz,
        is_front=settings.terminals != "rear",
    )
    return ScpiPort(unit, unit.format_error), "{port}"


DRIVER = Driver("scpi-meter", readout=ReadoutDriver(ScpiMeterSettings, _open, _twin))
