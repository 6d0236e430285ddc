"""An axis is named where the rows tell it, and only there; two packages have the degrees of freedom that they have."""

import numpy as np
import pytest

from ams.attitude.flag_codes import REDUNDANCY, SUSPECT_Y, SUSPECT_Z, suspects_in_words, words
from ams.attitude.redundancy import (
    at_offset_or_rail,
    disagreement,
    explaining,
    may_be_wrong,
    name_suspects,
)
from ams.frames import specific_force
from ams.models.cr import model_gravity_g, sting_gravity_g

DEG = np.pi / 180
K = np.array([[2.5, 0.01, -0.02], [0.02, -2.4, 0.03], [0.01, -0.02, 2.6]])
OFFSET_V = np.array([0.01, -0.02, 0.03])
SD_V = np.full(3, 1e-4)


def test_a_line_unplugged_in_a_row_is_named_by_its_offset() -> None:
    """True pitch 20°, roll 30°, y reads its offset: the case that was answered 22.43° and −0.34° without a word."""
    force = specific_force(np.array([20 * DEG]), np.array([30 * DEG])).T
    outputs = K @ force + OFFSET_V[:, None]
    outputs[1] = OFFSET_V[1]
    at_limit = at_offset_or_rail(outputs, OFFSET_V, 5 * SD_V)
    assert at_limit.ravel().tolist() == [False, True, False]
    possible = may_be_wrong(K, outputs - OFFSET_V[:, None], SD_V)
    codes = name_suspects(np.array([REDUNDANCY], dtype=np.uint32), at_limit, possible)
    assert codes[0] == REDUNDANCY | SUSPECT_Y
    assert words(codes) == ("redundancy: suspect y",)


def test_a_reading_at_a_rail_is_named() -> None:
    outputs = np.array([[0.5], [0.4], [2.6]])
    found = at_offset_or_rail(outputs, OFFSET_V, SD_V, np.array([[-2.6, 2.6]] * 3))
    assert found.ravel().tolist() == [False, False, True]


def test_two_axes_without_an_attitude_leave_only_one_that_is_right() -> None:
    """x at 0.6 g and y at 0.5 g are possible, z at 1.2 g is not with either of them."""
    deviation = K @ np.array([[0.6], [0.5], [1.2]])
    possible = may_be_wrong(K, deviation, SD_V)
    assert possible.ravel().tolist() == [False, False, True]
    codes = name_suspects(np.array([REDUNDANCY], dtype=np.uint32), np.zeros((3, 1), dtype=bool), possible)
    assert codes[0] == REDUNDANCY | SUSPECT_Z


def test_rows_that_agree_name_nobody() -> None:
    codes = name_suspects(
        np.zeros(1, dtype=np.uint32), np.ones((3, 1), dtype=bool), np.array([[True], [False], [False]])
    )
    assert codes[0] == 0


def packages(pitch, yaw, roll):
    """Six outputs in g of a sting and a model package by CR's frames, with their derivatives by central differences."""

    def outputs(angles):
        gravity = sting_gravity_g(angles[0], angles[1])
        return np.concatenate([gravity, model_gravity_g(gravity, angles[2])])

    at, h = np.array([pitch, yaw, roll]), 1e-6
    columns = [(outputs(at + h * e) - outputs(at - h * e)) / (2 * h) for e in np.eye(3)]
    return outputs(at), np.stack(columns, axis=-1)


SD_G = 1e-4
SIX = np.eye(6)[None] * SD_G**2


def test_two_packages_have_valid_readings_less_rank_degrees_of_freedom() -> None:
    _, J = packages(0.3, 0.2, 0.5)
    valid = np.ones((1, 6), dtype=bool)
    assert disagreement(np.zeros((1, 6)), J[None], SIX, valid).dof.tolist() == [3]
    assert disagreement(np.zeros((1, 6)), J[None, :, [0, 2]], SIX, valid).dof.tolist() == [4]  # yaw known
    valid[0, 4] = False
    assert disagreement(np.zeros((1, 6)), J[None], SIX, valid).dof.tolist() == [2]
    _, level = packages(0.0, 0.2, 0.5)
    assert disagreement(np.zeros((1, 6)), level[None], SIX, np.ones((1, 6), dtype=bool)).dof.tolist() == [4]


def test_two_packages_that_agree_have_the_chi_square_of_their_degrees_of_freedom() -> None:
    rng = np.random.default_rng(3)
    count = 4000
    _, J = packages(0.3, 0.2, 0.5)
    residuals = rng.normal(0, SD_G, (count, 6))
    found = disagreement(
        residuals, np.repeat(J[None], count, axis=0), np.repeat(SIX, count, axis=0), np.ones((count, 6), dtype=bool)
    )
    assert found.chi_square.mean() == pytest.approx(3.0, abs=4 * np.sqrt(6 / count))
    assert found.is_above(np.inf).mean() < 0.004


@pytest.mark.parametrize(
    ("reading", "words_"), [(1, "y or z of the sting package"), (4, "y or z of the model package")]
)
def test_y_and_z_of_a_package_cannot_be_told_apart_in_a_row(reading: int, words_: str) -> None:
    _, J = packages(0.3, 0.2, 0.5)
    residuals = np.zeros((1, 6))
    residuals[0, reading] = 0.01
    found = explaining(residuals, J[None], SIX, np.ones((1, 6), dtype=bool))
    said = suspects_in_words(found[0].tolist(), list("xyzxyz"), ["sting"] * 3 + ["model"] * 3)
    assert said == words_


def test_at_level_pitch_the_two_x_cannot_be_told_apart() -> None:
    _, J = packages(0.0, 0.0, 0.5)
    residuals = np.zeros((1, 6))
    residuals[0, 0] = 0.01
    found = explaining(residuals, J[None], SIX, np.ones((1, 6), dtype=bool))
    said = suspects_in_words(found[0].tolist(), list("xyzxyz"), ["sting"] * 3 + ["model"] * 3)
    assert said == "x of the sting package or x of the model package"


def test_the_x_of_a_package_is_told_from_the_rest() -> None:
    _, J = packages(0.3, 0.2, 0.5)
    residuals = np.zeros((1, 6))
    residuals[0, 3] = 0.01
    found = explaining(residuals, J[None], SIX, np.ones((1, 6), dtype=bool))
    assert (
        suspects_in_words(found[0].tolist(), list("xyzxyz"), ["sting"] * 3 + ["model"] * 3) == "x of the model package"
    )
