"""The check sensor tells its own changes from those of the table and of the meter."""

from collections.abc import Callable
from dataclasses import replace
from datetime import timedelta

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ams.archive.histories import with_rig_causes
from ams.archive.synthetic import CHECK_SENSOR, RIG, START, Story, synthetic_archive
from ams.surveillance.characteristics import PackageNumbers, characteristics_of
from ams.surveillance.check_chart import CheckHistory, check_history, check_sensors, unexplained_changes
from ams.surveillance.check_components import variance_of_families
from ams.surveillance.control_chart import history_of
from ams.surveillance.series import PointLabel, Population
from ams.surveillance.stated_changes import StatedScatter
from ams.units import RAD_PER_ARCSEC

CAMPAIGN = 9
FloatArray = NDArray[np.float64]
Disturbed = Callable[[int, np.random.Generator], tuple[float, FloatArray]]
Change = Callable[[NDArray[np.float64]], NDArray[np.float64]]
STORY = Story(sensors=12, drift_arcsec_per_year=0.0, drop_arcsec=0.0)


def from_campaign(change: Change, *, everybody: bool, seed: int = 1) -> Population:
    """From one campaign on, the (3, 4) numbers of all sensors or of the check sensor alone are changed."""
    population = synthetic_archive(np.random.default_rng(seed), STORY).population
    primary = population.numbers.primary.copy()
    for index, label in enumerate(population.labels):
        assert label.run_id is not None
        if int(label.run_id.removeprefix("campaign-")) >= CAMPAIGN and (everybody or label.sensor == CHECK_SENSOR):
            primary[index] = change(primary[index])
    return Population(population.labels, replace(population.numbers, primary=primary))


def gain(primary: NDArray[np.float64]) -> NDArray[np.float64]:
    return primary * np.array([1.0, 1.0002, 1.0002, 1.0002])


def offset(primary: NDArray[np.float64]) -> NDArray[np.float64]:
    return primary + np.array([5e-4, 0.0, 0.0, 0.0])


def tilt(primary: NDArray[np.float64]) -> NDArray[np.float64]:
    turned = Rotation.from_rotvec([0.0, 0.02, 0.0], degrees=True).apply(primary[:, 1:])
    return np.concatenate([primary[:, :1], turned], axis=1)


def one_axis(primary: NDArray[np.float64]) -> NDArray[np.float64]:
    return primary * np.array([[1.0, 1.0005, 1.0005, 1.0005], [1.0] * 4, [1.0] * 4])


def causes(found: CheckHistory) -> set[tuple[str, str]]:
    at = f"campaign-{CAMPAIGN:02d}"
    assert {finding.at.run_id for finding in found.findings} <= {at}, found.findings
    return {(finding.cause, finding.component.partition(" ")[0]) for finding in found.findings}


@pytest.mark.parametrize(
    ("change", "everybody", "cause", "component"),
    [
        (gain, True, "meter", "meter"),
        (offset, True, "meter", "meter"),
        (gain, False, "sensor", "meter"),
        (offset, False, "sensor", "meter"),
        (tilt, True, "table", "table"),
    ],
)
def test_what_changed_is_named(change: Change, everybody: bool, cause: str, component: str) -> None:
    found = check_history(from_campaign(change, everybody=everybody), CHECK_SENSOR)
    assert causes(found) == {(cause, component)}


def test_a_check_sensor_whose_axes_part_company_is_itself_at_fault() -> None:
    found = check_history(from_campaign(one_axis, everybody=False), CHECK_SENSOR)
    assert {cause for cause, _ in causes(found)} == {"sensor"}


def test_a_quiet_rig_raises_nothing() -> None:
    alarms = 0
    for seed in range(40):
        population = synthetic_archive(np.random.default_rng(seed), STORY).population
        alarms += bool(check_history(population, CHECK_SENSOR).findings)
    assert alarms <= 4, alarms  # 16 runs at 0.2 %: 3 % of the archives


def test_an_alarm_of_a_sensor_is_told_with_what_the_check_sensor_says_of_the_meter() -> None:
    population = from_campaign(gain, everybody=True)
    sensor = population.labels[-1].sensor
    found = with_rig_causes(population, history_of(population, sensor))
    (step,) = [finding for finding in found.findings if finding.at.run_id == f"campaign-{CAMPAIGN:02d}"]
    assert step.rig_cause is not None
    assert "other sensors of that run changed alike" in step.rig_cause


