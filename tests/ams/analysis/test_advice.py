"""Advice: planted patterns and drifts are named with their size, and noise is given no name."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import linregress
from simulated_campaign import ARCSEC, Campaign

from ams.analysis.advice import Advice, advise
from ams.analysis.fourier_terms import fourier_basis, largest_terms
from ams.calibration.calibrate import calibrate
from ams.inputs.request import CalibrationRequest, select_rows
from ams.models.cr import model_gravity_g, sting_gravity_g
from ams.observations import Observations

WHOLE_TURN = Campaign(
    pitch_deg=np.arange(-180.0, 181.0, 20.0), roll_deg=np.arange(-180.0, 151.0, 30.0), replications=4, noise_arcsec=0.5
)
ARCSEC_V = 2.5 * ARCSEC


def observe(campaign: Campaign = WHOLE_TURN, seed: int = 0, **added_v: float) -> Observations:
    """With terms added to the output of x, volts, by name (``sin2α_cosR`` for ``sin 2α·cos R``)."""
    observations = campaign.observe(np.random.default_rng(seed))
    columns = fourier_basis(observations.pitch_rad, observations.roll_rad)
    terms = {name.replace(" ", ""): column for name, column in columns.items()}
    extra = sum(size * terms[name.replace("_", "·")] for name, size in added_v.items())
    return replace(observations, outputs={"x": observations.outputs["x"] + extra})


def grid() -> tuple[np.ndarray, np.ndarray]:
    axes = np.meshgrid(np.deg2rad(np.arange(-180.0, 181.0, 30.0)), np.deg2rad(np.arange(0.0, 360.0, 45.0)))
    return axes[0].ravel(), axes[1].ravel()


def tp_basis(pitch: np.ndarray, roll: np.ndarray) -> np.ndarray:
    ones, level = np.ones_like(pitch), np.cos(pitch)
    return np.stack([ones, np.sin(pitch), level * np.sin(roll), level * np.cos(roll)], axis=1)


def advice(observations: Observations) -> Advice:
    return advise(calibrate(observations, CalibrationRequest(extended="no")).axes["x"], observations)


def test_planted_terms_are_named_with_their_amplitude_and_cause() -> None:
    found = advice(observe(sin2α=3.0 * ARCSEC_V, sin2α_cosR=-2.0 * ARCSEC_V, cosα=1.0 * ARCSEC_V))
    assert [term.name for term in found.lack_of_fit] == ["sin 2α", "sin 2α·cos R", "cos α"]
    for term, arcsec in zip(found.lack_of_fit, (3.0, -2.0, 1.0), strict=True):
        assert term.amplitude_deg * 3600.0 == pytest.approx(arcsec, abs=0.15)
        assert term.interval_95_deg[0] < arcsec / 3600.0 < term.interval_95_deg[1]
        assert term.amplitude_v == pytest.approx(np.deg2rad(term.amplitude_deg) * 2.5, rel=1e-3)
    assert "soft mount" in found.lack_of_fit[1].cause
    assert re.match(r"The residuals repeat as sin 2α with 3″ \(3[67] µV; 95 %: \S+ to \S+\): ", found.sentences[0])
    assert any("only a second calibration with the package mounted the other way round" in s for s in found.sentences)


@pytest.mark.parametrize("reach_deg", [45.0, 90.0])
def test_a_term_that_the_model_half_imitates_is_given_whole(reach_deg) -> None:
    campaign = replace(WHOLE_TURN, pitch_deg=np.linspace(-reach_deg, reach_deg, 19))
    term = advice(observe(campaign, sin2α=30.0 * ARCSEC_V)).lack_of_fit[0]
    assert term.name == "sin 2α"
    low, high = term.interval_95_deg
    assert low < 30.0 / 3600.0 < high


def test_missing_points_change_nothing_but_the_width() -> None:
    observations = observe(sin2α=3.0 * ARCSEC_V)
    kept = np.random.default_rng(1).uniform(size=observations.rows) > 0.1
    found = advice(select_rows(observations, kept)).lack_of_fit[0]
    assert (found.name, found.amplitude_deg * 3600.0) == ("sin 2α", pytest.approx(3.0, abs=0.15))


def test_noise_has_no_term_and_single_teeth_have_no_pattern() -> None:
    assert advice(observe()) == Advice((), (), ())
    teeth = advice(observe(replace(WHOLE_TURN, lack_of_fit_arcsec=2.0)))
    assert teeth.lack_of_fit == ()
    assert "no regular pattern" in teeth.sentences[0]


def test_false_terms_come_in_one_campaign_of_twenty() -> None:
    pitch, roll = grid()
    candidates, rng = fourier_basis(pitch, roll), np.random.default_rng(2)
    basis = tp_basis(pitch, roll)
    found = [bool(largest_terms(rng.standard_normal(pitch.size), basis, candidates, 1)) for _ in range(1000)]
    assert np.mean(found) == pytest.approx(0.05, abs=0.02)


def test_intervals_of_a_planted_term_hold_it() -> None:
    """With a pattern well above the noise, so that the search finds it every time."""
    pitch, roll = grid()
    candidates, rng, hits = fourier_basis(pitch, roll), np.random.default_rng(3), []
    basis = tp_basis(pitch, roll)
    for _ in range(1000):
        output = 2.0 * candidates["cos 2α"] + rng.standard_normal(pitch.size)
        term = largest_terms(output, basis, candidates, 1)[0]
        hits.append(term.name == "cos 2α" and term.interval_95_v[0] < 2.0 < term.interval_95_v[1])
    assert np.mean(hits) == pytest.approx(0.95, abs=0.02)


def test_the_interval_of_a_term_counts_it_among_what_was_fitted() -> None:
    """Of nine points: the textbook's regression on model and term together, with 9 − 4 degrees of freedom."""
    pitch = np.deg2rad(np.arange(-160.0, 161.0, 40.0))
    basis = np.stack([np.ones_like(pitch), np.sin(pitch), np.cos(pitch)], axis=1)
    columns = {"sin 2α": np.sin(2.0 * pitch)}
    output = 30.0 * columns["sin 2α"] + np.random.default_rng(2).standard_normal(pitch.size)
    (term,) = largest_terms(output, basis, columns, 1)
    whole = np.column_stack([basis, columns["sin 2α"]])
    answer, rest = np.linalg.lstsq(whole, output, rcond=None)[:2]
    half = 2.5706 * np.sqrt(rest[0] / 5.0 * np.linalg.inv(whole.T @ whole)[3, 3])  # t of GUM table G.2, 5, 95 %
    assert term.amplitude_v == pytest.approx(answer[3], rel=1e-9)
    assert np.diff(term.interval_95_v)[0] == pytest.approx(2.0 * half, rel=1e-4)


