"""What a change in mid-run is told as: the diagnosis of two visits, of the dwells in it and of those outside."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import SLIP, STEP
from ams.analysis.diagnostics.steps.step_scan import Change
from ams.arrays import BoolArray, FloatArray
from ams.calibration.steps import step_words
from ams.calibration.steps.step_search import NOTHING, StepSearch
from ams.findings import Finding
from ams.solve.extension import angles_of_points
from ams.surveillance.common_mode import judge_visits
from ams.surveillance.common_mode_columns import Visits, WatchedAxes
from ams.surveillance.common_mode_words import findings_of
from ams.surveillance.turns import FIXTURE

_CONTRADICTED: Final = 0.01
"""The chance below which a cause does not explain what changed."""
_PACKAGE: Final = "the package"
_METER: Final = "the meter"
_OF_A_LONE_AXIS: Final = "an axis that turned inside its sensor would look the same, as one axis alone shows it"


def findings_of_change(
    search: StepSearch, change: Change, *, is_shared: bool = False
) -> Iterator[tuple[Finding, int | None]]:
    """Yield what the diagnosis of two visits makes of the rows in a change and outside.

    ``is_shared``: whether all sensors are known to have turned with the table.
    """
    course, rows = search.course, search.evidence.rows
    between, steps = step_words.when(change, course, rows), step_words.doubted_steps(change, course, rows)
    doubt = step_words.doubt(change, course, rows)
    findings = (
        _diagnosed(search, change, between, steps, is_shared=is_shared)
        if change.output in (None, *search.on_table)
        else ()
    )
    findings = findings or (_undiagnosed(change, between, steps),)
    for finding in findings:
        is_of_sensor = finding.kind == "sensor-change" and change.output is not None and len(findings) == 1
        details = {**finding.details, "test": SLIP if change.is_of_table else STEP}
        yield (
            replace(
                finding.adding(*doubt),
                p_value=min(1.0, search.chance(change)),
                details=details,
                is_held=False,
            ),
            change.output if is_of_sensor else None,
        )


def _diagnosed(
    search: StepSearch, change: Change, between: str, steps: tuple[int, ...], *, is_shared: bool
) -> tuple[Finding, ...]:
    evidence, layout = search.evidence, search.evidence.layout
    inside = search.course.during(change)
    variances = [search.without(change).watched[index].variance for index in search.on_table]
    pitch, roll = angles_of_points(evidence.rows, layout)
    yaw = None if search.course.yaw_rad is None else layout.mean_by_point(search.course.yaw_rad)
    axes = [search.seen[index][0].models[search.seen[index][1]].nominal_axis for index in search.on_table]
    size = len(axes)
    watched = WatchedAxes(
        (_PACKAGE,) * size, tuple(axes), (_METER,) * size,
        np.array([search.watched[index].k for index in search.on_table]), np.full(size, search.course.is_rolled),
    )  # fmt: skip
    left = np.stack([search.undrifted(index) for index in search.on_table], axis=1)
    reading = np.stack(
        [evidence.fitted[:, at] for evidence, at in (search.seen[index] for index in search.on_table)], axis=1
    )
    later, earlier = (layout.sum_by_point(np.where(kept, 1.0, 0.0)) for kept in (inside, ~inside))
    with np.errstate(invalid="ignore", divide="ignore"):
        changed = (
            layout.sum_by_point(np.where(inside[:, None], left, 0.0)) / later[:, None]
            - layout.sum_by_point(np.where(inside[:, None], 0.0, left)) / earlier[:, None]
        )
        variance = np.outer(1.0 / later + 1.0 / earlier, variances)
    drift, drifted = _drifts_between(search, inside, variances)
    visits = Visits(
        pitch, roll, changed - drift, layout.mean_by_point(reading), variance, float(search.course.dof),
        drifted=drifted if search.drifting else None, yaw_rad=yaw,
    )  # fmt: skip
    found = judge_visits(watched, visits, _CONTRADICTED)
    unit = evidence.models[0].measured_unit
    findings = findings_of(found, watched.sensors, between, unit, steps, is_shared=is_shared)
    if size > 1:
        return findings
    return tuple(finding.adding(_OF_A_LONE_AXIS) if _is_on_mount(finding) else finding for finding in findings)


def _is_on_mount(finding: Finding) -> bool:
    """Return whether a finding is of a package that turned about its own axes, as no table turns it."""
    return finding.kind == "table-rotation" and finding.details.get("cause") == FIXTURE


def _drifts_between(search: StepSearch, inside: BoolArray, variances: Sequence[float]) -> tuple[FloatArray, FloatArray]:
    """Return (K, A) what the drift of each output did from outside a change to the rows inside, and how well known.

    It is taken from how the dwells of one point and side differ among each other: a change says nothing of these.
    """
    layout = search.evidence.layout
    cell = 2 * layout.point + inside
    counts = np.bincount(cell, minlength=2 * layout.points).clip(min=1)

    def means(values: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(cell, values, 2 * layout.points) / counts)

    passed = means(search.drift)
    between, within = passed[1::2] - passed[::2], search.drift - passed[cell]
    square = max(float(within @ within), NOTHING)
    found = np.zeros((2, layout.points, len(search.on_table)))
    for column, (index, variance) in enumerate(zip(search.on_table, variances, strict=True)):
        if index in search.drifting:
            left = search.undrifted(index)
            found[0, :, column] = float(within @ (left - means(left)[cell])) / square * between
            found[1, :, column] = np.sqrt(variance / square) * between
    return found[0], found[1]


def _undiagnosed(change: Change, between: str, steps: tuple[int, ...]) -> Finding:
    if change.is_of_table:
        about, whose = f"about {change.what}", "the table, its base or the common fixture"
        if change.is_on_mount:
            about, whose = f"about its {change.what}", f"{_PACKAGE} on its mount, or the fixture"
        return Finding("table-rotation", f"{_PACKAGE} turned {about} {between}: {whose}", True, None, steps)
    if change.is_of_meter:
        text = f"the {change.what} of all outputs stepped alike {between}: the meter, or what all of them share"
        return Finding("meter-gain" if change.what == "sensitivity" else "meter-offset", text, True, None, steps)
    text = f"the {change.what} stepped {between}: the sensor, its channel or its supply"
    return Finding("sensor-change", text, True, None, steps)
