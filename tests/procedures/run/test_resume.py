"""Resume: what it takes, what it refuses with the difference shown, and what a break in trust leads to."""

import json
import os
import re
import resource
import signal
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from faulty_rig import FaultyRig
from file_keys import keys_of, value_at
from resumed import resume_on
from small_run import Bench, StopAt, bench, dwells_of, in_child, measured

from procedures.errors import ExitStatus, JournalError, RequestError
from procedures.journal.audit.audit_trail import on_one_clock
from procedures.journal.audit.changes import Change, may_be_answered_for, require_unchanged, with_what_may_change
from procedures.journal.journal import Journal
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.spool import Request, Spool, ask
from procedures.journal.sidecar.owner import is_owned, owning
from procedures.journal.sidecar.verdict_file import has_earlier_verdict, read_verdict, set_verdict_aside
from procedures.journal.status.status import status
from procedures.journal.storage import JOURNAL_FILE
from procedures.kinds.read import procedure_form
from procedures.plan.steps import Dwell, Soak
from procedures.records.progress import Progress
from procedures.records.states import State
from procedures.run.judgement.history import agenda, history_of, replications_before
from procedures.run.resume import resume
from rig.abilities.abilities import Burst
from rig.assembly.open_rig import open_rig
from rig.clock import SystemClock, VirtualClock
from rig.description.read import rig_form
from rig.description.rig_file import RigDescription


@pytest.fixture
def small(tmp_path: Path) -> Bench:
    return bench(tmp_path)


def _stopped(small: Bench, dwells: int = 5) -> Path:
    run_dir = small.folder / "stopped"
    assert small.run(run_dir, observer=StopAt(run_dir, dwells)).state is State.STOPPED
    return run_dir


def _states(run_dir: Path) -> list[str]:
    with JournalReader.open(run_dir) as reader:
        reader.verify()
        return [str(event.detail["to"]) for event in reader.events("state")]


def test_a_resume_in_virtual_time_begins_no_earlier_than_what_was_measured_ended(small: Bench) -> None:
    run_dir = _stopped(small)
    with JournalReader.open(run_dir) as reader:
        last = reader.last_event()
    assert last is not None
    assert last.utc > datetime.now(UTC), "virtual time is ahead of the clock on the wall"
    resume(run_dir, "carla")
    with JournalReader.open(run_dir) as reader:
        assert min(event.utc for event in reader.events(after=last.sequence)) >= last.utc


def test_a_clock_that_was_set_back_while_the_run_stood_is_told_and_moves_no_date(small: Bench) -> None:
    """Three days back between stop and resume stood in no status, no report and no set."""
    run_dir = _stopped(small)
    with JournalReader.open(run_dir) as reader:
        stopped = reader.last_event()
    assert stopped is not None
    clock = VirtualClock(stopped.utc - timedelta(days=3))
    with open_rig(small.rig, clock=clock) as opened:
        assert resume_on(run_dir, opened, "carla").state is State.FINISHED
    with JournalReader.open(run_dir) as reader:
        (noted,) = reader.events("clock_step")
        counted = [event.utc for event in on_one_clock(list(reader.events()))]
    assert noted.detail["step_s"] == pytest.approx(-3 * 86400.0, abs=1.0)
    assert counted == sorted(counted)
    assert status(run_dir).clock_set_by_s == noted.detail["step_s"]


def test_a_resume_sets_the_verdict_of_the_stop_aside(small: Bench) -> None:
    """After a redo, and after a trip, the verdict of before stood for the minutes until the run was solved again."""
    run_dir = _stopped(small)
    stands = {"trust": "unusable", "sentence": "There is no result to use of any sensor.", "grounds": []}
    for judged in ({}, {"state": "finished"}):
        (run_dir / "verdict.json").write_text(json.dumps(stands | judged), encoding="utf-8")
        assert read_verdict(run_dir, State.FINISHED) is not None
        set_verdict_aside(run_dir)
        assert read_verdict(run_dir, State.FINISHED) is None
        assert has_earlier_verdict(run_dir, State.FINISHED)
    (run_dir / "verdict.json").write_text(json.dumps(stands | {"state": "finished"}), encoding="utf-8")
    resume(run_dir, "carla")
    assert read_verdict(run_dir, State.FINISHED) is None


