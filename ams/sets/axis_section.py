"""One solved axis as its section of the document, and the numbers of evaluation back from it."""

from collections.abc import Mapping

import numpy as np

from ams.arrays import FloatArray
from ams.calibration_result import AxisCalibration, FTest, ParameterEstimate, Replication, TpReplication
from ams.errors import SetError
from ams.models.drifting import at_reference_time, with_primary
from ams.sets.canonical import Document, Json, listed, number, plain, table
from ams.sets.equations import AxisNumbers, equation_of
from ams.sets.sensed_quantity import FIELDS, Units, units_in
from ams.units import UNITS, unit_of


def axis_section(axis: AxisCalibration, sensor: str) -> Document:
    """Return the document of one axis. Raises: SetError where a primary parameter is not determined."""
    axis = _of_a_set(axis, sensor)
    section: Document = {
        "nominal_axis": axis.nominal_axis,
        "equation": {},
        "parameters": {parameter.name: _parameter(parameter) for parameter in axis.parameters},
        "covariance_order": [parameter.name for parameter in axis.parameters],
        "covariance": _matrix(axis.covariance, len(axis.parameters), f"{sensor}: axis {axis.axis}: covariance"),
        "primary": _primary(axis, sensor),
        "sensitive_axis_v_per_g": dict(zip("xyz", map(_number, axis.sensitive_axis_v_per_g), strict=True)),
        "standard_error_v": _number(axis.standard_error_v),
        "degrees_of_freedom": int(axis.degrees_of_freedom),
        "replication": None if axis.replication is None else _replication(axis.replication),
        "warnings": [*axis.warnings, *axis.remarks],
        "findings": plain([finding.to_document() for finding in axis.findings], f"{sensor}: {axis.axis}: findings"),
        "notes": plain(axis.notes, f"{sensor}: axis {axis.axis}: notes"),
    }
    units = units_in(axis.model, axis.primary_names)
    section["equation"] = _equation(axis, axis_numbers(axis.axis, section, axis.model, units))
    return section if units is None else _of_lines(section, units[0])


def primary_section(axis: AxisCalibration, sensor: str) -> Document:
    """Return the primary parameters alone, as they stand in the document of the axis. Raises: SetError as that."""
    return _primary(_of_a_set(axis, sensor), sensor)


def _of_a_set(axis: AxisCalibration, sensor: str) -> AxisCalibration:
    """Return the solution as a set states it. Raises: SetError where a primary parameter is not determined."""
    if not np.isfinite(axis.primary).all():
        named = zip(axis.primary_names, axis.primary.tolist(), strict=True)
        values = ", ".join(f"{name} {value:g}" for name, value in named)
        raise SetError(
            f"{sensor}: axis {axis.axis}: a primary parameter is not determined: got {values}; no set was built; "
            "a set needs every coefficient of its equation: add the missing design points"
        )
    return without_site(at_reference_time(axis))


def _of_lines(section: Document, measured_unit: str) -> Document:
    """Return the section with every figure of the output keyed by its own unit; a line has no direction in V/g."""
    kept = {key: value for key, value in section.items() if key != "sensitive_axis_v_per_g"}
    replication = section["replication"]
    if isinstance(replication, dict):
        tp = _keyed(table(replication["tp"]), measured_unit)
        kept["replication"] = {**_keyed(replication, measured_unit), "tp": tp}
    return _keyed(kept, measured_unit)


def _keyed(entries: Document, measured_unit: str) -> Document:
    return {f"{key[:-1]}{measured_unit}" if key.endswith("_v") else key: value for key, value in entries.items()}


def standard_error_of(section: Mapping[str, Json], axis: AxisNumbers) -> float | None:
    """Return S_E of an axis, in the unit of its output; None where the set states none."""
    stated = section[f"standard_error_{axis.form.measured_unit}"]
    return None if stated is None else number(stated)


def lack_of_fit_of(section: Mapping[str, Json], axis: AxisNumbers) -> float:
    """Return what the points of an axis lack of its model, one standard deviation in the unit of its output.

    0 where the replications show none, and where nothing was replicated: S_E holds it there, as far as the fit left it.
    """
    replication = section["replication"]
    stated = None if replication is None else table(replication).get(f"lack_of_fit_{axis.form.measured_unit}")
    return 0.0 if stated is None else number(stated)


def without_site(axis: AxisCalibration) -> AxisCalibration:
    """Return the solution without primary parameters that tell of the place, such as the field beside a coil.

    They stay among the parameters, with their uncertainty; what they leave uncertain is in the others' covariance.
    """
    beginnings = FIELDS[axis.model].site_prefixes if axis.model in FIELDS else ()
    kept = [name for name in axis.primary_names if not name.startswith(beginnings)] if beginnings else []
    return with_primary(axis, kept) if kept and len(kept) < len(axis.primary_names) else axis


