"""A row a sensor: what a person reads first where a run has several."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from ams.observations import Observations
from ams.surveillance.adjustment import Condition
from procedures.numbers import arcsec, two_digits
from procedures.report.bands import band_along
from procedures.report.view import AxisView, RunView, SensorView

FEWEST = 2
"""Sensors of which a table of rows tells more than their own sections."""
NONE = "—"
_SIZE = re.compile(r"(?<![-−±.\d])\d+(?:\.\d+)?″")
"""An angle without a sign: how large something is, and never which one it is."""


@dataclass(frozen=True)
class OverviewRow:
    """One sensor in five words."""

    sensor: str
    anchor: str
    verdict: str
    """``sound``, ``usable`` or ``not usable``."""
    angle: str
    """The widest 95 % band of the fitted output over the attitudes measured, as an angle."""
    as_found: str
    as_left: str
    findings: str


def has_overview(view: RunView) -> bool:
    return len(view.sensors) >= FEWEST


def overview_rows(view: RunView) -> list[OverviewRow]:
    """Return the rows in the order of the sensors."""
    return [_row(sensor) for sensor in view.sensors]


def widest_arcsec(sensor: SensorView) -> float | None:
    """Return the widest 95 % band of the fitted output of any axis, as an angle; None where nothing was solved."""
    observations = sensor.observations
    if observations is None or not sensor.axes:
        return None
    return max(_widest_arcsec(axis, observations) for axis in sensor.axes)


Statement = tuple[str, str, str]
"""Sensor, axis (empty for all of it), and what is said of it."""


def stated_once(statements: Iterable[Statement], everyone: Sequence[str]) -> list[str]:
    """Return each text once, with everybody whom it is about: ``SN1 x, y; SN2: text``, or ``all 8 sensors: text``.

    Texts that differ in one size alone, as an angle, are one text with the range of it: ``by 0.22″ to 0.36″``.
    """
    about: dict[str, dict[str, list[str]]] = {}
    texts: dict[str, list[str]] = {}
    for sensor, axis, text in statements:
        form = _SIZE.sub("{}", text, count=1)
        axes = about.setdefault(form, {}).setdefault(sensor, [])
        if axis and axis not in axes:
            axes.append(axis)
        texts.setdefault(form, []).append(text)
    return [f"{_subject(subjects, everyone)}: {_with_range(texts[form])}" for form, subjects in about.items()]


def _with_range(texts: Sequence[str]) -> str:
    """Return one text for all that are alike but for their first size."""
    if len(set(texts)) == 1:
        return texts[0]
    sizes = sorted(
        (found.group() for text in texts if (found := _SIZE.search(text))), key=lambda size: float(size[:-1])
    )
    return _SIZE.sub(f"{sizes[0]} to {sizes[-1]}", texts[0], count=1)


def _subject(about: Mapping[str, Sequence[str]], everyone: Sequence[str]) -> str:
    """``about``: sensor to its axes, none of them where it is all of it."""
    if len(everyone) > 1 and list(about) == list(everyone) and len(set(map(tuple, about.values()))) == 1:
        axes = next(iter(about.values()))
        return f"all {len(everyone)} sensors{f', {_listed(axes)}' if axes else ''}"
    return "; ".join(f"{sensor} {_listed(axes)}".rstrip() for sensor, axes in about.items())


def _listed(axes: Sequence[str]) -> str:
    return ", ".join(axes)


def _row(sensor: SensorView) -> OverviewRow:
    widest = widest_arcsec(sensor)
    adjustment = sensor.adjustment
    found = (finding for axis in sensor.findings for finding in axis.findings)
    significant = dict.fromkeys(finding.kind.replace("-", " ") for finding in found if finding.is_significant)
    return OverviewRow(
        sensor=sensor.name,
        anchor=f"sensor-{sensor.slug}",
        verdict=sensor.verdict,
        angle=NONE if widest is None else f"±{two_digits(widest)}″",
        as_found=NONE if adjustment is None else _condition(adjustment.as_found),
        as_left=NONE if adjustment is None else _condition(adjustment.as_left),
        findings=", ".join(significant) or "none",
    )


def _condition(condition: Condition | None) -> str:
    if condition is None or condition.largest_error_deg is None:
        return NONE
    error = f"{two_digits(condition.largest_error_deg)}°"
    return f"{error}, {condition.verdict}" if condition.verdict else error


def _widest_arcsec(axis: AxisView, observations: Observations) -> float:
    widest_v = float(band_along(axis.calibration, observations, "pitch").confidence_v.max())
    return arcsec(widest_v, axis.sensitivity_v_per_g)
