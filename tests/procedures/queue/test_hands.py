"""What was armed and said to be mounted is so for the rig as it stood: whoever has the rig after it ends it."""

from datetime import timedelta
from pathlib import Path

import pytest
from queue_scene import (
    ANNA,
    BEN,
    HOUR,
    Scene,
    add_item,
    arm_queue,
    end_process,
    make_ready,
    queue_files,
    state_of,
    steps,
)

from procedures.errors import RequestError
from procedures.queue import people
from procedures.queue.hands import ABORT, JOG_STOP, REMOUNTED, STOP, disarm_by_stop_of_rig, heed_all
from procedures.queue.state import ItemState
from procedures.queue.store import QueueStore
from procedures.queue.words import queue_lines
from procedures.records.states import State
from rig.clock import VirtualClock
from rig.description.rig_file import RigDescription
from rig.lines.lock import STARTED_BY, acquire


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path, RigDescription]:
    (tmp_path / "files").mkdir()
    return queue_files(tmp_path / "files")


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    return Scene(tmp_path / "queue")


def _hold(files, purpose: str) -> None:
    """Somebody has the rig for a while, and gives it back."""
    with acquire([str(files[1])], purpose):
        pass


def _lines(scene: Scene) -> str:
    return "\n".join(queue_lines(scene.queue(), scene.world.boot(), scene.clock.now_utc()))


@pytest.mark.parametrize("purpose", ["run", "calrig resume", "jog"])
def test_a_use_by_hand_ends_the_arming_also_where_nobody_looked_meanwhile(scene, files, purpose: str):
    """A finished one too: whoever armed the queue has not seen the rig as it was left."""
    make_ready(scene, files)
    _hold(files, purpose)
    scene.new_runner()
    steps(scene)
    assert scene.world.started == []
    assert f"({purpose})" in _lines(scene).splitlines()[0]
    assert scene.rung == [("disarmed", f"Item 1 of the queue queue: {scene.messages[0].removeprefix('item 1 ')}")]
    people.attest(scene.store, ANNA, people.needs_of(files[2]))
    arm_queue(scene)
    steps(scene)
    assert scene.world.started == [(1, "start")], "somebody has looked, and armed it again"


def test_a_use_by_another_rig_file_of_the_same_port_ends_the_arming(scene, files, tmp_path: Path):
    procedure, rig_file, rig = files
    pitch = rig.axes["pitch"].model_copy(update={"port": "/dev/ttyUSB7"})
    wired = rig.model_copy(update={"axes": {**rig.axes, "pitch": pitch}})
    make_ready(scene, (procedure, rig_file, wired))
    with acquire([str(tmp_path / "a copy.toml"), "/dev/ttyUSB7"], "run"):
        pass
    steps(scene)
    assert scene.world.started == []


@pytest.mark.parametrize("what", [ABORT, STOP, JOG_STOP])
def test_a_stop_from_elsewhere_disarms_before_it_answers(scene, files, what: str):
    """Also one that comes to a run of the queue which finishes all the same: hands may be in the rig."""
    make_ready(scene, files, 2)
    steps(scene)
    (sentence,) = disarm_by_stop_of_rig(scene.folder.parent, files[1], what, scene.clock)
    assert "armed by Anna until" in sentence
    assert "it is disarmed by this" in sentence
    assert scene.queue().arming is None
    assert scene.queue().attestation is not None, "a stop mounts nothing else"
    end_process(scene, 1, State.FINISHED)
    steps(scene)
    assert scene.world.started == [(1, "start")]
    assert disarm_by_stop_of_rig(scene.folder.parent, files[1], what, scene.clock) == [], "it is armed no more"


def test_a_command_says_that_it_disarms_also_where_the_runner_was_quicker(scene, files):
    make_ready(scene, files)
    with acquire([str(files[1])], "jog"):
        steps(scene)
        assert scene.queue().arming is None
        (sentence,) = heed_all(scene.folder.parent, scene.clock)
    assert "it is disarmed by this" in sentence


def test_nothing_is_armed_while_somebody_else_has_the_rig(scene, files):
    item = add_item(scene, files)
    people.attest(scene.store, ANNA, item.needs)
    with acquire([str(files[1])], "jog"), pytest.raises(RequestError, match=r"in use by process \d+ \(jog\)"):
        arm_queue(scene)
    assert scene.queue().arming is None


def test_an_item_of_a_rig_that_somebody_has_is_added_and_disarms(scene, files, tmp_path: Path):
    """Its rig file may be another one, of which the queue knew nothing before."""
    make_ready(scene, files)
    (tmp_path / "more").mkdir()
    others = queue_files(tmp_path / "more")
    with acquire([str(others[1])], "jog"):
        add_item(scene, others)
    steps(scene)
    assert scene.world.started == []


def test_what_was_done_before_an_item_was_added_ends_nothing(scene, files, tmp_path: Path):
    """Also with a rig file of which the armed queue knew nothing."""
    _hold(files, "run")
    make_ready(scene, files)
    (tmp_path / "more").mkdir()
    others = queue_files(tmp_path / "more")
    _hold(others, "run")
    add_item(scene, others)
    steps(scene)
    assert scene.world.started == [(1, "start")]


