"""Each scene does what its sentence says, in the unit that it says."""

import numpy as np
import pytest
from physics_scenes import SCENES, campaigns
from physics_scenes.gyro_scenes import harmonic_motion, package_rate_dps
from physics_scenes.rotations import ARCSEC, gimbal_matrix, specific_force
from physics_scenes.sensor_scenes import traceless_basis
from physics_scenes.table_scenes import CURVES
from physics_scenes.tables import eight_harmonics, once_per_turn, sawtooth, white_teeth, zeroed
from physics_scenes.temperature_scenes import followed_degc

DENSE = np.deg2rad(np.arange(-180.0, 180.5, 0.5))
CURVE_KINDS = [once_per_turn, eight_harmonics, white_teeth, sawtooth]


def quiet(name: str, size: float, count: int = 3, seed: int = 4, **design):
    return campaigns(name, size, np.random.default_rng(seed), count, noise_arcsec=0.0, **design)


def change_g(name: str, size: float, **design) -> np.ndarray:
    """(n, D, S, A) what the scene adds to the outputs, against the sensitivity."""
    clean, happened = quiet(name, 0.0, **design), quiet(name, size, **design)
    return (happened.output_v - clean.output_v) / clean.package.sensitivity_v_per_g[:, None]


@pytest.mark.parametrize("curve_of", CURVE_KINDS)
def test_a_curve_stays_inside_its_limit_and_closes_after_a_turn(curve_of):
    curve = curve_of(1.0, 50, np.random.default_rng(1))
    errors = curve(DENSE)
    assert np.abs(errors).max() <= 1.0 + 1e-4
    np.testing.assert_allclose(errors[:, 0], errors[:, -1], atol=1e-9)
    np.testing.assert_array_equal(zeroed(curve)(np.zeros(1)), np.zeros((50, 1)))


@pytest.mark.parametrize("curve_of", [once_per_turn, eight_harmonics])
def test_a_smooth_curve_reaches_its_limit(curve_of):
    curve = curve_of(1.0, 50, np.random.default_rng(1))
    np.testing.assert_allclose(np.abs(curve(DENSE)).max(axis=1), 1.0, atol=1e-2)


@pytest.mark.parametrize("name", CURVES)
def test_a_tables_error_is_inside_the_limit_and_the_same_in_every_replication(name):
    drawn = quiet(name, 1.0)
    pitch_error = drawn.grid((drawn.true_pitch_deg - drawn.schedule.pitch_deg) * 3600.0)
    inside = np.abs(drawn.points_deg[:, 0]) < 89.0
    assert 0.05 < np.abs(pitch_error[..., inside]).max() <= 1.0 + 1e-3
    np.testing.assert_array_equal(pitch_error[:, 0], pitch_error[:, 5])


def test_white_teeth_are_no_curve():
    errors = white_teeth(1.0, 200, np.random.default_rng(1))(np.deg2rad(np.arange(0.0, 360.0, 30.0)))
    correlation = np.corrcoef(errors.T) - np.eye(12)
    assert np.abs(correlation).max() < 0.3
    assert errors.std() == pytest.approx(1.0 / np.sqrt(3.0), rel=0.05)


def test_a_roll_slip_is_seen_by_all_sensors_from_its_dwell_on():
    drawn = quiet("slip-roll", 72.0)
    moved = drawn.true_roll_deg - drawn.schedule.roll_deg
    moved = np.mod(moved + 180.0, 360.0) - 180.0
    after = np.arange(drawn.schedule.dwells) >= drawn.event.dwell[:, None]
    inside = np.abs(drawn.schedule.pitch_deg) < 89.0
    np.testing.assert_allclose(np.abs(moved)[:, inside], 0.02 * after[:, inside], atol=1e-9)
    assert (np.abs(change_g("slip-roll", 72.0))[0].max(axis=0)[:, 1:] > 0.9 * 72.0 * ARCSEC).all()


def test_a_sideways_tilt_of_the_base_turns_with_roll():
    """MATH 10: (0, cosR, −sinR) times the tilt, whatever the pitch."""
    drawn, clean = quiet("slip-base-sideways", 10.0), quiet("slip-base-sideways", 0.0)
    after = drawn.schedule.rows("check-after")
    change = (drawn.true_force_g - clean.true_force_g)[:, after] / (10.0 * ARCSEC)
    roll = np.deg2rad(drawn.schedule.roll_deg[after])
    pattern = np.stack([np.zeros_like(roll), np.cos(roll), -np.sin(roll)], axis=1)
    signs = np.sign((change * pattern).sum(axis=(1, 2)))
    np.testing.assert_allclose(signs[:, None, None] * change, np.broadcast_to(pattern, change.shape), atol=1e-4)


