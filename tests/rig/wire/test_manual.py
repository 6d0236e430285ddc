"""Laws of the lines that an operator reads and types."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.wire import manual as wire
from rig.wire.manual import LeaveIt, Order, SetTo, SetToZero

LINES: list[tuple[Order, bytes]] = [
    (
        SetTo("pitch", 30.0),
        b"pitch: set the axis to 30 deg, then press Enter (or type the angle it shows, or 'no')\n",
    ),
    (
        SetTo("roll", -0.25),
        b"roll: set the axis to -0.25 deg, then press Enter (or type the angle it shows, or 'no')\n",
    ),
    (SetToZero("pitch"), b"pitch: set the axis to its zero, then press Enter (or type 'no')\n"),
    (LeaveIt("pitch"), b"pitch: stop; leave the axis as it is\n"),
]


@pytest.mark.parametrize(("order", "line"), LINES)
def test_an_order_is_this_line(order: Order, line: bytes) -> None:
    assert wire.encode(order) == line
    assert wire.decode(line.decode()[:-1]) == order


@given(st.floats(-400, 400))
def test_an_angle_keeps_six_decimals(angle_deg: float) -> None:
    order = wire.decode(wire.encode(SetTo("pitch", angle_deg)).decode()[:-1])
    assert isinstance(order, SetTo)
    assert abs(order.angle_deg - angle_deg) <= 0.5000001e-6


@pytest.mark.parametrize(("answer", "angle_deg"), [("30", 30.0), ("-29.98", -29.98), ("+.5", 0.5), ("7.", 7.0)])
def test_a_typed_angle_is_a_plain_number(answer: str, angle_deg: float) -> None:
    assert wire.decode_angle(answer) == angle_deg


@pytest.mark.parametrize("answer", ["", "30 deg", "nan", "inf", "1e3", "29,98", "yes", "٣"])
def test_anything_else_is_no_angle(answer: str) -> None:
    assert wire.decode_angle(answer) is None


@given(st.text(max_size=60))
def test_no_text_breaks_the_reading(text: str) -> None:
    wire.decode(text)
    wire.decode_angle(text)
