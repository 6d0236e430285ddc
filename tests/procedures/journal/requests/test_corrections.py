"""Notes, dwells taken back and replications redone: superseded, never edited; a moved package has its own mounting."""

import json
from dataclasses import replace
from datetime import date
from pathlib import Path

import pytest
from faulty_rig import FaultyRig
from resumed import resume_on
from small_run import Bench, bench, dwells_of, measured, resumed
from unattended_run import RigWithBadLine, UnattendedRun, asks, events, run_unattended, states

from procedures.delivery.deliver import deliver, solve_run
from procedures.errors import RequestError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.corrections import (
    Authorisation,
    acknowledge,
    add_note,
    is_acknowledged,
    redo,
    void_from,
)
from procedures.journal.requests.spool import Request, Spool
from procedures.journal.sidecar.owner import owning
from procedures.journal.status.status import status
from procedures.journal.storage import JOURNAL_FILE
from procedures.records.states import State
from procedures.run.handover import handover
from procedures.run.readiness import readiness
from rig.abilities.abilities import AxisState
from rig.assembly.open_rig import Rig, open_rig
from rig.description.rig_file import LevelReading, RigDescription, Standard

BUMPED = Authorisation("anna", "the table was bumped")


@pytest.fixture
def small(tmp_path: Path) -> Bench:
    return bench(tmp_path)


@pytest.fixture
def whole(small: Bench) -> Path:
    assert small.run(small.folder / "run").state is State.FINISHED
    return small.folder / "run"


def test_a_void_takes_back_from_a_dwell_on_and_a_resume_measures_just_that_again(small: Bench, whole: Path) -> None:
    before = {dwell.step: dwell.sha256 for dwell in dwells_of(whole)}
    first = small.plan.design_dwells[20].step
    count = void_from(whole, first, BUMPED)
    assert status(whole).state is State.STOPPED
    assert status(whole).dwells_done == 20
    assert resumed(whole).state is State.FINISHED
    accepted = {dwell.step: dwell for dwell in dwells_of(whole) if dwell.accepted and dwell.purpose != "check"}
    again = {step for step, dwell in accepted.items() if dwell.attempt == 2}
    assert len(again) == count
    assert again == {step for step in accepted if step >= first}
    assert all(dwell.sha256 == before[step] for step, dwell in accepted.items() if step < first)
    voided = [dwell for dwell in dwells_of(whole) if not dwell.accepted]
    assert {dwell.reasons for dwell in voided} == {("voided by anna: the table was bumped",)}
    assert [dwell.sha256 for dwell in voided] == [before[dwell.step] for dwell in voided], "nothing was edited"


def test_a_redone_replication_is_measured_whole_again(small: Bench, whole: Path) -> None:
    assert redo(whole, 2, BUMPED) == sum(step.replication == 2 for step in small.plan.dwells)
    assert resumed(whole).state is State.FINISHED
    attempts = {dwell.attempt for dwell in dwells_of(whole) if dwell.accepted and dwell.replication == 2}
    assert attempts == {2}
    solved = solve_run(whole).sensors["SN1"]
    assert solved.failure is None
    assert len(solved.observations.point) == len(small.plan.design_dwells)


def test_a_moved_package_begins_a_mounting_whose_check_set_is_compared_with_no_other(small: Bench, whole: Path) -> None:
    redo(whole, 2, Authorisation("anna", "remounted on face B", is_remounted=True))
    moved = small.rig.model_copy(update={"twin": _with_azimuth(small.rig, 36.0)})
    with open_rig(RigDescription.model_validate(moved)) as rig:
        assert resume_on(whole, rig, "carla").state is State.FINISHED
    mountings = {
        dwell.replication: dwell.mounting for dwell in dwells_of(whole) if dwell.accepted and dwell.replication
    }
    assert mountings == {1: 1, 2: 2}
    assert [event.detail["tested"] for event in events(whole, "seam")] == [False]
    solved = solve_run(whole).sensors["SN1"].calibration
    assert solved is not None
    assert "coning and azimuth are those of mounting 2, the last" in str(solved.warnings)
    axis = solved.axes["x"]
    found = {parameter.name: parameter.value for parameter in axis.parameters}
    assert found["azimuth_deg"] == pytest.approx(36.0, abs=0.3)
    assert found["sensitivity_v_per_g"] == pytest.approx(2.5, abs=1e-4)
    earlier = axis.notes["mountings"]["earlier"]  # type: ignore[index]
    assert earlier["mounting_1_azimuth_deg"].value == pytest.approx(35.0, abs=0.3)


