"""Laws of what `check` foresees: what finished runs are reserved about stands there before, word for word."""

import os
from dataclasses import replace
from datetime import UTC, date, datetime, time, timedelta
from pathlib import Path
from zoneinfo import ZoneInfo

import pytest
from changed_sets import changed
from example_files import EXAMPLE_RIG
from finished_job import FinishedJob
from planning_files import AIR, procedure_file, rig_file
from small_run import PROCEDURE, bench
from zones import hung_in

from ams.archive.sign_offs import SignOff
from ams.calibration_result import Calibration
from ams.findings import significant_texts
from ams.sets.coefficients import from_document
from procedures.certificate.grounds import Grounds, gaps_of
from procedures.check.check_report import check
from procedures.delivery.deliver import sets_of, solve_run
from procedures.errors import PlanError
from procedures.kinds.read import read_procedure
from procedures.records.states import State
from procedures.run.preflight import preflight
from procedures.run.readiness import readiness
from procedures.solution.foreseen import FACTS
from rig.description.read import read_rig
from rig.description.rig_file import Level, LevelReading, RigDescription
from rig.local_time import local_day

SERPENTINE_ONE_SIDED = """
[procedure]
title = "serpentine, plateaus from one side"
kind = "grid"
replications = 1
[design]
kind = "D"
pitch_deg = { from = -80.0, to = 80.0, step = 20.0 }
roll_deg = [-120.0, 0.0, 120.0]
order = "serpentine"
[environment]
plateaus_degc = [15.0, 25.0]
soak_s = 10.0
[dwell]
samples = 2
settle = { window_s = 1.0, windows = 2, min_s = 1.0, max_s = 30.0 }
"""


def _held_against(calibration: Calibration) -> set[str]:
    """Everything but what a test found in the readings of this very run."""
    tested = {
        text
        for axis in calibration.axes.values()
        for text in significant_texts([finding for finding in axis.findings if finding.kind not in FACTS])
    }
    every = {*calibration.warnings, *(text for axis in calibration.axes.values() for text in axis.warnings)}
    return every - tested


def _untold(rig: RigDescription, procedure: Path, run: Path) -> dict[str, set[str]]:
    """What was held against a finished run and check did not say, without the numbers in it."""
    said = {_plain(text) for text in check(rig, read_procedure(procedure)).forecast.reservations}
    found = {}
    for name, solved in solve_run(run).sensors.items():
        assert solved.calibration is not None
        found[name] = {text for text in _held_against(solved.calibration) if _plain(text) not in said}
        assert _held_against(solved.calibration)
    return found


def _plain(text: str) -> str:
    return "".join(sign for sign in text if not sign.isdigit() and sign != ".")


def test_the_reservations_of_a_finished_run_stood_in_check(finished_job: FinishedJob) -> None:
    rig = read_rig(finished_job.folder / "rig.toml")
    assert _untold(rig, finished_job.folder / "procedure.toml", finished_job.run) == {"SN1047": set()}


def test_a_level_and_a_meter_not_declared_are_said_in_the_words_of_the_report_and_held_against_nothing(
    finished_job: FinishedJob,
) -> None:
    rig = read_rig(finished_job.folder / "rig.toml")
    forecast = check(rig, read_procedure(finished_job.folder / "procedure.toml")).forecast
    solved = solve_run(finished_job.run).sensors["SN1047"].calibration
    assert solved is not None
    level, meter, scanner = forecast.remarks
    assert level.startswith("the level of the base is not declared")
    assert meter.startswith("no uncertainty of the meter is declared (dmm)")
    assert scanner.startswith("no crosstalk of the scanner is declared (dmm)")
    assert {level, meter, scanner} <= set(solved.remarks)
    assert not any(
        "level of the base" in one or "meter" in one for one in (*forecast.reservations, *_held_against(solved))
    )


def test_a_serpentine_and_plateaus_from_one_side_are_foreseen(tmp_path: Path) -> None:
    made, run = bench(tmp_path, procedure=((PROCEDURE, SERPENTINE_ONE_SIDED),)), tmp_path / "run"
    assert made.run(run).state is State.FINISHED
    said = check(made.rig, read_procedure(tmp_path / "procedure.toml")).forecast.reservations
    assert any("time and attitude go together" in entry for entry in said)
    assert any("plateau was visited once only" in entry for entry in said)
    assert _untold(made.rig, tmp_path / "procedure.toml", run) == {"SN1": set()}


