"""Laws of a drift inside a replication: forward-reverse leaves none of it, a serpentine gives it to a sensitivity."""

import numpy as np
import pytest

from ams.calibration.calibrate import calibrate
from ams.calibration.together.in_step_hidden import in_step_correlation
from ams.inputs.request import CalibrationRequest
from ams.models.accelerometer import PitchRoll
from ams.observations import Observations
from procedures.description.procedure_file import Order
from procedures.plan.designs import full_grid
from procedures.plan.drift_bias import COMPARED, drift_bias
from procedures.plan.order import sequence, visits
from procedures.plan.specific_force import columns_of

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


@pytest.mark.parametrize("order", COMPARED)
def test_a_campaign_that_drifts_is_off_by_the_predicted_bias_and_by_nothing_else(order: Order) -> None:
    """Solved as a run is, for every axis: nothing but a linear drift of the offset inside each replication."""
    visited = sequence(visits(GRID, order), order, np.random.default_rng([0, 1]))
    pitch, roll = (np.deg2rad([getattr(point, f"{name}_deg") for point in visited]) for name in ("pitch", "roll"))
    drift = (np.arange(len(visited)) + 0.5) / len(visited) - 0.5
    force = {"x": np.sin(pitch), "y": -np.cos(pitch) * np.sin(roll), "z": -np.cos(pitch) * np.cos(roll)}
    count = len(visited)
    rows = Observations(
        replication=np.repeat([1, 2], count),
        point=np.tile([point.label for point in visited], 2),
        pitch_rad=np.tile(pitch, 2),
        roll_rad=np.tile(roll, 2),
        outputs={axis: np.tile(0.01 + 2.5 * own + 1e-4 * drift, 2) for axis, own in force.items()},
        source="drift",
    )
    solved = calibrate(rows, CalibrationRequest(extended="no"))
    for axis, found in solved.axes.items():
        predicted = drift_bias(PitchRoll(axis), GRID, 2.5)[order]
        true = {"offset_v": 0.01, f"k_{axis}_v_per_g": 2.5}
        for name, value in zip(found.primary_names, found.primary, strict=True):
            assert value - true.get(name, 0.0) == pytest.approx(1e-4 * predicted[name], abs=1e-12)
            if order == "forward-reverse":
                assert abs(predicted[name]) < 1e-12


@pytest.mark.parametrize("order", COMPARED)
def test_what_comes_back_in_each_replication_goes_with_the_model_by_the_worst_phase(order: Order) -> None:
    """Found here by fits of single waves; there and back, a cosine is nearly −sin of pitch."""
    visited = sequence(visits(GRID, order), order, np.random.default_rng([0, 1]))
    pitch, roll = (np.deg2rad([getattr(point, f"{name}_deg") for point in visited]) for name in ("pitch", "roll"))
    terms = np.stack(
        [np.ones_like(pitch), np.sin(pitch), np.cos(pitch) * np.sin(roll), np.cos(pitch) * np.cos(roll)], axis=1
    )
    at = 2.0 * np.pi * np.arange(pitch.size) / pitch.size
    largest = 0.0
    for periods in (1, 2, 3):
        for phase in np.linspace(0.0, np.pi, 181):
            wave = np.cos(periods * at + phase)
            left = wave - terms @ np.linalg.lstsq(terms, wave, rcond=None)[0]
            largest = max(largest, float(np.sqrt(1.0 - left @ left / (wave @ wave))))
    found = in_step_correlation(columns_of(PitchRoll("x"), visited, 2.5))
    assert found == pytest.approx(largest, abs=1e-3)
    assert (found > 0.95) is (order in ("there-and-back", "forward-reverse"))
