"""Chambers that speak lines of text, on a serial line or a socket."""

from rig.abilities.abilities import Environment
from rig.devices.ascii_chamber import AsciiChamber, AsciiChamberSettings
from rig.drivers.driver import Driver, EnvironmentDriver
from rig.lines.open_lines import Lines
from rig.twins.ascii_chamber import AsciiChamberTwin
from rig.twins.physics.world import World
from rig.twins.twin import Twin


def _open(name: str, settings: AsciiChamberSettings, lines: Lines) -> Environment:
    return AsciiChamber(name, settings, lines.stream(f"environment.{name}", settings.port, settings.baud_rate))


def _twin(name: str, settings: AsciiChamberSettings, world: World, time_factor: float) -> Twin:  # noqa: ARG001 it answers at once
    return AsciiChamberTwin(
        name,
        world,
        model=settings.model,
        is_fahrenheit=settings.values == "degf",
        channel=settings.channel,
        address=settings.address,
        reply_end=b"\r\n" if settings.reply_end == "lf" else b"\r",
    )


DRIVER = Driver("ascii-chamber", environment=EnvironmentDriver(AsciiChamberSettings, _open, _twin))
