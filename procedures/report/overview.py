"""A row a sensor: what a person reads first where a run has several."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from ams.observations import Observations
from ams.rounding import two_digits
from ams.surveillance.adjustment import Condition
from procedures.numbers import arcsec
from procedures.report.bands import band_along
from procedures.report.view import AxisView, RunView, SensorView

FEWEST = 2
"""Sensors of which a table of rows tells more than their own sections."""
NONE = "—"
LEAST_OF_ALL, MOST_LEFT_OUT = 4, 2
"""Of more sensors than that all but at most two are called so, instead of by name one after the other."""
_SIZE = re.compile(r"(?<![-−±.\d])\d+(?:\.\d+)?″")
"""An angle without a sign: how large something is, and never which one it is."""
_MEASURED = re.compile(r"(?P<sign>[-−+]?)(?P<size>\d+(?:\.\d+)?)″ \(u (?P<u>\d+(?:\.\d+)?)″\)")
"""An angle with its standard uncertainty: what each sensor shows of one turn differs in both."""
_ESTIMATE = re.compile(r"= (?P<sign>[-−]?)(?P<size>\d[\d.e+-]*) ± \S+ (?P<unit>[^\s()]+) \((?P<angle>\d[\d.]*)″\)")
"""What a term was found to be, with its uncertainty and as an angle: each sensor's section has its own."""


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
    failure: str = ""
    """Why there is no result to use, and what to do; empty where there is one."""


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


@dataclass(frozen=True)
class SharedStatement:
    """What is said of several sensors or axes, once."""

    about: str
    """``SN1 x, y; SN2``, or ``all 8 sensors``."""
    text: str
    members: tuple[int, ...]
    """Which of the statements it is made of, from 0."""


def stated_once(statements: Iterable[Statement], everyone: Sequence[str]) -> list[str]:
    """Return each text once, with everybody whom it is about: ``SN1 x, y; SN2: text``, or ``all 8 sensors: text``."""
    return [f"{shared.about}: {shared.text}" for shared in shared_statements(statements, everyone)]


def shared_statements(statements: Iterable[Statement], everyone: Sequence[str]) -> list[SharedStatement]:
    """Return the statements, those that are alike as one, in the order in which each was made first.

    Texts that differ in one size alone, as an angle, are one text with the range of it: ``by 0.22″ to 0.36″``; so are
    those that differ in an estimate of one sign: ``K₃ = 19 to 32 µV/g³ (1.5″ to 2.6″)``, or in one angle of one sign
    and its uncertainty: ``by +71.6″ to +72.5″ (u 0.37″ to 0.41″)``.
    """
    about: dict[str, dict[str, list[str]]] = {}
    texts: dict[str, list[str]] = {}
    members: dict[str, list[int]] = {}
    for index, (sensor, axis, text) in enumerate(statements):
        form = _form(text)
        axes = about.setdefault(form, {}).setdefault(sensor, [])
        if axis and axis not in axes:
            axes.append(axis)
        texts.setdefault(form, []).append(text)
        members.setdefault(form, []).append(index)
    return [
        SharedStatement(_subject(subjects, everyone), _with_range(texts[form]), tuple(members[form]))
        for form, subjects in about.items()
    ]


def _form(text: str) -> str:
    """Return what texts of one kind share."""
    found = _ESTIMATE.search(text)
    if found is None:
        measured = _measured(text)
        if measured is None:
            return _SIZE.sub("{}", text, count=1)
        return _replaced(text, measured, f"{measured['sign']}{{}}")
    return f"{text[: found.start()]}= {found['sign']}{{}} {found['unit']}{text[found.end() :]}"


def _with_range(texts: Sequence[str]) -> str:
    """Return one text for all that are alike but for their first size, or for what a term was found to be."""
    if len(set(texts)) == 1:
        return texts[0]
    estimates = [found for text in texts if (found := _ESTIMATE.search(text))]
    if estimates:
        low, high = (pick(estimates, key=lambda found: float(found["size"])) for pick in (min, max))
        least, most = (pick((found["angle"] for found in estimates), key=float) for pick in (min, max))
        first, sign = estimates[0], estimates[0]["sign"]
        span = f"= {sign}{low['size']} to {sign}{high['size']} {first['unit']} ({least}″ to {most}″)"
        return f"{texts[0][: first.start()]}{span}{texts[0][first.end() :]}"
    if measured := [found for text in texts if (found := _measured(text))]:
        sign = measured[0]["sign"]
        spans = (_span([found[group] for found in measured], before) for group, before in (("size", sign), ("u", "")))
        return _replaced(texts[0], measured[0], "{} (u {})".format(*spans))
    sizes = sorted(
        (found.group() for text in texts if (found := _SIZE.search(text))), key=lambda size: float(size[:-1])
    )
    return _SIZE.sub(f"{sizes[0]} to {sizes[-1]}", texts[0], count=1)


def _measured(text: str) -> re.Match[str] | None:
    """Return the angle that has a standard uncertainty, where no other stands before it."""
    measured, first = _MEASURED.search(text), _SIZE.search(text)
    return measured if measured and first and measured.start() <= first.start() else None


def _replaced(text: str, found: re.Match[str], words: str) -> str:
    return f"{text[: found.start()]}{words}{text[found.end() :]}"


def _span(sizes: Sequence[str], sign: str) -> str:
    """Return one angle, or from the least to the largest."""
    least, most = min(sizes, key=float), max(sizes, key=float)
    return f"{sign}{least}″" if least == most else f"{sign}{least}″ to {sign}{most}″"


def _subject(about: Mapping[str, Sequence[str]], everyone: Sequence[str]) -> str:
    """``about``: sensor to its axes, none of them where it is all of it."""
    if len(everyone) > 1 and list(about) == list(everyone) and len(set(map(tuple, about.values()))) == 1:
        axes = next(iter(about.values()))
        return f"all {len(everyone)} sensors{f', {_listed(axes)}' if axes else ''}"
    others = [sensor for sensor in everyone if sensor not in about]
    if 0 < len(others) <= MOST_LEFT_OUT and len(about) > LEAST_OF_ALL and len(set(map(tuple, about.values()))) == 1:
        axes = next(iter(about.values()))
        return f"{f'{_listed(axes)} of ' if axes else ''}all {len(everyone)} sensors but {_listed(others)}"
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
        failure=sensor.failure or "",
    )


def _condition(condition: Condition | None) -> str:
    if condition is None or condition.largest_error_deg is None:
        return NONE
    error = f"{two_digits(condition.largest_error_deg)}°"
    return f"{error}, {condition.verdict}" if condition.verdict else error


def _widest_arcsec(axis: AxisView, observations: Observations) -> float:
    widest_v = float(band_along(axis.calibration, observations, "pitch").confidence_v.max())
    return arcsec(widest_v, axis.sensitivity_v_per_g)
