"""The nonlinearity of a gyro's scale factor: the straight line beside it, what determines it, what is told of it."""

import re
from itertools import product
from typing import Literal

import numpy as np
import pytest
from physics_scenes import campaigns
from solved_campaigns import rows_of_gyros

from ams.analysis.predictions import model_of_solution, prediction_halfwidth_v
from ams.calibration.calibrate import calibrate
from ams.calibration_result import AxisCalibration
from ams.frames import AXES, Attitude, body_rates_rad_s, euler_rates_rad_s
from ams.inputs.request import CalibrationRequest
from ams.models.gyro import Gyro, GyroWithTerms, with_rate_terms
from ams.models.model import Model
from ams.observations import Observations
from ams.solve.extension import Extension
from ams.statistics.intervals import t_quantile


def turning(velocity_dps: np.ndarray) -> Attitude:
    still = np.zeros(len(velocity_dps))
    rates = euler_rates_rad_s(np.zeros((len(still), 3)), np.deg2rad(velocity_dps))
    return Attitude(still, still, still, euler_rate_rad_s=rates)


def solved(rows: Observations, extended: Literal["no", "test", "yes"] = "yes") -> dict[str, AxisCalibration]:
    request = CalibrationRequest(model="gyro", nominal_axes={axis: axis for axis in AXES}, extended=extended)
    return dict(calibrate(rows, request).axes)


@pytest.mark.parametrize("axis", AXES)
def test_offset_and_scale_factor_are_those_of_the_straight_line_that_comes_closest(axis: str) -> None:
    """IEEE Std 528: the scale factor is the slope of the line by least squares over input and output."""
    velocity = np.random.default_rng(1).uniform(-80.0, 80.0, (40, 3))
    along = velocity[:, "xyz".index(axis)]
    k = np.array([0.01, -0.02, 0.03]) + 1.25 * np.eye(3)["xyz".index(axis)]
    output = 0.05 + velocity @ k + 3e-7 * along**2 - 2e-9 * along**3
    model = with_rate_terms(Gyro(axis), turning(velocity), len(velocity))
    assert model is not None
    found = model.start(turning(velocity), output)
    line = np.linalg.lstsq(np.column_stack([np.ones(40), velocity]), output, rcond=None)[0]
    np.testing.assert_allclose(found[:4], line, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found[4:], [3e-7, -2e-9], rtol=1e-6)  # of outputs of 100, the cubic term is 4e-4
    elsewhere = np.random.default_rng(2).uniform(-80.0, 80.0, (7, 3))
    there = elsewhere[:, "xyz".index(axis)]
    truth = 0.05 + elsewhere @ k + 3e-7 * there**2 - 2e-9 * there**3
    np.testing.assert_allclose(model.predict(found, turning(elsewhere)), truth, rtol=1e-11)


@pytest.mark.parametrize("axis", AXES)
def test_the_slopes_by_the_angles_are_the_derivatives(axis: str) -> None:
    chance = np.random.default_rng(3)
    euler, rate = chance.uniform(-0.6, 0.6, (6, 3)), chance.uniform(-1.0, 1.0, (6, 3))
    model = GyroWithTerms(axis, ((100.0, 1.0, -2.0, 3.0), (-50.0, 600.0, 20.0, 30.0)))
    primary = np.array([0.05, *chance.normal(size=3), 2e-5, -3e-7])

    def output(angles: np.ndarray) -> np.ndarray:
        pitch, yaw, roll = angles.T
        return model.predict(primary, Attitude(pitch, roll, yaw, euler_rate_rad_s=rate))

    found = model.angle_jacobian(primary, Attitude(euler[:, 0], euler[:, 2], euler[:, 1], euler_rate_rad_s=rate))
    for index, name in enumerate(("pitch", "yaw", "roll")):
        step = np.eye(3)[index] * 1e-6
        np.testing.assert_allclose(found[name], (output(euler + step) - output(euler - step)) / 2e-6, atol=1e-7)


@pytest.mark.parametrize(
    ("velocity", "terms"),
    [
        (np.kron([[-100.0], [-50.0], [50.0], [100.0]], np.eye(3)), 2),
        (np.kron([[-100.0], [100.0], [100.01]], np.eye(3)), 1),
        (np.array(list(product((-100.0, 100.0), repeat=3)) * 2), 0),
    ],
)
def test_as_many_terms_stand_as_the_rates_determine(velocity: np.ndarray, terms: int) -> None:
    """Three levels hold a square and no third power; two hold nothing, whatever a servo adds to them."""
    velocity = velocity + 1e-4 * np.random.default_rng(4).normal(size=velocity.shape)
    model: Model | None = with_rate_terms(Gyro("y"), turning(velocity), len(velocity))
    assert len(model.primary_names if model else Gyro.primary_names) == 4 + terms