def test_of_terms_that_are_alike_on_the_grid_the_simplest_is_named() -> None:
    """At roll 0° and 180° alone cos 2R is one everywhere, and sin 2α·cos 2R is sin 2α."""
    pitch, roll = (a.ravel() for a in np.meshgrid(np.deg2rad(np.arange(-180.0, 180.0, 20.0)), [0.0, np.pi]))
    basis = np.stack([np.ones_like(pitch), np.sin(pitch), np.cos(pitch) * np.cos(roll)], axis=1)
    output = np.sin(2.0 * pitch) + 1e-3 * np.random.default_rng(0).standard_normal(pitch.size)
    assert largest_terms(output, basis, fourier_basis(pitch, roll), 1)[0].name == "sin 2α"


def creeping(step_v: float, timed: bool) -> Observations:
    observations = observe(replace(WHOLE_TURN, replications=5))
    output = observations.outputs["x"] + step_v * (observations.replication - 1)
    time_s = np.linspace(0.0, 10.0 * 3600.0, observations.rows) if timed else None
    return replace(observations, outputs={"x": output}, time_s=time_s)


def test_a_drift_is_given_a_replication_and_an_hour() -> None:
    rate = advice(creeping(1e-5, timed=True)).drift[0]
    assert rate.parameter == "offset_v"
    assert rate.per_replication == pytest.approx(1e-5, rel=0.05)
    assert rate.interval_95[0] < 1e-5 < rate.interval_95[1]
    assert rate.per_hour == pytest.approx(1e-5 / 2.0, rel=0.05)
    untimed = advice(creeping(-1e-5, timed=False))
    assert untimed.drift[0].per_hour is None
    assert re.match(r"Offset drifts by −\S+ µV a replication \(95 %: −\S+ to −\S+\)\.$", untimed.sentences[0])


