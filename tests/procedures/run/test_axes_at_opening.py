"""Axes that turn, or are not where they were left, when lines are opened; motors that somebody switched off."""

from pathlib import Path
from typing import Any

import pytest
from resumed import resume_on
from small_run import Bench, bench, dwells_of, measured
from unattended_run import RigReopenedLate, UnattendedRun, events, run_unattended, states

from procedures.journal.audit.audit_trail import notes_in
from procedures.records.progress import STRAY_MOTION
from procedures.records.states import State
from procedures.run.handover import handover
from rig.abilities.abilities import Burst
from rig.assembly.open_rig import Rig, open_rig
from rig.errors import LinkLost
from rig.motion.move import home_and_arrive
from rig.twins.physics.world import World

SLOW = (("speed_dps = 180.0", "speed_dps = 20.0"),)
ESP301 = (
    ('driver = "indexing-table"\nport = "twin"\nincrement_deg = 1.0', 'driver = "esp301"\nport = "twin"'),
    ("speed_dps = 180.0", "speed_dps = 20.0"),
)


def _sent_by_somebody_else(rig: Rig, name: str, target_deg: float, slip_deg: float = 0.0) -> None:
    """As one who had the rig before, or past this program; then the lines are opened."""
    axis: Any = rig.axes[name]
    home_and_arrive(axis, rig.clock, rig.clock.sleep)
    assert isinstance(rig.chance, World)
    rig.chance.slip(name, slip_deg, rig.clock.monotonic_s(), seen=True)
    axis._axis.start_move(target_deg)
    rig.clock.sleep(1.0)
    rig.reconnect()


def _stray(run_dir: Path) -> list[str]:
    return [str(event.detail["text"]) for event in events(run_dir, STRAY_MOTION)]


def test_fault_91_an_axis_that_turns_when_its_line_is_opened_is_stopped_told_and_homed(tmp_path: Path) -> None:
    """Detected: two looks at every axis before anything else, whenever lines are opened: run, resume, reconnect, jog.
    Response: stopped and seen at rest, told in journal, report and handover, homed, and the run goes on; outside its
    limits, or where it begins later, it is stopped and trips.
    """
    small = bench(tmp_path, rig=SLOW)
    assert small.run(tmp_path / "clean").state is State.FINISHED
    unattended = UnattendedRun(tmp_path / "run")

    def turning(rig: Rig) -> Rig:
        _sent_by_somebody_else(rig, "roll", 90.0)
        return rig

    assert run_unattended(small, unattended, rig_of=turning).state is State.FINISHED
    (told,) = _stray(unattended.run_dir)
    assert told.startswith("roll: moves, though nothing told it to: stopped, at rest at ")
    kinds = [event.kind for event in events(unattended.run_dir)]
    assert kinds.index(STRAY_MOTION) < kinds.index("identities"), "before anything else"
    assert [progress.message for progress in unattended.heard if progress.event == STRAY_MOTION] == [told]
    assert told in [note.text for note in notes_in(events(unattended.run_dir))], "on the page"
    assert "moved unasked (1)" in handover(unattended.run_dir)
    assert measured(dwells_of(unattended.run_dir)) == measured(dwells_of(tmp_path / "clean"))


def test_fault_91_what_turns_outside_its_limits_when_its_line_is_opened_trips(tmp_path: Path) -> None:
    small = bench(tmp_path, rig=SLOW)
    unattended = UnattendedRun(tmp_path / "run")

    def turning(rig: Rig) -> Rig:
        _sent_by_somebody_else(rig, "roll", 170.0, slip_deg=250.0)
        return rig

    outcome = run_unattended(small, unattended, rig_of=turning)
    assert outcome.state is State.TRIPPED
    assert "roll moved outside its limits: at " in outcome.reason
    assert "stopped, at rest at" in outcome.reason
    assert not events(unattended.run_dir, "intent")


def test_fault_91_an_axis_that_is_not_where_it_was_left_before_a_loss_is_told(tmp_path: Path) -> None:
    small = bench(tmp_path)

    def turned_by_hand(unattended: UnattendedRun) -> None:
        assert isinstance(unattended.rig.chance, World)
        unattended.rig.chance.slip("roll", 3.0, unattended.rig.clock.monotonic_s(), seen=True)

    def lose(number: int, burst: Burst) -> Burst:
        if number == 50:
            raise LinkLost("axes.pitch: the port is gone")
        return burst

    unattended = UnattendedRun(tmp_path / "run", at={1: turned_by_hand})
    outcome = run_unattended(small, unattended, rig_of=lambda rig: RigReopenedLate(rig, 2, spoil=lose))
    (told,) = _stray(unattended.run_dir)
    assert told.startswith("roll: left at rest at "), outcome.reason
    assert "it was moved while nobody could see it, or its machine lost its count" in told


def _motors(rig: Rig) -> Any:
    """The motors of the controller's twin, by number."""
    axis: Any = rig.axes["pitch"]
    return axis._axis._controller._exchange.stream.close.__self__._peer.axes


@pytest.mark.parametrize("other_loses_its_home", [False, True])
def test_fault_92_a_motor_that_somebody_switched_off_is_energised_by_no_one_but_a_person(
    tmp_path: Path, other_loses_its_home: bool
) -> None:
    """Detected: the motor was on and is off, on a controller that did not lose its power, at every look.
    Response: trip; nothing is sent that switches it on before a person resumes with name and reason.
    """
    small: Bench = bench(tmp_path, rig=ESP301)

    def switch_off(unattended: UnattendedRun) -> None:
        _motors(unattended.rig)[2].is_on = False
        if other_loses_its_home:  # which is mended by homing every axis
            pitch: Any = unattended.rig.axes["pitch"]
            pitch._axis._home = "none"

    unattended = UnattendedRun(tmp_path / "run", after={5: switch_off})
    outcome = run_unattended(small, unattended)
    assert (outcome.state, outcome.cause) == (State.TRIPPED, "device")
    assert "roll: the motor was switched off, not by calrig" in outcome.reason
    assert not _motors(unattended.rig)[2].is_on
    assert states(unattended.run_dir)[-1] == "tripped"
    with open_rig(small.rig) as rig:
        assert resume_on(unattended.run_dir, rig, "carla", "the guard is shut again").state is State.FINISHED
