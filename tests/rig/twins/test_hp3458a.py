"""The meter's twin against the user's guide, by literal bytes over the bus."""

import pytest
from gpib_rig import GpibRig, gpib_rig
from hypothesis import given
from hypothesis import strategies as st

from rig.twins import hp3458a as meter_twin
from rig.twins.hp3458a import Hp3458aTwin

READING_S = 2 * 10 / 50  # NPLC 10 with autozero at 50 Hz


def one_volt(now_s: float) -> float:
    return 1.0


def said(twin: Hp3458aTwin, message: bytes, now_s: float = 0.0) -> bytes:
    twin.listen(message, now_s)
    return twin.talk(now_s)[0]


def quiet_meter(volts: float = 1.0) -> Hp3458aTwin:
    twin = Hp3458aTwin(lambda now_s: volts)
    twin.listen(b"END ALWAYS;TARM HOLD;INBUF ON", 0.0)
    return twin


def read_all(twin: Hp3458aTwin, now_s: float) -> list[bytes]:
    readings = []
    while data := twin.talk(now_s)[0]:
        readings.append(data)
    return readings


def test_it_answers_as_in_the_guide() -> None:
    twin = quiet_meter()
    assert said(twin, b"ID?") == b"HP3458A\r\n"
    assert said(twin, b"id?\r\n") == b"HP3458A\r\n"
    assert said(twin, b"ERRSTR?") == b'0,"NO ERROR"\r\n'
    assert float(said(twin, b"TEMP?")) > 20.0


def test_the_reset_state_is_that_of_the_guide() -> None:
    # 3458A user's guide, RESET: AZERO ON, DCV AUTO, END OFF, NPLC 10, NRDGS 1,AUTO, OFORMAT ASCII.
    twin = quiet_meter()
    twin.listen(b"NPLC 1;AZERO OFF;NRDGS 7", 0.0)
    twin.listen(b"RESET", 0.0)
    queries = {b"END?": 0, b"AZERO?": 1, b"NPLC?": 10, b"OFORMAT?": 1, b"TARM?": 1, b"TRIG?": 1}
    assert {query: float(said(twin, query)) for query in queries} == queries
    assert said(twin, b"NRDGS?") == b"1, 1\r\n"


def test_ratio_divides_by_the_reference_at_the_sense_terminals() -> None:
    # 3458A user's guide, RATIO (docstring): "Ratio = Signal Voltage / DC Reference Voltage"; RESET executes RATIO OFF.
    twin = quiet_meter(9.99)
    assert float(said(twin, b"RATIO?")) == 0
    twin.listen(b"RATIO ON", 0.0)
    assert float(said(twin, b"RATIO?")) == 1
    twin.listen(b"TARM SGL", 0.0)
    assert [float(line) for line in read_all(twin, READING_S * 1.01)] == [9.99 / meter_twin.SENSE_V]
    twin.listen(b"RESET", 0.0)
    assert float(said(twin, b"RATIO?")) == 0


def test_the_switch_of_its_inputs_is_asked_for_and_no_reset_turns_it() -> None:
    # Keithley 2002 manual p. H-21 (emulation of the 3458A): "Returns status of INPUTS switch (1= Front; 2=Rear)".
    twin = quiet_meter()
    assert said(twin, b"TERM?") == b"1\r\n"
    twin.is_front = False
    twin.listen(b"RESET", 0.0)
    assert said(twin, b"TERM?") == b"2\r\n"


def test_preset_norm_is_triggered_by_talking() -> None:
    # 3458A user's guide, PRESET NORM: TARM AUTO, TRIG SYN, NPLC 1; addressing it to talk takes one reading.
    twin = Hp3458aTwin(one_volt)
    twin.listen(b"PRESET NORM;END ALWAYS", 0.0)
    assert said(twin, b"TRIG?") == b"5\r\n"
    assert twin.talk(1.0) == (b"", False)
    due_s = twin.next_talk_s()
    assert due_s == pytest.approx(1.0 + 2 * 1 / 50, abs=0.002)
    assert due_s is not None
    assert twin.talk(due_s) == (b" 1.000000000E+00\r\n", True)


def test_a_burst_comes_reading_by_reading() -> None:
    twin = quiet_meter()
    twin.listen(b"NRDGS 3,AUTO;TRIG AUTO", 0.0)
    twin.listen(b"TARM SGL", 0.0)
    assert twin.talk(READING_S * 0.99) == (b"", False)
    assert len(read_all(twin, READING_S * 1.01)) == 1
    assert len(read_all(twin, READING_S * 10.0)) == 2
    assert read_all(twin, READING_S * 99.0) == []
    assert said(twin, b"TARM?") == b"4\r\n"  # after SGL it holds


def test_without_an_input_buffer_the_bus_is_held_to_the_end_of_the_burst() -> None:
    # 3458A user's guide, INBUF OFF: the bus is held until the command is done, a TARM SGL burst included.
    twin = quiet_meter()
    twin.listen(b"NRDGS 3,AUTO;INBUF OFF", 0.0)
    assert twin.listen(b"TARM SGL", 0.0) == pytest.approx(3 * READING_S, abs=0.01)
    twin.clear(0.0)
    twin.listen(b"INBUF ON", 0.0)
    assert twin.listen(b"TARM SGL", 0.0) == 0.0


