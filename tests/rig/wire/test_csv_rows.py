"""Laws of streamed text: whole rows or none, at their place, whatever comes between."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.wire.csv_rows import RowShape, format_row, parse_rows
from rig.wire.stream_lines import split_whole_lines

NINE = b"12,1333,-4,-1330,14,-29,0,625,-3,1250\r\n"
# By hand: 41 ^ 2C ^ 31 ^ 2C ^ 32 = 42 ("A,1,2"), and without a dollar 31 ^ 2C ^ 32 = 2F ("1,2").
WITH_DOLLAR, WITHOUT = b"$A,1,2*42\r\n", b"1,2*2F\r\n"


def test_a_row_is_its_numbers() -> None:
    rows = parse_rows(NINE * 2, RowShape(10))
    assert rows.values.tolist() == [[12, 1333, -4, -1330, 14, -29, 0, 625, -3, 1250]] * 2


@pytest.mark.parametrize("separator", [b",", b";", b"\t", b" "])
def test_separators_are_settings(separator: bytes) -> None:
    line = separator.join([b"1", b"-2.5", b"3e-2"]) + b"\n"
    assert parse_rows(line, RowShape(3, separator)).values.tolist() == [[1.0, -2.5, 0.03]]


@pytest.mark.parametrize(("line", "prefix"), [(WITH_DOLLAR, b"$A,"), (WITHOUT, b"")])
def test_a_checksum_is_the_xor_of_what_stands_before_it_behind_the_dollar(line: bytes, prefix: bytes) -> None:
    shape = RowShape(2, prefix=prefix, checksum="xor")
    assert format_row([b"1", b"2"], shape) == line
    wrong = line.replace(b"2*", b"3*")
    rows = parse_rows(line + wrong + line.lower().replace(prefix.lower(), prefix), shape)
    assert rows.values.tolist() == [[1.0, 2.0]] * 2
    assert [(refusal.before, refusal.why) for refusal in rows.refused] == [(1, "the checksum is wrong")]


@pytest.mark.parametrize(
    "line",
    [
        b"t,ax,ay\r\n",
        b"1,2\r\n",
        b"1,2,3,4\n",
        b"1,,3\n",
        b"1,2,nan\n",
        b"1,2,0x3\n",
        b"1,2,3 4\n",
        b"\r\n",
        b"1,2,1_0\n",
    ],
)
def test_what_is_no_row_is_refused_with_its_place(line: bytes) -> None:
    rows = parse_rows(b"1,2,3\n" + line + b"4,5,6\n", RowShape(3))
    assert rows.values.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert [(refusal.before, refusal.line) for refusal in rows.refused] == [(1, line)]


@given(st.integers(0, len(NINE) * 2))
def test_pieces_may_end_anywhere(cut: int) -> None:
    whole, rest = split_whole_lines((NINE * 2)[:cut])
    assert whole + rest == (NINE * 2)[:cut]
    later, left = split_whole_lines(rest + (NINE * 2)[cut:])
    count = len(parse_rows(whole, RowShape(10)).values) + len(parse_rows(later, RowShape(10)).values)
    assert (count, left) == (2, b"")


@given(
    st.lists(st.lists(st.integers(-(2**31), 2**32), min_size=4, max_size=4), max_size=20),
    st.sampled_from(["none", "xor"]),
)
def test_rows_survive_the_wire(values: list[list[int]], checksum: str) -> None:
    shape = RowShape(4, prefix=b"$B,", checksum=checksum)  # type: ignore[arg-type]
    piece = b"".join(format_row([b"%d" % number for number in row], shape) for row in values)
    rows = parse_rows(piece, shape)
    np.testing.assert_array_equal(rows.values, np.array(values, dtype=float).reshape(-1, 4))


@given(st.lists(st.binary(max_size=50).map(lambda noise: noise + b"\n")), st.sampled_from(["none", "xor"]))
def test_no_bytes_raise_anything(lines: list[bytes], checksum: str) -> None:
    rows = parse_rows(b"".join(lines), RowShape(2, checksum=checksum))  # type: ignore[arg-type]
    assert np.isfinite(rows.values).all()
