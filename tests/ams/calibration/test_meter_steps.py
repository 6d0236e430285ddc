"""A meter whose gain or offset steps in mid-run is named, also where every output drifts evenly beside it.

Readings are made here from the specific force of physics, three axes at 2.5 V/g and 1.65″ a dwell.
"""

from dataclasses import replace

import numpy as np
import pytest
from dwells_of_points import layout_of_points
from numpy.typing import NDArray

from ams.analysis.diagnostics.step_patterns import Watched
from ams.analysis.diagnostics.steps.likeliest_step import changes_of
from ams.analysis.diagnostics.steps.step_outputs import scans_of_meter, scans_of_output, scans_of_table, together
from ams.analysis.diagnostics.steps.step_scan import Course
from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from ams.solve.layout import layout_of

FloatArray = NDArray[np.float64]
K = np.array([[2.5, 0.018, 0.012], [-0.01, 2.48, 0.008], [0.009, -0.015, 2.52]])
OFFSET_V = np.array([0.005, -0.003, 0.008])
NOISE_V = 20e-6
REPLICATIONS = 4
GRID = np.deg2rad([(p, r) for p in range(-90, 91, 30) for r in range(-180, 180, 45)])


def force_g(pitch_rad: FloatArray, roll_rad: FloatArray) -> FloatArray:
    """Return (N, 3) as a package on the table feels it, drawn here and not by the library."""
    across = np.cos(pitch_rad)
    return np.stack([np.sin(pitch_rad), -across * np.sin(roll_rad), -across * np.cos(roll_rad)], axis=1)


