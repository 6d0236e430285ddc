"""The results as a certificate states them: no uncertainty below what the laboratory has shown it can do.

Source: ISO/IEC 17025:2017, 7.8.4.1; ILAC-P14:09/2020, 5.4.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import hypot

import numpy as np

from ams.parameter_words import words_of
from ams.rounding import last_place, to_place, with_uncertainty
from ams.sets.canonical import Document, number, table
from ams.sets.capability import COVERAGE_FACTOR, smallest_expanded
from ams.sets.coefficients import CoefficientSet
from ams.statistics.intervals import t_quantile
from ams.surveillance.adjustment import Judgement
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
    factor: str
    is_capability: bool
    """The uncertainty stated is the laboratory's capability, not the smaller one calculated."""


def coefficients_of(coefficients: CoefficientSet, capability_deg: float | None) -> Iterator[Coefficient]:
    """Yield every coefficient that has a value, with its expanded uncertainty."""
    for axis, section in table(coefficients.document["axes"]).items():
        for name, stated in table(table(section)["parameters"]).items():
            row = table(stated)
            if row["value"] is not None and row["standard_uncertainty"] is not None:
                yield _coefficient(axis, name, row, smallest_expanded(name, table(section), capability_deg))


def undetermined(coefficients: CoefficientSet) -> Iterator[str]:
    """``x: azimuth`` for every coefficient that the data do not determine."""
    for axis, section in table(coefficients.document["axes"]).items():
        for name, stated in table(table(section)["parameters"]).items():
            if table(stated)["value"] is None:
                yield f"{axis}: {words_of(name).label}"


def angle_rows(
    errors: Mapping[str, AngleErrors], judgements: Sequence[Judgement], capability_deg: float | None
) -> Iterator[AngleRow]:
    """Yield errors along both axes of the plane of attitudes: pitch varied near roll 0, roll varied near pitch 0.

    Beside them where the error is largest, where error and uncertainty are largest together, and what every judgement
    was decided by. An attitude has one row: of several visits the one that decided, else the one that is farthest out;
    the largest error has its row whatever decided.
    """
    for name, found in errors.items():
        decided = [_decided(found, judgement) for judgement in judgements if judgement.angle == name]
        for row in _shown(found, [row for row in decided if row is not None]):
            calculated = float(found.expanded_deg[row])
            expanded = max(calculated, capability_deg or 0.0)
            is_capability = expanded > calculated
            factor = COVERAGE_FACTOR if is_capability else float(found.coverage_factor[row])
            digits = last_place(expanded)
            yield AngleRow(
                name,
                angle(float(found.pitch_deg[row])),
                angle(float(found.roll_deg[row])),
                to_place(float(found.error_deg[row]), digits).replace("-", "−"),
                to_place(expanded, digits),
                f"{factor:.2f}",
                is_capability,
            )


def is_visited_again(errors: Mapping[str, AngleErrors]) -> bool:
    """Return whether any attitude has several points, as in the order forward-reverse."""
    return any(len(set(_attitudes(found))) < found.error_deg.size for found in errors.values())


def _decided(found: AngleErrors, judgement: Judgement) -> int | None:
    """Return the index of the point that a judgement names; None where it names none."""
    named = (judgement.pitch_deg, judgement.roll_deg, judgement.error_deg)
    columns = (found.pitch_deg, found.roll_deg, found.error_deg)
    is_it = np.logical_and.reduce([column == value for column, value in zip(columns, named, strict=True)])
    return int(np.argmax(is_it)) if is_it.any() else None


def _shown(found: AngleErrors, decided: Sequence[int]) -> list[int]:
    """Return the places of the rows: the cross through level in the order of the angles, then what decides."""
    attitudes = _attitudes(found)
    farthest: dict[tuple[float, float], int] = {}
    for row in np.argsort(np.abs(found.error_deg) + found.expanded_deg).tolist():
        farthest[attitudes[row]] = row
    farthest |= {attitudes[row]: row for row in reversed(decided)}
    wanted = [*_cross(found), *(attitudes[row] for row in (found.largest, found.worst, *decided))]
    return list(dict.fromkeys([*(farthest[attitude] for attitude in dict.fromkeys(wanted)), found.largest]))


def _attitudes(found: AngleErrors) -> list[tuple[float, float]]:
    rounded = zip(np.round(found.pitch_deg, 6).tolist(), np.round(found.roll_deg, 6).tolist(), strict=True)
    return [(pitch, roll) for pitch, roll in rounded]


def _cross(found: AngleErrors) -> list[tuple[float, float]]:
    """Attitudes on the two lines through the one nearest to level, in the order of the angles."""
    attitudes = set(_attitudes(found))
    level = min(attitudes, key=lambda attitude: (hypot(*attitude), attitude))
    along_pitch = sorted(attitude for attitude in attitudes if attitude[1] == level[1])
    along_roll = sorted(attitude for attitude in attitudes if attitude[0] == level[0])
    return [*along_pitch, *along_roll]


def _coefficient(axis: str, name: str, row: Document, floor: float) -> Coefficient:
    label, symbol, unit = words_of(name)
    uncertainty, dof = number(row["standard_uncertainty"]), row.get("effective_degrees_of_freedom")
    factor = float(t_quantile(COVERAGE, number(dof) if dof is not None else np.inf))
    expanded = factor * uncertainty
    stated = max(expanded, floor)
    value, printed = with_uncertainty(number(row["value"]), stated)
    is_capability = stated > expanded
    printed_factor = f"{COVERAGE_FACTOR if is_capability else factor:.2f}"
    return Coefficient(axis, label, symbol, unit, value.replace("-", "−"), printed, printed_factor, is_capability)