@pytest.mark.parametrize(("name", "size"), [("sensor-rotation", 10.0), ("sensor-gain", 50.0), ("sensor-offset", 5.0)])
def test_one_sensors_change_is_seen_by_it_alone(name, size):
    change = np.abs(change_g(name, size)).max(axis=(1, 3))
    sensor = quiet(name, size).event.sensor
    struck = np.arange(3) == sensor[:, None]
    assert (change[struck] > 0.5 * size * (ARCSEC if name != "sensor-gain" else 1e-6)).all()
    assert (change[~struck] == 0.0).all()


@pytest.mark.parametrize(("name", "unit"), [("meter-gain", 1e-6), ("supply", 1e-6), ("meter-offset", 1e-6)])
def test_the_meter_changes_all_channels_alike(name, unit):
    clean, changed = quiet(name, 0.0), quiet(name, 100.0)
    after = clean.schedule.rows("check-after")
    change = (changed.output_v - clean.output_v)[:, after]
    whole = clean.output_v[:, after] if name != "meter-offset" else np.ones_like(change)
    ratio = change / whole / (100.0 * unit)
    np.testing.assert_allclose(np.abs(ratio), 1.0, atol=1e-6)


def test_remounting_happens_between_two_replications():
    drawn = quiet("remount", 10.0)
    replication = drawn.schedule.replication[drawn.event.dwell]
    before = drawn.schedule.replication[drawn.event.dwell - 1]
    assert (replication >= 1).all()
    assert (drawn.schedule.is_point[drawn.event.dwell - 1] | (before >= 0)).all()


def test_k2_and_k3_are_what_tumbling_shows():
    """Up and down: half the sum is b + K₂S, half the difference over S is 1 + K₃; half way the cubic is an eighth."""
    for name, size in (("k2", 10.0), ("k3", 10.0)):
        package = quiet(name, size).package
        along = np.array([1.0, -1.0, 0.5])[:, None] * package.axis_direction[0, 0, 0]
        up, down, half = (
            package.response_v(along[None, :, None])[0, :, 0, 0] - package.offset_v[0, 0, 0]
        ) / package.sensitivity_v_per_g[0, 0, 0]
        assert abs(up + down) / 2 == pytest.approx(10e-6 if name == "k2" else 0.0, abs=1e-12)
        assert abs(up - down) / 2 - 1 == pytest.approx(0.0, abs=1.01e-5)
        assert abs(half - 0.5) == pytest.approx(2.5e-6 if name == "k2" else 1.25e-6, abs=1e-12)


def test_asymmetries_differ_between_the_halves():
    for name in ("k0-asymmetry", "k1-asymmetry"):
        added = change_g(name, 10.0, axes="x")
        assert np.abs(added).max() == pytest.approx(5e-6, rel=1e-3)


@pytest.mark.parametrize("name", ["soft-mount", "soft-mount-worst", "cross-coupling", "cross-product"])
def test_second_order_terms_without_trace_have_their_size(name):
    q = quiet(name, 10.0).package.q_per_g
    np.testing.assert_allclose(np.trace(q, axis1=-2, axis2=-1), 0.0, atol=1e-18)
    np.testing.assert_allclose(q, np.swapaxes(q, -1, -2), atol=1e-20)
    norm = np.linalg.norm(q, axis=(-2, -1))
    np.testing.assert_allclose(norm, 10e-6 if "soft" in name else 10e-6 / np.sqrt(2.0))


def test_the_traceless_basis_is_orthonormal():
    flat = traceless_basis().reshape(5, 9)
    np.testing.assert_allclose(flat @ flat.T, np.eye(5), atol=1e-15)


@pytest.mark.parametrize("limit", [30.0, 90.0])
def test_the_worst_soft_mount_moves_the_offset_most_for_its_residuals(limit):
    def moved(name: str, count: int) -> np.ndarray:
        drawn = quiet(name, 10.0, count, pitch_limit_deg=limit)
        offset, vector = drawn.package.best_linear(*drawn.points_deg.T)
        force = specific_force(*np.deg2rad(drawn.points_deg).T)
        fitted = offset[:, None] + np.einsum("kc,nsac->nksa", force, vector)
        left = drawn.true_output_v(*drawn.points_deg.T) - fitted
        return np.abs(offset - drawn.package.offset_v) / np.sqrt((left**2).mean(axis=1))

    worst = moved("soft-mount-worst", 2)
    assert worst.min() == pytest.approx(worst.max(), rel=1e-6)
    assert worst.min() >= 0.999 * moved("soft-mount", 200).max()


