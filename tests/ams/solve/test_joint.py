"""Package and table in one fit: explicit rotations, coverage, and what a reversed mount is good for."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_columns import teeth_within

from ams.errors import DesignError
from ams.models.accelerometer import PitchRoll
from ams.observations import Observations
from ams.solve.joint import joint_fit
from ams.solve.table_errors import REVERSED, UPRIGHT, Mounting, TablePriors, table_effects
from ams.statistics.intervals import confidence_halfwidth

ARCSEC = np.pi / 180 / 3600
PACKAGE = {
    "x": (0.005, np.array([2.5, 0.018, 0.012])),
    "y": (-0.02, np.array([0.009, -2.48, 0.015])),
    "z": (0.011, np.array([-0.011, 0.02, 2.51])),
}
PITCH_DEG, ROLL_DEG = np.arange(-90.0, 91.0, 15.0), np.arange(-180.0, 181.0, 30.0)


def turn_x(a):
    return np.array([[1, 0, 0], [0, np.cos(a), np.sin(a)], [0, -np.sin(a), np.cos(a)]])


def turn_y(a):
    return np.array([[np.cos(a), 0, -np.sin(a)], [0, 1, 0], [np.sin(a), 0, np.cos(a)]])


def turn_z(a):
    return np.array([[np.cos(a), np.sin(a), 0], [-np.sin(a), np.cos(a), 0], [0, 0, 1]])


def table_force(pitch, roll, errors):
    """TP (113) with the table's errors put into the rotations themselves."""
    e = {"pitch zero": 0.0, "roll zero": 0.0, "base tilt": 0.0, "squareness": 0.0, "droop": 0.0, **errors}
    stands = pitch + e["pitch zero"] - e["droop"] * np.cos(pitch)
    up = np.array([0.0, 0.0, -1.0])
    return turn_x(roll + e["roll zero"]) @ turn_z(e["squareness"]) @ turn_y(stands) @ turn_x(e["base tilt"]) @ up


@pytest.mark.parametrize("name", ["pitch zero", "roll zero", "base tilt", "squareness", "droop"])
def test_what_a_table_error_does_is_the_derivative_of_the_rotations(name):
    pitch, roll = np.random.default_rng(1).uniform(-3, 3, (2, 30))
    h = 1e-30
    numeric = np.array([table_force(p, r, {name: 1j * h}).imag / h for p, r in zip(pitch, roll, strict=True)])
    np.testing.assert_allclose(table_effects(pitch, roll, [name])[:, :, 0], numeric, atol=1e-14)


def observe(rng, *, errors=None, teeth=None, mount=UPRIGHT, seat=(0.0, 0.0, 0.0), noise_arcsec=0.5, replications=3):
    """Outputs of the package on a table whose errors are given in radians."""
    pitch, roll = (g.ravel() for g in np.meshgrid(np.deg2rad(PITCH_DEG), np.deg2rad(ROLL_DEG), indexing="ij"))
    pitch_teeth, roll_teeth = teeth or (np.zeros(PITCH_DEG.size), np.zeros(ROLL_DEG.size))
    true_pitch = pitch + np.repeat(pitch_teeth, ROLL_DEG.size)
    true_roll = roll + np.tile(roll_teeth, PITCH_DEG.size)
    force = np.array([table_force(p, r, errors or {}) for p, r in zip(true_pitch, true_roll, strict=True)])
    seated = turn_x(seat[0]) @ turn_y(seat[1]) @ turn_z(seat[2]) @ np.array(mount)
    force = force @ seated.T
    points, n = pitch.size, replications
    outputs = {
        axis: np.tile(b + force @ k, n) + rng.normal(0, noise_arcsec * ARCSEC * np.linalg.norm(k), n * points)
        for axis, (b, k) in PACKAGE.items()
    }
    return Mounting(
        Observations(
            np.repeat(np.arange(n), points), np.tile(np.arange(points), n), np.tile(pitch, n), np.tile(roll, n), outputs
        ),
        mount,
    )


def draw_teeth(rng, limit_arcsec=1.0):
    pitch, roll = (rng.uniform(-limit_arcsec, limit_arcsec, n) * ARCSEC for n in (PITCH_DEG.size, ROLL_DEG.size))
    roll[-1] = roll[0]  # ±180° are one tooth
    return pitch, roll


TEETH = {"table": teeth_within(1.0)}


def truth(axis, fit):
    """Offset, sensitivities and no terms of second and third order."""
    b, k = PACKAGE[axis]
    return np.concatenate([[b], k, np.zeros(fit.primary[axis].size - 4)])