def test_the_check_sensors_of_a_rig_are_known() -> None:
    population = synthetic_archive(np.random.default_rng(1), STORY).population
    assert check_sensors(population, RIG) == (CHECK_SENSOR,)
    assert check_sensors(population, "another rig") == ()


def of_check_sensor(seed: int, change: Callable[[NDArray[np.float64], int], NDArray[np.float64]]) -> Population:
    """The check sensor's (3, 4) numbers, changed campaign by campaign."""
    population = synthetic_archive(np.random.default_rng(seed), STORY).population
    primary = population.numbers.primary.copy()
    for index, label in enumerate(population.labels):
        if label.sensor == CHECK_SENSOR and label.run_id is not None:
            primary[index] = change(primary[index], int(label.run_id.removeprefix("campaign-")))
    return Population(population.labels, replace(population.numbers, primary=primary))


SIGMA = STORY.day_arcsec * RAD_PER_ARCSEC / np.sqrt(3.0)
"""Of the mean gain of three axes from run to run."""


@pytest.mark.parametrize("seed", range(4))
def test_a_drift_of_one_sigma_a_run_is_found(seed: int) -> None:
    def creeping(primary: NDArray[np.float64], campaign: int) -> NDArray[np.float64]:
        return primary * np.array([1.0, *[1.0 + SIGMA * campaign] * 3])

    found = check_history(of_check_sensor(seed, creeping), CHECK_SENSOR).findings
    assert min(int(str(entry.at.run_id)[-2:]) for entry in found) <= 11
    assert found[0].component == "meter gain"


@pytest.mark.parametrize("seed", range(4))
def test_a_step_of_five_sigma_is_found_within_three_runs(seed: int) -> None:
    def stepped(primary: NDArray[np.float64], campaign: int) -> NDArray[np.float64]:
        return primary * np.array([1.0, *[1.0 + 5.0 * SIGMA * (campaign >= CAMPAIGN)] * 3])

    found = check_history(of_check_sensor(seed, stepped), CHECK_SENSOR).findings
    assert CAMPAIGN <= min(int(str(entry.at.run_id)[-2:]) for entry in found) <= CAMPAIGN + 2


def test_a_run_is_charted_against_the_mean_of_those_before_it() -> None:
    found = check_history(from_campaign(gain, everybody=False), CHECK_SENSOR)
    chart = next(chart for chart in found.charts if chart.name == "meter gain")
    assert chart.centre_deg[5] == pytest.approx(chart.value_deg[:5].mean())
    assert chart.is_alarm[CAMPAIGN]
    assert chart.centre_deg[CAMPAIGN + 1] == pytest.approx(chart.value_deg[CAMPAIGN]), "a change begins anew"


def test_before_limits_exist_nothing_is_said_to_have_stayed_as_it_was() -> None:
    """A table that leaned by 0.2° in the third run: no limit, no all-clear, and the tilt is told."""
    population = synthetic_archive(np.random.default_rng(3), STORY).population
    kept = [index for index, label in enumerate(population.labels) if str(label.run_id) < "campaign-03"]
    primary = population.numbers.primary[kept].copy()
    labels = [population.labels[location] for location in kept]
    (last,) = [at for at, label in enumerate(labels) if label.sensor == CHECK_SENSOR and label.run_id == "campaign-02"]
    turned = Rotation.from_rotvec([0.0, 0.0, 0.2], degrees=True).apply(primary[last][:, 1:])
    primary[last] = np.concatenate([primary[last][:, :1], turned], axis=1)
    numbers = replace(
        population.numbers, primary=primary, covariance=population.numbers.covariance[kept],
        scatter=population.numbers.scatter[kept],
    )  # fmt: skip
    found = check_history(Population(labels, numbers), CHECK_SENSOR)
    assert (found.is_judged, found.differences, found.findings) == (False, 2, ())
    spread = (2.5 * STORY.noise_arcsec * RAD_PER_ARCSEC) ** 2
    told = unexplained_changes(found, [stated_by(primary[last], np.full((3, 4), spread), 3)] * 3)
    (said,) = [text for text in told if text.startswith("table tilt z")]
    assert float(said.removeprefix("table tilt z ").partition("°")[0]) == pytest.approx(0.2, abs=0.001)


