"""The adapter's twin against the manual, by literal bytes: no codec of ours stands between."""

import pytest
from gpib_rig import GpibRig, gpib_rig
from hypothesis import given
from hypothesis import strategies as st

from rig.twins.prologix import PrologixTwin


def said(rig: GpibRig, data: bytes, within_s: float = 0.0) -> bytes:
    """What the adapter answers to ``data`` within a time."""
    rig.stream.write(data)
    end_s = rig.clock.monotonic_s() + within_s
    answer = b""
    while more := rig.stream.read(end_s):
        answer += more
    return answer


def test_it_tells_its_version() -> None:
    # Prologix GPIB-USB manual 6.107: the answer to ++ver ends with CR LF.
    assert said(gpib_rig(), b"++ver\n") == b"Prologix GPIB-USB Controller version 6.107\r\n"


@pytest.mark.parametrize("end", [b"\n", b"\r", b"\r\n"])
def test_a_line_ends_with_either_terminator(end: bytes) -> None:
    assert said(gpib_rig(), b"++addr 22" + end + b"++addr" + end) == b"22\r\n"


def test_setting_answers_nothing_and_asking_tells_the_value() -> None:
    assert said(gpib_rig(), b"++read_tmo_ms 3000\n") == b""
    assert said(gpib_rig(), b"++read_tmo_ms 3000\n++read_tmo_ms\n") == b"3000\r\n"


def test_a_refused_value_is_answered() -> None:
    # nelsond/prologix-gpib-ethernet PR #7: more than 3000 ms is answered "Unrecognized command".
    rig = gpib_rig()
    assert said(rig, b"++read_tmo_ms 4000\n") == b"Unrecognized command\r\n"
    assert said(rig, b"++nonsense\n") == b"Unrecognized command\r\n"
    assert said(rig, b"++addr 31\n") == b"Unrecognized command\r\n"


def test_an_instrument_s_answer_passes_unmodified() -> None:
    # pyvisa-py 0.8.1 on the wire: message with CR LF, then ++read eoi.
    rig = gpib_rig()
    said(rig, b"++auto 0\n++addr 22\nEND ALWAYS\r\n")
    assert said(rig, b"ID?\r\n++read eoi\n") == b"HP3458A\r\n"


def test_end_of_transmission_mark_follows_eoi() -> None:
    # pymeasure issue 954: eot_enable 1 with eot_char 0 puts a NUL after each answer.
    rig = gpib_rig()
    said(rig, b"++auto 0\n++addr 22\n++eot_enable 1\n++eot_char 0\nEND ALWAYS\n")
    assert said(rig, b"ID?\n++read eoi\n") == b"HP3458A\r\n\x00"


def test_a_read_without_eoi_ends_only_by_its_time_out() -> None:
    # 3458A: after RESET there is no EOI, so ++read eoi can only time out; the bytes come, the adapter stays busy.
    rig = gpib_rig()
    said(rig, b"++auto 0\n++read_tmo_ms 500\n++addr 22\nTARM HOLD\n")
    assert said(rig, b"ID?\n++read eoi\n++ver\n", within_s=0.49) == b"HP3458A\r\n"
    assert said(rig, b"", within_s=0.02).startswith(b"Prologix")


def test_a_silent_address_costs_the_time_out_and_says_nothing() -> None:
    rig = gpib_rig()
    said(rig, b"++auto 0\n++read_tmo_ms 1000\n++addr 5\n")
    assert said(rig, b"ID?\n++read eoi\n", within_s=1.0) == b""
    started_s = rig.clock.monotonic_s()
    assert said(rig, b"++read eoi\n++ver\n", within_s=2.0).startswith(b"Prologix")
    assert rig.clock.monotonic_s() - started_s >= 1.0


def test_a_serial_poll_does_not_make_the_instrument_talk() -> None:
    rig = gpib_rig()
    said(rig, b"++auto 0\n++addr 22\nEND ALWAYS\nID?\n")
    assert int(said(rig, b"++spoll\n")) & 128
    assert int(said(rig, b"++spoll 9\n")) & 16
    assert said(rig, b"++read eoi\n") == b"HP3458A\r\n"


def test_automatic_reading_follows_each_message() -> None:
    rig = gpib_rig()
    said(rig, b"++auto 0\n++addr 22\nEND ALWAYS\n++auto 1\n")
    assert said(rig, b"ID?\n") == b"HP3458A\r\n"


def test_settings_wear_the_memory_unless_saving_is_off() -> None:
    rig = gpib_rig()
    said(rig, b"++mode 1\n++auto 0\n")
    assert rig.adapter.eeprom_writes == 2
    said(rig, b"++savecfg 0\n++mode 1\n++auto 0\n++read_tmo_ms 3000\n")
    assert rig.adapter.eeprom_writes == 2


def test_after_a_reset_it_is_deaf_for_five_seconds() -> None:
    rig = gpib_rig()
    assert said(rig, b"++rst\n++ver\n", within_s=4.9) == b""
    rig.clock.sleep(0.2)
    assert said(rig, b"++ver\n") != b""


def test_reading_to_a_character_stops_there() -> None:
    rig = gpib_rig()
    said(rig, b"++auto 0\n++addr 22\n++read_tmo_ms 3000\nTARM HOLD\n")
    started_s = rig.clock.monotonic_s()
    assert said(rig, b"ID?\n++read 10\n++ver\n").startswith(b"HP3458A\r\nPrologix")
    assert rig.clock.monotonic_s() == started_s


@given(st.lists(st.binary(max_size=20), max_size=5))
def test_no_bytes_upset_it(pieces: list[bytes]) -> None:
    twin = PrologixTwin({})
    for number, piece in enumerate(pieces):
        twin.receive(piece, float(number))
        assert isinstance(twin.transmit(float(number)), bytes)
        event_s = twin.next_event_s()
        assert event_s is None or event_s > number
