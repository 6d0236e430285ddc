"""Wherever a run stands still, axes and interlocks are looked at as between two dwells."""

from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pytest
from faulty_rig import FaultyRig, noisier
from small_run import Bench, bench, dwells_of
from unattended_run import UnattendedRun, asks, events, run_unattended, states

from procedures.journal.header import make_header
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.records.progress import AT_REST, Progress
from procedures.records.states import State
from procedures.run.begin import begin
from rig.abilities.abilities import AxisState, Burst
from rig.assembly.open_rig import Rig, open_rig
from rig.description.read import read_rig
from rig.errors import LinkLost
from rig.motion.supervisor import SupervisedAxis
from rig.twins.manual import HANDLING_S
from rig.twins.physics.world import World

SERVOS = Path(__file__).parents[3] / "examples" / "servo-mechanism"
CHECKS = "[check]"
MOVED = "roll: was moved, though nothing told it to: left at"
SOON = 100
"""Rests: five looks of a run that stands still."""
BAND = "[interlocks.temperature.air]\nband_degc = [18.0, 22.0]\nhysteresis_degc = 0.3\ndelay_s = 10.0\n[twin]"
PLATEAU = "[environment]\nplateaus_degc = [30.0]\nsoak_s = 7200.0\nband_degc = 1.0\n[check]"


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench(tmp_path_factory.mktemp("bench"))


def _world(unattended: UnattendedRun) -> World:
    chance = unattended.rig.chance
    assert isinstance(chance, World)
    return chance


def _another_hand(unattended: UnattendedRun) -> None:
    _world(unattended).slip("roll", 75.0, unattended.rig.clock.monotonic_s(), seen=True)


def _warm(degc: float) -> Callable[[UnattendedRun], None]:
    return lambda unattended: _world(unattended).disturb("air", degc, unattended.rig.clock.monotonic_s())


def _require_trip_soon(unattended: UnattendedRun, standing: str, sentence: str) -> None:
    assert states(unattended.run_dir)[-2:] == [standing, "tripped"]
    assert sentence in str(events(unattended.run_dir, "state")[-1].detail["reason"])
    assert unattended.rests < SOON


def test_fault_52_an_axis_that_another_hand_moves_in_a_pause_trips(small: Bench, tmp_path: Path) -> None:
    unattended = UnattendedRun(tmp_path / "run", after={4: asks("pause")}, at={10: _another_hand})
    assert run_unattended(small, unattended).state is State.TRIPPED
    _require_trip_soon(unattended, "paused", MOVED)


def test_fault_52_an_axis_that_another_hand_moves_in_a_hold_for_a_person_trips(small: Bench, tmp_path: Path) -> None:
    def noisy(number: int, burst: Burst) -> Burst:
        return noisier(burst, 50.0) if number > 60 else burst

    unattended = UnattendedRun(tmp_path / "run", at={10: _another_hand})
    outcome = run_unattended(small, unattended, rig_of=lambda rig: FaultyRig(rig, spoil=noisy))
    assert outcome.state is State.TRIPPED
    _require_trip_soon(unattended, "held", MOVED)


def test_fault_52_an_axis_that_another_hand_moves_in_a_hold_by_an_interlock_trips(tmp_path: Path) -> None:
    small = bench(tmp_path, rig=(("[twin]", BAND),))
    unattended = UnattendedRun(tmp_path / "run", after={4: _warm(30.0)}, at={10: _another_hand})
    assert run_unattended(small, unattended).state is State.TRIPPED
    _require_trip_soon(unattended, "held", MOVED)


def test_what_holds_a_run_is_told_by_the_band_that_is_left_now(tmp_path: Path) -> None:
    """The room is left while the air holds the run, and still left when the air is back."""
    both = "".join(f"[interlocks.temperature.{name}]\nband_degc = [18.0, 22.0]\n" for name in ("air", "room"))
    room = '[environment.room]\ndriver = "watlow-f4"\nport = "twin"\n'
    small = bench(tmp_path, rig=(("[twin]", f"{room}{both}[twin]"),))

    def warm_room(degc: float) -> Callable[[UnattendedRun], None]:
        return lambda unattended: _world(unattended).disturb("room", degc, unattended.rig.clock.monotonic_s())

    unattended = UnattendedRun(
        tmp_path / "run",
        after={4: _warm(30.0)},
        at={50: warm_room(30.0), 100: _warm(20.0), 300: warm_room(20.0)},
    )
    assert run_unattended(small, unattended).state is State.FINISHED
    held = [event for event in events(unattended.run_dir, "state") if event.detail["to"] == "held"]
    assert [str(event.detail["reason"]).partition(":")[0] for event in held] == ["environment.air", "environment.room"]
    assert not [
        event for event in events(unattended.run_dir, "dwell") if held[0].sequence < event.sequence < held[1].sequence
    ]


