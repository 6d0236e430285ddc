"""The clean campaign, against a least-squares solution written out here."""

import numpy as np
import pytest
from physics_scenes import FINE, SCENES, campaigns, mixed, used_later
from physics_scenes.rotations import ARCSEC, specific_force


def least_squares(drawn) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (n, S, A, 4) estimates, errors over their standard uncertainty, and residual standard deviation in ″."""
    pitch, roll = np.deg2rad(drawn.points_deg).T
    force = np.einsum("sij,kj->ski", drawn.setup.mount_matrices(), specific_force(pitch, roll))[0]
    basis = np.concatenate([np.ones((force.shape[0], 1)), force], axis=1)
    outputs = drawn.grid(drawn.output_v)
    estimate = np.einsum("jk,nrksa->nsaj", np.linalg.pinv(basis), outputs) / outputs.shape[1]
    residual = outputs - np.einsum("kj,nsaj->nksa", basis, estimate)[:, None]
    sd = residual.std(axis=(1, 2))
    spread = np.sqrt(np.diag(np.linalg.inv(basis.T @ basis)) / outputs.shape[1])
    package = drawn.package
    truth = np.concatenate([package.offset_v[..., None], package.vector_v_per_g], axis=-1)
    return estimate, (estimate - truth) / (sd[..., None] * spread), sd / package.sensitivity_v_per_g / ARCSEC


@pytest.mark.parametrize("design", [{}, {"pitch_limit_deg": 10.0}, {"order": "random"}, {**FINE, "replications": 1}])
def test_least_squares_finds_the_truth_of_a_clean_campaign(design):
    _, score, sd_arcsec = least_squares(campaigns("clean", 0.0, np.random.default_rng(2), 60, **design))
    assert abs(score.mean()) < 0.2
    assert score.std() == pytest.approx(1.0, abs=0.12)
    assert sd_arcsec.mean() == pytest.approx(1.65, rel=0.01)


@pytest.mark.parametrize("axes", ["x", "xy", "xz", "xyz"])
def test_a_package_has_the_axes_that_were_asked_for(axes):
    drawn = campaigns("clean", 0.0, np.random.default_rng(2), 3, axes=axes, sensors=2)
    assert drawn.output_v.shape == (3, 936, 2, len(axes))
    for i, axis in enumerate(axes):
        assert (drawn.package.axis_direction[..., i, "xyz".index(axis)] > 0.999).all()


def test_the_true_output_is_the_reading_without_noise():
    drawn = campaigns("clean", 0.0, np.random.default_rng(2), 5, noise_arcsec=0.0)
    truth = drawn.true_output_v(drawn.schedule.pitch_deg, drawn.schedule.roll_deg)
    np.testing.assert_allclose(drawn.output_v, truth, atol=1e-14)


def test_a_clean_table_stands_where_it_says():
    drawn = campaigns("clean", 0.0, np.random.default_rng(2), 2)
    inside = np.abs(drawn.schedule.pitch_deg) < 89.0
    np.testing.assert_allclose(drawn.true_pitch_deg[0], drawn.schedule.pitch_deg, atol=1e-9)
    away = np.mod(drawn.true_roll_deg[0] - drawn.schedule.roll_deg + 180.0, 360.0) - 180.0
    np.testing.assert_allclose(away[inside], 0.0, atol=1e-9)


def test_without_roll_the_output_is_tps_single_axis():
    """b + S' sin(α + φ): the y component of k is never seen."""
    drawn = campaigns("clean", 0.0, np.random.default_rng(2), 1, axes="x", roll_count=1, noise_arcsec=0.0)
    k = drawn.package.vector_v_per_g[0, 0, 0]
    alpha = np.deg2rad(drawn.schedule.pitch_deg)
    expected = np.hypot(k[0], k[2]) * np.sin(alpha + np.arctan2(-k[2], k[0]))
    np.testing.assert_allclose(drawn.output_v[0, :, 0, 0], drawn.package.offset_v[0, 0, 0] + expected, atol=1e-14)


