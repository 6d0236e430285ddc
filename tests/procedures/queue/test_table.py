"""The queue's table, line by line; test_walk.py has it as a whole."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from queue_scene import (
    ANNA,
    BEN,
    HOUR,
    Process,
    Scene,
    add_item,
    arm_queue,
    end_process,
    make_ready,
    queue_files,
    state_of,
    steps,
)

from procedures.errors import JournalError, RequestError
from procedures.queue import people
from procedures.queue.runner import SHUTDOWN, WAITING_NOTICE_S
from procedures.queue.state import ItemState
from procedures.queue.store import FILE
from procedures.queue.words import queue_lines
from procedures.records.states import State
from rig.description.rig_file import RigDescription


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, RigDescription]:
    return queue_files(tmp_path_factory.mktemp("files"))


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    return Scene(tmp_path / "queue")


def test_what_is_armed_and_mounted_starts_and_the_next_after_it(scene, files):
    make_ready(scene, files, 2)
    steps(scene)
    assert scene.world.started == [(1, "start")]
    end_process(scene, 1, State.FINISHED)
    steps(scene)
    assert (state_of(scene, 1), scene.world.started) == (ItemState.FINISHED, [(1, "start"), (2, "start")])
    assert scene.world.notes[0][1].by == ANNA, "who attested it stands in the run"


def test_nothing_starts_disarmed_or_unattested(scene, files):
    item = add_item(scene, files)
    steps(scene)
    arm_queue(scene)
    steps(scene)
    assert scene.world.started == []
    assert "waits for an attestation" in scene.messages[0]
    people.attest(scene.store, ANNA, dict.fromkeys(item.needs, "B"))
    steps(scene)
    assert scene.world.started == [], "another datum face"


@pytest.mark.parametrize("by", [ANNA, BEN])
def test_what_another_person_adds_or_reorders_disarms(scene, files, by: str):
    make_ready(scene, files)
    add_item(scene, files, by)
    assert scene.queue().is_armed(scene.world.boot(), scene.clock.now_utc()) == (by == ANNA)
    arm_queue(scene)
    people.move(scene.store, 2, 1, by)
    assert [one.number for one in scene.queue().items] == [2, 1]
    assert scene.queue().is_armed(scene.world.boot(), scene.clock.now_utc()) == (by == ANNA)


@pytest.mark.parametrize("state", [State.TRIPPED, State.FAILED, State.STOPPED, State.ABORTED, State.RUNNING])
def test_a_halt_disarms_and_waits_for_a_decision(scene, files, state: State):
    make_ready(scene, files, 2)
    steps(scene)
    end_process(scene, 1, state)
    steps(scene)
    assert (state_of(scene), scene.queue().arming) == (ItemState.UNDECIDED, None)
    with pytest.raises(RequestError, match="item 1 needs a decision first"):
        arm_queue(scene)
    with pytest.raises(RequestError, match="needs a reason"):
        people.decide(scene.store, 1, "again", " ", ANNA)
    people.decide(scene.store, 1, "resume", "cable was loose", BEN)
    steps(scene)
    assert scene.world.started == [(1, "start")], "decided, and not armed"
    arm_queue(scene)
    steps(scene)
    assert scene.world.started == [(1, "start"), (1, "resume")]


@pytest.mark.parametrize(("choice", "started"), [("again", [(1, "start"), (1, "start")]), ("drop", [(1, "start")])])
def test_a_decision_measures_again_or_drops(scene, files, choice: str, started: list[tuple[int, str]]):
    make_ready(scene, files)
    steps(scene)
    end_process(scene, 1, State.FAILED)
    steps(scene)
    people.decide(scene.store, 1, choice, "table jammed", ANNA)
    if choice == "again":
        arm_queue(scene)
    steps(scene)
    assert scene.world.started == started


def test_a_held_run_keeps_the_rig_and_what_waits_too_long_expires(scene, files):
    make_ready(scene, files)
    add_item(scene, files, hours=2.0)
    steps(scene)
    scene.world.processes[1].run, scene.world.processes[1].state = Path("/runs/1"), State.HELD
    scene.clock.sleep(3 * 3600.0)
    steps(scene)
    assert (state_of(scene, 1), state_of(scene, 2)) == (ItemState.RUNNING, ItemState.EXPIRED)
    end_process(scene, 1, State.FINISHED)
    steps(scene)
    assert scene.world.started == [(1, "start")]


def test_what_somebody_says_while_a_run_goes_on_is_newer_than_what_it_shows(scene, files):
    make_ready(scene, files, 2)
    steps(scene)
    people.attest(scene.store, BEN, {"SN9": "A"})
    end_process(scene, 1, State.FINISHED)
    steps(scene)
    assert scene.world.started == [(1, "start")]


def test_an_early_item_waits_for_its_time_and_those_behind_it_too(scene, files):
    procedure, rig_file, rig = files
    early = scene.clock.now_utc() + HOUR
    people.add(scene.store, procedure, rig_file, rig, scene.folder, ANNA, title="later", named_files=(),
               not_before_utc=early, not_after_utc=None, refused=[])  # fmt: skip
    make_ready(scene, files)
    steps(scene)
    assert scene.world.started == []
    scene.clock.sleep(3601.0)
    steps(scene)
    assert scene.world.started == [(1, "start")]


def test_a_refused_item_stays_with_its_sentences_and_the_next_starts(scene, files):
    make_ready(scene, files)
    scene.world.refused = ("procedure.toml: was changed since",)
    steps(scene, 1)
    item = scene.queue().item(1)
    assert item is not None
    assert (item.state, item.reasons) == (ItemState.REFUSED, ("procedure.toml: was changed since",))
    scene.world.refused = ()
    add_item(scene, files)
    steps(scene)
    assert scene.world.started == [(2, "start")]


def test_a_busy_rig_is_waited_for_and_told_at_once_and_rung_after_ten_minutes(scene, files):
    make_ready(scene, files)
    scene.world.busy_by = "process 7 (jog)"
    steps(scene)
    assert scene.messages == ["item 1 waits for the rig, which is in use by process 7 (jog)"]
    assert scene.rung == []
    scene.clock.sleep(WAITING_NOTICE_S)
    steps(scene)
    assert [word for word, _ in scene.rung] == ["waits"]
    scene.world.busy_by = ""
    steps(scene)
    assert scene.world.started == [(1, "start")]
    scene.world.processes[1] = Process(is_alive=False, was_busy=True, of_start=1)
    steps(scene, 1)
    assert state_of(scene) is ItemState.WAITING, "somebody was quicker"


def test_fault_90_what_does_not_begin_in_the_night_rings_once(scene, files):
    """An item that is refused, expires, does not begin or waits long for the rig has no run that could tell it."""
    make_ready(scene, files, 2)
    scene.world.refused = ("dmm: is not there",)
    steps(scene)
    assert [word for word, _ in scene.rung] == ["refused", "refused"]
    assert scene.rung[0][1] == "Item 1 of the queue queue: dmm: is not there"
    scene.world.refused = ()
    late = add_item(scene, files, hours=1.0)
    scene.world.busy_by = "process 7 (jog)"
    steps(scene)
    scene.clock.sleep(WAITING_NOTICE_S)
    steps(scene)
    scene.clock.sleep(3600.0)
    steps(scene)
    assert [word for word, _ in scene.rung[2:]] == ["waits", "expired"]
    assert state_of(scene, late.number) is ItemState.EXPIRED
    scene.world.busy_by = ""
    dies = add_item(scene, files)
    steps(scene, 1)
    scene.world.processes[dies.number].is_alive = False
    steps(scene)
    assert [word for word, _ in scene.rung[4:]] == ["not begun"]


def test_fault_90_what_waits_for_an_attestation_that_nobody_gives_rings_and_says_what_was_given(scene, files):
    """Another datum face than the rig file's is another mount: the night must not pass in silence for it."""
    item = add_item(scene, files)
    people.attest(scene.store, ANNA, {"SN1": "A"})
    arm_queue(scene)
    steps(scene)
    assert scene.rung == [], "who has just armed it may still be about to say"
    scene.clock.sleep(WAITING_NOTICE_S)
    steps(scene)
    scene.clock.sleep(WAITING_NOTICE_S)
    steps(scene)
    ((word, text),) = scene.rung
    assert word == "waits"
    assert f"item {item.number} waits for an attestation that SN1 is mounted" in text
    assert "SN1 datum A is, says Anna" in text
    shown = "\n".join(queue_lines(scene.store.read(), scene.world.boot(), scene.clock.now_utc()))
    assert "waits for an attestation that SN1 is mounted (its rig file names no datum face)" in shown
    people.attest(scene.store, ANNA, dict(item.needs))
    steps(scene)
    assert scene.world.started == [(item.number, "start")]