@pytest.mark.thorough
def test_a_moved_package_is_delivered_with_the_last_mounting_in_its_set(small: Bench, whole: Path) -> None:
    redo(whole, 2, Authorisation("anna", "remounted on face B", is_remounted=True))
    moved = small.rig.model_copy(update={"twin": _with_azimuth(small.rig, 38.0)})
    with open_rig(RigDescription.model_validate(moved)) as rig:
        assert resume_on(whole, rig, "carla").state is State.FINISHED
    delivery = deliver(solve_run(whole), None)
    document = json.loads(delivery.sets["SN1"].read_text(encoding="utf-8"))
    assert document["axes"]["x"]["parameters"]["azimuth_deg"]["value"] == pytest.approx(38.0, abs=0.3)
    assert "those of mounting 2, the last" in json.dumps(document)
    assert "those of mounting 2, the last" in delivery.report.read_text(encoding="utf-8")


def _with_azimuth(rig: RigDescription, azimuth_deg: float) -> object:
    assert rig.twin is not None
    truth = rig.twin.truth["SN1"]
    return rig.twin.model_copy(
        update={"truth": {"SN1": {**truth, "x": truth["x"].model_copy(update={"azimuth_deg": azimuth_deg})}}}
    )


@pytest.mark.parametrize(
    ("wrong", "expected"),
    [
        (lambda run: void_from(run, 999, BUMPED), r"no accepted dwell of step 999 \(accepted steps: 6 to 32\)"),
        (lambda run: redo(run, 9, BUMPED), "replication 9 has no accepted dwell"),
        (lambda run: redo(run, 1, Authorisation("anna", " ")), "redo needs a reason"),
    ],
)
def test_what_cannot_be_taken_back_is_refused_and_nothing_is_written(whole: Path, wrong: object, expected: str) -> None:
    before = (whole / JOURNAL_FILE).read_bytes()
    with pytest.raises(RequestError, match=expected):
        wrong(whole)  # type: ignore[operator]
    assert (whole / JOURNAL_FILE).read_bytes() == before


def test_nobody_takes_back_under_a_running_run(whole: Path) -> None:
    with owning(whole), pytest.raises(RequestError, match=r"belongs to process \d+"):
        void_from(whole, 10, BUMPED)


def test_a_note_on_a_run_at_rest_is_in_the_chain(whole: Path) -> None:
    add_note(whole, "anna", "door was open from 3 to 4")
    with JournalReader.open(whole) as reader:
        reader.verify()
        (note,) = reader.events("note")
    assert (note.detail["by"], note.detail["text"]) == ("anna", "door was open from 3 to 4")


def test_the_handover_is_one_page_that_names_state_doubts_and_what_to_do(small: Bench, whole: Path) -> None:
    add_note(whole, "anna", "door was open from 3 to 4")
    redo(whole, 2, BUMPED)
    page = handover(whole)
    assert len(page.splitlines()) < 40
    for said in (
        "state      stopped since",
        "12 of 24 dwells of the design",
        "air        20.",
        "anna: door was open from 3 to 4",
        "anna: the table was bumped",
        f"next       calrig resume {whole}",
    ):
        assert said in page


def test_the_handover_of_a_finished_run_tells_its_verdict_and_no_end_to_come(whole: Path) -> None:
    assert "verdict " not in handover(whole)
    assert f"next       calrig solve {whole}\n" in handover(whole)
    rows = [{"sensor": "SN1", "verdict": "not usable"}, {"sensor": "SN2", "verdict": "usable"}]
    slipped = "SN1 turned; measure it again (calrig redo runs/x --replication 1 --operator NAME --reason TEXT)"
    grounds = ["it was interrupted once", slipped]
    sentence = "There is no result to use for one sensor."
    document = {"trust": "unusable", "sentence": sentence, "grounds": grounds, "sensors": rows}
    (whole / "verdict.json").write_text(json.dumps(document), encoding="utf-8")
    (whole / "report.html").write_text("<p>", encoding="utf-8")
    page = handover(whole)
    for said in (
        "verdict    There is no result to use for one sensor.\n",
        "not usable SN1\n",
        f"  1. {grounds[0]}\n  2. {slipped}\n",
        f"report     {whole / 'report.html'}\n",
    ):
        assert said in page
    assert "\nends " not in page
    (after,) = [line for line in page.splitlines() if line.startswith("next")]
    assert (
        "it is solved, and not to be used as it stands: leave the sensors as they are mounted; ground 2 below" in after
    )
    assert f"the command that takes them back, and calrig resume {whole} then measures them again" in after
    reserved = {**document, "trust": "reserved", "grounds": [f"ground {number}" for number in range(30)] + [slipped]}
    (whole / "verdict.json").write_text(json.dumps(reserved), encoding="utf-8")
    page = handover(whole)
    assert "next       it is solved; read the verdict and its grounds below first" in page
    assert f"  31. {slipped}\n  (31 grounds; the report has all)\n" in page
    assert "ground 12" not in page


