"""Laws of rest on machines that behave as machines: loops that hunt, brakes that creep, stops that are lost."""

import pytest
from restless_axis import QUIET, Noise, RestlessAxis, digits, gaussian

from rig.errors import DeviceFault
from rig.motion.motion_memory import MotionMemory
from rig.motion.move import stop_all
from rig.motion.supervisor import Supervisor

READ_BACKS = {
    "quiet": QUIET,
    "last digit": digits(1e-4),
    "three digits": digits(3e-4),
    "0.0002°": gaussian(2e-4),
    "0.0003°": gaussian(3e-4),
}
LOUD = {**READ_BACKS, "0.0004°": gaussian(4e-4)}


def _seconds_to_rest(axis: RestlessAxis) -> float:
    begun_s = axis.clock.monotonic_s()
    stop_all({"yaw": axis}, axis.clock)
    return axis.clock.monotonic_s() - begun_s


@pytest.mark.parametrize("noise", READ_BACKS.values(), ids=READ_BACKS)
@pytest.mark.parametrize("rate_dps", [0.0, 20.0])
def test_a_loop_that_hunts_about_its_place_is_seen_to_stand_and_is_stopped_once(noise: Noise, rate_dps: float) -> None:
    """As seen: ±0.0001° of an ESP301 and 0.0003° of a rate table, for 20 s "still moving", and the run tripped."""
    taken_s = []
    for seed in range(30):
        axis = RestlessAxis(noise, rate_dps=rate_dps, seed=seed)
        taken_s.append(_seconds_to_rest(axis))
        assert len(axis.stops_s) == 1
    assert max(taken_s) < 8.0
    assert sorted(taken_s)[15] < 4.5


@pytest.mark.parametrize("noise", READ_BACKS.values(), ids=READ_BACKS)
def test_what_a_stop_saw_stand_is_known_to_stand(noise: Noise) -> None:
    """By whoever tells of the end, and of the next opening of its line."""
    for seed in range(30):
        axis, memory = RestlessAxis(noise, seed=seed), MotionMemory()
        supervised = Supervisor(axis.clock, memory=memory).supervise(axis)
        supervised.start_move(20.0)
        stop_all({"yaw": supervised}, axis.clock)
        assert memory.known("yaw").is_at_rest


def test_an_axis_that_does_not_hunt_is_seen_to_stand_in_a_second() -> None:
    assert _seconds_to_rest(RestlessAxis()) == pytest.approx(1.0, abs=0.11)


@pytest.mark.parametrize("noise", LOUD.values(), ids=LOUD)
@pytest.mark.parametrize("creep_dps", [0.1, -0.1, 0.03, 0.01, 0.003, -0.003, 0.001])
def test_a_brake_that_creeps_is_never_taken_for_rest(noise: Noise, creep_dps: float) -> None:
    """Down to twice the speed from which an axis creeps, 0.0005 °/s with a tolerance of 0.001°."""
    for seed in range(10):
        axis = RestlessAxis(noise, creep_dps=creep_dps, seed=seed)
        with pytest.raises(
            DeviceFault, match=r"still moving at .* 20 s after the stop: its read-back ran over 0\.\d+°"
        ):
            stop_all({"yaw": axis}, axis.clock)


@pytest.mark.parametrize("noise", READ_BACKS.values(), ids=READ_BACKS)
@pytest.mark.parametrize("look_s", [0.05, 0.4])
def test_a_line_that_answers_slowly_shows_rest_and_creep_as_well(noise: Noise, look_s: float) -> None:
    """Two questions with 0.3 s between them, as of a dialect without a word of state."""
    for seed in range(30):
        assert _seconds_to_rest(RestlessAxis(noise, look_s=look_s, seed=seed)) < 12.0
        creeping = RestlessAxis(noise, creep_dps=0.001, look_s=look_s, seed=seed)
        with pytest.raises(DeviceFault, match="still moving"):
            stop_all({"yaw": creeping}, creeping.clock)


@pytest.mark.parametrize("creep_dps", [0.1, 0.01, 0.003])
def test_a_brake_that_creeps_is_told_again_every_second(creep_dps: float) -> None:
    axis = RestlessAxis(digits(1e-4), creep_dps=creep_dps)
    with pytest.raises(DeviceFault, match=r"axes\.yaw: arrival_tolerance_deg"):
        stop_all({"yaw": axis}, axis.clock)
    assert len(axis.stops_s) >= 15


def test_a_creep_that_turns_by_less_than_a_tolerance_in_two_seconds_is_rest() -> None:
    """It is found by where the axis stands: five tolerances, looked at every second."""
    assert _seconds_to_rest(RestlessAxis(digits(1e-4), creep_dps=1e-4)) < 8.0


@pytest.mark.parametrize("noise", READ_BACKS.values(), ids=READ_BACKS)
@pytest.mark.parametrize(("rate_dps", "lost_stops"), [(50.0, 1), (50.0, 3), (0.5, 1), (0.05, 1)])
def test_a_stop_that_is_lost_is_told_again_though_the_machine_says_that_it_rests(
    noise: Noise, rate_dps: float, lost_stops: int
) -> None:
    """As seen: a table that says "rest" of a rotation turned on for 20 s at 50 °/s, without a second stop."""
    axis = RestlessAxis(noise, rate_dps=rate_dps, lost_stops=lost_stops)
    assert _seconds_to_rest(axis) < 8.0 + lost_stops
    assert len(axis.stops_s) == 1 + lost_stops
    assert axis.true_deg < rate_dps * 1.2 * lost_stops + 10.0
    assert axis.stops_s[1] - axis.stops_s[0] == pytest.approx(1.0, abs=0.2)
