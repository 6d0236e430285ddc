"""Supplies and load resistors between the twins' sensors and their meters."""

from collections.abc import Mapping

from rig.description.rig_file import RigDescription, TwinSection
from rig.description.twin_truth import TwinSupply


def _nominal_v(description: RigDescription) -> dict[str, float]:
    """Return what every supply gives where nothing is wrong with it, by channel.

    What its chain declares; a supply that is only watched, by an interlock, stands in the middle of its band: a twin at
    0 V would hold every run for a fault that nobody planned.
    """
    supplies = {
        chain.supply_channel: chain.reference_supply_v
        for chain in description.chain.values()
        if chain.supply_channel is not None
    }
    sensors = description.sensors.values()
    sensed = {channel for sensor in sensors for channel in sensor.channels.values()}
    sensed |= {sensor.temperature.channel for sensor in sensors if sensor.temperature}
    watched = {name: sum(lock.band_v) / 2.0 for name, lock in description.interlocks.voltage.items()}
    names = supplies.keys() | (watched.keys() - sensed)
    return {name: supplies.get(name) or watched.get(name, 0.0) for name in names}


class ChainTruth:
    """What every declared chain does to its channel."""

    def __init__(self, description: RigDescription) -> None:
        twin = description.twin or TwinSection()
        self._chains = description.chain
        self._truth = twin.supplies
        self._nominal_v = _nominal_v(description)

    def supply_v(self, channel: str, replications: float) -> float | None:
        """Return what a supply's own channel carries; None for a channel that is none."""
        nominal_v = self._nominal_v.get(channel)
        if nominal_v is None:
            return None
        truth = self._truth.get(channel, TwinSupply())
        return nominal_v + truth.error_v + truth.drift_v_per_replication * replications

    def factor(self, channel: str, replications: float, degc: Mapping[str, float]) -> float:
        """Return what the chain makes of one volt. ``degc``: environment to its true temperature."""
        chain = self._chains.get(channel)
        if chain is None:
            return 1.0
        made = 1.0
        if chain.ratiometric and chain.supply_channel is not None:
            now_v = self.supply_v(chain.supply_channel, replications)
            made *= 1.0 if now_v is None else now_v / self._nominal_v[chain.supply_channel]
        if chain.load_resistor_ohm is not None and chain.load_resistor_at is not None:
            warmer_degc = degc[chain.load_resistor_at] - chain.load_resistor_degc
            ohm = chain.load_resistor_ohm + chain.load_resistor_ohm * chain.load_resistor_tc_per_degc * warmer_degc
            made *= ohm / chain.load_resistor_ohm
        return made
