import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ams.rounding import two_digits, with_uncertainty
from ams.statistics.intervals import degrees_of_freedom
from procedures.numbers import angle, arcsec, duration, p_value, three_digits


@pytest.mark.parametrize(
    ("value", "uncertainty", "printed"),
    [
        # JCGM 100:2008, 7.2.2: m = 100,021 47 g with u = 0,35 mg; 7.2.6: y = 10,057 62 Ω with u = 27 mΩ.
        (100.02147, 0.00035, ("100.02147", "0.00035")),
        (10.05762, 0.027, ("10.058", "0.027")),
        (1.23456, 0.0998, ("1.23", "0.10")),
        (1.23456, 0.00996, ("1.235", "0.010")),
        (123456.0, 1234.0, ("123500", "1200")),
        (-0.0000001, 0.01, ("0.000", "0.010")),
        (2.5, 0.0, ("2.5", "—")),
        (2.5, None, ("2.5", "—")),
        (2.5, float("nan"), ("2.5", "—")),
    ],
)
def test_a_value_is_printed_to_two_digits_of_its_uncertainty(
    value: float, uncertainty: float | None, printed: tuple[str, str]
) -> None:
    assert with_uncertainty(value, uncertainty) == printed


def test_a_magnitude_keeps_two_digits_at_any_size() -> None:
    assert [two_digits(value) for value in (0.0123, 0.999, 9.96, 1234.0, 0.0, -0.456)] == [
        "0.012", "1.0", "10", "1200", "0", "-0.46",
    ]  # fmt: skip
    assert two_digits(float("nan")) == "—"


def test_an_arc_second_is_the_3600th_of_a_degree() -> None:
    # 2.5 V/g: sin(1″) · 2.5 V = 12.120 µV
    assert arcsec(12.1203e-6, 2.5) == pytest.approx(1.0, rel=1e-5)
    assert arcsec(12.1203e-6, -2.5) == pytest.approx(1.0, rel=1e-5)


def test_a_probability_is_never_printed_as_zero() -> None:
    assert p_value(1e-30) == "< 0.001"
    assert p_value(0.0412) == "0.041"
    assert three_digits(37.34) == "37.3"
    assert [three_digits(value) for value in (919.0, 99.96, 0.0154, 2.22)] == ["919", "100", "0.02", "2.22"]


def test_angles_read_as_people_write_them() -> None:
    assert [angle(value) for value in (-90.0, 0.0, -0.0, 0.1234)] == ["−90°", "0°", "0°", "0.1234°"]


@pytest.mark.parametrize(
    ("seconds", "expected"),
    [
        (-3.0, "0 s"), (0.4, "0.4 s"), (8.0, "8 s"), (9.96, "10 s"), (59.4, "59 s"), (59.6, "1 min 00 s"),
        (100.0, "1 min 40 s"), (432.0, "7 min 12 s"), (599.6, "10 min"), (720.0, "12 min"), (3570.0, "1 h 00 min"),
        (11100.0, "3 h 05 min"), (44460.0, "12 h 21 min"), (180_000.0, "50 h 00 min"),
    ],
)  # fmt: skip
def test_a_duration_names_no_more_than_two_units(seconds: float, expected: str) -> None:
    assert duration(seconds) == expected


@given(st.floats(0.0, 1e6))
def test_a_duration_read_back_is_off_by_no_more_than_one_in_twenty(seconds: float) -> None:
    words, unit_s = duration(seconds).split(), {"s": 1.0, "min": 60.0, "h": 3600.0}
    read_s = sum(float(number) * unit_s[unit] for number, unit in zip(words[::2], words[1::2], strict=True))
    assert read_s == pytest.approx(seconds, rel=0.051, abs=0.051)


@pytest.mark.parametrize(
    ("dof", "expected"),
    [(None, "—"), (math.nan, "—"), (5.0, "5"), (5.46, "5.5"), (59.4, "59"), (10_000.4, "> 10 000"), (math.inf, "∞")],
)
def test_degrees_of_freedom_have_the_digits_that_say_something(dof: float | None, expected: str) -> None:
    assert degrees_of_freedom(dof) == expected
