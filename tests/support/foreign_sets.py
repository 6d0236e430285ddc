"""Sets that strain an export: temperature terms, a quadratic model, and texts that mean something to every parser."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from solved import provenance, solved_axis, solved_package

from ams.calibration_result import AxisCalibration, Calibration, ParameterEstimate
from ams.sets.coefficients import CoefficientSet, build_set

HOSTILE = '"; */ #error "x" /* $(P) ${P} ??/ \\ @p@ <a>&b; ]]> -- %s \n# \r\n * document_json| {} é µ 単位 \t\x1b'
Q = (1e-4, -2e-4, 3e-4, 5e-5, -1e-4)
TC = {"offset_tc_v_per_degc": 1e-4, "sensitivity_tc_per_degc": -2e-4}
TC2 = {**TC, "offset_tc2_v_per_degc2": -3e-6, "sensitivity_tc2_per_degc2": 5e-6}


def hostile() -> CoefficientSet:
    """A package whose declared texts try to end comments, strings and elements."""
    declared = {"customer": HOSTILE, "item": HOSTILE, HOSTILE: [HOSTILE, None, True]}
    return build_set(
        solved_package(),
        provenance(
            sensor='SN*/ 10"47$(P)',
            serial=HOSTILE,
            sensor_model=HOSTILE,
            gravity_source=HOSTILE,
            operator=HOSTILE,
            job=declared,
            laboratory={"name": HOSTILE},
            mount={"x": "+x", "y": "-y", "z": "-z", "datum": HOSTILE},
            chain={HOSTILE: {"serial": HOSTILE}},
        ),
    )


def warm() -> CoefficientSet:
    """A package with temperature coefficients."""
    axes = {axis: _warm(solved_axis(axis)) for axis in "xyz"}
    return build_set(Calibration(axes, "pitch-roll", "TP"), provenance(temperature_range_degc=(0.0, 40.0)))


def bending() -> CoefficientSet:
    """A package whose offset and sensitivities bend with temperature."""
    axes = {axis: _warm(solved_axis(axis), TC2) for axis in "xyz"}
    return build_set(Calibration(axes, "pitch-roll", "TP"), provenance(temperature_range_degc=(0.0, 40.0)))


def quadratic() -> CoefficientSet:
    """One axis of the extended model."""
    axis = solved_axis("y")
    names = tuple(f"q_{pair}_v_per_g2" for pair in ("xx", "xy", "xz", "yy", "yz"))
    extended = replace(
        axis,
        model="pitch-roll-extended",
        parameters=(*axis.parameters, *(_estimate(name, value) for name, value in zip(names, Q, strict=True))),
        covariance=np.diag([*np.diag(axis.covariance), *[1e-12] * 5]),
        **_with_primary(axis, names, Q),
    )
    return build_set(Calibration({"y": extended}, "pitch-roll-extended", "TP"), provenance())


def _warm(axis: AxisCalibration, coefficients: Mapping[str, float] = TC) -> AxisCalibration:
    names, values = tuple(coefficients), tuple(coefficients.values())
    extra = (*coefficients.items(), ("reference_temperature_degc", 20.0))
    return replace(
        axis,
        parameters=(*axis.parameters, *(_estimate(name, value) for name, value in extra)),
        covariance=np.diag([*np.diag(axis.covariance), *[1e-12] * len(names), 0.0]),
        **_with_primary(axis, names, values),
    )


def _with_primary(axis: AxisCalibration, names: tuple[str, ...], values: tuple[float, ...]) -> dict[str, object]:
    covariance = np.diag([1e-12] * (4 + len(names)))
    return {
        "primary_names": (*axis.primary_names, *names),
        "primary": np.array([*axis.primary, *values]),
        "primary_covariance": covariance,
        "tp_primary_covariance": covariance,
        "primary_dof": np.full(4 + len(names), 5.0),
        "variance_components": (),
    }


def _estimate(name: str, value: float) -> ParameterEstimate:
    return ParameterEstimate(name, value, 1e-6, 0.9e-6, 5.2, (value - 2e-6, value + 2e-6))