def test_mounted_sensors_read_the_plate_through_their_mount():
    drawn = campaigns("fixture-mounts", 0.0, np.random.default_rng(2), 1, noise_arcsec=0.0)
    level = drawn.true_output_v(np.array([30.0]), np.array([0.0]))[0, 0] - drawn.package.offset_v[0]
    signs = np.sign(np.where(np.abs(level) > 0.5, level, 0.0))
    np.testing.assert_array_equal(signs, [[1, 0, -1], [-1, 0, -1], [0, -1, -1]])


def test_the_best_linear_sensor_of_a_linear_sensor_is_itself():
    drawn = campaigns("clean", 0.0, np.random.default_rng(2), 3)
    offset, vector = drawn.package.best_linear(*drawn.points_deg.T)
    np.testing.assert_allclose(offset, drawn.package.offset_v, atol=1e-14)
    np.testing.assert_allclose(vector, drawn.package.vector_v_per_g, atol=1e-14)


def test_packages_are_used_later_as_they_truly_are():
    chance = np.random.default_rng(2)
    drawn = campaigns("k2", 20.0, chance, 3, noise_arcsec=0.0, use_rows=7, use_pitch_limit_deg=30.0)
    later = used_later(drawn, chance)
    assert later.output_v.shape == (3, 7, 1, 3)
    assert np.abs(later.true_pitch_deg).max() <= 30.0
    truth = drawn.true_output_v(later.true_pitch_deg[0], later.true_roll_deg[0])
    np.testing.assert_allclose(later.output_v, truth, atol=1e-13)


def test_a_good_package_in_use_gives_its_attitude_back():
    """K⁻¹(e − b) with the true b and K: each component errs by a dwell's noise, and its length is one (MATH 10)."""
    chance = np.random.default_rng(2)
    use = campaigns("use-good", 0.0, chance, 100).use
    k = use.package.vector_v_per_g[:, 0]
    force = np.linalg.solve(k[:, None], (use.output_v[:, :, 0] - use.package.offset_v)[..., None])[..., 0]
    pitch = np.rad2deg(np.arctan2(force[..., 0], np.hypot(force[..., 1], force[..., 2])))
    assert ((pitch - use.true_pitch_deg) * 3600.0).std() == pytest.approx(1.65, rel=0.05)
    away = np.mod(np.rad2deg(np.arctan2(-force[..., 1], -force[..., 2])) - use.true_roll_deg + 180.0, 360.0) - 180.0
    across = np.cos(np.deg2rad(use.true_pitch_deg))
    assert (away * across * 3600.0).std() == pytest.approx(1.65, rel=0.05)
    redundancy = (force**2).sum(axis=-1) - 1.0
    assert redundancy.std() == pytest.approx(2.0 * 1.65 * ARCSEC, rel=0.05)


def test_scenes_that_happen_at_once_add_up():
    """To first order; the sizes are small."""
    sizes = {"table-wrong-zero": 20.0, "slip-roll": 10.0, "k2": 5.0, "cross-product": 5.0}

    def drawn(chosen: dict[str, float]) -> np.ndarray:
        given = {name: chosen.get(name, 0.0) for name in sizes}
        return mixed(given, np.random.default_rng(2), 3).output_v

    clean = drawn({})
    together = drawn(sizes) - clean
    alone = sum(drawn({name: size}) - clean for name, size in sizes.items())
    assert np.abs(together).max() > 1e-4
    np.testing.assert_allclose(together, alone, atol=1e-7)


def test_what_does_not_mix_is_refused():
    chance = np.random.default_rng(2)
    with pytest.raises(ValueError, match="one calibration campaign"):
        mixed({"k2": 1.0, "use-good": 0.0}, chance, 1)
    with pytest.raises(ValueError, match="one temperature"):
        mixed({"temperature-lag": 0.3, "temperature-room": 0.2}, chance, 1)


def test_most_scenes_of_a_table_are_drawn_by_the_hundred():
    drawn = campaigns("table-harmonics", 1.0, np.random.default_rng(2), 200)
    assert drawn.output_v.shape == (200, 936, 1, 3)
    assert SCENES["table-harmonics"].is_declared(1.0)
    assert not SCENES["table-harmonics"].is_declared(2.0)
