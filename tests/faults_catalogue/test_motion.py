"""Catalogue 4.3: motion. Each entry of FAULTS 39 to 56 that is not tested beside the code that meets it."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from faulty_rig import FaultyRig
from motion_bench import motion_bench
from resumed import resume_on
from runs_with_faults import faults, run_with_faults
from small_run import QUICK_SETTLE, Bench, bench, dwells_of, measured
from standstill import STRIKES, RigReopenedLate, StruckRun, standstill_s
from unattended_run import UnattendedRun, asks, events, run_unattended, states

from ams.calibration.mountings import calibrate_mountings
from ams.calibration_result import Calibration
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from procedures.delivery.deliver import solve_run
from procedures.errors import PlanError
from procedures.records.states import State
from procedures.run.begin import begin
from procedures.run.services import RunServices
from procedures.solution import by_model
from rig.abilities.abilities import AxisState
from rig.assembly.open_rig import Rig, open_rig
from rig.errors import DeviceFault, RequestRefused
from rig.motion.jog import jog_to
from rig.motion.move import move_and_arrive
from rig.twins.physics.world import World
from rig.wire.maestro import Errors


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench(tmp_path_factory.mktemp("bench"))


@pytest.fixture(scope="module")
def clean(small: Bench) -> Path:
    assert small.run(small.folder / "clean").state is State.FINISHED
    return small.folder / "clean"


def _world(rig: Rig) -> World:
    assert isinstance(rig.chance, World)
    return rig.chance


def test_fault_39_a_plan_beyond_a_limit_is_refused_whole_before_the_first_move(tmp_path: Path) -> None:
    """Detected: in the plan, and once more in the driver just before the bytes go.
    Response: the whole plan is refused before any port is opened; a jog beyond a limit moves nothing.
    """
    narrow = (
        (
            "limits_deg = [-180.0, 180.0]\nspeed_dps = 180.0\naxis = 1",
            "limits_deg = [-20.0, 20.0]\nspeed_dps = 180.0\naxis = 1",
        ),
    )
    with pytest.raises(PlanError, match=r"pitch.* -30.*-20 to 20"):
        bench(tmp_path, rig=narrow)


@pytest.mark.parametrize("target_deg", [180.5, 181.0, -1e9, float("nan"), float("inf"), 57.3 * 90.0])
def test_fault_39_no_target_beyond_a_limit_reaches_the_machine(small: Bench, target_deg: float) -> None:
    with open_rig(small.rig) as rig:
        rig.axes["pitch"].home()
        rig.clock.sleep(60.0)
        with pytest.raises(RequestRefused):
            jog_to(rig, "pitch", target_deg, rig.clock.sleep)
        assert _world(rig).axes["pitch"].reached_deg == (0.0, 0.0)


def _from_reading(number: int, change: Callable[[AxisState], AxisState], looks: int = 10**9) -> type[FaultyRig]:
    """The pitch axis says something else from the n-th dwell reading on, for so many looks."""

    class Changed(FaultyRig):
        def __init__(self, rig: Rig) -> None:
            super().__init__(rig, look=self._changed)
            self.looks = 0

        def _changed(self, state: AxisState) -> AxisState:
            if self.meter.read_so_far < number or self.looks >= looks:
                return state
            self.looks += 1
            return change(state)

    return Changed


def test_fault_43_a_moving_flag_that_stays_set_trips_and_nothing_is_sent_on_top(small: Bench, tmp_path: Path) -> None:
    """Detected: the axis says that it moves though nothing told it to, or its read-back stands still for 2 s.
    Response: trip; no command goes out on top of a move that may be real.
    """
    moving = _from_reading(60, lambda state: replace(state, is_moving=True))
    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended, rig_of=moving)
    assert outcome.state is State.TRIPPED
    assert "pitch" in outcome.reason
    last = max(event.sequence for event in events(unattended.run_dir, "dwell"))
    assert not [e for e in events(unattended.run_dir, "intent") if e.sequence > last + 1]


def test_fault_44_a_read_back_that_misses_once_is_approached_anew(small: Bench, clean: Path, tmp_path: Path) -> None:
    """Detected: read-back against target after every move, before and after every dwell; never the command.
    Response: the dwell is void; approached anew at most twice, each on record; then a trip.
    """
    rule = {"line": "axes.pitch", "kind": "slip", "slip_deg": 0.05, "seen": True, "at_s": 90.0}
    unattended = UnattendedRun(tmp_path / "run")
    outcome, _ = run_with_faults(small, unattended, faults(once=rule))
    assert outcome.state in (State.FINISHED, State.TRIPPED), outcome.reason
    if outcome.state is State.TRIPPED:
        assert "was moved, though nothing told it to" in outcome.reason
        with open_rig(small.rig) as rig:
            assert resume_on(unattended.run_dir, rig, "carla", "looked").state is State.FINISHED
    assert all(
        abs(dwell.measured_deg["pitch"] - dwell.targets_deg["pitch"]) <= 0.001
        for dwell in dwells_of(unattended.run_dir) if dwell.accepted
    )  # fmt: skip


def test_fault_44_stuck_a_read_back_that_always_misses_trips(small: Bench, tmp_path: Path) -> None:
    off = _from_reading(60, lambda state: replace(state, position_deg=state.position_deg + 0.05))
    outcome = run_unattended(small, UnattendedRun(tmp_path / "run"), rig_of=off)
    assert outcome.state is State.TRIPPED


@pytest.mark.parametrize("by_deg", [1.0, -10.0])
def test_fault_46_a_home_that_is_a_tooth_off_is_found_by_the_check_set(
    small: Bench, tmp_path: Path, by_deg: float
) -> None:
    """Detected: the check set after every home against that of the start.
    Response: trip; nothing is measured from a false zero.
    """
    unattended = UnattendedRun(tmp_path / "run", after={8: asks("stop")})
    run_unattended(small, unattended)
    with open_rig(small.rig) as rig:
        _world(rig).slip("pitch", by_deg, rig.clock.monotonic_s(), seen=False)
        outcome = resume_on(unattended.run_dir, rig, "carla")
    assert outcome.state is State.TRIPPED
    assert "the restart made a step" in outcome.reason
    assert {dwell.purpose for dwell in dwells_of(unattended.run_dir) if dwell.epoch == 2} == {"check"}


def test_fault_47_a_coupling_that_seats_late_is_seated_anew_and_the_numbers_stay(
    small: Bench, clean: Path, tmp_path: Path
) -> None:
    """Detected: seat and lock of the machine, after every move, before and after every dwell.
    Response: seated anew from the next tooth at most twice, each on record; then a trip. A flicker voids the dwell.
    """

    class Late(FaultyRig):
        def __init__(self, rig: Rig) -> None:
            super().__init__(rig, look=self._unseated)
            self.is_late = self.was_moving = False

        def _unseated(self, state: AxisState) -> AxisState:
            """Once, at the end of a move."""
            arrives = self.was_moving and not state.is_moving and self.meter.read_so_far >= 60
            self.was_moving = state.is_moving
            if not arrives or self.is_late:
                return state
            self.is_late = True
            return replace(state, is_seated=False)

    unattended = UnattendedRun(tmp_path / "run")
    assert run_unattended(small, unattended, rig_of=Late).state is State.FINISHED
    assert "approached anew" in str([event.detail for event in events(unattended.run_dir, "again")])
    assert measured(dwells_of(unattended.run_dir)) == measured(dwells_of(clean))


def test_fault_47_stuck_a_coupling_that_never_seats_trips_and_measures_nothing(small: Bench, tmp_path: Path) -> None:
    lifted = _from_reading(60, lambda state: replace(state, is_seated=False))
    unattended = UnattendedRun(tmp_path / "run")
    outcome = run_unattended(small, unattended, rig_of=lifted)
    assert outcome.state is State.TRIPPED
    assert "the coupling is not seated and locked" in outcome.reason
    assert len(events(unattended.run_dir, "again")) <= 2
    assert all(dwell.accepted for dwell in dwells_of(unattended.run_dir)[:-1])


def test_fault_47_a_seat_that_flickers_during_a_dwell_voids_it(small: Bench, tmp_path: Path) -> None:
    flicker = _from_reading(63, lambda state: replace(state, is_seated=False), looks=1)
    unattended = UnattendedRun(tmp_path / "run")
    assert run_unattended(small, unattended, rig_of=flicker).state is State.FINISHED
    rejected = [dwell for dwell in dwells_of(unattended.run_dir) if not dwell.accepted]
    assert "not seated" in str([dwell.reasons for dwell in rejected])


class Backlash(FaultyRig):
    """The package lags behind by the play of the gear: where the last move went down, it stands too high."""

    PLAY_DEG = 0.05

    def __init__(self, rig: Rig) -> None:
        super().__init__(rig)
        body = _world(rig).axes["pitch"]
        rotate, attitude_rad, down = body.rotate, body.attitude_rad, [False]

        def turned(target_deg: float, start_s: float) -> float:
            down[0] = target_deg < body.table_deg(start_s)
            return rotate(target_deg, start_s)

        body.rotate = turned  # type: ignore[method-assign]
        body.attitude_rad = lambda now_s: attitude_rad(now_s) + np.deg2rad(self.PLAY_DEG) * down[0]  # type: ignore[method-assign]


def _away_in_u(run_dir: Path) -> float:
    """Largest distance of x' and z's parameters from the truth, in standard uncertainties."""
    solved = solve_run(run_dir).sensors["SN1"].calibration
    assert solved is not None
    truth = {"x": (0.005, 2.5, 0.5, 35.0), "z": (0.008, 2.52, 0.4, 160.0)}
    return max(
        abs(float(parameter.value or 0.0) - true) / float(parameter.standard_uncertainty or 1.0)
        for axis, values in truth.items()
        for parameter, true in zip(solved.axes[axis].parameters, values, strict=True)
    )


MANY = (("replications = 2", "replications = 4"), ("samples = 5", "samples = 20"))


@pytest.mark.parametrize("approach_deg", [0.0, -3.0])
def test_fault_49_a_one_sided_approach_keeps_backlash_out_of_the_parameters(
    tmp_path: Path, approach_deg: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Detected: reference visits see turns of the table to and fro; from some thirty attitudes on the dwells tell the
    play itself, by what all axes of a package do with the way that an axis of the table came.
    Response: findings name the table, those of the dwells with the size of its play; with `approach_deg` the last
    approach always comes from one side, and there is nothing to find.
    """
    text = (
        (
            "limits_deg = [-180.0, 180.0]\nspeed_dps = 180.0\naxis = 1",
            f"limits_deg = [-180.0, 180.0]\nspeed_dps = 180.0\naxis = 1\napproach_deg = {approach_deg}",
        ),
    )
    small = bench(tmp_path, rig=text, procedure=MANY)
    unattended = UnattendedRun(tmp_path / "run", at={n: asks("continue") for n in range(20, 2000, 20)})
    assert run_unattended(small, unattended, rig_of=Backlash).state is State.FINISHED
    requests = list[CalibrationRequest]()

    def calibrated(rows: Observations, request: CalibrationRequest) -> Calibration:
        requests.append(request)
        return calibrate_mountings(rows, request)

    monkeypatch.setattr(by_model, "calibrate_mountings", calibrated)
    solved = solve_run(unattended.run_dir).sensors["SN1"].calibration
    assert solved is not None
    assert {request.single_approach for request in requests} == {frozenset({"pitch"} if approach_deg else ())}
    kinds = {finding.kind for axis in solved.axes.values() for finding in axis.findings if finding.is_significant}
    assert ("table-rotation" in kinds) is (approach_deg == 0.0)
    scatter_v = {axis: solved_axis.standard_error_v for axis, solved_axis in solved.axes.items()}
    if approach_deg:
        assert _away_in_u(unattended.run_dir) < 5.0
        assert scatter_v["x"] < 2e-5
    else:
        assert scatter_v["x"] > 20.0 * 2e-5, "a play of 0.05° is 2 mV"


