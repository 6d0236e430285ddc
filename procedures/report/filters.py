"""Cells of the page: every value as the text that stands in a table. The templates call these as filters."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any, Final, Protocol
from urllib.parse import quote

import numpy as np
from markupsafe import Markup, escape

from ams.models.rate_terms import LOW_ORDER_NAMES
from ams.parameter_words import words_of
from ams.rounding import last_place, to_place, two_digits, with_uncertainty
from ams.statistics.intervals import degrees_of_freedom
from ams.surveillance.attitude_errors import AngleErrors
from ams.surveillance.level_errors import LevelErrors
from ams.units import printed as printed_unit
from procedures.journal.audit.audit_trail import Interruption
from procedures.numbers import angle, arcsec, attitude, duration, p_value, three_digits
from procedures.report.canvas import Figure
from procedures.report.figures import are_left_out
from procedures.report.findings_in_short import significant_findings, test_name, tests_in_short
from procedures.report.overview import overview_rows
from procedures.report.view import AxisView, ParameterRow, RunView, SensorView
from procedures.solution.budget_view import BudgetView

_INDEXED: Final = re.compile(r"(?<=(?<![A-Za-z_])[A-Za-z])_([a-z0-9]{1,3})(?![A-Za-z0-9_])")
MOST_PARAMETERS: Final = 7
NO_CHANCE: Final = 3.0
"""Expanded uncertainties from the truth: with five degrees of freedom once in seventeen hundred rows."""
"""Columns of a budget beside its sources: with the coefficients of temperature the last stood outside the page."""

URI_SAFE = " !$'()*+,-./:;<=>?@_{}~"
"""What a data URI inside an attribute may hold as it is."""


class _HasSensitivity(Protocol):
    @property
    def sensitivity_v_per_g(self) -> float: ...


def grouped(text: str) -> Markup:
    """Return the decimals in groups of three, set apart by space that is not copied with the number."""
    whole, point, decimals = text.partition(".")
    groups = [decimals[start : start + 3] for start in range(0, len(decimals), 3)]
    if not decimals.isdigit() or len(decimals) <= 4:
        return escape(_minus(text))
    tail = Markup("").join(Markup('<span class="g">{}</span>').format(group) for group in groups[1:])
    return Markup("{}{}{}{}").format(_minus(whole), point, groups[0], tail)


def value_text(row: ParameterRow) -> Markup:
    assert row.value is not None
    return grouped(with_uncertainty(row.value, row.standard_uncertainty)[0])


def uncertainty_text(row: ParameterRow) -> Markup:
    return grouped(with_uncertainty(0.0, row.standard_uncertainty)[1])


def expanded_text(row: ParameterRow) -> Markup:
    return grouped(with_uncertainty(0.0, row.expanded_uncertainty)[1])


def truth_text(row: ParameterRow) -> Markup:
    """Return the truth with one digit more than the estimate."""
    if row.truth is None:
        return grouped("—")
    u = row.standard_uncertainty
    return grouped(to_place(row.truth, last_place(u)) if u is not None and u > 0.0 else f"{row.truth:.9g}")


def holds_truth(row: ParameterRow) -> str:
    return {True: "yes", False: "no", None: "—"}[row.holds_truth]


def truths_missed(sensor: SensorView) -> str:
    """Say it where intervals miss the twin's truth by more than chance does; else empty."""
    rows = [row for axis in sensor.axes for row in axis.parameters if row.holds_truth is not None]
    worst = max(rows, key=lambda row: row.misses_truth_by, default=None)
    if worst is None or worst.misses_truth_by <= NO_CHANCE:
        return ""
    missed = sum(row.holds_truth is False for row in rows)
    return (
        f"{missed} of {len(rows)} 95 % intervals {'misses' if missed == 1 else 'miss'} the truth, the {worst.label} by "
        f"{worst.misses_truth_by:.2g} expanded uncertainties: that is not chance. What did it is in no uncertainty of "
        "this run; with a real sensor, whose truth nobody knows, nothing else would say so."
    )


def factor_text(factor: float | None) -> str:
    return "—" if factor is None else f"{factor:.2f}"


