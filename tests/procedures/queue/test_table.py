"""The queue's table, line by line, and as a whole against a model of it with a runner that is killed anywhere.

No item is started twice and none is lost; nothing starts disarmed, late, unmounted or beside another run.
"""

import sqlite3
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from queue_scene import Process, Scene
from small_run import RIG

from procedures.errors import JournalError, RequestError
from procedures.queue import people
from procedures.queue.runner import BUSY_TOLD_S, SHUTDOWN
from procedures.queue.state import AT_WORK, Item, Place
from procedures.queue.store import FILE
from procedures.records.states import State
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription

HOUR = timedelta(hours=1)
ANNA, BEN = "Anna", "Ben"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, RigDescription]:
    return _files(tmp_path_factory.mktemp("files"))


def _files(folder: Path) -> tuple[Path, Path, RigDescription]:
    procedure, rig = folder / "procedure.toml", folder / "rig.toml"
    procedure.write_text("[procedure]\n")
    rig.write_text(RIG)
    return procedure, rig, read_rig(rig)


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    return Scene(tmp_path / "queue")


def _add(scene: Scene, files: tuple[Path, Path, RigDescription], by: str = ANNA, hours: float | None = None) -> Item:
    procedure, rig_file, rig = files
    until = None if hours is None else scene.clock.now_utc() + hours * HOUR
    return people.add(
        scene.store, procedure, rig_file, rig, scene.folder, by, title="a night",
        not_before_utc=None, not_after_utc=until, refused=[],
    )  # fmt: skip


def _arm(scene: Scene, by: str = ANNA, hours: float = 12.0) -> None:
    now = scene.clock.now_utc()
    people.arm(scene.store, by, now + hours * HOUR, scene.world.boot(), now)


def _ready(scene: Scene, files: tuple[Path, Path, RigDescription], count: int = 1) -> None:
    """So many items, attested and armed."""
    for _ in range(count):
        item = _add(scene, files)
    people.attest(scene.store, ANNA, item.needs)
    _arm(scene)


def _end(scene: Scene, number: int, state: State, by: str = "") -> None:
    seen = scene.world.processes[number]
    seen.is_alive, seen.state, seen.by, seen.run = False, state, by, seen.run or Path(f"/runs/{number}")


def _steps(scene: Scene, count: int = 4) -> None:
    for _ in range(count):
        scene.step()


def _place(scene: Scene, number: int = 1) -> Place:
    item = scene.queue().item(number)
    assert item is not None
    return item.place


def test_what_is_armed_and_mounted_starts_and_the_next_after_it(scene, files):
    _ready(scene, files, 2)
    _steps(scene)
    assert scene.world.started == [(1, "start")]
    _end(scene, 1, State.FINISHED)
    _steps(scene)
    assert (_place(scene, 1), scene.world.started) == (Place.FINISHED, [(1, "start"), (2, "start")])
    assert scene.world.notes[0][1].by == ANNA, "who attested it stands in the run"


def test_nothing_starts_disarmed_or_unattested(scene, files):
    item = _add(scene, files)
    _steps(scene)
    _arm(scene)
    _steps(scene)
    assert scene.world.started == []
    assert "waits for an attestation" in scene.told[0]
    people.attest(scene.store, ANNA, dict.fromkeys(item.needs, "B"))
    _steps(scene)
    assert scene.world.started == [], "another datum face"


@pytest.mark.parametrize("by", [ANNA, BEN])
def test_what_another_person_adds_or_reorders_disarms(scene, files, by: str):
    _ready(scene, files)
    _add(scene, files, by)
    assert scene.queue().is_armed(scene.world.boot(), scene.clock.now_utc()) == (by == ANNA)
    _arm(scene)
    people.move(scene.store, 2, 1, by)
    assert [one.number for one in scene.queue().items] == [2, 1]
    assert scene.queue().is_armed(scene.world.boot(), scene.clock.now_utc()) == (by == ANNA)


@pytest.mark.parametrize("state", [State.TRIPPED, State.FAILED, State.STOPPED, State.ABORTED, State.RUNNING])
def test_a_halt_disarms_and_waits_for_a_decision(scene, files, state: State):
    _ready(scene, files, 2)
    _steps(scene)
    _end(scene, 1, state)
    _steps(scene)
    assert (_place(scene), scene.queue().arming) == (Place.UNDECIDED, None)
    with pytest.raises(RequestError, match="item 1 needs a decision first"):
        _arm(scene)
    with pytest.raises(RequestError, match="needs a reason"):
        people.decide(scene.store, 1, "again", " ", ANNA)
    people.decide(scene.store, 1, "resume", "cable was loose", BEN)
    _steps(scene)
    assert scene.world.started == [(1, "start")], "decided, and not armed"
    _arm(scene)
    _steps(scene)
    assert scene.world.started == [(1, "start"), (1, "resume")]