def test_without_noise_and_table_errors_the_package_comes_back():
    fit = joint_fit([observe(np.random.default_rng(0), noise_arcsec=0.0)], "xyz", TablePriors(**TEETH))
    for axis in PACKAGE:
        np.testing.assert_allclose(fit.primary[axis], truth(axis, fit), atol=1e-11)


def test_without_priors_it_is_ordinary_least_squares():
    mounting = observe(np.random.default_rng(1))
    fit = joint_fit([mounting], "x", TablePriors(), has_terms=False)
    o = mounting.observations
    force = np.stack(
        [np.sin(o.pitch_rad), -np.cos(o.pitch_rad) * np.sin(o.roll_rad), -np.cos(o.pitch_rad) * np.cos(o.roll_rad)], 1
    )
    basis = np.column_stack([np.ones(o.rows), force])
    np.testing.assert_allclose(fit.primary["x"], np.linalg.lstsq(basis, o.outputs["x"], rcond=None)[0], atol=1e-12)


def test_one_axis_with_teeth_is_generalised_least_squares():
    rng = np.random.default_rng(21)
    mounting = observe(rng, teeth=draw_teeth(rng, 5.0), replications=1)
    priors = TablePriors(teeth_within(5.0))
    tooth_rad = 5 * ARCSEC / 3**0.5
    fit = joint_fit([mounting], "y", priors, has_terms=False)
    o, k = mounting.observations, fit.primary["y"][1:]
    X = PitchRoll("y").basis(o)
    slopes = PitchRoll("y").angle_jacobian(fit.primary["y"], o)
    same_pitch = np.abs(np.sin((o.pitch_rad[:, None] - o.pitch_rad) / 2)) < 1e-9
    same_roll = np.abs(np.sin((o.roll_rad[:, None] - o.roll_rad) / 2)) < 1e-9
    U = np.diag(np.full(o.rows, fit.standard_error_v["y"] ** 2))
    U += tooth_rad**2 * same_pitch * np.outer(slopes["pitch"], slopes["pitch"])
    U += tooth_rad**2 * same_roll * np.outer(slopes["roll"], slopes["roll"])
    covariance = np.linalg.inv(X.T @ np.linalg.solve(U, X))
    expected = covariance @ X.T @ np.linalg.solve(U, o.outputs["y"])
    sd = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose((fit.primary["y"] - expected) / sd, 0.0, atol=2e-3)
    np.testing.assert_allclose(np.sqrt(np.diag(fit.axis_covariance("y"))), sd, rtol=2e-3)
    assert np.linalg.norm(k) == pytest.approx(2.48, abs=0.01)


def test_the_scatter_about_the_fit_is_the_noise():
    rng = np.random.default_rng(22)
    fit = joint_fit([observe(rng, teeth=draw_teeth(rng), replications=1)], "xyz", TablePriors(**TEETH))
    for axis, (_, k) in PACKAGE.items():
        assert fit.standard_error_v[axis] == pytest.approx(0.5 * ARCSEC * np.linalg.norm(k), rel=0.15)


def test_a_roll_zero_of_ten_arc_seconds_is_found_by_the_reversed_mount_and_only_by_it():
    rng = np.random.default_rng(2)
    errors, teeth = {"roll zero": 10 * ARCSEC}, draw_teeth(rng)
    priors = TablePriors(**TEETH, roll_zero_rad=30 * ARCSEC, seat_rad=1 * ARCSEC)
    once = observe(rng, errors=errors, teeth=teeth)
    alone = joint_fit([once], "xyz", priors)
    assert not alone.nuisance("roll zero").is_observed
    assert any(
        "roll zero: not observable" in sentence and "reversed mount" in sentence for sentence in alone.confounded
    )
    # the package's uncertainty holds what cannot be known: k_y of z turns with the roll zero
    assert np.sqrt(alone.axis_covariance("z")[2, 2]) > 0.9 * 2.51 * 30 * ARCSEC
    both = joint_fit([once, observe(rng, errors=errors, teeth=teeth, mount=REVERSED)], "xyz", priors)
    found = both.nuisance("roll zero")
    assert found.is_observed
    assert found.standard_deviation_rad < 1.5 * ARCSEC
    assert abs(found.estimate_rad - 10 * ARCSEC) < 3 * found.standard_deviation_rad
    assert both.confounded == () or not any("roll zero" in s for s in both.confounded)
    assert np.sqrt(both.axis_covariance("z")[2, 2]) < 0.1 * np.sqrt(alone.axis_covariance("z")[2, 2])


