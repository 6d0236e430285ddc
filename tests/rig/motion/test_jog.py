"""Laws of motion by hand: the limits of the description, absolute targets, readings with their spread."""

from collections.abc import Callable, Iterator
from contextlib import nullcontext
from pathlib import Path

import pytest
from table_bench import rig_file
from turning_rig import DRIVE_FOR_ROLL, STAGE_FOR_ROLL

from rig.assembly.open_rig import Rig, open_rig
from rig.description.device_settings import AxisSettings
from rig.description.fault_plan import FaultPlan, FaultRule
from rig.description.read import read_rig
from rig.errors import RequestRefused
from rig.motion.jog import attitude_of_pulse, home, jog_by, jog_to, pulse_of, readings, require_room_to_turn, turn_for


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    with open_rig(read_rig(rig_file(tmp_path, ("limits_deg = [-180.0, 180.0]", "limits_deg = [-45.0, 45.0]")))) as rig:
        for readout in rig.readouts.values():
            readout.prepare()
        yield rig


def test_steps_add_up_from_the_read_back(rig: Rig) -> None:
    wait = rig.clock.sleep
    home(rig, "pitch", wait)
    assert jog_to(rig, "pitch", 10.0, wait) == 10.0
    assert jog_by(rig, "pitch", -5.0, wait) == 5.0
    assert jog_by(rig, "pitch", 40.0, wait) == 45.0


@pytest.mark.parametrize("jog", [jog_to, jog_by])
def test_a_move_that_is_made_again_is_told(tmp_path: Path, jog: Callable[..., float]) -> None:
    stall = FaultPlan(fault={"stall": FaultRule(line="axes.pitch", kind="stall", for_s=1000.0, at_s=100.0)})
    messages: list[str] = []
    with open_rig(read_rig(rig_file(tmp_path)), faults=stall) as rig:
        home(rig, "pitch", rig.clock.sleep)
        rig.clock.sleep(100.0)
        assert jog(rig, "pitch", 30.0, rig.clock.sleep, messages.append) == 30.0
    (again,) = messages
    assert "pitch: move to 30°: no progress in 2 s" in again
    assert "it went back to 0° and is tried once more" in again


def test_a_step_across_the_limit_moves_nothing(rig: Rig) -> None:
    wait = rig.clock.sleep
    home(rig, "pitch", wait)
    jog_to(rig, "pitch", 45.0, wait)
    with pytest.raises(RequestRefused, match="move to 46°: outside the limits, allowed -45 to 45°"):
        jog_by(rig, "pitch", 1.0, wait)
    assert rig.axes["pitch"].state().position_deg == 45.0


class PulsedByOthers(AxisSettings):
    """A servo of another distribution: 10 µs a degree about 1500 µs."""

    pulse_limits_us: tuple[float, float] = (900.0, 2100.0)

    def pulse_us(self, attitude_deg: float) -> float:
        return 1500.0 + 10.0 * self.table_deg(attitude_deg)

    def pulse_attitude_deg(self, pulse_us: float) -> float:
        return self.attitude_deg((pulse_us - 1500.0) / 10.0)


def test_pulses_are_of_every_axis_whose_settings_tell_them(rig: Rig) -> None:
    """Whoever made its driver: sign −1 and zero 5° put 20° at −15° of the machine, which is 1350 µs."""
    servo = PulsedByOthers(driver="x", port="twin", limits_deg=(-45.0, 45.0), speed_dps=10.0, sign=-1, zero_deg=5.0)
    rig.description = rig.description.model_copy(update={"axes": {**rig.description.axes, "pitch": servo}})
    assert pulse_of(rig, "pitch", 20.0) == 1350.0
    assert attitude_of_pulse(rig, "pitch", 1350.0) == 20.0
    with pytest.raises(RequestRefused, match="pitch: pulse 2101 µs, allowed 900 to 2100 µs"):
        attitude_of_pulse(rig, "pitch", 2101.0)
    assert pulse_of(rig, "roll", 20.0) is None
    with pytest.raises(RequestRefused, match="roll: is no servo and has no pulses"):
        attitude_of_pulse(rig, "roll", 1500.0)


def test_an_axis_without_a_home_is_not_jogged(rig: Rig) -> None:
    for jog in (jog_to, jog_by):
        with pytest.raises(RequestRefused, match="pitch: the axis is not homed"):
            jog(rig, "pitch", 5.0, rig.clock.sleep)


def test_unknown_names_are_told_with_what_there_is(rig: Rig) -> None:
    with pytest.raises(RequestRefused, match=r"no axis 'yaw' \(allowed: pitch, roll\); nothing moved"):
        jog_to(rig, "yaw", 5.0, rig.clock.sleep)
    with pytest.raises(RequestRefused, match=r"no channel 'dmm.w' \(allowed: dmm.x, dmm.y, dmm.z\)"):
        readings(rig, ["dmm.x", "dmm.w"], 3, rig.clock.sleep)


