"""The queue's table as a whole against a model of it, with a runner that is killed anywhere.

No item is started twice and none is lost; nothing starts disarmed, late, unmounted or beside another run.
"""

from pathlib import Path

import numpy as np
import pytest
from queue_scene import (
    ANNA,
    BEN,
    HOUR,
    Scene,
    add_item,
    arm_queue,
    end_process,
    queue_files,
)

from procedures.errors import RequestError
from procedures.queue import people
from procedures.queue.state import AT_WORK, ItemState
from procedures.records.states import State


class QueueWalk:
    """People, time, processes, power and a runner that is killed between any two lines, against a model of the law."""

    def __init__(self, location: Path, chance: np.random.Generator) -> None:
        self.chance, (self.chance_of_disarm,) = chance, chance.spawn(1)
        self.word_of = ""
        self.procedure, self.rig_file, rig = queue_files(location)
        section = rig.rig.model_copy(update={"resume_after_power_cut": True})
        self.rig = rig.model_copy(update={"rig": section})
        self.scene = Scene(location / "queue")
        self.armed_by = ""
        self.word_stands = False
        """Whether somebody armed it and nobody has disarmed it since; a power cut takes only the arming."""
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
        item = add_item(self.scene, (self.procedure, self.rig_file, self.rig), by, hours)
        self.allowed[item.number], self.windows[item.number] = ["start"], item.not_after_utc
        self.changed_by(by)

    def changed_by(self, by: str) -> None:
        self.word_stands = self.word_stands and by == self.word_of
        self.armed_by = self.armed_by if by == self.armed_by else ""

    def arm(self) -> None:
        by, hours = self.one_of(ANNA, ANNA, BEN), self.one_of(1.0, 8.0)
        try:
            arm_queue(self.scene, by, hours)
        except RequestError:
            return
        self.armed_by, self.armed_until = by, self.scene.clock.now_utc() + hours * HOUR
        self.boot = self.scene.world.boots
        self.word_of, self.word_stands = by, True

    def disarm(self) -> None:
        people.disarm(self.scene.store, BEN)
        self.armed_by, self.word_stands = "", False

    def attest(self) -> None:
        is_right = self.chance.random() < 0.9
        needs = people.needs_of(self.rig)
        may_arm = self.chance.random() < 0.9
        people.attest(self.scene.store, ANNA, needs if is_right else {"SN9": ""}, may_arm=may_arm)
        self.mounted, self.is_said_since = is_right, True
        if not may_arm:
            self.armed_by, self.word_stands = "", False

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
        self.changed_by(by)

    def remove(self) -> None:
        number = self.any_item()
        try:
            people.remove(self.scene.store, number, BEN)
        except RequestError:
            return
        self.allowed[number] = []
        self.changed_by(BEN)

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
                end_process(self.scene, number, State.FINISHED)
                self.mounted = self.mounted or not self.is_said_since
                return
            case "trips" | "stops":
                end_process(self.scene, number, State.TRIPPED if kind == "trips" else State.STOPPED)
            case "dies":
                end_process(self.scene, number, State.RUNNING)
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
                end_process(self.scene, number, State.RUNNING)
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
        undecided = bool(self.scene.queue().in_state(ItemState.UNDECIDED))
        world.after_change = self.disarm if self.chance_of_disarm.random() < 0.01 else lambda: None
        self.kills += self.scene.step(lives)
        world.after_change = lambda: None
        for number, kind in world.started[self.seen :]:
            allowed = self.allowed[number]
            self.is_said_since = False
            began, self.began[number] = self.began.get(number), world.boots
            if kind == "resume" and "resume" not in allowed:
                assert began != world.boots, "resumed by itself though the machine was not started anew"
                assert number in self.may_resume, "resumed by itself twice"
                self.may_resume.remove(number)
                assert self.word_stands, "resumed by itself though it was disarmed"
                assert self.scene.clock.now_utc() <= self.armed_until, "resumed by itself beyond what was said"
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
        for item in self.scene.queue().in_state(ItemState.UNDECIDED):
            self.allowed[item.number].clear()  # a start that was allowed and came to nothing is allowed no more

    def any_item(self) -> int:
        return int(self.chance.integers(1, max(len(self.allowed), 1) + 1))

    def undecided(self) -> int:
        waiting = self.scene.queue().in_state(ItemState.UNDECIDED)
        return waiting[0].number if waiting else self.any_item()

    def none_is_lost(self) -> None:
        queue = self.scene.queue()
        assert sorted(item.number for item in queue.items) == sorted(self.allowed)
        assert len(queue.in_state(*AT_WORK)) <= 1

    def whoever_lives_is_known_to_have_the_rig(self) -> None:
        at_work = [entry.number for entry in self.scene.queue().in_state(*AT_WORK)]
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
        location = folder / str(seed)
        location.mkdir()
        walk = QueueWalk(location, np.random.default_rng(seed))
        walk.walk(steps)
        kills, starts = kills + walk.kills, starts + len(walk.scene.world.started)
    return kills, starts


def test_the_table_holds_with_a_runner_that_is_killed_anywhere(tmp_path: Path):
    kills, starts = _walks(tmp_path, 3, 100)
    assert kills >= 8
    assert starts >= 3, "the walk must come to what it looks for"


@pytest.mark.soak
@pytest.mark.timeout(1200)
def test_the_table_holds_over_500_kills(tmp_path: Path):
    kills, starts = _walks(tmp_path, 100, 160)
    assert kills >= 500
    assert starts >= 200
