import numpy as np
import pytest
from report_scene import Scene, run_view
from scipy.stats import t

from procedures.report.bands import band_along


def test_the_bands_of_a_tumble_are_those_of_its_published_variance() -> None:
    # TP section 4: the six-point tumble with roll predicts with variance 2/3 of that of a dwell, at every attitude.
    tumble = [(0.0, 0.0), (0.0, 90.0), (0.0, 180.0), (0.0, -90.0), (90.0, 0.0), (-90.0, 0.0)]
    view = run_view(Scene(points=tuple(tumble), replications=1, noise_arcsec=5.0, axes=("x",)))
    sensor = view.sensors[0]
    solution = sensor.axes[0].calibration
    assert sensor.observations is not None
    for along in ("pitch", "roll"):
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
