"""Rows of a package that is as it was calibrated: its axes contradict each other once in a thousand rows.

Every campaign is a calibration of its own, with its own set, and rows over the whole range of use with noise of their
own, so that what one calibration happens to be wrong by is one draw among many.
"""

from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest
from physics_scenes import campaigns
from solved_campaigns import columns_of, rows_of

from ams.attitude import flag_codes
from ams.calibration.calibrate import calibrate
from ams.inference.inference import Package, inference
from ams.inference.watch.watched_axes import answered_at_once, watched_axes
from ams.inputs.request import CalibrationRequest
from ams.sets.coefficients import build_set
from ams.sets.provenance import Provenance

SENSITIVITY_V_PER_G = 2.5
PART = 200
PIECE = 20
SAID = np.uint64(flag_codes.REDUNDANCY | flag_codes.FAULTY)
PROVENANCE = Provenance(
    sensor="SN", gravity_mps2=9.80665, gravity_source="declared", pitch_range_deg=(-90.0, 90.0),
    roll_range_deg=(-180.0, 180.0), created_utc=datetime(2026, 1, 1, tzinfo=UTC), software_version="0", rig="",
    procedure="", simulated=True,
)  # fmt: skip


def _flagged(sets: int, seed: int) -> np.ndarray:
    """Return by set the share of rows whose axes contradict each other, all at once and piece by piece, (sets, 2)."""
    drawn = campaigns("use-good", 0.0, np.random.default_rng(seed), sets)
    axes = drawn.use.setup.axes
    sd_v = np.deg2rad(drawn.use.setup.noise_arcsec / 3600.0) * SENSITIVITY_V_PER_G
    outputs = {axis: columns_of(drawn.calibration, axis) for axis in axes}
    shares = []
    for index in range(sets):
        rows = replace(rows_of(drawn.calibration), outputs={axis: outputs[axis][:, index] for axis in axes})
        coefficients = build_set(calibrate(rows, CalibrationRequest()), PROVENANCE)
        package = Package(coefficients, {axis: f"{axis}_v" for axis in axes})
        readings = {f"{axis}_v": drawn.use.output_v[index, :, 0, which] for which, axis in enumerate(axes)}
        angles = inference(package, reading_sd_v=sd_v)
        codes = answered_at_once(angles, readings).codes
        watched, rows = watched_axes(angles), codes.size
        pieces = [{n: v[part] for n, v in readings.items()} for part in np.array_split(np.arange(rows), rows // PIECE)]
        streamed = np.concatenate([watched.answer(piece).codes for piece in pieces])
        shares.append([np.mean((of.astype(np.uint64) & SAID) != 0) for of in (codes, streamed)])
    return np.array(shares)


def test_hardly_a_row_of_a_good_package_is_flagged() -> None:
    shares = _flagged(20, seed=9)
    assert np.mean(shares) < 0.005


@pytest.mark.soak
def test_one_row_in_a_thousand_is_flagged_over_two_thousand_sets() -> None:
    shares = np.concatenate([_flagged(PART, seed) for seed in range(2000 // PART)])
    assert len(shares) == 2000
    assert np.all(shares.mean(axis=0) > 0.0005)
    assert np.all(shares.mean(axis=0) < 0.002)
