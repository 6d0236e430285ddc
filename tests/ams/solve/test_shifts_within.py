"""What a sensor may have shifted by while it was calibrated: against shifts that are drawn and added to readings."""

import numpy as np
import pytest
from physics_scenes import campaigns
from simulated_campaign import Campaign
from solved_campaigns import ARCSEC, Coverage, coverage, solved

from ams.calibration.calibrate import calibrate
from ams.calibration.jointly import calibrate_jointly
from ams.calibration.solving.expectation import expect
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SHIFTS_WITHIN, Effect, SharedError
from ams.observations import Observations
from ams.solve.expected import Belief
from ams.solve.table_errors import TablePriors

V_PER_G = 2.5
REPLICATIONS, POINTS = 6, 32
NOISE_V = 1.65 * ARCSEC * V_PER_G
ALONE = {"sensors": 1, "reference_every": 0, "check_set": 0}


def _error(limit: float, effect: Effect = "reading-course") -> SharedError:
    name = SHIFTS_WITHIN[("reading-course", "gain-course").index(effect)]
    return SharedError(name, effect, limit / 3.0**0.5, is_of_one_channel=True)


def _rows(chance: np.random.Generator, noise_v: float = NOISE_V) -> Observations:
    """Rows of one axis by point; every replication visits the points in the same order, drawn by chance."""
    order = np.tile(chance.permutation(POINTS), REPLICATIONS)
    pitch, roll = np.linspace(-1.5, 1.5, POINTS), np.linspace(0.0, 12.0, POINTS) % (2.0 * np.pi)
    time_s = np.empty(REPLICATIONS * POINTS)
    replication, point = np.repeat(np.arange(REPLICATIONS), POINTS), np.tile(np.arange(POINTS), REPLICATIONS)
    time_s[replication * POINTS + order] = 20.0 * np.arange(order.size)
    output_v = 0.01 + V_PER_G * np.sin(pitch)[point] + noise_v * chance.standard_normal(order.size)
    return Observations(replication, point, pitch[point], roll[point], {"x": output_v}, time_s=time_s)


def _part(rows: Observations, error: SharedError) -> np.ndarray:
    request = CalibrationRequest(nominal_axes={"x": "x"}, shared_errors={"x": (error,)}, extended="no")
    parts = calibrate(rows, request).axes["x"].variance_components
    return next(part.covariance for part in parts if part.name == error.name)


@pytest.mark.parametrize("effect", ["reading-course", "gain-course"])
def test_small_beside_the_noise_it_is_the_spread_of_estimates_whose_readings_shift(effect: Effect) -> None:
    """Drawn: a step between any two dwells and a transient of every replication, each uniform within the limit."""
    chance, limit, draws = np.random.default_rng(4), 1e-9, 6000
    rows = _rows(chance)
    basis = np.column_stack(
        [np.ones(rows.rows), np.sin(rows.pitch_rad), -np.cos(rows.pitch_rad) * np.sin(rows.roll_rad),
         -np.cos(rows.pitch_rad) * np.cos(rows.roll_rad)]
    )  # fmt: skip
    assert rows.time_s is not None
    place = np.argsort(np.argsort(rows.time_s))
    turn = place % POINTS
    steps = place > chance.uniform(-1, rows.rows, (draws, 1))
    course = chance.uniform(-limit, limit, (draws, 1)) * steps
    course = course + chance.uniform(-limit, limit, (draws, 1)) * np.exp(-12.0 * turn / POINTS)
    if effect == "gain-course":
        course = course * (0.01 + V_PER_G * np.sin(rows.pitch_rad))
    moved = course @ np.linalg.pinv(basis).T
    found = _part(rows, _error(limit, effect))
    for direction in (*np.eye(4), np.array([1.0, 0.8, 0.0, 0.6]), np.array([1.0, 0.0, 0.8, -0.6])):
        drawn = np.mean((moved @ direction) ** 2)
        assert direction @ found @ direction == pytest.approx(drawn, rel=0.1, abs=0.0)


def test_a_limit_far_above_the_noise_leaves_what_the_readings_do_not_tell() -> None:
    """A year's limit of 200″ does not make the uncertainty of one hour: steps of an arc second would be seen."""
    rows = _rows(np.random.default_rng(5))
    year, year_and_more = (_part(rows, _error(limit * ARCSEC * V_PER_G)) for limit in (200.0, 2000.0))
    for covariance in (year, year_and_more):
        assert np.sqrt(covariance[0, 0]) / V_PER_G / ARCSEC < 3.0
        assert np.sqrt(covariance[1, 1]) / V_PER_G / ARCSEC < 1.0
    assert year[0, 0] < year_and_more[0, 0] < 1.5 * year[0, 0]