def test_what_was_judged_at_a_stop_is_no_verdict_of_the_run_that_was_finished_since(whole: Path) -> None:
    """For the minutes until it was solved again it was said to have no result to use of any sensor."""
    document = {"trust": "unusable", "sentence": "There is no result to use of any sensor.", "grounds": []}
    (whole / "report.html").write_text("<p>", encoding="utf-8")
    for state, is_told in (("tripped", False), ("finished", True)):
        (whole / "verdict.json").write_text(json.dumps({**document, "state": state}), encoding="utf-8")
        page = handover(whole)
        assert ("There is no result to use of any sensor." in page) == is_told
        assert (f"report     {whole / 'report.html'}" in page) == is_told
        assert (f"next       calrig solve {whole}\n" in page) != is_told


def test_what_a_result_lacks_is_listed_and_what_contradicts_the_day_is_refused(small: Bench) -> None:
    today = date(2026, 3, 1)
    missing = readiness(small.rig, today).missing
    assert "axes.pitch: no standard stands behind it" in missing
    assert "level.before: the base was not levelled before the run" in missing
    old = Standard(serial="1", certificate="K-17", due=date(2026, 2, 28))
    level = small.rig.level.model_copy(
        update={"before": LevelReading(about_pitch_arcsec=1.0, about_roll_arcsec=0.0, taken="2026-03-02")}
    )
    wrong = readiness(small.rig.model_copy(update={"standards": {"table": old}, "level": level}), today)
    assert wrong.contradictions == (
        "standards.table.due: 2026-02-28 is past (today is 2026-03-01), certificate K-17",
        "level.before.taken: 2026-03-02 is still to come (today is 2026-03-01)",
    )
    with pytest.raises(
        RequestError, match=r"rig.toml: not ready for a calibration: standards.table.due: .* nothing moved"
    ):
        wrong.require("rig.toml")


def test_the_journal_says_what_makes_a_result_an_engineering_one(whole: Path) -> None:
    (ready,) = events(whole, "readiness")
    assert "approved_by: nobody has approved it" in ready.detail["engineering"]  # type: ignore[operator]
    assert states(whole)[-1] == "finished"
    assert measured(dwells_of(whole))


def test_a_request_for_a_note_reaches_a_running_run_by_its_spool(whole: Path) -> None:
    Spool(whole).submit(Request("note", "anna", "2026-03-01T12:00:00+00:00", "later"))
    redo(whole, 2, BUMPED)
    resumed(whole)
    assert [event.detail["text"] for event in events(whole, "note")] == ["later"]


def test_an_acknowledgement_at_rest_and_in_a_held_run_is_on_record_and_known(small: Bench, tmp_path: Path) -> None:
    unattended = UnattendedRun(
        small.folder / "held", at={30: asks("ack"), **{at: asks("continue") for at in range(60, 2000, 20)}}
    )
    outcome = run_unattended(small, unattended, rig_of=RigWithBadLine)
    assert outcome.state in (State.FINISHED, State.STOPPED)
    (ack,) = events(unattended.run_dir, "ack")
    assert (ack.detail["by"], any(entry.event == "ack" for entry in unattended.heard)) == ("bert", True)


def test_a_tripped_run_is_acknowledged_by_a_word_after_its_trip_or_by_a_resume(small: Bench, tmp_path: Path) -> None:
    unattended = UnattendedRun(small.folder / "tripped", after={5: asks("ack")})
    run_unattended(small, unattended, rig_of=lambda rig: Pressed(rig))
    assert status(unattended.run_dir).state is State.TRIPPED
    assert not is_acknowledged(unattended.run_dir), "a word from before the trip does not speak of it"
    acknowledge(unattended.run_dir, "anna", "on my way")
    assert is_acknowledged(unattended.run_dir)
    with JournalReader.open(unattended.run_dir) as reader:
        reader.verify()


class Pressed(FaultyRig):
    """The stop button is pressed in mid-run."""

    def __init__(self, rig: Rig) -> None:
        super().__init__(rig, look=self._pressed)

    def _pressed(self, state: AxisState) -> AxisState:
        return replace(state, fault="stop button" if self.meter.read_so_far >= 60 else "")