@pytest.mark.parametrize(
    ("standard_errors", "cause"), [(2.0, "sensor"), (4.0, "meter"), (5.5, "meter"), (20.0, "meter")]
)
def test_what_the_other_sensors_show_beyond_chance_is_the_meters(standard_errors: float, cause: str) -> None:
    """Of ten witnesses a mean of 4 standard errors is chance in 0.3 % of the runs, one of 2 in 8 % (Student, 9 degrees
    of freedom). A change of so many, that the check sensor has too, is not laid to the check sensor."""
    change, witnesses = 12.0 * RAD_PER_ARCSEC, 10
    own = np.linspace(-1.0, 1.0, witnesses)
    own *= change / standard_errors * np.sqrt(witnesses) / np.std(own, ddof=1)
    population = synthetic_archive(np.random.default_rng(1), STORY).population
    primary, at = population.numbers.primary.copy(), f"campaign-{CAMPAIGN:02d}"
    here = [index for index, label in enumerate(population.labels) if label.run_id == at]
    others = [index for index in here if population.labels[index].sensor != CHECK_SENSOR]
    for index, size in zip(others[:witnesses], own, strict=True):
        primary[index] = primary[index - 1] * np.array([1.0, *[1.0 + change + size] * 3])
    (check,) = set(here) - set(others)
    primary[check] = primary[check - 1] * np.array([1.0, *[1.0 + change] * 3])
    kept = [index for index in range(len(population.labels)) if index not in others[witnesses:]]
    parts = {name: getattr(population.numbers, name)[kept] for name in ("covariance", "scatter")}
    numbers = replace(population.numbers, primary=primary[kept], **parts)
    found = check_history(Population([population.labels[index] for index in kept], numbers), CHECK_SENSOR)
    (said,) = [finding for finding in found.findings if finding.at.run_id == at]
    assert (said.cause, said.component) == (cause, "meter gain")


DAY = timedelta(days=90)


def alone(
    runs: int, seed: int, disturbed: Callable[[int, np.random.Generator], tuple[float, FloatArray]]
) -> Population:
    """A check sensor that is the only one: what a run does to gain (relative) and attitude (radians), noise beside."""
    chance, noise = np.random.default_rng(seed), RAD_PER_ARCSEC
    k = np.eye(3) + chance.normal(0.0, 0.003, (3, 3))
    rows = []
    for run in range(runs):
        gain, turn = disturbed(run, chance)
        turned = Rotation.from_rotvec(turn).apply(k) * (1.0 + gain)
        rows.append(np.column_stack([np.zeros(3), turned]) + noise * chance.standard_normal((3, 4)))
    labels = [
        PointLabel(f"{run:064d}", CHECK_SENSOR, f"campaign-{run:02d}", START + run * DAY, RIG, True, 9.8)
        for run in range(runs)
    ]
    spread = np.broadcast_to(np.eye(4) * noise**2, (runs, 3, 4, 4)).copy()
    return Population(labels, PackageNumbers(("x", "y", "z"), np.stack(rows), spread, spread))


def days_of_a_meter(run: int, chance: np.random.Generator) -> tuple[float, FloatArray]:
    return 10.0 * RAD_PER_ARCSEC * float(chance.standard_normal()), np.zeros(3)


def days_of_a_base_that_leans_one_way(run: int, chance: np.random.Generator) -> tuple[float, FloatArray]:
    return 0.0, 10.0 * RAD_PER_ARCSEC * np.array([0.0, 0.0, chance.standard_normal()])


@pytest.mark.parametrize("days", [days_of_a_meter, days_of_a_base_that_leans_one_way])
def test_what_scatters_more_than_its_like_is_judged_by_itself(days: Disturbed) -> None:
    """Ten times what the certificates state, in one component: each is a false alarm in a third of the runs, or one in
    sixteen, where its scatter is shared out among others that are quiet."""
    alarms = sum(len(check_history(alone(20, seed, days), CHECK_SENSOR).findings) for seed in range(10))
    assert alarms <= 2  # of 160 runs at 0.2 %


@pytest.mark.parametrize("sigma", [1.0, 5.0, 30.0])
def test_a_drift_of_a_check_sensor_that_is_alone_is_found_however_steep(sigma: float) -> None:
    def creeping(run: int, chance: np.random.Generator) -> tuple[float, FloatArray]:
        return days_of_a_meter(run, chance)[0] + sigma * 10.0 * RAD_PER_ARCSEC * run, np.zeros(3)

    found = [check_history(alone(14, seed, creeping), CHECK_SENSOR).findings for seed in range(4)]
    assert all({finding.component for finding in findings} == {"meter gain"} for findings in found)


