"""Laws of the servo's calibration."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.wire.pulses import PulseCalibration

BENT = PulseCalibration([(1000.0, -45.0), (1500.0, 0.0), (2000.0, 50.0)])


@pytest.mark.parametrize(
    ("pulse_us", "angle_deg"), [(1000, -45), (1250, -22.5), (1500, 0), (1750, 25), (2000, 50), (2100, 60), (900, -54)]
)
def test_straight_lines_go_through_the_points_and_on(pulse_us: float, angle_deg: float) -> None:
    assert BENT.angle_deg(pulse_us) == pytest.approx(angle_deg)
    assert BENT.pulse_us(angle_deg) == pytest.approx(pulse_us)


def test_a_servo_may_be_mounted_the_other_way_round() -> None:
    reversed_ = PulseCalibration([(1000.0, 90.0), (2000.0, -90.0)])
    assert reversed_.pulse_us(45.0) == pytest.approx(1250.0)
    assert reversed_.smallest_us_per_deg == pytest.approx(1000.0 / 180.0)


def test_the_flattest_line_limits_the_speed() -> None:
    assert BENT.smallest_us_per_deg == pytest.approx(10.0)
    assert (BENT.deg_per_us(1200.0), BENT.deg_per_us(1800.0)) == (pytest.approx(0.09), pytest.approx(0.1))


@given(st.floats(-200, 200))
def test_there_and_back_is_the_same_angle(angle_deg: float) -> None:
    assert BENT.angle_deg(BENT.pulse_us(angle_deg)) == pytest.approx(angle_deg, abs=1e-9)


@pytest.mark.parametrize(
    "points",
    [[], [(1500.0, 0.0)], [(1000.0, 0.0), (2000.0, 0.0)], [(1000.0, 0.0), (1000.0, 5.0)], [(1, 0), (2, 5), (3, 4)]],
)
def test_what_is_no_calibration_is_refused(points: list[tuple[float, float]]) -> None:
    with pytest.raises(ValueError, match="two or more"):
        PulseCalibration(points)