def test_the_traceless_offset_takes_a_third_of_the_trace():
    package = quiet("k2", 12.0).package
    moved = (package.traceless_offset_v - package.offset_v) / package.sensitivity_v_per_g
    np.testing.assert_allclose(np.abs(moved), 4e-6, rtol=1e-9)


def test_hysteresis_is_nothing_where_the_input_was_the_same():
    drawn = quiet("hysteresis", 10.0, axes="x", roll_count=1)
    same = drawn.schedule.pitch_deg == drawn.schedule.previous_pitch_deg
    added = change_g("hysteresis", 10.0, axes="x", roll_count=1)
    assert np.abs(added[:, same]).max(initial=0.0) == 0.0
    assert 3e-6 < np.abs(added).max() <= 10e-6


def test_a_wrong_dwell_is_wrong_once_by_its_size():
    noisy = [campaigns("wrong-dwell", size, np.random.default_rng(4), 5) for size in (0.0, 6.0)]
    change = (noisy[1].output_v - noisy[0].output_v) / (1.65 * ARCSEC * noisy[0].package.sensitivity_v_per_g[:, None])
    wrong = np.abs(change) > 1e-6
    assert (wrong.sum(axis=(1, 2, 3)) == 1).all()
    np.testing.assert_allclose(np.abs(change[wrong]), 6.0)
    event = noisy[1].event
    assert wrong[np.arange(5), event.dwell, event.sensor, event.axis].all()


def test_outliers_are_one_sided_and_rare():
    change = [campaigns("outliers", size, np.random.default_rng(4), 20).output_v for size in (0.0, 20.0)]
    added = change[1] - change[0]
    assert added.min() == 0.0
    assert (added > 0.0).mean() == pytest.approx(0.005, rel=0.1)


def test_a_swapped_channel_gives_the_neighbours_reading_at_one_dwell():
    clean, swapped = quiet("swapped-channel", 0.0), quiet("swapped-channel", 1.0)
    for n, dwell in enumerate(swapped.event.dwell):
        np.testing.assert_array_equal(swapped.output_v[n, dwell, 0], clean.output_v[n, dwell, 0, [0, 2, 1]])
    struck = (clean.output_v != swapped.output_v).any(axis=(2, 3))
    assert (struck.sum(axis=1) <= 1).all()


def test_a_wrong_tooth_turns_the_plate_by_a_degree_once():
    clean, wrong = quiet("wrong-tooth", 0.0), quiet("wrong-tooth", 1.0)
    turned = np.rad2deg(np.linalg.norm(wrong.true_force_g - clean.true_force_g, axis=-1))
    assert ((turned > 0.0).sum(axis=1) <= 1).all()
    assert turned.max() == pytest.approx(1.0, rel=1e-3)


def test_a_lagging_body_has_covered_all_but_a_share_of_e_after_its_time_constant():
    schedule = quiet("temperature-lag", 0.3).schedule
    first = np.flatnonzero(np.diff(schedule.chamber_degc))[0] + 1
    waited = schedule.time_s[first] - schedule.time_s[first - 1]
    followed = followed_degc(schedule, waited)
    step = schedule.chamber_degc[first] - schedule.chamber_degc[first - 1]
    assert followed[first] == pytest.approx(schedule.chamber_degc[first] - step * np.exp(-1.0))
    np.testing.assert_array_equal(followed_degc(schedule, 0.0), schedule.chamber_degc)


def test_temperature_in_step_is_the_same_in_every_replication():
    drawn = quiet("temperature-in-step", 0.2)
    recorded = drawn.grid(drawn.temperature_degc)
    np.testing.assert_allclose(recorded[:, 0], recorded[:, 3], atol=1e-3)
    assert np.ptp(recorded[0]) == pytest.approx(0.4, rel=0.01)
    assert (drawn.package.offset_tc_v_per_degc != 0.0).all()


def test_drifts_have_the_truth_as_their_mean_over_the_run():
    for name in ("drift-linear", "drift-step", "drift-walk"):
        added = change_g(name, 5.0) / ARCSEC
        np.testing.assert_allclose(added.mean(axis=1), 0.0, atol=0.05)
    np.testing.assert_allclose(np.ptp(change_g("drift-linear", 5.0), axis=1) / ARCSEC, 5.0)