def test_a_step_before_limits_exist_is_found_by_the_runs_after_it_and_dated() -> None:
    def stepped(run: int, chance: np.random.Generator) -> tuple[float, FloatArray]:
        return 0.0, np.array([0.0, 60.0 * RAD_PER_ARCSEC * (run >= 2), 0.0])

    (found,) = check_history(alone(9, 1, stepped), CHECK_SENSOR).findings
    assert (found.component, found.at.run_id) == ("table tilt y", "campaign-02")
    assert "(seen at 2018" in found.sentence or "(seen at 2019" in found.sentence
    assert np.radians(found.size_deg) / RAD_PER_ARCSEC == pytest.approx(60.0, abs=3.0)


def test_a_check_sensor_with_outputs_in_counts_has_offsets_too() -> None:
    population = alone(6, 1, days_of_a_meter)
    numbers = replace(population.numbers, sensitivity_name="sensitivity_counts_per_g")
    found = check_history(Population(population.labels, numbers), CHECK_SENSOR)
    assert all(np.isfinite(chart.value_deg).all() for chart in found.charts)
    assert "sensor offset_counts.x" in {chart.name for chart in found.charts}


@pytest.mark.parametrize(("runs", "known"), [(2, 1), (4, 3), (5, 4)])
def test_limits_exist_with_the_fifth_run_and_how_wide_they_are_is_told(runs: int, known: int) -> None:
    found = check_history(alone(runs, 2, days_of_a_meter), CHECK_SENSOR)
    assert (found.differences, found.is_judged) == (known, known == 4)
    if found.is_judged:
        assert found.unseen_deg["meter"] > 0.01, "ten sigma: two degrees of freedom"
        sets = [stated_by(np.hstack([np.zeros((3, 1)), np.eye(3)]), np.full((3, 4), RAD_PER_ARCSEC**2), 6)] * runs
        assert found.rests_on_few
        assert any("meter gain" in text for text in unexplained_changes(found, sets))


def stated_by(primary: FloatArray, variance: FloatArray, replications: int) -> tuple[tuple[str, ...], StatedScatter]:
    """What a set states of a check sensor's components: (3, 4) variances, of each axis by its replications alone."""
    parts = np.zeros((3, 3, 4, 4))
    for axis in range(3):
        parts[axis, axis] = np.diag(variance[axis])
    numbers = PackageNumbers(("x", "y", "z"), np.tile(primary, (3, 1, 1)), parts, parts)
    families = variance_of_families(numbers, characteristics_of(numbers))
    scatter = StatedScatter(
        np.stack(list(families.values()), axis=1), np.full(3, replications - 1.0), np.zeros(3, dtype=bool), ()
    )
    return tuple(families), scatter


def told_share(replications: int, runs: int, gain: float, histories: int) -> float:
    """Of how many check sensors, whose meter reads more by ``gain`` in the latest run, anything is told."""
    count, noise = 0, RAD_PER_ARCSEC
    for seed in range(histories):
        chance = np.random.default_rng(seed)
        population = alone(runs, seed, lambda run, _: (gain * (run == runs - 1), np.zeros(3)))
        variances = noise**2 * chance.chisquare(replications - 1, (runs, 3, 4)) / (replications - 1)
        rows = zip(population.numbers.primary, variances, strict=True)
        stated = [stated_by(primary, variance, replications) for primary, variance in rows]
        count += bool(unexplained_changes(check_history(population, CHECK_SENSOR), stated))
    return count / histories


@pytest.mark.parametrize(("replications", "runs"), [(2, 2), (3, 3), (6, 2)])
def test_of_sound_first_runs_five_of_a_hundred_are_told_at_most(replications: int, runs: int) -> None:
    assert told_share(replications, runs, 0.0, 100) <= 0.05 + 3.0 * np.sqrt(0.05 * 0.95 / 100)


def test_a_gain_of_a_few_expanded_uncertainties_is_told_in_the_second_run() -> None:
    assert told_share(6, 2, 10.0 * RAD_PER_ARCSEC, 40) > 0.6
