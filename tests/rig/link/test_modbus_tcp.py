"""Laws of our Modbus TCP conversation. Frames: MODBUS messaging on TCP/IP implementation guide V1.0b, by hand."""

from collections.abc import Callable

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from table_bench import virtual_clock

from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, DeviceSilent, LinkLost, RigError
from rig.link import faults
from rig.link.faults import FaultScript
from rig.link.memory import MemoryStream
from rig.link.modbus_tcp import ModbusTcp

READ_2820 = bytes.fromhex("00 01 00 00 00 06 01 03 0B 04 00 02")
PV_25 = bytes.fromhex("00 01 00 00 00 07 01 03 04 00 00 41 C8")
WRITE_25 = bytes.fromhex("00 01 00 00 00 0B 01 10 0A DE 00 02 04 00 00 41 C8")
WRITTEN = bytes.fromhex("00 01 00 00 00 06 01 10 0A DE 00 02")


class Server:
    """Answers what ``answer`` says of each request; a request is at least a header."""

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


def _client(answer: Callable[[bytes], bytes], script: FaultScript | None = None) -> tuple[ModbusTcp, Server]:
    server = Server(answer)
    return ModbusTcp(MemoryStream(server, virtual_clock(), "chamber", script), 1), server


def _numbered(body: str) -> Callable[[bytes], bytes]:
    """The reply with the transaction number of the question."""
    return lambda request: request[:2] + bytes.fromhex(body)


def _registers(request: bytes) -> bytes:
    """Register n holds n."""
    address, count = int.from_bytes(request[8:10], "big"), int.from_bytes(request[10:12], "big")
    values = b"".join((address + index).to_bytes(2, "big") for index in range(count))
    return (
        request[:2] + b"\x00\x00" + (3 + len(values)).to_bytes(2, "big") + b"\x01\x03" + bytes([len(values)]) + values
    )


def test_a_read_is_these_bytes() -> None:
    client, server = _client(lambda _: PV_25)
    assert client.read_holding(2820, 2) == (0x0000, 0x41C8)
    assert server.questions == [READ_2820]


def test_a_write_is_these_bytes() -> None:
    client, server = _client(lambda _: WRITTEN)
    client.write_registers(2782, [0x0000, 0x41C8])
    assert server.questions == [WRITE_25]


def test_every_question_has_its_own_number() -> None:
    client, server = _client(_registers)
    for _ in range(3):
        client.read_holding(10)
    assert [text[:2] for text in server.questions] == [b"\x00\x01", b"\x00\x02", b"\x00\x03"]


def test_fault_32_a_reply_with_another_number_is_passed_over_and_the_right_one_waited_for() -> None:
    """Detected: transaction, unit, function and length of every reply.
    Response: passed over, and the right one waited for until the deadline.
    """
    other = bytes.fromhex("00 63 00 00 00 05 01 03 02 00 07")
    client, _ = _client(lambda request: other + _registers(request))
    assert client.read_holding(10) == (10,)
    assert client.counts.stale_bytes == len(other)
    assert client.counts.repeated == 0


@pytest.mark.parametrize(
    ("body", "text"),
    [
        ("00 00 00 05 02 03 02 00 07", "unit 2, function 3 answered"),
        ("00 00 00 05 01 04 02 00 07", "unit 1, function 4 answered"),
        ("00 00 00 07 01 03 04 00 07 00 07", "need 11 bytes"),
        ("00 00 00 05 01 03 04 00 07", "need 11 bytes"),
    ],
)
def test_a_reply_that_cannot_be_the_answer_is_nonsense(body: str, text: str) -> None:
    client, _ = _client(_numbered(body))
    with pytest.raises(DeviceNonsense, match=text):
        client.read_holding(10)


@pytest.mark.parametrize("body", ["00 01 00 05 01 03 02 00 07", "00 00 FF FF 01 03 02 00 07"])
def test_a_connection_without_frames_is_given_up(body: str) -> None:
    client, server = _client(_numbered(body))
    for _ in range(2):
        with pytest.raises(LinkLost, match="no Modbus TCP header"):
            client.read_holding(10)
    assert len(server.questions) == 1


@pytest.mark.parametrize(("code", "kind"), [(2, DeviceRefused), (4, DeviceFault), (99, DeviceNonsense)])
def test_an_exception_says_who_must_act(code: int, kind: type[RigError]) -> None:
    client, _ = _client(_numbered(f"00 00 00 03 01 83 {code:02X}"))
    with pytest.raises(kind, match=f"exception {code} "):
        client.read_holding(10)


def test_silence_is_told_after_three_questions() -> None:
    client, server = _client(lambda _: b"")
    with pytest.raises(DeviceSilent, match=r"chamber: no whole reply to function 3, register 10 within 1 s"):
        client.read_holding(10)
    assert len(server.questions) == 3


@given(st.lists(st.tuples(st.integers(0, 15), st.integers(0, 5), st.floats(0.0, 4.0)), max_size=6))
@example([(0, 3, 0.0), (1, 4, 2.0), (3, 4, 1.0)])  # the rest of a frame behind the header of the next
def test_no_script_of_faults_gives_a_wrong_value(script_of_faults: list[tuple[int, int, float]]) -> None:
    def fault(kind: int, delay_s: float) -> faults.Fault:
        return (
            faults.drop,
            faults.delay(delay_s),
            faults.duplicate(delay_s),
            faults.truncate(5),
            faults.split(7, delay_s / 8.0),
            faults.prepend(b"\x01\x03\xff"),
        )[kind]

    script = FaultScript(reads={number: fault(kind, delay_s) for number, kind, delay_s in script_of_faults})
    client, _ = _client(_registers, script)
    for register in (10, 20, 30, 40, 50):
        try:
            assert client.read_holding(register) == (register,)
        except (DeviceSilent, DeviceNonsense, LinkLost):
            continue


def test_an_acknowledgement_of_another_block_is_nonsense() -> None:
    client, _ = _client(_numbered("00 00 00 06 01 10 0A DE 00 01"))
    with pytest.raises(DeviceNonsense, match="it acknowledges register 2782, 1 of them"):
        client.write_registers(2782, [0x0000, 0x41C8])
