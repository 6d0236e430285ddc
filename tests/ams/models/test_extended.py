"""The extended model: its terms, their derivatives, their independence of the linear sensor."""

import numpy as np
import pytest

from ams.frames import AXES, Attitude, specific_force
from ams.models.extended import ExtendedPitchRoll, centring_of, matrix_from_elements, quadratic_basis
from ams.models.registry import model_named

Q = np.array([3e-5, -1e-5, 2e-5, 4e-5, -6e-6])
K, K3 = np.array([2.5, 0.02, -0.03]), 5e-5


def attitudes(n=80, seed=2):
    pitch, roll = np.random.default_rng(seed).uniform(-np.pi, np.pi, (2, n))
    return Attitude(pitch, roll)


def test_the_five_terms_are_the_quadratic_form_of_a_traceless_matrix():
    force = np.random.default_rng(1).normal(size=(20, 3))
    matrix = matrix_from_elements(Q)
    assert np.trace(matrix) == 0.0
    np.testing.assert_allclose(quadratic_basis(force) @ Q, np.einsum("ni,ij,nj->n", force, matrix, force), atol=1e-18)


def extended(axis, rows):
    centring = centring_of(rows, rows.pitch_rad.size, axis)
    assert centring is not None
    return ExtendedPitchRoll(axis, centring)


def bent(force, axis):
    """b + k·f + fᵀQf + K₃ f_i³, written out."""
    quadratic = np.einsum("ni,ij,nj->n", force, matrix_from_elements(Q), force)
    return 0.01 + force @ K + quadratic + K3 * force[:, "xyz".index(axis)] ** 3


@pytest.mark.parametrize("axis", AXES)
def test_offset_and_sensitivities_are_those_of_the_best_linear_sensor(axis):
    rows = attitudes()
    model, force = extended(axis, rows), specific_force(rows.pitch_rad, rows.roll_rad)
    output = bent(force, axis)
    found = model.start(rows, output)
    linear = np.column_stack([np.ones(len(force)), force])
    np.testing.assert_allclose(found[:4], np.linalg.lstsq(linear, output, rcond=None)[0], atol=1e-14)
    np.testing.assert_allclose(found[4:], [*Q, K3], atol=1e-14)
    stated = dict(zip(model.parameter_names, model.parameters(found), strict=True))
    assert stated["offset_traceless_v"] == pytest.approx(0.01, abs=1e-14)
    np.testing.assert_allclose(model.parameters(found)[:4], model_named("pitch-roll", axis).parameters(found[:4]))
    np.testing.assert_allclose(model.predict(found, attitudes(9, 5)), bent(forces(attitudes(9, 5)), axis), atol=1e-14)


def forces(rows):
    return specific_force(rows.pitch_rad, rows.roll_rad)


@pytest.mark.parametrize("axis", AXES)
def test_the_terms_are_orthogonal_to_the_linear_sensor_over_the_design(axis):
    rows = attitudes()
    basis = extended(axis, rows).basis(rows)
    np.testing.assert_allclose(basis[:, :4].T @ basis[:, 4:], 0.0, atol=1e-12)


def test_points_that_determine_no_cubic_leave_it_out_and_points_that_determine_no_terms_all():
    """Three pitch angles hold sin³ as a multiple of sin; a tumble holds no square beside a constant."""
    pitch, roll = (g.ravel() for g in np.meshgrid(np.deg2rad([-40.0, 0.0, 40.0]), np.deg2rad(np.arange(0, 360, 45))))
    assert len(centring_of(Attitude(pitch, roll), pitch.size, "x")) == 5
    tumble = Attitude(np.deg2rad([0, 0, 0, 0, 90, -90]), np.deg2rad([0, 90, 180, -90, 0, 0]))
    assert centring_of(tumble, 6, "x") is None


@pytest.mark.parametrize("axis", AXES)
def test_arc_seconds_of_correction_excite_no_term_that_the_design_does_not(axis):
    """Four pitches by six rolls determine no cubic along x; a list of errors turns them by an arc second or two."""
    pitch, roll = (
        np.deg2rad(a).ravel() for a in np.meshgrid([-90.0, -30.0, 30.0, 90.0], np.arange(-180.0, 180.0, 60.0))
    )
    plain = centring_of(Attitude(pitch, roll), pitch.size, axis)
    turned = np.deg2rad(np.random.default_rng(4).uniform(-2.0, 2.0, (2, pitch.size)) / 3600.0)
    corrected = centring_of(Attitude(pitch + turned[0], roll + turned[1]), pitch.size, axis)
    assert (plain is None) == (corrected is None)
    assert len(corrected or ()) == len(plain or ())


def test_derivatives_are_the_complex_step():
    rows, h = attitudes(9), 1e-30
    model = extended("y", attitudes())
    primary = np.array([0.01, *K, *(1e4 * Q), 0.2])
    shifted = {
        "pitch": Attitude(rows.pitch_rad + 1j * h, rows.roll_rad),
        "roll": Attitude(rows.pitch_rad, rows.roll_rad + 1j * h),
    }
    for name, moved in shifted.items():
        numeric = model.predict(primary, moved).imag / h
        np.testing.assert_allclose(model.angle_jacobian(primary, rows)[name], numeric, rtol=1e-12, atol=1e-14)
    ahead, behind = (
        np.stack([model.parameters(primary + step) for step in sign * 1e-6 * np.eye(primary.size)], axis=-1)
        for sign in (1.0, -1.0)
    )
    np.testing.assert_allclose(model.parameters_jacobian(primary), (ahead - behind) / 2e-6, rtol=1e-6, atol=1e-6)


def test_a_soft_mount_has_two_periods_in_pitch_and_one_in_roll():
    # TP 9.2.3: sinusoidal with two periods over α = −180° to 180°, and one over roll at a given pitch.
    angle = np.arange(64) * 2 * np.pi / 64
    pitch_wave = quadratic_basis(specific_force(angle, np.zeros(64))) @ Q
    assert np.argmax(np.abs(np.fft.rfft(pitch_wave - pitch_wave.mean()))) == 2
    tilted = np.array([0.0, 0.0, 2e-5, 0.0, 0.0])  # q_xz, a sensor along x leaning under its own load
    roll_wave = quadratic_basis(specific_force(np.full(64, 0.5), angle)) @ tilted
    assert np.argmax(np.abs(np.fft.rfft(roll_wave))) == 1
