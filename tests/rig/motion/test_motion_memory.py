"""What is known of an axis that nobody can look at: at rest only where it was seen so with nothing sent since."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import pytest
from motion_bench import MotionBench, motion_bench

from rig.errors import DeviceSilent, MotionBreach, RequestRefused
from rig.link.faults import Part
from rig.motion.motion_memory import LATEST_S, MotionMemory
from rig.motion.move import home_and_arrive, move_and_arrive, stop_all
from rig.motion.supervisor import SupervisedAxis, Supervisor

LATE_S = 12.0


def test_an_axis_is_at_rest_only_where_it_was_seen_so_with_nothing_sent_since() -> None:
    bench, memory = motion_bench("indexing-table"), MotionMemory()
    pitch = Supervisor(bench.clock, memory=memory).supervise(bench.pitch)
    assert memory.in_words(["pitch"]) == (
        "pitch has not been read since the rig was opened, and nothing that moves it was sent",
    )
    home_and_arrive(pitch, bench.clock, bench.clock.sleep)
    assert memory.known("pitch").is_at_rest
    pitch.start_move(90.0)
    (sent,) = memory.in_words(["pitch"])
    assert sent.startswith(
        "whether pitch stands is not known: it was told to move to 90°, and its last read-back is 0.0"
    )
    bench.clock.sleep(1.0)
    assert pitch.state().is_moving
    assert memory.known("pitch").order == "move to 90°"
    pitch.stop()
    assert not memory.known("pitch").is_at_rest, "told to stop is not seen at rest"
    bench.clock.sleep(5.0)
    assert move_and_arrive(pitch, 30.0, bench.clock, bench.clock.sleep) == 30.0
    (rest,) = memory.in_words(["pitch"])
    assert rest.startswith("pitch was last read at rest at 30.0000°, 2024-03-01 ")
    assert rest.endswith("and nothing that moves it was sent since")


def test_what_was_known_outlives_the_connection() -> None:
    bench, memory = motion_bench("indexing-table"), MotionMemory()
    home_and_arrive(Supervisor(bench.clock, memory=memory).supervise(bench.pitch), bench.clock, bench.clock.sleep)
    Supervisor(bench.clock, memory=memory).supervise(bench.pitch)
    assert memory.known("pitch").is_at_rest


def test_an_axis_that_moves_unasked_is_not_said_to_stand() -> None:
    bench, memory = motion_bench("indexing-table"), MotionMemory()
    pitch = Supervisor(bench.clock, memory=memory).supervise(bench.pitch)
    home_and_arrive(pitch, bench.clock, bench.clock.sleep)
    bench.pitch.start_move(90.0)  # past the supervisor, as another program would
    bench.clock.sleep(1.0)
    with pytest.raises(MotionBreach):
        pitch.state()
    assert memory.in_words(["pitch"])[0].startswith("whether pitch stands is not known: its last read-back is ")


def _holds_the_next_move(bench: MotionBench, part_of: Callable[[bytes], Part]) -> None:
    """From now on, until one was held. A line that lets what follows overtake it, as some gateways do."""
    held: list[bytes] = []

    def hold(data: bytes) -> tuple[Part, ...]:
        if b"MOVE" not in data or held:
            return (Part(data),)
        held.append(data)
        return (part_of(data),)

    bench.faults.writes = dict.fromkeys(range(10**4), hold)


@dataclass
class _Guard:
    """A stop guard that was asked for a stop from elsewhere, or was not."""

    why: str = ""

    def expect_motion(self, moving: Sequence[str], ways: Mapping[str, tuple[int, int]]) -> None: ...
    def beat(self, moving: Sequence[str], silence_s: float) -> None: ...
    def stop_now(self) -> bool:
        return False

    def take_trouble(self) -> None: ...
    def why_stop(self) -> str:
        return self.why


def _pitch_at_home(
    why: str = "", driver: str = "indexing-table"
) -> tuple[MotionBench, MotionMemory, SupervisedAxis, _Guard]:
    bench, memory, guard = motion_bench(driver), MotionMemory(), _Guard()
    pitch = Supervisor(bench.clock, guard, memory).supervise(bench.pitch)
    home_and_arrive(pitch, bench.clock, bench.clock.sleep)
    guard.why = why
    return bench, memory, pitch, guard


def test_an_order_that_nobody_answered_is_in_doubt_through_every_stop_until_it_comes() -> None:
    bench, memory, pitch, _ = _pitch_at_home()
    _holds_the_next_move(bench, lambda data: Part(data, LATE_S))
    with pytest.raises(DeviceSilent):
        pitch.start_move(90.0)
    stop_all({"pitch": pitch}, bench.clock)
    assert memory.known("pitch").is_at_rest
    (doubt,) = memory.in_doubt(["pitch", "roll"])
    given = r"pitch: the order to move to 90° of 2024-03-01 \d\d:\d\d:\d\d UTC was neither acknowledged nor seen to be"
    assert re.fullmatch(given + " taken up, and may still come", doubt)
    assert memory.in_words(["pitch"])[0].endswith(doubt.removeprefix("pitch: "))
    bench.clock.sleep(LATE_S)
    bench.pitch.state()
    bench.clock.sleep(1.0)
    with pytest.raises(MotionBreach):  # it came, and no stop of before kept it
        pitch.state()
    assert memory.in_doubt(["pitch"]) == ()


def test_an_order_that_was_lost_before_one_that_was_answered_may_come_for_a_minute() -> None:
    bench, memory, pitch, _ = _pitch_at_home()
    _holds_the_next_move(bench, lambda data: Part(b""))
    move_and_arrive(pitch, 30.0, bench.clock, bench.clock.sleep)  # told twice: the first told nobody anything
    assert memory.in_doubt(["pitch"]) == (), "it leads to where the axis rests"
    move_and_arrive(pitch, 40.0, bench.clock, bench.clock.sleep)
    assert memory.waiting_settles(["pitch"])
    (doubt,) = memory.in_doubt(["pitch"])
    assert doubt.startswith("pitch: the order to move to 30°")
    bench.clock.sleep(LATEST_S)
    pitch.state()
    assert memory.in_doubt(["pitch"]) == ()
    _holds_the_next_move(bench, lambda data: Part(b""))
    with pytest.raises(DeviceSilent):
        pitch.start_move(90.0)
    pitch.stop()
    bench.clock.sleep(10.0 * LATEST_S)
    pitch.state()
    assert memory.in_doubt(["pitch"]), "nothing behind it was answered: nobody knows that the line carries anything"


def test_an_order_that_was_seen_to_be_taken_up_is_in_doubt_no_more() -> None:
    bench, memory, pitch, guard = _pitch_at_home("stopped from elsewhere")
    pitch.start_move(90.0)
    assert memory.in_doubt(["pitch"]), "its answer may have been that of the guard's stop"
    guard.why = ""
    pitch.stop()
    bench.clock.sleep(3.0)
    assert not pitch.state().is_moving
    assert memory.in_doubt(["pitch"]), "it did not move by more than a read-back wanders"
    bench, memory, pitch, _ = _pitch_at_home("stopped from elsewhere")
    pitch.start_move(90.0)
    bench.clock.sleep(1.0)
    pitch.state()
    assert memory.in_doubt(["pitch"]) == ()


def test_an_order_that_was_refused_before_it_was_sent_leaves_no_doubt_and_ends_none() -> None:
    bench, memory, pitch, _ = _pitch_at_home()

    def refuse(_target_deg: float) -> None:
        raise RequestRefused("pitch: the axis is not homed; nothing moved")

    start_move, bench.pitch.start_move = bench.pitch.start_move, refuse
    with pytest.raises(RequestRefused):
        pitch.start_move(30.0)
    assert memory.in_doubt(["pitch"]) == ()
    bench.pitch.start_move = start_move
    _holds_the_next_move(bench, lambda data: Part(b""))
    with pytest.raises(DeviceSilent):
        pitch.start_move(90.0)
    bench.pitch.start_move = refuse
    with pytest.raises(RequestRefused):
        pitch.start_move(30.0)
    bench.clock.sleep(2.0 * LATEST_S)
    pitch.stop()
    pitch.state()
    (doubt,) = memory.in_doubt(["pitch"])
    assert "the order to move to 90°" in doubt