def campaign(
    seed: int, drift_arcsec: float, gain: float = 0.0, offset_v: float = 0.0, only: str = "xyz"
) -> tuple[Observations, int]:
    """Return four replications there and back, and the dwell after which the outputs ``only`` are changed.

    ``drift_arcsec``: of all outputs, a replication.
    """
    chance, order = np.random.default_rng(seed), np.arange(len(GRID))
    point = np.concatenate([order, order[::-1]] * (REPLICATIONS // 2))
    pitch, roll = GRID[point].T
    at = int(point.size * chance.uniform(0.2, 0.8))
    since = np.arange(point.size) >= at
    drift_v = 2.5 * np.deg2rad(drift_arcsec / 3600.0) * np.linspace(0.0, REPLICATIONS, point.size)
    read = OFFSET_V + force_g(pitch, roll) @ K.T + drift_v[:, None]
    is_changed = since[:, None] & np.array([name in only for name in "xyz"])
    read = read * np.where(is_changed, 1.0 + gain, 1.0) + np.where(is_changed, offset_v, 0.0)
    read += NOISE_V * chance.standard_normal(read.shape)
    rows = Observations(
        np.repeat(np.arange(1, REPLICATIONS + 1), len(GRID)),
        point + 1,
        pitch,
        roll,
        {name: read[:, which] for which, name in enumerate("xyz")},
        time_s=90.0 * np.arange(point.size, dtype=np.float64),
        step=np.arange(1, point.size + 1),
    )
    return rows, at


def solved(rows: Observations, tested_axes: int = 3) -> Calibration:
    return calibrate(rows, CalibrationRequest(tested_axes=tested_axes))


def significant(found: Calibration) -> list[Finding]:
    return [finding for axis in found.axes.values() for finding in axis.findings if finding.is_significant]


def told(found: Calibration) -> set[str]:
    return {finding.kind for finding in significant(found)}


@pytest.mark.parametrize("tested_axes", [3, 24], ids=["one package", "eight packages"])
@pytest.mark.parametrize("drift_arcsec", [1.0, 3.0, 10.0])
@pytest.mark.parametrize("gain", [30e-6, 300e-6])
def test_a_gain_of_the_meter_that_steps_while_every_output_drifts_is_the_meters(
    gain: float, drift_arcsec: float, tested_axes: int
) -> None:
    for seed in (41, 42):
        rows, at = campaign(seed, drift_arcsec, gain=gain)
        found = solved(rows, tested_axes)
        steps = [finding for finding in significant(found) if finding.kind == "meter-gain"]
        assert len(steps) == 3  # all three axes say the same
        assert {finding.text for finding in steps} == {steps[0].text}
        assert "the meter" in steps[0].text
        (size,) = (value for name, value in steps[0].details.items() if name == "gain_of_the_meter")
        assert float(size or 0.0) == pytest.approx(gain, rel=0.3)
        assert abs(steps[0].steps[0] - (at + 1)) <= 12
        assert "drift" in told(found)
        assert not told(found) & {"table-rotation", "sensor-change", "meter-offset", "lack-of-fit", "wrong-dwell"}
        assert found.verdict == "not usable"


@pytest.mark.parametrize("drift_arcsec", [0.0, 10.0])
def test_ten_parts_in_a_million_are_seen(drift_arcsec: float) -> None:
    runs = [solved(campaign(seed, drift_arcsec, gain=10e-6)[0]) for seed in range(60, 72)]
    assert sum("meter-gain" in told(found) for found in runs) >= 10


@pytest.mark.parametrize("drift_arcsec", [0.0, 3.0])
def test_an_offset_of_the_meter_is_the_meters(drift_arcsec: float) -> None:
    found = solved(campaign(43, drift_arcsec, offset_v=300e-6)[0])
    assert "meter-offset" in told(found)
    assert not told(found) & {"table-rotation", "sensor-change", "meter-gain"}


@pytest.mark.parametrize("drift_arcsec", [0.0, 3.0])
def test_one_sensitivity_that_steps_is_the_sensors(drift_arcsec: float) -> None:
    found = solved(campaign(44, drift_arcsec, gain=100e-6, only="y")[0])
    assert "sensor-change" in told(found)
    assert not told(found) & {"table-rotation", "meter-offset", "meter-gain"}


def test_a_gain_of_the_meter_and_one_output_that_step_at_the_same_moment_are_not_told_as_the_sensor_alone() -> None:
    """Of two causes at once the readings tell that outputs changed by amounts of their own, and not whose they are."""
    for gain, step_v, names_meter in ((100e-6, 300e-6, True), (0.0, 300e-6, False)):
        rows, at = campaign(45, 0.0, gain=gain)
        z_v = rows.outputs["z"] + np.where(np.arange(rows.rows) >= at, step_v, 0.0)
        changes = [
            finding
            for finding in significant(solved(replace(rows, outputs={**rows.outputs, "z": z_v})))
            if finding.kind == "sensor-change"
        ]
        assert changes
        assert all(("what they share (the meter, a supply)" in change.fact) == names_meter for change in changes)


@pytest.mark.thorough
@pytest.mark.parametrize(("drift_arcsec", "most"), [(0.0, 1), (0.5, 8), (1.0, 2), (3.0, 2), (10.0, 2)])
def test_no_even_drift_is_called_a_step(drift_arcsec: float, most: int) -> None:
    runs = [solved(campaign(seed, drift_arcsec)[0]) for seed in range(100, 200)]
    steps = {"table-rotation", "sensor-change", "meter-offset", "meter-gain"}
    assert sum(bool(told(found) & steps) for found in runs) <= most


def test_a_step_of_the_meter_explains_what_least_squares_over_all_outputs_do() -> None:
    """Of two outputs, one of which drifts, place by place, by numpy's least squares and no other arithmetic."""
    chance, point = np.random.default_rng(6), np.tile(np.arange(14), 5)
    pitch, roll = (angle[point] for angle in chance.uniform(-1.5, 1.5, (2, 14)))
    order = chance.permutation(point.size)
    drift = np.zeros(point.size)
    drift[order] = np.arange(point.size)
    drift = about_points(drift, point) / np.linalg.norm(about_points(drift, point))
    noise = [about_points(chance.standard_normal(point.size), point) for _ in range(2)]
    outputs = [
        Watched(noise[0], 0.7, K[0], np.sin(pitch)),
        Watched(noise[1] - drift * (drift @ noise[1]), 2.0, K[1], np.sin(pitch), drift),
    ]
    course = Course(layout_of_points(point), order, pitch, roll, point.size - 14)
    y = np.concatenate([noise[0] / np.sqrt(0.7), noise[1] / np.sqrt(2.0)])
    beside = np.concatenate([np.zeros(point.size), drift])[:, None]
    for scan, taken in zip(
        scans_of_meter(together(course, outputs)),
        (force_g(pitch, roll) @ K[:2].T, np.ones((point.size, 2))),
        strict=True,
    ):
        explained = []
        for first in range(8, point.size - 7):
            since = np.zeros(point.size)
            since[order[first:]] = 1.0
            column = [about_points(taken[:, i] * since, point) / np.sqrt(o.variance) for i, o in enumerate(outputs)]
            both = np.column_stack([np.concatenate(column), beside])
            explained.append(squares(beside, y) - squares(both, y))
        (best, *_) = changes_of([scan])
        assert best.is_of_meter
        assert best.index == 8 + int(np.argmax(explained))
        assert best.square == pytest.approx(max(explained), rel=1e-6)


def test_of_one_output_the_meter_is_no_other_pattern_than_its_own() -> None:
    rows, _ = campaign(45, 0.0)
    point = np.asarray(rows.point - 1)
    alone = Watched(about_points(rows.outputs["x"], point), 1.0, K[0], np.sin(rows.pitch_rad))
    order, dof = np.arange(point.size), point.size - len(GRID)
    course = Course(layout_of(rows), order, rows.pitch_rad, rows.roll_rad, dof)
    assert not list(scans_of_meter(together(course, [alone])))
    assert told(solved(replace(rows, outputs={"x": rows.outputs["x"]}))) == set()


def test_patterns_that_are_looked_at_together_are_each_told_as_alone() -> None:
    chance, point = np.random.default_rng(7), np.tile(np.arange(14), 6)
    pitch, roll = (angle[point] for angle in chance.uniform(-1.5, 1.5, (2, 14)))
    course = Course(layout_of_points(point), chance.permutation(point.size), pitch, roll, point.size - 14)
    stepped = 4.0 * (np.argsort(course.time_order) > 30)
    outputs = [
        Watched(about_points(chance.standard_normal(point.size) + step, point), 1.0, k, np.sin(pitch))
        for k, step in zip(K, (stepped, 0.0, stepped * np.sin(pitch)), strict=True)
    ]
    of_all = together(course, outputs)
    scans = [*scans_of_table(of_all), *scans_of_meter(of_all)]
    scans += [scan for index, watched in enumerate(outputs) for scan in scans_of_output(course, watched, index)]
    alone = [change for scan in scans for change in changes_of([scan])]
    every = changes_of(scans)
    assert len(every) > len(scans) == 12  # some came back as well
    for one, other in zip(every, alone, strict=True):
        assert replace(one, p_value=0.0, square=0.0) == replace(other, p_value=0.0, square=0.0)
        assert (one.p_value, one.square) == pytest.approx((other.p_value, other.square), rel=1e-9)


def about_points(column: FloatArray, point: NDArray[np.int64]) -> FloatArray:
    return np.asarray(column - (np.bincount(point, column) / np.bincount(point))[point])


def squares(columns: FloatArray, y: FloatArray) -> float:
    """Return the sum of squares that columns leave of y."""
    left = y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]
    return float(left @ left)
