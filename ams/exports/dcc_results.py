"""The measurement ring of a DCC: method, equipment, conditions, coefficients, covariances, test vectors."""

import json
import math

import numpy as np

from ams.exports.csv_text import unit_below
from ams.exports.dcc_administration import software
from ams.exports.dcc_elements import (
    D_SI,
    Element,
    Elements,
    content,
    expanded,
    identification,
    interval,
    numbers,
    product,
    quantity,
    real,
)
from ams.exports.plain_values import columns, numeric
from ams.sets.canonical import Document, Json, listed, number, table
from ams.sets.capability import COVERAGE_FACTOR, capability_deg_of, smallest_expanded
from ams.sets.coefficients import CoefficientSet
from ams.sets.equipment import Equipment, equipment_of
from ams.sets.provenance import NO_GRAVITY_STATED
from ams.sets.vectors import outputs_key
from ams.statistics.distributions import student_t_quantile
from ams.statistics.intervals import degrees_of_freedom

COVERAGE_QUANTILE = 0.975


def measurement_result(coefficients: CoefficientSet, attachment: Element) -> Element:
    """Return the one measurement of a set."""
    axes = table(coefficients.document["axes"])
    attached = Element("dcc:data", [attachment])
    capability_deg = capability_deg_of(coefficients)
    results = [
        *(_axis(name, table(section), capability_deg) for name, section in axes.items()),
        _test_vectors(coefficients),
        Element("dcc:result", [content("dcc:name", "the coefficient set, whole"), attached]),
    ]
    equipments = [_equipment(row) for row in equipment_of(coefficients)]
    return Element(
        "dcc:measurementResult",
        [
            content("dcc:name", f"calibration of {coefficients.sensor}"),
            Element("dcc:usedMethods", [_method(coefficients)]),
            Element("dcc:usedSoftware", [software(coefficients)]),
            *([Element("dcc:measuringEquipments", equipments)] if equipments else []),
            Element("dcc:influenceConditions", _conditions(coefficients)),
            Element("dcc:results", results),
        ],
    )


def _method(coefficients: CoefficientSet) -> Element:
    convention = table(coefficients.document["convention"])
    described = content("dcc:description", f"convention {convention['name']}: {convention['text']}")
    name = content("dcc:name", f"{coefficients.model}: {coefficients.provenance['procedure']}")
    return Element("dcc:usedMethod", [name, described])


def _equipment(row: Equipment) -> Element:
    said = [f"used for: {row.used_for}"] if row.used_for else []
    said += [f"{key}: {value}" for key, value in (("certificate", row.certificate), ("due", row.due)) if value]
    said += [f"uncertainty: {json.dumps(row.uncertainty)}"] if row.uncertainty else []
    said += [] if row.certificate else ["no certificate of its uncertainty is declared"]
    described = [content("dcc:description", *said)] if said else []
    known = [identification("manufacturer", row.serial, "serial number")] if row.serial else []
    identifications = [Element("dcc:identifications", known)] if known else []
    return Element("dcc:measuringEquipment", [content("dcc:name", row.name), *described, *identifications])


def _conditions(coefficients: CoefficientSet) -> Elements:
    gravity = coefficients.gravity
    conditions = []
    if gravity.source != NO_GRAVITY_STATED:
        known = gravity.standard_uncertainty_mps2
        u = _expanded(known, None) if known else None
        conditions.append(_condition("local acceleration of gravity", "gravity_mps2", gravity.value_mps2, known=u))
    provenance = coefficients.provenance
    humidity = listed(table(provenance["job"] or {}).get("relative_humidity_percent") or [])
    for end, percent in zip(("lowest", "highest"), humidity, strict=False):
        named = f"{end} relative humidity"
        given = quantity(named, real(number(percent), "%"), f"condition.site.{end}_relative_humidity")
        data = Element("dcc:data", [given])
        conditions.append(Element("dcc:influenceCondition", [content("dcc:name", named), data]))
    supplies = {f"supply {channel}": volts for channel, volts in table(provenance.get("supplies") or {}).items()}
    for name, measured in {**table(coefficients.document["environment"]), **supplies}.items():
        for key, value in (measured if isinstance(measured, dict) else {}).items():
            if isinstance(value, int | float) and not isinstance(value, bool):
                conditions.append(_condition(f"{name}: {key}", key, float(value), name))
    return conditions


def _condition(name: str, key: str, value: float, location: str = "site", *, known: Elements | None = None) -> Element:
    """``known``: how far the value may be wrong; None where nobody declared it."""
    given = quantity(name, real(value, unit_below({}, key, ""), known), f"condition.{location}.{key}")
    return Element("dcc:influenceCondition", [content("dcc:name", name), Element("dcc:data", [given])])