class SoakSeen(UnattendedRun):
    """Something happens when a soak begins, and somebody writes down when that was."""

    def __init__(self, run_dir: Path, in_soak: Callable[[UnattendedRun], None], after: int) -> None:
        super().__init__(run_dir, after={after: self._leave_band} if after else {})
        self._in_soak, self._soaks, self._wanted = in_soak, 0, 2 if after else 1
        self.began_s = 0.0

    def _leave_band(self, unattended: UnattendedRun) -> None:
        _world(unattended).air["air"].hold(20.0, unattended.rig.clock.monotonic_s())
        unattended.rig.clock.sleep(3600.0)

    def on_event(self, progress: Progress) -> None:
        super().on_event(progress)
        self._soaks += progress.event == "soak"
        if progress.event == "soak" and self._soaks == self._wanted:
            self.began_s = self.rig.clock.monotonic_s()
            self._in_soak(self)


@pytest.mark.parametrize(("after", "standing"), [(0, "checking"), (4, "held")])
def test_fault_52_an_axis_that_another_hand_moves_in_a_soak_trips_at_once(
    tmp_path: Path, after: int, standing: str
) -> None:
    """The first, and the one in which a lost plateau is waited for."""
    small = bench(tmp_path, procedure=((CHECKS, PLATEAU),))
    unattended = SoakSeen(tmp_path / "run", _another_hand, after)
    assert run_unattended(small, unattended).state is State.TRIPPED
    _require_trip_soon(unattended, standing, MOVED)
    assert unattended.rig.clock.monotonic_s() - unattended.began_s < 60.0, "and not at the end of two hours"


def test_fault_65_an_interlock_that_trips_does_so_in_a_pause_after_its_delay(tmp_path: Path) -> None:
    small = bench(tmp_path, rig=(("[twin]", BAND.replace("[twin]", 'action = "trip"\n[twin]')),))
    unattended = UnattendedRun(tmp_path / "run", after={4: asks("pause")}, at={10: _warm(28.0)})
    assert run_unattended(small, unattended).state is State.TRIPPED
    _require_trip_soon(unattended, "paused", "allowed 18 to 22 °C (rig file: interlocks.temperature.air)")


def test_fault_65_an_interlock_that_holds_takes_back_in_a_pause_and_tells_once(tmp_path: Path) -> None:
    """The band is left before the pause and kept again before it ends: nobody could tell it at ``continue``."""
    small = bench(tmp_path, rig=(("[twin]", BAND.replace("delay_s = 10.0", "delay_s = 40.0")),))

    unattended = UnattendedRun(
        tmp_path / "run", after={4: _warm(30.0), 16: asks("pause")}, at={200: _warm(20.0), 900: asks("continue")}
    )
    assert run_unattended(small, unattended).state is State.FINISHED
    assert states(unattended.run_dir)[3:] == ["paused", "running", "finished"]
    (told,) = events(unattended.run_dir, AT_REST)
    assert "the run stands still, and does not go on before it is over" in str(told.detail["text"])
    (void,) = events(unattended.run_dir, "voided")
    assert void.detail["dwells"]
    counted = [dwell for dwell in dwells_of(unattended.run_dir) if dwell.accepted and dwell.purpose == "design"]
    assert all(17.9 < dwell.temperature_degc["air"] < 22.1 for dwell in counted)
    assert len(counted) == len(small.plan.design_dwells)


class Struck(FaultyRig):
    """What happens to the pitch axis while the run is paused."""

    def __init__(self, rig: Rig, unattended: UnattendedRun, strike: Callable[[AxisState], AxisState]) -> None:
        super().__init__(rig, look=self._struck)
        self._unattended, self._strike, self.strikes = unattended, strike, 0

    def _struck(self, state: AxisState) -> AxisState:
        heard = self._unattended.heard
        if not heard or heard[-1].state is not State.PAUSED:
            return state
        self.strikes += 1
        return self._strike(state)


