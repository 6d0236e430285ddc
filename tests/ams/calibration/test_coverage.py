"""Do the intervals hold the truth, do the tests ring as often as they say? Thousands of campaigns, all redrawn.

4 000 campaigns a scene here, held to 95 ± 1.5 % (4.4 standard errors of the count), 30 000 and ± 1 % in the soak. Six
replications; four do as well. Two or three replications have one or two degrees of freedom: their intervals are on the
safe side, because one that came out narrow by chance is widened to that of the noise inside the replications, and they
are held to that.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest
from _pytest.mark import ParameterSet
from estimated_temperature import Stacked, simulate_visits
from simulated_columns import NOISE_V, TRUTH, Scene, Simulated, force_of, simulate
from simulated_package import many_lines, simulate_packages

from ams.attitude.static import Angles, pitch_roll_from_three, pitch_roll_from_two, pitch_with_known_roll
from ams.calibration.solving.columns import SolvedColumns
from ams.models.accelerometer import PitchRoll
from ams.solve import mixed_model
from ams.statistics.intervals import confidence_halfwidth, prediction_halfwidth, t_quantile

READING_V = 0.5 * NOISE_V
BATCHES = 8
PRIMARY = ("offset_v", "k_x_v_per_g", "k_y_v_per_g", "k_z_v_per_g")
PLATEAUS_DEGC = (10.0, 20.0, 30.0, 20.0, 10.0, 30.0, 20.0, 10.0)
U_ACROSS_V_PER_G = 8.2e-7
"""Standard uncertainty of k_y and k_z from noise alone, six replications."""


def at_coning(standard_uncertainties: float) -> np.ndarray:
    return np.array([0.005, 2.5, standard_uncertainties * U_ACROSS_V_PER_G, 0.0])


SCENES = {
    "noise": Scene(),
    "lack of fit": Scene(lack_of_fit=3.0),
    "drift": Scene(drift=4.0),
    "lack of fit and drift": Scene(lack_of_fit=3.0, drift=4.0),
    "table": Scene(index_limit_arcsec=1.0),
    "table, lack of fit and drift": Scene(index_limit_arcsec=1.0, lack_of_fit=1.5, drift=2.0),
    "temperature": Scene(temperature=True),
    "unbalanced": Scene(lack_of_fit=3.0, drift=4.0, dropped=0.1),
    "small coning": Scene(truth=at_coning(5.0)),
}


IN_EVERY_CHANGE = ("noise", "table, lack of fit and drift", "temperature", "unbalanced")
"""Each error, at least once beside others."""


def _others() -> list[ParameterSet]:
    return [pytest.param(name, marks=pytest.mark.thorough) for name in SCENES if name not in IN_EVERY_CHANGE]


def attitudes(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    return rng.uniform(-1.2, 1.2, 3), rng.uniform(-3.1, 3.1, 3)


def of_primary(solved: SolvedColumns | Stacked, truth: np.ndarray) -> dict[str, np.ndarray]:
    """Whether each 95 % interval of b and k holds the truth, one entry a campaign."""
    half = t_quantile(0.95, solved.primary_dof) * np.sqrt(np.diagonal(solved.primary_covariance, axis1=1, axis2=2))
    return {name: abs(solved.primary[:, i] - truth[i]) < half[:, i] for i, name in enumerate(PRIMARY)}


def of_parameters(simulated: Simulated) -> dict[str, np.ndarray]:
    """Of b, k, S, coning and azimuth; NaN where the parameter is null."""
    solved, truth = simulated.solved, simulated.truth
    hits = of_primary(solved, truth)
    derived, edges = PitchRoll("x").parameters(truth), solved.parameters
    for i, name in ((1, "sensitivity"), (2, "coning"), (3, "azimuth")):
        inside = (abs(edges.values[:, i] - derived[i]) < edges.halfwidths_95[:, i]).astype(float)
        hits[name] = np.where(np.isnan(edges.values[:, i]), np.nan, inside)
    return hits


def of_outputs(solved: SolvedColumns | Stacked, truth: np.ndarray, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Of the output and of new readings at three attitudes, at the reference temperature."""
    pitch, roll = attitudes(rng)
    phi, components = force_of(pitch, roll), solved.components
    phi = np.column_stack([phi, np.zeros((3, solved.primary.shape[1] - 4))])
    error = (solved.primary[:, :4] - truth) @ phi[:, :4].T
    reading = error + READING_V * rng.standard_normal(error.shape)
    return {
        "calibrated output": (abs(error) < confidence_halfwidth(phi, components)).mean(axis=1),
        "new reading": (abs(reading) < prediction_halfwidth(phi, components, READING_V, np.inf)).mean(axis=1),
    }


