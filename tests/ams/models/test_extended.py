"""The extended model: its five terms, their derivatives, their independence of the base model."""

import numpy as np
import pytest

from ams.frames import AXES, Attitude, specific_force
from ams.models.extended import ExtendedPitchRoll, matrix_from_elements, quadratic_basis
from ams.models.registry import model_named

Q = np.array([3e-5, -1e-5, 2e-5, 4e-5, -6e-6])
PRIMARY = np.array([0.01, 2.5, 0.02, -0.03, *Q])


def attitudes(n=80, seed=2):
    pitch, roll = np.random.default_rng(seed).uniform(-np.pi, np.pi, (2, n))
    return Attitude(pitch, roll)


def test_the_five_terms_are_the_quadratic_form_of_a_traceless_matrix():
    force = np.random.default_rng(1).normal(size=(20, 3))
    matrix = matrix_from_elements(Q)
    assert np.trace(matrix) == 0.0
    np.testing.assert_allclose(quadratic_basis(force) @ Q, np.einsum("ni,ij,nj->n", force, matrix, force), atol=1e-18)


@pytest.mark.parametrize("axis", AXES)
def test_outputs_come_back_as_parameters(axis):
    model, rows = ExtendedPitchRoll(axis), attitudes()
    force = specific_force(rows.pitch_rad, rows.roll_rad)
    output = 0.01 + force @ PRIMARY[1:4] + np.einsum("ni,ij,nj->n", force, matrix_from_elements(Q), force)
    np.testing.assert_allclose(model.start(rows, output), PRIMARY, atol=1e-14)
    np.testing.assert_allclose(model.parameters(PRIMARY)[4:], Q)
    np.testing.assert_allclose(model.parameters(PRIMARY)[:4], model_named("pitch-roll", axis).parameters(PRIMARY[:4]))


def test_angle_derivatives_are_the_complex_step():
    model, rows, h = ExtendedPitchRoll("y"), attitudes(9), 1e-30
    primary = PRIMARY * np.array([1, 1, 1, 1, 1e4, 1e4, 1e4, 1e4, 1e4])
    shifted = {
        "pitch": Attitude(rows.pitch_rad + 1j * h, rows.roll_rad),
        "roll": Attitude(rows.pitch_rad, rows.roll_rad + 1j * h),
    }
    for name, moved in shifted.items():
        numeric = model.predict(primary, moved).imag / h
        np.testing.assert_allclose(model.angle_jacobian(primary, rows)[name], numeric, rtol=1e-12, atol=1e-14)


def test_a_soft_mount_has_two_periods_in_pitch_and_one_in_roll():
    # TP 9.2.3: sinusoidal with two periods over α = −180° to 180°, and one over roll at a given pitch.
    angle = np.arange(64) * 2 * np.pi / 64
    pitch_wave = quadratic_basis(specific_force(angle, np.zeros(64))) @ Q
    assert np.argmax(np.abs(np.fft.rfft(pitch_wave - pitch_wave.mean()))) == 2
    tilted = np.array([0.0, 0.0, 2e-5, 0.0, 0.0])  # q_xz, a sensor along x leaning under its own load
    roll_wave = quadratic_basis(specific_force(np.full(64, 0.5), angle)) @ tilted
    assert np.argmax(np.abs(np.fft.rfft(roll_wave))) == 1
