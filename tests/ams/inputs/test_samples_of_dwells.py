"""The step of single samples, and their noise, as the dwells hold them."""

import numpy as np
import pytest

from ams.inputs.samples_of_dwells import sampled_of

POINT = np.array([1, 2])
PER_G = 1.0 / 1333.0


def test_the_variance_is_that_about_the_mean_of_every_dwell() -> None:
    """By hand: 0, 1 about 0.5 is 1/4, and 2, 2 nothing."""
    found = sampled_of([np.array([0.0, 1.0]), np.array([2.0, 2.0])], POINT, 1.0)
    assert (found.step, found.variance, found.points) == (1.0, 0.125, 2)


@pytest.mark.parametrize("zero_counts", [0.0, 133.3])
def test_two_values_show_the_count_that_their_board_is_declared_to_send(zero_counts: float) -> None:
    """Neither is a decimal of a g, and a difference of 2640 counts is no step of ten."""
    samples = [(np.full(30, counts) - zero_counts) * PER_G for counts in (-1300.0, 1340.0)]
    assert sampled_of(samples, POINT, PER_G).step == pytest.approx(PER_G)
    assert sampled_of(samples, POINT).step != pytest.approx(PER_G)


def test_a_board_that_prints_two_decimals_has_their_step_and_not_that_of_a_whole_unit() -> None:
    assert sampled_of([np.full(30, 0.98), np.full(30, -1.03)], POINT, 1.0).step == pytest.approx(0.01)


def test_values_that_all_are_multiples_of_sixteen_counts_have_that_step() -> None:
    """Twelve bits in the upper part of sixteen."""
    counts = 16.0 * np.array([-1201.0, -7.0, 3.0, 12.0, 802.0, 1361.0])
    samples = [np.full(30, value * PER_G) for value in counts]
    assert sampled_of(samples, np.arange(6), PER_G).step == pytest.approx(16.0 * PER_G)


def test_samples_that_do_not_repeat_or_never_change_show_none() -> None:
    chance = np.random.default_rng(3)
    loud = [volts + 1e-5 * chance.standard_normal(300) for volts in (-2.5, 2.5)]
    assert sampled_of(loud, POINT).step is None
    assert sampled_of([np.full(30, 0.3), np.full(30, 0.3)], POINT, 0.1).step is None


def test_many_dwells_are_looked_at_in_part_and_show_the_same_step() -> None:
    chance = np.random.default_rng(4)
    true = chance.uniform(-1300.0, 1300.0, 3000)
    samples = [np.rint(at + 0.2 * chance.standard_normal(20)) * PER_G for at in true]
    found = sampled_of(samples, np.arange(3000), PER_G)
    assert found.step == pytest.approx(PER_G)
    assert found.variance == pytest.approx(np.mean([of_dwell.var() for of_dwell in samples]))