def test_fault_51_a_servo_that_follows_late_is_waited_for(clean: Path, tmp_path: Path) -> None:
    """Detected: the sensors themselves: settling sees them move on, the running fit sees them elsewhere.
    Response: waited for within `max_s`; a servo that stays away fails dwell after dwell and holds or trips the run.
    """
    rule = {"line": "axes.pitch", "kind": "lag", "lag_s": 6.0, "at_s": 1.0}
    unattended = UnattendedRun(tmp_path / "run", at={n: asks("continue") for n in range(20, 2000, 20)})
    slow, patience = ("speed_dps = 180.0", "speed_dps = 20.0"), (QUICK_SETTLE, "settle = { window_s = 1.5 }")
    patient = bench(tmp_path, rig=(slow,), procedure=(patience,))
    outcome, found = run_with_faults(patient, unattended, faults(late=rule))
    assert outcome.state is State.FINISHED
    assert found
    late = {
        dwell.step: dwell for dwell in dwells_of(unattended.run_dir) if dwell.accepted and dwell.purpose == "design"
    }
    for dwell in dwells_of(clean):
        if dwell.accepted and dwell.purpose == "design":
            for channel, reading in dwell.readings.items():
                assert late[dwell.step].readings[channel].mean == pytest.approx(reading.mean, abs=2e-4)


