import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.errors import DeviceNonsense
from rig.wire import hp3488a as wire


def test_the_answers_are_those_of_the_manual() -> None:
    # gpib-utils src/hp3488.c: VIEW answers "CLOSED 0" or "OPEN   1" (three spaces), ID? answers HP3488A.
    assert wire.parse_view(b"CLOSED 0") is True
    assert wire.parse_view(b"OPEN   1") is False
    assert wire.parse_identity(b"HP3488A") == "HP3488A"


def test_the_commands_are_those_of_the_manual() -> None:
    # gpib-utils src/hp3488.c and its manual page.
    assert wire.close(101) == b"CLOSE 101"
    assert wire.open_channel(101) == b"OPEN 101"
    assert wire.view(509) == b"VIEW 509"
    assert wire.card_type(1) == b"CTYPE 1"


def test_the_card_s_model_starts_at_the_twelfth_character() -> None:
    # gpib-utils src/hp3488.c: the model number is at offset 11 of an answer of at least 15 characters.
    assert wire.parse_card_type(b"RELAY MUX  44470") == "44470"
    assert wire.parse_card_type(b"CARD #1    44471  ") == "44471"
    with pytest.raises(DeviceNonsense):
        wire.parse_card_type(b"44470")


def test_errors_are_a_sum_of_bits() -> None:
    # gpib-utils src/hp3488.c: 1 syntax, 2 execution, 4 trigger too fast, 8 logic, 16 power.
    assert wire.parse_errors(b"0") == ()
    assert wire.parse_errors(b"3") == ("syntax", "execution")
    assert wire.parse_errors(b"16") == ("power",)


@pytest.mark.parametrize(
    "line", [b"CLOSED", b"CLOSED 1", b"OPEN 0", b"OPEN", b" CLOSED 0", b"CLOSED 0OPEN   1", b"1", b""]
)
def test_half_an_answer_is_no_answer(line: bytes) -> None:
    with pytest.raises(DeviceNonsense):
        wire.parse_view(line)


@given(st.binary(max_size=30))
def test_no_bytes_make_another_error_than_nonsense(line: bytes) -> None:
    for parse in (wire.parse_view, wire.parse_identity, wire.parse_card_type, wire.parse_errors):
        try:
            parse(line)
        except DeviceNonsense:
            continue