def test_end_says_when_eoi_comes() -> None:
    twin = quiet_meter()
    for word, at_reply, at_readings in ((b"OFF", False, [False, False]), (b"ON", True, [False, True])):
        twin.listen(b"NRDGS 2;END " + word, 0.0)
        twin.listen(b"ID?", 0.0)
        assert twin.talk(0.0) == (b"HP3458A\r\n", at_reply)
        twin.listen(b"TARM SGL", 0.0)
        assert [twin.talk(9.0)[1], twin.talk(9.0)[1]] == at_readings
    twin.listen(b"END ALWAYS", 0.0)
    twin.listen(b"TARM SGL", 0.0)
    assert [twin.talk(9.0)[1], twin.talk(9.0)[1]] == [True, True]


@pytest.mark.parametrize(
    ("volts", "range_v", "line"),
    [
        (12.1, b"10", b" 1.000000000E+38\r\n"),  # full scale of 10 V is 12 V
        (-12.1, b"10", b"-1.000000000E+38\r\n"),
        (12.0, b"10", b" 1.200000000E+01\r\n"),
        (-0.00123456789, b"0.1", b"-1.234567890E-03\r\n"),
        (12.1, b"AUTO", b" 1.210000000E+01\r\n"),
    ],
)
def test_overload_is_told_with_its_sign(volts: float, range_v: bytes, line: bytes) -> None:
    twin = quiet_meter(volts)
    twin.listen(b"DCV " + range_v, 0.0)
    twin.listen(b"TARM SGL", 0.0)
    assert twin.talk(9.0)[0] == line


def test_function_and_range_read_back() -> None:
    twin = quiet_meter()
    twin.listen(b"DCV 12", 0.0)
    assert [float(part) for part in said(twin, b"FUNC?").split(b",")] == [1.0, 10.0]
    twin.listen(b"FUNC DCV,100", 0.0)
    assert [float(part) for part in said(twin, b"FUNC?").split(b",")] == [1.0, 100.0]


@pytest.mark.parametrize(
    ("command", "function", "range_value", "reading"),
    [
        (b"OHM 1E3", 4.0, 1e3, 500.0),  # 0.5 V over the 1 mA of the range
        (b"FUNC OHM,1E4", 4.0, 1e4, 5000.0),
        (b"OHM 100", 4.0, 100.0, 1e38),  # 500 ohm, full scale 120 ohm
        (b"ACV 10", 2.0, 10.0, 0.0),  # of a steady input
        (b"OHM 1E3;DCV 1", 1.0, 1.0, 0.5),
        (b"ACV 10;PRESET NORM;DCV 10;TARM HOLD;TRIG AUTO", 1.0, 10.0, 0.5),
    ],
)
def test_another_function_is_answered_and_measured(
    command: bytes, function: float, range_value: float, reading: float
) -> None:
    # 3458A user's guide, FUNC: DCV 1, ACV 2, OHM 4; "FUNC?" answers function and range.
    twin = quiet_meter(0.5)
    twin.listen(command, 0.0)
    assert [float(part) for part in said(twin, b"FUNC?").split(b",")] == [function, range_value]
    twin.listen(b"TARM SGL", 0.0)
    assert float(twin.talk(9.0)[0]) == pytest.approx(reading, rel=1e-9)
    assert said(twin, b"ERRSTR?") == b'0,"NO ERROR"\r\n'


def test_settings_are_written_as_a_real_meter_writes_them() -> None:
    twin = quiet_meter()
    twin.listen(b"DCV 0.1", 0.0)
    assert [said(twin, query) for query in (b"FUNC?", b"RANGE?", b"NRDGS?")] == [b"1, .1\r\n", b".1\r\n", b"1, 1\r\n"]


@pytest.mark.parametrize(
    ("command", "operations", "readings"),
    [
        (b"MATH OFF", b"0,0\r\n", [3.0, 4.0]),
        (b"MATH NULL", b"7,0\r\n", [0.0, 1.0]),  # the first reading is the offset
        (b"SMATH SCALE,2;MATH SCALE", b"11,0\r\n", [1.5, 2.0]),
        (b"SMATH SCALE,2;SMATH OFFSET,1;MATH SCALE", b"11,0\r\n", [1.0, 1.5]),
        (b"MATH NULL;RESET;TARM HOLD;END ALWAYS;NRDGS 2", b"0,0\r\n", [3.0, 4.0]),
    ],
)
def test_mathematics_change_what_a_reading_is(command: bytes, operations: bytes, readings: list[float]) -> None:
    # 3458A user's guide, MATH: NULL = reading - OFFSET, OFFSET the first reading; SCALE = (reading - OFFSET) / SCALE.
    levels = iter([3.0, 4.0])
    twin = Hp3458aTwin(lambda _now_s: next(levels))
    twin.listen(b"END ALWAYS;TARM HOLD;NRDGS 2", 0.0)
    twin.listen(command, 0.0)
    assert said(twin, b"MATH?") == operations
    twin.listen(b"TARM SGL", 0.0)
    assert [float(line) for line in read_all(twin, 9.0)] == pytest.approx(readings)


