"""What a document says beyond the numbers, and H_E against the second derivative of the sum of squares itself."""

import json
from dataclasses import replace

import numpy as np
import pytest
from simulated_campaign import ARCSEC, Campaign
from solved import provenance

from ams.analysis.calibration_budget import axis_budget
from ams.analysis.diagnostics.size_words import Scale
from ams.calibration.calibrate import calibrate
from ams.calibration.findings_document import full_document
from ams.calibration.output.moved_quantities import _move
from ams.exports.formats import FORMATS
from ams.inputs.request import CalibrationRequest
from ams.models.accelerometer import PitchRoll
from ams.models.thermal import WithTemperature
from ams.observations import Observations
from ams.sets.apply import apply
from ams.sets.coefficients import build_set
from ams.solve.residual_curvature import residual_curvature

WHOLE_TURN = Campaign(
    pitch_deg=np.arange(-180.0, 181.0, 20.0), roll_deg=np.arange(-180.0, 151.0, 30.0), replications=4, noise_arcsec=0.5
)


def soft_and_drifting() -> Observations:
    """2 q_xz f_x f_z = −q_xz sin 2α cos R with q_xz = 5 arc seconds of 2.5 V/g, and 30 µV an hour."""
    rows = WHOLE_TURN.observe(np.random.default_rng(0))
    time_s = 60.0 * np.arange(rows.rows)
    x = rows.outputs["x"] - 5.0 * ARCSEC * 2.5 * np.sin(2.0 * rows.pitch_rad) * np.cos(rows.roll_rad)
    return replace(rows, outputs={"x": x + 30e-6 * time_s / 3600.0, "y": rows.outputs["y"]}, time_s=time_s)


@pytest.fixture(scope="module")
def document() -> dict:
    rows = soft_and_drifting()
    request = CalibrationRequest(extended="test", residual_curvature=True)
    solved = calibrate(rows, request)
    return full_document(solved, rows, {name: axis_budget(axis) for name, axis in solved.axes.items()})


def test_every_axis_has_its_findings_behind_the_published_keys(document: dict) -> None:
    assert list(document) == ["axes", "verdict", "method_version", "model", "convention", "package_covariance"]
    text = list(document["axes"]["x"])[8:]
    assert text == ["remarks", "advice", "findings", "extension", "residual_curvature", "budget"]
    json.dumps(document, allow_nan=False)


def test_the_planted_drift_is_told_per_replication_and_hour() -> None:
    rows = soft_and_drifting()
    advice = full_document(calibrate(rows, CalibrationRequest(extended="no")), rows)["axes"]["x"]["advice"]
    (drift,) = [entry for entry in advice["drift"] if entry["parameter"] == "offset_v"]
    a_replication_h = 60.0 * rows.rows / 4 / 3600.0
    assert drift["per_hour"] == pytest.approx(30e-6, rel=0.02)
    assert drift["per_replication"] == pytest.approx(30e-6 * a_replication_h, rel=0.02)
    (term,) = [entry for entry in advice["lack_of_fit"] if entry["name"] == "sin 2α·cos R"]
    assert term["amplitude_v"] == pytest.approx(-5.0 * ARCSEC * 2.5, rel=0.05)


def test_the_extension_tells_f_its_limit_and_the_verdict(document: dict) -> None:
    taken, left = (document["axes"][axis]["extension"] for axis in "xy")
    assert taken["is_accepted"]
    assert taken["f"] > taken["f_95"]
    assert not left["is_accepted"]
    assert left["f_95"] == pytest.approx(2.21, abs=0.15)  # F(5, ∞) is 2.214
    assert "mounted the other way round" in taken["remark"]


def test_the_axes_of_a_package_have_a_covariance_together(document: dict) -> None:
    package = document["package_covariance"]
    assert package["order"][0] == ["x", "offset_v"]
    covariance = np.array(package["covariance"])
    np.testing.assert_allclose(covariance, covariance.T, rtol=1e-9)
    assert np.linalg.eigvalsh(covariance).min() > -1e-12 * covariance.max()


