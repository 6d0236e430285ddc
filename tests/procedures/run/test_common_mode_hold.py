"""All sensors turned at once: the table is held and named while the run runs; what one does is blamed on that one."""

import re
import shlex
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from faulty_rig import FaultyRig
from resumed import resume_on
from small_run import Bench, bench, dwells_of
from turned_table import common_mode_events, several_sensors, slips
from unattended_run import UnattendedRun, asks, events, run_unattended, states

from ams.archive.sets import list_sets
from ams.findings import turned_the_table
from procedures.cli.main import run_command
from procedures.common_mode.visit_watch import VisitWatch, judge_run
from procedures.delivery.deliver import sets_of, solve_run
from procedures.delivery.publish import publish_solved
from procedures.journal.header import make_header
from procedures.journal.requests.corrections import Authorisation, void_from
from procedures.journal.requests.spool import Request, Spool
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.records.dwells import DwellRecord
from procedures.records.progress import Progress
from procedures.records.states import State
from procedures.report.assemble import assemble_view
from procedures.report.overview import overview_rows
from procedures.run.begin import begin
from procedures.run.handover import handover
from procedures.solution.run_findings import run_findings
from rig.abilities.abilities import Burst
from rig.assembly.open_rig import Rig, open_rig
from rig.assembly.simulate import serve_rig, write_rig
from rig.clock import ScaledClock, SystemClock
from rig.errors import LinkLost
from rig.twins.physics.world import World


