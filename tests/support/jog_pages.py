"""Pages of a browser that jog a bench over a network that delays, cuts and hangs, all on one virtual clock.

The bench, its guard, its leases, its devices and their twins are the real ones; who is simulated are the people, their
pages, the network and the server. Whatever sleeps lets them live on, a hundredth of a second at a time.
"""

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import TypeVar, cast
from unittest.mock import patch

import numpy as np
from table_bench import rig_file
from turning_rig import QUICK_METER, STAGE_FOR_ROLL

from procedures.jog_screen.control import Control, Order
from procedures.jog_screen.guard import LOOK_S
from procedures.jog_screen.log import ActionLog, Snapshots
from procedures.jog_screen.served import TICK_S
from procedures.jog_screen.values import Asker, Home
from procedures.jog_screen.worker import Bench
from rig.abilities.abilities import Axis
from rig.assembly.open_rig import Rig, open_rig
from rig.clock import Clock, VirtualClock
from rig.description.read import read_rig
from rig.errors import RigError, WaitEnded
from rig.motion import out_of_reach
from rig.motion.move import stop_all
from rig.twins.physics.world import World

STEP_S = 0.01
LEVELS = ("roll", "pitch")
HAPPENINGS = (
    *("take", "press", "press", "press", "release", "goto", "step", "home", "stop", "leave", "give"),
    *("hang", "thaw", "cut", "close", "slow", "server", "forge", "nothing", "nothing"),
)
Choice = TypeVar("Choice")


def choice_of(choices: Sequence[Choice], chance: np.random.Generator) -> Choice:
    return choices[int(chance.integers(len(choices)))]


class StepClock(VirtualClock):
    """Virtual, but nobody sleeps through what happens meanwhile."""

    slice_s = 0.1

    def __init__(self) -> None:
        super().__init__(datetime(2026, 11, 24, tzinfo=UTC))
        self.happen: Callable[[], None] = lambda: None
        self._is_happening = False

    def sleep(self, duration_s: float) -> None:
        ends_s = self.monotonic_s() + duration_s
        while (left_s := ends_s - self.monotonic_s()) > 0.0:
            if left_s > STEP_S:
                super().sleep(STEP_S)
            else:
                self._elapsed_s = ends_s  # a sum would leave a rest for ever
            if not self._is_happening:  # a stop that waits for its answer lives inside what happened
                self._is_happening = True
                self.happen()
                self._is_happening = False


@dataclass
class Page:
    """Choice tab, who sits before it, and the network between it and the server."""

    asker: Asker
    press: int = 0
    held: dict[str, object] | None = None
    tick: int = 0
    is_hung: bool = False
    is_closed: bool = False
    is_cut: bool = False
    delay_s: float = 0.0
    sent: set[str] = field(default_factory=set)
    """Axes that it sent somewhere, and then neither stopped nor left."""
    down: deque[tuple[float, int]] = field(default_factory=deque)
    up: deque[tuple[float, Order]] = field(default_factory=deque)

    @property
    def is_there(self) -> bool:
        return not (self.is_hung or self.is_closed or self.is_cut)

    @property
    def wants(self) -> set[str]:
        """Axes that may move as long as it is there."""
        return self.sent | ({str(self.held["axis"])} if self.held else set())

    def say(self, now_s: float, **order: object) -> None:
        if self.is_there:
            self.up.append((now_s + self.delay_s, order))

    def beat(self, now_s: float, **more: object) -> None:
        self.say(now_s, say="beat", tick=self.tick, press=self.press, held=self.held, **more)


