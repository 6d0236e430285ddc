from dataclasses import replace
from datetime import UTC, date, datetime
from pathlib import Path

import pytest
from report_scene import Scene, run_view

from ams.findings import Finding, significant_texts
from ams.sets.verdict_conditions import NO_GRAVITY, TERMS_NOT_TESTED
from procedures.journal.audit.audit_trail import Interruption
from procedures.kinds.section import SensorPage
from procedures.records.declared_gaps import level_remarks, meter_remarks
from procedures.report.verdict import judge
from procedures.report.view import AxisFindings, RunView, SensorView
from procedures.solution.level_of_base import level_warnings
from rig.description.read import read_rig
from rig.description.rig_file import Level, LevelReading, Standard

EXAMPLES = Path(__file__).parents[3] / "examples"


def _judged(view: RunView, table_arcsec: float | None = None, steps: tuple[str, ...] = ()) -> tuple[str, str]:
    verdict = judge(view.state, view.counts, view.sensors, view.interruptions, steps, table_arcsec)
    return verdict.trust, "\n".join((verdict.sentence, *verdict.grounds))


def _with(sensor: SensorView, *findings: Finding, **changes: object) -> SensorView:
    """The sensor with findings of its first axis, ``changes`` to the axis' view."""
    axis = sensor.axes[0]
    calibration = replace(axis.calibration, findings=findings, warnings=significant_texts(findings))
    first = replace(axis, calibration=calibration, **changes)  # type: ignore[arg-type]
    of_axis = AxisFindings(axis.axis, axis.channel, findings)
    return replace(sensor, axes=(first, *sensor.axes[1:]), findings=(of_axis, *sensor.findings[1:]))


def test_a_finished_replicated_run_without_findings_is_sound() -> None:
    trust, text = _judged(run_view(Scene()))
    assert trust == "sound"
    assert "pitch −90° to 90° and roll −180° to 180°" in text


@pytest.mark.parametrize(
    ("rejected", "repeated", "sentence"),
    [
        (1, 1, "1 dwell was rejected or taken back, and measured again; it is listed below by reason."),
        (1, 0, "1 dwell was rejected or taken back and was not measured again; it is listed below by reason."),
        (4, 4, "4 dwells were rejected or taken back, and measured again; they are listed below by reason."),
        (4, 3, "4 dwells were rejected or taken back; 3 of them were measured again, 1 not; they are listed below"),
        (4, 0, "4 dwells were rejected or taken back and were not measured again; they are listed below by reason."),
    ],
)
def test_of_rejected_dwells_it_is_said_how_many_were_measured_again(
    rejected: int, repeated: int, sentence: str
) -> None:
    view = run_view(Scene(axes=("x",), rejected=rejected))
    found = replace(view, counts=replace(view.counts, rejected_and_repeated=repeated))
    assert sentence in _judged(found)[1]


def test_lack_of_fit_that_the_table_explains_is_no_reservation_but_is_said() -> None:
    explained = run_view(Scene(tooth_arcsec=1.0, table_explains=True))
    assert _judged(explained, table_arcsec=1.2)[0] == "sound"
    assert "no larger than the table's index errors explain" in _judged(explained, table_arcsec=1.2)[1]
    trust, text = _judged(run_view(Scene(tooth_arcsec=1.0)), table_arcsec=0.3)
    assert trust == "reserved"
    assert "SN1047 x, y, z: the residuals repeat" in text
    assert "index errors explain" not in text


def test_residuals_of_an_axis_that_are_not_held_are_not_called_contained() -> None:
    explained = run_view(Scene(tooth_arcsec=1.0, table_explains=True))
    drifts = (Finding("drift", "it drifts", True, is_held=False),)
    axes = tuple(
        replace(axis, calibration=replace(axis.calibration, findings=drifts)) for axis in explained.sensors[0].axes
    )
    of_axes = tuple(AxisFindings(axis.axis, axis.channel, drifts) for axis in axes)
    sensor = replace(explained.sensors[0], axes=axes, findings=of_axes)
    found = replace(explained, sensors=(sensor, *explained.sensors[1:]))
    trust, text = _judged(found, table_arcsec=1.2)
    assert trust == "unusable"
    assert "contained in the stated uncertainties" not in text


def test_a_remark_is_said_and_is_no_reservation_where_a_warning_is_one() -> None:
    """A time term or straight lines that were asked for mean something; nothing speaks against the result."""
    view = run_view(Scene())
    sensor, text = view.sensors[0], "the offset holds at the reference time"
    axis = replace(sensor.axes[0], calibration=replace(sensor.axes[0].calibration, remarks=(text,)))
    found = replace(view, sensors=(replace(sensor, axes=(axis, *sensor.axes[1:]), remarks=("times count from noon",)),))
    trust, said = _judged(found)
    assert trust == "sound"
    assert "SN1047: times count from noon" in said
    assert f"SN1047: {text}" in said
    warned = replace(axis, calibration=replace(axis.calibration, warnings=(text,)))
    assert _judged(replace(view, sensors=(replace(sensor, axes=(warned,)),)))[0] == "reserved"


