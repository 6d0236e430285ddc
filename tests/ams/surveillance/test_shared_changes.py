"""What all sensors of a run changed alike is the meter's or the table's, and is laid to none of them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from archived_runs import a_run, a_sensor
from scipy.spatial.transform import Rotation
from yearly_laboratory import Laboratory, measured, read_otherwise

from ams.archive.histories import history
from ams.archive.runs import publish_run
from ams.arrays import FloatArray
from ams.surveillance.check_chart import check_history
from ams.surveillance.control_chart import history_of
from ams.surveillance.series import Population
from ams.surveillance.shared_changes import shared_changes, without_shared
from ams.units import RAD_PER_ARCSEC


def blamed(population: Population) -> set[str]:
    names = {label.sensor for label in population.labels}
    return {name for name in names if history_of(population, name).findings}


def without(population: Population) -> Population:
    return without_shared(population, shared_changes(population))


@pytest.mark.parametrize(
    "laboratory",
    [
        Laboratory(gain_arcsec=20.0),
        Laboratory(gain_arcsec=20.0, is_reversed=True),
        Laboratory(offset_arcsec=20.0),
        Laboratory(offset_arcsec=20.0, sensitivity=(1.0, 3.0)),
    ],
)
def test_a_meter_that_changed_is_named_and_no_sensor_is(laboratory: Laboratory) -> None:
    """Ten times a sensor's scatter: every one of them was said to have made a step."""
    for seed in range(3):
        population = measured(laboratory, seed)
        component = "meter gain" if laboratory.gain_arcsec else "meter offset"
        (change,) = shared_changes(population)
        assert (change.component, change.run_id) == (component, f"run-{laboratory.runs - 1:02d}")
        assert len(change.sensors) >= laboratory.sensors - 1
        wanted = laboratory.gain_arcsec or laboratory.offset_arcsec * 2.5 / np.median(
            np.abs(population.numbers.sensitivity)
        )
        assert change.size_rad / RAD_PER_ARCSEC == pytest.approx(wanted, abs=4.0 * 2.0)
        assert len(blamed(population)) > laboratory.sensors / 2
        assert blamed(without(population)) == set()


def test_a_small_change_that_no_sensor_shows_is_told_by_all_together_from_the_second_run_on() -> None:
    """Four times as large as a sensor's scatter in one axis; the first two runs of eight packages."""
    found = [shared_changes(measured(Laboratory(runs=2, gain_arcsec=8.0), seed)) for seed in range(20)]
    assert sum({change.component for change in changes} == {"meter gain"} for changes in found) >= 19


@pytest.mark.parametrize("gain_arcsec", [40.0, 100.0])
@pytest.mark.parametrize("moved", [2, 3, 4, 5, 6])
@pytest.mark.parametrize("runs", [2, 3, 8])
def test_a_change_of_some_sensors_is_laid_to_none_that_did_not_change(
    gain_arcsec: float, moved: int, runs: int
) -> None:
    """Two meters on one rig: told of those of a majority, by its size, and of nobody where neither has one."""
    for seed in range(3):
        population = measured(Laboratory(checks=0, runs=runs, gain_arcsec=gain_arcsec, moved=moved), seed)
        changed = {f"SN{place}" for place in range(moved)}
        found = shared_changes(population)
        assert len(found) == (moved > 4)
        for change in found:
            assert changed - set(change.apart) == set(change.sensors)
            assert set(change.apart) >= {f"SN{place}" for place in range(moved, 8)}
            assert change.size_rad / RAD_PER_ARCSEC == pytest.approx(gain_arcsec, abs=4.0 * 2.0)
        assert blamed(without(population)) <= (changed if not found else set(found[0].apart) & changed)


def test_a_step_of_one_of_two_sensors_is_no_scatter_of_the_runs_after_it() -> None:
    """1000″ in the third of ten runs; the meter changes by 60″ in the last, 37 times what one sensor scatters by."""
    laboratory = Laboratory(sensors=2, checks=0, runs=10, gain_arcsec=60.0, drop_arcsec=1000.0, drop_run=2)
    for seed in range(5):
        (change,) = shared_changes(measured(laboratory, seed))
        assert (change.run_id, change.sensors) == ("run-09", ("SN0", "SN1"))


