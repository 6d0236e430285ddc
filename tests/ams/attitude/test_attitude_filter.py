"""The filter over streams: honest over hundreds of runs, bounded over hours, and spoilt by nothing that it is fed."""

import numpy as np
import pytest
from kalman_steps import start_estimate
from scipy.spatial.transform import Rotation

from ams.attitude.attitude_filter import (
    FIELD_MISSING,
    FORCE_MISSING,
    FORCE_REJECTED,
    GYRO_BRIDGED,
    UNAIDED,
    AttitudeFilter,
    FilterSettings,
    mean_band,
)
from ams.attitude.kalman import GyroNoise
from ams.errors import ObservationsError

NOISE = GyroNoise(2e-3, 2e-5)
INTERVAL_S = 0.05
DOWN = np.array([0.0, 0.0, -1.0])
FIELD_UT = np.array([22.0, 3.0, 42.0])
SETTINGS = FilterSettings(
    INTERVAL_S, NOISE, force_sd_g=0.01, field_reference_ut=(22.0, 3.0, 42.0), field_sd_ut=0.5, gate=1e9
)


class Flight:
    """A motion with its truth, by explicit rotations of scipy, and what noisy sensors make of it."""

    def __init__(self, rng: np.random.Generator, rows: int, start_sd: float = 0.1, bias_sd: float = 0.01) -> None:
        time = np.arange(rows) * INTERVAL_S
        phase = rng.uniform(0, 6, 3)[:, None]
        self.rates = 0.4 * np.sin(np.array([[0.6], [1.0], [0.4]]) * time + phase)
        turns = (self.rates[:, 1:] + self.rates[:, :-1]).T / 2.0 * INTERVAL_S
        attitude = [Rotation.random(rng=rng)]
        for turn in turns:
            attitude.append(attitude[-1] * Rotation.from_rotvec(turn))
        self.attitude = Rotation.concatenate(attitude)
        walk = rng.normal(0, NOISE.bias_walk_rad_s_per_sqrt_s * np.sqrt(INTERVAL_S), (3, rows))
        self.bias = rng.normal(0, bias_sd, (3, 1)) + np.cumsum(walk, axis=1)
        white = rng.normal(0, NOISE.angle_random_walk_rad_per_sqrt_s / np.sqrt(INTERVAL_S), (3, rows))
        self.gyro = self.rates + self.bias + white
        back = self.attitude.inv()
        self.force = back.apply(DOWN).T + rng.normal(0, 0.01, (3, rows))
        self.field = back.apply(FIELD_UT).T + rng.normal(0, 0.5, (3, rows))
        wrong = Rotation.from_rotvec(rng.normal(0, start_sd, 3)) * self.attitude[0]
        self.start = start_estimate(wrong.as_quat(), start_sd, bias_sd)

    def error(self, filter_: AttitudeFilter) -> float:
        """The normalised estimation error squared (NEES), six degrees of freedom."""
        found = filter_.estimate
        turn = (self.attitude[-1] * Rotation.from_quat(found.quaternion).inv()).as_rotvec()
        error = np.concatenate([turn, self.bias[:, -1] - found.bias_rad_s])
        return float(error @ np.linalg.solve(found.covariance, error))


def test_errors_and_innovations_keep_to_the_band_of_their_means_over_two_hundred_runs() -> None:
    errors, of_force, of_field = [], [], []
    for seed in range(200):
        flight = Flight(np.random.default_rng(seed), 60)
        running = AttitudeFilter(SETTINGS, flight.start)
        path = running.run(flight.gyro, flight.force, flight.field)
        errors.append(flight.error(running))
        of_force.append(path.force_innovation[30:])
        of_field.append(path.field_innovation[30:])
    for values, dof in ((np.array(errors), 6), (np.concatenate(of_force), 3), (np.concatenate(of_field), 3)):
        low, high = mean_band(dof, values.size)
        assert low < values.mean() < high


def test_the_band_is_that_of_chi_square() -> None:
    draws = np.random.default_rng(2).chisquare(6, (20000, 200)).mean(axis=1)
    assert mean_band(6, 200) == pytest.approx(np.quantile(draws, [0.0005, 0.9995]), rel=0.02)