def test_a_run_of_the_queue_ends_no_arming_of_it_and_that_of_another_queue_does(scene, files, monkeypatch):
    make_ready(scene, files, 2)
    monkeypatch.setenv(STARTED_BY, str(scene.folder.resolve()))
    _hold(files, "run")
    monkeypatch.delenv(STARTED_BY)
    assert heed_all(scene.folder.parent, scene.clock) == []
    assert scene.queue().arming is not None
    monkeypatch.setenv(STARTED_BY, str(scene.folder.with_name("another")))
    _hold(files, "run")
    assert len(heed_all(scene.folder.parent, scene.clock)) == 1


@pytest.mark.parametrize("kind", ["start", "resume"])
def test_a_use_between_the_line_in_the_record_and_the_process_lets_nothing_begin(scene, files, kind: str):
    make_ready(scene, files)
    if kind == "resume":
        steps(scene)
        end_process(scene, 1, State.TRIPPED)
        steps(scene)
        people.decide(scene.store, 1, "resume", "cable was loose", ANNA)
        arm_queue(scene)
    before = list(scene.world.started)
    scene.world.after_change = lambda: _hold(files, "jog")
    steps(scene, 1)
    scene.world.after_change = lambda: None
    steps(scene)
    assert (state_of(scene), scene.world.started) == (ItemState.UNDECIDED, before)


def test_what_is_mounted_is_told_with_its_time_until_a_run_by_hand_may_have_changed_it(scene, files):
    make_ready(scene, files, 2)
    scene.clock.sleep(60.0)
    steps(scene)
    end_process(scene, 1, State.FINISHED)
    steps(scene, 2)
    assert "mounted: SN1, says the run that finished, at " in _lines(scene)
    _hold(files, "jog")
    steps(scene)
    assert "mounted: SN1, says the run that finished" in _lines(scene), "a jog mounts nothing else"
    _hold(files, "run")
    steps(scene)
    assert scene.queue().attestation is None
    assert "what the run that finished said at " in _lines(scene)
    arm_queue(scene)
    steps(scene)
    assert scene.world.started == [(1, "start")]
    assert "waits for an attestation that SN1 is mounted" in scene.messages[-1]


def test_a_package_that_was_mounted_anew_ends_what_was_said(scene, files):
    make_ready(scene, files)
    disarm_by_stop_of_rig(scene.folder.parent, files[1], REMOUNTED, scene.clock)
    assert (scene.queue().attestation, scene.queue().arming) == (None, None)


@pytest.mark.parametrize("behind", [timedelta(seconds=1), 20 * 365 * 24 * HOUR])
def test_after_a_cold_start_with_a_clock_that_is_behind_nothing_resumes_itself(scene, files, behind: timedelta):
    """A computer without a clock of its own comes back minutes after the cut, or in another century."""
    procedure, rig_file, rig = files
    section = rig.rig.model_copy(update={"resume_after_power_cut": True})
    make_ready(scene, (procedure, rig_file, rig.model_copy(update={"rig": section})))
    steps(scene)
    end_process(scene, 1, State.RUNNING)
    after = Scene(scene.folder, VirtualClock(scene.clock.now_utc() - behind))
    after.world.processes, after.world.boots = scene.world.processes, 2
    steps(after)
    assert (state_of(after), after.world.started) == (ItemState.UNDECIDED, [])
    assert "not resumed: the clock of this machine shows" in _lines(after)
    assert "the clock of this machine shows" in after.rung[0][1]


def test_a_clock_that_was_set_back_starts_nothing_before_what_is_recorded(scene, files):
    make_ready(scene, files)
    after = Scene(scene.folder, VirtualClock(scene.clock.now_utc() - timedelta(seconds=5)))
    steps(after, 1)
    assert after.world.started == []
    assert "waits: the clock of this machine shows" in after.messages[0]
    after.clock.sleep(6.0)
    steps(after)
    assert after.world.started == [(1, "start")]


class BeatenStore(QueueStore):
    """A store whose user is a moment too late: somebody else has changed the queue since it was seen."""

    def change(self, decide):  # type: ignore[no-untyped-def]
        QueueStore(self.folder, self._clock).change(lambda queue: ("move", {"item": 2, "to": 1, "by": BEN}))
        return super().change(decide)


@pytest.mark.parametrize("act", ["arm", "move", "remove", "attest", "decide"])
def test_an_act_in_view_of_a_queue_that_changes_meanwhile_changes_nothing(scene, files, act: str):
    for _ in range(2):
        add_item(scene, files)
    store, seen, now = BeatenStore(scene.folder, scene.clock), scene.queue().sequence, scene.clock.now_utc()
    acts = {
        "arm": lambda: people.arm(store, ANNA, now + HOUR, scene.world.boot(), now, expects=seen),
        "move": lambda: people.move(store, 1, 2, ANNA, expects=seen),
        "remove": lambda: people.remove(store, 1, ANNA, expects=seen),
        "attest": lambda: people.attest(store, ANNA, {"SN1": ""}, expects=seen),
        "decide": lambda: people.decide(store, 1, "drop", "why", ANNA, expects=seen),
    }
    with pytest.raises(RequestError, match=f"{act} was asked in view of another queue"):
        acts[act]()
    assert [event.kind for event in scene.queue().events] == ["add", "add", "move"]