@pytest.mark.parametrize(("choice", "started"), [("again", [(1, "start"), (1, "start")]), ("drop", [(1, "start")])])
def test_a_decision_measures_again_or_drops(scene, files, choice: str, started: list[tuple[int, str]]):
    _ready(scene, files)
    _steps(scene)
    _end(scene, 1, State.FAILED)
    _steps(scene)
    people.decide(scene.store, 1, choice, "table jammed", ANNA)
    if choice == "again":
        _arm(scene)
    _steps(scene)
    assert scene.world.started == started


def test_a_held_run_keeps_the_rig_and_what_waits_too_long_expires(scene, files):
    _ready(scene, files)
    _add(scene, files, hours=2.0)
    _steps(scene)
    scene.world.processes[1].run, scene.world.processes[1].state = Path("/runs/1"), State.HELD
    scene.clock.sleep(3 * 3600.0)
    _steps(scene)
    assert (_place(scene, 1), _place(scene, 2)) == (Place.RUNNING, Place.EXPIRED)
    _end(scene, 1, State.FINISHED)
    _steps(scene)
    assert scene.world.started == [(1, "start")]


def test_what_somebody_says_while_a_run_goes_on_is_newer_than_what_it_shows(scene, files):
    _ready(scene, files, 2)
    _steps(scene)
    people.attest(scene.store, BEN, {"SN9": "A"})
    _end(scene, 1, State.FINISHED)
    _steps(scene)
    assert scene.world.started == [(1, "start")]


def test_an_early_item_waits_for_its_time_and_those_behind_it_too(scene, files):
    procedure, rig_file, rig = files
    early = scene.clock.now_utc() + HOUR
    people.add(scene.store, procedure, rig_file, rig, scene.folder, ANNA, title="later", not_before_utc=early,
               not_after_utc=None, refused=[])  # fmt: skip
    _ready(scene, files)
    _steps(scene)
    assert scene.world.started == []
    scene.clock.sleep(3601.0)
    _steps(scene)
    assert scene.world.started == [(1, "start")]


def test_a_refused_item_stays_with_its_sentences_and_the_next_starts(scene, files):
    _ready(scene, files)
    scene.world.refused = ("procedure.toml: was changed since",)
    _steps(scene, 1)
    item = scene.queue().item(1)
    assert item is not None
    assert (item.place, item.told) == (Place.REFUSED, ("procedure.toml: was changed since",))
    scene.world.refused = ()
    _add(scene, files)
    _steps(scene)
    assert scene.world.started == [(2, "start")]


def test_a_busy_rig_is_waited_for_and_told_after_ten_minutes(scene, files):
    _ready(scene, files)
    scene.world.busy_by = "process 7 (jog)"
    _steps(scene)
    assert scene.told == []
    scene.clock.sleep(BUSY_TOLD_S)
    _steps(scene)
    assert scene.told == ["item 1 waits for the rig, which is in use by process 7 (jog)"]
    scene.world.busy_by = ""
    _steps(scene)
    assert scene.world.started == [(1, "start")]
    scene.world.processes[1] = Process(is_alive=False, was_busy=True, of_start=1)
    _steps(scene, 1)
    assert _place(scene) is Place.WAITING, "somebody was quicker"


@pytest.mark.parametrize("allows", [True, False])
@pytest.mark.parametrize("is_guarded", [True, False])
@pytest.mark.parametrize("state", [State.RUNNING, State.STOPPED])
def test_a_cold_start_resumes_once_where_the_rig_file_allows_it_and_something_stops_every_axis(
    scene, files, allows: bool, is_guarded: bool, state: State
):
    procedure, rig_file, rig = files
    section = rig.rig.model_copy(update={"resume_after_power_cut": allows})
    _ready(scene, (procedure, rig_file, rig.model_copy(update={"rig": section})), 2)
    _steps(scene)
    scene.world.boots, scene.world.is_guarded = 2, is_guarded
    _end(scene, 1, state, SHUTDOWN)
    _steps(scene)
    resumed = allows and is_guarded
    assert scene.world.started == [(1, "start")] + [(1, "resume")] * resumed
    if not resumed:
        assert _place(scene) is Place.UNDECIDED
        return
    scene.world.boots = 3
    _end(scene, 1, state, SHUTDOWN)
    _steps(scene)
    assert (_place(scene), len(scene.world.started)) == (Place.UNDECIDED, 2), "once"