def test_a_band_without_the_level_says_so_in_the_verdict() -> None:
    view = run_view(Scene())
    (remark,) = level_remarks(read_rig(EXAMPLES / "inclinometer" / "rig.toml").model_copy(update={"level": Level()}))
    found = replace(view, sensors=(replace(view.sensors[0], remarks=(remark.text,)), *view.sensors[1:]))
    assert (
        _judged(found)[1]
        .splitlines()[0]
        .endswith("or better (95 %), without the level of the base, which is not declared.")
    )
    assert "without the level" not in _judged(view)[1]


def test_a_band_without_the_meter_says_so_in_the_verdict_and_is_as_sound_as_one_without_the_level() -> None:
    view = run_view(Scene())
    rig = read_rig(EXAMPLES / "inclinometer" / "rig.toml")
    undeclared = (
        *level_remarks(rig.model_copy(update={"level": Level()})),
        *meter_remarks(rig.model_copy(update={"standards": {}}), rig.sensors["SN1047"]),
    )
    of_both = tuple(said.text for said in undeclared)
    for remarks, ending in (
        (of_both[1:], ", without the uncertainty of the meter, which is not declared."),
        (of_both, ", without the level of the base and the uncertainty of the meter, which are not declared."),
    ):
        found = replace(view, sensors=(replace(view.sensors[0], remarks=remarks), *view.sensors[1:]))
        assert _judged(found)[0] == _judged(view)[0] == "sound"
        assert _judged(found)[1].splitlines()[0].endswith(ending)


def test_what_is_not_tested_of_a_model_stands_in_the_verdict_and_three_things_undeclared_in_one_list() -> None:
    view = run_view(Scene())
    rig = read_rig(EXAMPLES / "inclinometer" / "rig.toml")
    without = rig.model_copy(update={"standards": {}, "level": Level()})
    texts = [said.text for said in (*level_remarks(without), *meter_remarks(without, rig.sensors["SN1047"]))]
    remarks = (*texts, f"{NO_GRAVITY}: and so on", TERMS_NOT_TESTED)
    found = _judged(replace(view, sensors=(replace(view.sensors[0], remarks=remarks), *view.sensors[1:])))
    assert found[0] == "sound"
    assert (
        found[1]
        .splitlines()[0]
        .endswith(
            ", without the level of the base, the uncertainty of the meter and the uncertainty of local gravity, which "
            "are not declared; not tested for terms of second and third order, memories and slips of the table."
        )
    )


def test_what_the_stated_uncertainties_do_not_hold_is_not_called_usable_with_them() -> None:
    view = run_view(Scene(sensors=("SN1", "SN2")))
    sensor = view.sensors[1]
    for is_held, trust in ((True, "reserved"), (False, "unusable")):
        found_of = _with(sensor, Finding("drift", "the output settles", True, is_held=is_held))
        found = _judged(replace(view, sensors=(view.sensors[0], found_of)))
        assert found[0] == trust
        assert ("with the stated uncertainties of SN2: they do not hold" in found[1]) == (not is_held)
        assert ("is known to" in found[1]) == is_held


def test_a_straight_line_is_judged_by_its_findings_as_its_set_is() -> None:
    """Straight lines have a section of their own and no axes in the view: only the set said "not usable"."""
    view = run_view(Scene(sensors=("SN1",)))
    finding = Finding("drift", "the gain drifts", True, is_held=False)
    line = replace(
        _with(view.sensors[0], finding), axes=(), section=SensorPage("SN1: gain 1.0", ("The gain drifts.",), (), ())
    )
    trust, text = _judged(replace(view, sensors=(line,)))
    assert trust == "unusable"
    assert text.startswith("Not to be used with the stated uncertainties: they do not hold all that was found.")


def test_a_package_that_turned_on_its_mount_is_named_and_no_table_is_blamed_for_it() -> None:
    view = run_view(Scene(sensors=("SN1", "SN2")))

    def turned(sensor: SensorView, cause: str) -> SensorView:
        details = {"cause": cause, "confounded_with": None, "turned_arcsec": 36.0}
        return _with(sensor, Finding("table-rotation", "the package turned", True, details=details, is_held=False))

    first, second = view.sensors
    askew = "turned on the mount, or with the fixture, while the run measured"
    for sensors, sentence in (
        ((first, turned(second, "fixture")), f"Not to be used as it stands of SN2: SN2 {askew}."),
        ((turned(second, "fixture"),), f"Not to be used as it stands: SN2 {askew}."),
        (
            (first, turned(second, "roll")),
            "Not to be used as it stands: the table, its base or the fixture turned while the run measured.",
        ),
    ):
        trust, text = _judged(replace(view, sensors=sensors))
        assert trust == "unusable"
        assert text.splitlines()[0] == sentence


def test_drift_one_replication_and_an_unfinished_run_are_reservations() -> None:
    assert "SN1047 x, y, z: offset changed by 12″" in _judged(run_view(Scene(offset_drift_v=4e-6)))[1]
    assert "one replication only" in _judged(run_view(Scene(replications=1)))[1]
    assert "did not finish (state “aborted”)" in _judged(run_view(Scene(state="aborted")))[1]