def of_pitch(solved: SolvedColumns | Stacked, truth: np.ndarray, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Pitch from one new reading with the roll known, TP (76) to (82)."""
    count = solved.primary.shape[0]
    pitch, roll = rng.uniform(-1.2, 1.2, count), rng.uniform(-3.1, 3.1, count)
    reading = force_of(pitch, roll) @ truth + READING_V * rng.standard_normal(count)
    found = pitch_with_known_roll(many_lines(solved, READING_V), reading, roll)
    return {"inferred pitch": abs(found.pitch_rad - pitch) < found.pitch_half_95_rad}


def shares(scene: Scene, campaigns: int, seed: int = 0) -> dict[str, float]:
    """Share of intervals that hold the truth, by what they are of; a fresh pattern of missing rows in every batch."""
    rng = np.random.default_rng(seed)
    batches: list[dict[str, np.ndarray]] = []
    for _ in range(BATCHES):
        simulated = simulate(scene, campaigns // BATCHES, rng)
        solved, truth = simulated.solved, simulated.truth
        batches.append(of_parameters(simulated) | of_outputs(solved, truth, rng) | of_pitch(solved, truth, rng))
    return means(batches)


def means(batches: Sequence[Mapping[str, np.ndarray]]) -> dict[str, float]:
    return {name: float(np.nanmean(np.concatenate([batch[name] for batch in batches]))) for name in batches[0]}


def shares_of_angles(scene: Scene, campaigns: int, seed: int = 0) -> dict[str, float]:
    """The same of pitch and roll from one reading each of two and three axes."""
    rng = np.random.default_rng(seed)
    return means([_of_angles(scene, campaigns // BATCHES, rng) for _ in range(BATCHES)])


def _of_angles(scene: Scene, campaigns: int, rng: np.random.Generator) -> dict[str, np.ndarray]:
    simulated, hits = simulate_packages(scene, campaigns, rng), {}
    for axes in ("xyz", "xy", "xz"):
        low, high = (0.3, 2.8) if axes == "xz" else (-1.2, 1.2)
        pitch, roll = rng.uniform(-1.2, 1.2, campaigns), rng.uniform(low, high, campaigns)
        clean = force_of(pitch, roll) @ simulated.truth[["xyz".index(axis) for axis in axes]].T
        readings = clean + READING_V * rng.standard_normal(clean.shape)
        lines, package = simulated.lines(axes, READING_V), simulated.together(axes)
        infer = pitch_roll_from_three if len(axes) == 3 else pitch_roll_from_two
        hits |= _held(axes, infer(lines, readings, package=package), pitch, roll)
    return hits


def _held(axes: str, found: Angles, pitch: np.ndarray, roll: np.ndarray) -> dict[str, np.ndarray]:
    flagged = np.array(found.flags) != ""
    assert set(found.flags) <= {"", "redundancy: outputs disagree"}
    assert flagged.mean() <= 0.01
    return {
        f"pitch by {axes}": abs(found.pitch_rad - pitch) < found.pitch_half_95_rad,
        f"roll by {axes}": abs(found.roll_rad - roll) < found.roll_half_95_rad,
    }


def shares_of_visits(visits: int, campaigns: int, seed: int = 0, **errors: float) -> dict[str, float]:
    """Temperature coefficients estimated from plateaus that were visited from both sides."""
    rng = np.random.default_rng(seed)
    solved = simulate_visits(PLATEAUS_DEGC[:visits], 1, campaigns, rng, **errors)
    return means([of_primary(solved, TRUTH) | of_outputs(solved, TRUTH, rng) | of_pitch(solved, TRUTH, rng)])


@pytest.mark.parametrize("scene", [*IN_EVERY_CHANGE, *_others()])
def test_intervals_hold_the_truth_in_95_percent_of_4000_campaigns(scene) -> None:
    found = shares(SCENES[scene], 4000)
    assert found == pytest.approx(dict.fromkeys(found, 0.95), abs=0.015), found


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.thorough
def test_angles_inferred_from_several_axes_hold_in_95_percent_of_4000_campaigns(scene) -> None:
    found = shares_of_angles(SCENES[scene], 4000)
    assert found == pytest.approx(dict.fromkeys(found, 0.95), abs=0.015), found


def test_angles_by_three_axes_hold_with_four_replications_that_drift() -> None:
    """Weights by each axis' own variance, from three degrees of freedom, made it 93 %."""
    found = shares_of_angles(replace(SCENES["drift"], replications=4), 4000, seed=2)
    assert found == pytest.approx(dict.fromkeys(found, 0.95), abs=0.015), found


@pytest.mark.parametrize(
    ("campaigns", "within"),
    [
        (300, 0.03),
        pytest.param(700, 0.02, marks=pytest.mark.thorough),
        pytest.param(4000, 0.015, marks=pytest.mark.soak),
    ],
    ids=str,
)
def test_with_estimated_temperature_coefficients_too(campaigns: int, within: float) -> None:
    """Six visits of three plateaus; across the axis Student's factor is that of along it, one degree of freedom less
    than there is."""
    found = shares_of_visits(6, campaigns, lack_of_fit=3.0)
    assert found == pytest.approx(dict.fromkeys(found, 0.95), abs=within), found


def test_axes_taken_as_independent_lose_what_the_table_does_to_all_of_them() -> None:
    """Indices of ±10″ and hardly any noise: roll by y and z has the error of the index, not its part by √2."""
    rng = np.random.default_rng(0)
    simulated = simulate_packages(Scene(index_limit_arcsec=10.0), 2000, rng)
    pitch, roll = rng.uniform(-0.5, 0.5, 2000), np.full(2000, np.pi / 4.0)
    readings = force_of(pitch, roll) @ simulated.truth.T
    lines = simulated.lines("xyz", 1e-9)
    for package, low, high in ((simulated.together("xyz"), 0.93, 0.97), (None, 0.6, 0.9)):
        found = pitch_roll_from_three(lines, readings, package)
        assert low < np.mean(abs(found.roll_rad - roll) < found.roll_half_95_rad) < high


@pytest.mark.soak
@pytest.mark.parametrize("scene", SCENES)
def test_intervals_hold_the_truth_in_95_percent_of_30000_campaigns(scene) -> None:
    found = shares(SCENES[scene], 30_000, seed=1) | shares_of_angles(SCENES[scene], 30_000, seed=1)
    assert found == pytest.approx(dict.fromkeys(found, 0.95), abs=0.01), found


@pytest.mark.soak
@pytest.mark.parametrize("errors", [{}, {"lack_of_fit": 3.0}], ids=["visits", "visits and lack of fit"])
def test_with_estimated_temperature_coefficients_in_10000_campaigns(errors) -> None:
    found = shares_of_visits(8, 10_000, seed=1, **errors)
    assert found == pytest.approx(dict.fromkeys(found, 0.95), abs=0.01), found


@pytest.mark.soak
@pytest.mark.parametrize("scene", SCENES)
def test_four_replications_do_as_well(scene) -> None:
    four = replace(SCENES[scene], replications=4)
    if scene == "small coning":
        four = replace(four, truth=at_coning(5.0 * np.sqrt(6.0 / 4.0)))
    found = shares(four, 10_000, seed=2) | shares_of_angles(four, 10_000, seed=2)
    assert found == pytest.approx(dict.fromkeys(found, 0.95), abs=0.015), found


@pytest.mark.parametrize("replications", [2, pytest.param(3, marks=pytest.mark.thorough)])
def test_with_two_or_three_replications_intervals_err_on_the_safe_side(replications) -> None:
    for name in ("noise", "lack of fit", "drift", "lack of fit and drift", "unbalanced"):
        found = shares(replace(SCENES[name], replications=replications), 2000)
        assert min(found.values()) > 0.93, (name, found)


@pytest.mark.parametrize("replications", [2, 3])
def test_the_narrowest_intervals_of_two_or_three_replications_hold_as_often_as_others(replications) -> None:
    """Widths vary by chance a hundredfold; by these alone 0.39 (two), 0.64 (three) of the narrowest hold an offset."""
    simulated = simulate(Scene(replications=replications), 4000, np.random.default_rng(5))
    edges, derived = simulated.solved.parameters, PitchRoll("x").parameters(simulated.truth)
    for i, name in enumerate(edges.names):
        half = edges.halfwidths_95[:, i]
        narrowest = half <= np.quantile(half, 0.05)
        held = abs(edges.values[narrowest, i] - derived[i]) < half[narrowest]
        assert held.mean() > 0.88, (name, held.mean())


@pytest.mark.parametrize(("replications", "allowed"), [(2, 1.06), (3, 1.15), (4, 1.0)])
def test_what_two_or_three_replications_say_is_not_given_away(replications, allowed, monkeypatch) -> None:
    scene = replace(SCENES["noise"], replications=replications)

    def mean_halfwidths() -> np.ndarray:
        solved = simulate(scene, 2000, np.random.default_rng(6)).solved
        return np.asarray(solved.parameters.halfwidths_95.mean(axis=0))

    now = mean_halfwidths()
    monkeypatch.setattr(mixed_model, "no_less_than_noise", lambda spread, *_: spread)
    assert np.all(now <= allowed * mean_halfwidths() * (1.0 + 1e-12))


def test_the_pooled_form_of_tp_holds_the_truth_in_half_of_the_campaigns_with_lack_of_fit_and_drift() -> None:
    """MATH 5: 42 to 60 %; why the mixed model is what is reported."""
    solved = simulate(SCENES["lack of fit and drift"], 2000, np.random.default_rng(0)).solved
    half = t_quantile(0.95, float(solved.degrees_of_freedom)) * np.sqrt(
        np.diagonal(solved.tp_primary_covariance, axis1=1, axis2=2)
    )
    held = np.mean(abs(solved.primary - TRUTH) < half, axis=0)
    assert np.all(held < 0.70)


@pytest.mark.parametrize("standard_uncertainties", [0.0, 1.0])
def test_a_coning_angle_near_zero_is_null_and_the_vector_still_holds(standard_uncertainties) -> None:
    simulated = simulate(Scene(truth=at_coning(standard_uncertainties)), 4000, np.random.default_rng(0))
    hits = of_parameters(simulated)
    assert np.mean(np.isnan(hits["coning"])) > 0.98
    for name in ("k_y_v_per_g", "k_z_v_per_g"):
        assert hits[name].mean() == pytest.approx(0.95, abs=0.015)


@pytest.mark.soak
@pytest.mark.parametrize("standard_uncertainties", [5.0, 6.0, 7.0, 10.0])
def test_coning_and_azimuth_hold_from_five_standard_uncertainties_on(standard_uncertainties) -> None:
    hits = of_parameters(simulate(Scene(truth=at_coning(standard_uncertainties)), 20_000, np.random.default_rng(0)))
    for name in ("coning", "azimuth"):
        assert np.nanmean(hits[name]) == pytest.approx(0.95, abs=0.015)


# False alarms and power


def alarms(scene: Scene, campaigns: int, seed: int = 0) -> tuple[dict[str, float], dict[str, float], float]:
    """Share of tests above their limit, default and TP's by name, and of campaigns with any significant after Holm."""
    replication = simulate(scene, campaigns, np.random.default_rng(seed)).solved.replication
    assert replication is not None
    tests = {"lack of fit": replication.lack_of_fit, **replication.drift}
    tp = {"lack of fit": replication.tp.bias, **replication.tp.drift}
    default, of_tp = (
        {name: float(np.mean(entry.t > entry.f_95)) for name, entry in kind.items()} for kind in (tests, tp)
    )
    return default, of_tp, float(np.mean(np.any([test.is_significant for test in tests.values()], axis=0)))


def test_default_tests_ring_falsely_in_one_of_twenty() -> None:
    default, _, any_after_holm = alarms(Scene(), 4000)
    assert default == pytest.approx(dict.fromkeys(default, 0.05), abs=0.015)
    assert any_after_holm == pytest.approx(0.05, abs=0.015)


@pytest.mark.parametrize("dropped", [0.0, 0.1])
def test_drift_tests_keep_their_false_alarms_under_lack_of_fit_where_tps_never_ring(dropped) -> None:
    default, tp, _ = alarms(Scene(lack_of_fit=3.0, dropped=dropped), 4000)
    assert default.pop("lack of fit") == 1.0
    assert default == pytest.approx(dict.fromkeys(default, 0.05), abs=0.015)
    tp.pop("lack of fit")
    assert max(tp.values()) < 0.005


def test_the_lack_of_fit_test_keeps_its_false_alarms_under_drift() -> None:
    default, _, _ = alarms(Scene(drift=4.0), 4000)
    assert default["lack of fit"] == pytest.approx(0.05, abs=0.015)


@pytest.mark.parametrize("lack_of_fit", [0.0, 3.0])
@pytest.mark.parametrize("drift", [1.0, 2.0])
@pytest.mark.thorough
def test_power_against_a_drift_is_what_theory_says_whatever_the_lack_of_fit(lack_of_fit, drift) -> None:
    """T / (1 + δ²) is F(n − 1, (n − 1)(K − 4)) where replications wander by δ standard errors (a random effect)."""
    from scipy.stats import f

    default, tp, _ = alarms(Scene(lack_of_fit=lack_of_fit, drift=drift), 4000)
    n, points = 6, 42
    dof = n - 1, (n - 1) * (points - 4)
    power = f.sf(f.ppf(0.95, *dof) / (1.0 + drift**2), *dof)
    assert default["offset"] == pytest.approx(power, abs=0.025)
    assert default["sensitivity"] == pytest.approx(power, abs=0.025)
    if lack_of_fit:
        assert tp["offset"] < 0.5 * power


@pytest.mark.soak
def test_false_alarms_of_all_default_tests_in_40000_campaigns() -> None:
    for scene in (Scene(), Scene(lack_of_fit=3.0), Scene(dropped=0.1, lack_of_fit=3.0), Scene(replications=3)):
        default, _, _ = alarms(scene, 40_000)
        if scene.lack_of_fit:
            default.pop("lack of fit")
        assert default == pytest.approx(dict.fromkeys(default, 0.05), abs=0.006)