class JogScene:
    """The bench with its pages, and what was seen of its axes."""

    def __init__(self, bench: Bench, rig: Rig, clock: StepClock) -> None:
        self.bench, self.world, self.clock, self._axes = bench, cast("World", rig.chance), clock, rig.axes
        self.control = Control(bench, clock)
        self.pages: list[Page] = []
        self.is_server_hung = False
        self.there_s: dict[str, float] = {}
        """When somebody last wanted the axis to move, and was there."""
        self.driven_s = self.moving_s = 0.0
        """The longest that an axis was driven on, and moved at all, after the last that wanted it was there."""
        self._rates_dps: dict[str, float] = {}
        self.moved = 0
        self._held_up: deque[tuple[Page, Order]] = deque()
        self._pending: deque[Callable[[], None]] = deque()
        self._tick_due_s = self._look_due_s = 0.0
        self._can_stop = False
        self._is_judged = True
        self._number = 0
        clock.happen = self._happen
        bench.guard._begin = self._pending.append  # a thread of its own: it waits for the line, here for the owner
        wait = bench._wait

        def waited(duration_s: float, *, is_looking: bool = True) -> None:
            self._can_stop = True
            try:
                wait(duration_s, is_looking=is_looking)
            finally:
                self._can_stop = False

        bench._wait = waited  # type: ignore[method-assign]

    def begin(self, pages: int) -> None:
        """New tabs, nobody has the bench, every axis stands."""
        for page in self.pages:
            page.is_closed = True
            self.control.hear({"say": "gone"}, page.asker)
        self.is_server_hung = False
        self._held_up.clear()
        self.pages = []
        self.live(3.0)
        assert not self.moving(), "it moves, and nobody is there"
        self.there_s.clear()
        self._home()
        for _ in range(pages):
            self._number += 1
            self.pages.append(Page(Asker(f"tab-{self._number}", f"person {self._number}", "192.0.2.7")))

    def _home(self) -> None:
        """Home what a stop left without a home, from the terminal."""
        self._is_judged = False
        for axis, device in self._axes.items():
            while not device.state().is_homed:
                self.bench.ask(Home(axis))
                self.live(1.0)
        self._is_judged = True

    def live(self, duration_s: float) -> None:
        """Let the owner of the devices work for a while."""
        ends_s = self.clock.monotonic_s() + duration_s
        while self.clock.monotonic_s() < ends_s:
            before_s = self.clock.monotonic_s()
            self.bench._round()
            self._stop_now()
            if self.clock.monotonic_s() == before_s:
                self.clock.sleep(STEP_S)

    def moving(self) -> list[str]:
        now_s = self.clock.monotonic_s()
        return [name for name, body in self.world.axes.items() if body.rate_dps(now_s) != 0.0]

    def _stop_now(self) -> None:
        while self._pending:
            with suppress(WaitEnded):
                self._pending.popleft()()

    def _happen(self) -> None:
        now_s = self.clock.monotonic_s()
        if now_s >= self._tick_due_s:
            self._tick_due_s = now_s + TICK_S
            number = self.control.tick()
            self.control.look()
            for page in self.pages:
                if not self.is_server_hung and not page.is_cut:
                    page.down.append((now_s + page.delay_s, number))
        for page in self.pages:
            self._live_page(page, now_s)
        while self._held_up and not self.is_server_hung:
            page, order = self._held_up.popleft()
            self.control.hear(order, page.asker)
        if now_s >= self._look_due_s:
            self._look_due_s = now_s + LOOK_S
            self.bench.guard.look()
        if self._can_stop:
            self._can_stop = False
            self._stop_now()
            self._can_stop = True
        self._judge(now_s)

    def _live_page(self, page: Page, now_s: float) -> None:
        while page.down and page.down[0][0] <= now_s:
            _, number = page.down.popleft()
            if page.is_there:
                page.tick = max(page.tick, number)
                page.beat(now_s)
        while page.up and page.up[0][0] <= now_s:
            _, order = page.up.popleft()
            if not page.is_cut:
                self._held_up.append((page, order))
        self._see(page, now_s)

    def _see(self, page: Page, now_s: float) -> None:
        for axis in page.wants if page.is_there else ():
            self.there_s[axis] = now_s

    def _judge(self, now_s: float) -> None:
        for axis, body in self.world.axes.items():
            rate_dps, before_dps = abs(body.rate_dps(now_s)), self._rates_dps.get(axis, 0.0)
            self._rates_dps[axis] = rate_dps
            if rate_dps == 0.0 or not self._is_judged:
                continue
            self.moved += 1
            assert axis in self.there_s, f"{axis} moves, and nobody asked for it"
            late_s = now_s - self.there_s[axis]
            self.moving_s = max(self.moving_s, late_s)
            if rate_dps >= before_dps:  # one that slows down was told to stop
                self.driven_s = max(self.driven_s, late_s)

    # What people and networks do.

    def do(self, chance: np.random.Generator) -> str:
        """Have one thing happen; returns what."""
        now_s, having = self.clock.monotonic_s(), [page for page in self.pages if page.asker == self.control.holder]
        page = having[0] if having and chance.random() < 0.7 else choice_of(self.pages, chance)
        what, axis = choice_of(HAPPENINGS, chance), choice_of(LEVELS, chance)
        match what:
            case "take":
                page.say(now_s, say="take")
            case "press" if page.is_there:
                page.press += 1
                page.held = {"axis": "roll", "rate_dps": choice_of((-5.0, 2.0, 10.0), chance)}
                page.beat(now_s)
            case "release" if page.is_there:
                page.held = None
                page.beat(now_s)
            case "goto" | "step" | "home" if page.is_there:
                page.sent = page.sent | {axis}
                degrees = choice_of((-30.0, -2.0, 5.0, 40.0, 500.0), chance)
                page.say(now_s, say="do", act=what, axis=axis, degrees=degrees, tick=page.tick)
            case "stop":
                page.say(now_s, say="stop")
            case "leave" if page.is_there:
                page.held, page.sent = None, set()
                page.beat(now_s, away=True)
            case "give" if page.is_there:
                page.held, page.sent = None, set()
                page.say(now_s, say="give")
            case "hang":
                page.is_hung = True
            case "thaw":
                page.is_hung = False
            case "cut":
                page.is_cut = True
            case "close":
                page.is_closed = True
                self._held_up.append((page, {"say": "gone"}))
            case "slow":
                page.delay_s = choice_of((0.0, 0.02, 0.1, 2.0), chance)
            case "server":
                self.is_server_hung = not self.is_server_hung
            case "forge":  # a page that lies about what it saw
                page.say(now_s, say="beat", tick=10**9, press=page.press + 5, held={"axis": "pitch", "rate_dps": 3.0})
        self._see(page, now_s)
        return what


def _stop_one_after_the_other(axes: Mapping[str, Axis], clock: Clock) -> None:
    """What threads do at the same time elsewhere: tell every axis to stop, then see each stand."""
    for axis in axes.values():
        with suppress(RigError):
            axis.stop()
    for name, axis in axes.items():
        stop_all({name: axis}, clock)


@contextmanager
def jog_scene(folder: Path) -> Iterator[JogScene]:
    """A pitch table that positions and a roll stage that turns, both homed."""
    path, clock = rig_file(folder, QUICK_METER, STAGE_FOR_ROLL), StepClock()
    stops = patch.object(out_of_reach, "stop_all", _stop_one_after_the_other)
    with stops, open_rig(read_rig(path), clock=clock, rig_file=path) as rig:
        log = ActionLog(folder / "actions.jsonl", clock)
        bench = Bench(rig, log, Snapshots(folder / "snapshots.csv", clock), clock)
        bench.guard.close()  # its looks are made by the clock
        bench.guard._closing.clear()
        scene = JogScene(bench, rig, clock)
        try:
            yield scene
        finally:
            clock.happen = lambda: None
            log.close()