def test_a_dead_axis_reads_its_offset_and_the_others_the_truth():
    drawn = quiet("use-dead-axis", 1.0)
    dead = np.arange(3) == drawn.use.event.axis[:, None]
    read = drawn.use.output_v[:, :, 0]
    offset = drawn.use.package.offset_v
    np.testing.assert_allclose(read.transpose(0, 2, 1)[dead].T, np.broadcast_to(offset[:, 0][dead], (50, 3)))
    truth = drawn.use.true_output_v(drawn.use.schedule.pitch_deg, drawn.use.schedule.roll_deg)[:, :, 0]
    np.testing.assert_allclose(read.transpose(0, 2, 1)[~dead], truth.transpose(0, 2, 1)[~dead])


def test_gravity_at_the_site_scales_what_the_sensors_feel_and_not_their_offsets():
    clean, heavier = (quiet("use-site-gravity", size).use for size in (0.0, 0.03))
    offset = clean.package.offset_v[:, None]
    np.testing.assert_allclose((heavier.output_v - offset) / (clean.output_v - offset), 1.0 + 0.03 / 9.80665)


def test_two_packages_with_a_dead_axis_know_which():
    drawn = campaigns("two-packages-dead-axis", 1.0, np.random.default_rng(4), 20)
    assert drawn.use_v.shape == (20, 50, 2, 3)
    rows = np.arange(20)
    offset = drawn.offset_v[rows, drawn.faulty_package, drawn.faulty_axis]
    read = drawn.use_v[rows, :, drawn.faulty_package, drawn.faulty_axis]
    np.testing.assert_allclose(read, np.broadcast_to(offset[:, None], (20, 50)), atol=1e-3)


def test_six_positions_and_two_levels_determine_the_whole_matrix():
    """Rank 12 (MATH 10), and least squares with both fields known finds M and o; one axis' pair alone does not."""
    drawn = campaigns("field-coned", 1.0, np.random.default_rng(4), 3)
    field = drawn.nominal_earth_ut + drawn.nominal_coil_ut
    in_package = np.einsum("pij,lj->pli", drawn.to_package, field).reshape(-1, 3)
    basis = np.concatenate([np.ones((12, 1)), in_package], axis=1)
    assert 3 * np.linalg.matrix_rank(basis) == 12
    assert 3 * np.linalg.matrix_rank(basis[:4]) == 9
    solved = np.einsum("jk,nka->naj", np.linalg.pinv(basis), drawn.counts.mean(axis=1).reshape(3, 12, 3))
    np.testing.assert_allclose(solved[..., 0], drawn.offset_counts, atol=2.0)
    np.testing.assert_allclose(solved[..., 1:], drawn.matrix_counts_per_ut, atol=0.03)


def test_rates_in_package_axes_are_the_derivative_of_the_rotation():
    time = np.linspace(0.0, 10.0, 21)
    euler, rate = harmonic_motion(time, 10.0)
    step = 1e-6
    late, early = (gimbal_matrix(*np.deg2rad(harmonic_motion(time + s, 10.0)[0]).T) for s in (step, -step))
    cross = -(late - early) / (2 * step) @ np.swapaxes(gimbal_matrix(*np.deg2rad(euler).T), 1, 2)
    expected = np.stack([cross[:, 2, 1], cross[:, 0, 2], cross[:, 1, 0]], axis=1)
    np.testing.assert_allclose(np.deg2rad(package_rate_dps(euler, rate)), expected, atol=1e-8)


def test_earth_turns_upwards_in_the_north():
    """ω_down = −ω sinφ: with z down a gyro about z reads less than its table, by 0.0025 °/s at 37°."""
    drawn = campaigns("gyro-earth-rate", 1.0, np.random.default_rng(4), 1)
    z_down = drawn.mean_earth_dps[5, drawn.rates_dps == 100.0][0]
    np.testing.assert_allclose(z_down, [0.0, 0.0, -15.041 / 3600 * np.sin(np.deg2rad(37.09))], atol=1e-12)
    at_rest = drawn.mean_earth_dps[:, drawn.rates_dps == 0.0][:, 0]
    np.testing.assert_allclose(np.linalg.norm(at_rest, axis=1) * 3600.0, 15.041)


def test_a_dropout_is_one_gap_of_its_length():
    drawn = campaigns("gyro-dropout", 0.5, np.random.default_rng(4), 5)
    lost = np.isnan(drawn.output_v)
    assert (lost.sum(axis=1) == 50).all()
    assert (np.abs(np.diff(lost[..., 0].astype(int), axis=1)).sum(axis=1) == 2).all()


def test_every_scene_of_use_shows_what_it_changes():
    for name, entry in SCENES.items():
        if name.startswith("use-") and entry.flags_rows:
            good, bad = quiet(name, 0.0).use, quiet(name, entry.sizes[-1]).use
            changed = entry.sizes[-1] and (good.output_v != bad.output_v).any()
            assert changed or name == "use-noisy-axis"
