"""How far the meter of a rig file can read the outputs of a file: what is beyond was never read by it."""

from collections.abc import Mapping

from ams.inputs.possible_outputs import Reach
from rig.description.cross_checks import OVER_RANGE
from rig.description.rig_file import RigDescription, Sensor


def meter_reach(rig: RigDescription, sensor: Sensor | None) -> Mapping[str, Reach]:
    """Return sensor axis to what its meter reads at most; axes of no declared range are left out."""
    if sensor is None:
        return {}
    found: dict[str, Reach] = {}
    for axis, channel in sensor.channels.items():
        readout, _, name = channel.partition(".")
        range_v = rig.readouts[readout].range_of_channel_v(name) if readout in rig.readouts else None
        if range_v is not None:
            why = f"{channel} of the rig file has a range of {range_v:g} V and reads {OVER_RANGE:g} times that"
            found[str(axis)] = Reach(OVER_RANGE * range_v, why, ", or correct range_v of the rig file")
    return found
