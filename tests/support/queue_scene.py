"""A queue with a world that a test makes: processes that begin, end and die at its word; a runner that is killed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import timedelta
from pathlib import Path

from journals import a_clock
from small_run import RIG

from procedures.queue import people
from procedures.queue.runner import Look, Runner
from procedures.queue.state import Attestation, Item, ItemState, Queue
from procedures.queue.store import QueueStore
from procedures.records.states import ACTIVE, State
from rig.clock import VirtualClock
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription

HOUR = timedelta(hours=1)
ANNA, BEN = "Anna", "Ben"
QueueFiles = tuple[Path, Path, RigDescription]
"""A procedure, a rig file, and what the latter says."""


class Killed(BaseException):
    """The runner, between two lines."""


@dataclass
class Process:
    """One that the runner started."""

    is_alive: bool = True
    run: Path | None = None
    state: State | None = None
    by: str = ""
    was_busy: bool = False
    has_ended: bool = False
    """Its run, though it lives."""
    of_start: int = 0
    """Which start of its item it is: the words of another one tell nothing of this one."""


@dataclass
class MadeWorld:
    """What a runner sees; every call may be its last."""

    clock: VirtualClock
    boots: int = 1
    busy_by: str = ""
    refused: tuple[str, ...] = ()
    is_guarded: bool = True
    processes: dict[int, Process] = field(default_factory=dict)
    started: list[tuple[int, str]] = field(default_factory=list)
    """Item, and ``start`` or ``resume``."""
    notes: list[tuple[Path, Attestation]] = field(default_factory=list)
    lives: int = 1_000_000
    """Calls before the runner is killed."""
    after_change: Callable[[], None] = lambda: None
    """What others do between a line that the runner has written and its next one."""

    def boot(self) -> str:
        return f"boot {self.boots}"

    def check(self, item: Item) -> Sequence[str]:
        self._pass()
        return self.refused

    def busy(self, item: Item) -> str:
        return self.busy_by

    def start(self, item: Item, by: str) -> None:
        self._pass()
        self._begin(item, Process(), "start")
        self._pass()

    def resume(self, item: Item, by: str, reason: str) -> None:
        self._pass()
        before = self.processes[item.number]
        self._begin(item, Process(run=before.run, state=before.state), "resume")
        self._pass()

    def look(self, item: Item) -> Look:
        self._pass()
        seen = self.processes.get(item.number)
        if seen is not None and seen.of_start != item.starts:
            seen = None if item.run == "" else Process(False, seen.run, seen.state, seen.by)
        if seen is None or (seen.run is None and not seen.is_alive):
            return Look(False, None, was_busy=seen is not None and seen.was_busy, said="")
        state = State.INTERRUPTED if not seen.is_alive and seen.state in ACTIVE else seen.state
        return Look(seen.is_alive, seen.run, state, "", seen.by, seen.has_ended)

    def is_stopped_by_something(self, item: Item) -> bool:
        return self.is_guarded

    def note(self, run: Path, attestation: Attestation) -> None:
        self._pass()
        self.notes.append((run, attestation))

    def alive(self) -> list[int]:
        return [number for number, running in self.processes.items() if running.is_alive]

    def _begin(self, item: Item, process: Process, kind: str) -> None:
        assert self.alive() == [], "two runs at once"
        process.of_start = item.starts + 1
        self.processes[item.number] = process
        self.started.append((item.number, kind))

    def _pass(self) -> None:
        self.lives -= 1
        if self.lives < 0:
            raise Killed


class FragileStore(QueueStore):
    """A store whose user may be killed before a change and after it."""

    world: MadeWorld

    def change(self, decide):  # type: ignore[no-untyped-def]
        self.world._pass()
        found = super().change(decide)
        self.world.after_change()
        self.world._pass()
        return found


@dataclass
class Scene:
    """The queue of one rig."""

    folder: Path
    clock: VirtualClock = field(default_factory=a_clock)

    def __post_init__(self) -> None:
        self.world = MadeWorld(self.clock)
        self.store = QueueStore(self.folder, self.clock)
        self.messages: list[str] = []
        self.rung: list[tuple[str, str]] = []
        """Word and sentences of what people who are not there were told."""
        self.new_runner()

    def new_runner(self) -> None:
        store = FragileStore(self.folder, self.clock)
        store.world = self.world
        self.runner = Runner(store, self.world, self.clock, self.messages.append, self._ring)

    def _ring(self, title: str, word: str, text: str) -> None:
        assert title == "a night"
        self.rung.append((word, text))

    def step(self, lives: int = 1_000_000) -> bool:
        """One look of the runner; True where it was killed in it, and another is begun."""
        self.world.lives = lives
        try:
            self.runner.step()
        except Killed:
            self.new_runner()
            return True
        return False

    def queue(self) -> Queue:
        return self.store.read()


def queue_files(folder: Path) -> QueueFiles:
    procedure, rig = folder / "procedure.toml", folder / "rig.toml"
    procedure.write_text("[procedure]\n")
    rig.write_text(RIG)
    return procedure, rig, read_rig(rig)


def add_item(scene: Scene, files: QueueFiles, by: str = ANNA, hours: float | None = None) -> Item:
    procedure, rig_file, rig = files
    until = None if hours is None else scene.clock.now_utc() + hours * HOUR
    return people.add(
        scene.store, procedure, rig_file, rig, scene.folder, by, title="a night",
        named_files=(), not_before_utc=None, not_after_utc=until, refused=[],
    )  # fmt: skip


def arm_queue(scene: Scene, by: str = ANNA, hours: float = 12.0) -> None:
    now = scene.clock.now_utc()
    people.arm(scene.store, by, now + hours * HOUR, scene.world.boot(), now)


def make_ready(scene: Scene, files: QueueFiles, count: int = 1) -> None:
    """So many items, attested and armed."""
    for _ in range(count):
        item = add_item(scene, files)
    people.attest(scene.store, ANNA, item.needs)
    arm_queue(scene)


def end_process(scene: Scene, number: int, state: State, by: str = "") -> None:
    seen = scene.world.processes[number]
    seen.is_alive, seen.state, seen.by, seen.run = False, state, by, seen.run or Path(f"/runs/{number}")


def steps(scene: Scene, count: int = 4) -> None:
    for _ in range(count):
        scene.step()


def state_of(scene: Scene, number: int = 1) -> ItemState:
    item = scene.queue().item(number)
    assert item is not None
    return item.state
