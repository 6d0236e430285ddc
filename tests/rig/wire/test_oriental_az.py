"""Laws of the AZ's registers. Literal frames: wire facts, section 6 (worked from the maker's sample)."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.wire import oriental_az as wire
from rig.wire.oriental_az import Operation

WORKED = Operation(wire.INCREMENTAL, 5000, 1000, 1000, 1000)
WORKED_DATA = "00000000 00000002 00001388 000003E8 000003E8 000003E8 000003E8 00000001"


def test_the_worked_operation_is_these_registers() -> None:
    registers = wire.encode(WORKED)
    assert b"".join(register.to_bytes(2, "big") for register in registers) == bytes.fromhex(WORKED_DATA)
    assert wire.decode(registers) == WORKED


@pytest.mark.parametrize(("value", "words"), [(0, (0, 0)), (-1, (0xFFFF, 0xFFFF)), (-5000, (0xFFFF, 0xEC78))])
def test_values_are_signed_upper_word_first(value: int, words: tuple[int, int]) -> None:
    assert wire.words(value) == words
    assert wire.value_of(*words) == value


@given(st.integers(-(2**31), 2**31 - 1))
def test_every_value_reads_back(value: int) -> None:
    assert wire.value_of(*wire.words(value)) == value


@pytest.mark.parametrize("value", [2**31, -(2**31) - 1])
def test_a_value_beyond_32_bits_is_refused(value: int) -> None:
    with pytest.raises(ValueError, match="32 bits"):
        wire.words(value)
