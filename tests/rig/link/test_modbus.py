"""Laws of our Modbus RTU conversation. Frames: wire facts, section 4; late replies: the measured fact f5."""

from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from table_bench import virtual_clock

from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, DeviceSilent, LinkLost, RigError
from rig.link import faults
from rig.link.faults import FaultScript
from rig.link.memory import MemoryStream
from rig.link.modbus import ModbusRtu


class Slave:
    """A slave by literal bytes: answers what ``answer`` says, keeps what it was asked."""

    def __init__(self, answer: Callable[[bytes], bytes]) -> None:
        self.questions: list[bytes] = []
        self._answer = answer
        self._due = b""

    def receive(self, data: bytes, now_s: float) -> None:
        self.questions.append(data)
        self._due += self._answer(data)

    def transmit(self, now_s: float) -> bytes:
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return None


READ_PV, PV_25_3 = bytes.fromhex("01 03 00 64 00 01 C5 D5"), bytes.fromhex("01 03 02 00 FD 79 C5")
WRITE_SP = bytes.fromhex("01 06 01 2C FF 33 48 1A")
ILLEGAL = bytes.fromhex("01 83 02 C0 F1")


def _checked(body: bytes) -> bytes:
    """With the Modbus checksum: polynomial A001 reflected, start FFFF, low byte first (serial line guide V1.02)."""
    crc = 0xFFFF
    for byte in body:
        crc ^= byte
        for _ in range(8):
            crc = (crc >> 1) ^ (0xA001 if crc & 1 else 0)
    return body + crc.to_bytes(2, "little")


def _registers(request: bytes) -> bytes:
    """Register n holds n."""
    address, count = int.from_bytes(request[2:4], "big"), int.from_bytes(request[4:6], "big")
    values = b"".join((address + index).to_bytes(2, "big") for index in range(count))
    return _checked(request[:2] + bytes([len(values)]) + values)


def _master(answer: Callable[[bytes], bytes], script: FaultScript | None = None) -> tuple[ModbusRtu, Slave]:
    slave = Slave(answer)
    return ModbusRtu(MemoryStream(slave, virtual_clock(), "chamber", script), 1), slave


@pytest.mark.parametrize(("baud_rate", "gap_s"), [(9600, 3.5 * 11 / 9600), (115200, 0.00175)])
def test_a_frame_is_told_from_the_one_before_by_three_and_a_half_characters(baud_rate: int, gap_s: float) -> None:
    """Modbus over serial line V1.02, section 2.5.1.1: characters of 11 bits, 1.750 ms above 19 200 baud."""
    arrived_s: list[float] = []
    clock = virtual_clock()

    def answer(_: bytes) -> bytes:
        arrived_s.append(clock.monotonic_s())
        return PV_25_3

    master = ModbusRtu(MemoryStream(Slave(answer), clock, "chamber"), 1, baud_rate=baud_rate)
    for _ in range(3):
        master.read_holding(100)
    assert arrived_s[2] - arrived_s[1] == pytest.approx(gap_s, rel=1e-6)


def test_the_checksum_rule_agrees_with_the_published_frames() -> None:
    for frame in (READ_PV, PV_25_3, WRITE_SP, ILLEGAL):
        assert _checked(frame[:-2]) == frame


def test_a_read_is_these_bytes() -> None:
    master, slave = _master(lambda _: PV_25_3)
    assert master.read_holding(100) == (253,)
    assert slave.questions == [READ_PV]


def test_a_write_is_these_bytes_and_its_echo_is_checked() -> None:
    master, slave = _master(lambda request: request)
    master.write_register(300, 0xFF33)
    assert slave.questions == [WRITE_SP]
    wrong, _ = _master(lambda _: _checked(bytes.fromhex("01 06 01 2C FF 34")))
    with pytest.raises(DeviceNonsense, match="the echo names register 300"):
        wrong.write_register(300, 0xFF33)


@pytest.mark.parametrize(
    ("code", "kind"),
    [
        *((code, DeviceRefused) for code in (1, 2, 3, 5, 6)),
        *((code, DeviceFault) for code in (4, 8)),
        *((code, LinkLost) for code in (10, 11)),
        (99, DeviceNonsense),
    ],
)
def test_every_exception_code_says_who_must_act(code: int, kind: type[RigError]) -> None:
    master, _ = _master(lambda _: _checked(bytes([1, 0x83, code])))
    with pytest.raises(kind, match=rf"exception {code} "):
        master.read_holding(100)


@pytest.mark.parametrize("code", [5, 6])  # Modbus application protocol V1.1b3, section 7: acknowledge, device busy
def test_a_busy_slave_is_asked_again_for_a_while(code: int) -> None:
    answers = iter([_checked(bytes([1, 0x83, code]))] * 2 + [PV_25_3])
    master, slave = _master(lambda _: next(answers))
    assert master.read_holding(100) == (253,)
    assert len(slave.questions) == 3


@pytest.mark.parametrize(
    ("reply", "why"),
    [
        (PV_25_3[:-1] + b"\xc4", "checksum"),
        (_checked(bytes.fromhex("02 03 02 00 FD")), "unit 2 answered"),
        (_checked(bytes.fromhex("01 04 02 00 FD")), "function 4 answered"),
        (_checked(bytes.fromhex("01 03 04 00 FD 00 FD")), "more bytes|holds 4 bytes"),
        (PV_25_3 + PV_25_3, "more bytes than one reply"),
    ],
)
def test_a_reply_that_cannot_be_the_answer_is_nonsense(reply: bytes, why: str) -> None:
    master, _ = _master(lambda _: reply)
    with pytest.raises(DeviceNonsense, match=why):
        master.read_holding(100)


