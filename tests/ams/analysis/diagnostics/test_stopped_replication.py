"""A replication that stopped part way tells little of its own parameters, and shows no term that is not there."""

import numpy as np
import pytest

from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

PITCH, ROLL = (np.radians(grid).ravel() for grid in np.mgrid[-90:91:15, -180:180:30])
REPLICATIONS, NOISE_V = 4, 2e-5
TERMS = ("K2", "Kpp", "Kip", "Kio", "Kpo", "K3", "K0'", "K1'")


def _calibration(seed: int, kept: int, k2_v_per_g2: float = 0.0, drift_v: float = 0.0) -> Calibration:
    """A sensor along x; the last replication holds the first ``kept`` points only."""
    chance, count = np.random.default_rng(seed), PITCH.size
    replication, point = np.divmod(np.arange(REPLICATIONS * count), count)
    there = (replication < REPLICATIONS - 1) | (point < kept)
    replication, point = replication[there], point[there]
    force = specific_force(PITCH[point], ROLL[point])
    output = 0.01 + force @ (2.5, 0.02, -0.03) + k2_v_per_g2 * force[:, 0] ** 2 + drift_v * replication
    output = output + chance.normal(0.0, NOISE_V, output.size)
    return calibrate(
        Observations(replication + 1, point + 1, PITCH[point], ROLL[point], {"x": output}), CalibrationRequest()
    )


def _p_values(found: Calibration) -> dict[str, float]:
    tests = {str(finding.details.get("test")): finding.p_value for finding in found.axes["x"].findings}
    return {name: float(tests[name]) for name in TERMS}


@pytest.mark.parametrize("kept", [12, 24, 60, 96])
def test_a_replication_that_stopped_shows_no_term_that_is_not_there(kept: int) -> None:
    p_values = np.array([list(_p_values(_calibration(seed, kept)).values()) for seed in range(25)])
    assert p_values.min() > 1e-4  # 200 of them, of which one in 50 runs of this test would be less by chance
    assert np.mean(p_values < 0.05) < 0.12
    assert np.mean(p_values) == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize("kept", [24, 96, PITCH.size])
def test_a_term_that_is_there_is_found_whatever_the_last_replication_lacks(kept: int) -> None:
    assert _p_values(_calibration(3, kept, k2_v_per_g2=5.0 * NOISE_V))["K2"] < 1e-6


def test_a_drift_between_replications_of_which_one_stopped_is_no_term() -> None:
    found = _calibration(4, 24, drift_v=10.0 * NOISE_V)
    assert min(_p_values(found).values()) > 1e-3
    assert any(finding.kind == "drift" and finding.is_significant for finding in found.axes["x"].findings)
