"""The known voltages that a readout's twin has on the channels of its checks: a short and a reference."""

from rig.abilities.meter_checks import MeterChecks
from rig.description.twin_truth import TwinReadout
from rig.twins.physics.known_voltages import REFERENCE, SHORT, KnownVoltages
from rig.twins.physics.world import World


def wired_checks(checks: MeterChecks) -> dict[int, str]:
    """Return channel number to what is wired to it."""
    names = {"short": SHORT, "reference": REFERENCE}
    return {channel: names[name] for name, channel in checks.channel_numbers().items() if channel is not None}


def known_voltages(name: str, checks: MeterChecks, world: World) -> KnownVoltages:
    """Return what a readout's twin reads: the sensors of the world, and the checks."""
    return KnownVoltages(world, world.meters.get(name, TwinReadout()), checks.reference_v or 0.0)