def test_a_shift_that_the_readings_show_is_in_it_as_large_as_it_is() -> None:
    """Nothing is taken off the estimate, so that the interval has to reach the sensor before and after."""
    limit_v = 10.0 * ARCSEC * V_PER_G
    rows = _rows(np.random.default_rng(6))
    assert rows.time_s is not None
    late = rows.time_s > np.median(rows.time_s)
    shifted = Observations(
        rows.replication, rows.point, rows.pitch_rad, rows.roll_rad, {"x": rows.outputs["x"] + limit_v * late},
        time_s=rows.time_s,
    )  # fmt: skip
    request = CalibrationRequest(nominal_axes={"x": "x"}, shared_errors={"x": (_error(limit_v),)}, extended="no")
    offset = calibrate(shifted, request).axes["x"].parameters[0]
    assert offset.interval_95 is not None
    low, high = offset.interval_95
    assert low < 0.01 < high
    assert low < 0.01 + limit_v < high


def test_the_forecast_is_the_mean_of_what_runs_without_a_shift_state() -> None:
    chance, error = np.random.default_rng(7), _error(2.0 * ARCSEC * V_PER_G)
    request = CalibrationRequest(nominal_axes={"x": "x"}, shared_errors={"x": (error,)}, extended="no")
    rows = _rows(chance, 0.0)
    component = next(
        part for part in expect(rows, request, {"x": Belief(NOISE_V)}).package.components if part.name == error.name
    )
    noisy = [
        Observations(
            rows.replication, rows.point, rows.pitch_rad, rows.roll_rad,
            {"x": rows.outputs["x"] + NOISE_V * chance.standard_normal(rows.rows)}, time_s=rows.time_s,
        )
        for _ in range(60)
    ]  # fmt: skip
    stated = np.mean([_part(drawn, error) for drawn in noisy], axis=0)
    np.testing.assert_allclose(np.diag(component.covariance), np.diag(stated), rtol=0.2)


def test_a_joint_fit_has_it_as_a_fit_of_the_axis_alone() -> None:
    error = _error(1.0 * ARCSEC * V_PER_G)
    rows = Campaign(replications=4).observe(np.random.default_rng(3))
    request = CalibrationRequest(
        nominal_axes={axis: axis for axis in "xyz"}, shared_errors=dict.fromkeys("xyz", (error,)), extended="no"
    )
    jointly = calibrate_jointly(rows, request, TablePriors(pitch_zero_rad=1.0 * ARCSEC))
    alone = calibrate(rows, request)
    for axis, found in jointly.axes.items():
        (part,), (same,) = (
            [part.covariance for part in each.variance_components if part.name == error.name]
            for each in (found, alone.axes[axis])
        )
        np.testing.assert_allclose(part, same, rtol=1e-6, atol=1e-6 * np.max(same))
    assert jointly.package is not None
    np.testing.assert_allclose(jointly.package.covariance[4:8, 4:8], jointly.axes["y"].primary_covariance)


def _covered(scene: str, size: float, limit_arcsec: float, count: int) -> Coverage:
    drawn = campaigns(scene, size, np.random.default_rng(11), count, **(ALONE if scene == "sensor-offset" else {}))
    errors = [_error(limit_arcsec * ARCSEC * V_PER_G)] if limit_arcsec else []
    return coverage(drawn, solved(drawn, None, errors), np.random.default_rng(1))


SHIFTING = (("drift-settling", 0.5, 0.83), ("sensor-offset", 0.5, 0.5))
"""Half a standard deviation of 1.65″ at the start of every replication, and half an arc second in mid-run."""


@pytest.mark.parametrize(("scene", "size", "limit_arcsec"), SHIFTING)
def test_intervals_hold_a_sensor_that_shifts_by_its_limit_and_without_it_do_not(
    scene: str, size: float, limit_arcsec: float
) -> None:
    declared, silent = (_covered(scene, size, limit, 30) for limit in (limit_arcsec, 0.0))
    assert declared.least > 0.93
    assert silent.least < 0.93
    assert declared.prediction_half_width_arcsec < 1.5 * silent.prediction_half_width_arcsec


@pytest.mark.soak
@pytest.mark.parametrize(("scene", "size", "limit_arcsec"), SHIFTING)
@pytest.mark.parametrize("times", [1.0, 2.0, 10.0])
def test_at_the_limit_and_far_below_it_they_hold(scene: str, size: float, limit_arcsec: float, times: float) -> None:
    assert _covered(scene, size, times * limit_arcsec, 400).least > 0.93