def _paused(run_dir: Path) -> UnattendedRun:
    return UnattendedRun(run_dir, after={4: asks("pause")}, at={300: asks("continue")})


def test_a_digit_that_a_line_turns_over_in_a_pause_is_asked_again(small: Bench, tmp_path: Path) -> None:
    unattended = _paused(tmp_path / "run")
    lies = [40.0]

    def lie(state: AxisState) -> AxisState:
        return replace(state, position_deg=state.position_deg + (lies.pop() if lies else 0.0))

    outcome = run_unattended(small, unattended, rig_of=lambda rig: Struck(rig, unattended, lie))
    assert outcome.state is State.FINISHED
    (noted,) = events(unattended.run_dir, "unconfirmed")
    assert "pitch: was moved, though nothing told it to" in str(noted.detail["told"])


def _silent(_state: AxisState) -> AxisState:
    raise LinkLost("axes.pitch at twin: gone")


def _homeless(state: AxisState) -> AxisState:
    return replace(state, is_homed=False)


@pytest.mark.parametrize("strike", [_silent, _homeless])
def test_fault_21_a_line_or_a_home_that_is_lost_in_a_pause_moves_nothing_before_somebody_says_continue(
    small: Bench, tmp_path: Path, strike: Callable[[AxisState], AxisState]
) -> None:
    unattended = _paused(tmp_path / "run")
    rigs: list[Struck] = []

    def rig_of(rig: Rig) -> Struck:
        rigs.append(Struck(rig, unattended, strike))
        return rigs[0]

    assert run_unattended(small, unattended, rig_of=rig_of).state is State.FINISHED
    assert states(unattended.run_dir)[3:] == ["paused", "running", "held", "checking", "running", "finished"]
    (told,) = events(unattended.run_dir, AT_REST)
    assert "a new epoch begins when somebody says continue, by homing" in str(told.detail["text"])
    assert any(progress.event == AT_REST for progress in unattended.heard)
    assert rigs[0].strikes >= 3
    assert strike is _homeless or rigs[0].strikes <= 10, "with growing pauses where it does not answer"


def test_fault_21_a_line_that_is_lost_in_a_hold_begins_a_new_epoch(tmp_path: Path) -> None:
    """Nobody is waited for: the hold by the air ends as one by the line."""
    small = bench(tmp_path, rig=(("[twin]", BAND),))
    unattended = UnattendedRun(tmp_path / "run", after={4: _warm(30.0)}, at={400: _warm(20.0)})
    gone = [LinkLost("axes.pitch at twin: gone")]

    def look(state: AxisState) -> AxisState:
        if gone and unattended.rests > 50:
            raise gone.pop()
        return state

    outcome = run_unattended(small, unattended, rig_of=lambda rig: FaultyRig(rig, look=look))
    assert outcome.state is State.FINISHED
    assert [event.detail.get("cause") for event in events(unattended.run_dir, "state") if event.detail["to"] == "held"][
        :2
    ] == ["interlock", "link"]


def test_fault_52_an_axis_that_another_hand_moves_while_a_person_applies_a_field_trips(tmp_path: Path) -> None:
    rig = read_rig(SERVOS / "rig.toml")
    procedure = read_procedure(SERVOS / "magnetometer.toml")
    small = Bench(SERVOS, rig, make_plan(rig, procedure))
    run_dir = tmp_path / "run"
    run_dir.mkdir()
    header = make_header(
        "run", small.plan, rig, SERVOS / "rig.toml", SERVOS / "magnetometer.toml", "t", datetime.now(UTC)
    )
    began_s: list[float] = []
    with open_rig(rig) as opened:
        coil, yaw = opened.fields["coil"], opened.axes["yaw"]
        assert isinstance(yaw, SupervisedAxis)
        start_field = coil.start_field

        def asked(field_ut: float) -> None:
            start_field(field_ut)
            if not began_s:
                began_s.append(opened.clock.monotonic_s())
                yaw._axis.start_move(45.0)  # past the supervisor, as another program would

        coil.start_field = asked  # type: ignore[method-assign]
        outcome = begin(run_dir, header, small.plan, opened)
        assert (outcome.state, "yaw: " in outcome.reason) == (State.TRIPPED, True), outcome
        assert opened.clock.monotonic_s() - began_s[0] < HANDLING_S, "and not when that person is done"
