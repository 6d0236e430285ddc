"""Straight lines: SR's flown numbers come back, derivatives are a complex step's, intervals cover."""

import numpy as np
import pytest

from ams.calibration.calibrate import calibrate
from ams.errors import DesignError, ObservationsError
from ams.inputs.request import CalibrationRequest
from ams.models.linear import fit_line
from ams.models.straight_line import StraightLine
from ams.observations import Observations


def observed(level: np.ndarray, reading: np.ndarray, replications: int = 1) -> Observations:
    points = level.size // replications
    nothing = np.zeros(level.size)
    labels = np.repeat(np.arange(replications), points), np.tile(np.arange(points), replications)
    return Observations(*labels, nothing, nothing, {"x": reading}, reference_level=level, units={"x": "counts"})


def solve(rows: Observations) -> dict:
    request = CalibrationRequest(models={"x": StraightLine("x", "g", "counts")}, nominal_axes={"x": "x"}, extended="no")
    return {estimate.name: estimate for estimate in calibrate(rows, request).axes["x"].parameters}


def test_derivatives_are_those_of_a_complex_step() -> None:
    model, primary, step = StraightLine("x", "g", "counts"), np.array([-32.6, 1333.0]), 1e-30
    for index in range(2):
        shifted = primary.astype(complex)
        shifted[index] += 1j * step
        numeric = model.parameters(shifted).imag / step
        np.testing.assert_allclose(model.parameters_jacobian(primary)[:, index], numeric, rtol=1e-12)


def test_noise_free_levels_give_the_line_of_sr_in_either_direction() -> None:
    # SR, accelerometer x: 1.0032·(counts/1333) + 0.02066 g.
    level = np.array([-1.0, 0.0, 0.5, 1.0])
    reading = 1333.0 * (level - 0.02066) / 1.0032
    found, theirs = solve(observed(level, reading)), fit_line(reading, level).line
    assert found["gain_g_per_counts"].value == pytest.approx(theirs.gain, rel=1e-12)
    assert found["gain_g_per_counts"].value == pytest.approx(1.0032 / 1333.0, rel=1e-12)
    assert found["offset_g"].value == pytest.approx(0.02066, rel=1e-10)


@pytest.mark.parametrize(
    ("campaigns", "tolerance"), [(250, 0.044), pytest.param(1000, 0.022, marks=pytest.mark.thorough)]
)
def test_intervals_of_gain_and_offset_cover(campaigns: int, tolerance: float) -> None:
    chance, level = np.random.default_rng(12), np.tile(np.linspace(-1.0, 1.0, 5), 6)
    truth = {"gain_g_per_counts": 1.0032 / 1333.0, "offset_g": 0.2}
    held: dict[str, list[bool]] = {name: [] for name in truth}
    for _ in range(campaigns):
        reading = (level - 0.2) * 1333.0 / 1.0032 + chance.normal(0.0, 5.0, level.size)
        for name, estimate in solve(observed(level, reading, 6)).items():
            low, high = estimate.interval_95
            held[name].append(low < truth[name] < high)
    for inside in held.values():
        assert np.mean(inside) == pytest.approx(0.95, abs=tolerance)


def test_a_reading_that_does_not_follow_is_null_with_the_reason() -> None:
    chance, level = np.random.default_rng(1), np.linspace(-1.0, 1.0, 20)
    rows = observed(level, chance.normal(size=20))
    request = CalibrationRequest(models={"x": StraightLine("x", "g", "counts")}, nominal_axes={"x": "x"}, extended="no")
    axis = calibrate(rows, request).axes["x"]
    assert [estimate.value for estimate in axis.parameters] == [None, None]
    assert any("does not follow the reference" in warning for warning in axis.warnings)


def test_one_level_and_no_level_are_refused() -> None:
    with pytest.raises(DesignError, match="1 different levels; nothing was solved; measure at two or more"):
        solve(observed(np.ones(5), np.arange(5.0)))
    with pytest.raises(ObservationsError, match="reference_g"):
        StraightLine("x", "g", "counts").basis(Observations(*(np.zeros(2, dtype=int),) * 2, *(np.zeros(2),) * 2, {}))
