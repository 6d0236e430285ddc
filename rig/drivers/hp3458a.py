"""HP 3458A with an HP 3488A scanner before it, each with an address of its own on a GPIB."""

from rig.abilities.abilities import Readout
from rig.abilities.cards import card_of_slot
from rig.clock import Clock
from rig.description.device_settings import TWIN_PORT
from rig.devices.hp3458a import Hp3458aReadout, Hp3458aSettings, scanner_resource
from rig.drivers.driver import Driver, ReadoutDriver
from rig.drivers.wired_checks import known_voltages, wired_checks
from rig.errors import DescriptionError
from rig.lines.open_lines import Lines
from rig.link.gpib import parse_resource
from rig.twins.hp3458a import Hp3458aTwin
from rig.twins.hp3488a import Hp3488aTwin
from rig.twins.physics.known_voltages import OUTPUT_OHM
from rig.twins.physics.world import World
from rig.twins.prologix import GpibInstrument, PrologixTwin
from rig.twins.scanned_input import ScannedInput
from rig.twins.twin import Twin
from rig.wire import hp3458a as meter_wire
from rig.wire import hp3488a as scanner_wire


def _open(name: str, settings: Hp3458aSettings, lines: Lines, clock: Clock) -> Readout:
    meter_bus = lines.bus(f"readouts.{name}", parse_resource(settings.resource, meter_wire.DEFAULT_ADDRESS))
    scanner_bus = lines.bus(f"readouts.{name}", scanner_resource(settings))
    return Hp3458aReadout(name, settings, meter_bus, clock, scanner_bus)


def _twin(name: str, settings: Hp3458aSettings, world: World) -> tuple[Twin, str]:
    if settings.scanner_resource not in (None, TWIN_PORT):
        raise DescriptionError(
            f"readouts.{name}: scanner_resource: a meter's twin needs its scanner's twin; leave it out"
        )
    wiring = {entry.scanner_channel: f"{name}.{channel}" for channel, entry in settings.channels.items()}
    wiring |= wired_checks(settings.checks)
    source = known_voltages(name, settings.checks, world)
    fitting = {slot: scanner_wire.cards_for(numbers)[0] for slot, numbers in scanner_wire.by_slot(wiring).items()}
    scanner = Hp3488aTwin(fitting | card_of_slot(settings.cards))
    twin = Hp3458aTwin(ScannedInput(source, scanner, wiring, {**world.output_ohm, **OUTPUT_OHM}))
    twin.inside_degc = source.inside_degc
    twin.is_front = settings.terminals != "rear"
    instruments: dict[int, GpibInstrument] = {
        meter_wire.DEFAULT_ADDRESS: twin,
        scanner_wire.DEFAULT_ADDRESS: scanner,
    }
    return PrologixTwin(instruments), f"prologix+{{port}}#{meter_wire.DEFAULT_ADDRESS}"


DRIVER = Driver("hp3458a", readout=ReadoutDriver(Hp3458aSettings, _open, _twin))