def test_the_interval_of_a_drift_is_that_of_a_straight_line_through_the_replications() -> None:
    """By scipy's regression and Student's t of GUM table G.2 with 5 − 2 degrees of freedom."""
    observations = creeping(1e-5, timed=False)
    axis = calibrate(observations, CalibrationRequest(extended="no")).axes["x"]
    assert axis.replication is not None
    offsets = [row["offset_v"] for row in axis.replication.per_replication.values()]
    line = linregress(np.arange(5.0), offsets)
    rate = advise(axis, observations).drift[0]
    assert rate.per_replication == pytest.approx(line.slope, rel=1e-9)
    assert rate.interval_95 is not None
    assert np.diff(rate.interval_95)[0] == pytest.approx(2.0 * 3.1824 * line.stderr, rel=1e-4)


def test_a_change_without_a_trend_is_not_called_a_drift() -> None:
    observations = observe(replace(WHOLE_TURN, replications=5))
    jumps = np.array([0.0, 3e-5, -3e-5, 2e-5, 0.0])[observations.replication - 1]
    found = advice(replace(observations, outputs={"x": observations.outputs["x"] + jumps}))
    assert "changes between the replications without a trend" in found.sentences[0]


def test_two_replications_have_a_rate_and_no_interval() -> None:
    observations = observe(replace(WHOLE_TURN, replications=2))
    moved = observations.outputs["x"] + 1e-5 * observations.replication
    rate = advice(replace(observations, outputs={"x": moved})).drift[0]
    assert rate.interval_95 is None
    assert rate.per_replication == pytest.approx(1e-5, rel=0.1)


def test_on_a_gimbal_the_terms_are_those_of_what_the_package_feels() -> None:
    """2 q_xz f_x f_z = −q_xz sin 2α cos R, α and R those of the specific force, whatever yaw it comes from."""
    rows = WHOLE_TURN.observe(np.random.default_rng(0))
    yawed = replace(rows, yaw_rad=np.deg2rad(25.0 * (rows.point % 3 - 1.0)))
    force = -model_gravity_g(sting_gravity_g(yawed.pitch_rad, yawed.yaw_rad), yawed.roll_rad)
    noise = 0.5 * ARCSEC_V * np.random.default_rng(1).standard_normal(rows.rows)
    output = 0.005 + force @ [2.5, 0.02, -0.01] - 2.0 * 3.0 * ARCSEC_V * force[:, 0] * force[:, 2] + noise
    measured = replace(yawed, outputs={"x": output})
    axis = calibrate(measured, CalibrationRequest(model="pitch-yaw-roll-model", extended="no")).axes["x"]
    (term,) = advise(axis, measured).lack_of_fit
    assert term.name == "sin 2α·cos R"
    assert term.amplitude_deg * 3600.0 == pytest.approx(3.0, abs=0.15)


def test_a_straight_line_is_told_of_the_misalignment_that_it_leaves_out() -> None:
    rows = WHOLE_TURN.observe(np.random.default_rng(0))
    axis = calibrate(
        rows, CalibrationRequest(model="linear-accelerometer", nominal_axes={"x": "x"}, extended="no")
    ).axes["x"]
    found = advise(axis, rows).lack_of_fit
    assert {term.name for term in found} == {"cos α·sin R", "cos α·cos R"}
    assert all("misalignment of the sensor" in term.cause for term in found)
    sides = [term.amplitude_deg for term in found]
    assert np.hypot(*sides) == pytest.approx(np.rad2deg(np.tan(np.deg2rad(0.5))), rel=0.05)