@pytest.mark.parametrize("name", ["pitch zero", "base tilt", "squareness"])
def test_errors_that_rolling_reverses_are_found_in_one_mount(name):
    rng = np.random.default_rng(3)
    field = {"pitch zero": "pitch_zero_rad", "base tilt": "base_tilt_rad", "squareness": "squareness_rad"}[name]
    mounting = observe(rng, errors={name: 10 * ARCSEC}, teeth=draw_teeth(rng))
    found = joint_fit([mounting], "xyz", TablePriors(**TEETH, **{field: 30 * ARCSEC})).nuisance(name)
    assert found.is_observed
    assert abs(found.estimate_rad - 10 * ARCSEC) < 3.5 * found.standard_deviation_rad


# The errors of one campaign hang together, so 25 campaigns say less than their 300 parameters suggest.
@pytest.mark.parametrize(
    ("campaigns", "rms", "cover"), [(25, 0.3, 0.06), pytest.param(400, 0.08, 0.02, marks=pytest.mark.soak)]
)
def test_intervals_cover_with_everything_wrong_at_once(campaigns, rms, cover):
    rng, errors_in_sd, held = np.random.default_rng(4), [], []
    widths = {"pitch zero": 5, "roll zero": 5, "base tilt": 5, "squareness": 3, "droop": 2}
    priors = TablePriors(
        **TEETH,
        pitch_zero_rad=5 * ARCSEC,
        roll_zero_rad=5 * ARCSEC,
        base_tilt_rad=5 * ARCSEC,
        squareness_rad=3 * ARCSEC,
        droop_rad=2 * ARCSEC,
        seat_rad=2 * ARCSEC,
    )
    for _ in range(campaigns):
        errors = {name: rng.normal(0, width * ARCSEC) for name, width in widths.items()}
        teeth, seat = draw_teeth(rng), rng.normal(0, 2 * ARCSEC, 3)
        mountings = [
            observe(rng, errors=errors, teeth=teeth),
            observe(rng, errors=errors, teeth=teeth, mount=REVERSED, seat=seat),
        ]
        fit = joint_fit(mountings, "xyz", priors)
        for axis in PACKAGE:
            off = fit.primary[axis] - truth(axis, fit)
            errors_in_sd.append(off[:4] / np.sqrt(np.diag(fit.axis_covariance(axis)))[:4])
            held.append(np.abs(off) <= confidence_halfwidth(np.eye(off.size), fit.axis_components(axis)))
    z = np.array(errors_in_sd)
    assert np.sqrt(np.mean(z**2)) == pytest.approx(1.0, abs=rms)
    assert np.mean(np.abs(z) < 1.96) == pytest.approx(0.95, abs=cover)
    assert np.mean(held) == pytest.approx(0.95, abs=cover), "the terms rest on few replications: Student"


def test_the_joint_fit_is_sharper_than_axis_by_axis():
    rng = np.random.default_rng(5)
    mounting = observe(rng, teeth=draw_teeth(rng), noise_arcsec=0.2)
    priors = TablePriors(**TEETH)
    joint, alone = joint_fit([mounting], "xyz", priors), joint_fit([mounting], "x", priors)
    assert np.trace(joint.axis_covariance("x")) < np.trace(alone.axis_covariance("x"))


def test_drift_between_replications_widens_the_covariance():
    rng = np.random.default_rng(8)
    steady = observe(rng, replications=5)
    o = steady.observations
    jumps = rng.normal(0, 2e-4, 5)[o.replication]
    drifting = Observations(
        o.replication, o.point, o.pitch_rad, o.roll_rad, {a: v + jumps for a, v in o.outputs.items()}
    )
    calm, moved = (joint_fit([Mounting(x)], "xyz", TablePriors(**TEETH)) for x in (o, drifting))
    assert np.sqrt(moved.axis_covariance("x")[0, 0]) > 0.5 * np.std(jumps) / np.sqrt(5)
    assert np.sqrt(calm.axis_covariance("x")[0, 0]) < 0.1 * np.sqrt(moved.axis_covariance("x")[0, 0])
    assert moved.standard_error_v["x"] < 1.2 * calm.standard_error_v["x"]


def test_drift_in_two_mountings_averages_out_as_between_twice_the_replications() -> None:
    """Offsets that jump by σ at every replication: their mean over two mountings of five has σ/√10."""
    rng, jump_v = np.random.default_rng(9), 2e-4
    jumps = jump_v * np.tile([-1.2, -0.6, 0.0, 0.6, 1.2], (2, 1)) / np.std([-1.2, -0.6, 0.0, 0.6, 1.2], ddof=1)
    mountings = []
    for mount, own in zip((UPRIGHT, REVERSED), jumps, strict=True):
        steady = observe(rng, replications=5, mount=mount).observations
        moved = {axis: output + own[steady.replication] for axis, output in steady.outputs.items()}
        mountings.append(Mounting(replace(steady, outputs=moved), mount))
    fit = joint_fit(mountings, "xyz", TablePriors(**TEETH))
    assert np.sqrt(fit.axis_covariance("y")[0, 0]) == pytest.approx(jump_v / np.sqrt(10.0), rel=0.05)


