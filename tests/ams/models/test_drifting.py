"""A drift of the offset with time: recovered, covered by its interval, refused without times."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_campaign import OFFSET_V, VECTOR_V_PER_G, Campaign

from ams.analysis.predictions import model_of_solution
from ams.calibration.calibrate import calibrate
from ams.errors import ObservationsError
from ams.frames import Attitude
from ams.inputs.request import CalibrationRequest
from ams.models.accelerometer import PitchRoll
from ams.models.drifting import DRIFT_NAME, WithTime
from ams.observations import Observations

TIMED = CalibrationRequest(time_term=True, extended="no")
DRIFT_V_PER_H = 4e-6


def drifting(campaign: Campaign, seed: int, drift_v_per_h: float = DRIFT_V_PER_H) -> Observations:
    """A dwell a minute, there and back, the offset creeping by a fixed amount an hour from the middle of the run."""
    observations = campaign.observe(np.random.default_rng(seed))
    time_s = 60.0 * np.arange(observations.rows)
    hours = (time_s - 0.5 * time_s[-1]) / 3600.0
    outputs = {axis: output + drift_v_per_h * hours for axis, output in observations.outputs.items()}
    return replace(observations, outputs=outputs, time_s=time_s)


def test_a_drift_with_time_is_recovered_to_ten_digits_beside_the_other_parameters() -> None:
    solved = calibrate(drifting(Campaign(noise_arcsec=0.0, replications=3), 0), TIMED)
    for axis, solved_axis in solved.axes.items():
        truth = [OFFSET_V[axis], *VECTOR_V_PER_G[axis], DRIFT_V_PER_H]
        np.testing.assert_allclose(solved_axis.primary, truth, rtol=0, atol=1e-12)
        assert [p.name for p in solved_axis.parameters[-2:]] == [DRIFT_NAME, "reference_time_s"]
        assert [p.value for p in solved_axis.parameters[-2:]] == pytest.approx([DRIFT_V_PER_H, 73.0 * 60.0], rel=1e-6)
        assert model_of_solution(solved_axis) == WithTime(PitchRoll(axis), 73.0 * 60.0)


def test_the_time_term_goes_with_estimated_temperature() -> None:
    observations = drifting(Campaign(noise_arcsec=0.0, replications=4), 0)
    temperature = np.random.default_rng(1).uniform(15.0, 35.0, observations.rows)
    outputs = {axis: output + 3e-5 * (temperature - 25.0) for axis, output in observations.outputs.items()}
    warm = replace(observations, outputs=outputs, temperature_degc=temperature)
    solved = calibrate(warm, replace(TIMED, temperature="estimate", reference_temperature_degc=25.0)).axes["x"]
    found = {p.name: p.value for p in solved.parameters}
    assert found["offset_tc_v_per_degc"] == pytest.approx(3e-5, rel=1e-6)
    assert found[DRIFT_NAME] == pytest.approx(DRIFT_V_PER_H, rel=1e-6)


@pytest.mark.thorough
def test_intervals_hold_the_drift_and_the_offset_while_replications_wander_besides() -> None:
    campaign = Campaign(
        replications=6,
        offset_drift_arcsec=1.0,
        pitch_deg=np.array([-60.0, 0.0, 60.0]),
        roll_deg=np.arange(0, 360, 90.0),
    )
    hits = []
    for seed in range(300):
        entry = calibrate(drifting(campaign, seed), TIMED).axes["x"]
        for location, truth in ((0, OFFSET_V["x"]), (4, DRIFT_V_PER_H)):
            low, high = entry.parameters[location].interval_95
            hits.append(low < truth < high)
    assert np.mean(hits) == pytest.approx(0.95, abs=0.025)


def test_without_times_the_time_term_is_refused() -> None:
    observations = drifting(Campaign(replications=2), 0)
    with pytest.raises(ObservationsError, match=r"time term: no times were recorded.*give a column time_s"):
        calibrate(replace(observations, time_s=None), TIMED)
    with pytest.raises(ObservationsError, match="all rows have the same time"):
        calibrate(replace(observations, time_s=np.zeros(observations.rows)), TIMED)


def test_jacobian_is_that_of_a_complex_step() -> None:
    model = WithTime(PitchRoll("y"), 600.0)
    rng = np.random.default_rng(3)
    attitude = Attitude(rng.uniform(-1, 1, 7), rng.uniform(-3, 3, 7), time_s=rng.uniform(0, 5000, 7))
    primary = np.array([0.1, 0.02, -2.4, 0.03, 5e-6])
    for index in range(5):
        step = np.zeros(5, dtype=complex)
        step[index] = 1e-200j
        derivative = model.predict(primary + step, attitude).imag / 1e-200
        np.testing.assert_allclose(model.jacobian(primary, attitude)[:, index], derivative, rtol=1e-12)


def test_without_a_time_the_model_stands_at_its_reference_time() -> None:
    model, primary = WithTime(PitchRoll("x"), 600.0), np.array([0.1, 2.5, 0.0, 0.0, 1.0])
    here = Attitude(np.array([0.3]), np.array([0.1]))
    at_reference = replace(here, time_s=np.array([600.0]))
    np.testing.assert_array_equal(model.predict(primary, here), model.predict(primary, at_reference))
