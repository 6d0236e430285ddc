"""A gain of the meter that drifts is no table beyond its limit, and hides neither such a table nor one that slips."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from physics_scenes import Campaign, campaigns
from solved_campaigns import columns_of, rows_of, table_of

from ams.analysis.diagnostics.beliefs import TABLE_LIMIT
from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from ams.units import RAD_PER_ARCSEC

_COUNT = 6
_PPM = 20.0
"""A replication."""


def _in_time(rows: Observations) -> NDArray[np.int64]:
    """Return the turn of each row."""
    assert rows.time_s is not None
    return np.argsort(np.argsort(rows.time_s))


def _drifting(drawn: Campaign, index: int, *, by_levels: bool = False) -> Observations:
    """Return a campaign read by a meter whose gain goes up evenly, or in the breaks between replications alone."""
    rows = rows_of(drawn)
    gone = rows.replication.astype(float) if by_levels else 6.0 * _in_time(rows) / rows.rows
    gain = 1.0 + 1e-6 * _PPM * gone
    return replace(rows, outputs={axis: gain * columns_of(drawn, axis)[:, index] for axis in drawn.setup.axes})


def _solved(name: str, size: float, *, by_levels: bool = False) -> Iterator[Calibration]:
    drawn = campaigns(name, size, np.random.default_rng(8), _COUNT)
    for index in range(_COUNT):
        yield calibrate(_drifting(drawn, index, by_levels=by_levels), CalibrationRequest(table=table_of()))


def _significant(solved: Calibration) -> list[Finding]:
    return [said for axis in solved.axes.values() for said in axis.findings if said.is_significant]


def _share(found: Iterator[Calibration]) -> float:
    """Return in how many campaigns the table is told to be off."""
    told = [any(said.details.get("test") == TABLE_LIMIT for said in _significant(solved)) for solved in found]
    return float(np.mean(told))


@pytest.mark.parametrize("by_levels", [False, True])
def test_a_gain_that_drifts_with_the_order_of_the_points_is_told_as_that_and_the_table_is_not(by_levels: bool) -> None:
    found = list(_solved("clean", 0.0, by_levels=by_levels))
    assert all(any(said.kind == "drift" for said in _significant(solved)) for solved in found)
    assert _share(iter(found)) == 0.0


@pytest.mark.parametrize("curve", ["table-once", "table-teeth"])
def test_a_table_beyond_its_limit_is_told_beside_a_gain_that_drifts(curve: str) -> None:
    assert _share(_solved(curve, 3.0)) >= 0.85


@pytest.mark.parametrize("arcsec", [3.0, 10.0])
def test_a_slip_of_the_table_is_told_beside_a_gain_that_drifts(arcsec: float) -> None:
    """It passed for drifts of offset, coning and azimuth: "usable", or for a table off by more than is declared."""
    drawn = campaigns("clean", 0.0, np.random.default_rng(9), _COUNT)
    rows = rows_of(drawn)
    late = _in_time(rows) >= int(0.55 * rows.rows)
    slip = np.where(late, arcsec * RAD_PER_ARCSEC, 0.0)
    for index in range(_COUNT):
        seen = _drifting(drawn, index)
        across = {"y": np.cos(rows.roll_rad), "z": -np.sin(rows.roll_rad)}
        outputs = {
            axis: values - np.cos(rows.pitch_rad) * slip * 2.5 * across.get(axis, 0.0)
            for axis, values in seen.outputs.items()
        }
        told = _significant(calibrate(replace(seen, outputs=outputs), CalibrationRequest(table=table_of())))
        assert {said.kind for said in told if not said.is_held} == {"table-rotation"}
        assert all("about roll" in said.text for said in told if said.kind == "table-rotation")