@pytest.mark.parametrize("entry", sorted(STRIKES))
def test_fault_55_no_axis_moves_once_it_was_seen_at_rest(entry: int) -> None:
    """Detected: after every stop each axis is seen at rest for a second.
    Response: an axis that moves on is named, and the run is tripped, also where it was aborted.
    """
    assert standstill_s(entry) < (1.0 if entry != 21 else 20.0)


def test_fault_55_stuck_an_axis_that_creeps_on_after_abort_is_told(small: Bench, tmp_path: Path) -> None:
    class Creeps(FaultyRig):
        def __init__(self, rig: Rig) -> None:
            super().__init__(rig, look=self._crept)
            self.by_deg = 0.0

        def _crept(self, state: AxisState) -> AxisState:
            self.by_deg += 0.01 * (self.pitch.stops > 0)
            return replace(state, position_deg=state.position_deg + self.by_deg)

    unattended = UnattendedRun(tmp_path / "run", after={5: asks("abort")})
    outcome = run_unattended(small, unattended, rig_of=Creeps)
    assert outcome.state is State.TRIPPED
    assert "not every axis is known to stand still: pitch: still moving" in outcome.reason


@pytest.mark.usefixtures("terminal_signals")
def test_fault_19_a_termination_in_mid_move_stops_the_axes_within_a_second(small: Bench, tmp_path: Path) -> None:
    """Detected: signals leave a mark that every slice of every wait reads.
    Response: once: stop after the dwell; twice: abort; SIGTERM: stop at once; a closed terminal ends nothing.
    """
    run = StruckRun(tmp_path / "run", STRIKES[19])
    run.run_dir.mkdir()
    with open_rig(small.rig) as rig:
        run.rig = rig
        outcome = begin(
            run.run_dir,
            small.header(run.run_dir),
            small.plan,
            RigReopenedLate(rig, run),
            services=RunServices(pulse=run.pulse),
        )
        assert outcome.state is State.STOPPED
        assert run.still_after_s() < 1.0
    assert states(run.run_dir)[-1] == "stopped"


