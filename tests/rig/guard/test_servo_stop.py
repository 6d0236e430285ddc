"""A servo is sent nowhere by the stop guard but to where it is, on the way of its order; one that stood, nowhere."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from guarded_engine import until
from hypothesis import given
from hypothesis import strategies as st
from timed_servos import CLOCK, NEUTRAL, TimedServos, timed_servos

from rig.guard.line import Line
from rig.guard.outcomes import SLOWED, STOOD
from rig.guard.servo_stop import ServoStop, Untrusted
from rig.wire.maestro import GET_ERRORS, GET_POSITION, GET_SCRIPT_STATUS, SET_SPEED, SET_TARGET, MaestroCodec, set_speed

CODEC = MaestroCodec(None, has_crc=False)
PITCH, ROLL = 0, 1
PATIENCE_S = 0.25
AIM = {"device": None, "has_crc": False, "limits": (3968, 8000), "patience_s": PATIENCE_S}
WAY = [NEUTRAL, 4000]
TOLERANCE = 4
"""A microsecond."""
LAG = 200
"""A servo at its lowest speed goes so far in two seconds, which a busy machine may put between answer and order."""
TRIALS = 16
ENGINE_ASKS = (
    bytes([GET_ERRORS]),
    bytes([GET_POSITION, PITCH]),
    bytes([GET_POSITION, ROLL]) + bytes([GET_SCRIPT_STATUS]),
)


def _line(served: TimedServos) -> Line:
    axes = {
        name: [{"send": CODEC.encode(set_speed(channel, 1)).hex(), "aim": {"channel": channel, **AIM}}]
        for channel, name in enumerate(("pitch", "roll"))
    }
    document = {"name": "servos", "address": served.path, "is_escaped": False, "axes": axes}
    return Line(document, os.dup(served.descriptor))


def _stopped(served: TimedServos, moving: list[str], ways: dict[str, list[int]]) -> dict[str, str]:
    """As the guard stops the line of an engine that is dead."""
    line, outcomes = _line(served), dict[str, str]()
    try:
        assert line.stop_now(None, moving, outcomes)
        line.aim(moving, ways, outcomes)
    finally:
        line.release()
    return outcomes


def _dies_in_a_question(
    number: int, latency_s: float, damage: Callable[[np.random.Generator], Callable[[bytes], bytes]]
) -> tuple[TimedServos, dict[str, str]]:
    """An engine asks one thing after the other of both servos, roll under way, and is gone at some moment."""
    chance = np.random.default_rng(number)
    with timed_servos(latency_s, damage(chance)) as served:
        served.start(ROLL, WAY[1])
        CLOCK.sleep(float(chance.uniform(0.05, 0.6)))
        for asked in chance.permutation(len(ENGINE_ASKS))[: chance.integers(1, len(ENGINE_ASKS) + 1)]:
            os.write(served.descriptor, ENGINE_ASKS[asked])
            CLOCK.sleep(float(chance.uniform(0.0, 0.01)))
        served.is_damaging = True
        return served, _stopped(served, ["roll"], {"pitch": [NEUTRAL, 7000], "roll": WAY})


def _trials(
    latency_s: float, damage: Callable[[np.random.Generator], Callable[[bytes], bytes]]
) -> list[tuple[TimedServos, dict[str, str]]]:
    with ThreadPoolExecutor(TRIALS) as threads:
        return list(threads.map(lambda number: _dies_in_a_question(number, latency_s, damage), range(TRIALS)))


def _is_on_the_way(channel: int, target: int) -> bool:
    return channel == ROLL and min(WAY) - TOLERANCE <= target <= max(WAY) + TOLERANCE


@pytest.mark.parametrize("latency_s", [0.0, 0.04, 0.2])
def test_fault_94_an_answer_that_the_dead_engine_had_asked_for_is_nobodys_position(latency_s: float) -> None:
    """Detected: silence for as long as an answer takes, then marks, length, agreement, limits and way of the answer.
    Response: a servo under way is sent to where it is; one that stood is sent nowhere; the record tells what was sent.
    """
    for served, outcomes in _trials(latency_s, lambda _chance: lambda reply: reply):
        assert outcomes["pitch"] == STOOD
        assert outcomes["roll"].startswith("told to stop at "), outcomes
        assert outcomes["roll"].endswith("read back there") or "; not read back: " in outcomes["roll"], outcomes
        for channel, target, pulse in served.targets:
            assert _is_on_the_way(channel, target), served.targets
            assert abs(target - pulse) <= LAG, served.targets
        assert served.targets
        _is_silent_before_the_question(served)


def _is_silent_before_the_question(served: TimedServos) -> None:
    """All that the engine had asked for has been answered for so long as an answer takes."""
    (slowed, *_) = [number for number, (_, command) in enumerate(served.heard) if command == SET_SPEED]
    (asked_s, *_) = [at_s for at_s, command in served.heard[slowed:] if command == GET_SCRIPT_STATUS]
    near = [at_s for at_s in served.answered_s if asked_s - PATIENCE_S < at_s < asked_s]
    assert not near, (asked_s, near)


def _struck(chance: np.random.Generator) -> Callable[[bytes], bytes]:
    """Every other reply is altered: a bit, another servo's pulse, a mark too many, doubled, cut, nothing."""

    def damage(reply: bytes) -> bytes:
        if not reply or chance.random() < 0.5:
            return reply
        flipped = bytearray(reply)
        flipped[chance.integers(len(flipped))] ^= 1 << int(chance.integers(8))
        return (bytes(flipped), NEUTRAL.to_bytes(2, "little"), b"\1\1", reply * 2, reply[:1], b"")[chance.integers(6)]

    return damage