def test_chunks_give_what_the_whole_gives() -> None:
    flight = Flight(np.random.default_rng(3), 100)
    whole = AttitudeFilter(SETTINGS, flight.start).run(flight.gyro, flight.force, flight.field)
    parted = AttitudeFilter(SETTINGS, flight.start)
    pieces = [
        parted.run(flight.gyro[:, part], flight.force[:, part], flight.field[:, part])
        for part in (slice(0, 1), slice(1, 40), slice(40, 40), slice(40, 100))
    ]
    np.testing.assert_array_equal(np.concatenate([piece.quaternion for piece in pieces], axis=1), whole.quaternion)


def test_what_was_not_read_is_marked_and_spoils_nothing() -> None:
    flight = Flight(np.random.default_rng(4), 400)
    flight.gyro[1, 100:104] = np.nan
    flight.force[:, 200:203] = np.nan
    flight.field[2, 300] = np.inf
    running = AttitudeFilter(SETTINGS, flight.start)
    path = running.run(flight.gyro, flight.force, flight.field)
    assert np.isfinite(path.quaternion).all()
    assert np.flatnonzero(path.codes & GYRO_BRIDGED).tolist() == [100, 101, 102, 103]
    assert np.flatnonzero(path.codes & FORCE_MISSING).tolist() == [200, 201, 202]
    assert np.flatnonzero(path.codes & FIELD_MISSING).tolist() == [300]
    assert path.sd[:3, 103].max() > 1.2 * path.sd[:3, 99].max()
    assert flight.error(running) < 27.0  # chi-square of 6 at 0.9999


def test_a_stream_that_begins_without_rates_is_carried_by_gravity() -> None:
    flight = Flight(np.random.default_rng(5), 200)
    flight.gyro[:, :3] = np.nan
    running = AttitudeFilter(SETTINGS, flight.start)
    path = running.run(flight.gyro, flight.force, flight.field)
    assert np.isfinite(path.quaternion).all()
    assert flight.error(running) < 27.0


def test_an_accelerated_stretch_is_left_out_with_what_follows_it() -> None:
    flight = Flight(np.random.default_rng(6), 600)
    push = np.zeros((3, 600))
    push[0, 300:360] = np.sin(np.linspace(0, 2 * np.pi, 60)) * 0.8  # passes through zero halfway
    force = flight.force + push
    settings = FilterSettings(INTERVAL_S, NOISE, 0.01, field_reference_ut=(22.0, 3.0, 42.0), field_sd_ut=0.5)
    running = AttitudeFilter(settings, flight.start)
    path = running.run(flight.gyro, force, flight.field)
    rejected = (path.codes & FORCE_REJECTED) != 0
    assert rejected[303:360].all()
    assert rejected[:300].mean() < 0.1
    assert not rejected[380:].all()
    assert flight.error(running) < 27.0


def test_gravity_that_stays_away_is_said() -> None:
    flight = Flight(np.random.default_rng(7), 300)
    flight.force[:, 20:] += np.array([[0.0], [0.5], [0.0]])
    settings = FilterSettings(INTERVAL_S, NOISE, 0.01, unaided_s=5.0)
    path = AttitudeFilter(settings, flight.start).run(flight.gyro, flight.force)
    assert path.codes[60] == FORCE_REJECTED
    assert path.codes[150] == FORCE_REJECTED | UNAIDED


@pytest.mark.parametrize(
    "rows", [pytest.param(36_000, marks=pytest.mark.thorough), pytest.param(216_000, marks=pytest.mark.soak)], ids=str
)
def test_hours_of_flight_stay_bounded_where_integration_drifts(rows: int) -> None:
    """Half an hour and three, with a bias of 0.5 °/s: the gyro alone is 900° out, the filter within its few tenths."""
    flight = Flight(np.random.default_rng(8), rows, bias_sd=0.009)
    running = AttitudeFilter(SETTINGS, flight.start)
    path = running.run(flight.gyro, flight.force, flight.field)
    off = (Rotation.from_quat(path.quaternion.T[1000:]) * flight.attitude[1000:].inv()).magnitude()
    assert np.rad2deg(off).max() < 2.0
    assert 0.6 < np.sqrt(np.mean(off**2)) / np.sqrt(np.mean(np.sum(path.sd[:3, 1000:] ** 2, axis=0))) < 1.4


def test_settings_that_contradict_themselves_are_refused() -> None:
    with pytest.raises(ObservationsError, match="give both or none"):
        FilterSettings(0.01, NOISE, 0.01, field_reference_ut=(1.0, 0.0, 0.0))
    with pytest.raises(ObservationsError, match="both must be above 0"):
        FilterSettings(0.0, NOISE, 0.01)