@pytest.mark.parametrize("bit", list(Errors))
def test_fault_50_an_error_bit_in_mid_dwell_is_seen_by_the_look_after_it(bit: Errors) -> None:
    """Detected: the error register, read with every look, before and after every dwell; it is kept though reading
    clears it.
    Response: the servos went to their home: the dwell is void and the run trips; nothing moves before a home.
    """
    machine = motion_bench("maestro")
    machine.home_all()
    move_and_arrive(machine.pitch, 30.0, machine.clock, machine.clock.sleep)
    before = machine.pitch.state()
    assert (before.is_homed, before.fault) == (True, "")
    machine.twin.fail(bit, machine.clock.monotonic_s())
    after = machine.pitch.state()
    assert (after.is_homed, "sent the servos home" in after.fault) == (False, True)
    with pytest.raises(DeviceFault, match="nothing moved; clear it at the machine"):
        move_and_arrive(machine.pitch, 30.0, machine.clock, machine.clock.sleep)


@pytest.mark.parametrize(
    "at_s", [8.3, 40.2, 99.9, *[pytest.param(at_s, marks=pytest.mark.thorough) for at_s in (0.5, 21.7, 61.7, 80.3)]]
)
def test_fault_45_a_controller_that_loses_power_at_any_moment_is_homed_before_anything_else(
    small: Bench, clean: Path, tmp_path: Path, at_s: float
) -> None:
    """Whole lines, whole twins: power fails for three seconds; no number comes from a false zero."""
    unattended = UnattendedRun(tmp_path / "run", at={n: asks("continue") for n in range(200, 4000, 200)})
    cut = {"line": "axes.pitch", "kind": "power-cycle", "at_s": at_s, "away_s": 3.0}
    outcome, said = run_with_faults(small, unattended, faults(cut=cut))
    assert said
    if outcome.state is not State.FINISHED:
        assert outcome.state is State.TRIPPED, outcome.reason
        with open_rig(small.rig) as rig:
            assert resume_on(unattended.run_dir, rig, "carla", "looked at its supply").state is State.FINISHED
    again = {dwell.step for dwell in dwells_of(unattended.run_dir) if dwell.accepted and dwell.attempt > 1}
    found, truth = measured(dwells_of(unattended.run_dir)), measured(dwells_of(clean))
    assert found.keys() == truth.keys()
    assert {step: found[step] for step in found if step not in again} == {
        step: truth[step] for step in truth if step not in again
    }
    assert len(again) <= 1, "the dwell in progress, rejected and measured with chance of its own"


def test_fault_42_gone_a_stall_that_clears_is_on_record_and_changes_no_number(
    small: Bench, clean: Path, tmp_path: Path
) -> None:
    unattended = UnattendedRun(tmp_path / "run")
    stall = {"line": "axes.pitch", "kind": "stall", "for_s": 1000.0, "at_s": 60.0}
    outcome, _ = run_with_faults(small, unattended, faults(stall=stall))
    assert outcome.state is State.FINISHED, outcome.reason
    (again,) = events(unattended.run_dir, "again")
    assert "no progress in 2 s" in str(again.detail["reason"])
    assert "is tried once more" in str(again.detail["reason"])
    assert measured(dwells_of(unattended.run_dir)) == measured(dwells_of(clean))