def axis_numbers(
    axis: str, section: Mapping[str, Json], model: str | None = None, units: Units | None = None
) -> AxisNumbers:
    """Return what the equation takes, read from the section of a checked document."""
    equation = table(section["equation"])
    centring = equation.get("centring")
    if "unit" in equation:
        units = str(equation["measured_unit"]), str(equation["unit"])
    return AxisNumbers(
        axis=axis,
        model=str(table(section["equation"])["name"]) if model is None else model,
        nominal_axis=str(section["nominal_axis"]),
        primary={name: number(value) for name, value in table(table(section["primary"])["values"]).items()},
        parameters={name: _value(table(entry)) for name, entry in table(section["parameters"]).items()},
        centring=None if centring is None else np.array([[number(c) for c in listed(row)] for row in listed(centring)]),
        units=units,
    )


def _value(parameter: Document) -> float | None:
    return None if parameter["value"] is None else number(parameter["value"])


def _equation(axis: AxisCalibration, numbers: AxisNumbers) -> Document:
    terms = len(axis.centring)
    equation = equation_of(axis.model, axis.nominal_axis, numbers.temperature_order, terms, numbers.units)
    section: Document = {
        "name": equation.name,
        "source": equation.source,
        "primary": equation.primary,
        "derived": equation.derived,
    }
    if numbers.units is not None:
        section["measured_unit"], section["unit"] = numbers.units
    if axis.centring:
        section["centring"] = [list(row) for row in axis.centring]
    return section


def _unit(name: str) -> str:
    unit = unit_of(name)
    if unit is None:
        raise SetError(
            f"parameter {name}: its name ends in no unit that sets know: allowed are "
            f"{', '.join(f'_{ending}' for ending in UNITS)}; nothing was built"
        )
    return unit


def _parameter(parameter: ParameterEstimate) -> Document:
    return {
        "value": _number(parameter.value),
        "unit": _unit(parameter.name),
        "standard_uncertainty": _number(parameter.standard_uncertainty),
        "tp_standard_uncertainty": _number(parameter.tp_standard_uncertainty),
        "effective_degrees_of_freedom": _number(parameter.effective_degrees_of_freedom),
        "interval_95": None if parameter.interval_95 is None else [_number(end) for end in parameter.interval_95],
    }


def _primary(axis: AxisCalibration, sensor: str) -> Document:
    names, where = axis.primary_names, f"{sensor}: axis {axis.axis}: primary covariance"
    return {
        "order": list(names),
        "values": {name: float(value) for name, value in zip(names, axis.primary, strict=True)},
        "units": {name: _unit(name) for name in names},
        "covariance": _matrix(axis.primary_covariance, len(names), where),
        "tp_covariance": _matrix(axis.tp_primary_covariance, len(names), where),
        "effective_degrees_of_freedom": dict(zip(names, map(_number, axis.primary_dof), strict=True)),
        "components": {
            component.name: {
                "covariance": _matrix(component.covariance, len(names), f"{where} of {component.name}"),
                "degrees_of_freedom": _number(component.dof),
            }
            for component in axis.variance_components
        },
    }


def _replication(replication: Replication) -> Document:
    return {
        "n": int(replication.replications),
        "points": int(replication.points),
        "lack_of_fit": _f_test(replication.lack_of_fit),
        "drift": {name: _f_test(test) for name, test in replication.drift.items()},
        "tp": _tp(replication.tp),
        "precision_v": _number(replication.precision_v),
        "lack_of_fit_v": _number(replication.lack_of_fit_v),
        "per_replication": {
            str(label): {name: _number(value) for name, value in estimates.items()}
            for label, estimates in replication.per_replication.items()
        },
    }


def _tp(tp: TpReplication) -> Document:
    return {
        "sigma_bias_v": _number(tp.sigma_bias_v),
        "sigma_prec_v": _number(tp.sigma_prec_v),
        "t_bias": _number(tp.t_bias),
        "f_bias_95": _number(tp.f_bias_95),
        "drift": {name: _f_test(test) for name, test in tp.drift.items()},
    }


def _f_test(test: FTest) -> Document:
    return {
        "t": _number(test.t),
        "f_95": _number(test.f_95),
        "p_value": _number(test.p_value),
        "numerator_dof": _number(test.numerator_dof),
        "denominator_dof": _number(test.denominator_dof),
        "is_significant": bool(test.is_significant),
    }


def _matrix(values: FloatArray, size: int, where: str) -> list[Json]:
    if values.shape != (size, size):
        raise SetError(f"{where}: has the wrong shape: got {values.shape}, needed ({size}, {size}); nothing was built")
    if np.isfinite(values).all():
        return [[*row] for row in values.tolist()]
    return [[_number(value) for value in row] for row in values]


def _number(value: float | None) -> float | None:
    """Return the value as a plain float, null where it is not finite."""
    return float(value) if value is not None and np.isfinite(value) else None