def test_the_gaps_of_a_certificate_stood_in_check(finished_job: FinishedJob, tmp_path: Path) -> None:
    """Of standards that hold: one that is due says so in other words, with other days, and has laws of its own."""
    rig = read_rig(finished_job.folder / "rig.toml")
    plan = check(rig, read_procedure(finished_job.folder / "procedure.toml")).plan
    said = preflight(Path("rig.toml"), rig, plan, tmp_path, datetime(2026, 11, 1, 12, tzinfo=UTC)).certificate
    (made,) = sets_of(solve_run(finished_job.run)).values()
    far = changed(made, lambda d: [one.update(due="2999-12-31") for one in d["provenance"]["standards"]])
    coefficients = from_document(far, "a set")
    grounds = Grounds("1", coefficients.created_utc.date(), coefficients, None, SignOff(coefficients.sha256, (), ()))
    missing = [gap for gap in gaps_of(grounds) if "which nobody has accepted" not in gap]
    assert len(missing) >= 6
    assert [gap for gap in missing if not any(entry.startswith(gap) for entry in said)] == []


def test_a_standard_that_is_due_before_the_run_ends_is_told(finished_job: FinishedJob, tmp_path: Path) -> None:
    rig = read_rig(finished_job.folder / "rig.toml")
    plan = check(rig, read_procedure(finished_job.folder / "procedure.toml")).plan
    two_days = replace(plan, expected=replace(plan.expected, p90_s=2.0 * 86_400.0))
    noon_of_due = datetime.combine(rig.standards["table"].due, time(12))
    for before, is_told in ((1, True), (2, False), (30, False)):
        began_utc = (noon_of_due - timedelta(days=before)).astimezone(UTC)
        gaps = preflight(Path("rig.toml"), rig, two_days, tmp_path, began_utc).certificate
        assert any("standards.table.due" in gap for gap in gaps) == is_told


@pytest.mark.parametrize("which", ["before", "after"])
def test_a_level_that_nobody_can_have_read_yet_is_told_of_a_twin_and_refused_of_a_rig(
    finished_job: FinishedJob, tmp_path: Path, which: str
) -> None:
    rig = read_rig(finished_job.folder / "rig.toml")
    plan = check(rig, read_procedure(finished_job.folder / "procedure.toml")).plan
    reading = LevelReading(about_pitch_arcsec=0.0, about_roll_arcsec=0.0, taken="2036-03-01")
    of_2036 = rig.model_copy(update={"level": Level(**{which: reading})})
    now = datetime(2026, 11, 1, 12, tzinfo=UTC)
    sentence = f"level.{which}.taken: 2036-03-01 is still to come (today is {local_day(now)})"
    assert sentence in preflight(Path("rig.toml"), of_2036, plan, tmp_path, now).certificate
    assert sentence in readiness(of_2036, local_day(now)).contradictions
    assert not any("still to come" in gap for gap in preflight(Path("rig.toml"), rig, plan, tmp_path, now).certificate)


@pytest.mark.parametrize(
    ("began_local", "is_told"), [("2026-11-24T20:00", False), ("2026-11-24T23:30", True), ("2026-11-25T00:10", True)]
)
def test_a_due_day_holds_to_its_midnight_at_the_wall(
    finished_job: FinishedJob, tmp_path: Path, *, began_local: str, is_told: bool
) -> None:
    rig = read_rig(finished_job.folder / "rig.toml")
    plan = check(rig, read_procedure(finished_job.folder / "procedure.toml")).plan
    an_hour = replace(plan, expected=replace(plan.expected, p90_s=3600.0))
    table = rig.standards["table"].model_copy(update={"due": date(2026, 11, 24)})
    due_now = rig.model_copy(update={"standards": {"table": table}})
    began_utc = datetime.fromisoformat(began_local).astimezone(UTC)
    gaps = preflight(Path("rig.toml"), due_now, an_hour, tmp_path, began_utc).certificate
    assert any("standards.table.due" in gap for gap in gaps) == is_told


