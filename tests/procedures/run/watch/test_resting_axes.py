"""Axes that should rest: moved by somebody, misread once, at a limit switch, under a stop button, stalled."""

from dataclasses import replace
from pathlib import Path

import pytest
from faulty_rig import FaultyRig
from resumed import resume_on
from small_run import Bench, bench
from unattended_run import UnattendedRun, events, run_unattended

from procedures.errors import ExitStatus, RequestError
from procedures.journal.status.status import status
from procedures.records.states import State
from rig.abilities.abilities import AxisState, Burst
from rig.assembly.open_rig import Rig, open_rig
from rig.twins.physics.world import World


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench(tmp_path_factory.mktemp("bench"))


class Touched(FaultyRig):
    """Somebody moves the pitch axis by hand, or presses its button, once so many readings were taken."""

    def __init__(self, rig: Rig, **change: object) -> None:
        super().__init__(rig, look=self._touched)
        self._change = change
        self.looks = 0

    def _touched(self, state: AxisState) -> AxisState:
        self.looks += self.meter.read_so_far == 60
        return replace(state, **self._change) if self.looks > 1 else state  # type: ignore[arg-type]


def test_fault_52_an_axis_that_moves_though_nothing_told_it_to_trips(small: Bench, tmp_path: Path) -> None:
    """Detected: every look at an axis that should rest, inside dwells, between them, while another axis moves, and
    every second of a pause, a hold or a soak; a jog finds the rig locked.
    Response: trip; what was measured is safe, the position is not trusted before the next home.
    """
    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended, rig_of=lambda rig: Touched(rig, position_deg=12.5))
    assert outcome.state is State.TRIPPED
    assert "pitch: was moved, though nothing told it to: left at" in outcome.reason
    last = max(event.sequence for event in events(unattended.run_dir, "dwell"))
    assert not [event for event in events(unattended.run_dir, "intent") if event.sequence > last]


class Displaced(FaultyRig):
    """Somebody turns the table while a channel is read, past this program: the machine's own read-back shows it."""

    def __init__(self, rig: Rig) -> None:
        super().__init__(rig, spoil=self._displaced)
        self._world = rig.chance

    def _displaced(self, number: int, burst: Burst) -> Burst:
        if number == 60:
            assert isinstance(self._world, World)
            self._world.slip("pitch", 3.0, self.clock.monotonic_s(), seen=True)
        return burst


def test_fault_81_an_axis_that_is_moved_inside_a_dwell_trips_and_the_dwell_is_not_kept(
    small: Bench, tmp_path: Path
) -> None:
    """Detected: the read-back of every axis at every look inside the dwell, against where it was left.
    Response: trip; the dwell in progress is not kept, and nothing is tried again.
    """
    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended, rig_of=Displaced)
    assert outcome.state is State.TRIPPED
    assert "pitch: was moved, though nothing told it to: left at" in outcome.reason
    last = max(event.sequence for event in events(unattended.run_dir, "dwell"))
    intents = [event for event in events(unattended.run_dir, "intent") if event.sequence > last]
    assert len(intents) == 1, "the dwell in progress, and no attempt after it"


def test_a_read_back_that_is_wrong_once_is_recorded_and_trips_nothing(small: Bench, tmp_path: Path) -> None:
    """One digit turned over on the line at the look after the third dwell."""
    lies = 0

    def lie(unattended: UnattendedRun) -> None:
        nonlocal lies
        lies = 1

    def look(state: AxisState) -> AxisState:
        nonlocal lies
        found, lies = (state.position_deg + 40.0 if lies else state.position_deg), 0
        return replace(state, position_deg=found)

    unattended = UnattendedRun(tmp_path / "run", after={3: lie})
    assert run_unattended(small, unattended, rig_of=lambda rig: FaultyRig(rig, look=look)).state is State.FINISHED
    (noted,) = events(unattended.run_dir, "unconfirmed")
    assert "pitch: was moved, though nothing told it to" in str(noted.detail["told"])


def _latched(small: Bench, run_dir: Path, fault: str) -> None:
    outcome = run_unattended(small, UnattendedRun(run_dir), rig_of=lambda rig: Touched(rig, fault=fault))
    assert (outcome.state, outcome.exit_status) == (State.TRIPPED, ExitStatus.HELD)
    assert f"pitch: {fault} while it should rest" in outcome.reason
    assert status(run_dir).held_by == outcome.reason


def test_fault_40_a_limit_switch_latches(small: Bench, tmp_path: Path) -> None:
    """Detected: the device's own status at every look.
    Response: the axis is stopped, trip, latched; resume with name and reason homes and checks first.
    """
    _latched(small, tmp_path / "run", "limit switch")


def test_fault_41_a_stop_button_latches_and_its_release_alone_starts_nothing(small: Bench, tmp_path: Path) -> None:
    """Detected: the device's own status at every look.
    Response: trip, latched also across power cuts; releasing the button starts nothing.
    """
    _latched(small, tmp_path / "run", "stop button")
    with open_rig(small.rig) as rig, pytest.raises(RequestError, match="a person has to look first"):
        resume_on(tmp_path / "run", rig, "carla")


def test_fault_42_a_stalled_axis_is_stopped_and_trips(small: Bench, tmp_path: Path) -> None:
    """Detected: no progress in 2 s, or longer than distance/speed × 1.5 + 5 s.
    Response: stopped, back to where it came from, once more; then a trip.
    """

    class Stalled(FaultyRig):
        def __init__(self, rig: Rig) -> None:
            super().__init__(rig, look=self._stuck)
            start_move, self.is_stuck = self.pitch.start_move, False

            def sticks(target_deg: float) -> None:
                start_move(target_deg)
                self.is_stuck = self.meter.read_so_far >= 60 and self.pitch.stops == 0

            self.pitch.start_move = sticks  # type: ignore[method-assign]

        def _stuck(self, state: AxisState) -> AxisState:
            return replace(state, is_moving=True, position_deg=3.25) if self.is_stuck else state

    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended, rig_of=Stalled)
    assert outcome.state is State.TRIPPED
    assert "no progress in 2 s at 3.25°, though it says it moves" in outcome.reason
