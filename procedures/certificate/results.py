"""The results as a certificate states them: no uncertainty below what the laboratory has shown it can do.

The capability (CMC) is an angle. For each coefficient it is the angle's effect: on the offset and the sensitivity
S·capability, on the azimuth capability/sin Ω. Source: ISO/IEC 17025:2017, 7.8.4.1; ILAC-P14:09/2020, 5.4.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import hypot, radians, sin

import numpy as np

from ams.parameter_words import words_of
from ams.rounding import last_place, to_place, with_uncertainty
from ams.sets.canonical import Document, number, table
from ams.sets.coefficients import CoefficientSet
from ams.statistics.intervals import t_quantile
from ams.surveillance.attitude_errors import AngleErrors
from procedures.numbers import angle

COVERAGE = 0.95


@dataclass(frozen=True)
class Coefficient:
    """One coefficient as printed."""

    axis: str
    label: str
    symbol: str
    unit: str
    value: str
    expanded: str
    factor: str
    is_capability: bool
    """The uncertainty stated is the laboratory's capability, not the smaller one calculated."""


@dataclass(frozen=True)
class AngleRow:
    """The error of an inferred angle at one attitude, degrees as printed."""

    angle: str
    pitch: str
    roll: str
    error: str
    expanded: str


def coefficients_of(coefficients: CoefficientSet, capability_deg: float | None) -> Iterator[Coefficient]:
    """Yield every coefficient that has a value, with its expanded uncertainty."""
    for axis, section in table(coefficients.document["axes"]).items():
        rows = table(section)["parameters"]
        # Null or missing for a sensor of another unit.
        values = list(table(table(section).get("sensitive_axis_v_per_g", {})).values())
        size = None if None in values or not values else hypot(*map(number, values))
        for name, stated in table(rows).items():
            row = table(stated)
            if row["value"] is not None and row["standard_uncertainty"] is not None:
                yield _coefficient(axis, name, row, _floor(name, table(rows), size, capability_deg))


def undetermined(coefficients: CoefficientSet) -> Iterator[str]:
    """``x: azimuth`` for every coefficient that the data do not determine."""
    for axis, section in table(coefficients.document["axes"]).items():
        for name, stated in table(table(section)["parameters"]).items():
            if table(stated)["value"] is None:
                yield f"{axis}: {words_of(name).label}"


def angle_rows(errors: Mapping[str, AngleErrors], capability_deg: float | None) -> Iterator[AngleRow]:
    """Errors along both axes of the plane of attitudes: pitch varied near roll 0, roll varied near pitch 0."""
    for name, found in errors.items():
        for pair in _cross(found):
            expanded = max(float(found.expanded_deg[pair]), capability_deg or 0.0)
            digits = last_place(expanded)
            yield AngleRow(
                name,
                angle(float(found.pitch_deg[pair])),
                angle(float(found.roll_deg[pair])),
                to_place(float(found.error_deg[pair]), digits).replace("-", "−"),
                to_place(expanded, digits),
            )


def _cross(found: AngleErrors) -> list[int]:
    """Places of the points on the two lines through the point nearest to level, in the order of the angles."""
    pitch, roll = np.round(found.pitch_deg, 6), np.round(found.roll_deg, 6)
    level = int(np.argmin(np.hypot(pitch, roll)))
    along_pitch = np.flatnonzero(roll == roll[level])
    along_roll = np.flatnonzero((pitch == pitch[level]) & (roll != roll[level]))
    return [*along_pitch[np.argsort(pitch[along_pitch])], *along_roll[np.argsort(roll[along_roll])]]


def _coefficient(axis: str, name: str, row: Document, floor: float) -> Coefficient:
    label, symbol, unit = words_of(name)
    uncertainty, dof = number(row["standard_uncertainty"]), row.get("effective_degrees_of_freedom")
    factor = float(t_quantile(COVERAGE, number(dof) if dof is not None else np.inf))
    expanded = factor * uncertainty
    stated = max(expanded, floor)
    value, printed = with_uncertainty(number(row["value"]), stated)
    return Coefficient(axis, label, symbol, unit, value.replace("-", "−"), printed, f"{factor:.2f}", stated > expanded)


def _floor(name: str, rows: Document, size: float | None, capability_deg: float | None) -> float:
    """Return the capability as an uncertainty of this coefficient; 0 where it says nothing about it.

    An angle that a laboratory can tell by gravity says nothing about a sensor of rates.
    """
    if not capability_deg or size is None:
        return 0.0
    if name in ("offset_v", "sensitivity_v_per_g"):
        return size * radians(capability_deg)
    if name == "azimuth_deg":
        coning = table(rows["coning_deg"])["value"]
        tilt = sin(radians(number(coning))) if coning is not None else 0.0
        return capability_deg / tilt if tilt > 0.0 else 0.0
    return capability_deg if name in ("coning_deg", "pitch_misalignment_deg") else 0.0
