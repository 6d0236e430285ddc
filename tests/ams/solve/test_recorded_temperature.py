"""What a recorded temperature did to an estimate is what its component says, by arithmetic and over campaigns."""

import numpy as np
import pytest
from physics_scenes import campaigns
from solved_campaigns import coverage, solved

from ams.arrays import FloatArray
from ams.frames import Attitude
from ams.models.accelerometer import PitchRoll
from ams.solve.linear_form import factor
from ams.solve.recorded_temperature import is_unmodelled, recorded_temperature

MODEL = PitchRoll("x")
TRUTH = np.array([0.01, 2.5, 0.02, -0.03])


def _component(temperature_degc: FloatArray, shift_v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bias of the ordinary estimate, and the covariance that is stated of it."""
    rng = np.random.default_rng(3)
    rows = Attitude(rng.uniform(-1.5, 1.5, temperature_degc.size), rng.uniform(-3.1, 3.1, temperature_degc.size))
    form = factor(MODEL.basis(rows), MODEL.primary_names, rows)
    outputs = (form.basis @ TRUTH + shift_v)[:, None]
    ordinary = form.solve(outputs)
    part = recorded_temperature(form, form.estimator, outputs, ordinary, temperature_degc)
    return ordinary[:, 0] - TRUTH, part.covariance[0]


def test_without_noise_the_component_is_the_square_of_what_the_temperature_did() -> None:
    temperature = 20.0 + np.linspace(-0.3, 0.5, 40) ** 2
    bias, covariance = _component(temperature, 25e-6 * (temperature - temperature.mean()))
    assert np.abs(bias).max() > 1e-8
    assert covariance == pytest.approx(np.outer(bias, bias), rel=1e-6, abs=1e-20)


def test_a_temperature_that_acts_on_nothing_adds_nothing() -> None:
    _, covariance = _component(20.0 + np.linspace(-0.3, 0.5, 40) ** 2, np.zeros(40))
    assert np.abs(covariance).max() < 1e-24


def test_a_temperature_that_the_attitudes_tell_whole_blows_nothing_up() -> None:
    rng = np.random.default_rng(3)
    along = np.sin(rng.uniform(-1.5, 1.5, 40))  # the pitch that _component draws first
    _, covariance = _component(20.0 + 0.1 * along, 1e-6 * rng.standard_normal(40))
    assert np.sqrt(covariance[0, 0]) < 1e-6


@pytest.mark.parametrize("nth", [0, 1, 2])
def test_one_reading_that_stands_apart_by_its_last_digit_widens_nothing(nth: int) -> None:
    """The attitude of that reading is that of the mean output: what it does to what is sensed lies in the model."""
    rng = np.random.default_rng(3)
    pitch_rad, roll_rad = rng.uniform(-1.5, 1.5, 60), rng.uniform(-3.1, 3.1, 60)
    fitted = MODEL.basis(Attitude(pitch_rad, roll_rad)) @ TRUTH
    location = int(np.argsort(np.abs(fitted - fitted.mean()))[nth])
    rows = Attitude(pitch_rad, roll_rad)
    temperature = np.full(60, 21.0)
    temperature[location] += 0.05
    form = factor(MODEL.basis(rows), MODEL.primary_names, rows)
    outputs = (form.basis @ TRUTH + 1e-5 * rng.standard_normal(60))[:, None]
    part = recorded_temperature(form, form.estimator, outputs, form.solve(outputs), temperature)
    assert np.all(np.diag(part.covariance[0]) < 0.3 * 1e-10 * np.diag(form.unscaled_covariance))


@pytest.mark.parametrize("temperature_degc", [None, np.full(5, 20.0)])
def test_what_was_not_recorded_or_never_changed_counts_for_nothing(temperature_degc: FloatArray | None) -> None:
    assert not is_unmodelled(MODEL, temperature_degc)


def test_in_step_with_the_replications_the_intervals_hold_what_they_would_lose() -> None:
    drawn = campaigns("temperature-in-step", 0.05, np.random.default_rng(5), 60)
    after, before = solved(drawn), solved(drawn, extended=False)
    held, lost = (coverage(drawn, entry, np.random.default_rng(9)) for entry in (after, before))
    assert held.least > 0.9
    assert lost.least < 0.85


def test_a_temperature_that_wanders_by_chance_widens_nothing() -> None:
    drawn = campaigns("temperature-alternating", 0.1, np.random.default_rng(5), 5)
    shares = [
        next(part for part in entry.components if part.name == "recorded temperature").covariance[:, 0, 0]
        / entry.primary_covariance[:, 0, 0]
        for entry in solved(drawn).values()
    ]
    assert np.max(shares) < 0.01
