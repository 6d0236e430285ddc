"""Which terms a mechanism leaves: by explicit rotation matrices with one small turn in them, differentiated exactly."""

import numpy as np
import pytest

from ams.analysis.fourier_terms import fourier_basis
from ams.analysis.residual_causes import MECHANISMS, UNUSUAL, usual_cause
from ams.frames import specific_force
from ams.models.extended import quadratic_basis

STEP = 1e-200j
PITCH, ROLL = (a.ravel() for a in np.meshgrid(*[np.deg2rad(np.arange(-180.0, 180.0, 15.0))] * 2, indexing="ij"))


def turn(axis: str, angle: complex) -> np.ndarray:
    """Passive rotation: components in axes turned by the angle."""
    i = "xyz".index(axis)
    j, k = (i + 1) % 3, (i + 2) % 3
    matrix = np.zeros((3, 3), dtype=complex)
    matrix[i, i] = 1.0
    matrix[j, j] = matrix[k, k] = np.cos(angle)
    matrix[j, k], matrix[k, j] = np.sin(angle), -np.sin(angle)
    return matrix


def sensed(pitch_of, roll_of, base=None, between=None) -> np.ndarray:
    """(K, 3) derivative of the specific force by the small error."""
    up = np.array([0.0, 0.0, -1.0])
    identity = np.eye(3)
    rows = []
    for pitch, roll in zip(PITCH, ROLL, strict=True):
        chain = turn("x", roll_of(roll)) @ (identity if between is None else between) @ turn("y", pitch_of(pitch))
        rows.append(chain @ (identity if base is None else base) @ up)
    return np.imag(np.array(rows)) / STEP.imag


def same(angle: float) -> float:
    return angle


ERRORS = {
    "the table's pitch axis (an error once a turn)": [sensed(lambda a: a + STEP * np.sin(a), same)],
    "the zero of the pitch axis or the level of the base along it": [sensed(lambda a: a + STEP, same)],
    "the level of the base across the pitch axis": [sensed(same, same, base=turn("x", STEP))],
    "a roll axis that is not square to the pitch axis": [sensed(same, same, between=turn("z", STEP))],
    "droop of the table": [sensed(lambda a: a - STEP * np.cos(a), same)],
    "the table's roll axis (an error once a turn)": [
        sensed(same, lambda r: r + STEP * np.sin(r)),
        sensed(same, lambda r: r + STEP * np.cos(r)),
    ],
    "a soft mount inside the package": [
        np.repeat(column[:, None], 3, axis=1) for column in quadratic_basis(specific_force(PITCH, ROLL)).T
    ],
}


def terms_of(output: np.ndarray) -> set[str]:
    """Terms with an amplitude; the columns are orthogonal over whole turns. Those of the model are left out."""
    candidates = fourier_basis(PITCH, ROLL)
    found = {name for name, column in candidates.items() if abs(column @ output) > 1e-9 * (column @ column)}
    return found - {"sin α", "cos α·sin R", "cos α·cos R"}


def test_rotations_give_the_specific_force() -> None:
    chains = [turn("x", r) @ turn("y", a) @ [0.0, 0.0, -1.0] for a, r in zip(PITCH[:50], ROLL[:50], strict=True)]
    np.testing.assert_allclose(np.real(chains), specific_force(PITCH[:50], ROLL[:50]), atol=1e-15)


@pytest.mark.parametrize("words", MECHANISMS)
def test_a_mechanism_leaves_the_terms_that_it_is_named_for(words) -> None:
    for index, axis in enumerate("xyz"):
        left = set().union(*(terms_of(error[:, index]) for error in ERRORS[words]))
        assert MECHANISMS[words].get(axis, frozenset()) == left, axis


def test_every_mechanism_has_its_rotation_here() -> None:
    assert set(ERRORS) == set(MECHANISMS)


def test_words_name_every_mechanism_that_fits() -> None:
    assert usual_cause("sin 2α", "x") == "the table's pitch axis (an error once a turn)"
    assert usual_cause("cos 2α", "x") == "droop of the table or a soft mount inside the package"
    assert usual_cause("sin 2α·cos 2R", "x") == UNUSUAL