def test_a_clock_that_was_not_set_is_not_told(small: Bench) -> None:
    run_dir = _stopped(small)
    resume(run_dir, "carla")
    with JournalReader.open(run_dir) as reader:
        assert list(reader.events("clock_step")) == []


def _on_changed_rig(run_dir: Path, rig: RigDescription, **words: str) -> State:
    with open_rig(rig) as opened:
        return resume_on(run_dir, opened, "carla", **words).state


def test_a_stopped_run_goes_on_with_the_first_missing_dwell(small: Bench) -> None:
    small.run(small.folder / "whole")
    run_dir = _stopped(small)
    outcome = resume(run_dir, "carla", "back from lunch")
    assert (outcome.state, outcome.dwells_done) == (State.FINISHED, len(small.plan.design_dwells))
    assert measured(dwells_of(run_dir)) == measured(dwells_of(small.folder / "whole"))
    assert _states(run_dir)[3:] == ["stopped", "checking", "running", "finished"]


def test_every_resume_measures_the_check_set_again_in_its_own_epoch(small: Bench) -> None:
    run_dir = _stopped(small)
    resume(run_dir, "carla")
    checks = [dwell for dwell in dwells_of(run_dir) if dwell.purpose == "check"]
    wanted = [dwell.step for dwell in small.plan.check_set]
    assert [(dwell.epoch, dwell.step) for dwell in checks] == [(epoch, step) for epoch in (1, 2) for step in wanted]
    first, again = checks[0], checks[len(wanted)]
    assert first.readings["dmm.x"].samples.tobytes() != again.readings["dmm.x"].samples.tobytes()
    with JournalReader.open(run_dir) as reader:
        (seam,) = reader.events("seam")
    assert (seam.detail["tested"], seam.detail["comparisons"], seam.detail["steps"]) == (True, 18, 0)


def test_the_record_tells_who_resumed_and_why(small: Bench) -> None:
    run_dir = _stopped(small)
    resume(run_dir, "carla", "back from lunch")
    with JournalReader.open(run_dir) as reader:
        opened = [event.detail for event in reader.events("opened")]
    assert [(entry["operator"], entry["epoch"], entry["reason"]) for entry in opened] == [
        ("tester", 1, ""),
        ("carla", 2, "back from lunch"),
    ]


@pytest.mark.parametrize(
    ("file", "old", "new"), [("rig.toml", "seed = 7", "seed = 8"), ("procedure.toml", "samples = 5", "samples = 6")]
)
def test_fault_70_resume_refuses_a_changed_file_and_shows_the_difference(
    small: Bench, file: str, old: str, new: str
) -> None:
    """Detected: rig file, procedure file, what these name and version of the software against what the journal holds.
    Response: refused, every difference shown field by field; with a name and a reason that the record keeps the run
    goes on with its own plan, and of the rig file only ports and interlocks are taken over.
    """
    run_dir = _stopped(small)
    path = small.folder / file
    path.write_text(path.read_text().replace(old, new))
    before = (run_dir / JOURNAL_FILE).read_bytes()
    key, was, found = old.split(" = ")[0], old.split(" = ")[1], new.split(" = ")[1]
    with pytest.raises(
        RequestError, match=rf"not what the run began with.*\n .*\.{key}: was {was}, is {found}$"
    ) as output:
        resume(run_dir, "carla")
    assert output.value.exit_status == ExitStatus.WRONG_REQUEST
    assert (run_dir / JOURNAL_FILE).read_bytes() == before


