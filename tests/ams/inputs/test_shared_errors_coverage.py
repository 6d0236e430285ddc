"""Coverage where every campaign has a meter, a level and a table of its own: 95 % intervals hold 95 %."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_campaign import ARCSEC, Campaign

from ams.calibration.calibrate import calibrate
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SharedError
from ams.statistics.intervals import t_quantile

ERRORS = (
    SharedError("multimeter zero", "reading", 8e-6),
    SharedError("multimeter gain", "gain", 4e-6),
    SharedError("level about pitch", "pitch", 0.7 * ARCSEC),
    SharedError("level about roll", "base-tilt", 0.7 * ARCSEC),
)
K = np.array([2.5, 0.02, 0.012])


@pytest.mark.parametrize(
    "campaigns", [150, pytest.param(600, marks=pytest.mark.thorough), pytest.param(6000, marks=pytest.mark.soak)]
)
def test_95_percent_intervals_hold_the_truth_in_95_percent_of_campaigns(campaigns: int) -> None:
    chance = np.random.default_rng(11)
    rows = Campaign(replications=4).observe(chance)
    request = CalibrationRequest(nominal_axes={"x": "x"}, shared_errors={"x": ERRORS}, extended="no")
    truth, held = np.concatenate([[0.005], K]), np.zeros(4)
    for _ in range(campaigns):
        zero, gain, pitch_zero, tilt = (error.standard_uncertainty * chance.standard_normal() for error in ERRORS)
        force = specific_force(rows.pitch_rad + pitch_zero, rows.roll_rad)
        force[:, 1:] += tilt * np.stack([np.cos(rows.roll_rad), -np.sin(rows.roll_rad)], axis=-1)
        output = (0.005 + force @ K) * (1.0 + gain) + zero + 5e-6 * chance.standard_normal(rows.rows)
        axis = calibrate(replace(rows, outputs={"x": output}), request).axes["x"]
        half = t_quantile(0.95, axis.primary_dof) * np.sqrt(np.diag(axis.primary_covariance))
        held += np.abs(axis.primary - truth) <= half
    tolerance = {150: 0.057, 600: 0.03}.get(campaigns, 0.01)
    assert held / campaigns == pytest.approx(0.95, abs=tolerance)
