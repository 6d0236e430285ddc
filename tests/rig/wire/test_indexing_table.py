"""Laws of the indexing table's lines. Literal frames are those of the design's worked dialect (chapter 5)."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.wire.indexing_table import (
    Acknowledged,
    AskPosition,
    AskState,
    Command,
    Home,
    Identify,
    Identity,
    Move,
    Position,
    Refused,
    Reply,
    Stop,
    TableCodec,
    TableState,
)
from rig.wire.table_dialect import load_dialect

CODEC = TableCodec(load_dialect(None, 1.0))
AT_REST = TableState(is_moving=False, is_seated=True, is_homed=True)
FRAMES: list[tuple[Command, bytes, Reply, bytes]] = [
    (Move(1, 10.0), b"1 MOVE +010.0000\r\n", Acknowledged(), b"1 OK\r\n"),
    (Move(2, -180.0), b"2 MOVE -180.0000\r\n", Refused("NOT HOMED"), b"2 ERR NOT HOMED\r\n"),
    (AskPosition(1), b"1 POS?\r\n", Position(10.0), b"1 POS +010.0000\r\n"),
    (AskState(1), b"1 STAT?\r\n", AT_REST, b"1 STAT IDLE SEATED LOCKED HOMED\r\n"),
    (Home(1), b"1 HOME\r\n", Acknowledged(), b"1 OK\r\n"),
    (Stop(2), b"2 STOP\r\n", Acknowledged(), b"2 OK\r\n"),
    (Identify(), b"ID?\r\n", Identity("SOME TABLE"), b"ID SOME TABLE\r\n"),
]


@pytest.mark.parametrize(("command", "question", "reply", "answered"), FRAMES, ids=[str(frame[0]) for frame in FRAMES])
def test_a_command_and_its_reply_are_these_bytes(
    command: Command, question: bytes, reply: Reply, answered: bytes
) -> None:
    assert CODEC.encode_command(command) == question
    assert CODEC.decode_command(question[:-2]) == command
    assert CODEC.encode_reply(reply, getattr(command, "axis", 0), type(command)) == answered
    assert CODEC.decode_reply(answered[:-2], command) == reply


@pytest.mark.parametrize(
    "line",
    [
        b"2 POS +010.0000",  # another axis
        b"1 POS +010.00",  # shortened
        b"1 POS +01\xb0.0000",  # a flipped bit
        b"1 OK",  # another question's answer
        b"",
        b"1 POS +010.00001 POS +010.0000",
    ],
)
def test_a_line_that_is_no_answer_decodes_to_nothing(line: bytes) -> None:
    assert CODEC.decode_reply(line, AskPosition(1)) is None


@pytest.mark.parametrize(
    "words",
    [
        b"IDLE SEATED LOCKED",  # home missing
        b"IDLE MOVING SEATED LOCKED HOMED",  # contradiction
        b"IDLE SEATED LOCKED HOMEE",  # unknown
        b"IDLE SEATED UNLOCKED LIFTED HOMED",
        b"SEATED LOCKED HOMED",
    ],
)
def test_a_state_that_is_not_told_whole_is_no_state(words: bytes) -> None:
    assert CODEC.decode_reply(b"1 STAT " + words, AskState(1)) is None


def test_a_coupling_that_is_seated_but_not_locked_is_not_seated() -> None:
    state = CODEC.decode_reply(b"1 STAT IDLE SEATED UNLOCKED HOMED", AskState(1))
    assert state == TableState(is_moving=False, is_seated=False, is_homed=True)


def test_a_fault_word_is_told() -> None:
    state = CODEC.decode_reply(b"1 STAT IDLE SEATED LOCKED HOMED FAULT", AskState(1))
    assert isinstance(state, TableState)
    assert state.is_faulty


@given(st.binary(max_size=40))
def test_no_bytes_at_all_raise_or_become_a_wrong_position(line: bytes) -> None:
    reply = CODEC.decode_reply(line, AskPosition(1))
    if isinstance(reply, Position):
        assert CODEC.encode_reply(reply, 1, AskPosition).removesuffix(b"\r\n") == line
    CODEC.decode_command(line)
    CODEC.decode_reply(line, AskState(1))
