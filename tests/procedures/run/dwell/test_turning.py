"""Constant rates on twins: what counts is measured, and an axis that turns wrongly is brought to rest and told."""

import re
from pathlib import Path
from typing import cast

import pytest
from motion_runs import MotionRun, motion_run

from procedures.journal.journal_reader import JournalReader
from procedures.plan.steps import Turn
from procedures.records.dwells import DwellRecord
from procedures.records.states import State
from procedures.run.dwell.measure import Announcement
from procedures.run.dwell.stream_recorder import Recorder
from procedures.run.dwell.turning import LOOK_S, SPARE_TURNS, stop_and_see, turn
from rig.assembly.open_rig import open_rig
from rig.cables.cable import TurningAxis
from rig.description.fault_plan import FaultPlan, FaultRule
from rig.errors import RequestRefused, WaitEnded
from rig.motion.move import home_and_arrive
from rig.twins.csv_imu import CsvImuTwin

ONE_AXIS = {
    r"replications = 4": "replications = 1",
    r"pitch_dps = .*": "roll_dps = [40.0]",
    r"yaw_dps = .*\n": "",
    r"(?m)^roll_dps = \[10.0, 40.0\]\n": "",
    r'model = "gyro"': 'model = "linear"',
}
ROLL = r'(?s)(\[twin\]\nseed = 5\ntime = "virtual"\n)'


def _roll(tmp_path: Path, twin: str = "") -> MotionRun:
    """±40 °/s about roll for one revolution; ``twin``: what its axis really does."""
    rig_changes = {ROLL: rf"\1\n[twin.axes.roll]\n{twin}\n"} if twin else None
    return motion_run(tmp_path, "rate-table", "rates", ONE_AXIS, rig_changes)


def _dwells(run_dir: Path) -> list[DwellRecord]:
    with JournalReader.open(run_dir) as reader:
        reader.verify()
        return list(reader.dwells())


def test_the_rate_is_measured_from_position_and_time_over_whole_revolutions(tmp_path: Path) -> None:
    small = _roll(tmp_path, "rate_error = 0.01")  # inside the band of 2 %
    solved = small.solved()
    turned = [dwell for dwell in solved.record.dwells if dwell.motion is not None and dwell.motion.turned_deg]
    assert [round(dwell.motion.turned_deg / 360.0, 2) >= 1.0 for dwell in turned if dwell.motion] == [True, False]
    for dwell, asked_dps in zip(turned, (40.0, -40.0), strict=True):
        assert dwell.motion is not None
        rate_dps, uncertainty_dps = dwell.motion.rates_dps["roll"], dwell.motion.rate_uncertainty_dps["roll"]
        assert rate_dps == pytest.approx(1.01 * asked_dps, abs=4.0 * uncertainty_dps)  # not the set value
        assert uncertainty_dps < 1e-3
        assert abs(dwell.motion.turned_deg) >= 360.0
        assert dwell.readings["logger.gx"].samples.size == 900  # 9 s at 100 Hz
    calibration = solved.sensors["ENC03J"].calibration
    assert calibration is not None
    gain = calibration.axes["x"].parameters[0]
    assert gain.value == pytest.approx(1.0 / 1.25, rel=1e-4)  # with the set value it would be 1 % off
    assert set(calibration.axes) == {"x"}  # y and z were not turned
    assert any("axis z: it was exposed to one level only" in warning for warning in calibration.warnings)


def test_fault_53_a_speed_error_of_five_percent_trips_with_the_axis_at_rest(tmp_path: Path) -> None:
    small = _roll(tmp_path, "rate_error = 0.05")
    outcome = small.run(tmp_path / "run")
    assert outcome.state is State.TRIPPED
    assert "roll: turns steadily at 42 °/s, asked for 40 °/s, allowed within 0.808 °/s" in outcome.reason
    assert abs(outcome.positions_deg["roll"]) < 6.0 * 42.0  # read back at rest, seconds after it began
    assert not [dwell for dwell in _dwells(tmp_path / "run") if dwell.motion and dwell.motion.turned_deg]


def test_fault_53_a_runaway_is_decelerated_within_seconds(tmp_path: Path) -> None:
    """Detected: cumulative angle over time against the rate that was asked for, at every look.
    Response: the axis is told to decelerate, trip; nothing measured at another rate is kept.
    """
    small = _roll(tmp_path, "runaway_after_s = 5.0")
    outcome = small.run(tmp_path / "run")
    assert outcome.state is State.TRIPPED
    assert "roll: turns at" in outcome.reason
    assert "decelerate to rest" in outcome.reason
    rested_deg = outcome.positions_deg["roll"]
    assert rested_deg < 40.0 * 5.0 + 45.0 * 3.0 + 50.0**2 / 80.0  # seen within 3 s, then its own brake


