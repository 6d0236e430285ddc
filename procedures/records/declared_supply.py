"""Readings at the declared supply and load resistor, for whoever compares dwells while the run goes on.

A supply that drifts moves every reading of a ratiometric sensor: that is no wrong tooth, no swapped channel and no step
of a restart. What is stored stays as it was read.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import isfinite

from procedures.records.dwells import ChannelReading, DwellRecord
from rig.description.signal_chain import Chain


def correcting(chains: Mapping[str, Chain]) -> dict[str, Chain]:
    """Return the chains that change what is read."""
    return {channel: chain for channel, chain in chains.items() if chain.corrects}


def at_declared(record: DwellRecord, chains: Mapping[str, Chain]) -> DwellRecord:
    """Return the record with the corrected channels' samples as they would be by declaration.

    Supplies of ratiometric sensors are left out.

    Where a supply was not read, or overloaded, its sensor's reading stays as it is.
    """
    if not chains:
        return record
    supplies = {chain.supply_channel for chain in chains.values() if chain.ratiometric}
    readings = {
        channel: _at_declared(reading, record, chains.get(channel))
        for channel, reading in record.readings.items()
        if channel not in supplies
    }
    return replace(record, readings=readings)


def _at_declared(reading: ChannelReading, record: DwellRecord, chain: Chain | None) -> ChannelReading:
    if chain is None:
        return reading
    supply = record.readings.get(chain.supply_channel or "")
    supply_v = None if supply is None or not isfinite(supply.mean) else supply.mean
    resistor_degc = None if chain.load_resistor_at is None else record.temperature_degc.get(chain.load_resistor_at)
    factor = chain.factor(supply_v, resistor_degc)
    return replace(reading, samples=reading.samples / factor) if factor else reading