def test_a_file_that_is_gone_contradicts_nothing(small: Bench) -> None:
    run_dir = _stopped(small)
    (small.folder / "procedure.toml").unlink()
    (small.folder / "rig.toml").unlink()
    assert resume(run_dir, "carla").state is State.FINISHED


def test_a_changed_comment_is_no_change(small: Bench) -> None:
    run_dir = _stopped(small)
    path = small.folder / "rig.toml"
    path.write_text("# the laboratory's own rig\n" + path.read_text())
    assert resume(run_dir, "carla").state is State.FINISHED


def test_fault_70_a_person_may_answer_for_a_change_and_the_record_keeps_it(
    small: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_dir = _stopped(small)
    monkeypatch.setattr("procedures.journal.audit.changes.calrig_version", lambda: "9.9.9")
    with pytest.raises(RequestError, match=r"--accept-changes needs a name and a reason: .* reason got ' '"):
        resume(run_dir, "carla", " ", accepts_changes=True)
    assert resume(run_dir, "carla", "a new release", StopAt(run_dir, 14), accepts_changes=True).state is State.STOPPED
    with JournalReader.open(run_dir) as reader:
        reader.verify()
        (override,) = reader.events("override")
    (difference,) = override.detail["differences"]  # type: ignore[misc]
    assert (override.detail["by"], override.detail["reason"]) == ("carla", "a new release")
    assert difference.endswith('is "9.9.9"')
    assert resume(run_dir, "carla").state is State.FINISHED, "what was answered for is not asked again"


@pytest.mark.parametrize(
    ("file", "was", "becomes", "sentence"),
    [
        ("procedure.toml", "samples = 5", "samples = 6", "procedure file: dwell.samples: was 5, is 6"),
        ("rig.toml", "seed = 7", "seed = 8", "rig file: twin.seed: was 7, is 8"),
        ("rig.toml", 'port = "twin"\nincrement_deg', 'port = "socket://127.0.0.1:9"\nincrement_deg',
         'rig file: axes.pitch.port: was "twin", is "socket://127.0.0.1:9"'),
    ],
)  # fmt: skip
def test_fault_70_what_the_run_would_keep_is_refused_by_its_name_whoever_answers(
    small: Bench, file: str, was: str, becomes: str, sentence: str
) -> None:
    run_dir = _stopped(small)
    path = small.folder / file
    path.write_text(path.read_text().replace(was, becomes))
    before = (run_dir / JOURNAL_FILE).read_bytes()
    with pytest.raises(RequestError, match="a run keeps what it began with") as refused:
        resume(run_dir, "carla", "samples of tomorrow", accepts_changes=True)
    assert sentence in str(refused.value)
    assert (run_dir / JOURNAL_FILE).read_bytes() == before


def test_fault_70_each_key_of_both_files_is_taken_over_or_refused_by_its_name(tmp_path: Path) -> None:
    """Every key of both forms, changed alone: the rig of the resume has it, or the refusal names it."""
    places = [("rig", key) for key in keys_of(rig_form())] + [("procedure", key) for key in keys_of(procedure_form())]
    taken = set()
    for file, key in places:
        name = f"{file} file: {'.'.join(part.partition(':')[0].replace('*', 'a') for part in key.split('.'))}"
        change = Change(name, "before", "now")
        if may_be_answered_for(change, is_rehearsal=False):
            taken.add(key)
            *tables, last = name.removeprefix("rig file: ").split(".")
            if tables[0] != "interlocks":
                rig: dict[str, Any] = {last: "before"}
                for table in reversed(tables):
                    rig = {table: rig}
                found = json.loads(with_what_may_change(json.dumps(rig), tmp_path, [change]))
                assert value_at(found, (*tables, last)) == "now", key
        else:
            with pytest.raises(RequestError, match=rf"begin a new run with it [^\n]*\n  {re.escape(name)}: was"):
                require_unchanged(tmp_path, [change], (), is_accepted=True, operator="carla", reason="a reason")
    kinds = {key.split(".")[-1] for key in taken if not key.startswith("interlocks.")}
    assert kinds == {"port", "resource", "scanner_resource", "baud_rate", "control"}
    assert len(places) > 200


def test_fault_70_a_rehearsal_takes_no_port_over() -> None:
    change = Change("rig file: axes.pitch.port", "socket://a:1", "socket://b:2")
    assert may_be_answered_for(change, is_rehearsal=False)
    assert not may_be_answered_for(change, is_rehearsal=True)


def test_fault_70_an_interlock_that_was_too_narrow_may_be_widened(tmp_path: Path) -> None:
    narrow = '[interlocks.voltage."dmm.z"]\nband_v = [-2.6, 0.5]\naction = "trip"\n[twin]'
    small = bench(tmp_path, rig=(("[twin]", narrow),))
    assert small.run(tmp_path / "run").state is State.TRIPPED
    path = tmp_path / "rig.toml"
    path.write_text(path.read_text().replace("[-2.6, 0.5]", "[-2.6, 2.6]"))
    assert resume(tmp_path / "run", "carla", "z turns over", accepts_changes=True).state is State.FINISHED


def test_fault_70_of_a_changed_rig_file_only_ports_are_taken_over(tmp_path: Path) -> None:
    rig = json.dumps({"axes": {"pitch": {"port": "socket://a:1", "speed_dps": 20.0}}, "readouts": {}})
    changes = (Change("rig file: axes.pitch.port", "socket://a:1", "socket://b:2"),
               Change("rig file: axes.pitch.speed_dps", 20.0, 40.0))  # fmt: skip
    found = json.loads(with_what_may_change(rig, tmp_path / "rig.toml", changes))
    assert found["axes"]["pitch"] == {"port": "socket://b:2", "speed_dps": 20.0}


def test_fault_70_resume_refuses_another_version_of_the_software(small: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    run_dir = _stopped(small)
    monkeypatch.setattr("procedures.journal.audit.changes.calrig_version", lambda: "9.9.9")
    with pytest.raises(RequestError, match=r"software: calrig: was .*, is .9\.9\.9"):
        resume(run_dir, "carla")


def test_a_finished_run_is_not_resumed(small: Bench) -> None:
    small.run(small.folder / "whole")
    with pytest.raises(RequestError, match="the run is finished, and resume takes stopped, interrupted, tripped"):
        resume(small.folder / "whole", "carla")


def test_a_run_that_somebody_runs_is_not_resumed(small: Bench) -> None:
    run_dir = _stopped(small)
    with owning(run_dir), pytest.raises(RequestError, match=r"belongs to process \d+ since"):
        resume(run_dir, "carla")


def test_a_damaged_journal_is_not_resumed(small: Bench) -> None:
    run_dir = _stopped(small)
    samples = dwells_of(run_dir)[8].readings["dmm.y"].samples.tobytes()
    content = (run_dir / JOURNAL_FILE).read_bytes()
    (run_dir / JOURNAL_FILE).write_bytes(content.replace(samples, samples[::-1]))
    with pytest.raises(JournalError, match="the dwell of step 8, attempt 1, epoch 1 is not as it was written"):
        resume(run_dir, "carla")


def test_a_folder_without_a_run_is_refused_and_left_empty(tmp_path: Path) -> None:
    with pytest.raises(JournalError, match="cannot be read"):
        resume(tmp_path, "carla")
    assert list(tmp_path.iterdir()) == []


def test_a_step_at_the_seam_trips_until_a_person_accepts_it(small: Bench) -> None:
    run_dir = _stopped(small)
    bumped = RigDescription.model_validate(_with_offset(small.rig, 0.0052))
    assert _on_changed_rig(run_dir, bumped) is State.TRIPPED
    found = status(run_dir)
    assert found.state is State.TRIPPED
    assert "the restart made a step: SN1 changed since the check set of epoch 1: offset of SN1 x" in str(found.held_by)
    assert "dmm.x at step" in str(found.held_by)
    with pytest.raises(RequestError, match=r"tripped, so a person has to look first.*--operator and --reason"):
        _on_changed_rig(run_dir, bumped)
    assert _on_changed_rig(run_dir, bumped, reason="package remounted, seen by carla") is State.FINISHED
    assert _states(run_dir)[3:] == ["stopped", "checking", "tripped", "checking", "running", "finished"]
    assert set(measured(dwells_of(run_dir))) == {dwell.step for dwell in small.plan.dwells if dwell.purpose != "check"}


def _with_offset(rig: RigDescription, offset_v: float) -> RigDescription:
    assert rig.twin is not None
    truth = rig.twin.truth["SN1"]
    moved = {**truth, "x": truth["x"].model_copy(update={"offset_v": offset_v})}
    return rig.model_copy(update={"twin": rig.twin.model_copy(update={"truth": {"SN1": moved}})})


def test_after_a_step_that_a_person_accepted_dwells_are_held_against_those_since(small: Bench) -> None:
    """A step of 20 mg, then one dwell that is off by 30 mg: with the dwells before the step in it, the running fit
    would take both for scatter."""
    run_dir = _stopped(small)
    changed = RigDescription.model_validate(_with_offset(small.rig, 0.055))
    assert _on_changed_rig(run_dir, changed) is State.TRIPPED

    def once_off(number: int, burst: Burst) -> Burst:
        return replace(burst, samples=burst.samples + 0.075) if number == 40 else burst

    with open_rig(changed) as rig:
        spoilt = FaultyRig(rig, spoil=once_off)
        assert resume_on(run_dir, spoilt, "carla", "new amplifier").state is State.FINISHED
    (rejected,) = [dwell for dwell in dwells_of(run_dir) if not dwell.accepted]
    assert "from what the dwells before predict" in rejected.reasons[0]


def test_other_devices_than_at_the_start_trip(small: Bench) -> None:
    run_dir = _stopped(small)
    with open_rig(small.rig) as opened:
        outcome = resume_on(run_dir, FaultyRig(opened, identity="HP3458A, other serial"), "carla")
    assert (outcome.state, outcome.exit_status) == (State.TRIPPED, ExitStatus.HELD)
    assert "readouts.dmm: was" in outcome.reason
    assert "'HP3458A, other serial'" in outcome.reason


def test_requests_to_a_dead_process_are_journalled_and_not_obeyed(small: Bench) -> None:
    run_dir = _stopped(small)
    Spool(run_dir).submit(Request("abort", "anna", "2026-03-01T12:01:00+00:00"))
    Spool(run_dir).submit(Request("note", "anna", "2026-03-01T12:02:00+00:00", "door was open"))
    assert resume(run_dir, "carla").state is State.FINISHED
    with JournalReader.open(run_dir) as reader:
        refused = [event.detail for event in reader.events("request") if "refused" in event.detail]
        assert [(entry["kind"], entry["refused"]) for entry in refused] == [
            ("abort", "asked of the process before this one")
        ]
        assert [event.detail["text"] for event in reader.events("note")] == ["door was open"]


def test_a_run_killed_after_its_last_dwell_is_finished_without_moving(small: Bench) -> None:
    run_dir = small.folder / "whole"
    last = len(small.plan.design_dwells)

    class Dies:
        def on_event(self, progress: Progress) -> None:
            if progress.event == "dwell" and progress.dwells_done == last:
                os.kill(os.getpid(), signal.SIGKILL)

    os.waitpid(in_child(lambda: small.run(run_dir, observer=Dies())), 0)
    assert status(run_dir).state is State.INTERRUPTED
    resume(run_dir, "carla")
    assert _states(run_dir)[-4:] == ["interrupted", "checking", "running", "finished"]
    with JournalReader.open(run_dir) as reader:
        opened = reader.last_event("opened")
        assert opened is not None
        after = [event.kind for event in reader.events() if event.sequence > opened.sequence]
    assert after == [*["state"] * 3, "links", "safe", "state"]


def test_nobody_takes_a_request_to_a_run_that_is_not_running(small: Bench) -> None:
    run_dir = _stopped(small)
    with pytest.raises(RequestError, match="cannot pause: no process runs this run: it is stopped"):
        ask(run_dir, "pause", "anna", SystemClock().now_utc())
    assert not is_owned(run_dir)


def _dwell(step: int, purpose: str = "design") -> Dwell:
    return Dwell(step, purpose, 1, step, {"pitch": float(step)})  # type: ignore[arg-type]


def _soak(step: int) -> Soak:
    return Soak(step, 0, "air", 20.0, 1.0, 60.0)


STEPS = (_soak(0), _dwell(1, "check"), _dwell(2), _dwell(3), _soak(4), _dwell(5), _soak(6), _dwell(7))


@pytest.mark.parametrize(
    ("done", "left"),
    [
        (set(), [0, 1, 2, 3, 4, 5, 6, 7]),
        ({2}, [0, 1, 3, 4, 5, 6, 7]),
        ({2, 3}, [4, 1, 5, 6, 7]),
        ({2, 3, 5}, [6, 1, 7]),
        ({2, 5}, [0, 1, 3, 6, 7]),
        ({2, 3, 5, 7}, []),
    ],
)
def test_what_is_left_begins_with_the_soak_in_force_and_the_check_set(done: set[int], left: list[int]) -> None:
    assert [step.step for step in agenda(STEPS, frozenset(done))] == left


def test_replications_completed_follow_the_plan_not_the_time(small: Bench) -> None:
    before = replications_before(small.plan)
    first, second = (
        next(dwell.step for dwell in small.plan.design_dwells if dwell.replication == number) for number in (1, 2)
    )
    assert (before[first], before[second]) == (0.0, 1.0)
    assert all(before[dwell.step] == 0.0 for dwell in small.plan.check_set)


def test_attempts_go_on_where_the_dead_process_left_them(small: Bench) -> None:
    run_dir = _stopped(small)
    dwells = dwells_of(run_dir)
    step = small.plan.design_dwells[5].step
    rejected = replace(dwells[-1], step=step, point=99, accepted=False, reasons=("dmm.x: noise",))
    journal = Journal.open_for_append(run_dir / JOURNAL_FILE)
    journal.commit_dwell(rejected, SystemClock())
    journal.close()
    assert resume(run_dir, "carla").state is State.FINISHED
    assert [dwell.attempt for dwell in dwells_of(run_dir) if dwell.step == step] == [1, 2]
    assert history_of(dwells_of(run_dir), 2, small.plan).attempts(step) == 2


def _on_a_full_disk(small: Bench, run_dir: Path, limit_bytes: int) -> None:
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit_bytes, limit_bytes))
    outcome = small.run(run_dir)
    (run_dir / "outcome.txt").write_text(f"{int(outcome.exit_status)} {outcome.reason}")


@pytest.mark.parametrize(
    "limit_bytes", [302_000, *[pytest.param(n, marks=pytest.mark.thorough) for n in (150_000, 420_000)]]
)
def test_a_full_disk_ends_the_run_safely_and_resume_finishes_it(small: Bench, limit_bytes: int) -> None:
    small.run(small.folder / "whole")
    run_dir = small.folder / "full"
    _, exit_status = os.waitpid(in_child(lambda: _on_a_full_disk(small, run_dir, limit_bytes)), 0)
    assert exit_status == 0
    text = (run_dir / "outcome.txt").read_text()
    assert text.startswith("1 ")
    assert "everything committed before is intact" in text
    assert status(run_dir).state in (State.STOPPED, State.INTERRUPTED)
    assert resume(run_dir, "carla", "space again").state is State.FINISHED
    assert measured(dwells_of(run_dir)) == measured(dwells_of(small.folder / "whole"))
