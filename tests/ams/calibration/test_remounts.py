"""A package that was taken off and put back, or turned on its mount, between replications or within one, is told so.

Readings are made here from the specific force of physics turned by Rodrigues' formula, three axes at 2.5 V/g and 1.65″
a dwell, seven pitch angles by eight roll angles in four replications.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray
from physics_scenes import campaigns

from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.findings import Finding, turned_the_table
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

FloatArray = NDArray[np.float64]
ARCSEC = np.pi / 180.0 / 3600.0
V_PER_G = 2.5
REPLICATIONS = 4
GRID = np.deg2rad([(p, r) for p in range(-90, 91, 30) for r in range(-180, 180, 45)])
BETWEEN_TWO_AND_THREE, WITHIN_THE_THIRD = 2 * len(GRID), 2 * len(GRID) + 23
ABOUT = {"y": "lateral axis", "z": "normal"}
NOT_OF_ALL = {"drift", "lack-of-fit", "sensor-change", "meter-gain", "meter-offset", "wrong-dwell", "uneven-noise"}


def turned(force: FloatArray, axis: str, angle_rad: FloatArray) -> FloatArray:
    """Return (N, 3) what a package feels that stands turned by (N,) angles about one of its own axes."""
    e, angle = np.eye(3)["xyz".index(axis)], angle_rad[:, None]
    return np.asarray(
        force * np.cos(angle) - np.cross(e, force) * np.sin(angle) + np.outer(force @ e, e) * (1.0 - np.cos(angle))
    )


@dataclass(frozen=True)
class Turn:
    """What turns, by how much, from which dwell on, or evenly over the whole run."""

    axis: str
    arcsec: float
    at: int = BETWEEN_TWO_AND_THREE
    outputs: str = "xyz"
    is_even: bool = False
    until: int | None = None


def observed(turn: Turn, seed: int) -> Observations:
    chance, order = np.random.default_rng(seed), np.arange(len(GRID))
    point = np.concatenate([order, order[::-1]] * (REPLICATIONS // 2))
    pitch, roll = GRID[point].T
    across, dwell = np.cos(pitch), np.arange(point.size)
    force = np.stack([np.sin(pitch), -across * np.sin(roll), -across * np.cos(roll)], axis=1)
    k = V_PER_G * (np.eye(3) + 0.005 * chance.standard_normal((3, 3)))
    since = (dwell >= turn.at) & (dwell < (turn.until or point.size))
    angle = turn.arcsec * ARCSEC * (dwell / point.size if turn.is_even else since)
    still, moved = force @ k.T, turned(force, turn.axis, angle) @ k.T
    read = np.where([name in turn.outputs for name in "xyz"], moved, still) + 0.005
    read += 1.65 * ARCSEC * V_PER_G * chance.standard_normal(read.shape)
    return Observations(
        np.repeat(np.arange(1, REPLICATIONS + 1), len(GRID)),
        point + 1,
        pitch,
        roll,
        {name: read[:, which] for which, name in enumerate("xyz")},
        time_s=90.0 * dwell,
        step=dwell + 1,
    )


def solved(turn: Turn, seed: int) -> Calibration:
    return calibrate(observed(turn, seed), CalibrationRequest(tested_axes=3))


def significant(found: Calibration) -> dict[str, list[Finding]]:
    return {name: [finding for finding in axis.findings if finding.is_significant] for name, axis in found.axes.items()}


def told(found: Calibration) -> set[str]:
    return {finding.kind for every in significant(found).values() for finding in every}


@pytest.mark.parametrize("at", [BETWEEN_TWO_AND_THREE, WITHIN_THE_THIRD], ids=["between replications", "within one"])
@pytest.mark.parametrize("size_arcsec", [5.0, -20.0, 360.0])
@pytest.mark.parametrize("axis", ["y", "z"])
def test_a_package_that_turned_on_its_mount_is_told_with_axis_angle_and_dwell(
    axis: str, size_arcsec: float, at: int
) -> None:
    for seed in (1, 2):
        found = solved(Turn(axis, size_arcsec, at), seed)
        turns = [
            finding for every in significant(found).values() for finding in every if finding.kind == "table-rotation"
        ]
        assert len(turns) == 3  # all three axes say the same
        assert {finding.text for finding in turns} == {turns[0].text}
        assert f"about its {ABOUT[axis]} between" in turns[0].text
        assert "the package on its mount, or the fixture" in turns[0].text
        assert float(turns[0].details[f"fixture_about_{axis}_arcsec"] or 0.0) == pytest.approx(size_arcsec, abs=1.2)
        assert abs(turns[0].steps[0] - (at + 1)) <= 16  # at the ends of pitch a row of dwells sees little of it
        assert not told(found) & NOT_OF_ALL
        assert found.verdict == "not usable"
        assert turned_the_table(turns)


def test_two_arc_seconds_are_seen_in_most_runs() -> None:
    runs = [solved(Turn(axis, 2.5), seed) for seed in range(5) for axis in "yz"]
    assert sum("table-rotation" in told(found) for found in runs) >= 8


@pytest.mark.parametrize("size_arcsec", [10.0, 200.0])
def test_a_package_put_back_askew_is_told_with_the_whole_angle(size_arcsec: float) -> None:
    """It is turned about any direction, by the laboratory of ``physics_scenes``."""
    alone = {"sensors": 1, "reference_every": 0, "check_set": False}
    drawn = campaigns("remount", size_arcsec, np.random.default_rng(4), 4, **alone)
    assert drawn.event is not None
    schedule = drawn.schedule
    for place in range(4):
        rows = Observations(
            schedule.replication, schedule.point, np.deg2rad(schedule.pitch_deg), np.deg2rad(schedule.roll_deg),
            {axis: drawn.output_v[place, :, 0, which] for which, axis in enumerate("xyz")},
            time_s=schedule.time_s, step=np.arange(1, schedule.dwells + 1),
        )  # fmt: skip
        found = calibrate(rows, CalibrationRequest())
        turn = next(finding for finding in significant(found)["x"] if finding.kind == "table-rotation")
        assert float(turn.details["turned_arcsec"] or 0.0) <= 1.1 * size_arcsec
        assert abs(turn.steps[0] - (int(drawn.event.dwell[place]) + 1)) <= 26
        assert found.verdict == "not usable"


@pytest.mark.parametrize(("axis", "output"), [("y", "x"), ("z", "y"), ("y", "z")])
@pytest.mark.parametrize("size_arcsec", [5.0, 40.0])
def test_one_axis_that_turned_alone_is_that_axis_and_no_turn_of_the_package(
    axis: str, output: str, size_arcsec: float
) -> None:
    found = solved(Turn(axis, size_arcsec, outputs=output), 3)
    assert "table-rotation" not in told(found)
    assert [name for name, every in significant(found).items() if every] == [output]


@pytest.mark.parametrize("axis", ["y", "z"])
def test_a_package_that_turns_evenly_all_the_time_drifts_and_made_no_step(axis: str) -> None:
    found = solved(Turn(axis, 20.0, is_even=True), 5)
    assert "drift" in told(found)
    assert "table-rotation" not in told(found)


def test_a_smaller_step_of_one_output_is_found_beside_an_even_turn_of_the_package() -> None:
    """What cannot be told as a turn of the package does not end the search for others."""
    rows = observed(Turn("y", 30.0, is_even=True), 6)
    since = np.arange(rows.rows) >= WITHIN_THE_THIRD
    stepped = {name: values + 6e-5 * since * (name == "y") for name, values in rows.outputs.items()}
    found = calibrate(replace(rows, outputs=stepped), CalibrationRequest(tested_axes=3))
    assert {finding.kind for finding in significant(found)["y"]} == {"sensor-change"}
    assert "table-rotation" not in told(found)


@pytest.mark.parametrize("axis", ["y", "z"])
@pytest.mark.parametrize("drift_arcsec", [2.0, 40.0])
def test_a_package_that_turned_while_every_output_drifts_evenly_is_told_and_so_is_the_drift(
    axis: str, drift_arcsec: float
) -> None:
    rows = observed(Turn(axis, 10.0, WITHIN_THE_THIRD), 11)
    drift_v = drift_arcsec * ARCSEC * V_PER_G * np.linspace(0.0, 1.0, rows.rows)
    drifting = replace(rows, outputs={name: values + drift_v for name, values in rows.outputs.items()})
    found = calibrate(drifting, CalibrationRequest(tested_axes=3))
    turn = next(finding for finding in significant(found)["x"] if finding.kind == "table-rotation")
    assert float(turn.details[f"fixture_about_{axis}_arcsec"] or 0.0) == pytest.approx(10.0, abs=1.5)
    assert "drift" in told(found)
    assert not told(found) & (NOT_OF_ALL - {"drift"})


@pytest.mark.parametrize("axis", ["y", "z"])
def test_a_turn_that_went_and_came_back_is_told_with_its_dwells(axis: str) -> None:
    first, last = len(GRID), 2 * len(GRID)
    found = solved(Turn(axis, 20.0, at=first, until=last), 7)
    turn = next(finding for finding in significant(found)["x"] if finding.kind == "table-rotation")
    assert f"about its {ABOUT[axis]} from" in turn.text
    assert "and back" in turn.text
    assert abs(turn.steps[0] - (first + 1)) <= 16
    assert abs(turn.steps[-1] - last) <= 16


def test_of_one_axis_alone_a_turn_inside_its_sensor_is_said_to_look_the_same() -> None:
    rows = observed(Turn("z", 40.0), 8)
    found = calibrate(replace(rows, outputs={"x": rows.outputs["x"]}), CalibrationRequest())
    turn = next(finding for finding in significant(found)["x"] if finding.kind == "table-rotation")
    assert "the package on its mount, or the fixture" in turn.text
    assert "an axis that turned inside its sensor would look the same" in turn.text
    assert found.verdict == "not usable"


def test_about_the_forward_axis_mount_and_table_are_both_named() -> None:
    """It is a slip of roll to the last digit. A slip of pitch no turn of the package looks like at all roll angles."""
    roll = next(finding for finding in significant(solved(Turn("x", 20.0), 9))["y"] if finding.kind == "table-rotation")
    assert "about roll between" in roll.text
    assert "the table, its base or the common fixture; the package on its mount would look the same here" in roll.text
    rows = observed(Turn("y", 0.0), 10)
    pitch, slip = rows.pitch_rad, 20.0 * ARCSEC * (np.arange(rows.rows) >= BETWEEN_TWO_AND_THREE)
    by_pitch = np.stack(
        [np.cos(pitch), np.sin(pitch) * np.sin(rows.roll_rad), np.sin(pitch) * np.cos(rows.roll_rad)], axis=1
    )
    moved = {name: rows.outputs[name] + V_PER_G * slip * by_pitch[:, which] for which, name in enumerate("xyz")}
    slipped = calibrate(replace(rows, outputs=moved), CalibrationRequest(tested_axes=3))
    turn = next(finding for finding in significant(slipped)["x"] if finding.kind == "table-rotation")
    assert "about pitch between" in turn.text
    assert "the table, its base or the common fixture" in turn.text
    assert "mount" not in turn.text