def test_no_damaged_answer_sends_a_servo_off_the_way_of_its_order() -> None:
    for served, outcomes in _trials(0.01, _struck):
        assert all(_is_on_the_way(channel, target) for channel, target, _ in served.targets), served.targets
        aimed = outcomes["roll"].startswith("told to stop at ")
        assert aimed is bool(served.targets)
        assert aimed or outcomes["roll"].startswith("NOT told to stop: it goes on at its lowest speed to where it was")


@given(
    st.binary(max_size=12) | st.binary(min_size=4, max_size=4).map(lambda data: b"\1%b\1%b\1" % (data[:2], data[2:]))
)
def test_whatever_is_answered_only_a_pulse_of_the_way_becomes_a_target(reply: bytes) -> None:
    stop = ServoStop({"channel": ROLL, **AIM}, WAY)
    try:
        order = stop.order(stop.position(reply))
    except Untrusted:
        return
    assert (order[0], order[1]) == (SET_TARGET, ROLL)
    assert _is_on_the_way(order[1], order[2] | order[3] << 7)
    assert len(reply) == 7


def test_a_way_beyond_the_channels_own_limits_ends_at_these() -> None:
    stop = ServoStop({"channel": ROLL, **AIM}, [3000, NEUTRAL])
    with pytest.raises(Untrusted, match="it says 875 µs, and its way is 992 µs to 1501 µs"):
        stop.position(b"\1" + (3500).to_bytes(2, "little") + b"\1" + (3500).to_bytes(2, "little") + b"\1")


def test_a_servo_whose_way_nobody_knows_is_slowed_and_the_record_says_so() -> None:
    with timed_servos() as served:
        served.start(ROLL, WAY[1])
        outcomes = _stopped(served, ["roll"], {})
        assert until(lambda: served.servos[ROLL].speed == 1, 5.0)
    assert served.targets == []
    assert outcomes["roll"] == (
        "NOT told to stop: it goes on at its lowest speed to where it was sent: where it came from is not known"
    )


def test_the_line_of_an_engine_that_lives_is_written_to_and_not_read() -> None:
    """What it had asked for comes to it whole."""
    with timed_servos() as served:
        served.start(ROLL, WAY[1])
        line, outcomes = _line(served), dict[str, str]()
        os.write(served.descriptor, bytes([GET_POSITION, ROLL]))
        assert line.stop_now(None, ["roll"], outcomes)
        line.release()
        answer = b""
        while len(answer) < 2:
            answer += os.read(served.descriptor, 2 - len(answer))
        assert until(lambda: served.servos[ROLL].speed == 1, 5.0)
    assert outcomes == {"pitch": STOOD, "roll": SLOWED}
    assert min(WAY) <= int.from_bytes(answer, "little") <= max(WAY)
    assert (served.servos[PITCH].speed, served.targets) == (20, [])
