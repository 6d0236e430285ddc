"""A package moved on its seat in between: common offset and sensitivity, a coning angle and azimuth per mounting."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from ams.calibration.calibrate import calibrate
from ams.calibration.mountings import calibrate_mountings
from ams.errors import DesignError
from ams.inputs.request import CalibrationRequest
from ams.models.remounted import Remounted
from ams.observations import Observations

FloatArray = NDArray[np.float64]

NOISE_V, OFFSET_V, SENSITIVITY = 2e-5, 0.005, 2.5
PITCH, ROLL = (
    grid.ravel()
    for grid in np.meshgrid(np.deg2rad(np.arange(-60.0, 61.0, 20.0)), np.deg2rad(np.arange(-180.0, 180.0, 45.0)))
)
K = PITCH.size
TRUTH_DEG = {1: (0.5, 35.0), 2: (0.9, -70.0)}
"""Mounting to coning and azimuth of the x sensor."""


def _force(pitch: FloatArray, roll: FloatArray) -> FloatArray:
    """TP (2) written out once more."""
    return np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)], axis=-1)


def _direction(coning_deg: float, azimuth_deg: float) -> FloatArray:
    c, a = np.deg2rad(coning_deg), np.deg2rad(azimuth_deg)
    return np.array([np.cos(c), np.sin(c) * np.cos(a), np.sin(c) * np.sin(a)])


def _campaign(chance: np.random.Generator, mounting: NDArray[np.int64], noise_v: float = NOISE_V) -> Observations:
    """One row a point for every replication; ``mounting`` per row."""
    replications = mounting.size // K
    pitch, roll = np.tile(PITCH, replications), np.tile(ROLL, replications)
    force = _force(pitch, roll)
    along = np.select(
        [mounting == label for label in TRUTH_DEG], [force @ _direction(*angles) for angles in TRUTH_DEG.values()]
    )
    drift_v = np.repeat(0.5 * noise_v * chance.standard_normal(replications), K)
    output_v = OFFSET_V + drift_v + SENSITIVITY * along + noise_v * chance.standard_normal(mounting.size)
    return Observations(
        replication=np.repeat(np.arange(1, replications + 1), K),
        point=np.tile(np.arange(1, K + 1), replications),
        pitch_rad=pitch,
        roll_rad=roll,
        outputs={"x": output_v},
        mounting=mounting,
    )


def _split(replications: int, first: int, rows_more: int = 0) -> NDArray[np.int64]:
    """Moved after ``first`` replications and so many dwells of the next."""
    moved = first * K + rows_more
    return np.where(np.arange(replications * K) < moved, 1, 2)


def _found(observations: Observations) -> dict[str, tuple[float, float]]:
    axis = calibrate_mountings(observations, CalibrationRequest(extended="no")).axes["x"]
    return {
        parameter.name: (float(parameter.value or 0.0), float(parameter.standard_uncertainty or 0.0))
        for parameter in axis.parameters
    }


@pytest.mark.parametrize("nominal", ["x", "y", "z"])
def test_the_derivatives_are_those_of_a_complex_step(nominal: str) -> None:
    model = Remounted(nominal, (1, 3))
    chance = np.random.default_rng(2)
    rows = _campaign(chance, np.repeat([1, 3, 4], K))
    primary = np.concatenate([[0.1], 2.5 * np.eye(3)["xyz".index(nominal)] + 0.05, [0.02, -0.03, 0.3, 0.2]])
    by_step = np.stack(
        [np.imag(model.predict(primary + 1e-30j * step, rows)) / 1e-30 for step in np.eye(primary.size)], axis=1
    )
    np.testing.assert_allclose(model.jacobian(primary, rows), by_step, atol=1e-14)
    step = 1e-7
    numeric = np.stack(
        [(model.parameters(primary + step * e) - model.parameters(primary - step * e)) / (2 * step)
         for e in np.eye(primary.size)], axis=1,
    )  # fmt: skip
    np.testing.assert_allclose(model.parameters_jacobian(primary), numeric, rtol=2e-6, atol=2e-6)


def test_without_noise_every_mounting_comes_back_to_ten_digits() -> None:
    rows = _campaign(np.random.default_rng(1), _split(4, 2), noise_v=1e-15)
    axis = calibrate_mountings(rows, CalibrationRequest(extended="no")).axes["x"]
    found = {parameter.name: parameter.value for parameter in axis.parameters}
    assert found["offset_v"] == pytest.approx(OFFSET_V, rel=1e-10)
    assert found["sensitivity_v_per_g"] == pytest.approx(SENSITIVITY, rel=1e-10)
    assert found["coning_deg"] == pytest.approx(0.9, rel=1e-9)
    assert found["azimuth_deg"] == pytest.approx(-70.0, rel=1e-9)
    earlier = axis.notes["mountings"]["earlier"]  # type: ignore[index]
    assert earlier["mounting_1_coning_deg"].value == pytest.approx(0.5, rel=1e-9)
    assert earlier["mounting_1_azimuth_deg"].value == pytest.approx(35.0, rel=1e-9)


def test_one_fit_over_a_move_that_nobody_told_of_is_wrong_and_this_one_is_right() -> None:
    rows = _campaign(np.random.default_rng(3), _split(6, 3))
    blind = calibrate(replace(rows, mounting=None), CalibrationRequest(extended="no")).axes["x"]
    right = calibrate_mountings(rows, CalibrationRequest(extended="no")).axes["x"]
    assert blind.standard_error_v > 100.0 * right.standard_error_v
    assert right.standard_error_v == pytest.approx(1.12 * NOISE_V, rel=0.2)


def test_the_set_speaks_of_the_last_mounting_in_the_words_of_one() -> None:
    solved = calibrate_mountings(_campaign(np.random.default_rng(4), _split(6, 3)), CalibrationRequest(extended="no"))
    axis = solved.axes["x"]
    assert [parameter.name for parameter in axis.parameters] == [
        "offset_v",
        "sensitivity_v_per_g",
        "coning_deg",
        "azimuth_deg",
    ]
    assert axis.primary_covariance.shape == axis.covariance.shape == (4, 4)
    assert (solved.model, axis.model) == ("pitch-roll", "pitch-roll")
    assert "coning and azimuth are those of mounting 2, the last" in solved.warnings[-1]
    total = sum(part.covariance for part in axis.variance_components)
    np.testing.assert_allclose(total, axis.primary_covariance, rtol=1e-9, atol=1e-24)


def test_one_mounting_is_the_ordinary_calibration() -> None:
    rows = _campaign(np.random.default_rng(5), np.full(3 * K, 1, dtype=np.int64))
    plain = calibrate(replace(rows, mounting=None), CalibrationRequest(extended="no"))
    assert (
        calibrate_mountings(rows, CalibrationRequest(extended="no")).axes["x"].parameters == plain.axes["x"].parameters
    )


def test_as_many_moves_as_replications_are_said_to_hide_drift() -> None:
    solved = calibrate_mountings(_campaign(np.random.default_rng(6), _split(2, 1)), CalibrationRequest(extended="no"))
    assert "2 replications over 2 mountings: drift between replications cannot be told" in solved.warnings[-1]


def test_models_without_an_azimuth_to_turn_are_refused() -> None:
    rows = _campaign(np.random.default_rng(6), _split(4, 2))
    with pytest.raises(DesignError, match="got 2 mountings for model pitch-only, allowed one"):
        calibrate_mountings(rows, CalibrationRequest(model="pitch-only", extended="no"))


def test_a_mounting_of_too_few_dwells_is_refused_in_words() -> None:
    rows = _campaign(np.random.default_rng(7), _split(4, 0, 1))
    with pytest.raises(DesignError, match="mounting_1"):
        calibrate_mountings(rows, CalibrationRequest(extended="no"))


@pytest.mark.parametrize(
    ("mounting", "campaigns"),
    [
        pytest.param(_split(6, 3), 150, id="between", marks=pytest.mark.thorough),
        pytest.param(_split(6, 2, K // 2), 150, id="within"),
    ],
)
def test_intervals_hold_the_truth_over_a_move(mounting: NDArray[np.int64], campaigns: int) -> None:
    """Between two replications, and within one. 95 % of 150: 135 to 150 at 1 in 1000 (binomial)."""
    chance = np.random.default_rng(8)
    truth = {"offset_v": OFFSET_V, "sensitivity_v_per_g": SENSITIVITY, "coning_deg": 0.9, "azimuth_deg": -70.0}
    held = dict.fromkeys(truth, 0)
    for _ in range(campaigns):
        axis = calibrate_mountings(_campaign(chance, mounting), CalibrationRequest(extended="no")).axes["x"]
        for parameter in axis.parameters:
            assert parameter.interval_95 is not None
            held[parameter.name] += parameter.interval_95[0] <= truth[parameter.name] <= parameter.interval_95[1]
    assert all(count >= 0.90 * campaigns for count in held.values()), held