@pytest.fixture(scope="module")
def eight(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return several_sensors(tmp_path_factory.mktemp("eight"), 8)


@pytest.fixture(scope="module")
def three(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return several_sensors(tmp_path_factory.mktemp("three"), 3)


@pytest.mark.parametrize(("axis", "by_deg"), [("roll", -0.02), ("pitch", 0.02)])
def test_fault_88_a_slip_in_mid_run_is_held_at_the_next_reference_visit_with_the_table_named(
    eight: Bench, tmp_path: Path, axis: str, by_deg: float
) -> None:
    """An axis slips by 72″, and its read-back does not tell.

    Detected: every reference visit over all sensors: slips of the axes, tilt of the base, meter, each sensor's own.
    Response: held within that visit, the table named, the dwells in doubt and what takes them back; set in quarantine.
    """
    unattended = UnattendedRun(tmp_path / "run", at={5: asks("stop")}, after={7: slips(axis, by_deg)})
    assert run_unattended(eight, unattended).state is State.STOPPED
    held = next(event for event in events(unattended.run_dir, "state") if event.detail["to"] == "held")
    reason = str(held.detail["reason"])
    assert held.detail["cause"] == "table"
    assert f"about {axis} between visits 2 and 3: the table, its base or the common fixture, not the sensors" in reason
    assert reason.startswith("all eight sensors turned by " + ("−7" if by_deg < 0 else "+7"))
    assert "in doubt are the 3 dwells of steps" in reason
    assert f"calrig redo {unattended.run_dir} --replication 1 --operator NAME --reason TEXT" in reason
    ((kinds, is_held, _),) = common_mode_events(unattended.run_dir)
    assert (kinds, is_held) == (["table-rotation"], True)


def test_whoever_continues_is_held_once_and_nothing_of_the_run_passes_for_good(three: Bench, tmp_path: Path) -> None:
    """The same finding stands in solution, set, verdict and archive, and no sensor is blamed."""
    unattended = UnattendedRun(tmp_path / "run", at={5: asks("continue")}, after={7: slips("roll", -0.02)})
    assert run_unattended(three, unattended).state is State.FINISHED
    assert states(unattended.run_dir).count("held") == 1
    solved = solve_run(unattended.run_dir)
    ((_, _, text),) = common_mode_events(unattended.run_dir)
    url, sets = f"sqlite:///{tmp_path / 'archive.sqlite'}", sets_of(solved)
    for name, sensor in solved.sensors.items():
        assert sensor.calibration is not None
        axis = sensor.calibration.axes["x"]
        assert [finding.text for finding in axis.findings if finding.is_significant] == [text]
        assert text in axis.warnings
        assert text in sets[name].document["warnings"]  # type: ignore[operator]
    verdict = assemble_view(solved.record, solved.sensors).verdict
    assert verdict.trust == "unusable"
    rows = overview_rows(assemble_view(solved.record, solved.sensors))
    assert {row.verdict for row in rows} == {"not usable"}, "one verdict on one page"
    assert sum(text[1:] in ground for ground in verdict.grounds) == 1, "said once, not once a sensor"
    publish_solved(url, unattended.run_dir, solved.record, solved.sensors, sets)
    assert [coefficients.quarantine for coefficients in list_sets(url)] == [text] * 3


def test_what_was_in_doubt_is_measured_again_after_void_and_resume(three: Bench, tmp_path: Path) -> None:
    unattended = UnattendedRun(tmp_path / "run", at={5: asks("stop")}, after={7: slips("roll", -0.02)})
    assert run_unattended(three, unattended).state is State.STOPPED
    (noted,) = events(unattended.run_dir, "common_mode")
    doubtful = noted.detail["doubtful"]
    assert isinstance(doubtful, list)
    page = handover(unattended.run_dir)
    assert "next       it was held before. All sensors turned together" in page, "not only that it may be resumed"
    assert "\nends " not in page, "nothing goes on"
    command = re.search(r"calrig (void .+? --reason TEXT)", page.partition("next  ")[2])
    assert command is not None
    filled_in = {"NAME": "bert", "TEXT": "the coupling is tight again"}
    words = [filled_in.get(word, word) for word in shlex.split(command[1])]
    assert words[1:4] == [str(unattended.run_dir), "--from", str(min(doubtful))]
    assert run_command(words) == 0
    (taken_back,) = events(unattended.run_dir, "voided")
    assert len(taken_back.detail["dwells"]) == len(doubtful) + 2, "and the visit at two attitudes"  # type: ignore[arg-type]
    with open_rig(three.rig) as rig:
        assert resume_on(unattended.run_dir, rig, "bert").state is State.FINISHED
    assert len(common_mode_events(unattended.run_dir)) == 1
    assert run_findings(solve_run(unattended.run_dir).record) == ()


def slipped_and_taken_back(three: Bench, run_dir: Path, *, is_remounted: bool) -> None:
    """Roll slips by 72″ and is not put right: the seam trips, and every dwell of the design is taken back."""
    unattended = UnattendedRun(run_dir, at={5: asks("stop")}, after={7: slips("roll", -0.02)})
    assert run_unattended(three, unattended).state is State.STOPPED
    (noted,) = events(run_dir, "common_mode")
    doubtful = noted.detail["doubtful"]
    assert isinstance(doubtful, list)
    void_from(run_dir, min(doubtful), Authorisation("bert", "the coupling is tight again"))
    assert resumed(three, run_dir, -0.02) is State.TRIPPED
    first = next(step.step for step in three.plan.steps if step.step and getattr(step, "purpose", "") == "design")
    void_from(run_dir, first, Authorisation("bert", "all again", is_remounted=is_remounted))


def resumed(three: Bench, run_dir: Path, roll_off_deg: float, reason: str = "") -> State:
    with open_rig(three.rig) as rig:  # a twin of its own stands where its zero is: it is put where the run left it
        world = rig.chance
        assert isinstance(world, World)
        world.slip("roll", roll_off_deg, rig.clock.monotonic_s(), seen=False)
        return resume_on(run_dir, rig, "bert", reason).state


@pytest.mark.parametrize("is_remounted", [False, True])
def test_a_turn_that_all_dwells_stand_after_parts_them_from_the_declared_zero(
    three: Bench, tmp_path: Path, is_remounted: bool
) -> None:
    """All is measured again on the slipped table: it all agrees, and stands 72″ of roll off the truth."""
    run_dir = tmp_path / "run"
    slipped_and_taken_back(three, run_dir, is_remounted=is_remounted)
    assert resumed(three, run_dir, -0.02, "all is measured again") is State.FINISHED
    solved = solve_run(run_dir)
    view = assemble_view(solved.record, solved.sensors)
    (finding,) = run_findings(solved.record)
    assert finding.text.startswith("all three sensors turned by −7")
    assert "about roll since the check set of epoch 1" in finding.text
    assert "all dwells that count stand after it" in finding.text
    assert "set the zero and read the level anew and calibrate again from the start" in finding.text
    assert view.verdict.trust == "unusable"
    assert "turned away from the declared zero" in view.verdict.sentence
    assert {row.verdict for row in overview_rows(view)} == {"not usable"}
    url, sets = f"sqlite:///{tmp_path / 'archive.sqlite'}", sets_of(solved)
    publish_solved(url, run_dir, solved.record, solved.sensors, sets)
    assert [coefficients.quarantine for coefficients in list_sets(url)] == [finding.fact] * 3


def test_a_turn_put_right_before_any_dwell_that_counts_is_told_and_spoils_nothing(three: Bench, tmp_path: Path) -> None:
    """The check set of the dwells that count stands as the first did: what turned is back at the declared zero."""
    run_dir = tmp_path / "run"
    slipped_and_taken_back(three, run_dir, is_remounted=False)
    assert resumed(three, run_dir, 0.0, "the zero of roll is set back") is State.FINISHED
    solved = solve_run(run_dir)
    view = assemble_view(solved.record, solved.sensors)
    found = run_findings(solved.record)
    said = "stands again as that of epoch 1 did: what had changed was put right"
    assert any(said in noted.text for noted in view.notes)
    assert {one.kind for one in found} == {"table-rotation"}, "it did turn, and that is told"
    assert view.verdict.trust == "reserved"
    assert any("stand on one side of it" in ground for ground in view.verdict.grounds)
    url, sets = f"sqlite:///{tmp_path / 'archive.sqlite'}", sets_of(solved)
    publish_solved(url, run_dir, solved.record, solved.sensors, sets)
    assert [coefficients.quarantine for coefficients in list_sets(url)] == [None] * 3


def test_a_rig_that_was_put_right_is_held_against_where_it_is_back_and_against_nothing_else(
    three: Bench, tmp_path: Path
) -> None:
    """The check set of the trip was refused: a later restart that stands as the first one did makes no step, and one
    that stands as the refused one does. Half way back is not back.
    """
    run_dir = tmp_path / "run"
    slipped_and_taken_back(three, run_dir, is_remounted=False)
    assert resumed(three, run_dir, -0.01, "half way") is State.TRIPPED
    assert resumed(three, run_dir, 0.0, "the zero of roll is set back") is State.FINISHED
    last = max(dwell.step for dwell in dwells_of(run_dir) if dwell.accepted and dwell.purpose == "design")
    void_from(run_dir, last, Authorisation("bert", "once more"))
    assert resumed(three, run_dir, 0.0) is State.FINISHED
    void_from(run_dir, last, Authorisation("bert", "once more"))
    assert resumed(three, run_dir, -0.02) is State.TRIPPED
    against = [seam.detail["against_epoch"] for seam in events(run_dir, "seam")]
    assert against == [1, 2, 3, 1, 1]
    assert [seam.detail.get("back_at_epoch") for seam in events(run_dir, "seam")] == [None, None, 1, None, None]


def test_a_turn_that_all_dwells_stand_before_is_told_and_spoils_nothing(three: Bench, tmp_path: Path) -> None:
    """What was measured after it was taken back and is not measured again."""
    unattended = UnattendedRun(tmp_path / "run", at={5: asks("stop")}, after={7: slips("roll", -0.02)})
    assert run_unattended(three, unattended).state is State.STOPPED
    (noted,) = events(unattended.run_dir, "common_mode")
    record = solve_run(unattended.run_dir).record
    doubtful = noted.detail["doubtful"]
    assert isinstance(doubtful, list)
    kept = [
        replace(dwell, accepted=dwell.accepted and dwell.step not in doubtful)
        for dwell in dwells_of(unattended.run_dir)
    ]
    told = [finding for judged in judge_run(record.plan, {}, kept, ()) for finding in judged.findings]
    assert ["stand on one side of it" in finding.text for finding in told] == [True]
    assert not turned_the_table(told)


def changed(channel: str, by: Callable[[Burst], Burst], since: int) -> Callable[[int, Burst], Burst]:
    return lambda number, burst: by(burst) if number >= since and burst.channel.startswith(channel) else burst


def more_v(by_v: float) -> Callable[[Burst], Burst]:
    return lambda burst: replace(burst, samples=burst.samples + by_v)


def times(by: float) -> Callable[[Burst], Burst]:
    return lambda burst: replace(burst, samples=burst.samples * by)


SINCE = 9 * 14
"""Readings of nine channels: six check dwells, three of the design, a visit of two, three of the design."""


def around(spoil: Callable[[int, Burst], Burst]) -> Callable[[Rig], FaultyRig]:
    return lambda rig: FaultyRig(rig, spoil=spoil)


@pytest.mark.parametrize(
    ("spoil", "kind", "words"),
    [
        (changed("dmm.SN3y", more_v(5e-4), SINCE), "sensor-change", "SN3 changed by itself"),
        (changed("dmm", times(1.0002), SINCE), "meter-gain", "the meter (gain of dmm)"),
        (changed("dmm", more_v(2e-4), SINCE), "meter-offset", "the meter (offset of dmm)"),
    ],
)
def test_a_drift_of_one_sensor_is_blamed_on_it_and_the_meters_gain_and_offset_on_the_meter(
    three: Bench, tmp_path: Path, spoil: Callable[[int, Burst], Burst], kind: str, words: str
) -> None:
    unattended = UnattendedRun(tmp_path / "run")
    assert run_unattended(three, unattended, rig_of=around(spoil)).state is State.FINISHED
    found = common_mode_events(unattended.run_dir)
    assert {kind} == {kind for kinds, _, _ in found for kind in kinds}
    assert not any(held for _, held, _ in found)
    assert words in found[0][2]


@pytest.mark.parametrize("by", [times(1.0002), more_v(2e-4)])
def test_a_change_of_the_meter_names_the_dwells_in_doubt_and_what_measures_them_again(
    three: Bench, tmp_path: Path, by: Callable[[Burst], Burst]
) -> None:
    """The commands of the handover, split as a shell does, are what the command line takes."""
    unattended = UnattendedRun(tmp_path / "run of today")
    run_dir = unattended.run_dir
    assert run_unattended(three, unattended, rig_of=around(changed("dmm", by, SINCE))).state is State.FINISHED
    (noted,) = events(run_dir, "common_mode")
    doubtful = noted.detail["doubtful"]
    assert isinstance(doubtful, list)
    solved = solve_run(run_dir)
    (finding,) = run_findings(solved.record)
    assert f"in doubt are the {len(doubtful)} dwells of steps {min(doubtful)} to {max(doubtful)}" in finding.text
    run = shlex.quote(str(run_dir))
    assert f"calrig void {run} --from {min(doubtful)} --operator NAME --reason TEXT" in finding.text
    assert f"; then calrig resume {run};" in finding.text
    assert "accept the finding by name and reason" in finding.text
    page = handover(run_dir).partition("\nnext ")[2]
    assert "nothing, it is solved" not in page
    command = re.search(r"calrig (void .+? --reason TEXT)", page)
    assert command is not None
    words = [{"NAME": "bert", "TEXT": "the meter is put right"}.get(word, word) for word in shlex.split(command[1])]
    assert words[1:4] == [str(run_dir), "--from", str(min(doubtful))]
    assert run_command(words) == 0
    with open_rig(three.rig) as rig:
        assert resume_on(run_dir, rig, "bert").state is State.FINISHED
    assert run_findings(solve_run(run_dir).record) == ()
    assert "in doubt" not in handover(run_dir).partition("\nnext ")[2]


def test_a_quiet_run_says_nothing(three: Bench, tmp_path: Path) -> None:
    unattended = UnattendedRun(tmp_path / "run")
    assert run_unattended(three, unattended).state is State.FINISHED
    assert common_mode_events(unattended.run_dir) == []


def test_fault_87_a_partial_check_set_is_judged_when_the_next_one_stands(eight: Bench, tmp_path: Path) -> None:
    """The link is lost inside the first check set, and roll slips by 0.2° before it comes back.

    Detected: what was measured of the set that was cut short, against the next one, over all sensors and attitudes.
    Response: tripped; table, meter and sensors told apart in the sentence.
    """
    unattended = UnattendedRun(tmp_path / "run")
    lost_at = 24 * 4 + 5

    def lost(number: int, burst: Burst) -> Burst:
        if number == lost_at:
            slips("roll", 0.2)(unattended)
            raise LinkLost("axes.pitch at /dev/x: the port is gone or broken; check cable and adapter")
        return burst

    outcome = run_unattended(eight, unattended, rig_of=around(lost))
    assert outcome.state is State.TRIPPED
    assert "all eight sensors turned by +720″" in outcome.reason
    assert "about roll since the check set of epoch 1: the table, its base or the common fixture" in outcome.reason
    assert "look at the table's coupling, its base and the common fixture; a resume" in outcome.reason
    (seam,) = events(unattended.run_dir, "seam")
    assert (seam.detail["tested"], seam.detail["attitudes"], seam.detail["of"]) == (True, 4, 6)


def test_a_lone_sensor_at_one_attitude_is_not_held_for_what_may_be_its_own_drift(tmp_path: Path) -> None:
    small = bench(tmp_path)
    unattended = UnattendedRun(tmp_path / "run", after={9: slips("roll", -0.02)})
    assert run_unattended(small, unattended).state is State.FINISHED
    ((kinds, is_held, text),) = common_mode_events(unattended.run_dir)
    assert (kinds, is_held) == (["table-rotation"], False)
    assert "a change of SN1 itself" in text


def warms_to(degc: float) -> Callable[[UnattendedRun], None]:
    def warm(unattended: UnattendedRun) -> None:
        world = unattended.rig.chance
        assert isinstance(world, World)
        world.disturb("air", degc, unattended.rig.clock.monotonic_s())

    return warm


def test_air_that_warms_in_mid_run_holds_no_lone_package_for_a_turn_of_the_table(tmp_path: Path) -> None:
    """Two offsets by two coefficients look like a turn about two axes, at the one attitude of a visit."""
    warm = "offset_tc_v_per_degc = {}, reference_temperature_degc = 20.0, offset_v = {}"
    truths = tuple((f"offset_v = {at_v},", f"{warm.format(tc, at_v)},") for tc, at_v in ((9e-5, 0.005), (5e-5, -0.003)))
    small = bench(tmp_path, rig=truths)
    unattended = UnattendedRun(tmp_path / "run", at={5: asks("stop")}, after={8: warms_to(24.0)})
    assert run_unattended(small, unattended).state is State.FINISHED
    found = common_mode_events(unattended.run_dir)
    assert found
    assert not any(is_held for _, is_held, _ in found)
    assert "a change of SN1 itself" in found[0][2]


def test_a_visit_that_is_taken_back_in_part_is_compared_as_it_was_measured_again(three: Bench, tmp_path: Path) -> None:
    """What was measured while a band was left counts for nothing, in what later visits are compared with either."""
    assert three.run(tmp_path / "run").state is State.FINISHED
    dwells = [dwell for dwell in dwells_of(tmp_path / "run") if dwell.accepted]
    spoilt_step = [dwell.step for dwell in dwells if dwell.purpose == "reference"][3]

    def spoilt(dwell: DwellRecord) -> DwellRecord:
        readings = {
            name: replace(reading, samples=reading.samples + 5e-4 * name.endswith("y"))
            for name, reading in dwell.readings.items()
        }
        return replace(dwell, readings=readings)

    watch, found = VisitWatch(three.plan, {}), []
    for dwell in dwells:
        if dwell.step == spoilt_step:
            watch.take(spoilt(dwell))
            watch.take_back([spoilt_step])
        found.append(watch.take(dwell))
    judged = [visit for visit in found if visit is not None]
    assert [visit.between for visit in judged[:2]] == ["between the check set and visit 1", "between visits 1 and 2"]
    assert len(judged) == 4
    assert not any(visit.findings for visit in judged)


def test_a_visit_that_is_taken_back_leaves_no_trace_of_the_turn_that_it_showed(three: Bench, tmp_path: Path) -> None:
    """Nor is one that is taken back behind it compared with any more."""
    assert three.run(tmp_path / "run").state is State.FINISHED
    dwells = [dwell for dwell in dwells_of(tmp_path / "run") if dwell.accepted]
    references = [dwell for dwell in dwells if dwell.purpose == "reference"]
    of_visit = len(references) // 4
    first, second = ({dwell.step for dwell in references[of_visit * n : of_visit * (n + 1)]} for n in (0, 1))
    checks = {dwell.step: dwell for dwell in dwells if dwell.purpose == "check"}

    def turned(dwell: DwellRecord) -> DwellRecord:
        readings = {name: replace(it, samples=it.samples + 5e-3) for name, it in dwell.readings.items()}
        return replace(dwell, readings=readings)

    watch, told = VisitWatch(three.plan, {}), []
    for dwell in dwells:
        if dwell.step in second:
            told += [judged for judged in [watch.take(turned(dwell))] if judged is not None]
            if told:
                assert told[0].findings
                watch.take_back(second)
                told += [watch.take(again) for again in dwells if again.step in second]
                break
        else:
            watch.take(dwell)
    assert told[-1] is not None
    assert (told[-1].between, told[-1].findings) == ("between visits 1 and 2", ())
    assert not watch.stands_as_since_the_turn(checks, lambda _step: True)
    watch.take_back(first)
    rest = dwells[dwells.index(references[2 * of_visit - 1]) + 1 :]
    (third, *_) = [judged for judged in map(watch.take, rest) if judged is not None]
    assert third.between == "between visits 2 and 3"


FIRST = 9 * 7
"""Readings of nine channels: six check dwells and one of the design."""


@pytest.mark.parametrize(("axis", "by_deg"), [("roll", -0.02), ("pitch", 0.02)])
def test_fault_88_a_slip_before_the_first_visit_is_held_there_by_the_check_set(
    eight: Bench, tmp_path: Path, axis: str, by_deg: float
) -> None:
    """All later visits stand on one side of it; one attitude of theirs is among those of the check set."""
    unattended = UnattendedRun(tmp_path / "run", at={5: asks("stop")}, after={1: slips(axis, by_deg)})
    assert run_unattended(eight, unattended).state is State.STOPPED
    held = next(event for event in events(unattended.run_dir, "state") if event.detail["to"] == "held")
    reason = str(held.detail["reason"])
    whose = "the table, its base or the common fixture, not the sensors"
    assert f"about {axis} between the check set and visit 1: {whose}" in reason
    assert reason.startswith("all eight sensors turned by " + ("−7" if by_deg < 0 else "+7"))
    assert "in doubt are the 3 dwells of steps 6 to 8" in reason
    assert f"calrig void {unattended.run_dir} --from 6 --operator NAME --reason TEXT" in reason
    solved = solve_run(unattended.run_dir)
    assert assemble_view(solved.record, solved.sensors).verdict.trust == "unusable"


def test_a_run_stopped_before_its_second_visit_is_not_usable_with_a_slip_before_its_first(
    three: Bench, tmp_path: Path
) -> None:
    unattended = UnattendedRun(
        tmp_path / "run", at={5: asks("continue")}, after={1: slips("roll", -0.02), 5: asks("stop")}
    )
    assert run_unattended(three, unattended).state is State.STOPPED
    ((kinds, _, text),) = common_mode_events(unattended.run_dir)
    assert kinds == ["table-rotation"]
    assert [finding.text for finding in run_findings(solve_run(unattended.run_dir).record)] == [text]


def test_the_first_visit_measured_again_after_void_is_compared_with_the_check_set_of_its_epoch(
    three: Bench, tmp_path: Path
) -> None:
    """The table was put right: nothing is told. It slips again after that check set: it is held again, by it."""
    unattended = UnattendedRun(tmp_path / "run", at={5: asks("stop")}, after={1: slips("roll", -0.02)})
    assert run_unattended(three, unattended).state is State.STOPPED
    void_from(unattended.run_dir, 6, Authorisation("bert", "the coupling is tight again"))
    again = UnattendedRun(unattended.run_dir, at={5: asks("stop")}, after={1: slips("roll", -0.02)})
    with open_rig(three.rig) as rig:
        again.rig = rig
        assert resume_on(unattended.run_dir, rig, "bert", observer=again, idle_clock=again).state is State.STOPPED
    assert "between the check set of epoch 2 and visit 1" in common_mode_events(unattended.run_dir)[1][2]
    void_from(unattended.run_dir, 6, Authorisation("bert", "the coupling is a new one"))
    with open_rig(three.rig) as rig:
        assert resume_on(unattended.run_dir, rig, "bert").state is State.FINISHED
    assert len(common_mode_events(unattended.run_dir)) == 2
    assert run_findings(solve_run(unattended.run_dir).record) == ()


FIRST = 9 * 7
"""Readings of nine channels: six check dwells and one of the design."""


@pytest.mark.parametrize(
    ("spoil", "kind", "words"),
    [
        (changed("dmm.SN3y", more_v(5e-4), FIRST), "sensor-change", "SN3 changed by itself"),
        (changed("dmm", more_v(2e-4), FIRST), "meter-offset", "the meter (offset of dmm)"),
    ],
)
def test_before_the_first_visit_too_a_drift_is_blamed_on_what_drifted(
    three: Bench, tmp_path: Path, spoil: Callable[[int, Burst], Burst], kind: str, words: str
) -> None:
    unattended = UnattendedRun(tmp_path / "run")
    assert run_unattended(three, unattended, rig_of=around(spoil)).state is State.FINISHED
    ((kinds, is_held, text),) = common_mode_events(unattended.run_dir)
    assert (kinds, is_held) == ([kind], False)
    assert words in text
    assert "between the check set and visit 1" in text


class SlipsOnce:
    """Lets roll slip behind the ports when seven dwells are done, and asks for a stop where the run is held."""

    def __init__(self, world: World, clock: ScaledClock, run_dir: Path) -> None:
        self._world, self._clock, self._run_dir, self._has_slipped = world, clock, run_dir, False

    def on_event(self, progress: Progress) -> None:
        if progress.event == "dwell" and progress.dwells_done == 7 and not self._has_slipped:
            self._has_slipped = True
            self._world.slip("roll", -0.02, self._clock.monotonic_s(), seen=False)
        if progress.state is State.HELD:
            Spool(self._run_dir).submit(Request("stop", "bert", "2026-03-01T13:00:00+00:00", "please stop"))


def test_fault_88_a_slip_behind_real_ports_is_held_at_the_next_visit(three: Bench, tmp_path: Path) -> None:
    run_dir, factor = tmp_path / "ports", 100.0
    run_dir.mkdir()
    files = tmp_path / "served.toml", three.folder / "procedure.toml"
    clock = ScaledClock(factor)
    with serve_rig(three.rig, clock) as served:
        described = write_rig(three.folder / "rig.toml", served.addresses, factor, files[0])
        plan = make_plan(described, read_procedure(files[1]))
        header = make_header("ports", plan, described, *files, "tester", SystemClock().now_utc())
        with open_rig(described) as rig:
            outcome = begin(run_dir, header, plan, rig, SlipsOnce(served.world, clock, run_dir))
    assert outcome.state is State.STOPPED
    ((kinds, is_held, text),) = common_mode_events(run_dir)
    assert (kinds, is_held) == (["table-rotation"], True)
    assert text.startswith("all three sensors turned by −7")
    assert "about roll between visits 2 and 3: the table, its base or the common fixture, not the sensors" in text
