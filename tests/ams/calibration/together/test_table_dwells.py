"""A table that stood off at a dwell is named by all packages together; a reading that is wrong stays its channel's.

Campaigns are those of the laboratory of ``physics_scenes``, which knows nothing of the tests: 7 × 8 points to ±90° in
four replications, 1.65″ a dwell. The table stands beside its tooth about pitch or roll at one dwell.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from physics_scenes import Campaign, campaigns, mixed

from ams.calibration.calibrate import calibrate
from ams.calibration.together.table_dwell_search import StoodPackage
from ams.calibration.together.table_dwells import DwellsOfTable, judge_dwells
from ams.calibration_result import Calibration
from ams.findings import Finding, turned_the_table
from ams.inputs.known_of_run import DwellLabels, labels_of
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

DESIGN: dict[str, Any] = {
    "reference_every": 0, "check_set": False, "replications": 4, "pitch_count": 7, "roll_count": 8,
}  # fmt: skip
COUNT = 6
RINGS_ARCSEC = 30.0
"""What any one axis tells by itself."""


@dataclass(frozen=True)
class Judged:
    """One campaign."""

    packages: list[tuple[str, Observations]]
    found: DwellsOfTable
    struck: DwellLabels | None
    seen_arcsec: float
    """How far gravity turned in the packages at the dwell, for each degree that the table stood off about either axis:
    the less of both."""
    axis: tuple[int, int]
    """Sensor and axis that were struck, −1 for all."""

    def solved_again(self) -> list[Calibration]:
        request = CalibrationRequest(tested_axes=3 * len(self.packages), known_of_run=self.found.known)
        return [calibrate(rows, request) for _, rows in self.packages]


def judged(scene: str, size: float, sensors: int, count: int = COUNT, seed: int = 1, **design: Any) -> Iterator[Judged]:
    drawn = campaigns(scene, size, np.random.default_rng(seed), count, **{**DESIGN, "sensors": sensors, **design})
    yield from judged_of(drawn, size)


def judged_of(drawn: Campaign, size: float) -> Iterator[Judged]:
    """``size``: degrees that the table stood off."""
    sensors = drawn.setup.sensors
    for place in range(drawn.campaigns):
        packages = [(f"P{sensor + 1}", rows_of(drawn, place, sensor)) for sensor in range(sensors)]
        request = CalibrationRequest(tested_axes=3 * sensors)
        found = judge_dwells([StoodPackage(name, rows, calibrate(rows, request)) for name, rows in packages])
        event, rows = drawn.event, packages[0][1]
        if event is None:
            yield Judged(packages, found, None, 0.0, (-1, -1))
            continue
        assert rows.step is not None
        row = int(np.flatnonzero(rows.step == int(event.dwell[place]) + 1)[0])
        axis = int(event.sensor[place]), int(event.axis[place])
        yield Judged(packages, found, labels_of(rows)[row], 3600.0 * size * float(np.cos(rows.pitch_rad[row])), axis)


def rows_of(drawn: Campaign, place: int, sensor: int) -> Observations:
    schedule = drawn.schedule
    return Observations(
        schedule.replication,
        schedule.point,
        np.deg2rad(schedule.pitch_deg),
        np.deg2rad(schedule.roll_deg),
        {axis: drawn.output_v[place, :, sensor, which] for which, axis in enumerate("xyz")},
        time_s=schedule.time_s,
        step=np.arange(1, schedule.dwells + 1),
    )


def significant(found: Calibration) -> list[Finding]:
    return [finding for axis in found.axes.values() for finding in axis.findings if finding.is_significant]


@pytest.mark.parametrize(("sensors", "size"), [(3, 0.02), (8, 0.1)])
def test_a_table_off_at_a_dwell_is_named_and_no_sensor_is_blamed(sensors: int, size: float) -> None:
    visible = [one for one in judged("wrong-tooth", size, sensors) if one.seen_arcsec > RINGS_ARCSEC]
    named = [one for one in visible if one.found.known.off == {one.struck}]
    assert len(visible) >= COUNT // 2
    assert len(named) >= 0.95 * len(visible)
    for one in named:
        (finding,) = one.found.findings
        assert finding.kind == "table-rotation"
        assert "so it is not the sensors" in finding.text
        assert turned_the_table([finding])
        assert finding.text.count("calrig void") == 1  # one way out for all
        assert finding.steps == (int(one.packages[0][1].step[labels_of(one.packages[0][1]).index(one.struck)]),)  # type: ignore[index,arg-type]
    blamed = [kind.kind for one in named[:3] for solved in one.solved_again() for kind in significant(solved)]
    assert len(blamed) <= 1, blamed


def test_one_package_names_the_table_where_two_axes_show_it_and_both_where_one_does() -> None:
    """Three readings and two turns: at level a roll is y alone."""
    named = either = 0
    for one in judged("wrong-tooth", 0.1, 1, count=16):
        if one.seen_arcsec < RINGS_ARCSEC:
            continue
        known, rows = one.found.known, one.packages[0][1]
        is_oblique = abs(np.sin(2.0 * rows.roll_rad[labels_of(rows).index(one.struck)])) > 0.5  # type: ignore[arg-type]
        assert one.struck in known.off or one.struck in known.alike
        if one.struck in known.off:
            named += 1
            assert "(or the package on it)" in one.found.findings[0].text
            continue
        assert not is_oblique
        either += 1
        wrong = [finding for finding in significant(one.solved_again()[0]) if finding.kind == "wrong-dwell"]
        assert len(wrong) == 1
        assert "a table that stood off by" in wrong[0].text
        assert wrong[0].details["confounded_with"] == "table-rotation"
    assert min(named, either) >= 3


@pytest.mark.parametrize("sensors", [1, 3])
@pytest.mark.parametrize("size", [8.0, 1500.0])
def test_a_reading_that_is_wrong_stays_its_channels(sensors: int, size: float) -> None:
    for one in judged("wrong-dwell", size, sensors):
        assert not one.found.known.off
        assert not one.found.findings
        wrong = [
            (sensor, axis)
            for sensor, solved in enumerate(one.solved_again())
            for axis, label in enumerate("xyz")
            if any(finding.kind == "wrong-dwell" and finding.is_significant for finding in solved.axes[label].findings)
        ]
        assert wrong == [one.axis] or (size < 10.0 and not wrong)
        assert sensors == 1 or not one.found.known.alike


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_one_output_alone_never_names_the_table(axis: str) -> None:
    """Five of 224 readings 20 standard deviations off: of a single reading a turn and a wrong reading are the same."""
    chance = np.random.default_rng(3)
    for one in judged("clean", 0.0, 1, count=4):
        _, rows = one.packages[0]
        outputs_v = rows.outputs[axis].copy()
        outputs_v[chance.choice(rows.rows, 5, replace=False)] += 20.0 * 2.5 * np.deg2rad(1.65 / 3600.0)
        alone = replace(rows, outputs={axis: outputs_v})
        request = CalibrationRequest(nominal_axes={axis: axis})
        found = judge_dwells([StoodPackage("P1", alone, calibrate(alone, request))])
        assert not found.known.off
        assert not found.findings


def test_two_dwells_off_hide_neither() -> None:
    (one,) = judged("clean", 0.0, 3, count=1)
    off = {40: 0.02, 130: -0.05}
    packages = []
    for name, rows in one.packages:
        turned = np.zeros(rows.rows)
        turned[list(off)] = np.deg2rad(list(off.values()))
        across = np.cos(rows.pitch_rad)
        by_roll = {"x": 0.0 * across, "y": -across * np.cos(rows.roll_rad), "z": across * np.sin(rows.roll_rad)}
        outputs = {axis: values + 2.5 * turned * by_roll[axis] for axis, values in rows.outputs.items()}
        packages.append((name, replace(rows, outputs=outputs)))
    found = judge_dwells([StoodPackage(name, rows, calibrate(rows, CalibrationRequest())) for name, rows in packages])
    labels = labels_of(packages[0][1])
    assert found.known.off == {labels[row] for row in off}
    assert found.findings[0].steps == (41, 131)


def test_a_table_that_seats_anew_at_every_dwell_is_not_off_at_one() -> None:
    """Seating turns all packages alike: 3″ of it beside 1.65″ of a reading, of which 24 axes make 0.3″."""
    chance = np.random.default_rng(7)
    for one in judged("clean", 0.0, 8, count=2):
        rows = one.packages[0][1]
        turn = np.deg2rad(3.0 / 3600.0) * chance.standard_normal(rows.rows)
        by_pitch = {
            "x": np.cos(rows.pitch_rad),
            "y": np.sin(rows.pitch_rad) * np.sin(rows.roll_rad),
            "z": np.sin(rows.pitch_rad) * np.cos(rows.roll_rad),
        }
        packages = []
        for name, each in one.packages:
            outputs = {axis: values + 2.5 * turn * by_pitch[axis] for axis, values in each.outputs.items()}
            seated = replace(each, outputs=outputs)
            solved = calibrate(seated, CalibrationRequest(tested_axes=24))
            packages.append(StoodPackage(name, seated, solved))
        assert not judge_dwells(packages).known.has_dwells


@pytest.mark.parametrize("louder", [3.0, 9.0])
def test_a_loud_replication_is_no_table_that_stood_off(louder: float) -> None:
    """Its dwells stand out of all, and none of its own: they were told as turns in 130 and 193 of 200 campaigns."""
    full = {"replications": 6, "pitch_count": 13, "roll_count": 12}
    told = [one.found.known for one in judged("noisy-replication", louder, 1, **full)]
    assert not any(known.has_dwells for known in told)


@pytest.mark.parametrize("sensors", [1, 3])
def test_a_table_off_at_a_dwell_is_named_beside_a_loud_replication_and_no_other_dwell(sensors: int) -> None:
    drawn = mixed(
        {"noisy-replication": 3.0, "wrong-tooth": 0.05}, np.random.default_rng(2), 12, **DESIGN, sensors=sensors
    )
    every = list(judged_of(drawn, 0.05))
    assert sum(one.seen_arcsec > RINGS_ARCSEC for one in every) >= len(every) // 2
    for one in every:
        told = one.found.known.off | set(one.found.known.alike)
        assert told == {one.struck} or (not told and one.seen_arcsec < RINGS_ARCSEC)


@pytest.mark.thorough
@pytest.mark.parametrize("sensors", [1, 3])
def test_where_nothing_is_wrong_the_table_is_named_at_its_level(sensors: int) -> None:
    """0.05/34 of all campaigns: one in 680."""
    rung = sum(one.found.known.has_dwells for one in judged("clean", 0.0, sensors, count=400, seed=5))
    assert rung <= 4


@pytest.mark.thorough
@pytest.mark.parametrize("size", [0.0, 0.001, 0.002, 0.003, 0.005, 0.01, 0.1])
@pytest.mark.parametrize("sensors", [1, 3, 8])
def test_from_nothing_to_obvious_only_the_dwell_that_was_off_is_named(sensors: int, size: float) -> None:
    every = list(judged("wrong-tooth", size, sensors, count=40, seed=9))
    visible = [one for one in every if one.seen_arcsec > RINGS_ARCSEC]
    blamed = [one for one in visible if one.struck in one.found.known.off | set(one.found.known.alike)]
    others = [one for one in every if (one.found.known.off | set(one.found.known.alike)) - {one.struck}]
    assert len(blamed) >= 0.95 * len(visible)
    assert len(others) <= 1
