"""What is remembered is what the function gives, for equal contents only, and nobody can write into it."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from ams.remembered import remembered
from ams.statistics.intervals import FTestColumns


def test_equal_contents_are_computed_once_and_others_anew() -> None:
    calls = []

    @remembered(2)
    def doubled(values: np.ndarray, times: int = 2) -> np.ndarray:
        calls.append(times)
        return values * times

    index = np.arange(3.0)
    first, again = doubled(index), doubled(index.copy())
    assert first is again
    assert len(calls) == 1
    for other in (index + 1e-9, index.astype(int), index.reshape(3, 1), -0.0 * index):
        np.testing.assert_array_equal(doubled(other), other * 2)
    doubled(index, times=3)
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


def test_what_was_handed_out_is_known_as_an_argument_and_no_other_array_is_taken_for_it() -> None:
    calls = []

    @remembered(4)
    def doubled(values: np.ndarray) -> np.ndarray:
        return 2.0 * values

    @remembered(64)
    def total(values: np.ndarray) -> float:
        calls.append(values)
        return float(values.sum())

    for size in range(2, 30):  # the first are forgotten: others may stand at their place in memory
        values = np.arange(float(size))
        assert total(doubled(values)) == total(doubled(values)) == size * (size - 1)
    assert len(calls) == 28


def test_arrays_in_a_tuple_or_a_value_are_read_only_as_well() -> None:
    @remembered(4)
    def both(values: np.ndarray) -> tuple[np.ndarray, FTestColumns]:
        return values + 1.0, FTestColumns(values + 2.0, 1.0, values + 3.0, 1.0, 1.0, values > 0.0)

    entry, other = both(np.zeros(3))
    for array in (entry, other.t):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_what_is_large_is_computed_each_time() -> None:
    calls = []

    @remembered(2)
    def noted(values: np.ndarray) -> int:
        calls.append(values.size)
        return values.size

    large = np.zeros(200_000)
    assert noted(large) == noted(large)
    assert len(calls) == 2


def test_content_that_is_looked_up_alike_is_still_told_apart() -> None:
    calls = []

    @remembered(8)
    def total(values: np.ndarray) -> float:
        calls.append(values)
        return float(values.sum())

    for index in range(0, 5000, 7):  # one number differs, wherever it stands
        values = np.zeros(5000)
        values[index] = 2.0**-30
        assert total(values) == 2.0**-30
    assert len(calls) == len(range(0, 5000, 7))


def test_threads_that_find_and_forget_at_once_all_get_what_the_function_gives() -> None:
    @remembered(3)
    def doubled(value: int, values: np.ndarray) -> np.ndarray:
        return 2.0 * value * values

    def wrong(first: int) -> int:
        values = np.ones(4)
        asked = [(first * turn) % 7 for turn in range(2000)]
        return sum(doubled(value, values)[0] != 2.0 * value for value in asked)

    with ThreadPoolExecutor(4) as threads:
        assert sum(threads.map(wrong, (1, 2, 3, 5))) == 0
