"""History finds what drifted, what dropped and what was mixed up, and rarely anything else."""

from dataclasses import replace

import numpy as np
import pytest

from ams.archive.synthetic import Story, SyntheticArchive, synthetic_archive
from ams.errors import ArchiveUnknown
from ams.surveillance.between_runs import pooled_scatter
from ams.surveillance.control_chart import History, history_of
from ams.surveillance.interval_advice import advise_interval
from ams.surveillance.series import Population
from ams.units import RAD_PER_ARCSEC


def all_histories(archive: SyntheticArchive) -> dict[str, History]:
    names = dict.fromkeys(label.sensor for label in archive.population.labels)
    return {name: history_of(archive.population, name) for name in names}


def guilty_are_found(archive: SyntheticArchive, found: dict[str, History]) -> None:
    for name in archive.drifting:
        said = {finding.characteristics[0] for finding in found[name].findings if finding.kind in ("drift", "step")}
        assert "sensitivity_v_per_g.x" in said, (name, found[name].findings)
        assert any("sensitivity x" in finding.sentence for finding in found[name].findings), "as reports name it"
    assert not any("_" in finding.sentence for history in found.values() for finding in history.findings)
    for name in archive.dropped:
        steps = [finding for finding in found[name].findings if finding.kind == "step"]
        assert {"offset_v.y", "angle_deg.yz"} <= {
            characteristic for step in steps for characteristic in step.characteristics
        }, (name, steps)
    for name, other in zip(archive.mixed_up, reversed(archive.mixed_up), strict=True):
        assert other in {finding.partner for finding in found[name].findings}, (name, found[name].findings)


def false_alarms(seeds: range, story: Story) -> tuple[int, int]:
    """Sound sensors with any finding in all their years, and sound sensors; the guilty must all be found."""
    alarms = sensors = 0
    for seed in seeds:
        archive = synthetic_archive(np.random.default_rng(seed), story)
        found = all_histories(archive)
        guilty_are_found(archive, found)
        alarms += sum(bool(found[name].findings) for name in archive.sound)
        sensors += len(archive.sound)
    return alarms, sensors


def test_fifty_sensors_over_eight_years_all_guilty_found_and_few_false_alarms() -> None:
    alarms, sensors = false_alarms(range(6), Story())
    assert sensors == 6 * 45
    assert alarms <= 0.05 * sensors, alarms


@pytest.mark.soak
@pytest.mark.parametrize(
    "story", [Story(), Story(day_arcsec=1.0, drifting=5), Story(sensors=20, years=10), Story(per_year=1, years=12)]
)
def test_false_alarms_over_many_archives(story: Story) -> None:
    alarms, sensors = false_alarms(range(100, 140), story)
    assert alarms <= 0.05 * sensors, f"{alarms} of {sensors}"


def test_sensors_that_scatter_differently_are_judged_by_their_own_scatter() -> None:
    alarms = sensors = 0
    for seed in range(3):
        archive = synthetic_archive(np.random.default_rng(seed), Story())
        chance, numbers = np.random.default_rng(1000 + seed), archive.population.numbers
        primary = numbers.primary.copy()
        for name in archive.sound:
            rows = archive.population.rows_of(name)
            mean = primary[rows].mean(axis=0)
            primary[rows] = mean + (primary[rows] - mean) * np.exp(chance.normal(0.0, 0.5))
        population = Population(archive.population.labels, replace(numbers, primary=primary))
        alarms += sum(bool(history_of(population, name).findings) for name in archive.sound)
        sensors += len(archive.sound)
    assert alarms <= 0.05 * sensors, f"{alarms} of {sensors}"


def quiet(seed: int = 3, **changes: object) -> SyntheticArchive:
    """Nobody drifts enough or drops far enough to matter."""
    return synthetic_archive(
        np.random.default_rng(seed), replace(Story(drift_arcsec_per_year=0.0, drop_arcsec=0.0), **changes)
    )


def test_the_scatter_between_runs_is_that_of_the_days() -> None:
    archive = quiet()
    scatter = pooled_scatter(archive.population)
    offsets = [index for index, kind in enumerate(archive.population.kinds) if kind == "offset_v"]
    day_and_noise = np.hypot(2.0, 0.5) * RAD_PER_ARCSEC
    assert np.sqrt(scatter.variance[offsets]) == pytest.approx(day_and_noise, rel=0.08)


def test_a_remount_alone_raises_nothing_however_large() -> None:
    archive = quiet(remount_arcsec=3600.0)
    found = [history_of(archive.population, name) for name in archive.sound[:12]]
    assert sum(bool(entry.findings) for entry in found) <= 1
    assert np.abs(found[1].rotation_deg[1:]).max() > 0.5


