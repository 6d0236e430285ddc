"""Gyros of drawn truths on the twin's rate table: solution, set and truth line agree with a computation beside them.

That computation knows nothing of the solver: rates from position and time, one least squares by numpy over the
recorded means, axes by CR's matrices (coning from the nominal axis, azimuth about it).
"""

from pathlib import Path

import numpy as np
import pytest
from motion_runs import motion_run
from physics_scenes.gimbal_scenes import coned_axis
from scipy.stats import t as student

from ams.sets.canonical import number, table
from procedures.delivery.deliver import SolvedRun, sets_of
from procedures.report.truth import truth_of

RATE_DPS = 90.0
SHORT = {r"replications = 4": "replications = 2", r"\[10.0, 40.0\]": f"[{RATE_DPS}]", r"dwell_s = 9.0": "dwell_s = 4.0"}
OF_STAGE = {"roll": 0, "pitch": 1, "yaw": 2}
"""Component of the rate in package axes, where the other two stages stand at zero."""
Truth = dict[str, tuple[float, float, float, float]]
"""Axis to offset (V), sensitivity (V/(°/s)), coning and azimuth (°) in the terms of a rig file."""


def drawn(seed: int) -> Truth:
    chance = np.random.default_rng(seed)
    return {
        axis: (
            round(float(chance.normal(0.0, 0.1)), 6),
            round(float(chance.choice([-1.0, 1.0]) * chance.uniform(0.8, 1.6)), 6),
            round(float(chance.uniform(0.08, 0.6)), 5),
            round(float(chance.uniform(-180.0, 180.0)), 4),
        )
        for axis in "xyz"
    }


def solved_on_the_twin(truth: Truth, seed: int, folder: Path) -> SolvedRun:
    lines = {
        rf"(?m)^{axis} = \{{ offset_v = 0.05\d, .*\}}": f"{axis} = {{ offset_v = {b}, sensitivity_v_per_dps = {s}, "
        f"coning_deg = {coning}, azimuth_deg = {azimuth}, noise_v = 0.002 }}"
        for axis, (b, s, coning, azimuth) in truth.items()
    }
    nothing_declared = {r"nominal_sensitivity_v_per_dps = .*\n": ""}  # either polarity is drawn
    rig = {r"seed = 5": f"seed = {seed}", **nothing_declared, **lines}
    return motion_run(folder, "rate-table", "rates", SHORT, rig).solved()


def by_numpy(solved: SolvedRun, axis: str) -> tuple[np.ndarray, np.ndarray, int]:
    """Return b and k (4,), their covariance for the noise inside the two replications, and its degrees of freedom.

    The rig does not say how it lies to the Earth's axis, whose rate is therefore sought: a gyro senses it at rest and
    where its own stage turns; whole turns about the two others have it come to nothing.
    """
    own = "xyz".index(axis)
    replication, basis, outputs = [], [], []
    for dwell in solved.record.dwells:
        if dwell.purpose == "design":
            rate_dps = np.zeros(3)
            for stage, measured_dps in dwell.motion.rates_dps.items() if dwell.motion else ():
                rate_dps[OF_STAGE[stage]] = measured_dps
            replication.append(dwell.replication)
            others_turn = bool(np.delete(rate_dps, own).any())
            basis.append([1.0, *rate_dps, 0.0 if others_turn else 1.0])
            outputs.append(dwell.readings[f"logger.g{axis}"].mean)
    rows, output_v = np.array(basis), np.array(outputs)
    estimate = np.linalg.lstsq(rows, output_v, rcond=None)[0]
    first, second = (np.array(replication) == number for number in sorted(set(replication)))
    misfit_v = output_v - rows @ estimate
    _, square, *_ = np.linalg.lstsq(rows[first], misfit_v[first] - misfit_v[second], rcond=None)
    dof = int(first.sum()) - rows.shape[1]
    covariance = 0.5 * float(square[0]) / dof * np.linalg.inv(rows.T @ rows)
    return estimate[:4], covariance[:4, :4], dof


def true_vector(truth: Truth, axis: str) -> np.ndarray:
    b, sensitivity, coning_deg, azimuth_deg = truth[axis]
    direction = coned_axis(axis, np.deg2rad(coning_deg), np.deg2rad(azimuth_deg + 90.0))  # TP's azimuth in CR's terms
    return np.concatenate([[b], sensitivity * direction])


@pytest.mark.parametrize("seed", [31, *(pytest.param(seed, marks=pytest.mark.thorough) for seed in range(32, 36))])
def test_solution_set_and_truth_line_agree_with_numpy_and_the_file(seed: int, tmp_path: Path) -> None:
    truth = drawn(seed)
    solved = solved_on_the_twin(truth, seed, tmp_path)
    sensor = solved.sensors["ENC03J"]
    assert sensor.calibration is not None
    for axis, found in sensor.calibration.axes.items():
        estimate, covariance, dof = by_numpy(solved, axis)
        noise = np.sqrt(np.diag(covariance))
        # Sensitivities are the same whatever the weights of the points; the offset is that of other weights.
        assert np.all(np.abs(found.primary[:4] - estimate) <= np.array([3.0, 1e-6, 1e-6, 1e-6]) * noise), axis
        allowed = float(student.ppf(0.9999, dof)) * noise
        assert np.all(np.abs(found.primary[:4] - true_vector(truth, axis)) <= allowed), axis
        told = truth_of(solved.record.rig, "ENC03J", axis, sensor.observations, found)
        parameters = table(table(table(sets_of(solved)["ENC03J"].document["axes"])[axis])["parameters"])
        for parameter in found.parameters:
            assert parameter.value is not None
            assert parameter.interval_95 is not None
            assert number(table(parameters[parameter.name])["value"]) == pytest.approx(parameter.value, rel=1e-12)
            half = 0.5 * (parameter.interval_95[1] - parameter.interval_95[0])
            error = parameter.value - told[parameter.name]
            error = (error + 180.0) % 360.0 - 180.0 if parameter.name == "azimuth_deg" else error
            # 60 intervals at 95 %, none narrower than that of the noise alone: three of its half-widths are 6 σ
            assert abs(error) <= 3.0 * half, (axis, parameter.name, error, half)
        across = np.delete(estimate[1:], "xyz".index(axis))
        spread = float(np.sqrt(np.min(np.delete(np.diag(covariance)[1:], "xyz".index(axis)))))
        least_deg = np.rad2deg(float(student.ppf(0.975, dof)) * spread / np.linalg.norm(across))
        low, high = next(p.interval_95 for p in found.parameters if p.name == "azimuth_deg" and p.interval_95)
        assert 0.5 * (high - low) >= 0.5 * least_deg, axis
