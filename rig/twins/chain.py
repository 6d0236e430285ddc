"""Supplies and load resistors between the twins' sensors and their meters."""

from collections.abc import Mapping

from rig.description.rig_file import RigDescription, TwinSection
from rig.description.twin_truth import TwinSupply


class ChainTruth:
    """What every declared chain does to its channel."""

    def __init__(self, description: RigDescription) -> None:
        twin = description.twin or TwinSection()
        self._chains = description.chain
        self._truth = twin.supplies
        self._nominal_v = {
            chain.supply_channel: chain.reference_supply_v or 0.0
            for chain in description.chain.values()
            if chain.supply_channel is not None
        }

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