def test_an_axis_does_not_turn_on_for_a_stream_that_is_slow(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a board that falls behind, a fifth of the samples are here when the revolution is whole."""
    samples = Recorder.samples
    monkeypatch.setattr(Recorder, "samples", lambda recorder, name: samples(recorder, name) // 5)
    outcome = _roll(tmp_path).run(tmp_path / "run")
    assert outcome.state is State.TRIPPED
    assert "360° were asked for; logger had not sent its samples: look at its rate_hz" in outcome.reason
    assert outcome.positions_deg["roll"] < 360.0 * (1.0 + SPARE_TURNS) + 10.0 * 40.0 * LOOK_S + 40.0 * 5.0


@pytest.mark.parametrize(
    ("ratio", "is_allowed"), [(0.7, False), (0.97, False), (0.997, True), (1.003, True), (1.4, False)]
)
def test_a_stream_at_another_rate_than_stated_is_no_dwell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ratio: float, is_allowed: bool
) -> None:
    """Its samples would stand at wrong times, and random walk and drift be wrong by as much."""
    _boards_send(monkeypatch, ratio)
    outcome = motion_run(tmp_path, "servo-mechanism", "drift").run(tmp_path / "run")
    assert (outcome.state is State.FINISHED) is is_allowed
    assert ("times as fast as the rig file states" in outcome.reason) is not is_allowed


def _boards_send(monkeypatch: pytest.MonkeyPatch, ratio: float) -> None:
    """Boards send so many times as fast as their rig file states, and tell the true time where they tell one."""
    begin = CsvImuTwin.__init__

    def begin_at_another_rate(twin: CsvImuTwin, *arguments: object, **settings: object) -> None:
        begin(twin, *arguments, **settings)  # type: ignore[arg-type]
        twin._rate_hz *= ratio

    monkeypatch.setattr(CsvImuTwin, "__init__", begin_at_another_rate)


def test_a_turn_beyond_what_the_cables_bear_is_refused_before_anything_moves(tmp_path: Path) -> None:
    from procedures.errors import PlanError

    with pytest.raises(
        PlanError, match=r"rates\.roll_dps: 9 s at 40 °/s are 1 revolutions.*bear 1 \(axes\.roll\.wrap_turns"
    ):
        motion_run(tmp_path, "rate-table", "rates", ONE_AXIS, {"wrap_turns = 5.0": "wrap_turns = 1.0"})


def test_a_turn_that_the_cables_do_not_bear_from_where_they_are_is_refused_before_anything_moves(
    tmp_path: Path,
) -> None:
    """They bear 5 revolutions and are wound by 4: one more with its ramps is too many, back it is not."""
    small = _roll(tmp_path)
    forth, back = (dwell for dwell in small.plan.design_dwells if isinstance(dwell.motion, Turn))
    announcement = Announcement(1, 1, 0.0, "settle", "read")
    with open_rig(small.rig) as rig:
        for axis in rig.axes.values():
            home_and_arrive(axis, rig.clock, rig.clock.sleep)
        roll = cast("TurningAxis", rig.axes["roll"])
        roll.start_rate(40.0)
        while roll.turn_look(rig.clock).angle_deg < 4.0 * 360.0:
            rig.clock.sleep(LOOK_S)
        stop_and_see(rig, "roll")
        rested = rig.axes["roll"].state()
        assert isinstance(forth.motion, Turn)
        with pytest.raises(RequestRefused, match=r"roll: turn by \+1.25 rev.* wound \+4.*, allowed 5 .*nothing moved"):
            turn(rig, small.plan, forth, forth.motion, announcement, rig.clock.sleep)
        assert rig.axes["roll"].state() == rested
        assert isinstance(back.motion, Turn)
        assert turn(rig, small.plan, back, back.motion, announcement, rig.clock.sleep).motion is not None


def test_fault_67_a_dwell_with_lost_samples_is_void_and_measured_again(tmp_path: Path) -> None:
    lost = FaultPlan(fault={"gone": FaultRule(line="streams.logger", kind="drop", nth=(130,))})
    outcome = _roll(tmp_path).run(tmp_path / "run", lost)
    assert outcome.state is State.FINISHED
    dwells = _dwells(tmp_path / "run")
    (void,) = [dwell for dwell in dwells if not dwell.accepted]
    assert len(void.reasons) == 1
    assert re.fullmatch(
        r"logger: of 900 samples \d+ missing \(before sample \d+: the count goes on by \d+\), allowed none",
        void.reasons[0],
    )
    again = next(dwell for dwell in dwells if dwell.step == void.step and dwell.accepted)
    assert again.attempt == void.attempt + 1


def test_nothing_is_read_before_the_axis_is_at_speed(tmp_path: Path) -> None:
    """With a ramp of 40 °/s² the first second is not at 40 °/s: every sample of the dwell is."""
    _roll(tmp_path).run(tmp_path / "run")
    turned = [dwell for dwell in _dwells(tmp_path / "run") if dwell.motion and dwell.motion.turned_deg]
    for dwell in turned:
        samples = dwell.readings["logger.gx"].samples
        assert abs(samples[:50].mean() - samples.mean()) < 5.0 * 0.002 / 50.0**0.5
        assert dwell.settle_s > 0.5


@pytest.mark.parametrize("after_s", [0.3, 2.0, 6.0])
def test_an_abort_while_it_turns_leaves_the_axis_at_rest(tmp_path: Path, after_s: float) -> None:
    small = _roll(tmp_path)
    dwell = next(dwell for dwell in small.plan.design_dwells if isinstance(dwell.motion, Turn))
    assert isinstance(dwell.motion, Turn)
    with open_rig(small.rig) as rig:
        for axis in rig.axes.values():
            home_and_arrive(axis, rig.clock, rig.clock.sleep)
        ends_s = rig.clock.monotonic_s() + after_s

        def wait(duration_s: float) -> None:
            rig.clock.sleep(min(duration_s, 0.1))
            if rig.clock.monotonic_s() > ends_s:
                raise WaitEnded("abort")

        with pytest.raises(WaitEnded):
            turn(rig, small.plan, dwell, dwell.motion, Announcement(1, 1, 0.0, "settle", "read"), wait)
        rested = rig.axes["roll"].state()
        assert not rested.is_moving
        assert 0.0 < rested.position_deg < 40.0 * (after_s + 2.0)
        rig.clock.sleep(60.0)
        assert rig.axes["roll"].state().position_deg == rested.position_deg