def test_what_nobody_armed_expires_without_ringing(scene, files):
    add_item(scene, files, hours=1.0)
    scene.clock.sleep(2 * 3600.0)
    steps(scene)
    assert (state_of(scene), scene.rung) == (ItemState.EXPIRED, [])


def test_a_run_that_began_tells_its_own_end_but_for_a_restart_of_the_machine(scene, files):
    make_ready(scene, files, 2)
    steps(scene)
    end_process(scene, 1, State.RUNNING)
    steps(scene)
    assert scene.rung == [], "its stop guard has told that it died"
    people.decide(scene.store, 1, "drop", "table jammed", ANNA)
    arm_queue(scene)
    steps(scene)
    end_process(scene, 2, State.RUNNING)
    scene.world.boots = 2
    steps(scene)
    assert [word for word, _ in scene.rung] == ["interrupted"]


@pytest.mark.parametrize("allows", [True, False])
@pytest.mark.parametrize("is_guarded", [True, False])
@pytest.mark.parametrize("state", [State.RUNNING, State.STOPPED])
def test_a_cold_start_resumes_once_where_the_rig_file_allows_it_and_something_stops_every_axis(
    scene, files, allows: bool, is_guarded: bool, state: State
):
    procedure, rig_file, rig = files
    section = rig.rig.model_copy(update={"resume_after_power_cut": allows})
    make_ready(scene, (procedure, rig_file, rig.model_copy(update={"rig": section})), 2)
    steps(scene)
    scene.world.boots, scene.world.is_guarded = 2, is_guarded
    end_process(scene, 1, state, SHUTDOWN)
    steps(scene)
    resumed = allows and is_guarded
    assert scene.world.started == [(1, "start")] + [(1, "resume")] * resumed
    if not resumed:
        assert state_of(scene) is ItemState.UNDECIDED
        return
    scene.world.boots = 3
    end_process(scene, 1, state, SHUTDOWN)
    steps(scene)
    assert (state_of(scene), len(scene.world.started)) == (ItemState.UNDECIDED, 2), "once"


