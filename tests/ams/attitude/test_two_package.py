"""CR's attitude from gravity in two packages: every attitude of its branch, and NaN where an angle has no meaning."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ams.attitude.two_package import angles_from_gravity
from ams.models.cr import model_gravity_g, sting_gravity_g


def away(low, high):
    return st.floats(low, high) | st.floats(-high, -low)


@given(away(0.01, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_every_attitude_is_found_within_its_branch(pitch, yaw, roll):
    gravity = sting_gravity_g(np.array([pitch]), np.array([yaw]))
    found = angles_from_gravity(gravity, model_gravity_g(gravity, np.array([roll])))
    assert found.pitch_rad[0] == pytest.approx(pitch, abs=1e-10)
    assert found.yaw_rad[0] == pytest.approx(yaw, abs=1e-9)
    assert np.cos(found.roll_rad[0] - roll) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize(
    ("pitch", "yaw", "lost"),
    [(0.0, 0.3, {"yaw_rad"}), (0.4, np.pi / 2, {"pitch_rad", "yaw_rad"}), (np.pi / 2, 0.0, {"roll_rad"})],
)
def test_an_angle_without_meaning_is_not_stated(pitch, yaw, lost):
    gravity = sting_gravity_g(np.array([pitch]), np.array([yaw]))
    found = angles_from_gravity(gravity, model_gravity_g(gravity, np.array([0.2])))
    assert {name for name, values in vars(found).items() if np.isnan(values[0])} == lost


def test_at_no_pitch_the_other_angles_are_still_given():
    gravity = sting_gravity_g(np.array([0.0]), np.array([0.0]))
    found = angles_from_gravity(gravity, model_gravity_g(gravity, np.array([0.2])))
    assert found.pitch_rad[0] == 0.0
    assert found.roll_rad[0] == pytest.approx(0.2)
