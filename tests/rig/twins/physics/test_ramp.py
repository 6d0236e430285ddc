"""Laws of the twins' paths: limited speed and acceleration, the shortest time, no jump anywhere."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.twins.physics.ramp import Ramp, Spin


def test_a_long_way_is_a_trapezoid_and_a_short_one_a_triangle() -> None:
    # 10 per s at 20 per s²: 0.5 s and 2.5 each to ramp; 25 between takes 2.5 s.
    assert Ramp(0.0, 30.0, 100.0, 10.0, acceleration=20.0).arrival_s == pytest.approx(103.5)
    # 0.05 at 20 per s²: 2 √(0.05/20) s, never at top speed.
    short = Ramp(0.0, -0.05, 0.0, 10.0, acceleration=20.0)
    assert short.arrival_s == pytest.approx(0.1)
    assert short.speed_at(0.05) == pytest.approx(-1.0)


def test_without_limits_it_is_a_line_or_a_jump() -> None:
    line = Ramp(2.0, 12.0, 0.0, 5.0)
    assert (line.at(1.0), line.arrival_s) == (7.0, 2.0)
    jump = Ramp(2.0, 12.0, 3.0, math.inf)
    assert (jump.at(3.0), jump.arrival_s) == (12.0, 3.0)


@given(
    position=st.floats(-500, 500),
    target=st.floats(-500, 500),
    top=st.floats(0.5, 50),
    acceleration=st.floats(0.5, 100),
    part=st.floats(-1, 1),
)
def test_no_ramp_breaks_its_limits_or_jumps(
    position: float, target: float, top: float, acceleration: float, part: float
) -> None:
    ramp = Ramp(position, target, 0.0, top, speed=part * top, acceleration=acceleration)
    step_s = ramp.arrival_s / 400.0
    indices = [ramp.at(i * step_s) for i in range(401)]
    speeds = [ramp.speed_at(i * step_s) for i in range(401)]
    assert indices[0] == pytest.approx(position, abs=1e-6)
    assert ramp.at(ramp.arrival_s) == target
    assert ramp.speed_at(ramp.arrival_s) == 0.0
    assert max(abs(speed) for speed in speeds) <= top * (1.0 + 1e-6)
    assert all(abs(b - a) <= (top + acceleration * step_s) * step_s + 1e-6 for a, b in pairwise(indices))
    assert all(abs(b - a) <= acceleration * step_s * 1.001 + 1e-3 for a, b in pairwise(speeds))


def test_a_spin_ramps_to_its_rate_and_keeps_it() -> None:
    spin = Spin(0.0, -20.0, 10.0, speed=0.0, acceleration=40.0)
    assert spin.at(10.5) == pytest.approx(-5.0)  # ½ · 40 · 0.5²
    assert spin.at(110.5) == pytest.approx(-2005.0)
    assert (spin.speed_at(60.0), spin.arrival_s) == (-20.0, math.inf)
