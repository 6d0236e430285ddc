"""Angles of a package whose offsets and sensitivities bend with temperature, with their uncertainty."""

import numpy as np
import pytest
from foreign_sets import TC2, bending

from ams.errors import OutsideValidity
from ams.inference.inference import Inference, Package
from ams.inference.package.calibrated import sensor_of_set
from ams.sets.apply import apply

PITCH_DEG, ROLL_DEG = np.array([-35.0, 10.0, 60.0]), np.array([-120.0, 15.0, 40.0])
WARM_DEGC = np.array([2.0, 20.0, 38.0])


def test_the_angles_that_made_the_outputs_come_back_at_every_temperature() -> None:
    coefficients = bending()
    outputs = apply(coefficients, np.deg2rad(PITCH_DEG), np.deg2rad(ROLL_DEG), WARM_DEGC)
    package = Package(coefficients, {axis: f"{axis}_v" for axis in "xyz"})
    readings = {**{f"{axis}_v": outputs[axis] for axis in "xyz"}, "temperature_degc": WARM_DEGC}
    found = dict(Inference(package, reading_sd_v=1e-5).answer(readings).columns)
    assert found["pitch_deg"] == pytest.approx(PITCH_DEG, abs=1e-9)
    assert found["roll_deg"] == pytest.approx(ROLL_DEG, abs=1e-9)


def test_what_a_coefficient_moves_is_the_derivative_of_the_output_at_the_reference() -> None:
    """By a step of each coefficient in the set's own equation, v = b + b₁τ + b₂τ² + (1 + s₁τ + s₂τ²)(k·f)."""
    sensor = sensor_of_set(bending(), "x", 1e-5, WARM_DEGC)
    rise = WARM_DEGC - 20.0
    force = np.array([[0.1, -0.3, -0.9], [0.5, 0.2, -0.8], [-0.7, 0.1, 0.6]])
    gain = 1.0 + TC2["sensitivity_tc_per_degc"] * rise + TC2["sensitivity_tc2_per_degc2"] * rise**2
    sensed = force @ sensor.k_v_per_g
    expected = {
        "offset_v": 1.0 / gain, "offset_tc_v_per_degc": rise / gain, "offset_tc2_v_per_degc2": rise**2 / gain,
        "sensitivity_tc_per_degc": rise * sensed / gain, "sensitivity_tc2_per_degc2": rise**2 * sensed / gain,
    }  # fmt: skip
    rows = sensor.rows(force)
    for name, column in expected.items():
        np.testing.assert_allclose(rows[:, list(sensor.names).index(name)], column, rtol=1e-12)


@pytest.mark.parametrize("read_degc", [293.15, -180.0, 9.9e37])
def test_a_temperature_that_no_sensor_stands_gives_no_angle_and_no_output(read_degc: float) -> None:
    """20 °C in kelvin among two rows in degrees: that row alone is flagged, and a set is not applied there at all."""
    coefficients = bending()
    outputs = apply(coefficients, np.deg2rad(PITCH_DEG), np.deg2rad(ROLL_DEG), WARM_DEGC)
    readings = {f"{axis}_v": outputs[axis] for axis in "xyz"}
    package = Package(coefficients, {axis: f"{axis}_v" for axis in "xyz"})
    read = np.where([False, True, False], read_degc, WARM_DEGC)
    found = Inference(package, reading_sd_v=1e-5).answer({**readings, "temperature_degc": read})
    assert np.isnan(found.columns["pitch_deg"]).tolist() == [False, True, False]
    assert found.columns["pitch_deg"][[0, 2]] == pytest.approx(PITCH_DEG[[0, 2]], abs=1e-9)
    with pytest.raises(OutsideValidity, match=r"temperature: got .* allowed −100 to 200 °C"):
        apply(coefficients, 0.0, 0.0, read, beyond_validity=True)
