"""Dialects after published command sets: the bytes of docs/devices/indexing-table.md, and files that cannot work."""

from pathlib import Path

import pytest

from rig.errors import DescriptionError
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
    Prepare,
    Refused,
    Reply,
    Stop,
    TableCodec,
    TableState,
)
from rig.wire.table_dialect import load_dialect, published_dialects

AT_REST, MOVING = TableState(False, True, None), TableState(True, True, None)
PARKER_FAULT, PARKER_IN_ZONE = TableState(False, True, False, is_faulty=True), TableState(False, True, False)
# Each line from the page; what the page calls memory is not here.
FRAMES: list[tuple[str, Command, bytes, bytes, Reply]] = [
    ("newmark-nsc-a1", AskPosition(1), b"@01PX\r", b"12345", Position(1.2345)),
    ("newmark-nsc-a1", Prepare(1), b"@01ABS\r", b"OK", Acknowledged()),
    ("newmark-nsc-a1", Move(1, 1.0), b"@01X10000\r", b"OK", Acknowledged()),
    ("newmark-nsc-a1", AskState(1), b"@01MST\r", b"0", AT_REST),
    ("newmark-nsc-a1", AskState(1), b"@01MST\r", b"2", MOVING),
    ("newmark-nsc-a1", AskState(1), b"@01MST\r", b"64", TableState(False, True, None, is_faulty=True)),
    ("newmark-nsc-a1", Stop(1), b"@01STOP\r", b"OK", Acknowledged()),
    ("newmark-nsc-a1", Move(1, 1.0), b"@01X10000\r", b"?Error Moving", Refused("Error Moving")),
    ("inficon-srt-422", Identify(), b"$@\r", b"$*SRT422V0123", Identity("SRT422V0123")),
    ("inficon-srt-422", AskPosition(1), b"$G\r", b"$*1234", Position(222.12)),
    ("inficon-srt-422", AskState(1), b"$D\r", b"$*M", MOVING),
    ("inficon-srt-422", AskState(1), b"$D\r", b"$*R", AT_REST),
    ("yaesu-gs-232", AskPosition(1), b"C2\r", b"+0180+0000", Position(180.0)),
    ("mclennan-pm304", Identify(), b"1ID\r", b"Mclennan Servo Supplies Ltd. PM304 V6.15", Identity("PM304 V6.15")),
    ("mclennan-pm304", AskState(1), b"1OS\r", b"00010000", AT_REST),
    ("mclennan-pm304", AskState(1), b"1OS\r", b"00000000", MOVING),
    ("mclennan-pm304", AskPosition(1), b"1OA\r", b"AP=10234", Position(10.234)),
    ("parker-6k", Prepare(1), b"1MA1\r", b"\r\n", Acknowledged()),
    ("parker-6k", AskPosition(1), b"1TPC\r", b"*1TPC+0\r\n", Position(0.0)),
    (
        "parker-6k",
        AskState(1),
        b"1TAS\r",
        b"*1TAS0000_0000_0000_0000_0000_0000_0000_0000\r\n",
        TableState(False, True, False),
    ),
    (
        "parker-6k",
        AskState(1),
        b"1TAS\r",
        b"*1TAS1000_1000_0000_0000_0000_0000_0000_0000\r\n",
        TableState(True, True, True),
    ),
    # EPICS drvPC6K.h, TAS_*, counted from 1: 12 stall detected, 13 drive shut down, 23 position error exceeded.
    ("parker-6k", AskState(1), b"1TAS\r", b"*1TAS0000_0000_0001_0000_0000_0000_0000_0000\r\n", PARKER_FAULT),
    ("parker-6k", AskState(1), b"1TAS\r", b"*1TAS0000_0000_0000_1000_0000_0000_0000_0000\r\n", PARKER_FAULT),
    ("parker-6k", AskState(1), b"1TAS\r", b"*1TAS0000_0000_0000_0000_0000_0010_0000_0000\r\n", PARKER_FAULT),
    ("parker-6k", AskState(1), b"1TAS\r", b"*1TAS0000_0000_0000_0000_0000_0001_0000_0000\r\n", PARKER_IN_ZONE),
]


