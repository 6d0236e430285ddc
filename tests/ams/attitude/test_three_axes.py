"""Three axes at the machine's speed: scipy's answers, spread by finite differences, alarms as often as they should."""

from dataclasses import dataclass

import numpy as np
import pytest
from case_shares import rest_to_thorough
from scipy.optimize import least_squares

from ams.attitude import flag_codes, three_axes
from ams.attitude.flag_codes import NOT_FINITE, PITCH_SINGULAR, REDUNDANCY, ROLL_SINGULAR
from ams.attitude.force_covariance import (
    LINE_BASIS,
    ParameterErrors,
    PolynomialErrors,
    SharedWeighing,
    errors_of_force,
    output_polynomials,
    quadratic_form,
)
from ams.attitude.static import redundancy_limit
from ams.attitude.three_axes import AttitudeColumns, Bend, fitted, judged_into
from ams.errors import DesignError
from ams.frames import specific_force
from ams.models.extended import matrix_from_elements, quadratic_basis

DEG = np.pi / 180
K = np.array([[2.5, 0.05, -0.02], [0.1, -2.4, 0.03], [0.01, -0.2, 0.6]])
OFFSET_V = np.array([0.01, -0.02, 0.03])
READING_V = np.array([2e-5, 1e-4, 3e-5])
Q_BASIS = ({(2, 0, 0): 1.0, (0, 0, 2): -1.0}, {(1, 1, 0): 2.0}, {(1, 0, 1): 2.0}, {(0, 2, 0): 1.0, (0, 0, 2): -1.0},
           {(0, 1, 1): 2.0})  # fmt: skip

MONOMIALS = [{p: 1.0} for p in ((2, 0, 0), (1, 1, 0), (1, 0, 1), (0, 2, 0), (0, 1, 1), (0, 0, 2))]


def random_covariance(rng, size, scale):
    root = rng.normal(0, scale, (size, size))
    return root @ root.T


def errors(seed=1, parts=2, scale=1e-5, dof=(5.0, 30.0)):
    rng = np.random.default_rng(seed)
    return ParameterErrors(
        np.stack([random_covariance(rng, 12, scale) for _ in range(parts)]), np.array(dof[:parts]), READING_V**2
    )


def package(**kwargs):
    return three_axes.three_axes(K, OFFSET_V, errors(), redundancy_limit, **kwargs)


def attitudes(rng, count):
    return rng.uniform(-85, 85, count) * DEG, rng.uniform(-180, 180, count) * DEG


def outputs(pitch, roll):
    return OFFSET_V[:, None] + K @ specific_force(np.atleast_1d(pitch), np.atleast_1d(roll)).T


@pytest.mark.parametrize("noise_v", [0.0, 1e-5, 1e-3, 0.05])
def test_angles_are_those_of_scipys_least_squares(noise_v: float) -> None:
    rng = np.random.default_rng(2)
    pitch, roll = attitudes(rng, 30)
    read = outputs(pitch, roll) + rng.normal(0, 1, (3, 30)) * noise_v
    used = package()
    found = used.attitude(read)
    sensed = used.inverse @ (read - OFFSET_V[:, None])
    start = sensed / np.linalg.norm(sensed, axis=0)
    powers, volts2 = output_polynomials(errors())
    squares = np.sum(K**2, axis=1)
    for n in range(30):
        at = np.array([np.prod(start[:, n] ** np.array(power)) for power in powers])
        calibration = np.mean(np.einsum("ciim,m->i", volts2, at) / squares)
        weights = 1 / np.sqrt(READING_V**2 + squares * calibration)

        def misfit(angles, n=n, weights=weights):
            return (K @ specific_force(angles[:1], angles[1:])[0] + OFFSET_V - read[:, n]) * weights

        by_scipy = least_squares(misfit, [pitch[n], roll[n]], xtol=1e-15, ftol=1e-15, gtol=1e-15).x
        assert found.pitch_rad[n] == pytest.approx(by_scipy[0], abs=1e-6)
        assert np.sin(found.roll_rad[n] - by_scipy[1]) == pytest.approx(0.0, abs=1e-5)


def test_without_noise_every_attitude_comes_back_to_rounding() -> None:
    pitch, roll = attitudes(np.random.default_rng(3), 40_000)
    found = package().attitude(outputs(pitch, roll))
    assert not found.codes.any()
    np.testing.assert_allclose(found.pitch_rad, pitch, atol=2e-14)
    np.testing.assert_allclose(found.roll_rad, roll, atol=2e-13)
    plain = package().angles(outputs(pitch, roll))
    np.testing.assert_array_equal(plain[0], found.pitch_rad)
    np.testing.assert_array_equal(plain[1], found.roll_rad)
    assert not plain[2].any()


