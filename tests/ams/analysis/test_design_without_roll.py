"""Designs without roll: TP's tumble, the theorems, and Monte Carlo for the expected uncertainties."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ams.analysis.design_without_roll import evaluate_without_roll, variance_without_roll
from ams.errors import DesignError

CARDINAL = np.deg2rad([-90.0, 0.0, 90.0, 180.0])  # TP (57)


@given(st.floats(-np.pi, np.pi))
def test_the_four_point_tumble_has_variance_three_quarters_everywhere(pitch_rad):
    """TP 4.4: without roll, 3/4."""
    assert variance_without_roll(CARDINAL, np.array([pitch_rad]))[0] == pytest.approx(0.75, abs=1e-12)


def test_the_tumbles_figures_are_those_of_a_constant():
    figures = evaluate_without_roll(CARDINAL, (-np.pi / 2, np.pi), (-0.1, 0.1))
    assert figures.figure_of_merit_sqrt == pytest.approx(np.sqrt(4 * 0.75))
    assert figures.usage_figure_of_merit_sqrt == pytest.approx(np.sqrt(4 * 0.75))
    assert figures.max_variance == pytest.approx(0.75)


def test_the_mean_over_the_points_is_the_number_of_parameters():
    """The trace of the hat matrix: the variance function summed over a design's own points is 3."""
    pitch_rad = np.deg2rad(np.arange(-36.0, 37.0, 2.0))
    assert variance_without_roll(pitch_rad, pitch_rad).sum() == pytest.approx(3.0, abs=1e-9)


@given(st.lists(st.floats(-3.0, 3.0), min_size=6, max_size=12, unique_by=lambda angle: round(angle, 1)))
def test_no_place_in_the_range_has_more_than_the_largest_variance(angles):
    pitch_rad = np.array(angles)
    range_rad = (float(pitch_rad.min()), float(pitch_rad.max()))
    largest = evaluate_without_roll(pitch_rad, range_rad).max_variance
    anywhere = variance_without_roll(pitch_rad, np.linspace(*range_rad, 20_011))
    assert anywhere.max() <= largest * (1.0 + 1e-7)
    assert largest <= anywhere.max() * (1.0 + 1e-4)


def test_two_points_cannot_determine_three_parameters():
    with pytest.raises(DesignError):
        evaluate_without_roll(np.array([-0.5, 0.5]), (-0.5, 0.5))