def test_silence_is_told_with_the_register_and_the_deadline() -> None:
    master, slave = _master(lambda _: b"")
    with pytest.raises(
        DeviceSilent, match=r"chamber: no whole reply to function 3, register 100: got nothing within 1 s"
    ):
        master.read_holding(100)
    assert len(slave.questions) == 3


@pytest.mark.parametrize("late_s", [1.05, 1.15, 1.5, 2.3])
def test_fault_33_a_late_reply_is_never_the_value_of_another_register(late_s: float) -> None:
    """f5: pymodbus' own client returns register 10's value for register 20 here, without an error.

    Detected: after a time-out the line must be quiet and a sentinel be answered.
    Response: the value is asked for anew; a late reply is never another register's.
    """
    script = FaultScript()
    master, _ = _master(_registers, script)
    master.set_sentinel(606, 606)
    assert master.read_holding(606) == (606,)
    script.reads = {script.taken: faults.stall(late_s)}
    assert master.read_holding(10) == (10,)
    assert [master.read_holding(register) for register in (20, 30, 40)] == [(20,), (30,), (40,)]


def test_after_a_register_that_never_answered_its_late_reply_is_not_the_next_registers() -> None:
    script = FaultScript()
    master, _ = _master(_registers, script)
    master.set_sentinel(606, 606)
    assert master.read_holding(606) == (606,)
    first = script.taken
    # Register 10 is answered after 3.8 s, when everything is given up; what is asked meanwhile is lost.
    script.reads = {first: faults.stall(3.8)} | dict.fromkeys(range(first + 1, first + 4), faults.drop)
    with pytest.raises(DeviceSilent):
        master.read_holding(10)
    assert master.read_holding(20) == (20,)
    assert master.counts.nonsense >= 1  # the late reply stood for the sentinel, which cannot be 10


def test_a_late_answer_to_an_earlier_sentinel_does_not_clear_the_doubt() -> None:
    script = FaultScript()
    master, _ = _master(_registers, script)
    master.set_sentinel(606, 606)
    assert master.read_holding(606) == (606,)
    first = script.taken
    # Lost; the sentinel's answer late, so it is asked again; that answer late, too, when register 10 is asked.
    script.reads = dict(enumerate([faults.drop, faults.stall(1.3), faults.stall(0.25), faults.drop], start=first))
    with pytest.raises(DeviceNonsense, match="more replies than questions"):
        master.read_holding(10)
    assert master.read_holding(10) == (10,)


@settings(max_examples=150)
@given(st.lists(st.tuples(st.integers(0, 25), st.integers(0, 5), st.floats(0.0, 4.0)), max_size=6))
def test_no_script_of_faults_gives_a_wrong_value(script_of_faults: list[tuple[int, int, float]]) -> None:
    """Replies keep their order, as on a line; a doubled one comes at once: later ones RTU cannot tell."""

    def fault(kind: int, delay_s: float) -> faults.Fault:
        return (
            faults.drop,
            faults.stall(delay_s),
            faults.duplicate(),
            faults.truncate(3),
            faults.flip_bit(-4, 2),
            faults.prepend(b"\x01\x03"),
        )[kind]

    script = FaultScript(reads={number: fault(kind, delay_s) for number, kind, delay_s in script_of_faults})
    master, _ = _master(_registers, script)
    master.set_sentinel(606, 606)
    for register in (606, 10, 20, 30, 40, 50):
        try:
            assert master.read_holding(register) == (register,)
        except (DeviceSilent, DeviceNonsense):
            continue


@given(st.binary(max_size=40))
def test_any_bytes_are_the_right_answer_or_an_error_of_ours(reply: bytes) -> None:
    master, _ = _master(lambda _: reply)
    try:
        values = master.read_holding(100)
    except RigError:
        return
    assert reply == _checked(b"\x01\x03\x02" + values[0].to_bytes(2, "big"))


def test_a_block_is_written_by_these_bytes_and_its_acknowledgement_is_checked() -> None:
    # Wire facts, section 4: F4T, set point 25.0 of loop 1.
    master, slave = _master(lambda _: _checked(bytes.fromhex("01 10 0A DE 00 02")))
    master.write_registers(2782, [0x0000, 0x41C8])
    assert slave.questions == [bytes.fromhex("01 10 0A DE 00 02 04 00 00 41 C8 30 19")]
    wrong, _ = _master(lambda _: _checked(bytes.fromhex("01 10 0A DE 00 01")))
    with pytest.raises(DeviceNonsense, match="it acknowledges register 2782, 1 of them"):
        wrong.write_registers(2782, [0x0000, 0x41C8])


class _Talker:
    """Sends two bytes every tenth of a second, whatever it is asked."""

    def __init__(self) -> None:
        self.questions: list[bytes] = []
        self._sent_s = 0.0

    def receive(self, data: bytes, now_s: float) -> None:
        self.questions.append(data)

    def transmit(self, now_s: float) -> bytes:
        if now_s < self._sent_s + 0.1:
            return b""
        self._sent_s = now_s
        return b"\x55\xaa"

    def next_event_s(self) -> float | None:
        return self._sent_s + 0.1


def test_a_line_that_never_falls_quiet_is_refused_with_what_came_and_is_not_asked() -> None:
    talker = _Talker()
    line = ModbusRtu(MemoryStream(talker, virtual_clock(), "chamber"), 1)
    with pytest.raises(DeviceNonsense, match=r"within 5 s: \d+ bytes came, the last .*; nothing was sent") as caught:
        line.read_holding(100)
    assert not talker.questions
    assert f": {line.counts.stale_bytes} bytes came" in str(caught.value)
