import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.errors import DeviceNonsense
from rig.wire import prologix as wire

# Prologix GPIB-USB manual 6.107, page 7: the example of escaped binary data.
MANUAL_DATA = bytes.fromhex("00 01 02 0D 03 0A 04 1B 05 2B 06")
MANUAL_ESCAPED = bytes.fromhex("00 01 02 1B 0D 03 1B 0A 04 1B 1B 05 1B 2B 06")


def test_a_message_is_escaped_as_in_the_manual() -> None:
    assert wire.message(MANUAL_DATA) == MANUAL_ESCAPED + b"\n"


def test_the_adapter_undoes_the_escapes_of_the_manual() -> None:
    assert wire.split_host_lines(MANUAL_ESCAPED + b"\n") == ([wire.HostLine(False, MANUAL_DATA)], b"")


def test_the_frames_are_those_that_other_clients_send() -> None:
    # pyvisa-py 0.8.1 and prologix_gpib_async 1.5.0, captured on the wire.
    assert wire.setting("savecfg", 0) == b"++savecfg 0\n"
    assert wire.setting("mode", 1) == b"++mode 1\n"
    assert wire.setting("auto", 0) == b"++auto 0\n"
    assert wire.setting("eoi", 1) == b"++eoi 1\n"
    assert wire.setting("eot_enable", 0) == b"++eot_enable 0\n"
    assert wire.setting("eot_char", 10) == b"++eot_char 10\n"
    assert wire.address(22) == b"++addr 22\n"
    assert wire.READ_TO_EOI == b"++read eoi\n"
    assert wire.message(b"ID?") == b"ID?\n"


def test_the_frames_are_those_of_the_manual() -> None:
    # Prologix GPIB-USB manual 6.107, pages 9 to 15: names and arguments of the commands.
    assert wire.setting("read_tmo_ms", 3000) == b"++read_tmo_ms 3000\n"
    assert wire.setting("eos", 0) == b"++eos 0\n"
    assert wire.setting_query("auto") == b"++auto\n"
    assert wire.serial_poll(22) == b"++spoll 22\n"
    assert (wire.CLEAR, wire.INTERFACE_CLEAR, wire.VERSION) == (b"++clr\n", b"++ifc\n", b"++ver\n")


def test_a_plus_reaches_the_instrument_only_when_escaped() -> None:
    # Captured on the wire: DISP MSG,"A+B" must be sent with ESC before the plus.
    assert wire.message(b'DISP MSG,"A+B"') == b'DISP MSG,"A\x1b+B"\n'
    assert wire.split_host_lines(b"A+B\n")[0] == [wire.HostLine(False, b"AB")]


@given(st.binary(min_size=1))
def test_any_message_arrives_as_it_was_meant(data: bytes) -> None:
    assert wire.split_host_lines(wire.message(data)) == ([wire.HostLine(False, data)], b"")


@given(st.lists(st.binary(min_size=1, max_size=8), min_size=1, max_size=4), st.data())
def test_lines_may_arrive_in_any_pieces(messages: list[bytes], data: st.DataObject) -> None:
    stream = b"".join(wire.message(message) for message in messages)
    cut = data.draw(st.integers(0, len(stream)))
    first, rest = wire.split_host_lines(stream[:cut])
    second, left = wire.split_host_lines(rest + stream[cut:])
    assert [line.text for line in first + second] == messages
    assert left == b""


def test_versions_seen_in_the_field_are_accepted() -> None:
    # Version strings of GPIB-USB 6.107, 6.101 and 6.95 as public repositories quote them.
    for line in (
        b"Prologix GPIB-USB Controller version 6.107",
        b"Prologix GPIB-USB Controller version 6.101",
        b"Prologix GPIB-USB Controller version 6.95",
    ):
        assert wire.parse_version(line) == line.decode()


@given(st.binary())
def test_no_bytes_make_the_adapter_s_numbers_anything_else(line: bytes) -> None:
    try:
        assert line.isdigit()
        assert wire.parse_number(line) == int(line)
    except (AssertionError, DeviceNonsense):
        assert not (line.isdigit() and len(line) <= 5)


@pytest.mark.parametrize("line", [b"", b"Unrecognized command", b"-1", b"1 ", b"256", b"0x10"])
def test_a_status_byte_is_a_decimal_number_of_eight_bits(line: bytes) -> None:
    with pytest.raises(DeviceNonsense):
        wire.parse_status_byte(line)