@pytest.mark.skipif(os.name == "nt", reason="the zone of a process is a variable only elsewhere")
def test_a_level_that_was_read_this_evening_is_not_still_to_come_where_utc_has_tomorrow_already() -> None:
    """Half past eight in the evening in St John's: by UTC it is midnight of the next day."""
    rig = read_rig(EXAMPLE_RIG)
    reading = LevelReading(about_pitch_arcsec=0.0, about_roll_arcsec=0.0, taken="2026-12-01T00:00:00Z")
    read_now = rig.model_copy(update={"level": Level(before=reading)})
    with hung_in("America/St_Johns"):
        found = readiness(read_now, local_day(datetime(2026, 12, 1, 0, 30, tzinfo=UTC)))
        assert [entry for entry in (*found.contradictions, *found.missing) if entry.startswith("level")] == []
        tomorrow = LevelReading(about_pitch_arcsec=0.0, about_roll_arcsec=0.0, taken="2026-11-30")
        assert Level(before=reading, after=tomorrow).after == tomorrow, "both on the thirtieth"


def test_a_day_is_that_of_the_calendar_at_the_wall() -> None:
    """Four in the morning by UTC is eleven in the evening of the day before in New York, and noon in Singapore."""
    moment_utc = datetime(2026, 11, 25, 4, tzinfo=UTC)
    assert local_day(moment_utc, ZoneInfo("America/New_York")) == date(2026, 11, 24)
    assert local_day(moment_utc, ZoneInfo("Asia/Singapore")) == date(2026, 11, 25)


def test_a_plateau_outside_an_interlock_is_refused_before_anything_moves(tmp_path: Path) -> None:
    rig = rig_file(tmp_path, more=AIR + "[interlocks.temperature.air]\nband_degc = [15.0, 25.0]\n")
    procedure = procedure_file(tmp_path, more="[environment]\nplateaus_degc = [20.0, 30.0]\n")
    with pytest.raises(PlanError, match=r"30 °C lies outside interlocks.temperature.air .*the run would hold there"):
        check(rig, procedure)


@pytest.mark.parametrize(
    ("band_degc", "would_hold_at"), [("[15.0, 25.0]", None), ("[19.8, 24.0]", "19.5"), ("[16.0, 20.1]", "20.5")]
)
def test_a_chamber_that_may_be_stable_where_its_interlock_holds_is_a_reservation(
    tmp_path: Path, band_degc: str, would_hold_at: str | None
) -> None:
    rig = rig_file(tmp_path, more=AIR + f"[interlocks.temperature.air]\nband_degc = {band_degc}\n")
    procedure = procedure_file(tmp_path, more="[environment]\nplateaus_degc = [20.0]\nband_degc = 0.5\n")
    said = [text for text in check(rig, procedure).forecast.reservations if "interlocks.temperature.air" in text]
    assert [f"would hold the run at {would_hold_at} °C" in text for text in said] == [True] * (
        would_hold_at is not None
    )


@pytest.mark.parametrize(("share", "rule", "is_told"), [(0.9, "guard-band", True), (1.1, "guard-band", False),
                                                       (0.9, "simple", False)])  # fmt: skip
def test_a_limit_that_the_guard_band_uses_up_is_a_reservation(
    tmp_path: Path, share: float, rule: str, *, is_told: bool
) -> None:
    procedure = procedure_file(tmp_path)
    (angles,) = check(rig_file(tmp_path), procedure).forecast.angles.values()
    limit_deg = share * angles["pitch"].calibration_deg
    declared = f'[acceptance]\npitch_limit_deg = {limit_deg!r}\ndecision_rule = "{rule}"\n'
    said = check(rig_file(tmp_path, more=declared), procedure).forecast.reservations
    assert any("acceptance.pitch_limit_deg" in text and "cannot be passed by SN1" in text for text in said) == is_told


def test_tps_ten_recommendations_are_told_each_with_its_reason(tmp_path: Path) -> None:
    found = check(rig_file(tmp_path), procedure_file(tmp_path)).forecast.recommendations
    assert [entry.number for entry in found] == list(range(1, 11))
    assert all(entry.text and entry.reason for entry in found)
    assert {entry.number for entry in found if entry.is_followed} == {2, 3, 4, 7, 9}
    assert {entry.number for entry in found if entry.is_followed is False} == {6}
    serpentine = check(rig_file(tmp_path), procedure_file(tmp_path, more='order = "serpentine"\n')).forecast
    assert any("(TP recommendation 4)" in line for line in serpentine.advice)
