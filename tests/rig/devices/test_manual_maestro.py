"""What the Maestro's guide says commands do besides their purpose, put to the twin: docs/devices/maestro.md."""

from motion_bench import MotionBench, motion_bench

GET_POSITION, GET_ERRORS, GO_HOME = bytes.fromhex("90 00"), bytes.fromhex("A1"), bytes.fromhex("A2")
NEUTRAL = bytes.fromhex("84 00 70 2E")
FARTHER = bytes.fromhex("84 00 2C 32")
SLOWLY = bytes.fromhex("87 00 04 00")
OFF = bytes.fromhex("84 00 00 00")
BEYOND = bytes.fromhex("84 00 7F 7F")
UNKNOWN = bytes.fromhex("B0")


def _said(bench: MotionBench, data: bytes, after_s: float = 0.0) -> bytes:
    bench.clock.sleep(after_s)
    now_s = bench.clock.monotonic_s()
    bench.twin.receive(data, now_s)
    answer: bytes = bench.twin.transmit(now_s)
    return answer


def test_after_power_on_there_are_no_pulses() -> None:
    # p. 27: "On startup or error, the servos turn off (no pulses are sent)."
    assert _said(motion_bench("maestro"), GET_POSITION) == b"\x00\x00"


def test_the_first_target_behind_off_is_jumped_to_whatever_speed_is_set() -> None:
    # p. 58: "as soon as the servo is turned off, the Maestro has no way of knowing where it is"
    bench = motion_bench("maestro")
    _said(bench, SLOWLY)
    _said(bench, NEUTRAL)
    assert _said(bench, GET_POSITION) == bytes.fromhex("70 17")
    _said(bench, FARTHER)
    under_way = int.from_bytes(_said(bench, GET_POSITION, 0.1), "little")
    assert under_way == 6000 + 40, "speed 4 is 100 µs a second"
    _said(bench, OFF)
    assert _said(bench, GET_POSITION) == b"\x00\x00", "target 0 is no stop that holds"
    _said(bench, NEUTRAL)
    assert _said(bench, GET_POSITION) == bytes.fromhex("70 17")


def test_any_error_sends_the_servos_home_and_reading_clears_the_bits() -> None:
    # p. 39: "When an error occurs, the corresponding bit in the error register is set"; p. 44: then all are cleared
    bench = motion_bench("maestro")
    _said(bench, FARTHER)
    _said(bench, UNKNOWN)
    assert _said(bench, GET_ERRORS) == bytes.fromhex("10 00"), "bit 4: protocol"
    assert _said(bench, GET_ERRORS) == b"\x00\x00"
    assert _said(bench, GET_POSITION, 5.0) != bytes.fromhex("2C 19"), "it did not stay at its target"


def test_a_target_beyond_the_limits_is_clamped_without_an_error() -> None:
    bench = motion_bench("maestro")
    _said(bench, BEYOND)
    clamped = int.from_bytes(_said(bench, GET_POSITION), "little")
    assert 8000 <= clamped < 0x3FFF
    assert _said(bench, GET_ERRORS) == b"\x00\x00"


def test_home_is_a_position_or_off_and_not_the_last_target() -> None:
    # p. 58: "This command sends all servos and outputs to their home positions, just as if an error had occurred."
    bench = motion_bench("maestro")
    _said(bench, FARTHER)
    _said(bench, GO_HOME)
    assert _said(bench, GET_POSITION, 5.0) != bytes.fromhex("2C 19")
