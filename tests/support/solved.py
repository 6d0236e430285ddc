"""Calibrations built by hand from known parameters, so that a set can be tested without a solver."""

from dataclasses import replace
from datetime import UTC, date, datetime

import numpy as np

from ams.calibration_result import (
    AxisCalibration,
    Calibration,
    FTest,
    ParameterEstimate,
    Replication,
    TpReplication,
    VarianceComponent,
)
from ams.sets.provenance import Provenance, Standard

PARAMETERS = {
    "x": (0.005, 2.5, 0.5, 35.0),
    "y": (-0.0121, 2.47, 0.31, -120.0),
    "z": (0.0007, -2.52, 0.12, 171.0),
}
"""Offset V, sensitivity V/g, coning deg, azimuth deg."""
NAMES = ("offset_v", "sensitivity_v_per_g", "coning_deg", "azimuth_deg")
PRIMARY_NAMES = ("offset_v", "k_x_v_per_g", "k_y_v_per_g", "k_z_v_per_g")


def direction(axis: str, sensitivity: float, coning_deg: float, azimuth_deg: float) -> np.ndarray:
    """k = S·u, written out axis by axis from the definition of the angles."""
    c, s = np.cos(np.radians(coning_deg)), np.sin(np.radians(coning_deg))
    along, across = s * np.cos(np.radians(azimuth_deg)), s * np.sin(np.radians(azimuth_deg))
    return sensitivity * np.array({"x": (c, along, across), "y": (across, c, along), "z": (along, across, c)}[axis])


def _test(t: float) -> FTest:
    return FTest(t, 1.16, 0.2, 243.0, 1215.0, False)


def replication() -> Replication:
    drift = {name: _test(1.1) for name in ("offset", "sensitivity", "coning", "azimuth")}
    alone = {1: dict(zip(NAMES, PARAMETERS["x"], strict=True)), 2: dict(zip(NAMES, PARAMETERS["x"], strict=True))}
    return Replication(
        2, 247, _test(0.98), drift, TpReplication(4.17e-5, 1.54e-5, 37.3, 1.16, drift), 2e-5, 1e-5, alone
    )


def solved_axis(axis: str = "x", *, with_angles: bool = True) -> AxisCalibration:
    offset, sensitivity, coning, azimuth = PARAMETERS[axis]
    values = (offset, sensitivity, coning, azimuth) if with_angles else (offset, sensitivity, None, None)
    k = direction(axis, sensitivity, coning, azimuth)
    covariance = np.diag([1e-12, 2e-12, 1e-9, 1e-3])
    primary_covariance = np.diag([1e-12, 2e-12, 2e-12, 2e-12]) + 1e-13
    return AxisCalibration(
        axis=axis,
        model="pitch-roll",
        nominal_axis=axis,
        parameters=tuple(
            ParameterEstimate(name, value, 1e-6, 0.9e-6, 5.2, None if value is None else (value - 2e-6, value + 2e-6))
            for name, value in zip(NAMES, values, strict=True)
        ),
        covariance=covariance if with_angles else np.diag([1e-12, 2e-12, np.nan, np.nan]),
        primary_names=PRIMARY_NAMES,
        primary=np.array([offset, *k]),
        primary_covariance=primary_covariance,
        tp_primary_covariance=0.9 * primary_covariance,
        primary_dof=np.array([5.2, 5.3, 6.1, np.inf]),
        standard_error_v=2e-5,
        degrees_of_freedom=490,
        sensitive_axis_v_per_g=(float(k[0]), float(k[1]), float(k[2])),
        fitted_v=np.zeros(0),
        residuals_v=np.zeros(0),
        replication=replication() if axis == "x" else None,
        variance_components=(
            VarianceComponent("replications", np.diag([1e-12, 2e-12, 2e-12, 2e-12]), 5.0),
            VarianceComponent("table", np.full((4, 4), 1e-13), np.inf),
        ),
        warnings=() if with_angles else ("coning angle is within five standard uncertainties of zero",),
    )


def solved_package(axes: str = "xyz") -> Calibration:
    return Calibration({axis: solved_axis(axis) for axis in axes}, "pitch-roll", "TP")


def provenance(**changes: object) -> Provenance:
    base = Provenance(
        sensor="SN1047",
        serial="1047",
        sensor_model="three-axis package",
        gravity_mps2=9.79826,
        gravity_source="survey 2024",
        pitch_range_deg=(-90.0, 90.0),
        roll_range_deg=(-180.0, 180.0),
        temperature_range_degc=(19.0, 21.0),
        created_utc=datetime(2026, 3, 1, 6, 20, tzinfo=UTC),
        software_version="0.1.0",
        rig="accelerometer laboratory, dual-axis table",
        procedure="three-axis, ±90°, six replications",
        operator="J. Doe",
        run_id="20260228T190000Z-three-axis",
        journal_sha256="0123456789abcdef" * 4,
        simulated=False,
        environment={"air": {"mean_degc": 20.02, "min_degc": 19.6, "max_degc": 20.4}},
        standards=(
            Standard("table", "77", "C-2025-14", date(2027, 1, 31), {"limit_arcsec": 1.0, "kind": "limit"}),
            Standard("meter", "2823A", None, None),
        ),
        mount={"x": "+pitch", "datum": "face A"},
        chain={"x": {"load_resistor_ohm": 2500, "ratiometric": False}},
        job={"customer": '=HYPERLINK("http://example.invalid")', "item": "-1\r\n@x"},
        laboratory={"name": "Instrument Laboratory"},
    )
    return replace(base, **changes)
