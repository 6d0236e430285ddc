"""Laws of the last check before an axis is sent anywhere: limits belong to what is allowed, nothing beyond does."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.abilities.targets import check_target, is_on_increment, nearest_step, require_home
from rig.description.device_settings import AxisSettings
from rig.errors import RequestRefused

LIMITS = (-45.0, 90.0)


def axis(increment_deg: float = 0.0, zero_deg: float = 0.0) -> AxisSettings:
    return AxisSettings(
        driver="any", port="twin", limits_deg=LIMITS, speed_dps=1.0, increment_deg=increment_deg, zero_deg=zero_deg
    )


@pytest.mark.parametrize("target_deg", [-45.0, 0.0, 90.0])
def test_both_limits_are_allowed(target_deg: float) -> None:
    check_target("pitch", axis(1.0), target_deg)


@pytest.mark.parametrize("target_deg", [math.nextafter(-45.0, -90.0), math.nextafter(90.0, 180.0), math.inf, math.nan])
def test_nothing_beyond_a_limit_is(target_deg: float) -> None:
    with pytest.raises(RequestRefused, match=r"pitch: move to .*nothing moved"):
        check_target("pitch", axis(), target_deg)


@pytest.mark.parametrize(("table_deg", "fits"), [(10.0, True), (10.0 + 1e-9, True), (10.01, False), (10.5, False)])
def test_the_teeth_are_those_of_the_machine(table_deg: float, fits: bool) -> None:
    """With a zero of its own, an attitude between two degrees may stand on a tooth, and the other way round."""
    if fits:
        check_target("pitch", axis(1.0, zero_deg=table_deg - 3.3), 3.3)
        return
    with pytest.raises(RequestRefused, match="multiples of 1°"):
        check_target("pitch", axis(1.0, zero_deg=table_deg - 3.0), 3.0)


@given(st.integers(-3_600_000, 3_600_000), st.integers(1, 100_000), st.integers(1, 6))
def test_every_multiple_stands_on_a_tooth_and_nothing_a_thousandth_of_one_beside_it(
    tooth: int, thousandths: int, digits: int
) -> None:
    """However fine the teeth are and however many: what binary fractions round is far below a thousandth of any."""
    increment_deg = thousandths / 10.0 ** (digits + 3)
    assert is_on_increment(tooth * increment_deg, increment_deg)
    assert is_on_increment(float(f"{tooth * increment_deg:.15g}"), increment_deg)
    assert not is_on_increment((tooth + 0.001) * increment_deg, increment_deg)


@given(st.floats(-1e6, 1e6), st.floats(-1e5, 1e5), st.floats(2.0, 1e5))
def test_the_nearest_step_is_whole_and_between_the_limits(step: float, low: float, span: float) -> None:
    high = low + span
    whole = nearest_step(step, (low, high))
    assert whole == nearest_step(step, (high, low)), "an axis of the other sense has them in the other order"
    assert low - 1e-5 <= whole <= high + 1e-5
    if low + 1.0 <= step <= high - 1.0:
        assert abs(whole - step) <= 0.5


def test_an_axis_that_is_not_homed_is_sent_nowhere() -> None:
    require_home("pitch", "move to 3 deg", is_homed=True)
    with pytest.raises(
        RequestRefused, match=r"^pitch: turn at 3 deg/s: the axis is not homed; nothing moved; home it first$"
    ):
        require_home("pitch", "turn at 3 deg/s", is_homed=False)
