"""A calibration as the JSON document of ``calrig fit`` and ``calrig solve``: finite numbers or null, nothing else."""

from collections.abc import Mapping
from math import isfinite

from ams.calibration_result import AxisCalibration, Calibration, FTest, ParameterEstimate, Replication, TpReplication
from ams.statistics.intervals import INFINITE_DOF

Document = dict[str, object]


def to_document(calibration: Calibration) -> Document:
    """Return ``{"axes": {label: …}}``; warnings and remarks that concern every axis stand once in each of them."""
    return {"axes": {label: _axis(axis, calibration) for label, axis in calibration.axes.items()}}


def _axis(axis: AxisCalibration, calibration: Calibration) -> Document:
    return {
        "parameters": {estimate.name: _parameter(estimate) for estimate in axis.parameters},
        "covariance": [[number(float(value)) for value in row] for row in axis.covariance],
        "standard_error_v": number(axis.standard_error_v),
        "degrees_of_freedom": axis.degrees_of_freedom,
        "effective_degrees_of_freedom": {
            estimate.name: degrees_of_freedom(estimate.effective_degrees_of_freedom) for estimate in axis.parameters
        },
        **_sensitive_axis(axis),
        "replication": None if axis.replication is None else _replication(axis.replication),
        "warnings": list(dict.fromkeys((*calibration.warnings, *axis.warnings))),
        "remarks": list(dict.fromkeys((*calibration.remarks, *axis.remarks))),
    }


def _sensitive_axis(axis: AxisCalibration) -> Document:
    """Return k, per g or, for gyros, per °/s."""
    primary = dict(zip(axis.primary_names, map(float, axis.primary), strict=True))
    of_rates = {name: f"k_{name}_v_per_dps" for name in "xyz"}
    if primary.keys() >= set(of_rates.values()):
        return {"sensitive_axis_v_per_dps": {name: number(primary[key]) for name, key in of_rates.items()}}
    values = map(number, axis.sensitive_axis_v_per_g)
    return {"sensitive_axis_v_per_g": dict(zip("xyz", values, strict=True))}


def _parameter(estimate: ParameterEstimate) -> Document:
    return {
        "value": number(estimate.value),
        "standard_uncertainty": number(estimate.standard_uncertainty),
        "tp_standard_uncertainty": number(estimate.tp_standard_uncertainty),
    }


def _replication(replication: Replication) -> Document:
    return {
        "n": replication.replications,
        "points": replication.points,
        "lack_of_fit": _test(replication.lack_of_fit),
        "drift": _tests(replication.drift),
        "tp": _tp(replication.tp),
    }


def _tp(tp: TpReplication) -> Document:
    return {
        "sigma_bias_v": number(tp.sigma_bias_v),
        "sigma_prec_v": number(tp.sigma_prec_v),
        "t_bias": number(tp.t_bias),
        "f_bias_95": number(tp.f_bias_95),
        "drift": _tests(tp.drift),
    }


def _tests(tests: Mapping[str, FTest]) -> Document:
    return {name: _test(test) for name, test in tests.items()}


def _test(test: FTest) -> Document:
    return {"t": number(test.t), "f_95": number(test.f_95)}


def degrees_of_freedom(dof: float | None) -> float | None:
    """Return the degrees of freedom, null where there is nothing to count.

    That is an exact value, or an uncertainty that a certificate states.
    """
    return None if dof is None or dof >= INFINITE_DOF else number(dof)


def number(value: float | None) -> float | None:
    """Return the value as JSON has it: null where it is not finite."""
    return None if value is None or not isfinite(value) else float(value)