def test_spread_is_the_covariance_carried_by_finite_differences() -> None:
    rng = np.random.default_rng(4)
    pitch, roll = attitudes(rng, 50)
    used, read, h = package(), outputs(pitch, roll), 1e-6
    found = used.attitude(read)
    slopes = np.empty((2, 3, 50))
    for axis in range(3):
        step = h * (np.arange(3) == axis)[:, None]
        up, down = used.attitude(read + step), used.attitude(read - step)
        slopes[:, axis] = [(up.pitch_rad - down.pitch_rad) / (2 * h), (up.roll_rad - down.roll_rad) / (2 * h)]
    force = specific_force(pitch, roll)
    for n in range(50):
        rows = np.kron(np.eye(3), np.append(1.0, force[n]))
        covariance = rows @ errors().covariances_v2.sum(axis=0) @ rows.T + np.diag(READING_V**2)
        expected = np.sqrt(np.einsum("ai,ij,aj->a", slopes[:, :, n], covariance, slopes[:, :, n]))
        assert found.pitch_sd_rad[n] == pytest.approx(expected[0], rel=1e-5)
        assert found.roll_sd_rad[n] == pytest.approx(expected[1], rel=1e-5)


@pytest.mark.parametrize("basis", [LINE_BASIS, (*LINE_BASIS, *Q_BASIS)])
def test_polynomials_are_the_covariance_of_predictions(basis) -> None:
    rng = np.random.default_rng(5)
    terms = len(basis)
    own = ParameterErrors(random_covariance(rng, 3 * terms, 1e-5)[None], np.array([np.inf]), READING_V**2, basis)
    force = specific_force(*attitudes(rng, 20))
    sampled = errors_of_force(K, own).total(force.T)
    full = np.concatenate([np.ones((20, 1)), force, quadratic_basis(force)], axis=1)[:, :terms]
    inverse = np.linalg.inv(K)
    for n in range(20):
        rows = np.kron(np.eye(3), full[n])
        expected = inverse @ (rows @ own.covariances_v2[0] @ rows.T + np.diag(READING_V**2)) @ inverse.T
        vector = rng.normal(size=(3, 1))
        assert quadratic_form(sampled[:, n : n + 1], vector)[0] == pytest.approx(
            (vector.T @ expected @ vector)[0, 0], rel=1e-9
        )


def test_quadratic_terms_are_taken_off_at_the_angles_themselves() -> None:
    rng = np.random.default_rng(6)
    q = rng.normal(0, 2e-3, (3, 5))
    pitch, roll = attitudes(rng, 200)
    force = specific_force(pitch, roll)
    bent = np.stack([np.einsum("ni,ij,nj->n", force, matrix_from_elements(own), force) for own in q])
    powers = [next(iter(monomial)) for monomial in MONOMIALS]
    bend = Bend(powers, q @ np.array([[entry.get(p, 0.0) for p in powers] for entry in Q_BASIS]))
    found = package(bend=bend).attitude(outputs(pitch, roll) + bent)
    np.testing.assert_allclose(found.pitch_rad, pitch, atol=1e-12)
    np.testing.assert_allclose(found.roll_rad, roll, atol=1e-11)


def test_the_vertical_keeps_pitch_and_loses_roll() -> None:
    found = package().attitude(outputs([np.pi / 2, -np.pi / 2, 0.3], [0.3, 0.3, 0.3]))
    assert found.codes.tolist() == [ROLL_SINGULAR, ROLL_SINGULAR, 0]
    np.testing.assert_allclose(np.abs(found.pitch_rad[:2]), np.pi / 2, atol=1e-7)
    assert np.isnan(found.roll_rad[:2]).all()
    assert (found.pitch_sd_rad[:2] > 0).all()
    vague = three_axes.three_axes(
        K, OFFSET_V, ParameterErrors(np.zeros((0, 12, 12)), np.empty(0), np.ones(3)), redundancy_limit
    )
    assert (
        vague.attitude(outputs([0.3], [0.3])).codes[0] & (PITCH_SINGULAR | ROLL_SINGULAR)
        == PITCH_SINGULAR | ROLL_SINGULAR
    )


def test_what_is_not_a_number_is_marked_and_touches_no_other_row() -> None:
    pitch, roll = attitudes(np.random.default_rng(7), 100)
    read = outputs(pitch, roll)
    read[1, 30], read[2, 60], read[0, 90] = np.nan, np.inf, -np.inf
    found = package().attitude(read)
    assert np.flatnonzero(found.codes).tolist() == [30, 60, 90]
    assert set(found.codes[[30, 60, 90]].tolist()) == {NOT_FINITE}
    assert np.isnan(found.pitch_rad[[30, 60, 90]]).all()
    clean = package().attitude(outputs(pitch, roll))
    good = found.codes == 0
    np.testing.assert_allclose(found.pitch_rad[good], clean.pitch_rad[good], rtol=0, atol=1e-15)
    assert flag_codes.words(found.codes[30:31]) == ("reading missing or not a number",)
    assert package().angles(read)[2][30] == NOT_FINITE