def as_arcsec(voltage_v: float, owner: _HasSensitivity) -> str:
    return f"{_minus(two_digits(arcsec(voltage_v, owner.sensitivity_v_per_g)))}″"


def microvolt(voltage_v: float) -> str:
    return f"{two_digits(voltage_v * 1e6)} µV"


def primary_label(name: str) -> str:
    return "b" if name == "offset_v" else words_of(name).label


def primary_linear(axis: AxisView) -> list[str]:
    """Return the names of the primary parameters without the terms of higher order, which stand among the others."""
    return [name for name in axis.calibration.primary_names if name not in LOW_ORDER_NAMES]


def primary_texts(axis: AxisView) -> list[Markup]:
    """Return those estimates as value(uncertainty in the last two digits)."""
    deviations = np.sqrt(np.maximum(np.diag(axis.calibration.primary_covariance), 0.0))
    rows = zip(axis.calibration.primary_names, axis.calibration.primary, deviations, strict=True)
    return [_concise(float(value), float(deviation)) for name, value, deviation in rows if name not in LOW_ORDER_NAMES]


def remarks_once(axes: Sequence[AxisView]) -> list[tuple[str, str]]:
    """Return each remark once, with the axes that it is of where they are not all of several."""
    found: dict[str, list[str]] = {}
    for axis in axes:
        for remark in axis.remarks:
            found.setdefault(remark, []).append(axis.axis)
    return [(text, "" if len(names) == len(axes) > 1 else ", ".join(names)) for text, names in found.items()]


def shared_remarks(view: RunView) -> list[str]:
    """Return what is remarked of every solved sensor of several, by it or by each of its axes: it is said once.

    Of a sensor alone it is what the verdict says already.
    """
    solved = [sensor for sensor in view.sensors if sensor.axes]
    if not solved:
        return []
    said = [
        [
            *sensor.warnings,
            *sensor.remarks,
            *(text for text, _ in remarks_once(sensor.axes)),
            *(text for axis in sensor.axes for text in axis.calibration.warnings),
        ]
        for sensor in solved
    ]
    shared = [text for text in dict.fromkeys(said[0]) if all(text in others for others in said[1:])]
    return shared if len(view.sensors) > 1 else [text for text in shared if not not_among_the_grounds(view, [text])]


def not_among_the_grounds(view: RunView, texts: Sequence[str]) -> list[str]:
    """Return those texts that the verdict does not say already."""
    return [text for text in texts if not any(ground.endswith(text) for ground in view.verdict.grounds)]


def as_stated(axes: Sequence[AxisView]) -> list[tuple[str, str, str]]:
    """Return source and what states it, said once for all axes; the axes where they are not all."""
    found: dict[tuple[str, str], list[str]] = {}
    for axis in axes:
        for row in () if axis.budget is None else axis.budget.rows:
            if row.stated:
                found.setdefault((row.source, row.stated), []).append(axis.axis)
    everywhere = [axis.axis for axis in axes if axis.budget is not None]
    return [(*key, "" if names == everywhere else ", ".join(names)) for key, names in found.items()]


