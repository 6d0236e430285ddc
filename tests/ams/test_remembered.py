"""What is remembered is what the function gives, for equal contents only, and nobody can write into it."""

import numpy as np
import pytest

from ams.remembered import remembered


def test_equal_contents_are_computed_once_and_others_anew() -> None:
    calls = []

    @remembered(2)
    def doubled(values: np.ndarray, times: int = 2) -> np.ndarray:
        calls.append(times)
        return values * times

    one = np.arange(3.0)
    first, again = doubled(one), doubled(one.copy())
    assert first is again
    assert len(calls) == 1
    for other in (one + 1e-9, one.astype(int), one.reshape(3, 1), -0.0 * one):
        np.testing.assert_array_equal(doubled(other), other * 2)
    doubled(one, times=3)
    assert len(calls) == 6
    with pytest.raises(ValueError, match="read-only"):
        first[0] = 1.0


def test_the_oldest_is_forgotten() -> None:
    calls = []

    @remembered(2)
    def noted(value: int) -> int:
        calls.append(value)
        return value

    for value in (1, 2, 1, 3, 1, 2):
        noted(value)
    assert calls == [1, 2, 3, 2]
