"""Visits of temperature plateaus: found, counted as whole plots, and carried into intervals that hold the truth."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_campaign import OFFSET_V, VECTOR_V_PER_G, Campaign

from ams.calibration.calibrate import calibrate
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from ams.solve.layout import layout_of
from ams.solve.whole_plots import visit_warnings, visits_of, whole_plots
from ams.statistics.intervals import t_quantile

OFFSET_TC, SENSITIVITY_TC = 3e-5, 2e-4
POINTS = 12
GRID = {"pitch_deg": np.array([-60.0, 0.0, 60.0]), "roll_deg": np.array([-180.0, -90.0, 0.0, 90.0])}


def visited(plateaus_degc, per_visit: int, seed: int, plot_v: float = 2e-5, plot_share: float = 1e-5) -> Observations:
    """Every visit shifts offset and sensitivity by its own amount, and so does the temperature."""
    rng = np.random.default_rng(seed)
    visits, rows = len(plateaus_degc), len(plateaus_degc) * per_visit * POINTS
    observations = Campaign(replications=visits * per_visit, noise_arcsec=0.3, **GRID).observe(rng)
    visit = np.repeat(np.arange(visits), per_visit * POINTS)
    temperature = np.array(plateaus_degc)[visit] + rng.uniform(-0.3, 0.3, rows)
    rise, sensed = temperature - 25.0, observations.outputs["x"] - OFFSET_V["x"]
    shift = rng.normal(0.0, plot_v, visits)[visit] + rng.normal(0.0, plot_share, visits)[visit] * sensed
    output = observations.outputs["x"] + OFFSET_TC * rise + SENSITIVITY_TC * rise * sensed + shift
    return replace(observations, outputs={"x": output}, temperature_degc=temperature)


ESTIMATE = CalibrationRequest(temperature="estimate", reference_temperature_degc=25.0, extended="no")


def test_visits_are_found_in_the_order_of_time_and_not_of_the_rows() -> None:
    observations = visited([15.0, 35.0, 15.0], 2, 0)
    found = visits_of(observations)
    assert found is not None
    np.testing.assert_array_equal(found.index, np.repeat([0, 1, 2], 2 * POINTS))
    assert found.plateau_degc == pytest.approx((15.0, 35.0, 15.0), abs=0.1)
    backwards = replace(observations, time_s=-np.arange(observations.rows, dtype=float))
    again = visits_of(backwards)
    assert again is not None
    np.testing.assert_array_equal(again.index, np.repeat([2, 1, 0], 2 * POINTS))


def test_a_temperature_that_wanders_or_stays_has_no_visits() -> None:
    observations = visited([15.0, 35.0], 2, 0)
    rows = observations.rows
    assert visits_of(replace(observations, temperature_degc=np.linspace(15.0, 35.0, rows))) is None
    assert visits_of(replace(observations, temperature_degc=np.full(rows, 20.0))) is None
    assert visits_of(replace(observations, temperature_degc=None)) is None


def test_the_covariance_counts_visits_not_the_replications_inside_them() -> None:
    observations = visited([15.0, 25.0, 35.0, 25.0, 15.0], 4, 1)
    solved = calibrate(observations, ESTIMATE).axes["x"]
    part = solved.variance_components[0]
    assert (part.name, part.dof) == ("whole plots", 5 - 1 - 1)
    layout = layout_of(observations)
    assert whole_plots(layout, None, ()).dof == 19
    assert whole_plots(layout, visits_of(observations), ()).dof == 4


def test_replications_across_the_plateaus_stay_what_is_counted() -> None:
    """Each replication goes through all plateaus: then replications are the independent repeats."""
    observations = visited([15.0, 35.0, 15.0, 35.0], 1, 1)
    relabelled = replace(
        observations,
        replication=(observations.replication + 1) // 2,
        point=observations.point + 100 * (observations.replication % 2),
    )
    plots = whole_plots(layout_of(relabelled), visits_of(relabelled), ())
    assert (plots.count, plots.is_replications) == (2, True)


def test_one_visit_a_plateau_or_one_side_only_is_said() -> None:
    def warnings(*plateaus_degc: float) -> str:
        observations = visited(plateaus_degc, 2, 0)
        found = visits_of(observations)
        assert found is not None
        return " ".join(visit_warnings(layout_of(observations), found))

    assert "visited once only" in warnings(15.0, 25.0, 35.0)
    assert "one side only" in warnings(15.0, 25.0, 35.0, 15.0, 25.0, 35.0)
    assert warnings(15.0, 25.0, 35.0, 25.0, 15.0) == ""


def test_of_two_plateaus_is_said_what_they_cannot_tell_and_not_that_a_side_is_missing() -> None:
    """Between two plateaus there is one way up and one down, in whatever order they are visited."""
    found = visits_of(rows := visited((15.0, 35.0, 15.0, 35.0), 2, 0))
    assert found is not None
    (said,) = visit_warnings(layout_of(rows), found)
    assert "the warmer is reached by warming and the colder by cooling, always" in said
    assert "side" not in said
    assert "add a plateau between them" in said
    found = visits_of(rows := visited((15.0, 35.0), 2, 0))
    assert found is not None
    assert "more than once, one between them and from both sides" in visit_warnings(layout_of(rows), found)[0]


def held(plateaus_degc, per_visit: int, request: CalibrationRequest, campaigns: int, **errors: float) -> np.ndarray:
    """Share of campaigns whose intervals of b, k and the temperature coefficients hold the truth."""
    hits = []
    for seed in range(campaigns):
        solved = calibrate(visited(plateaus_degc, per_visit, seed, **errors), request).axes["x"]
        truth = np.array([OFFSET_V["x"], *VECTOR_V_PER_G["x"], OFFSET_TC, SENSITIVITY_TC])
        half = t_quantile(0.95, solved.primary_dof) * np.sqrt(np.diag(solved.primary_covariance))
        hits.append(np.abs(solved.primary - truth) < half)
    return np.mean(hits, axis=0)


@pytest.mark.thorough
def test_intervals_hold_the_truth_when_every_visit_has_an_error_of_its_own() -> None:
    """Counting the twelve replications instead of the six visits holds b, k_x and the terms in 69 to 78 %."""
    share = held([15.0, 25.0, 35.0, 25.0, 15.0, 35.0], 2, ESTIMATE, 200)
    assert share.min() > 0.90
    assert share.mean() == pytest.approx(0.95, abs=0.02)


@pytest.mark.soak
@pytest.mark.parametrize("per_visit", [1, 3])
@pytest.mark.parametrize("plot_v", [0.0, 2e-5])
def test_intervals_hold_the_truth_whatever_the_visits_do(per_visit: int, plot_v: float) -> None:
    share = held([15.0, 25.0, 35.0, 25.0, 15.0, 35.0], per_visit, ESTIMATE, 3000, plot_v=plot_v, plot_share=plot_v / 2)
    assert share.min() > 0.935
    assert share.max() < 0.985  # across the axis a contrast is given up for a slope that is not there