def test_an_external_trigger_never_comes() -> None:
    twin = quiet_meter()
    twin.listen(b"TRIG EXT;TARM SGL", 0.0)
    assert said(twin, b"TRIG?") == b"2\r\n"
    assert twin.talk(99.0)[0] == b""


def test_a_fixed_range_ends_autoranging() -> None:
    twin = quiet_meter()
    assert said(twin, b"ARANGE?") == b"1\r\n"
    twin.listen(b"DCV 10", 0.0)
    assert said(twin, b"ARANGE?") == b"0\r\n"
    twin.listen(b"ARANGE ON", 0.0)
    assert said(twin, b"ARANGE?") == b"1\r\n"


@pytest.mark.parametrize(("question", "set_to"), [(0.5, 0.5), (1, 1), (7.2, 8), (10, 10), (12, 20), (100, 100)])
def test_power_line_cycles_come_in_steps(question: float, set_to: float) -> None:
    # 3458A user's guide, NPLC: steps of 1 from 1 to 10, of 10 from 10 to 1000.
    twin = quiet_meter()
    twin.listen(b"NPLC %g" % question, 0.0)
    assert float(said(twin, b"NPLC?")) == set_to


@pytest.mark.parametrize(
    ("message", "error"),
    [
        (b"NONSENSE", b'103,"SYNTAX ERROR"\r\n'),
        (b"NPLC 2000", b'106,"PARAMETER OUT OF RANGE"\r\n'),
        (b"MATH STAT", b'105,"UNDEFINED PARAMETER RECEIVED"\r\n'),  # not modelled
        (b"TARM LEVEL", b'105,"UNDEFINED PARAMETER RECEIVED"\r\n'),
        (b"OFORMAT PINK", b'105,"UNDEFINED PARAMETER RECEIVED"\r\n'),
    ],
)
def test_a_wrong_command_is_told_once(message: bytes, error: bytes) -> None:
    twin = quiet_meter()
    twin.listen(message, 0.0)
    assert twin.serial_poll(0.0) & 32
    assert said(twin, b"ERRSTR?") == error
    assert said(twin, b"ERRSTR?") == b'0,"NO ERROR"\r\n'
    assert not twin.serial_poll(0.0) & 32


def test_the_lowest_error_is_told_first() -> None:
    twin = quiet_meter()
    twin.listen(b"NPLC 2000;NONSENSE", 0.0)
    assert [said(twin, b"ERRSTR?")[:3] for _ in range(3)] == [b"103", b"106", b'0,"']


def test_the_status_tells_data_ready_and_power() -> None:
    twin = quiet_meter()
    assert twin.serial_poll(0.0) & 8  # power-on, until it is cleared
    twin.listen(b"CSB;NRDGS 2", 0.0)
    assert twin.serial_poll(0.0) == 16
    twin.listen(b"TARM SGL", 0.0)
    assert twin.serial_poll(0.0) == 0
    assert twin.serial_poll(READING_S * 1.01) == 128
    assert twin.serial_poll(READING_S * 9.0) == 128 | 16
    twin.clear(READING_S * 9.0)
    assert twin.serial_poll(READING_S * 9.0) == 16


def test_a_reading_is_taken_when_it_is_due_and_not_when_it_is_fetched() -> None:
    twin = Hp3458aTwin(lambda now_s: now_s)
    twin.listen(b"END ALWAYS;TARM HOLD;INBUF ON;NRDGS 2;TARM SGL", 0.0)
    values = [float(line) for line in read_all(twin, 9.0)]
    assert values == pytest.approx([READING_S, 2 * READING_S], abs=0.002)


def test_a_power_failure_forgets_everything() -> None:
    twin = quiet_meter()
    twin.listen(b"CSB;NPLC 1", 0.0)
    twin.power_cycle()
    twin.listen(b"END ALWAYS", 0.0)
    assert said(twin, b"NPLC?") == b"10\r\n"
    assert twin.serial_poll(0.0) & 8


def test_the_scanner_decides_what_is_measured() -> None:
    rig: GpibRig = gpib_rig()
    rig.meter.listen(b"END ALWAYS;TARM HOLD", 0.0)

    def measured() -> float:
        rig.meter.listen(b"TARM SGL", 0.0)
        return float(rig.meter.talk(9.0)[0])

    assert measured() == 0.0
    rig.scanner.listen(b"CLOSE 102", 0.0)
    assert measured() == pytest.approx(-2.0, abs=1e-3)
    rig.scanner.listen(b"CLOSE 101", 0.0)
    assert measured() == pytest.approx(-0.5, abs=1e-3)  # two outputs of one resistance meet in the middle


@given(st.binary(max_size=40))
def test_no_message_upsets_it(message: bytes) -> None:
    twin = Hp3458aTwin(one_volt)
    assert twin.listen(message, 0.0) >= 0.0
    data, _ = twin.talk(0.0)
    assert isinstance(data, bytes)
    assert 0 <= twin.serial_poll(0.0) < 256