@pytest.mark.parametrize(
    "laboratory",
    [
        Laboratory(),
        Laboratory(sensors=3),
        Laboratory(sensors=2, checks=2),
        Laboratory(runs=2),
        Laboratory(drop_arcsec=60.0),
    ],
)
def test_sound_runs_and_one_sensor_that_dropped_are_nothing_that_all_share(laboratory: Laboratory) -> None:
    """0.2 % of the runs are false alarms at most: of 60 histories of 7 runs one is let pass."""
    assert sum(bool(shared_changes(measured(laboratory, seed))) for seed in range(60)) <= 1


def test_a_sensor_that_dropped_while_the_meter_changed_is_still_found() -> None:
    population = measured(Laboratory(gain_arcsec=20.0, drop_arcsec=80.0), 1)
    (change,) = shared_changes(population)
    assert "SN7" not in change.sensors
    assert "seven of eight sensors of that run changed alike" in change.sentence
    assert blamed(without(population)) == {"SN7"}


def test_a_meter_that_always_wanders_has_not_changed() -> None:
    laboratory = Laboratory(runs=16, wander_arcsec=10.0)
    late = [
        change
        for seed in range(20)
        for change in shared_changes(measured(laboratory, seed))
        if change.run_id > "run-05"
    ]
    assert len(late) <= 8  # of 200 runs at 1 %, the median of a few runs being what it is


def gains_arcsec(population: Population, sensor: str) -> FloatArray:
    """Return what a sensor is judged by: the mean change of its sensitivities since the first run."""
    gains = population.coordinates[population.rows_of(sensor)][:, 3:6].mean(axis=1) / RAD_PER_ARCSEC
    return np.asarray(gains - gains[0])


@pytest.mark.parametrize("runs", [8, 10])
@pytest.mark.parametrize("wander_arcsec", [10.0, 40.0])
def test_a_meter_that_always_wanders_is_laid_to_no_sensor_more_than_if_nothing_were_taken_out(
    runs: int, wander_arcsec: float
) -> None:
    """Taken out of the first runs and left in those after, it was laid to up to 94 % of sound sensors."""
    laboratory = Laboratory(sensors=6, checks=0, runs=runs, wander_arcsec=wander_arcsec)
    histories = [measured(laboratory, seed) for seed in range(6)]
    raw, judged = (
        sum(len(found) for found in map(look, histories)) for look in (blamed, lambda it: blamed(without(it)))
    )
    assert judged <= raw + 1
    assert judged <= 6


@pytest.mark.parametrize("arcsec_a_year", [10.0, 20.0, 40.0])
@pytest.mark.parametrize("runs", [6, 7, 8])
def test_sensors_of_one_make_that_age_alike_keep_their_drift(arcsec_a_year: float, runs: int) -> None:
    """It was taken for a meter that changes every year, and the next calibration was advised after its limit."""
    sound = measured(Laboratory(sensors=6, checks=0, runs=runs), 3)
    aged = read_otherwise(sound, lambda _, run: arcsec_a_year * run)
    years = np.arange(runs)
    slope = np.polyfit(years, gains_arcsec(without(aged), "SN0"), 1)[0]
    assert slope == pytest.approx(arcsec_a_year, abs=4.0 * 2.0 / np.sqrt(3.0 * ((years - years.mean()) ** 2).sum()))


def test_a_sensor_that_stayed_apart_keeps_no_part_of_what_the_meter_did_and_undid() -> None:
    """It drops while the meter reads 40″ more for one run: repaired, the meter left 40″ with that sensor for ever."""
    for seed in range(3):
        sound = measured(Laboratory(sensors=6, checks=0), seed)
        repaired = read_otherwise(sound, lambda name, run: 40.0 * (run == 5) + 60.0 * (name == "SN3" and run >= 5))
        assert [change.run_id for change in shared_changes(repaired)] == ["run-05", "run-06"]
        judged = without(repaired)
        assert gains_arcsec(judged, "SN3")[6:] == pytest.approx(60.0, abs=4.0 * 2.0)
        assert gains_arcsec(judged, "SN0") == pytest.approx(0.0, abs=4.0 * 2.0)


