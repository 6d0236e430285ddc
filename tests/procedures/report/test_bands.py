import numpy as np
import pytest
from report_scene import Scene, run_view
from scipy.stats import t

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