def test_a_drift_is_told_with_its_rate() -> None:
    archive = synthetic_archive(np.random.default_rng(2), Story())
    found = history_of(archive.population, archive.drifting[0])
    chart = next(chart for chart in found.charts if chart.name == "sensitivity_v_per_g.x")
    assert chart.rate_per_year is not None
    assert chart.rate_standard_uncertainty is not None
    true_rate = 4.0 * RAD_PER_ARCSEC * chart.value[0]
    assert abs(chart.rate_per_year - true_rate) < 4.0 * chart.rate_standard_uncertainty
    assert chart.rate_standard_uncertainty < 0.2 * true_rate


def test_calibrations_at_two_sites_are_one_history() -> None:
    archive = quiet()
    population, name = archive.population, archive.sound[0]
    rows, ratio = population.rows_of(name), 9.81 / 9.79826
    labels, primary = list(population.labels), population.numbers.primary.copy()
    for index in range(rows.start, rows.start + 6):
        labels[index] = replace(labels[index], gravity_mps2=9.81)
        primary[index, :, 1:] *= ratio
    elsewhere = Population(labels, replace(population.numbers, primary=primary))
    assert len(history_of(elsewhere, name).findings) == len(history_of(population, name).findings)


def test_a_lone_sensor_is_not_judged_before_its_scatter_is_known_and_then_is() -> None:
    archive = synthetic_archive(np.random.default_rng(5), Story(drop_arcsec=400.0))
    rows = archive.population.rows_of(archive.dropped[0])
    numbers = archive.population.numbers

    def first(count: int) -> Population:
        part = slice(rows.start, rows.start + count)
        columns = {name: getattr(numbers, name)[part] for name in ("primary", "covariance", "scatter")}
        return Population(archive.population.labels[part], replace(numbers, **columns))

    assert not history_of(first(4), archive.dropped[0]).is_judged
    assert history_of(first(5), archive.dropped[0]).is_judged
    assert [finding.kind for finding in history_of(first(16), archive.dropped[0]).findings] == ["step"]


def test_a_sensor_that_is_not_there_is_refused() -> None:
    with pytest.raises(ArchiveUnknown, match="sensor 'SN9': has no calibration here"):
        history_of(quiet().population, "SN9")


def test_the_interval_follows_the_drift_and_never_jumps() -> None:
    archive = synthetic_archive(np.random.default_rng(2), Story(drift_arcsec_per_year=20.0))
    drifting = history_of(archive.population, archive.drifting[0])
    advice = advise_interval(drifting, 0.006)
    assert advice is not None
    assert 3 <= advice.months <= 9  # 21.6 arc seconds less the scatter, 2.0·√2·2.1 at least, at 20 a year: 9 months
    tight = advise_interval(drifting, 0.002)
    assert tight is not None
    assert tight.months == 3  # never less than half of the six so far
    sound = history_of(archive.population, archive.sound[1])
    generous = advise_interval(sound, 0.1)
    assert generous is not None
    assert generous.months == 12
    assert "sensitivity" in advice.sentence


def test_a_scatter_is_learned_from_a_thousand_calibrations_of_the_sensors_behind_by_name() -> None:
    population = synthetic_archive(np.random.default_rng(3), Story(sensors=80, years=10)).population
    sensor = "SN1078"
    text = {sensor, "SN1079", "SN1080", *(f"SN{1001 + index}" for index in range(48))}  # 50 sensors, 20 times each
    rows = np.array([label.sensor in text for label in population.labels])
    numbers = population.numbers
    few = Population(
        [label for label, is_asked in zip(population.labels, rows, strict=True) if is_asked],
        replace(numbers, **{name: getattr(numbers, name)[rows] for name in ("primary", "covariance", "scatter")}),
    )
    of_few, of_all = pooled_scatter(few, sensor), pooled_scatter(population, sensor)
    for name in ("variance", "dof", "prior_dof"):
        assert getattr(of_few, name).tolist() == getattr(of_all, name).tolist()
    assert of_all.dof.max() < 0.37 * 3 * 1000
    truth = pooled_scatter(population, "nobody").variance  # another thousand
    assert np.all(np.abs(of_all.variance / truth - 1.0) < 0.2)


def test_what_cannot_be_judged_yet_is_not_called_sound() -> None:
    """A slope is tested from five calibrations on: with fewer of them nothing can be said to have stayed."""
    two = History("SN1", tuple("ab"), (), np.zeros((2, 3)), (), is_judged=True)  # type: ignore[arg-type]
    assert "nothing" not in two.conclusion
    assert two.conclusion.endswith("of a drift it cannot judge yet (2 of 5 calibrations)")
    assert replace(two, is_judged=False).conclusion.startswith("cannot judge yet (2 of 5 calibrations)")
    assert replace(two, labels=tuple("abcde")).conclusion.startswith("nothing was found")  # type: ignore[arg-type]
