"""TP table 1, tumble designs and theorems, with a brute-force look at the maximum."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pitch_roll_of_tp import primary_from_parameters

from ams.analysis.design_variance import (
    AngleBox,
    design_rank,
    evaluate_design,
    max_variance,
    variance_function,
)
from ams.errors import DesignError
from ams.frames import Attitude
from ams.models.accelerometer import PitchOnly, PitchRoll
from ams.solve.linear_form import factor

ROLL_DEG = -180.0 + 360.0 / 64 * np.arange(64)


def grid(pitch_deg: np.ndarray, roll_deg: np.ndarray = ROLL_DEG) -> tuple[np.ndarray, np.ndarray]:
    pitch, roll = np.meshgrid(np.deg2rad(pitch_deg), np.deg2rad(roll_deg), indexing="ij")
    return pitch.ravel(), roll.ravel()


def box(limit_deg: float) -> AngleBox:
    return AngleBox((-np.deg2rad(limit_deg), np.deg2rad(limit_deg)))


TWO_CLUSTERS = np.concatenate([np.full(16, -30.0), [0.0], np.full(16, 30.0)])
TABLE_1 = [  # pitch points, calibration range, V^½, usage range, V_R^½
    (np.linspace(-30, 30, 33), 30, 1.989, None, None),
    (np.linspace(-45, 45, 33), 45, 1.993, 30, 1.927),
    (np.linspace(-90, 90, 33), 90, 2.008, 30, 2.222),
    (np.linspace(-180, 180, 33), 180, 1.993, 30, 2.174),
    (TWO_CLUSTERS, 30, 1.941, 10, 1.912),
]


@pytest.mark.parametrize(("pitch_deg", "limit", "printed", "usage", "usage_printed"), TABLE_1)
def test_figures_of_merit_of_tp_table_1(pitch_deg, limit, printed, usage, usage_printed) -> None:
    found = evaluate_design(*grid(pitch_deg), box(limit), None if usage is None else box(usage))
    assert found.figure_of_merit_sqrt == pytest.approx(printed, abs=0.0006)
    assert found.rank == 4
    if usage is None:
        assert found.usage_figure_of_merit_sqrt is None
    else:
        assert found.usage_figure_of_merit_sqrt == pytest.approx(usage_printed, abs=0.0006)


def test_repeating_the_roll_point_at_half_a_turn_costs_nothing() -> None:
    points = grid(np.linspace(-30, 30, 33), np.append(ROLL_DEG, 180.0))
    assert evaluate_design(*points, box(30)).figure_of_merit_sqrt == pytest.approx(1.989, abs=0.0006)


TUMBLE = np.deg2rad([90.0, -90.0, 0.0, 0.0, 0.0, 0.0]), np.deg2rad([0.0, 0.0, 0.0, 90.0, 180.0, -90.0])


def test_six_point_tumble_has_two_thirds_everywhere() -> None:
    anywhere = np.random.default_rng(2).uniform(-np.pi, np.pi, (2, 200))
    np.testing.assert_allclose(variance_function(*TUMBLE, *anywhere), 2.0 / 3.0, rtol=1e-12)


def test_four_point_tumble_without_roll_has_three_quarters_everywhere() -> None:
    model, pitch = PitchOnly("x"), np.deg2rad([-90.0, 0.0, 90.0, 180.0])
    attitude = Attitude(pitch, np.zeros(4))
    inverse = factor(model.basis(attitude), model.primary_names, attitude).unscaled_covariance
    anywhere = model.basis(Attitude(np.linspace(-3, 3, 50), np.zeros(50)))
    np.testing.assert_allclose(np.einsum("ni,ij,nj->n", anywhere, inverse, anywhere), 0.75, rtol=1e-12)


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    axis=st.sampled_from("xyz"),
    sensitivity=st.floats(0.1, 10.0),
    coning_deg=st.floats(0.5, 60.0),
    azimuth_deg=st.floats(-180.0, 180.0),
)
def test_variance_is_free_of_offset_sensitivity_coning_and_azimuth(
    seed: int, axis: str, sensitivity: float, coning_deg: float, azimuth_deg: float
) -> None:
    """TP theorems I to III: h R⁻¹ hᵀ of (52) with the derivatives by b, S, Ω and A themselves, at any of their values
    and for each of the three sensors, is one and the same function of the points."""
    rng = np.random.default_rng(seed)
    points, anywhere = rng.uniform(-1.5, 1.5, (2, 15)), rng.uniform(-3.0, 3.0, (2, 8))
    parameters = np.array([rng.normal(), -sensitivity, np.deg2rad(coning_deg), np.deg2rad(azimuth_deg)])
    h = 1e-30
    by_parameters = [primary_from_parameters(axis, parameters + 1j * h * unit).imag / h for unit in np.eye(4)]
    slopes, wanted = (
        PitchRoll(axis).basis(Attitude(*at)) @ np.stack(by_parameters, axis=1) for at in (points, anywhere)
    )
    triangle = np.linalg.qr(slopes, mode="r")
    expected = np.sum(np.linalg.solve(triangle.T, wanted.T) ** 2, axis=0)
    np.testing.assert_allclose(variance_function(*points, *anywhere), expected, rtol=1e-6)


def test_variance_is_free_of_roll_where_roll_is_uniform() -> None:
    """TP theorem IV."""
    roll = np.linspace(-np.pi, np.pi, 37)
    values = variance_function(*grid(np.array([-40.0, -10.0, 25.0])), np.full(37, 0.4), roll)
    np.testing.assert_allclose(values, values[0], rtol=1e-11)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10_000), low=st.floats(-90, 0), wide=st.floats(1, 180))
def test_maximum_is_never_below_a_fine_grid_and_hardly_above(seed: int, low: float, wide: float) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1.5, 1.5, 12), rng.uniform(-np.pi, np.pi, 12)
    area = AngleBox((np.deg2rad(low), np.deg2rad(low + wide)), (-2.0, 3.0))
    fine = np.meshgrid(np.linspace(*area.pitch_rad, 401), np.linspace(*area.roll_rad, 401))
    brute = variance_function(*points, *fine).max()
    found = max_variance(*points, area)
    assert brute * (1 - 1e-12) <= found <= brute * (1 + 2e-3)


def test_rank_counts_what_the_points_determine() -> None:
    assert design_rank(*grid(np.array([-30.0, 0.0, 30.0]))) == 4
    assert design_rank(*grid(np.array([-30.0, 0.0, 30.0]), np.array([0.0]))) == 3
    assert design_rank(*grid(np.array([20.0]), np.array([10.0]))) == 1
    with pytest.raises(DesignError, match="rank 3 of 4"):
        evaluate_design(*grid(np.array([-30.0, -10.0, 0.0, 30.0]), np.array([0.0])), box(30))


def test_a_box_upside_down_is_refused() -> None:
    with pytest.raises(DesignError, match=r"box: pitch: got 30° to -30°"):
        AngleBox((np.deg2rad(30), np.deg2rad(-30)))
