"""The world of a runner as files and locks have it: a run that ended while its process goes on to ring."""

import subprocess
import sys
import threading
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import pytest
from guarded_engine import until
from queue_scene import ANNA, Scene, add_item, arm_queue, queue_files
from small_run import bench

from procedures.alerts.dispatcher import AlertDispatcher
from procedures.alerts.settings import AlertSettings, Escalation
from procedures.cli.run.attend import ring_out
from procedures.errors import RequestError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.corrections import is_acknowledged
from procedures.queue import people
from procedures.queue.hands import heed
from procedures.queue.state import Item, ItemState
from procedures.queue.world import RigWorld
from procedures.records.progress import Progress, SilentObserver
from procedures.records.states import State
from rig import file_lock
from rig.clock import SystemClock
from rig.lines.lock import uses

NOBODY = (sys.executable, "-c", "")


class Fails:
    """An observer that ends the run after three dwells as a defect of ours would."""

    def __init__(self, dispatcher: AlertDispatcher) -> None:
        self._dispatcher = dispatcher

    def on_event(self, progress: Progress) -> None:
        self._dispatcher.on_event(progress)
        if progress.dwells_done == 3:
            raise ZeroDivisionError("of ours")


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    """An item that was started, with what it needs."""
    (tmp_path / "files").mkdir()
    scene = Scene(tmp_path / "queue")
    item = add_item(scene, queue_files(tmp_path / "files"))
    people.attest(scene.store, ANNA, item.needs)
    arm_queue(scene)
    return scene


def test_a_decision_ends_the_ringing_of_a_run_that_ended(scene: Scene, tmp_path: Path) -> None:
    clock, run = SystemClock(), tmp_path / "run"
    settings = AlertSettings(command=NOBODY, escalate=Escalation(after_min=60.0, command=NOBODY))
    dispatcher = AlertDispatcher(settings, "night", clock, SilentObserver())
    with pytest.raises(ZeroDivisionError):
        bench(tmp_path).run(run, observer=Fails(dispatcher))
    world = RigWorld(scene.folder, clock, lambda _rig: [])
    item = _recorded(scene, run)
    with (scene.folder / "item-1.lock").open("a+", encoding="utf-8") as lock:
        assert file_lock.take(lock, clock, 5)
        rings = threading.Thread(target=ring_out, args=(run, dispatcher), daemon=True)
        rings.start()
        # A command of the alarm that was forked while the run had its lock holds it too until it is its own program.
        assert until(lambda: world.look(item).has_ended, 10.0)
        seen = world.look(item)
        assert (seen.is_alive, seen.has_ended, seen.state) == (True, True, State.FAILED)
        of_a_start_that_has_not_had_the_run = replace(item, started_utc=clock.now_utc() + timedelta(hours=1))
        assert not world.look(of_a_start_that_has_not_had_the_run).has_ended
        scene.store.change(lambda _queue: ("ended", {"item": 1, "state": "failed", "reason": "of ours"}))
        assert not is_acknowledged(run)
        people.decide(scene.store, 1, "again", "mended", ANNA)
        rings.join(20.0)
        assert not rings.is_alive(), "somebody knows"
        assert world.busy(item) == "an earlier process of the item, which has not ended yet"
    assert world.busy(item) == ""
    with JournalReader.open(run) as reader:
        known = reader.last_event("ack")
    assert known is not None
    assert (known.detail["by"], known.detail["via"]) == (ANNA, "queue")
    assert known.detail["text"] == "decided in the queue: again, mended"


def test_a_decision_that_is_refused_acknowledges_nothing(scene: Scene, tmp_path: Path) -> None:
    dispatcher = AlertDispatcher(AlertSettings(), "night", SystemClock(), SilentObserver())
    with pytest.raises(ZeroDivisionError):
        bench(tmp_path).run(tmp_path / "run", observer=Fails(dispatcher))
    _recorded(scene, tmp_path / "run")
    with pytest.raises(RequestError, match="item 1 is running"):
        people.decide(scene.store, 1, "again", "mended", ANNA)
    assert not is_acknowledged(tmp_path / "run")


def test_a_process_of_the_queue_that_has_the_rig_is_no_use_from_outside(scene: Scene, tmp_path: Path) -> None:
    """It says whose it is; the same process begun by a person ends what is armed."""
    takes_rig = (sys.executable, "-c", "import sys; from rig.lines.lock import acquire; acquire([sys.argv[4]], 'run')")
    item, clock = scene.queue().items[0], SystemClock()
    world = RigWorld(scene.folder, clock, lambda _rig: [], command=takes_rig)
    world.start(item, ANNA)
    assert [child.wait(60.0) for child in world._children] == [0]
    assert [use.queue for use in uses(item.resources)] == [str(scene.folder)]
    assert heed(scene.store).arming is not None
    subprocess.run([*takes_rig, "run", item.procedure.path, "--rig", item.rig.path], check=True)
    assert heed(scene.store).arming is None


def _recorded(scene: Scene, run: Path) -> Item:
    """The item as the runner has it after its run began."""
    scene.store.change(lambda _queue: ("start", {"item": 1, "boot": "boot 1"}))
    item = scene.store.change(lambda _queue: ("began", {"item": 1, "run": str(run)})).item(1)
    assert item is not None
    assert item.state is ItemState.RUNNING
    return item