def _axis(name: str, section: Document, capability_deg: float | None) -> Element:
    equation, primary = table(section["equation"]), table(section["primary"])
    printed = content("dcc:text", f"primary: {equation['primary']}", f"derived: {equation['derived']}")
    data = [
        printed,
        *(_primary(name, section, index, capability_deg) for index in range(len(listed(primary["order"])))),
        *(
            _derived(name, key, table(entry), smallest_expanded(key, section, capability_deg))
            for key, entry in table(section["parameters"]).items()
        ),
        *_covariance(name, "covariance", primary["covariance"], primary),
    ]
    for component, part in table(primary["components"]).items():
        data += _covariance(name, f"covariance, part: {component}", table(part)["covariance"], primary)
    described = content("dcc:description", f"equation {equation['name']}, {equation['source']}")
    return Element("dcc:result", [content("dcc:name", f"axis {name}"), described, Element("dcc:data", data)])


def _primary(axis: str, section: Document, index: int, capability_deg: float | None) -> Element:
    primary = table(section["primary"])
    name = str(listed(primary["order"])[index])
    variance = listed(listed(primary["covariance"])[index])[index]
    dof = table(primary["effective_degrees_of_freedom"])[name]
    value, unit = number(table(primary["values"])[name]), str(table(primary["units"])[name])
    smallest = smallest_expanded(name, section, capability_deg)
    known = None if variance is None else _expanded(math.sqrt(number(variance)), dof, smallest)
    dof_known = math.inf if dof is None else number(dof)
    about = f"primary parameter of axis {axis}; effective degrees of freedom {degrees_of_freedom(dof_known)}"
    return quantity(name, real(value, unit, known), f"{axis}.primary.{name}", about)


def _expanded(standard_uncertainty: float, dof: Json, smallest: float = 0.0) -> Elements:
    """``smallest``: the laboratory's capability, which is stated where the expanded uncertainty is below it."""
    factor = float(student_t_quantile(COVERAGE_QUANTILE, math.inf if dof is None else number(dof)))
    if factor * standard_uncertainty < smallest:
        return expanded(smallest, COVERAGE_FACTOR)
    return expanded(factor * standard_uncertainty, factor)


def _derived(axis: str, name: str, parameter: Document, smallest: float) -> Element:
    identifier, unit = f"{axis}.parameters.{name}", str(parameter["unit"])
    about = f"derived parameter of axis {axis}"
    ends, uncertainty = listed(parameter["interval_95"]), parameter["standard_uncertainty"]
    if parameter["value"] is None:
        undetermined = content("dcc:noQuantity", "not determined: see the warnings")
        return quantity(name, undetermined, identifier, about)
    known = None
    if uncertainty is not None and len(ends) == 2 and None not in ends:
        value, low, high = number(parameter["value"]), number(ends[0]), number(ends[1])
        known = interval(number(uncertainty), low, high)
        if min(value - low, high - value) < smallest:
            stated = max(number(uncertainty), smallest / COVERAGE_FACTOR)
            known = interval(stated, min(low, value - smallest), max(high, value + smallest))
    return quantity(name, real(number(parameter["value"]), unit, known), identifier, about)


def _covariance(axis: str, title: str, matrix: Json, primary: Document) -> Elements:
    """Return the matrix as one quantity a row; none where an entry is not known."""
    rows = numeric(listed(matrix))
    order = [str(name) for name in listed(primary["order"])]
    if rows is None or not np.isfinite(rows).all():
        return []
    units = [D_SI[str(table(primary["units"])[name])] for name in order]
    return [
        quantity(
            f"{title}: row {name}",
            numbers(row.tolist(), [product(unit, other) for other in units]),
            f"{axis}.{title}.{name}",
            f"in the order {', '.join(order)}",
        )
        for name, unit, row in zip(order, units, rows, strict=True)
    ]


def _test_vectors(coefficients: CoefficientSet) -> Element:
    section = coefficients.test_vectors
    found = columns(section["forward"]) or {}
    key = outputs_key(coefficients.axes)
    outputs = found.pop(key)
    data = [content("dcc:text", "inputs and expected outputs", section["tolerance_text"])]
    data += [_column(name, values.tolist(), unit_below({}, name, "")) for name, values in found.items()]
    data += [_column(f"output of {axis}", values.tolist(), unit_below({}, key, "")) for axis, values in outputs.items()]
    return Element("dcc:result", [content("dcc:name", "test vectors"), Element("dcc:data", data)])


def _column(name: str, values: list[float], unit: str) -> Element:
    return quantity(name, numbers(values, [D_SI[unit]] * len(values)), f"vectors.{name}")
