"""Laws of Zaber's lines. Literal lines: captured from zaber-motion 10.2.0 (wire facts, section 5.1)."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.wire import zaber as wire
from rig.wire.zaber import Command, Reply

CAPTURED = [
    (Command(1, 0, "get pos", 0), b"/1 0 00 get pos:2D\n"),
    (Command(1, 1, "move abs 5000", 1), b"/1 1 01 move abs 5000:EB\n"),
]


@pytest.mark.parametrize(("command", "line"), CAPTURED)
def test_a_command_is_the_captured_line(command: Command, line: bytes) -> None:
    assert wire.encode_command(command) == line
    assert wire.decode_command(line[:-1]) == command


@pytest.mark.parametrize(
    ("line", "reply"),
    [
        (b"@01 0 OK IDLE -- 0", Reply(1, 0, True, False, "--", "0", None, False)),
        (b"@01 1 02 OK BUSY WR -4267", Reply(1, 1, True, True, "WR", "-4267", 2, False)),
        (b"@12 1 RJ IDLE NI BADDATA", Reply(12, 1, False, False, "NI", "BADDATA", None, False)),
        (b"@01 1 OK IDLE FS 02 FS WR", Reply(1, 1, True, False, "FS", "02 FS WR", None, False)),
    ],
)
def test_replies(line: bytes, reply: Reply) -> None:
    assert wire.decode_reply(line) == reply
    assert wire.encode_reply(reply) == line + b"\r\n"


def test_the_checksum_covers_everything_after_the_lead_character() -> None:
    # By hand: the bytes of "01 0 00 OK IDLE -- 0" sum to 0x3F3; 0x100 − 0xF3 = 0x0D.
    assert sum(b"01 0 00 OK IDLE -- 0") == 0x3F3
    assert wire.decode_reply(b"@01 0 00 OK IDLE -- 0:0D") == Reply(1, 0, True, False, "--", "0", 0, True)
    assert wire.decode_reply(b"@01 0 00 OK IDLE -- 1:0D") is None


@given(st.integers(0, 25), st.integers(0, 7), st.integers(-(2**31), 2**31 - 1), st.integers(0, 99))
def test_one_flipped_bit_is_never_a_reply(position: int, bit: int, index: int, message_id: int) -> None:
    line = bytearray(wire.encode_reply(Reply(1, 1, True, False, "--", str(index), message_id))[:-2])
    line[position % len(line)] ^= 1 << bit
    damaged = wire.decode_reply(bytes(line))
    # A flip in the colon hides the checksum: then there is none, and the driver asks for one.
    assert damaged is None or not damaged.has_checksum or damaged.data == str(index)


@pytest.mark.parametrize(
    "line",
    [b"", b"@01 0 OK IDLE --", b"@1 0 OK IDLE -- 0", b"@01 0 OK IDLE -- 0 ", b"#01 0 OK IDLE -- 0", b"!01 1 IDLE --"],
)
def test_what_is_no_reply_is_none(line: bytes) -> None:
    assert wire.decode_reply(line) is None


def test_alerts_and_info_are_asides() -> None:
    assert wire.is_aside(b"!01 1 IDLE --")
    assert wire.is_aside(b"#01 0 some text")
    assert not wire.is_aside(b"@01 0 OK IDLE -- 0")
    assert not wire.is_aside(b"")


@given(st.binary(max_size=60))
def test_arbitrary_bytes_are_decoded_or_refused(line: bytes) -> None:
    wire.decode_command(line)
    reply = wire.decode_reply(line)
    assert reply is None or line.startswith(b"@")


@pytest.mark.parametrize(("data", "value"), [("5000", 5000), ("-7", -7), ("1 2", None), ("1.5", None), ("", None)])
def test_a_whole_number_is_one(data: str, value: int | None) -> None:
    assert wire.decode_integer(data) == value