def test_a_run_that_did_not_finish_says_first_why_and_since_when() -> None:
    view, moment = run_view(Scene(state="tripped")), datetime(2026, 3, 2, 3, 14, tzinfo=UTC)
    held = Interruption("held", moment, None, "", "W1 y reads 0.000012 V at 12 attitudes: the channel is dead")
    paused = Interruption("paused", moment, None, "A. Operator", "coffee")
    grounds = judge("tripped", view.counts, view.sensors, (held,), (), None).grounds
    assert grounds[0] == f"The run did not finish (state “tripped”), since 2026-03-02 03:14 UTC: {held.reason}."
    grounds = judge("tripped", view.counts, view.sensors, (paused,), (), None).grounds
    assert grounds[0] == "The run did not finish (state “tripped”)."


def test_missing_dwells_are_counted() -> None:
    view = run_view(Scene())
    short = replace(view, counts=replace(view.counts, design_accepted=view.counts.design_planned - 3))
    trust, text = _judged(short)
    assert trust == "reserved"
    assert "3 of 147 planned design dwells are missing" in text


@pytest.mark.parametrize(("state", "what"), [
    ("stopped", ": calrig resume night-1 measures them, and solves with them what cannot be solved without."),
    ("interrupted", ": calrig resume night-1 measures them, and solves with them what cannot be solved without."),
    ("tripped", ": calrig resume night-1 --operator NAME --reason TEXT measures them, and "),
    ("failed", ": this run goes on no more, a new one measures them."),
    ("closed", ": this run goes on no more, a new one measures them."),
    ("finished", "."),
])  # fmt: skip
def test_what_measures_missing_dwells_is_said(state: str, what: str) -> None:
    """Solving again, however often, does not."""
    view = run_view(Scene())
    counts = replace(view.counts, design_accepted=2, design_planned=24)
    grounds = judge(state, counts, view.sensors, (), (), None, run="night-1").grounds
    assert [ground for ground in grounds if f"22 of 24 planned design dwells are missing{what}" in ground]


def test_a_sensor_without_a_solution_makes_the_run_unusable() -> None:
    view = run_view(Scene())
    failed = replace(view.sensors[0], axes=(), failure="roll has one value only")
    trust, text = _judged(replace(view, sensors=(failed,)))
    assert trust == "unusable"
    assert "SN1047: roll has one value only" in text


def test_what_two_sensors_fail_by_is_said_once() -> None:
    view = run_view(Scene(sensors=("SN1", "SN2")))
    failed = tuple(replace(sensor, axes=(), failure="roll has one value only") for sensor in view.sensors)
    trust, text = _judged(replace(view, sensors=failed))
    assert trust == "unusable"
    assert "all 2 sensors: roll has one value only" in text
    assert text.count("roll has one value only") == 1


def test_a_step_at_a_restart_is_a_reservation_although_it_was_accepted() -> None:
    trust, text = _judged(run_view(Scene()), steps=("dmm.x at step 2 changed by 4e-05 V",))
    assert trust == "reserved"
    assert "A restart made a step: dmm.x at step 2" in text


@pytest.mark.parametrize(("after_arcsec", "is_moved"), [(0.0, False), (1.9, False), (2.1, True), (400.0, True)])
def test_a_base_that_moved_by_more_than_its_instrument_explains_is_told(after_arcsec: float, is_moved: bool) -> None:
    level = Level(
        uncertainty_arcsec=1.0,
        before=LevelReading(about_pitch_arcsec=0.0, about_roll_arcsec=5.0),
        after=LevelReading(about_pitch_arcsec=after_arcsec, about_roll_arcsec=5.0),
    )
    said = level_warnings(read_rig(EXAMPLES / "inclinometer" / "rig.toml").model_copy(update={"level": level}))
    assert len(said) == is_moved
    if is_moved:
        assert f"turned by {after_arcsec:+.3g}″ about pitch between" in said[0]
        assert "roll between" not in said[0]


def test_a_level_without_a_limit_may_be_wrong_by_twice_its_standard_uncertainty_at_each_reading() -> None:
    """U = 1.2″ at k = 3 is u = 0.4″: two readings differ by up to 1.6″."""
    of_level = Standard(serial="L", certificate="c", due=date(2030, 1, 1), kind="expanded", k=3.0)
    plain = read_rig(EXAMPLES / "inclinometer" / "rig.toml")
    plain = plain.model_copy(update={"standards": {**plain.standards, "level": of_level}})
    at_zero = LevelReading(about_pitch_arcsec=0.0, about_roll_arcsec=0.0)
    told = []
    for after_arcsec in (1.5, 1.7):
        after = LevelReading(about_pitch_arcsec=after_arcsec, about_roll_arcsec=0.0)
        level = Level(standard="level", uncertainty_arcsec=1.2, before=at_zero, after=after)
        told.append(level_warnings(plain.model_copy(update={"level": level})))
    assert told[0] == ()
    assert "turned by +1.7″ about pitch" in told[1][0]
    assert "(±0.8″ each" in told[1][0]