def test_h_e_is_the_rest_of_the_second_derivative_of_the_sum_of_squares() -> None:
    """½ ∂²(Σe²) = F_cᵀF_c − H_E, TP (44), (45) with the sign that the sum of squares has."""
    rows = WHOLE_TURN.observe(np.random.default_rng(1))
    warm = replace(rows, temperature_degc=20.0 + 10.0 * np.sin(np.arange(rows.rows)))
    model = WithTemperature(PitchRoll("x"), 20.0)
    primary = np.array([0.01, 2.5, 0.02, -0.01, 1e-4, 3e-3])
    output = model.predict(primary, warm) + 0.05 * np.random.default_rng(2).standard_normal(rows.rows)
    found = residual_curvature(model, primary, warm, output - model.predict(primary, warm))
    slopes = model.jacobian(primary, warm)

    def half_square(change: np.ndarray) -> float:
        left = output - model.predict(primary + change, warm)
        return 0.5 * float(left @ left)

    steps = np.diag([1e-3, 1e-3, 1e-3, 1e-3, 1e-4, 1e-4])
    whole = np.array(
        [
            [
                (half_square(a + b) - half_square(a - b) - half_square(b - a) + half_square(-a - b))
                / (4.0 * a.sum() * b.sum())
                for b in steps
            ]
            for a in steps
        ]
    )
    assert np.abs(found.h_e).max() > 0.0
    np.testing.assert_allclose(slopes.T @ slopes - found.h_e, whole, rtol=2e-4, atol=2e-4 * np.abs(found.h_e).max())


def test_h_e_is_asked_for_and_zero_where_the_model_is_linear(document: dict) -> None:
    curvature = document["axes"]["y"]["residual_curvature"]
    assert not np.any(curvature["h_e"])
    assert set(curvature["standard_uncertainty_ratio"].values()) == {1.0}
    rows = soft_and_drifting()
    assert (
        "residual_curvature" not in full_document(calibrate(rows, CalibrationRequest(extended="no")), rows)["axes"]["x"]
    )


def test_a_set_stands_at_the_reference_time_and_never_extrapolates_the_drift() -> None:
    rows = soft_and_drifting()
    solved = calibrate(rows, CalibrationRequest(nominal_axes={"x": "x"}, time_term=True, extended="no"))
    assert not any("never applied" in text for text in solved.axes["x"].warnings)
    axis, made = solved.axes["x"], build_set(solved, provenance())
    section = made.document["axes"]["x"]
    assert section["parameters"]["offset_drift_v_per_h"]["value"] == pytest.approx(30e-6, rel=0.02)
    assert section["parameters"]["offset_drift_v_per_h"]["unit"] == "V/h"
    reference_s = 0.5 * 60.0 * (rows.rows - 1)
    assert section["parameters"]["reference_time_s"]["value"] == pytest.approx(reference_s)
    assert any("time_s = " in text and "never applied" in text for text in section["warnings"])
    assert "offset_drift_v_per_h" not in section["primary"]["order"]
    found = apply(made, rows.pitch_rad[:5], rows.roll_rad[:5], beyond_validity=True)["x"]
    k, pitch, roll = axis.primary[1:4], rows.pitch_rad[:5], rows.roll_rad[:5]
    force = np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)], axis=-1)
    np.testing.assert_allclose(found, axis.primary[0] + force @ k, rtol=1e-12)


@pytest.mark.parametrize("kind", sorted(set(FORMATS) - {"imucal"}))
def test_every_format_takes_a_set_with_a_time_term(kind: str) -> None:
    """imucal takes triads alone, and says so of these two axes."""
    rows = soft_and_drifting()
    made = build_set(calibrate(rows, CalibrationRequest(time_term=True, extended="no")), provenance())
    assert FORMATS[kind].to_bytes(made)


def test_a_move_of_a_sensitivity_is_told_without_an_exponent() -> None:
    """Source: JCGM 100 7.2.6, two digits: 99.6 is 100, as a person writes it."""
    assert [_move("sensitivity_v_per_g", span, 1.0, Scale("V", None)) for span in (97e-6, 99.6e-6)] == [
        "97 ppm",
        "100 ppm",
    ]
