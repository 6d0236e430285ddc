"""The section on inferred angles against angles put in by hand: the error shown is the error made."""

import re
from dataclasses import replace

import numpy as np
import pytest
from report_scene import Scene, run_view

from ams.sets.stated_verdict import no_conformity
from ams.surveillance.adjustment import Acceptance, Adjustment, Condition, judge, without_conformity
from ams.surveillance.attitude_errors import AngleErrors
from procedures.cli.archive.text import adjustment_lines
from procedures.report.angle_figures import angle_error_figure
from procedures.report.canvas import style
from procedures.report.figures import Figures
from procedures.report.overview import overview_rows
from procedures.report.page import render_page
from procedures.report.verdict import judge as judge_run
from procedures.report.view import RunView

SHA = "ab" * 32


def _errors(name: str, error_deg: float) -> AngleErrors:
    pitch = np.array([-60.0, -30.0, 0.0, 30.0, 60.0])
    size = np.array([0.2, 0.4, 1.0, 0.3, 0.1]) * error_deg
    return AngleErrors(name, pitch, np.zeros(5), size, np.full(5, 0.001), np.full(5, 2.0), 0)


def _condition(kind: str, run: RunView, error_deg: float, limit_deg: float) -> Condition:
    errors = {name: _errors(name, error_deg) for name in ("pitch", "roll")}
    judged = tuple(judge(error, limit_deg, "guard-band") for error in errors.values())
    return Condition(kind, SHA, run.started_utc, errors, judged)  # type: ignore[arg-type]


def _run(as_left_deg: float, as_found_deg: float | None = None, limit_deg: float = 0.01) -> RunView:
    view = run_view(Scene())
    acceptance = Acceptance({"pitch": limit_deg, "roll": limit_deg})
    found = None if as_found_deg is None else _condition("as-found", view, as_found_deg, limit_deg)
    left = _condition("as-left", view, as_left_deg, limit_deg)
    reason = "first calibration in this archive" if found is None else None
    adjustment = Adjustment("SN1047", (-60.0, 60.0), acceptance, found, reason, left)
    sensors = (replace(view.sensors[0], adjustment=adjustment),)
    verdict = judge_run(view.state, view.counts, sensors, view.interruptions, (), 0.8)
    return replace(view, sensors=sensors, verdict=verdict)


def _text(view: RunView) -> str:
    page = render_page(view, Figures((), {sensor.name: () for sensor in view.sensors}))
    return " ".join(re.sub(r"<[^>]+>", " ", page).split())


@pytest.mark.parametrize(
    ("as_left_deg", "trust", "words"),
    [
        (0.003, "sound", ""),
        (0.0095, "reserved", "SN1047 as left: pitch conditional"),
        (0.05, "unusable", "SN1047 as left: pitch fail"),
    ],
)
def test_the_verdict_of_the_run_heeds_the_limits(as_left_deg: float, trust: str, words: str) -> None:
    view = _run(as_left_deg)
    assert view.verdict.trust == trust
    assert words in " ".join(view.verdict.grounds)


def test_a_sensor_found_beyond_its_limits_casts_doubt_on_what_it_measured_before() -> None:
    grounds = " ".join(_run(0.003, as_found_deg=0.05).verdict.grounds)
    assert "as found: pitch fail" in grounds
    assert "since its last calibration is affected" in grounds


def test_the_largest_error_stands_in_the_table_with_its_uncertainty_and_place() -> None:
    text = _text(_run(0.003, as_found_deg=0.05))
    # 0.05 deg at pitch 0, U = 2 x 0.001 deg
    assert re.search(r"as found, \d{4}-\d\d-\d\d pitch 0\.0500° 0\.0020° 2\.00 pitch 0°, roll 0° 5 ±0\.01° fail", text)
    assert "as left, this run pitch 0.0030° 0.0020°" in text
    assert "pitch −60° to 60°" in text
    assert "ILAC-G8" in text


def test_a_calibration_that_is_not_usable_passes_nowhere_on_the_page() -> None:
    view = _run(0.003)
    sensor = view.sensors[0]
    assert sensor.adjustment is not None
    held = without_conformity(sensor.adjustment, no_conformity("not usable", is_in_quarantine=False))
    view = replace(view, sensors=(replace(sensor, adjustment=held, verdict="not usable"),))
    (row,) = overview_rows(view)
    assert row.as_left == "0.0030°"
    text = _text(view)
    assert re.search(r"as left, this run pitch 0\.0030° 0\.0020° 2\.00 pitch 0°, roll 0° 5 ±0\.01° not judged", text)
    assert "As left: not judged (the calibration is not usable)." in text
    lines = list(adjustment_lines(held))
    assert lines[1].startswith("as left: not judged, the calibration is not usable (set ")
    assert not re.search(r"\bpass\b(?! where)|inside the limit(?! at)", " ".join(lines))


def test_a_first_calibration_says_that_nothing_was_found() -> None:
    assert "As found: none (first calibration in this archive)." in _text(_run(0.003))


def test_the_figure_draws_the_limit_only_where_the_errors_stay_legible() -> None:
    with style():
        near, far = (angle_error_figure(_run(0.003, limit_deg=limit).sensors[0]) for limit in (0.01, 1.0))
    assert near is not None
    assert far is not None
    assert b"#d55e00" in near.svg
    assert b"#d55e00" not in far.svg


def test_a_sensor_without_angles_has_no_such_section() -> None:
    assert "Errors of the inferred angles" not in _text(run_view(Scene()))
