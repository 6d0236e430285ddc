"""Anything may be asked of a run, and anything may happen to its rig, in any order: start, pause, resume, stop, abort,
jog, stop button, unplug, replug, power loss, kill. Whatever the order, the states follow the table, what is stored
stays, nothing moves outside its limits, and nothing moves where nobody runs anything."""

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import replace
from datetime import datetime
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from asking import put
from device_sets import SHORTER, device_set
from fault_scripts import require_inside_limits, require_rest
from faulty_rig import FaultyRig
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule, run_state_machine_as_test
from journals import a_clock
from killing import run_child
from resumed import resume_on
from small_run import Bench, dwells_of, measured

from procedures.errors import RequestError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.spool import Spool
from procedures.journal.status.status import status
from procedures.journal.storage import JOURNAL_FILE
from procedures.records.progress import Progress
from procedures.records.states import ANSWERED_FOR, RESUMABLE, State, require_transition
from procedures.run.begin import begin
from procedures.run.ending import Outcome
from rig.abilities.abilities import AxisState
from rig.assembly.open_rig import Rig, open_rig
from rig.clock import Clock
from rig.errors import LinkLost, RequestRefused, RigBusy
from rig.link.byte_stream import ByteStream
from rig.motion.jog import jog_to
from rig.motion.move import home_and_arrive

HAPPENINGS = ("pause", "stop", "abort", "note", "unplug", "stop button", "jog", "resume")
RESTS_BEFORE_HELP, RESTS_BEFORE_STOP = 20, 150
EXAMPLES, MORE_EXAMPLES, STEPS = 4, 12, 6


class Plug:
    """The cables of a rig: a line source whose lines can be pulled out together."""

    def __init__(self) -> None:
        self.is_out = False

    def source(self, key: str, open_line: Callable[[], ByteStream]) -> ByteStream:
        self.require_in(key)
        return _Line(key, open_line(), self)

    def require_in(self, key: str) -> None:
        if self.is_out:
            raise LinkLost(f"{key}: unplugged; check the cable")


class _Line:
    def __init__(self, key: str, line: ByteStream, plug: Plug) -> None:
        self.name, self.clock = line.name, line.clock
        self._key, self._line, self._plug = key, line, plug

    def write(self, data: bytes) -> None:
        self._plug.require_in(self._key)
        self._line.write(data)

    def read(self, deadline_s: float) -> bytes:
        self._plug.require_in(self._key)
        return self._line.read(deadline_s)

    def discard_input(self) -> bytes:
        self._plug.require_in(self._key)
        return self._line.discard_input()

    def close(self) -> None:
        self._line.close()


class Bystander:
    """A person's clock and the run's observer: lets things happen at chosen moments, and helps out afterwards."""

    slice_s = 0.1
    factor = 1.0

    def __init__(self, world: "RunAndRig", script: Mapping[int, str]) -> None:
        self._world, self._script = world, dict(script)
        self._clock, self._events, self._rests = a_clock(), 0, 0

    def on_event(self, progress: Progress) -> None:
        self._events += 1
        if (happening := self._script.pop(self._events, None)) is not None:
            self._world.happen(happening, self.now_utc(), is_over=progress.dwells_done == progress.dwells_planned)

    def sleep(self, duration_s: float) -> None:
        """The run stands still: plug in again and say continue, and after long enough stop it."""
        self._clock.sleep(duration_s)
        self._rests += 1
        if self._rests % RESTS_BEFORE_HELP == 0:
            self._world.plug.is_out = False
            self._world.ask("stop" if self._rests > RESTS_BEFORE_STOP else "continue", self.now_utc())

    def monotonic_s(self) -> float:
        return self._clock.monotonic_s()

    def boottime_s(self) -> float:
        return self._clock.boottime_s()

    def now_utc(self) -> datetime:
        return self._clock.now_utc()