def test_the_answer_of_a_row_is_that_it_has_in_any_company() -> None:
    """To the last bit: of steps that rows beside it need, and of rows that none settles, a row knows nothing."""
    rng, count = np.random.default_rng(12), 600
    readings = outputs(*attitudes(rng, count)) * (1.0 + 4e-6 * rng.normal(size=count))
    beside, is_off = readings.copy(), np.arange(count) % 6 == 0
    beside[:, is_off] *= np.where(np.arange(is_off.sum()) % 10 == 0, 1.4, 1.0 + 1e-4)
    alone, together = package().attitude(readings), package().attitude(beside)
    for name in ("pitch_rad", "roll_rad", "pitch_sd_rad", "roll_sd_rad", "redundancy_t"):
        np.testing.assert_array_equal(getattr(together, name)[~is_off], getattr(alone, name)[~is_off])


def test_an_empty_table_has_no_angles() -> None:
    assert package().attitude(np.empty((3, 0))).pitch_rad.size == 0


FAULTS = {
    "y unplugged": (lambda v: np.where(np.arange(3)[:, None] == 1, OFFSET_V[:, None], v)),
    "z clipped by 1.5 %": (lambda v: v - 0.015 * np.where(np.arange(3)[:, None] == 2, v - OFFSET_V[:, None], 0.0)),
    "all outputs 2 % high": (lambda v: OFFSET_V[:, None] + 1.02 * (v - OFFSET_V[:, None])),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_what_was_silent_is_flagged(fault: str) -> None:
    """The reviewers' cases at pitch 20°, roll 30°."""
    found = package().attitude(FAULTS[fault](outputs(20 * DEG, 30 * DEG)))
    assert found.codes[0] & REDUNDANCY
    assert abs(found.redundancy_t[0]) > 10


def test_gravity_that_is_not_known_is_no_disagreement() -> None:
    read = OFFSET_V[:, None] + 1.001 * (outputs(20 * DEG, 30 * DEG) - OFFSET_V[:, None])
    assert package().attitude(read).codes[0] == REDUNDANCY
    assert package(gravity_relative_u=1e-3).attitude(read).codes[0] == 0


@dataclass(frozen=True)
class OfManySets:
    """Every row is of a set of its own: its calibration's variance was estimated, well or badly."""

    whole: PolynomialErrors
    factor: np.ndarray

    def total(self, force):
        calibration, reading = self.whole.parts(force, np.arange(force.shape[1])).swapaxes(0, 0)
        return calibration * self.factor + reading

    def parts(self, force, rows):
        calibration, reading = self.whole.parts(force, rows)
        return np.stack([calibration * self.factor[rows], reading])

    def dof(self, rows):
        return self.whole.dof(rows)

    def weighing(self, sensed, square) -> SharedWeighing:
        return self.whole.weighing(sensed, square)


@pytest.mark.parametrize(("scale", "dof"), rest_to_thorough([2e-6, 3e-5, 3e-4], [4.0, 6.0, 20.0, np.inf], every=5))
def test_one_good_row_in_a_thousand_is_suspected(dof: float, scale: float) -> None:
    """200 000 independent sets whose covariance was estimated with few degrees of freedom, one reading of each."""
    rng = np.random.default_rng(8)
    count = 200_000
    own = errors(seed=9, parts=1, scale=scale, dof=(dof,))
    pitch, roll = attitudes(rng, count)
    force = specific_force(pitch, roll)
    wrong = rng.multivariate_normal(np.zeros(12), own.covariances_v2[0], count).reshape(count, 3, 4)
    basis = np.concatenate([np.ones((count, 1)), force], axis=1)
    deviation = K @ force.T + np.einsum("nip,np->in", wrong, basis) + READING_V[:, None] * rng.normal(size=(3, count))
    factor = np.ones(count) if np.isinf(dof) else rng.chisquare(dof, count) / dof
    used = OfManySets(errors_of_force(K, own), factor)
    sensed = np.linalg.solve(K, deviation)
    found = AttitudeColumns.empty(count)
    judged_into(found, slice(None), (sensed, *fitted(sensed, used)), used, redundancy_limit, 0.0)
    share = np.mean((found.codes & REDUNDANCY) != 0)
    assert 0.0005 <= share <= 0.002


def test_memory_does_not_grow_with_rows() -> None:
    assert max(block.stop - block.start for block in three_axes.blocks(10**7)) == three_axes.BLOCK_ROWS


def test_axes_in_one_plane_are_refused() -> None:
    with pytest.raises(DesignError, match="one plane"):
        three_axes.three_axes(K[[0, 1, 1]], OFFSET_V, errors(), redundancy_limit)
