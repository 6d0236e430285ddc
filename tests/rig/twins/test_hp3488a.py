"""The scanner's twin against its manual, by literal bytes."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.twins.hp3488a import RELAY_S, Hp3488aTwin


def said(twin: Hp3488aTwin, message: bytes, now_s: float = 0.0) -> bytes:
    twin.listen(message, now_s)
    return twin.talk(now_s)[0]


def test_it_answers_as_in_the_manual() -> None:
    # gpib-utils src/hp3488.c: ID?, VIEW, CTYPE with the model at offset 11, ERROR without a question mark.
    twin = Hp3488aTwin()
    assert said(twin, b"ID?\r\n") == b"HP3488A\r\n"
    assert said(twin, b"VIEW 101") == b"OPEN   1\r\n"
    twin.listen(b"CLOSE 101", 0.0)
    assert said(twin, b"VIEW 101") == b"CLOSED 0\r\n"
    card = said(twin, b"CTYPE 1")
    assert card[11:16] == b"44470"
    assert len(card.strip()) >= 15
    assert said(twin, b"ERROR") == b"0\r\n"


def test_relays_latch_until_opened() -> None:
    twin = Hp3488aTwin()
    twin.listen(b"CLOSE 101,102", 0.0)
    assert twin.closed_channels() == {101, 102}
    twin.listen(b"OPEN 101", 0.0)
    assert twin.closed_channels() == {102}
    twin.listen(b"CRESET 1", 0.0)
    assert twin.closed_channels() == frozenset()


def test_a_device_clear_opens_all_relays() -> None:
    twin = Hp3488aTwin()
    twin.listen(b"CLOSE 101", 0.0)
    twin.clear(0.0)
    assert twin.closed_channels() == frozenset()


def test_it_is_ready_when_the_relay_has_moved() -> None:
    twin = Hp3488aTwin()
    twin.listen(b"CLOSE 101", 5.0)
    assert not twin.serial_poll(5.0) & 0x10
    assert twin.serial_poll(5.0 + RELAY_S) & 0x10


@pytest.mark.parametrize(
    ("message", "error"), [(b"NONSENSE", b"1\r\n"), (b"CLOSE 110", b"2\r\n"), (b"VIEW 601", b"2\r\n")]
)
def test_an_error_is_told_once(message: bytes, error: bytes) -> None:
    twin = Hp3488aTwin()
    twin.listen(message, 0.0)
    assert twin.serial_poll(0.0) & 0x20
    assert said(twin, b"ERROR") == error
    assert said(twin, b"ERROR") == b"0\r\n"


@given(st.binary(max_size=40))
def test_no_message_upsets_it(message: bytes) -> None:
    twin = Hp3488aTwin()
    twin.listen(message, 0.0)
    assert isinstance(twin.talk(0.0)[0], bytes)
    assert twin.closed_channels() <= set(range(100, 110))
