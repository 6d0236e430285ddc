"""The chance of one number, against readings that are drawn."""

import numpy as np
import pytest

from ams.inputs.equal_readings import chance_of_a_number


@pytest.mark.parametrize("step", [0.05, 0.2, 0.5])
def test_no_number_is_read_oftener_and_the_most_likely_one_nearly_so(step: float) -> None:
    numbers = np.rint(np.random.default_rng(1).standard_normal(400_000) / step)
    shares = np.unique(numbers, return_counts=True)[1] / numbers.size
    assert shares.max() == pytest.approx(chance_of_a_number(step, 1.0), rel=0.03)


def test_two_readings_are_equal_as_their_difference_is_none() -> None:
    numbers = np.rint(np.random.default_rng(2).standard_normal((2, 400_000)) / 0.2)
    equal = np.mean(numbers[0] == numbers[1])
    assert equal == pytest.approx(chance_of_a_number(0.2, np.sqrt(2.0)), rel=0.03)


def test_it_is_certain_without_noise_and_with_steps_that_hold_all_of_it() -> None:
    assert chance_of_a_number(1e-6, 0.0) == chance_of_a_number(10.0, 1.0) == 1.0
