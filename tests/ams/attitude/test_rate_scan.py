"""Attitudes from rates against scipy's rotations, whole and in pieces, with and without gaps."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from integrated import integrated
from scipy.spatial.transform import Rotation

from ams.attitude import quaternion, rate_scan
from ams.attitude.rate_scan import RateScan, bridge, path_by_turns, prefix_products, turns_of_rates
from ams.errors import ObservationsError

START = Rotation.from_euler("ZYX", [0.3, -0.2, 1.0]).as_quat()


def motion(count: int, interval_s: float):
    """R(t) = Rz(sin t) Ry(t²/2) with its body rates by hand."""
    t = np.arange(count) * interval_s
    path = Rotation.from_euler("ZY", np.column_stack([np.sin(t), 0.5 * t**2]))
    yaw_rate, pitch, pitch_rate = np.cos(t), 0.5 * t**2, t
    return path, np.stack([-np.sin(pitch) * yaw_rate, pitch_rate, np.cos(pitch) * yaw_rate])


def off(path, truth) -> float:
    return float((Rotation.from_quat(path.quaternion.T) * truth.inv()).magnitude().max())


@pytest.mark.parametrize("count", [1, 2, 63, 64, 65, 200, 1000, 5003])
def test_prefix_products_are_the_products_one_by_one(count: int) -> None:
    steps = Rotation.random(count, rng=np.random.default_rng(1)).as_quat()
    expected = np.empty_like(steps)
    expected[0] = steps[0]
    for n in range(1, count):
        expected[n] = quaternion.multiply(expected[n - 1], steps[n])
    np.testing.assert_allclose(prefix_products(steps.T).T, expected, atol=1e-12)


def test_cubic_is_of_fourth_order_on_a_rate_that_bends() -> None:
    errors = []
    for count in (51, 101, 201):
        truth, rates = motion(count, 1.5 / (count - 1))
        errors.append(off(integrated(rates, truth[0].as_quat(), 1.5 / (count - 1)), truth))
    assert np.all(np.log2(np.array(errors[:-1]) / np.array(errors[1:])) > 3.7)


@pytest.mark.parametrize(("interpolation", "degree"), [("hold", 0), ("linear", 1), ("cubic", 3)])
def test_the_moments_are_exact_for_polynomials_of_its_degree(interpolation, degree: int) -> None:
    """About one axis the turn is the integral of the rate, end intervals included."""
    t = np.arange(9.0)
    integral = np.polynomial.Polynomial([0.3, -0.2, 0.05, 0.01][: degree + 1]).integ()
    rates = np.zeros((3, 9))
    rates[1] = integral.deriv()(t * 0.1)
    found = turns_of_rates(rates, 0.1, interpolation)
    np.testing.assert_allclose(found[1], np.diff(integral(t * 0.1)), atol=1e-15)
    assert not found[[0, 2]].any()


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.integers(0, 60), min_size=1, max_size=12),
    st.integers(0, 10_000),
    st.sampled_from(["cubic", "linear", "hold"]),
)
def test_chunks_of_any_length_give_what_the_whole_gives(lengths, seed, interpolation) -> None:
    rng = np.random.default_rng(seed)
    count = sum(lengths) + 5
    rates = rng.normal(0, 0.5, (3, count))
    for _ in range(rng.integers(0, 4)):
        first, gap = rng.integers(0, count), rng.choice([1, 2, 7, 150])
        rates[rng.integers(0, 3), first : first + gap] = np.nan
    rates[:, rng.integers(0, count)] = 0.1
    stream = RateScan(START, 0.02, interpolation)
    ends = np.append(np.cumsum(lengths), count)
    pieces = [stream.feed(rates[:, a:b]) for a, b in zip(np.append(0, ends[:-1]), ends, strict=True)]
    pieces.append(stream.finish())
    filled, is_missing = bridge(rates)
    whole = path_by_turns(START, filled, slice(None), 0.02, interpolation)
    np.testing.assert_allclose(np.concatenate([p.quaternion for p in pieces], axis=1), whole, atol=1e-12)
    np.testing.assert_array_equal(np.concatenate([p.is_bridged for p in pieces]), is_missing)
    np.testing.assert_array_equal(np.concatenate([p.bridged_samples for p in pieces]), np.cumsum(is_missing))


def test_a_stream_keeps_no_more_than_it_needs() -> None:
    stream = RateScan(START, 0.01)
    for _ in range(50):
        stream.feed(np.full((3, 100), 0.1))
    assert stream._rates.shape[1] <= 4
    stream.feed(np.full((3, 100), np.nan))
    for _ in range(50):
        stream.feed(np.full((3, 100), np.nan))
    assert stream._rates.shape[1] <= 4
    assert stream._waiting.shape[1] <= rate_scan.LONGEST_BRIDGE


def test_a_gap_is_bridged_marked_and_counted() -> None:
    truth, rates = motion(201, 0.005)
    holed = rates.copy()
    holed[0, 50:53] = np.nan
    holed[:, 120] = np.inf
    path = integrated(holed, truth[0].as_quat(), 0.005)
    assert np.flatnonzero(path.is_bridged).tolist() == [50, 51, 52, 120]
    assert path.bridged_samples[[49, 52, 119, 200]].tolist() == [0, 3, 3, 4]
    assert np.isfinite(path.quaternion).all()
    assert off(path, truth) < 1e-5


def test_a_long_gap_holds_the_last_rate() -> None:
    rates = np.zeros((3, 400))
    rates[0] = np.arange(400.0)
    rates[:, 100:300] = np.nan
    filled, is_missing = bridge(rates)
    assert is_missing.sum() == 200
    np.testing.assert_array_equal(filled[0, 100:300], 99.0)
    rates[0, 100:300] = np.nan
    rates[:, 150] = [150.0, 0.0, 0.0]
    np.testing.assert_allclose(bridge(rates)[0][0, 100:151], np.arange(100.0, 151.0))


def test_nothing_to_integrate_is_refused() -> None:
    with pytest.raises(ObservationsError, match="no sample has a rate"):
        integrated(np.full((3, 10), np.nan), START, 0.01)
    with pytest.raises(ObservationsError, match="cubic interpolation needs 4"):
        integrated(np.zeros((3, 3)), START, 0.01)
    stream = RateScan(START, 0.01)
    stream.feed(np.zeros((3, 2)))
    with pytest.raises(ObservationsError, match="cubic interpolation needs 4"):
        stream.finish()
    with pytest.raises(ObservationsError, match="above 0 s"):
        RateScan(START, 0.0)