def test_after_a_cold_start_nothing_new_starts_before_it_is_armed_again(scene, files):
    _ready(scene, files, 2)
    scene.world.boots = 2
    _steps(scene)
    assert scene.world.started == []
    assert (
        scene.queue().why_not_armed(scene.world.boot(), scene.clock.now_utc()) == "the machine was started anew since"
    )


def test_a_record_that_was_changed_starts_nothing(scene, files):
    _ready(scene, files)
    path = scene.folder / FILE
    with sqlite3.connect(path) as changed:
        changed.execute("UPDATE events SET detail = replace(detail, 'Anna', 'Mallory') WHERE kind = 'arm'")
    with pytest.raises(JournalError, match="event 3 is not what was written"):
        scene.step()
    assert scene.world.started == []


class QueueWalk:
    """People, time, processes, power and a runner that is killed between any two lines, against a model of the law."""

    def __init__(self, place: Path, chance: np.random.Generator) -> None:
        self.chance = chance
        self.procedure, self.rig_file, rig = _files(place)
        section = rig.rig.model_copy(update={"resume_after_power_cut": True})
        self.rig = rig.model_copy(update={"rig": section})
        self.scene = Scene(place / "queue")
        self.armed_by = ""
        self.armed_until = self.scene.clock.now_utc()
        self.allowed: dict[int, list[str]] = {}
        """Of each item: the starts that somebody allowed and that have not happened."""
        self.windows: dict[int, object] = {}
        self.began: dict[int, int] = {}
        """The start of the machine in which an item was last started or resumed."""
        self.may_resume: set[int] = set()
        """Items that were not resumed by themselves since they were started."""
        self.seen = 0
        self.mounted = self.is_said_since = False
        self.kills = 0

    def walk(self, steps: int) -> None:
        names = list(MOVES)
        weights = np.array([MOVES[name] for name in names], dtype=float)
        for _ in range(steps):
            getattr(self, names[self.chance.choice(len(names), p=weights / weights.sum())])()
            self.none_is_lost()
            self.whoever_lives_is_known_to_have_the_rig()

    def one_of(self, *values):
        return values[int(self.chance.integers(len(values)))]

    def add(self) -> None:
        by, hours = self.one_of(ANNA, ANNA, BEN), self.one_of(None, None, None, 3.0)
        item = _add(self.scene, (self.procedure, self.rig_file, self.rig), by, hours)
        self.allowed[item.number], self.windows[item.number] = ["start"], item.not_after_utc
        self.armed_by = self.armed_by if by == self.armed_by else ""

    def arm(self) -> None:
        by, hours = self.one_of(ANNA, ANNA, BEN), self.one_of(1.0, 8.0)
        try:
            _arm(self.scene, by, hours)
        except RequestError:
            return
        self.armed_by, self.armed_until = by, self.scene.clock.now_utc() + hours * HOUR
        self.boot = self.scene.world.boots

    def disarm(self) -> None:
        people.disarm(self.scene.store, BEN)
        self.armed_by = ""

    def attest(self) -> None:
        is_right = self.chance.random() < 0.9
        needs = people.needs_of(self.rig)
        people.attest(self.scene.store, ANNA, needs if is_right else {"SN9": ""})
        self.mounted, self.is_said_since = is_right, True

    def decide(self) -> None:
        choice = self.one_of("resume", "again", "drop")
        number = self.undecided()
        try:
            people.decide(self.scene.store, number, choice, "why", BEN)
        except RequestError:
            return
        self.allowed[number] += {"resume": ["resume"], "again": ["start"], "drop": []}[choice]

    def move(self) -> None:
        number, to, by = self.any_item(), self.any_item(), self.one_of(ANNA, BEN)
        try:
            people.move(self.scene.store, number, to, by)
        except RequestError:
            return
        self.armed_by = self.armed_by if by == self.armed_by else ""

    def remove(self) -> None:
        number = self.any_item()
        try:
            people.remove(self.scene.store, number, BEN)
        except RequestError:
            return
        self.allowed[number] = []

    def time_passes(self) -> None:
        hours = self.one_of(0.2, 0.5, 5.0)
        self.scene.clock.sleep(hours * 3600.0)

    def others(self) -> None:
        busy = self.one_of("", "", "", "jog")
        self.scene.world.busy_by = busy

    def a_process(self) -> None:
        if not self.scene.world.alive():
            return
        kind = self.one_of("begins", "finishes", "trips", "stops", "dies", "never begins", "was busy")
        (number,) = self.scene.world.alive()
        process = self.scene.world.processes[number]
        match kind:
            case "begins":
                process.run, process.state = process.run or Path(f"/runs/{number}"), State.HELD
                return
            case "finishes":
                _end(self.scene, number, State.FINISHED)
                self.mounted = self.mounted or not self.is_said_since
                return
            case "trips" | "stops":
                _end(self.scene, number, State.TRIPPED if kind == "trips" else State.STOPPED)
            case "dies":
                _end(self.scene, number, State.RUNNING)
            case "never begins" | "was busy":
                if process.run is not None:
                    return
                process.is_alive, process.was_busy = False, kind == "was busy"
                if kind == "was busy":
                    self.allowed[number].append("start")
                    return
        self.armed_by = ""

    def power_cut(self) -> None:
        world = self.scene.world
        for number in world.alive():
            process = world.processes[number]
            if process.run is None:
                process.is_alive = False
            else:
                _end(self.scene, number, State.RUNNING)
        world.boots += 1
        self.armed_by = ""
        self.scene.new_runner()

    def the_runner_is_killed(self) -> None:
        for _ in range(3):
            self._look(int(self.chance.integers(7)))

    def the_runner_looks(self) -> None:
        for _ in range(3):
            self._look(1_000_000)

    def _look(self, lives: int) -> None:
        world = self.scene.world
        undecided = bool(self.scene.queue().in_place(Place.UNDECIDED))
        self.kills += self.scene.step(lives)
        for number, kind in world.started[self.seen :]:
            allowed = self.allowed[number]
            self.is_said_since = False
            began, self.began[number] = self.began.get(number), world.boots
            if kind == "resume" and "resume" not in allowed:
                assert began != world.boots, "resumed by itself though the machine was not started anew"
                assert number in self.may_resume, "resumed by itself twice"
                self.may_resume.remove(number)
                continue
            assert kind in allowed, f"item {number}: {kind} twice, or never allowed"
            allowed.remove(kind)
            assert self.armed_by, "started disarmed"
            assert self.boot == world.boots, "started after a cold start"
            assert self.scene.clock.now_utc() <= self.armed_until, "started beyond what was said"
            assert not undecided
            if kind == "start":
                self.may_resume.add(number)
                assert self.mounted, "started unmounted"
                until = self.windows[number]
                assert until is None or self.scene.clock.now_utc() <= until, "started late"
        self.seen = len(world.started)

    def any_item(self) -> int:
        return int(self.chance.integers(1, max(len(self.allowed), 1) + 1))

    def undecided(self) -> int:
        waiting = self.scene.queue().in_place(Place.UNDECIDED)
        return waiting[0].number if waiting else self.any_item()

    def none_is_lost(self) -> None:
        queue = self.scene.queue()
        assert sorted(one.number for one in queue.items) == sorted(self.allowed)
        assert len(queue.in_place(*AT_WORK)) <= 1

    def whoever_lives_is_known_to_have_the_rig(self) -> None:
        at_work = [one.number for one in self.scene.queue().in_place(*AT_WORK)]
        assert set(self.scene.world.alive()) <= set(at_work)


MOVES = {
    "the_runner_is_killed": 30, "the_runner_looks": 10, "a_process": 36, "arm": 30, "attest": 16, "add": 14,
    "decide": 24, "time_passes": 2, "others": 3, "power_cut": 3, "disarm": 1, "move": 1, "remove": 1,
}  # fmt: skip
"""What happens, and how often."""


def _walks(folder: Path, count: int, steps: int) -> tuple[int, int]:
    """So many walks, each with its seed; how often the runner was killed, and how much was started."""
    kills = starts = 0
    for seed in range(count):
        place = folder / str(seed)
        place.mkdir()
        walk = QueueWalk(place, np.random.default_rng(seed))
        walk.walk(steps)
        kills, starts = kills + walk.kills, starts + len(walk.scene.world.started)
    return kills, starts


def test_the_table_holds_with_a_runner_that_is_killed_anywhere(tmp_path: Path):
    kills, starts = _walks(tmp_path, 3, 100)
    assert kills >= 8
    assert starts >= 3, "the walk must come to what it looks for"


@pytest.mark.soak
def test_the_table_holds_over_500_kills(tmp_path: Path):
    kills, starts = _walks(tmp_path, 100, 160)
    assert kills >= 500
    assert starts >= 200
