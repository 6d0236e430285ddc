"""Confidence and prediction intervals of a solved axis hold what they promise."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_campaign import ARCSEC, OFFSET_V, VECTOR_V_PER_G, Campaign

from ams.analysis.predictions import confidence_halfwidth_v, model_of_solution, prediction_halfwidth_v
from ams.calibration.calibrate import calibrate
from ams.errors import DesignError
from ams.frames import Attitude, specific_force
from ams.inputs.request import CalibrationRequest
from ams.models.thermal import TemperatureCoefficients

AT = Attitude(np.deg2rad([0.0, 17.0, -80.0]), np.deg2rad([0.0, 130.0, -20.0]))
ONE = CalibrationRequest(nominal_axes={"x": "x"}, extended="no")


@pytest.mark.thorough
def test_intervals_hold_the_calibrated_output_and_new_readings() -> None:
    truth = OFFSET_V["x"] + specific_force(AT.pitch_rad, AT.roll_rad) @ VECTOR_V_PER_G["x"]
    noise_v, campaigns = 0.8 * ARCSEC * 2.5, 800
    held, predicted = np.zeros(3), np.zeros(3)
    for seed in range(campaigns):
        rng = np.random.default_rng(seed)
        solved = calibrate(Campaign(replications=5, lack_of_fit_arcsec=0.5).observe(rng), ONE).axes["x"]
        output = model_of_solution(solved).predict(solved.primary, AT)
        held += np.abs(output - truth) < confidence_halfwidth_v(solved, AT)
        reading = truth + noise_v * rng.standard_normal(3)
        predicted += np.abs(output - reading) < prediction_halfwidth_v(solved, AT, noise_v)
    assert held / campaigns == pytest.approx(0.95, abs=0.025)
    assert predicted / campaigns == pytest.approx(0.95, abs=0.025)


def test_the_output_has_its_slope_by_roll() -> None:
    """∂v/∂R = −S sin Ω cos α cos(R + A): TP (75) with its sign put right."""
    solved = calibrate(Campaign(replications=3, noise_arcsec=0.0).observe(np.random.default_rng(0)), ONE).axes["x"]
    _, s, coning, azimuth = (item.value for item in solved.parameters)
    coning, azimuth = np.deg2rad(coning), np.deg2rad(azimuth)
    slope = -s * np.sin(coning) * np.cos(AT.pitch_rad) * np.cos(AT.roll_rad + azimuth)
    signed = model_of_solution(solved).angle_jacobian(solved.primary, AT)["roll"]
    np.testing.assert_allclose(signed, slope, atol=1e-12)


def test_a_solution_knows_its_temperature_terms_again() -> None:
    observations = Campaign(replications=2).observe(np.random.default_rng(1))
    observations = replace(observations, temperature_degc=np.full(observations.rows, 22.0))
    request = replace(ONE, temperature="apply", known_temperature={"x": TemperatureCoefficients(1e-5, 2e-4)})
    solved = calibrate(observations, request).axes["x"]
    output = model_of_solution(solved).predict(solved.primary, observations)
    np.testing.assert_allclose(output, solved.fitted_v, rtol=1e-14)


def test_a_model_that_is_not_known_by_name_is_refused() -> None:
    solved = calibrate(Campaign(replications=2).observe(np.random.default_rng(1)), ONE).axes["x"]
    with pytest.raises(DesignError, match="no model is known by the name 'mine'"):
        model_of_solution(replace(solved, model="mine"))