def in_parts(budget: BudgetView) -> Iterator[BudgetView]:
    """Yield a budget in tables of so many parameters as a page has room for, all of about the same width."""
    count = len(budget.headings)
    tables = max(-(-count // MOST_PARAMETERS), 1)
    for index in range(tables):
        columns = slice(index * count // tables, (index + 1) * count // tables)
        rows = tuple(replace(row, cells=row.cells[columns]) for row in budget.rows)
        yield BudgetView(budget.headings[columns], rows)


def _concise(value: float, uncertainty: float) -> Markup:
    printed, deviation = with_uncertainty(value, uncertainty)
    digits = deviation.replace(".", "").lstrip("0")
    return grouped(printed) + (f"({digits})" if digits.isdigit() else "")


def utc_text(moment: datetime) -> str:
    return moment.astimezone(UTC).strftime("%Y-%m-%d %H:%M:%S")


def lasted(interruption: Interruption) -> str:
    if interruption.ended_utc is None:
        return "—"
    return duration((interruption.ended_utc - interruption.began_utc).total_seconds())


def run_duration(view: RunView) -> str:
    """Return how long the run took from its beginning, with soaks, holds and trips."""
    if view.ended_utc is None:
        return "—"
    return duration((view.ended_utc - view.began_utc).total_seconds())


def data_uri(figure: Figure) -> Markup:
    """Return the picture for an attribute in double quotes, percent-encoded.

    A picture inside the figure is base64 already and need not be so twice; a quotation mark escaped for HTML as well
    would make the page a quarter longer. What is left of ``quote`` cannot end such an attribute.
    """
    svg = figure.svg.replace(b"\n", b" ").replace(b'"', b"'")
    return Markup("data:image/svg+xml," + quote(svg, safe=URI_SAFE))  # noqa: S704


def largest_error(errors: AngleErrors) -> str:
    """Return the largest error, degrees, to the place of its uncertainty."""
    at = errors.largest
    return f"{_minus(with_uncertainty(float(errors.error_deg[at]), float(errors.expanded_deg[at]))[0])}°"


def largest_expanded(errors: AngleErrors) -> str:
    return f"{two_digits(float(errors.expanded_deg[errors.largest]))}°"


def largest_budget(errors: AngleErrors) -> str:
    """Return the parts of the standard uncertainty of the largest error; empty where its store has none."""
    at = errors.largest
    return ", ".join(f"{name} {two_digits(float(part[at]))}°" for name, part in errors.parts_deg.items())


def largest_at(errors: AngleErrors) -> str:
    return attitude({"pitch": float(errors.pitch_deg[errors.largest]), "roll": float(errors.roll_deg[errors.largest])})


def largest_level_error(errors: LevelErrors) -> str:
    """Return the error in the unit of what is sensed, to the place of its uncertainty."""
    worst = errors.worst
    value, _ = with_uncertainty(float(errors.error[worst]), float(errors.expanded[worst]))
    return f"{_minus(value)} {printed_unit(errors.unit)}"


def largest_level_expanded(errors: LevelErrors) -> str:
    return f"{two_digits(float(errors.expanded[errors.worst]))} {printed_unit(errors.unit)}"


def largest_level_at(errors: LevelErrors) -> str:
    return f"{_minus(f'{errors.level[errors.worst]:.4g}')} {printed_unit(errors.unit)}"


def with_indices(text: str) -> Markup:
    """Return a symbol or an equation with the indices that plain text has after a low line set below: q_xx, f_y²."""
    pieces = _INDEXED.split(text)
    return Markup("").join(
        escape(piece) if index % 2 == 0 else Markup("<sub>{}</sub>").format(piece) for index, piece in enumerate(pieces)
    )


def _minus(text: str) -> str:
    return text.replace("-", "−", 1) if text.startswith("-") else text


FILTERS: Mapping[str, Callable[..., Any]] = {
    "value_text": value_text,
    "uncertainty_text": uncertainty_text,
    "expanded_text": expanded_text,
    "truth_text": truth_text,
    "holds_truth": holds_truth,
    "truths_missed": truths_missed,
    "dof": degrees_of_freedom,
    "factor": factor_text,
    "as_arcsec": as_arcsec,
    "microvolt": microvolt,
    "primary_label": primary_label,
    "primary_linear": primary_linear,
    "as_stated": as_stated,
    "in_parts": in_parts,
    "remarks_once": remarks_once,
    "primary_texts": primary_texts,
    "utc": utc_text,
    "lasted": lasted,
    "run_duration": run_duration,
    "data_uri": data_uri,
    "attitude": attitude,
    "degrees": angle,
    "indices": with_indices,
    "overview_rows": overview_rows,
    "significant_findings": significant_findings,
    "tests_in_short": tests_in_short,
    "test_name": test_name,
    "are_figures_left_out": are_left_out,
    "shared_remarks": shared_remarks,
    "not_among_the_grounds": not_among_the_grounds,
    "largest_error": largest_error,
    "largest_expanded": largest_expanded,
    "largest_at": largest_at,
    "largest_budget": largest_budget,
    "largest_level_error": largest_level_error,
    "largest_level_expanded": largest_level_expanded,
    "largest_level_at": largest_level_at,
    "grouped": grouped,
    "three": three_digits,
    "p": p_value,
}
