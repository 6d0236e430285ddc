"""Laws of running numbers: wraps are undone, what is missing is named."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.abilities.stream_reader import Wrapping, count_gaps, time_gaps


@given(st.integers(0, 65535), st.lists(st.integers(0, 200), max_size=40), st.integers(0, 40))
def test_wraps_are_undone_wherever_the_blocks_are_cut(start: int, steps: list[int], cut: int) -> None:
    truth = start + np.concatenate([[0], np.cumsum(steps)]).astype(float)
    raw = np.mod(truth, 65536.0)
    wrapping = Wrapping(65536.0)
    cut = min(cut, len(raw))
    first = wrapping.unwrapped(raw[:cut], None)
    second = wrapping.unwrapped(raw[cut:], float(first[-1]) if cut else None)
    np.testing.assert_array_equal(np.concatenate([first, second]), truth)


def test_a_count_that_skips_repeats_or_goes_back_is_named_where_it_does() -> None:
    gaps = count_gaps(np.array([5.0, 6.0, 9.0, 9.0, 2.0, 3.0]), 4.0)
    assert [(gap.at, gap.missing) for gap in gaps] == [(2, 2), (3, 0), (4, None)]
    assert [(gap.at, gap.missing) for gap in count_gaps(np.array([7.0, 8.0]), 4.0)] == [(0, 2)]
    assert count_gaps(np.array([7.0, 8.0]), None) == ()


def test_time_shows_missing_samples_by_the_rate() -> None:
    times_s = np.array([0.0, 0.01, 0.0201, 0.05, 0.05, 0.04])
    gaps = time_gaps(times_s, None, 100.0)
    assert [(gap.at, gap.missing) for gap in gaps] == [(3, 2), (4, 0), (5, None)]


def test_a_single_lost_sample_is_a_gap_of_one_also_between_two_blocks() -> None:
    assert [(gap.at, gap.missing) for gap in time_gaps(np.array([0.0, 0.01, 0.03, 0.04]), None, 100.0)] == [(2, 1)]
    assert [(gap.at, gap.missing) for gap in time_gaps(np.array([0.07, 0.08]), 0.05, 100.0)] == [(0, 1)]


@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_jitter_of_a_third_of_the_interval_is_no_gap(jitter: float) -> None:
    rng = np.random.default_rng(3)
    times_s = 0.005 * (np.arange(1000) + rng.uniform(-jitter / 2, jitter / 2, 1000))
    assert time_gaps(times_s, None, 200.0) == ()
