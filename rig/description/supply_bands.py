"""What several chains state of one supply, taken together: a supply is watched where all of them allow it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from rig.description.rig_file import RigDescription
from rig.description.signal_chain import Chain
from rig.toml_file import TomlFile


@dataclass(frozen=True, slots=True)
class SupplyBand:
    """What every chain of a supply allows; nothing where ``low_v`` is above ``high_v``."""

    low_v: float
    high_v: float
    low_chain: str
    """The channel whose chain states the lower end."""
    high_chain: str

    @property
    def keys(self) -> str:
        """Where both ends are stated."""
        chains = dict.fromkeys((self.low_chain, self.high_chain))
        return " and ".join(f"chain.{channel}.supply_band_v" for channel in chains)


def supply_bands(chains: Mapping[str, Chain]) -> dict[str, SupplyBand]:
    """Return the band that all chains of a supply have in common, by the channel of the supply."""
    found: dict[str, SupplyBand] = {}
    for channel, chain in chains.items():
        if chain.supply_channel is None or chain.supply_band_v is None:
            continue
        low_v, high_v = chain.supply_band_v
        band = found.get(chain.supply_channel, SupplyBand(low_v, high_v, channel, channel))
        if low_v > band.low_v:
            band = SupplyBand(low_v, band.high_v, channel, band.high_chain)
        if high_v < band.high_v:
            band = SupplyBand(band.low_v, high_v, band.low_chain, channel)
        found[chain.supply_channel] = band
    return found


def contradicting_supplies(file: TomlFile, rig: RigDescription) -> Iterable[str]:
    """Yield bands that no supply can keep and nominal voltages outside their own band.

    Of files only: journals hold rigs from before they were refused.
    """
    for channel, chain in rig.chain.items():
        if chain.supply_band_v is None:
            continue
        low_v, high_v = chain.supply_band_v
        if low_v >= high_v:
            yield file.complaint(
                ("chain", channel, "supply_band_v"),
                f"got [{low_v:g}, {high_v:g}], allowed is a lower end below the upper one, in volts",
            )
        elif chain.supply_nominal_v is not None and not low_v <= chain.supply_nominal_v <= high_v:
            yield file.complaint(
                ("chain", channel, "supply_nominal_v"),
                f"got {chain.supply_nominal_v:g} V, allowed {low_v:g} to {high_v:g} V (its supply_band_v); "
                "correct one of them",
            )
    sound = {
        channel: chain
        for channel, chain in rig.chain.items()
        if chain.supply_band_v is not None and chain.supply_band_v[0] < chain.supply_band_v[1]
    }
    for supply, band in supply_bands(sound).items():
        if band.low_v > band.high_v:
            key = ("chain", band.high_chain, "supply_band_v")
            yield file.complaint(
                key,
                f"{supply} is to stay at or below {band.high_v:g} V here and at or above {band.low_v:g} V by "
                f"chain.{band.low_chain}.supply_band_v ({file.where(('chain', band.low_chain, 'supply_band_v'))}): no "
                "supply keeps both, and every run would hold at once; correct one of them, or the supply_channel",
            )
