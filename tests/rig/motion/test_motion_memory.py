"""What is known of an axis that nobody can look at: at rest only where it was seen so with nothing sent since."""

import pytest
from motion_bench import motion_bench

from rig.errors import MotionBreach
from rig.motion.motion_memory import MotionMemory
from rig.motion.move import home_and_arrive, move_and_arrive
from rig.motion.supervisor import Supervisor


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