@pytest.mark.parametrize("how", ["disarmed", "added to by another", "over", "machine slept"])
def test_nothing_resumes_itself_after_a_cold_start_once_it_was_disarmed(scene, files, how: str):
    procedure, rig_file, rig = files
    section = rig.rig.model_copy(update={"resume_after_power_cut": True})
    make_ready(scene, (procedure, rig_file, rig.model_copy(update={"rig": section})))
    steps(scene)
    if how == "disarmed":
        people.disarm(scene.store, BEN)
    elif how == "added to by another":
        add_item(scene, files, BEN)
    elif how == "over":
        scene.clock.sleep(13 * 3600.0)
    else:
        scene.world.after_change = lambda: scene.clock.sleep(13 * 3600.0)
    scene.world.boots = 2
    end_process(scene, 1, State.RUNNING)
    steps(scene)
    assert (state_of(scene), scene.world.started) == (ItemState.UNDECIDED, [(1, "start")])


@pytest.mark.parametrize("kind", ["start", "resume"])
@pytest.mark.parametrize("how", ["disarmed", "machine slept"])
def test_nothing_starts_that_is_disarmed_between_its_line_in_the_record_and_its_process(scene, files, kind, how):
    make_ready(scene, files)
    if kind == "resume":
        steps(scene)
        end_process(scene, 1, State.TRIPPED)
        steps(scene)
        people.decide(scene.store, 1, "resume", "cable was loose", ANNA)
        arm_queue(scene)
    before = list(scene.world.started)
    others = {
        "disarmed": lambda: people.disarm(scene.store, BEN),
        "machine slept": lambda: scene.clock.sleep(13 * 3600.0),
    }
    scene.world.after_change = others[how]
    steps(scene, 1)
    scene.world.after_change = lambda: None
    steps(scene)
    assert (state_of(scene), scene.world.started) == (ItemState.UNDECIDED, before)


def test_after_a_cold_start_nothing_new_starts_before_it_is_armed_again(scene, files):
    make_ready(scene, files, 2)
    scene.world.boots = 2
    steps(scene)
    assert scene.world.started == []
    assert (
        scene.queue().why_not_armed(scene.world.boot(), scene.clock.now_utc()) == "the machine was started anew since"
    )


def test_a_record_that_was_changed_starts_nothing(scene, files):
    make_ready(scene, files)
    path = scene.folder / FILE
    with closing(sqlite3.connect(path)) as changed, changed:
        changed.execute("UPDATE events SET detail = replace(detail, 'Anna', 'Mallory') WHERE kind = 'arm'")
    with pytest.raises(JournalError, match="event 3 is not what was written"):
        scene.step()
    assert scene.world.started == []


def test_a_run_that_ended_and_still_rings_needs_its_decision_at_once(scene, files):
    """Its process lives until somebody knows: for as long nothing else was said of it, and the queue was armed."""
    make_ready(scene, files, 2)
    steps(scene)
    process = scene.world.processes[1]
    process.run, process.state, process.has_ended = Path("/runs/1"), State.TRIPPED, True
    steps(scene)
    assert state_of(scene) is ItemState.UNDECIDED
    assert scene.queue().arming is None
    people.decide(scene.store, 1, "resume", "the button is released", ANNA)
    assert state_of(scene) is ItemState.RESUMING
