"""Watlow's F4T: a chamber on Modbus, by line or TCP."""

from rig.abilities.abilities import Environment
from rig.devices import watlow_f4t
from rig.devices.watlow_f4t import WatlowF4TSettings
from rig.drivers.driver import Driver, EnvironmentDriver
from rig.lines.open_lines import Lines
from rig.twins.modbus_slave import ModbusSlave
from rig.twins.physics.world import World
from rig.twins.twin import Twin
from rig.twins.watlow_f4t import WatlowF4TTwin


def _open(name: str, settings: WatlowF4TSettings, lines: Lines) -> Environment:
    return watlow_f4t.connect(name, settings, lines.stream(f"environment.{name}", settings.port, settings.baud_rate))


def _twin(name: str, settings: WatlowF4TSettings, world: World, time_factor: float) -> Twin:
    registers = WatlowF4TTwin(
        name, world, loop=settings.loop, word_order=settings.word_order, fahrenheit=settings.values == "degf"
    )
    return ModbusSlave(registers, unit=settings.unit, framing=settings.transport, gap_s=time_factor)


DRIVER = Driver("watlow-f4t", environment=EnvironmentDriver(WatlowF4TSettings, _open, _twin), speaks_modbus=True)