def test_readings_are_means_with_their_spread(rig: Rig) -> None:
    wait = rig.clock.sleep
    for axis in rig.axes:
        home(rig, axis, wait)
    x, z = readings(rig, ["dmm.x", "dmm.z"], 20, wait)
    # Level, by the truth of the example: x is near its offset, z near offset − S.
    assert x.mean == pytest.approx(0.005 - 2.5 * 0.0087265 * 0.5736, abs=2e-4)  # b − S sinΩ sinA
    assert z.mean == pytest.approx(0.008 - 2.52, abs=1e-3)
    assert (x.samples, x.overloads) == (20, 0)
    assert 1e-5 < x.standard_deviation < 4e-5


def test_a_turn_that_is_over_before_its_first_answer_has_a_rate_all_the_same(tmp_path: Path) -> None:
    slow = FaultPlan(fault={"slow": FaultRule(line="axes.roll", kind="delay", delay_s=0.3, every=1)})
    with open_rig(read_rig(rig_file(tmp_path, STAGE_FOR_ROLL)), faults=slow) as rig:
        home(rig, "roll", rig.clock.sleep)
        rate = turn_for(rig, "roll", 5.0, 0.25, rig.clock.sleep).measured
    assert rate.turned_deg > 0.0
    assert rate.rate_dps == pytest.approx(5.0, abs=rate.uncertainty_dps + 0.1)


def test_gathering_speed_is_no_part_of_a_measured_rate(tmp_path: Path) -> None:
    table, drive = DRIVE_FOR_ROLL
    with open_rig(read_rig(rig_file(tmp_path, (table, f"{drive}acceleration_dps2 = 4.0\n")))) as rig:
        home(rig, "roll", rig.clock.sleep)
        turn = turn_for(rig, "roll", 5.0, 4.0, rig.clock.sleep)  # 5 deg/s after 1.25 s
    rate = turn.measured
    assert turn.doubt == ""
    assert rate.rate_dps == pytest.approx(5.0, abs=rate.uncertainty_dps + 0.01)
    assert rate.turned_deg == pytest.approx(4.0 * 5.0 - 0.5 * 1.25 * 5.0, abs=1.0)


@pytest.mark.parametrize(
    ("for_s", "is_missed", "is_changing"),
    [(4.0, True, True), (9.0, True, True), (14.0, True, True), (30.0, False, False)],
)
def test_a_rate_by_hand_that_was_not_reached_or_not_constant_is_told(
    tmp_path: Path, for_s: float, is_missed: bool, is_changing: bool
) -> None:
    """At 2 °/s² 20 °/s take 10 s: the second half of 14 s holds 3 s of ramp. As seen: 50 °/s asked, 7.6 told."""
    table, drive = DRIVE_FOR_ROLL
    with open_rig(read_rig(rig_file(tmp_path, (table, f"{drive}acceleration_dps2 = 2.0\n")))) as rig:
        home(rig, "roll", rig.clock.sleep)
        turn = turn_for(rig, "roll", 20.0, for_s, rig.clock.sleep)
    assert ("it was not reached" in turn.doubt) == is_missed
    assert ("it was not constant" in turn.doubt) == is_changing
    assert turn.doubt == "" or turn.doubt.startswith("asked for +20 °/s: ")


@pytest.mark.parametrize(
    ("position_deg", "rate_dps", "is_allowed"),
    [
        (44.0, 5.0, False),
        (44.0, -5.0, True),
        (-44.0, -5.0, False),
        (-44.0, 5.0, True),
        (0.0, 5.0, True),
        (0.0, -5.0, True),
    ],
)
def test_an_axis_is_turned_towards_neither_limit_that_it_would_soon_pass(
    rig: Rig, position_deg: float, rate_dps: float, is_allowed: bool
) -> None:
    with nullcontext() if is_allowed else pytest.raises(RequestRefused, match="leads beyond the limits"):
        require_room_to_turn(rig, "pitch", position_deg, rate_dps)


@pytest.mark.parametrize("rate_dps", [20.0, -20.0])
def test_an_axis_whose_cables_do_not_bear_it_is_not_turned(tmp_path: Path, rate_dps: float) -> None:
    table, stage = STAGE_FOR_ROLL
    with open_rig(read_rig(rig_file(tmp_path, (table, f"{stage}wrap_turns = 1.0\n")))) as rig:
        home(rig, "roll", rig.clock.sleep)
        with pytest.raises(RequestRefused, match="cable"):
            turn_for(rig, "roll", rate_dps, 30.0, rig.clock.sleep)  # 600 of 360 degrees
        rig.clock.sleep(5.0)
        assert rig.axes["roll"].state().position_deg == 0.0