def test_rates_that_determine_no_term_are_told() -> None:
    velocity = np.tile(np.kron([[-50.0], [50.0]], np.eye(3)), (3, 1))
    rows = turning(velocity)
    output = 0.05 + velocity[:, 0] * 1.25 + 1e-5 * np.random.default_rng(5).normal(size=len(velocity))
    found = calibrate(
        Observations(np.repeat(np.arange(3), 6), np.tile(np.arange(6), 3), rows.pitch_rad, rows.roll_rad,
                     {"x": output}, yaw_rad=rows.yaw_rad, euler_rate_rad_s=rows.euler_rate_rad_s),
        CalibrationRequest(model="gyro", nominal_axes={"x": "x"}),
    ).axes["x"]  # fmt: skip
    assert found.primary_names == Gyro.primary_names
    assert any("nonlinearity and asymmetry of the scale factor are not determined" in text for text in found.remarks)


@pytest.mark.parametrize(
    ("scene", "kind", "symbol"),
    [
        ("gyro-nonlinearity", "cubic", "K₃"),
        ("gyro-asymmetry", "asymmetry", "K₁′"),
    ],
)
def test_what_is_plain_is_named_with_its_size_in_ppm(scene: str, kind: str, symbol: str) -> None:
    """Ten parts per million, drawn by somebody who knows nothing of the test."""
    drawn = campaigns(scene, 10.0, np.random.default_rng(6), 1)
    for axis in solved(rows_of_gyros(drawn)).values():
        [finding] = [finding for finding in axis.findings if finding.is_significant and finding.kind == kind]
        said = re.match(rf"{symbol} = (−?[\d.]+) ± ([\d.]+) ppm: ", finding.text)
        assert said is not None
        size, expanded = (float(number.replace("−", "-")) for number in said.groups())
        assert abs(abs(size) - 10.0) <= 1.5 * expanded <= 1.0
        assert finding.text in axis.warnings


def test_a_table_whose_rates_bend_is_named_beside_the_gyro_that_it_bends() -> None:
    """Straight gyros on a table that turns faster by 100 ppm at its largest rate, by less at lesser ones."""
    rates = np.array([0.0, 10.0, -10.0, 25.0, -25.0, 50.0, -50.0, 100.0, -100.0])
    stated = np.concatenate([np.outer(rates, along) for along in np.eye(3)])
    turned = stated * (1.0 + 1e-6 * np.abs(stated))
    chance, count = np.random.default_rng(7), 4
    k = 0.02 * (np.eye(3) + 0.004 * chance.standard_normal((3, 3)))
    volts = np.tile(0.02 + turned @ k.T, (count, 1)) + 5e-6 * chance.standard_normal((count * len(stated), 3))
    rows = turning(np.tile(stated, (count, 1)))
    found = solved(
        Observations(np.repeat(np.arange(count), len(stated)), np.tile(np.arange(len(stated)), count),
                     rows.pitch_rad, rows.roll_rad, dict(zip(AXES, volts.T, strict=True)), yaw_rad=rows.yaw_rad,
                     euler_rate_rad_s=rows.euler_rate_rad_s)
    )  # fmt: skip
    for axis in found.values():
        [finding] = [finding for finding in axis.findings if finding.is_significant and finding.kind == "cubic"]
        assert "; or of the table's: rates that are wrong by another part at one speed" in finding.text


