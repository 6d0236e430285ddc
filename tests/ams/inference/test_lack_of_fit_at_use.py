"""A chain that bends is as wrong where it is used as where it was calibrated, whatever noise is stated there."""

from datetime import UTC, datetime

import numpy as np
import pytest

from ams.calibration.calibrate import calibrate
from ams.inference.inference import Package, inference
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.provenance import Provenance

NOISE_V, FULL_SCALE_V, REPLICATIONS, ROWS = 2e-5, 10.0, 4, 100
K = np.array([[2.5, 0.02, -0.01], [0.01, 2.48, 0.03], [-0.02, 0.01, 2.52]])
OFFSET_V = np.array([0.005, -0.003, 0.008])


def force(pitch_deg: np.ndarray, roll_deg: np.ndarray) -> np.ndarray:
    pitch, roll = np.radians(pitch_deg), np.radians(roll_deg)
    return np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)])


def outputs_v(f: np.ndarray, ppm: float, chance: np.random.Generator) -> np.ndarray:
    """What a chain reads whose integral nonlinearity is S-shaped, so much of its span of 10 V either way."""
    true_v = OFFSET_V[:, None] + K @ f
    bent_v = ppm * 1e-6 * FULL_SCALE_V * np.sin(2.0 * np.pi * true_v / 5.0)
    return true_v + bent_v + NOISE_V * chance.standard_normal(true_v.shape)


def calibrated(ppm: float, chance: np.random.Generator) -> CoefficientSet:
    grid = np.array([(p, r) for p in np.linspace(-90.0, 90.0, 7) for r in np.arange(-180.0, 180.0, 45.0)])
    pitch, roll = np.tile(grid, (REPLICATIONS, 1)).T
    rows = Observations(
        pitch_rad=np.radians(pitch),
        roll_rad=np.radians(roll),
        outputs=dict(zip("xyz", outputs_v(force(pitch, roll), ppm, chance), strict=True)),
        point=np.tile(np.arange(len(grid)), REPLICATIONS),
        replication=np.repeat(np.arange(REPLICATIONS), len(grid)),
    )
    made = Provenance(
        sensor="SN", gravity_mps2=9.80665, gravity_source="declared", pitch_range_deg=(-90.0, 90.0),
        roll_range_deg=(-180.0, 180.0), created_utc=datetime(2026, 1, 1, tzinfo=UTC), software_version="0", rig="",
        procedure="", simulated=True,
    )  # fmt: skip
    return build_set(calibrate(rows, CalibrationRequest()), made)


@pytest.mark.parametrize("ppm", [0.0, 10.0, 30.0])
def test_angles_hold_the_truth_with_the_noise_of_the_place_of_use(ppm: float) -> None:
    """Its true noise is stated; of 30 ppm the angles held in 0.63, for its lack of fit was in the default alone."""
    chance, held, widths = np.random.default_rng([11, int(ppm)]), [], []
    for _ in range(12):
        package = Package(calibrated(ppm, chance), {axis: f"{axis}_v" for axis in "xyz"})
        pitch, roll = chance.uniform(-70.0, 70.0, ROWS), chance.uniform(-180.0, 180.0, ROWS)
        readings = dict(zip(("x_v", "y_v", "z_v"), outputs_v(force(pitch, roll), ppm, chance), strict=True))
        found = inference(package, reading_sd_v=NOISE_V, intervals=True).infer(readings)
        half_deg = np.asarray(found["pitch_half_95_deg"])
        held.append(np.abs(np.asarray(found["pitch_deg"]) - pitch) <= half_deg)
        widths.append(half_deg)
    assert np.mean(held) >= 0.91
    if ppm == 0.0:
        assert np.mean(held) <= 0.985, "nothing is widened where nothing bends"