class RunAndRig(RuleBasedStateMachine):
    """One run on one rig of twins; ``bench`` and ``clean`` are set by the test."""

    bench: Bench
    clean: Mapping[int, tuple[object, ...]]

    def __init__(self) -> None:
        super().__init__()
        self.opened = ExitStack()
        folder = Path(self.opened.enter_context(TemporaryDirectory(prefix="calrig-machine-")))
        self.run_dir, self.plug, self.is_pressed = folder / "run", Plug(), False
        self.run_dir.mkdir()
        rig_file = self.bench.folder / "rig.toml"
        self.rig: Rig = self.opened.enter_context(
            open_rig(self.bench.rig, rig_file=rig_file, line_source=self.plug.source)
        )
        self.faulty_rig = FaultyRig(self.rig, look=self._look)
        self.stored: list[str] = []
        self.was_pressed = False

    def teardown(self) -> None:
        self.opened.close()

    def _look(self, state: AxisState) -> AxisState:
        return replace(state, fault="stop button") if self.is_pressed else state

    @property
    def state(self) -> State | None:
        return status(self.run_dir).state if (self.run_dir / JOURNAL_FILE).exists() else None

    def ask(self, kind: str, now_utc: datetime) -> None:
        put(Spool(self.run_dir), kind, "bert", "please", now_utc.isoformat())

    def happen(self, what: str, now_utc: datetime, *, is_over: bool) -> None:
        """While the run runs. What is pressed when everything is measured stops nothing any more."""
        if what == "unplug":
            self.plug.is_out = True
        elif what == "stop button":
            self.is_pressed, self.was_pressed = True, not is_over
        elif what == "jog":
            with pytest.raises(RigBusy):
                open_rig(self.bench.rig, rig_file=self.bench.folder / "rig.toml")
        elif what == "resume":
            with pytest.raises(RequestError, match="the run belongs to process"):
                resume_on(self.run_dir, self.faulty_rig, "eve", "impatient")
        else:
            self.ask(what, now_utc)

    def _work(self, seen: Bystander) -> Outcome:
        if self.state is None:
            return begin(self.run_dir, self.bench.header(self.run_dir), self.bench.plan, self.faulty_rig, seen, seen)
        return resume_on(self.run_dir, self.faulty_rig, "ann", "looked at it", seen, seen)

    def _is_workable(self) -> bool:
        return self.state is None or self.state in RESUMABLE

    @precondition(_is_workable)
    @rule(script=st.dictionaries(st.integers(1, 25), st.sampled_from(HAPPENINGS), max_size=2))
    def start_or_resume(self, script: dict[int, str]) -> None:
        self.plug.is_out = self.is_pressed = self.was_pressed = False
        outcome = self._work(Bystander(self, script))
        assert outcome.state is self.state
        if self.was_pressed and not self.plug.is_out:
            assert outcome.state in (State.TRIPPED, State.ABORTED, State.STOPPED, State.FAILED), outcome
        require_rest(self.rig, outcome)
        self.plug.is_out = self.is_pressed = False

    @precondition(_is_workable)
    @rule(passage=st.integers(1, 400))
    def die(self, passage: int) -> None:
        """The process is killed at some place; the rig of this process was never touched by it."""
        self.plug.is_out = self.is_pressed = False
        run_child(lambda seen: self._work(Bystander(self, {})), f"any:{passage}")

    @precondition(lambda self: self.state in ANSWERED_FOR)
    @rule()
    def resume_without_a_reason(self) -> None:
        with pytest.raises(RequestError, match="a person has to look first"):
            resume_on(self.run_dir, self.faulty_rig, "", "")

    @precondition(lambda self: self.state in (State.FINISHED, State.FAILED))
    @rule()
    def resume_what_has_ended(self) -> None:
        with pytest.raises(RequestError, match="and resume takes"):
            resume_on(self.run_dir, self.faulty_rig, "ann", "wants more")

    @rule(axis=st.sampled_from(("pitch", "roll")), target_deg=st.integers(-400, 400))
    def jog(self, axis: str, target_deg: int) -> None:
        """By hand between two stretches; the rig is this process' own."""
        clock: Clock = self.rig.clock
        if not self.rig.axes[axis].state().is_homed:
            home_and_arrive(self.rig.axes[axis], clock, clock.sleep)
        if abs(target_deg) > 180:
            with pytest.raises(RequestRefused, match="outside the limits"):
                jog_to(self.rig, axis, target_deg, clock.sleep)
        else:
            assert jog_to(self.rig, axis, target_deg, clock.sleep) == target_deg

    @invariant()
    def nothing_stored_is_lost_or_changed(self) -> None:
        if self.state is None:
            return
        dwells = dwells_of(self.run_dir)
        found = [dwell.sha256 for dwell in dwells]
        assert found[: len(self.stored)] == self.stored
        self.stored = found
        if self.state is State.FINISHED:
            assert measured(dwells) == self.clean

    @invariant()
    def states_follow_the_table(self) -> None:
        if self.state is None:
            return
        with JournalReader.open(self.run_dir) as reader:
            entered = [State(str(event.detail["to"])) for event in reader.events("state")]
        assert entered[0] is State.PLANNED
        for before, after in pairwise(entered):
            require_transition(before, after)

    @invariant()
    def nothing_was_sent_outside_its_limits(self) -> None:
        require_inside_limits(self.rig)


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> type[RunAndRig]:
    folder = tmp_path_factory.mktemp("machine")
    bench = device_set("table-3458a", folder, SHORTER)
    assert bench.run(folder / "clean").state is State.FINISHED
    return type("RunAndRig", (RunAndRig,), {"bench": bench, "clean": measured(dwells_of(folder / "clean"))})


def _settings(examples: int, steps: int) -> settings:
    return settings(
        max_examples=examples,
        stateful_step_count=steps,
        deadline=None,
        derandomize=True,
        database=None,
        phases=[Phase.generate],  # a story of few steps is read as it is; shrinking it costs minutes
        suppress_health_check=list(HealthCheck),
    )


@pytest.mark.timeout(600)
@pytest.mark.parametrize("examples", [EXAMPLES, pytest.param(MORE_EXAMPLES, marks=pytest.mark.thorough)])
def test_whatever_is_asked_in_whatever_order_the_run_keeps_its_promises(
    machine: type[RunAndRig], examples: int
) -> None:
    run_state_machine_as_test(machine, settings=_settings(examples, STEPS))


@pytest.mark.soak
@pytest.mark.timeout(7200)
def test_four_hundred_long_stories_keep_their_promises(machine: type[RunAndRig]) -> None:
    run_state_machine_as_test(machine, settings=settings(_settings(400, 15), derandomize=False))