@pytest.mark.parametrize("campaigns_drawn", [40, pytest.param(400, marks=pytest.mark.thorough)])
@pytest.mark.parametrize("size_ppm", [0.1, 0.3, 1.0])
def test_what_the_scale_factor_bends_is_in_the_interval_of_a_reading(campaigns_drawn: int, size_ppm: float) -> None:
    """A third power around the size where it is found: rates read later lie where the equation says they do."""
    seed = 7
    drawn = campaigns("gyro-nonlinearity", size_ppm, np.random.default_rng(seed), campaigns_drawn, replications=6)
    clean = campaigns(
        "gyro-nonlinearity", size_ppm, np.random.default_rng(seed), campaigns_drawn, replications=6, dwell_noise_v=0.0
    )
    chance, reading_v = np.random.default_rng(8), drawn.setup.dwell_noise_v
    held: dict[str, list[bool]] = {"offset": [], "scale factor": [], "reading": []}
    for campaign in range(campaigns_drawn):
        rows, truth = rows_of_gyros(drawn, campaign), rows_of_gyros(clean, campaign)
        points = len(rows.pitch_rad) // 6
        velocity = np.rad2deg(body_rates_rad_s(np.zeros((points, 3)), truth.euler_rate_rad_s[:points]))
        line = np.column_stack([np.ones(points), velocity])
        for index, (label, axis) in enumerate(solved(rows).items()):
            straight = np.linalg.lstsq(line, truth.outputs[label][:points], rcond=None)[0]
            halfwidth = t_quantile(0.95, axis.primary_dof) * np.sqrt(np.diag(axis.primary_covariance))
            inside = np.abs(axis.primary[:4] - straight) < halfwidth[:4]
            held["offset"].append(bool(inside[0]))
            held["scale factor"].append(bool(inside[1 + index]))
            at = turning(velocity[[0, 5]])
            new = truth.outputs[label][[0, 5]] + reading_v * chance.standard_normal(2)
            far = np.abs(new - model_of_solution(axis).predict(axis.primary, at))
            held["reading"] += (far < prediction_halfwidth_v(axis, at, reading_v)).tolist()
    rates = {name: float(np.mean(inside)) for name, inside in held.items()}
    assert min(rates.values()) > (0.90 if campaigns_drawn < 100 else 0.93), rates


def test_a_test_lets_the_terms_in_where_they_are_and_leaves_them_out_where_they_are_not() -> None:
    """F of two terms, by two fits of numpy to the means of the points: replications of the same rates weigh alike."""
    for size_ppm, is_there in ((0.0, False), (10.0, True)):
        rows = rows_of_gyros(campaigns("gyro-nonlinearity", size_ppm, np.random.default_rng(9), 1, replications=4))
        velocity = np.rad2deg(body_rates_rad_s(np.zeros((rows.rows, 3)), rows.euler_rate_rad_s))[: rows.rows // 4]
        for index, (label, axis) in enumerate(solved(rows, "test").items()):
            extension = axis.notes["extension"]
            assert isinstance(extension, Extension)
            mean = rows.outputs[label].reshape(4, -1).mean(axis=0)
            line = np.column_stack([np.ones(len(velocity)), velocity])
            bent = np.column_stack([line, velocity[:, index] ** 2 / 1e4, velocity[:, index] ** 3 / 1e6])
            left = [float(np.sum((mean - a @ np.linalg.lstsq(a, mean, rcond=None)[0]) ** 2)) for a in (line, bent)]
            dof = len(velocity) - 6
            f = (left[0] - left[1]) / 2.0 / (left[1] / dof)
            assert extension.test.t <= f * (1.0 + 1e-6)  # never against less than the noise inside the replications
            assert extension.test.t > 0.2 * f
            assert extension.is_accepted == is_there
            assert axis.primary_names == (GyroWithTerms(label, ((0.0,) * 4,) * 2).primary_names if is_there else
                                          Gyro.primary_names)  # fmt: skip
            assert any("terms of the scale factor are significant" in text for text in axis.warnings) == is_there


@pytest.mark.parametrize("campaigns_drawn", [30, pytest.param(400, marks=pytest.mark.thorough)])
@pytest.mark.parametrize("extended", ["no", "test", "yes"])
def test_where_nothing_is_bent_all_three_ways_hold_their_intervals(
    extended: Literal["no", "test", "yes"], campaigns_drawn: int
) -> None:
    drawn = campaigns("gyro-nonlinearity", 0.0, np.random.default_rng(10), campaigns_drawn, replications=6)
    held: dict[str, list[bool]] = {"offset": [], "k": []}
    for campaign in range(campaigns_drawn):
        for index, axis in enumerate(solved(rows_of_gyros(drawn, campaign), extended).values()):
            truth = np.concatenate(
                [[drawn.truth.offset_v[campaign, index]], drawn.truth.matrix_v_per_dps[campaign, index]]
            )
            half = t_quantile(0.95, axis.primary_dof) * np.sqrt(np.diag(axis.primary_covariance))
            inside = np.abs(axis.primary[:4] - truth) <= half[:4]
            held["offset"].append(bool(inside[0]))
            held["k"] += inside[1:].tolist()
    shares = {name: float(np.mean(each)) for name, each in held.items()}
    low, high = (0.86, 1.0) if campaigns_drawn < 100 else (0.93, 0.97)
    assert all(low <= share <= high for share in shares.values()), shares
