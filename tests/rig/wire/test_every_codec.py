"""What every codec promises, on frames from outside: right, or refused; never wrong, never another exception.

Whole, byte by byte, cut, with rubbish before and after, and arbitrary bytes. A decoder or encoder that is not among
the frames fails the test at the end.
"""

from typing import Any

import pytest
from frames import ANY, DECODED, ENCODED, Decoded, Encoded, decoders, encoders
from hypothesis import given, settings
from hypothesis import strategies as st
from table_bench import virtual_clock

from rig.errors import DeviceNonsense, DeviceSilent
from rig.link.exchange import Exchange, Patience
from rig.link.memory import MemoryStream

REFUSED = object()
LINES = [entry for entry in DECODED if b"\r\n" not in entry.frame and b"\n" not in entry.frame]
"""Answers that a terminator ends."""
TELLING = [entry for entry in DECODED if entry.blind != ANY]
"""Frames that tell rubbish around them."""


def _taken(decoded: Decoded, data: bytes) -> Any:
    try:
        value = decoded.decode(data)
    except DeviceNonsense:
        return REFUSED
    return REFUSED if value is None else value


def _ids(frames: Any) -> list[str]:
    return [f"{index}-{frame.name}" for index, frame in enumerate(frames)]


@pytest.mark.parametrize("decoded", DECODED, ids=_ids(DECODED))
def test_a_frame_from_outside_is_its_value(decoded: Decoded) -> None:
    assert decoded.source
    assert _taken(decoded, decoded.frame) == decoded.value


@pytest.mark.parametrize("encoded", ENCODED, ids=_ids(ENCODED))
def test_what_is_sent_is_the_frame_from_outside(encoded: Encoded) -> None:
    assert encoded.source
    assert encoded.made == encoded.literal


@pytest.mark.parametrize("decoded", DECODED, ids=_ids(DECODED))
@settings(max_examples=30)
@given(data=st.binary(max_size=60))
def test_arbitrary_bytes_are_a_value_or_refused(decoded: Decoded, data: bytes) -> None:
    _taken(decoded, data)


@pytest.mark.parametrize("decoded", TELLING, ids=_ids(TELLING))
@settings(max_examples=30)
@given(data=st.data(), is_before=st.booleans())
def test_rubbish_around_a_frame_never_makes_another_value(
    decoded: Decoded, data: st.DataObject, is_before: bool
) -> None:
    telling = bytes(byte for byte in range(256) if byte not in decoded.blind)
    parts = data.draw(st.tuples(st.binary(max_size=4), st.sampled_from(telling), st.binary(max_size=4)))
    rubbish = parts[0] + bytes([parts[1]]) + parts[2]
    found = _taken(decoded, rubbish + decoded.frame if is_before else decoded.frame + rubbish)
    assert found is REFUSED or found == decoded.value


class Scripted:
    """The other side of a line: says the pieces one after the other, a millisecond apart, once it was asked."""

    def __init__(self, pieces: list[bytes]) -> None:
        self._pieces = pieces
        self._due: list[tuple[float, bytes]] = []

    def receive(self, data: bytes, now_s: float) -> None:
        assert data == b"ask\n"
        self._due = [(now_s + 0.001 * index, piece) for index, piece in enumerate(self._pieces, start=1)]

    def transmit(self, now_s: float) -> bytes:
        said = b"".join(piece for due_s, piece in self._due if due_s <= now_s)
        self._due = [(due_s, piece) for due_s, piece in self._due if due_s > now_s]
        return said

    def next_event_s(self) -> float | None:
        return min((due_s for due_s, _ in self._due), default=None)


def _asked(decoded: Decoded, pieces: list[bytes]) -> Any:
    """Through an exchange, as a driver asks."""
    stream = MemoryStream(Scripted(pieces), virtual_clock(), "line")
    exchange = Exchange(stream, patience=Patience(timeout_s=1.0, attempts=1))

    def parse(line: bytes) -> Any:
        if (value := _taken(decoded, line)) is REFUSED:
            raise DeviceNonsense("refused")
        return value

    return exchange.ask(b"ask\n", parse, idempotent=True)


@pytest.mark.parametrize("decoded", LINES, ids=_ids(LINES))
def test_an_answer_may_come_byte_by_byte_and_in_any_two_pieces(decoded: Decoded) -> None:
    line = decoded.frame + b"\r\n"
    assert _asked(decoded, [bytes([byte]) for byte in line]) == decoded.value
    for cut in range(1, len(line)):
        assert _asked(decoded, [line[:cut], line[cut:]]) == decoded.value


@pytest.mark.parametrize("decoded", LINES, ids=_ids(LINES))
def test_a_part_of_an_answer_is_no_answer(decoded: Decoded) -> None:
    """Neither ``12.3`` of ``12.345`` nor a line whose end never comes."""
    line = decoded.frame + b"\r\n"
    for length in range(len(line)):
        with pytest.raises(DeviceSilent):
            _asked(decoded, [line[:length]] if length else [])


@pytest.mark.parametrize("decoded", LINES, ids=_ids(LINES))
def test_more_than_one_answer_is_none(decoded: Decoded) -> None:
    line = decoded.frame + b"\r\n"
    for more in (line, b"\x00", b"1"):
        with pytest.raises((DeviceNonsense, DeviceSilent)):
            _asked(decoded, [line + more])


def test_no_decoder_and_no_encoder_is_without_a_frame_from_outside() -> None:
    assert decoders() - {entry.name for entry in DECODED} == set()
    assert encoders() - {entry.name for entry in ENCODED} == set()
    assert {entry.name for entry in DECODED} <= decoders() | {"scpi.parse_block"}
    assert {entry.name for entry in ENCODED} <= encoders()
