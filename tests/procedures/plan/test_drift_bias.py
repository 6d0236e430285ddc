"""Laws of a drift inside a replication: forward-reverse leaves none of it, a serpentine gives it to a sensitivity."""

import numpy as np
import pytest

from ams.models.accelerometer import PitchRoll
from procedures.plan.designs import full_grid
from procedures.plan.drift_bias import drift_bias

GRID = full_grid(np.arange(-60.0, 61.0, 15.0).tolist(), np.arange(-180.0, 180.0, 30.0).tolist())


def test_forward_reverse_leaves_no_bias_in_any_parameter() -> None:
    assert max(map(abs, drift_bias(PitchRoll("x"), GRID, 2.5)["forward-reverse"].values())) < 1e-12


def test_the_bias_is_what_a_drifting_campaign_is_solved_to() -> None:
    """Raster: pitch rises with time row by row, so sin(pitch) takes the drift; the slope of a line through it."""
    found = drift_bias(PitchRoll("x"), GRID, 2.5)["raster"]
    pitch = np.repeat(np.deg2rad(np.arange(-60.0, 61.0, 15.0)), 12)
    drift = (np.arange(pitch.size) + 0.5) / pitch.size - 0.5
    assert found["k_x_v_per_g"] == pytest.approx(np.polyfit(np.sin(pitch), drift, 1)[0], rel=1e-9)
    assert found["k_x_v_per_g"] > 5.0 * abs(drift_bias(PitchRoll("x"), GRID, 2.5)["there-and-back"]["k_x_v_per_g"])
