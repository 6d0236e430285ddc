"""Dwells whose recorded temperature no sensor stands, set aside from the sensor that it is the temperature of.

A thermometer that reads 850 °C once says nothing of the readings beside it, which its temperature would correct, or
place in the range of validity. Many such dwells are a thermometer in another unit, or one that is broken, and no
calibration: the solver refuses them with the likely unit.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from ams.analysis.diagnostics.dwell_words import dwell_words
from ams.analysis.diagnostics.take_back import ways_back_of, ways_in_words
from ams.arrays import FloatArray
from ams.findings import Finding
from ams.inputs.request import select_rows
from ams.models.possible_temperature import POSSIBLE, impossible_temperatures
from ams.observations import Observations
from procedures.plan.channels import temperature_source
from procedures.records.dwells import DwellRecord
from procedures.solution.observations import design_dwells, observations_of, temperatures_degc
from procedures.solution.request import SensorRows

TEST: Final = "temperature of the dwell"
_LARGEST_PART: Final = 0.1
"""Of the dwells; one may always be set aside."""
_MOST_LISTED: Final = 5


class SetAside(NamedTuple):
    """A sensor with the dwells that are solved, and what is said of the others."""

    item: SensorRows
    findings: tuple[Finding, ...] = ()


def without_wild_temperatures(item: SensorRows) -> SetAside:
    """Return a sensor without single dwells whose temperature no sensor stands, with a finding that names them.

    A long rest has no dwells beside that could stand for one. Raises: JournalError.
    """
    dwells = design_dwells(item.dwells)
    if item.plan.is_single_rest or len(dwells) < 2:
        return SetAside(item)
    read_degc = _read_degc(item, dwells)
    is_wild = impossible_temperatures(read_degc)
    count = int(np.count_nonzero(is_wild))
    if not 0 < count <= max(1, int(_LARGEST_PART * is_wild.size)):
        return SetAside(item)
    kept = tuple(dwell for dwell, wild in zip(dwells, is_wild.tolist(), strict=True) if not wild)
    rows = observations_of(dwells, item.channels, None, item.source, run=item.run)
    ways = ways_in_words(ways_back_of(is_wild, rows))
    finding = _finding(select_rows(rows, is_wild), read_degc[is_wild].tolist(), ways)
    return SetAside(replace(item, dwells=kept), (finding,))


def _read_degc(item: SensorRows, dwells: Sequence[DwellRecord]) -> FloatArray:
    """Return (N,) what was read as the temperature of the sensor or of its load resistors, an impossible one first."""
    of_sensor = temperatures_degc(dwells, temperature_source(item.rig, item.sensor), item.source, item.rig.chain)
    found = np.full(len(dwells), np.nan) if of_sensor is None else of_sensor
    for environment in _resistors_at(item):
        read = np.array([dwell.temperature_degc.get(environment, np.nan) for dwell in dwells], dtype=float)
        found = np.where(impossible_temperatures(read), read, found)
    return found


def _resistors_at(item: SensorRows) -> Sequence[str]:
    """Return the environments whose temperature brings readings of the sensor to their declared load resistors."""
    chains = [item.rig.chain[channel] for channel in item.channels.values() if channel in item.rig.chain]
    return tuple(dict.fromkeys(chain.load_resistor_at for chain in chains if chain.load_resistor_at is not None))


def _finding(rows: Observations, read_degc: Sequence[float], ways: str) -> Finding:
    each = [f"{dwell_words(rows, row)} with {read:.4g} °C" for row, read in enumerate(read_degc[:_MOST_LISTED])]
    more = rows.rows - len(each)
    listed = "; ".join(each) + (f"; and {more} more" if more else "")
    assert rows.step is not None
    steps = tuple(int(step) for step in rows.step)
    which, was = ("that dwell", "was") if rows.rows == 1 else ("these dwells", "were")
    fact = (
        f"the recorded temperature is one that no sensor stands: {listed}; allowed {POSSIBLE}; {which} {was} set "
        "aside: the result is that of the others"
    )
    details: dict[str, float | str | None] = {
        "test": TEST,
        "temperature_degc": read_degc[0],
        "replication": float(rows.replication[0]),
        "point": float(rows.point[0]),
    }
    what_to_do = f"look at the thermometer and its wiring, and measure again ({ways})"
    return Finding("wrong-dwell", fact, True, None, steps, details, what_to_do=what_to_do)
