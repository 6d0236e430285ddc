"""An armed queue while nobody can leave a mark of having the rig: nothing starts, and whoever stops axes is told."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from full_machine_folder import MOUNTED, WAYS, MachineFolder, machine_folder_that_fills
from queue_scene import ANNA, Scene, arm_queue, end_process, make_ready, queue_files, steps
from small_disk import SmallDisk, small_disk

from procedures.errors import ProcedureError, RequestError
from procedures.queue import people
from procedures.queue.hands import ABORT, JOG_STOP, STOP, disarm_by_stop_of_rig, disarm_by_stop_of_run, heed_all
from procedures.queue.words import queue_lines
from procedures.records.states import State
from rig.errors import RigBusy
from rig.lines.lock import acquire, lock_folder

NO_ROOM = "takes no file: No space left on device"


@pytest.fixture(params=WAYS)
def machine(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[MachineFolder]:
    with machine_folder_that_fills(tmp_path, monkeypatch, request.param) as folder:
        yield folder


@pytest.fixture
def files(tmp_path: Path):
    (tmp_path / "files").mkdir()
    return queue_files(tmp_path / "files")


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    return Scene(tmp_path / "queues" / "queue")


def _told(scene: Scene) -> str:
    return "\n".join(queue_lines(scene.queue(), scene.world.boot(), scene.clock.now_utc()))


@pytest.mark.parametrize("what", [ABORT, STOP, JOG_STOP])
def test_fault_79_a_stop_that_leaves_no_mark_disarms_the_queues_of_its_account_all_the_same(
    machine: MachineFolder, scene: Scene, files, what: str
) -> None:
    make_ready(scene, files)
    machine.fill()
    disarmed, others = disarm_by_stop_of_rig(scene.folder.parent, files[1], what, scene.clock)
    assert "it is disarmed by this" in disarmed
    assert NO_ROOM in others
    assert "no queue of another account is told of this" in others
    machine.free()
    scene.new_runner()
    steps(scene)
    assert scene.world.started == []
    assert f"({what})" in _told(scene)
    assert scene.queue().attestation is not None, "a stop mounts nothing else"


def test_a_stop_of_another_rig_disarms_nothing(machine: MachineFolder, scene: Scene, files, tmp_path: Path) -> None:
    make_ready(scene, files)
    machine.fill()
    (tmp_path / "more").mkdir()
    (others,) = disarm_by_stop_of_rig(scene.folder.parent, queue_files(tmp_path / "more")[1], ABORT, scene.clock)
    assert "no queue of another account is told of this" in others
    assert scene.queue().arming is not None


def test_fault_79_no_runner_starts_what_a_use_would_not_stop(machine: MachineFolder, scene: Scene, files) -> None:
    """Whose stop it was cannot be told afterwards: another account's is seen by its mark alone."""
    make_ready(scene, files)
    machine.fill()
    steps(scene)
    machine.free()
    steps(scene)
    assert scene.world.started == []
    assert NO_ROOM in _told(scene).splitlines()[0]
    ((word, text),) = scene.rung
    assert (word, NO_ROOM in text) == ("disarmed", True)
    arm_queue(scene)
    steps(scene)
    assert scene.world.started == [(1, "start")], "somebody has looked, and armed it again"


def test_fault_79_no_runner_starts_what_became_unseen_behind_its_look(
    machine: MachineFolder, scene: Scene, files
) -> None:
    make_ready(scene, files)
    scene.world.after_change = machine.fill
    steps(scene, 1)
    scene.world.after_change = lambda: None
    machine.free()
    steps(scene)
    assert scene.world.started == []


def test_nothing_is_armed_while_no_use_would_be_seen(machine: MachineFolder, scene: Scene, files) -> None:
    make_ready(scene, files)
    people.disarm(scene.store, ANNA)
    machine.fill()
    with pytest.raises(RequestError, match=NO_ROOM):
        arm_queue(scene)
    assert scene.queue().arming is None


def test_a_run_of_the_queue_goes_on_and_the_next_waits_for_a_person(
    machine: MachineFolder, scene: Scene, files
) -> None:
    make_ready(scene, files, 2)
    steps(scene)
    machine.fill()
    steps(scene)
    end_process(scene, 1, State.FINISHED)
    machine.free()
    steps(scene)
    assert scene.world.started == [(1, "start")]


def test_a_mark_that_cannot_be_read_lets_nothing_start(scene: Scene, files) -> None:
    make_ready(scene, files)
    acquire([str(files[1])], "run").release()
    from_elsewhere = next(path for path in _marks(files) if "people" in path.name)
    from_elsewhere.write_text("")
    with pytest.raises(RequestError, match=r"who uses the rig cannot be seen: .* does not say who used the rig"):
        scene.step()
    assert scene.world.started == []


def _marks(files) -> list[Path]:
    return [path for path in lock_folder().glob("*.used") if str(files[1]) in path.read_text()]


@pytest.fixture
def both(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[MachineFolder, SmallDisk]]:
    with (
        machine_folder_that_fills(tmp_path, monkeypatch, MOUNTED) as machine,
        small_disk(tmp_path / "state", "256k") as disk,
    ):
        yield machine, disk


def test_fault_79_where_the_record_takes_nothing_either_a_stop_says_that_the_queue_is_armed(both, files) -> None:
    """Its runner starts nothing meanwhile, nor when there is room again."""
    disk = both[1]
    scene = Scene(disk.path / "queue")
    make_ready(scene, files)
    for full in both:
        full.fill()
    armed, others = disarm_by_stop_of_rig(disk.path, files[1], ABORT, scene.clock)
    assert armed.startswith("queue queue: IS STILL ARMED")
    assert "before hands go in end its runner" in armed
    assert NO_ROOM in others
    with pytest.raises(RigBusy, match=NO_ROOM):
        acquire([str(files[1])], "jog")
    with pytest.raises(ProcedureError, match="cannot be used"):
        scene.step()
    for full in both:
        full.free()
    steps(scene)
    assert scene.world.started == [], "it remembers"
    assert scene.queue().arming is None


def test_a_use_with_a_mark_is_not_lost_where_the_record_takes_nothing(both, files) -> None:
    disk = both[1]
    scene = Scene(disk.path / "queue")
    make_ready(scene, files)
    disk.fill()
    with acquire([str(files[1])], "jog"):
        (sentence,) = heed_all(disk.path, scene.clock)
    assert "its runner finds the mark of this before it starts anything" in sentence
    assert "STILL ARMED" not in sentence
    disk.free()
    steps(scene)
    assert scene.world.started == []


def test_a_stop_of_a_run_whose_rig_cannot_be_told_names_what_is_armed(scene: Scene, files, tmp_path: Path) -> None:
    make_ready(scene, files)
    (tmp_path / "no run").mkdir()
    unknown, armed = disarm_by_stop_of_run(scene.folder.parent, tmp_path / "no run", ABORT, scene.clock)
    assert "whose rig this is cannot be told" in unknown
    assert "IS STILL ARMED" in armed
    people.disarm(scene.store, ANNA)
    assert len(disarm_by_stop_of_run(scene.folder.parent, tmp_path / "no run", ABORT, scene.clock)) == 1