@pytest.mark.parametrize(("name", "command", "question", "answered", "reply"), FRAMES)
def test_a_published_line_is_sent_and_understood(
    name: str, command: Command, question: bytes, answered: bytes, reply: Reply
) -> None:
    codec = TableCodec(load_dialect(name, 1.0))
    assert codec.encode_command(command) == question
    answer = codec.decode_reply(answered, command)
    if isinstance(answer, Position) and isinstance(reply, Position):
        assert answer.position_deg == pytest.approx(reply.position_deg)
    else:
        assert answer == reply


def test_a_silent_move_is_whole_degrees_and_answers_nothing() -> None:
    # Hamlib: `W180 000` CR → nothing.
    codec = TableCodec(load_dialect("yaesu-gs-232", 1.0))
    assert codec.encode_command(Move(1, 180.0)) == b"W180 000\r"
    assert not codec.is_answered(Move)
    assert not codec.knows(Identify)
    assert not codec.knows(AskState)
    assert not codec.knows(Home)
    assert codec.reply_terminator == b"\r\n"


def test_no_stop_is_known_as_such() -> None:
    # INFICON manual pages 54 to 56: no stop on the pages seen.
    assert not TableCodec(load_dialect("inficon-srt-422", 1.0)).knows(Stop)


def test_they_are_taken_by_name_only() -> None:
    assert len(published_dialects()) >= 4
    assert load_dialect(None, 0.18).name == "single-axis-0.0001deg"


OWN = """
name = "own"
increment_deg = 0.5
terminator = "\\n"
line = { baud_rate = 9600 }
move = { command = "G{target_d:+03d}*{target_m:02d}'{target_s:02d}" }
position = { command = "P", reply = "{position_d:+03d}*{position_m:02d}'{position_s:02d}#" }
"""


@pytest.mark.parametrize("deg", [0.0, 12.5, -0.5, -0.0, -179.5, 359.5])
def test_degrees_minutes_and_seconds_come_back(tmp_path: Path, deg: float) -> None:
    # LX200: `+12*34'56#`; the sign of -0° 30' is not that of a number.
    (tmp_path / "own.toml").write_text(OWN)
    codec = TableCodec(load_dialect(str(tmp_path / "own.toml"), 0.5))
    line = codec.encode_reply(Position(deg), 1, AskPosition).removesuffix(b"\n")
    assert codec.decode_reply(line, AskPosition(1)) == Position(deg)
    assert codec.decode_command(codec.encode_command(Move(1, deg)).removesuffix(b"\n")) == Move(1, deg)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("baud_rate = 9600", "baud_rate = 9601", "baud_rate"),
        ("baud_rate = 9600", "parity = 'X'", "parity"),
        ("{position_d:+03d}*{position_m:02d}'{position_s:02d}#", "{position_deg:.0f}", "cannot be parsed back"),
        ("{position_d:+03d}*{position_m:02d}'{position_s:02d}#", "{position_counts:d}", "counts_per_turn"),
        ("{position_d:+03d}*{position_m:02d}'{position_s:02d}#", "{axis}{position_deg:.1f}", "cannot be parsed back"),
        ("{position_d:+03d}*{position_m:02d}'{position_s:02d}#", "OK", "no angle"),
        ('name = "own"', 'name = "own"\nstate = { command = "S", reply = "{status:x}" }', "table [bits]"),
        ('name = "own"', 'name = "own"\nbits = { moving = [1] }', "belong together"),
        ('name = "own"', 'name = "own"\nstate = { command = "S", reply = "{status:q}" }', "format d, x, b or l"),
    ],
)
def test_a_dialect_that_cannot_work_is_a_sentence_with_file_and_line(
    tmp_path: Path, old: str, new: str, sentence: str
) -> None:
    path = tmp_path / "own.toml"
    assert old in OWN
    path.write_text(OWN.replace(old, new))
    with pytest.raises(DescriptionError) as caught:
        load_dialect(str(path), 0.5)
    assert sentence in str(caught.value)
    assert str(caught.value).startswith(f"{path}:")
