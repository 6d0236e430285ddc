"""The equations of a set against the printed ones of NASA/TP-1999-209835 and against explicit rotations."""

from math import cos, radians, sin

import numpy as np
import pytest
from solved import PARAMETERS, provenance, solved_axis, solved_package

from ams.errors import SetError
from ams.sets.apply import apply
from ams.sets.axis_section import axis_numbers, axis_section
from ams.sets.coefficients import build_set
from ams.sets.equations import derived_direction, equation_of

ATTITUDES_DEG = [(0.0, 0.0), (30.0, 45.0), (-57.5, 133.0), (89.0, -90.0), (-12.0, 180.0)]


def printed(axis: str, alpha: float, roll: float) -> float:
    """TP (2), (4), (5) as printed."""
    b, s, coning_deg, azimuth_deg = PARAMETERS[axis]
    w, a = radians(coning_deg), radians(azimuth_deg)
    if axis == "x":
        return b + s * (cos(w) * sin(alpha) - sin(w) * cos(alpha) * sin(roll + a))
    if axis == "y":
        bracket = sin(a) * sin(alpha) - cos(a) * cos(roll) * cos(alpha)
        return b - s * (cos(w) * sin(roll) * cos(alpha) - sin(w) * bracket)
    bracket = cos(a) * sin(alpha) - sin(a) * sin(roll) * cos(alpha)
    return b - s * (cos(w) * cos(roll) * cos(alpha) - sin(w) * bracket)


def rotated_up(alpha: float, roll: float) -> np.ndarray:
    """Up (0, 0, −1) in axes pitched about y, then rolled about x."""
    about_y = np.array([[cos(alpha), 0, -sin(alpha)], [0, 1, 0], [sin(alpha), 0, cos(alpha)]])
    about_x = np.array([[1, 0, 0], [0, cos(roll), sin(roll)], [0, -sin(roll), cos(roll)]])
    return about_x @ about_y @ np.array([0.0, 0.0, -1.0])


@pytest.mark.parametrize("attitude_deg", ATTITUDES_DEG)
@pytest.mark.parametrize("axis", "xyz")
def test_a_set_gives_the_outputs_of_the_printed_equations(axis: str, attitude_deg: tuple[float, float]) -> None:
    alpha, roll = map(radians, attitude_deg)
    outputs_v = apply(build_set(solved_package(), provenance()), alpha, roll)
    assert outputs_v[axis] == pytest.approx(printed(axis, alpha, roll), rel=0, abs=1e-14)


@pytest.mark.parametrize("attitude_deg", ATTITUDES_DEG)
def test_a_set_senses_the_up_direction_turned_by_explicit_rotations(attitude_deg: tuple[float, float]) -> None:
    alpha, roll = map(radians, attitude_deg)
    axis = solved_axis("y")
    outputs_v = apply(build_set(solved_package("y"), provenance()), alpha, roll)
    assert outputs_v["y"] == pytest.approx(axis.primary[0] + axis.primary[1:] @ rotated_up(alpha, roll), abs=1e-14)


def test_the_signs_are_those_of_the_house() -> None:
    """+pitch gives +S on x, level gives −S on z, roll +90° gives −S on y."""
    coefficients = build_set(solved_package(), provenance())
    assert apply(coefficients, np.pi / 2, 0.0)["x"] == pytest.approx(0.005 + 2.5 * cos(radians(0.5)))
    assert apply(coefficients, 0.0, 0.0)["z"] == pytest.approx(0.0007 + 2.52 * cos(radians(0.12)))
    assert apply(coefficients, 0.0, np.pi / 2)["y"] == pytest.approx(-0.0121 - 2.47 * cos(radians(0.31)))


@pytest.mark.parametrize("axis", "xyz")
def test_sensitivity_and_angles_give_the_primary_vector(axis: str) -> None:
    numbers = axis_numbers(axis, axis_section(solved_axis(axis), "SN1"))
    assert derived_direction(numbers) == pytest.approx(solved_axis(axis).primary[1:], abs=1e-15)


def test_an_undetermined_angle_leaves_the_primary_form_only() -> None:
    numbers = axis_numbers("x", axis_section(solved_axis("x", with_angles=False), "SN1"))
    assert derived_direction(numbers) is None


def test_an_equation_that_no_set_knows_is_refused() -> None:
    with pytest.raises(
        SetError, match="model 'magnetometer', nominal axis 'x': no set of this version has its equation"
    ):
        equation_of("magnetometer", "x", False)
    with pytest.raises(SetError, match="nominal axis 'y'"):
        equation_of("pitch-only", "y", False)