def test_errors_that_act_alike_are_named_together():
    rng = np.random.default_rng(6)
    priors = TablePriors(**TEETH, roll_zero_rad=10 * ARCSEC, seat_rad=10 * ARCSEC)
    fit = joint_fit([observe(rng), observe(rng, mount=REVERSED)], "xyz", priors)
    assert any("roll zero" in s and "seat 2 about x" in s and "apart" in s for s in fit.confounded)


def pitch_only(mounting):
    """The rows at roll 0: what a table without a roll axis gives."""
    o = mounting.observations
    kept = np.abs(o.roll_rad) < 1e-9
    rows = Observations(
        o.replication[kept],
        o.point[kept],
        o.pitch_rad[kept],
        o.roll_rad[kept],
        {a: v[kept] for a, v in o.outputs.items()},
    )
    return Mounting(rows, mounting.package_from_table)


def test_without_roll_a_level_error_of_ten_arc_seconds_needs_the_reversed_mount():
    rng = np.random.default_rng(11)
    errors, teeth = {"pitch zero": 10 * ARCSEC}, draw_teeth(rng)
    priors = TablePriors(**TEETH, pitch_zero_rad=30 * ARCSEC, seat_rad=0.5 * ARCSEC)
    once = pitch_only(observe(rng, errors=errors, teeth=teeth))
    alone = joint_fit([once], "x", priors)
    assert not alone.nuisance("pitch zero").is_observed
    assert any("pitch zero: not observable" in sentence for sentence in alone.confounded)
    assert np.isnan(alone.primary["x"][2])  # k_y: nothing excites it without roll
    assert np.sqrt(alone.axis_covariance("x")[3, 3]) > 0.9 * 2.5 * 30 * ARCSEC
    both = joint_fit([once, pitch_only(observe(rng, errors=errors, teeth=teeth, mount=REVERSED))], "x", priors)
    found = both.nuisance("pitch zero")
    assert found.is_observed
    assert abs(found.estimate_rad - 10 * ARCSEC) < 3 * found.standard_deviation_rad
    assert found.standard_deviation_rad < 1.0 * ARCSEC


def test_one_pitch_angle_only_is_refused_in_words():
    o = observe(np.random.default_rng(7)).observations
    flat = Observations(o.replication, o.point, np.full_like(o.pitch_rad, 0.3), o.roll_rad, o.outputs)
    with pytest.raises(DesignError, match="add pitch and roll angles"):
        joint_fit([Mounting(flat)], "xyz", TablePriors())


@pytest.mark.parametrize("replications", [pytest.param(2, marks=pytest.mark.thorough), 4])
def test_intervals_hold_where_every_parameter_drifts_between_replications(replications):
    """Offsets and sensitivities move by 5″ between replications: Student with the replications' own degrees of freedom.

    120 campaigns of one axis and four parameters: a share of 0.95 scatters by about 1.5 %.
    """
    rng, held = np.random.default_rng(31), []
    for _ in range(120):
        mounting = observe(rng, teeth=draw_teeth(rng), replications=replications)
        o = mounting.observations
        moved = 2.5 * 5 * ARCSEC * rng.normal(size=(replications, 4))
        drifted = o.outputs["x"] + np.sum(PitchRoll("x").basis(o) * moved[o.replication], axis=1)
        fit = joint_fit([Mounting(replace(o, outputs={"x": drifted}))], "x", TablePriors(**TEETH))
        half = confidence_halfwidth(np.eye(fit.primary["x"].size), fit.axis_components("x"))
        held.append(np.abs(fit.primary["x"] - truth("x", fit)) <= half)
    assert np.mean(held) >= 0.92
    assert fit.replication_dof == replications - 1


@pytest.mark.parametrize("replications", [1, 4])
def test_the_standard_error_is_that_of_one_dwell_however_many_replications_there_are(replications: int) -> None:
    rng = np.random.default_rng(23)
    fit = joint_fit([observe(rng, teeth=draw_teeth(rng), replications=replications)], "xyz", TablePriors(**TEETH))
    for axis, (_, k) in PACKAGE.items():
        assert fit.standard_error_v[axis] == pytest.approx(0.5 * ARCSEC * np.linalg.norm(k), rel=0.15)
