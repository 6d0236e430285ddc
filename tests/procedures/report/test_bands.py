from dataclasses import replace

import numpy as np
import pytest
from report_scene import Scene, run_view
from scipy.stats import t

from ams.calibration.calibrate import calibrate
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from procedures.report.bands import Along, band_along


def test_the_bands_of_a_tumble_are_those_of_its_published_variance() -> None:
    # TP section 4: the six-point tumble with roll predicts with variance 2/3 of that of a dwell, at every attitude.
    tumble = [(0.0, 0.0), (0.0, 90.0), (0.0, 180.0), (0.0, -90.0), (90.0, 0.0), (-90.0, 0.0)]
    view = run_view(Scene(points=tuple(tumble), replications=1, noise_arcsec=5.0, axes=("x",)))
    sensor = view.sensors[0]
    solution = sensor.axes[0].calibration
    assert sensor.observations is not None
    directions: tuple[Along, ...] = ("pitch", "roll")
    for along in directions:
        band = band_along(solution, sensor.observations, along)
        factor = t.ppf(0.975, 2) * solution.standard_error_v
        np.testing.assert_allclose(band.confidence_v, factor * np.sqrt(2 / 3), rtol=1e-9)
        np.testing.assert_allclose(band.prediction_v, factor * np.sqrt(5 / 3), rtol=1e-9)


def test_the_prediction_band_holds_as_many_dwells_as_it_says() -> None:
    view = run_view(Scene(pitch_deg=tuple(range(-90, 91, 10)), roll_deg=tuple(range(-180, 180, 30)), replications=6))
    sensor = view.sensors[0]
    assert sensor.observations is not None
    for axis in sensor.axes:
        band = band_along(axis.calibration, sensor.observations, "pitch")
        half = np.interp(np.rad2deg(sensor.observations.pitch_rad), band.angle_deg, band.prediction_v)
        inside = float(np.mean(np.abs(axis.calibration.residuals_v) <= half))
        assert inside == pytest.approx(0.95, abs=0.02)


def test_a_design_with_one_roll_angle_has_bands_too() -> None:
    view = run_view(Scene(pitch_deg=tuple(range(-90, 91, 10)), roll_deg=(0.0, 90.0), axes=("x",)))
    sensor = view.sensors[0]
    assert sensor.observations is not None
    band = band_along(sensor.axes[0].calibration, sensor.observations, "roll")
    assert np.all(np.isfinite(band.confidence_v))


def test_no_attitude_of_the_design_has_a_wider_interval_than_the_band() -> None:
    # An uneven design, whose variance function depends on both angles; φᵀVφ by hand at every point.
    points = tuple((float(p), float(r)) for p in (-90, -20, 0, 60) for r in (-150, -30, 0, 20, 90))
    sensor = run_view(Scene(points=points, replications=2, axes=("x",))).sensors[0]
    rows, solution = sensor.observations, sensor.axes[0].calibration
    assert rows is not None
    a, r = rows.pitch_rad, rows.roll_rad
    phi = np.column_stack([np.ones(a.size), np.sin(a), -np.cos(a) * np.sin(r), -np.cos(a) * np.cos(r)])
    half_v = t.ppf(0.975, rows.rows - 4) * np.sqrt(np.einsum("ij,jk,ik->i", phi, solution.primary_covariance, phi))
    angles: dict[Along, np.ndarray] = {"pitch": a, "roll": r}
    for along, angle in angles.items():
        band = band_along(solution, rows, along)
        drawn_v = np.interp(np.rad2deg(angle), band.angle_deg, band.confidence_v)
        assert np.all(half_v <= 1.001 * drawn_v)
        assert np.max(half_v / drawn_v) > 0.99


def test_a_package_of_cr_has_the_band_of_its_own_gravity_and_not_of_tps() -> None:
    # Yaw turns gravity out of TP's directions: φ = (1, G) of CR (III-B.30) to (III-B.32), by hand at every point.
    pitch, yaw, roll = (
        np.deg2rad(a).ravel() for a in np.meshgrid([-40.0, 5.0, 60.0], [-60.0, 10.0], [-90.0, 0.0, 50.0])
    )
    g = np.array([-np.sin(pitch) * np.cos(yaw), np.sin(pitch) * np.sin(yaw), np.cos(pitch)])
    g_y = np.cos(roll) * g[1] + np.sin(roll) * g[2]
    phi = np.column_stack([np.ones(18), g[0], g_y, -np.sin(roll) * g[1] + np.cos(roll) * g[2]])
    volts = phi @ [0.1, 2.5, 0.01, -0.02] + np.random.default_rng(1).normal(0.0, 1e-4, 18)
    rows = Observations(np.ones(18, dtype=int), np.arange(18), pitch, roll, {"x": volts}, yaw_rad=yaw)
    solution = calibrate(rows, CalibrationRequest(model="pitch-yaw-roll-model", extended="no")).axes["x"]
    half_v = t.ppf(0.975, 14) * np.sqrt(np.einsum("ij,jk,ik->i", phi, solution.primary_covariance, phi))
    angles: dict[Along, np.ndarray] = {"pitch": pitch, "roll": roll}
    for along, angle in angles.items():
        band = band_along(solution, rows, along)
        drawn_v = np.interp(np.rad2deg(angle), band.angle_deg, band.confidence_v)
        assert np.all(half_v <= 1.001 * drawn_v)
        assert np.max(half_v / drawn_v) > 0.99


def test_a_temperature_model_has_the_band_of_the_widest_temperature_it_visited() -> None:
    chance = np.random.default_rng(2)
    attitudes = [(p, r) for p in (-60.0, 0.0, 60.0) for r in (-120.0, 0.0, 120.0)]
    pitch, roll = np.deg2rad(np.array(attitudes * 4)).T
    warm = np.repeat([10.0, 30.0, 31.0, 11.0], 9)
    phi = np.column_stack([np.ones(36), np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)])
    volts = phi @ [0.0, 2.5, 0.0, 0.0] + 1e-3 * (warm - 20.0) + chance.normal(0.0, 1e-4, 36)
    rows = Observations(np.arange(36) // 9, np.arange(36) % 9, pitch, roll, {"x": volts}, temperature_degc=warm)
    solution = calibrate(
        rows, CalibrationRequest(temperature="estimate", reference_temperature_degc=20.0, extended="no")
    ).axes["x"]
    band = band_along(solution, rows, "pitch")
    cold = band_along(solution, replace(rows, temperature_degc=np.full(36, 20.0)), "pitch")
    ratio = band.confidence_v / cold.confidence_v
    assert ratio.min() >= 1.0
    assert ratio.max() > 1.2