def test_a_sensor_that_stayed_apart_from_usual_wander_has_the_meters_change_taken_out_later() -> None:
    """It drops in the third run; what the others did then is not told, so nothing is left in it."""
    laboratory = Laboratory(sensors=6, checks=0, runs=10, wander_arcsec=10.0, gain_arcsec=400.0)
    for seed in range(3):
        dropped = read_otherwise(measured(laboratory, seed), lambda name, run: 100.0 * (name == "SN3" and run >= 2))
        (change,) = shared_changes(dropped)
        assert change.apart == ()
        assert gains_arcsec(without(dropped), "SN3")[-1] == pytest.approx(100.0, abs=4.0 * 10.0)


def test_check_sensors_that_turned_alike_tell_the_table_and_one_alone_tells_nothing_here() -> None:
    turned = measured(Laboratory(sensors=3, checks=2, tilt_arcsec=30.0), 2)
    (change,) = shared_changes(turned)
    assert change.component == "table tilt y"
    assert "the table or its base, not the sensors" in change.sentence
    (said,) = [found for found in check_history(turned, "CHECK-0", [change]).findings if found.cause == "table"]
    assert said.sentence == change.sentence
    assert shared_changes(measured(Laboratory(sensors=3, checks=1, tilt_arcsec=30.0), 2)) == ()


def test_a_check_sensor_says_what_all_changed_alike_once() -> None:
    population = measured(Laboratory(gain_arcsec=40.0), 3)
    found = check_history(population, "CHECK-0", shared_changes(population)).findings
    assert [(finding.cause, finding.component) for finding in found] == [("meter", "meter gain")]


def test_the_archive_lays_what_the_meter_did_to_no_sensor(tmp_path: Path) -> None:
    """Four packages twice, read 300 ppm higher the second time: each was told to have changed."""
    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    for day, gain in ((0, 1.0), (200, 1.0003)):
        measured_here = [a_sensor(day, f"SN{index}", read_times=gain) for index in range(1, 5)]
        publish_run(url, a_run(day), measured_here, a_run(day).ended_utc)
    found = history(url, "SN1")
    (change,) = found.shared
    assert change.component == "meter gain"
    assert np.degrees(change.size_rad) == pytest.approx(np.degrees(3e-4), rel=0.01)
    assert found.history.unexplained == ""
    gains = [chart for chart in found.history.charts if chart.name.startswith("sensitivity")]
    assert all(np.diff(chart.shared / chart.value[0]) == pytest.approx([3e-4], rel=0.01) for chart in gains)
    assert all(chart.shared[0] == 0.0 for chart in found.history.charts)
    assert found.not_its_doing == (change.sentence,)


@pytest.mark.parametrize("before_deg", [0.0, 30.0, 90.0, 179.0])
def test_a_tilt_is_about_its_axis_whatever_mount_a_check_sensor_had_before(before_deg: float) -> None:
    """Its first calibration was made in another mount, before it was a check sensor."""
    tilt_arcsec = 30.0
    population = measured(Laboratory(sensors=4, checks=2, tilt_arcsec=tilt_arcsec), 2)
    mount, labels = Rotation.from_rotvec([0.0, 0.0, np.radians(before_deg)]), list(population.labels)
    primary = population.numbers.primary.copy()
    for index, label in enumerate(labels):
        if label.is_check and label.run_id == "run-00":
            primary[index, :, 1:] = mount.apply(primary[index, :, 1:])
            labels[index] = replace(label, is_check=False)
    tilts = {
        change.component: change.size_rad / RAD_PER_ARCSEC
        for change in shared_changes(Population(labels, replace(population.numbers, primary=primary)))
        if change.component.startswith("table tilt")
    }
    assert list(tilts) == ["table tilt y"]
    assert tilts["table tilt y"] == pytest.approx(tilt_arcsec, abs=4.0)
