"""Errors that all rows share: each part of the covariance is the shift that the very error makes in a calibration.

The errors are made by explicit rotations and by wrong instruments, and the package is calibrated again.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from simulated_campaign import ARCSEC, Campaign

from ams.calibration.calibrate import calibrate
from ams.calibration_result import AxisCalibration
from ams.errors import ObservationsError
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import Effect, SharedError
from ams.models.cr import model_gravity_g, sting_gravity_g
from ams.models.thermal import TemperatureCoefficients
from ams.observations import Observations

CAMPAIGN = Campaign(replications=3, noise_arcsec=0.3)
K = {"x": np.array([2.5, 0.02, -0.01]), "y": np.array([0.03, 2.4, 0.02]), "z": np.array([0.01, -0.02, 2.6])}
OFFSET_V = {"x": 0.005, "y": -0.02, "z": 0.03}
TILT_RAD = 0.0005 * ARCSEC


def about_x(angle: float) -> np.ndarray:
    return np.array([[1, 0, 0], [0, np.cos(angle), np.sin(angle)], [0, -np.sin(angle), np.cos(angle)]])


def about_y(angle: float) -> np.ndarray:
    return np.array([[np.cos(angle), 0, -np.sin(angle)], [0, 1, 0], [np.sin(angle), 0, np.cos(angle)]])


def about_z(angle: float) -> np.ndarray:
    return np.array([[np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0], [0, 0, 1]])


def felt(rows: Observations, before_pitch: np.ndarray, pitch_error: float = 0.0) -> np.ndarray:
    """(N, 3) specific force by passive rotations from outside in: base, pitch, yaw, roll."""
    up = before_pitch @ np.array([0.0, 0.0, -1.0])
    yaw = np.zeros(rows.rows) if rows.yaw_rad is None else rows.yaw_rad
    angles = zip(rows.pitch_rad + pitch_error, yaw, rows.roll_rad, strict=True)
    return np.array([about_x(roll) @ about_z(turn) @ about_y(pitch) @ up for pitch, turn, roll in angles])


def with_outputs(rows: Observations, force: np.ndarray) -> Observations:
    """Under so much noise, the same each time, that the fit cannot tell the error from it and leaves it where it is."""
    noise_v = 1e-5 * np.random.default_rng(5).standard_normal((3, rows.rows))
    outputs = {axis: OFFSET_V[axis] + force @ K[axis] + own for axis, own in zip(K, noise_v, strict=True)}
    return replace(rows, outputs=outputs)


def solved(rows: Observations, model: str = "pitch-roll", *errors: SharedError) -> dict[str, AxisCalibration]:
    shared = dict.fromkeys("xyz", errors)
    return dict(calibrate(rows, CalibrationRequest(model=model, shared_errors=shared, extended="no")).axes)


def part(axis: AxisCalibration, name: str) -> np.ndarray:
    """(P,) column of a part of rank one, up to its sign."""
    covariance = next(item.covariance for item in axis.variance_components if item.name == name)
    values, vectors = np.linalg.eigh(covariance)
    assert values[:-1] == pytest.approx(0.0, abs=1e-9 * values[-1])
    return np.sqrt(values[-1]) * vectors[:, -1]


def assert_same_up_to_sign(entry: np.ndarray, other: np.ndarray, relative: float) -> None:
    sign = 1.0 if entry @ other > 0.0 else -1.0
    np.testing.assert_allclose(entry, sign * other, atol=relative * float(np.abs(other).max()))


@pytest.fixture(scope="module")
def plain() -> Observations:
    rows = CAMPAIGN.observe(np.random.default_rng(0))
    return with_outputs(rows, specific_force(rows.pitch_rad, rows.roll_rad))


@pytest.fixture(scope="module")
def yawed(plain: Observations) -> Observations:
    yaw = np.deg2rad(30.0 * (plain.point % 3 - 1.0))
    rows = replace(plain, yaw_rad=yaw)
    return with_outputs(rows, -model_gravity_g(sting_gravity_g(rows.pitch_rad, yaw), rows.roll_rad))


SHIFTS: dict[Effect, Callable[[Observations], Observations]] = {
    "reading": lambda rows: replace(rows, outputs={a: v + 3e-9 for a, v in rows.outputs.items()}),
    "gain": lambda rows: replace(rows, outputs={a: v * (1.0 + 1e-9) for a, v in rows.outputs.items()}),
    "pitch": lambda rows: with_outputs(rows, felt(rows, np.eye(3), TILT_RAD)),
    "base-tilt": lambda rows: with_outputs(rows, felt(rows, about_x(TILT_RAD))),
}
SIZES: dict[Effect, float] = {"reading": 3e-9, "gain": 1e-9, "pitch": TILT_RAD, "base-tilt": TILT_RAD}


@pytest.mark.parametrize("effect", list(SHIFTS))
@pytest.mark.parametrize("model", ["pitch-roll", "pitch-yaw-roll-model"])
def test_a_part_is_the_shift_that_the_error_makes(
    effect: Effect, model: str, plain: Observations, yawed: Observations
) -> None:
    rows = plain if model == "pitch-roll" else yawed
    found = solved(rows, model, SharedError("it", effect, SIZES[effect]))
    before, after = solved(rows, model), solved(SHIFTS[effect](rows), model)
    for axis in "xyz":
        assert_same_up_to_sign(part(found[axis], "it"), after[axis].primary - before[axis].primary, 1e-3)


def test_the_sting_package_does_not_see_roll_in_a_tilt(yawed: Observations) -> None:
    still = replace(yawed, roll_rad=np.zeros(yawed.rows))
    rows = replace(with_outputs(still, felt(still, np.eye(3))), roll_rad=yawed.roll_rad)
    text = solved(rows, "pitch-yaw-roll-sting", SharedError("it", "base-tilt", TILT_RAD))
    before = solved(rows, "pitch-yaw-roll-sting")
    tilted = replace(with_outputs(still, felt(still, about_x(TILT_RAD))), roll_rad=yawed.roll_rad)
    after = solved(tilted, "pitch-yaw-roll-sting")
    for axis in "xyz":
        assert_same_up_to_sign(part(text[axis], "it"), after[axis].primary - before[axis].primary, 1e-3)


def test_a_wrong_thermometer_moves_the_parameters_by_its_part(plain: Observations) -> None:
    warm = replace(plain, temperature_degc=20.0 + np.linspace(-4.0, 4.0, plain.rows))
    known = dict.fromkeys("xyz", TemperatureCoefficients(2e-5, -4e-5))

    def fit(rows: Observations, *errors: SharedError) -> AxisCalibration:
        request = CalibrationRequest(
            temperature="apply", known_temperature=known, reference_temperature_degc=20.0,
            shared_errors=dict.fromkeys("xyz", errors), extended="no",
        )  # fmt: skip
        return calibrate(rows, request).axes["x"]

    assert warm.temperature_degc is not None
    found = fit(warm, SharedError("thermometer", "temperature", 1e-4))
    before = fit(warm)
    after = fit(replace(warm, temperature_degc=warm.temperature_degc + 1e-4))
    free = slice(0, 4)
    assert_same_up_to_sign(part(found, "thermometer")[free], (after.primary - before.primary)[free], 1e-3)


def test_replications_make_a_shared_error_no_smaller() -> None:
    error = SharedError("meter", "reading", 1e-4)
    few, many = (
        calibrate(
            Campaign(replications=count, noise_arcsec=0.3).observe(np.random.default_rng(1)),
            CalibrationRequest(shared_errors=dict.fromkeys("xyz", (error,)), extended="no"),
        ).axes["x"]
        for count in (2, 12)
    )
    for axis in (few, many):
        assert float(np.sqrt(next(p.covariance[0, 0] for p in axis.variance_components if p.name == "meter"))) == (
            pytest.approx(1e-4, rel=1e-9)
        )


def test_an_uncertainty_that_is_none_is_refused() -> None:
    with pytest.raises(ObservationsError, match="multimeter: standard uncertainty: got nan, allowed 0 or more"):
        SharedError("multimeter", "reading", float("nan"))
