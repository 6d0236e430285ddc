"""Between three rates nothing tells a bend of the scale factor from an asymmetry: predictions there hold both."""

import numpy as np
import pytest
from physics_scenes import campaigns
from physics_scenes.gyro_scenes import GyroRates
from solved_campaigns import rows_of_gyros, velocity_dps_of

from ams.analysis.predictions import model_of_solution, prediction_halfwidth_v
from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.frames import AXES, Attitude, euler_rates_rad_s
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import BETWEEN_RATES
from ams.sets.verdict_conditions import THREE_RATES, verdict_conditions

CAMPAIGNS, REPLICATIONS, NOISE_V = 25, 4, 2e-5
THREE, SEVEN = (-100.0, 0.0, 100.0), (-100.0, -50.0, -20.0, 0.0, 20.0, 50.0, 100.0)


def drawn(size_ppm: float, rates_dps: tuple[float, ...], noise_v: float = NOISE_V) -> GyroRates:
    """The same gyros whatever the rates."""
    return campaigns(
        "gyro-asymmetry", size_ppm, np.random.default_rng(7), CAMPAIGNS,
        replications=REPLICATIONS, rates_dps=rates_dps, dwell_noise_v=noise_v,
    )  # fmt: skip


def solved(calibrated: GyroRates, campaign: int) -> Calibration:
    request = CalibrationRequest(model="gyro", nominal_axes={axis: axis for axis in AXES})
    return calibrate(rows_of_gyros(calibrated, campaign), request)


def held_at(rate_dps: float, size_ppm: float) -> float:
    """The share of readings, at a rate and minus it, that 95 % intervals hold."""
    calibrated, used = drawn(size_ppm, THREE), drawn(size_ppm, (-rate_dps, 0.0, rate_dps), 0.0)
    velocity = velocity_dps_of(used)
    points, chance = len(velocity) // REPLICATIONS, np.random.default_rng(3)
    still, rates = np.zeros(points), euler_rates_rad_s(np.zeros((points, 3)), np.deg2rad(velocity[:points]))
    at = Attitude(still, still, still, euler_rate_rad_s=rates)
    held = []
    for campaign in range(CAMPAIGNS):
        exact = rows_of_gyros(used, campaign).outputs
        for index, (label, axis) in enumerate(solved(calibrated, campaign).axes.items()):
            turns = np.isclose(np.abs(velocity[:points, index]), rate_dps)
            read = exact[label][:points] + NOISE_V * chance.standard_normal(points)
            off = np.abs(read - model_of_solution(axis).predict(axis.primary, at))
            held += (off <= prediction_halfwidth_v(axis, at, NOISE_V))[turns].tolist()
    return float(np.mean(held))


@pytest.mark.parametrize("size_ppm", [0.0, 1.0, 3.0, 1500.0])
def test_a_reading_at_half_the_rate_is_held_however_large_the_asymmetry(size_ppm: float) -> None:
    assert held_at(50.0, size_ppm) > 0.92


def test_it_is_said_and_stands_in_the_budget_and_a_rate_between_ends_it() -> None:
    few = solved(drawn(1500.0, THREE), 0)
    for label, axis in few.axes.items():
        (part,) = (part for part in axis.variance_components if part.name == BETWEEN_RATES)
        # Both senses differ by 1 500 ppm: ¼ of ½ of it of the largest output, 125 V, at half the rate.
        assert np.sqrt(part.covariance[0, 0]) == pytest.approx(0.9 * 1500e-6 / 8.0 * 125.0, rel=0.05)
        (remark,) = (text for text in axis.remarks if text.startswith(THREE_RATES))
        assert f"ppm of the largest of {label}, which is in the uncertainty" in remark
        assert "bend of third order" in verdict_conditions(axis.remarks)
    for axis in solved(drawn(1500.0, SEVEN), 0).axes.values():
        assert BETWEEN_RATES not in {part.name for part in axis.variance_components}
        assert not [text for text in axis.remarks if text.startswith(THREE_RATES)]
