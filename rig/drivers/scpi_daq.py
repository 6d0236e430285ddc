"""Data acquisition units that speak SCPI, on a GPIB or on a line."""

from rig.abilities.abilities import Readout
from rig.abilities.cards import card_of_slot
from rig.clock import Clock
from rig.devices.scpi_daq import DEFAULT_ADDRESS, ScpiDaqReadout
from rig.devices.scpi_daq_settings import CARD_CHANNELS, ScpiDaqSettings
from rig.drivers.driver import Driver, ReadoutDriver
from rig.drivers.message_lines import message_line
from rig.drivers.wired_checks import known_voltages, wired_checks
from rig.lines.open_lines import Lines
from rig.twins.physics.world import World
from rig.twins.scpi_daq import ScpiDaqTwin
from rig.twins.scpi_port import ScpiPort
from rig.twins.twin import Twin


def _open(name: str, settings: ScpiDaqSettings, lines: Lines, clock: Clock) -> Readout:
    line = message_line(f"readouts.{name}", settings.resource, lines, DEFAULT_ADDRESS)
    return ScpiDaqReadout(name, settings, line, clock)


def _twin(name: str, settings: ScpiDaqSettings, world: World) -> tuple[Twin, str]:
    wiring = {entry.channel: f"{name}.{channel}" for channel, entry in settings.channels.items()}
    source, wiring = known_voltages(name, settings.checks, world), wiring | wired_checks(settings.checks)
    unit = ScpiDaqTwin(source, wiring, model=settings.model, line_frequency_hz=settings.line_frequency_hz)
    cards = card_of_slot(settings.cards)
    unit.cards |= cards
    unit.card_channels |= {slot: CARD_CHANNELS[card] for slot, card in cards.items() if card in CARD_CHANNELS}
    return ScpiPort(unit), "{port}"


DRIVER = Driver("scpi-daq", readout=ReadoutDriver(ScpiDaqSettings, _open, _twin))
