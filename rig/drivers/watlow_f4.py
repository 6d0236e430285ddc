"""Watlow's F4: a chamber on a Modbus line."""

from rig.abilities.abilities import Environment
from rig.devices import watlow_f4
from rig.devices.watlow_f4 import WatlowF4Settings
from rig.drivers.driver import Driver, EnvironmentDriver
from rig.lines.open_lines import Lines
from rig.twins.physics.world import World
from rig.twins.twin import Twin
from rig.twins.watlow_f4 import WatlowF4Twin


def _open(name: str, settings: WatlowF4Settings, lines: Lines) -> Environment:
    return watlow_f4.connect(name, settings, lines.stream(f"environment.{name}", settings.port, settings.baud_rate))


def _twin(name: str, settings: WatlowF4Settings, world: World, time_factor: float) -> Twin:
    return WatlowF4Twin(name, world, unit=settings.unit, gap_s=time_factor)


DRIVER = Driver("watlow-f4", environment=EnvironmentDriver(WatlowF4Settings, _open, _twin), speaks_modbus=True)
