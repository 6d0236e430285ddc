"""What changed once in mid-run is told as that, by its cause; what drifts is not; where nothing happens nothing rings.

Campaigns are those of the laboratory of ``physics_scenes``, which knows nothing of the tests: a table whose read-back
does not tell that it slipped, seen by one package of three axes.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from dwells_of_points import layout_of_points
from numpy.typing import NDArray
from physics_scenes import Campaign, campaigns, mixed
from scipy.stats import binom  # type: ignore[import-untyped]

from ams.analysis.diagnostics.beliefs import SETTLING
from ams.analysis.diagnostics.step_patterns import Watched
from ams.analysis.diagnostics.steps.likeliest_step import changes_of
from ams.analysis.diagnostics.steps.step_outputs import scans_of_output, scans_of_table, together
from ams.analysis.diagnostics.steps.step_scan import Course
from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.findings import Finding, turned_the_table
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

ALONE = {"sensors": 1, "reference_every": 0, "check_set": False, "replications": 4}
COUNT = 12


def solved(
    scene: str, size: float, count: int = COUNT, seed: int = 3, **design: object
) -> Iterator[tuple[Calibration, Campaign, int]]:
    """Yield each campaign of a scene, solved, with the row of the event in the order of the rows."""
    setup: dict[str, Any] = {**ALONE, **design}
    drawn: Campaign = campaigns(scene, size, np.random.default_rng(seed), count, **setup)
    for place in range(count):
        at = -1 if drawn.event is None else int(drawn.event.dwell[place])
        yield calibrate(observed(drawn, place), CalibrationRequest()), drawn, at


def observed(drawn: Campaign, place: int = 0) -> Observations:
    schedule = drawn.schedule
    return Observations(
        schedule.replication,
        schedule.point,
        np.deg2rad(schedule.pitch_deg),
        np.deg2rad(schedule.roll_deg),
        {axis: drawn.output_v[place, :, 0, which] for which, axis in enumerate("xyz")},
        time_s=schedule.time_s,
        step=np.arange(1, schedule.dwells + 1),
    )


def told(found: Calibration) -> set[str]:
    return {finding.kind for axis in found.axes.values() for finding in axis.findings if finding.is_significant}


def of_kind(found: Calibration, kind: str) -> list[Finding]:
    every = [finding for axis in found.axes.values() for finding in axis.findings if finding.is_significant]
    return [finding for finding in every if finding.kind == kind]


@pytest.mark.parametrize("scene", ["slip-roll", "slip-pitch", "slip-base"])
@pytest.mark.parametrize("size", [5.0, 72.0])
def test_a_table_that_slips_is_named_with_the_dwell_and_the_result_is_not_usable(scene: str, size: float) -> None:
    for found, _drawn, at in solved(scene, size):
        slips = of_kind(found, "table-rotation")
        assert {finding.text for finding in slips} == {slips[0].text}  # all three axes say the same
        assert len(slips) == 3
        assert "the table, its base or the common fixture" in slips[0].text
        assert abs(slips[0].steps[0] - (at + 1)) <= 26  # at the ends of pitch two rows of dwells see no roll
        assert slips[0].steps[-1] == found.axes["x"].fitted_v.size
        assert float(slips[0].details["turned_arcsec"] or 0.0) == pytest.approx(size, rel=0.3)
        assert (found.verdict == "not usable") == bool(turned_the_table(slips))
        assert turned_the_table(slips)


def test_what_the_slip_explains_is_told_by_no_other_test() -> None:
    """Without it, K₂, K_ip and a drift are told, none of which is there."""
    others = [told(found) - {"table-rotation"} for found, *_ in solved("slip-pitch", 72.0, count=20)]
    assert sum(bool(one) for one in others) <= 5


@pytest.mark.parametrize(
    ("scene", "size", "kind"),
    [
        ("sensor-offset", 5.0, "sensor-change"),
        ("sensor-gain", 50.0, "sensor-change"),
        ("meter-gain", 50.0, "meter-gain"),
    ],
)
def test_a_step_of_sensor_or_meter_is_theirs_and_not_the_tables(scene: str, size: float, kind: str) -> None:
    for found, drawn, _ in solved(scene, size):
        assert kind in told(found)
        assert "table-rotation" not in told(found)
        assert found.verdict == "not usable"  # the result is a mixture of before and after
        if kind == "sensor-change":
            assert drawn.event is not None
            assert len(of_kind(found, kind)) == 1  # of one output, and told of no other


@pytest.mark.parametrize(
    ("scene", "size"), [("drift-linear", 5.0), ("drift-replications", 2.0), ("drift-walk", 5.0), ("drift-warm-up", 5.0)]
)
def test_the_likeliest_step_of_a_drift_is_no_step(scene: str, size: float) -> None:
    kinds = [told(found) for found, *_ in solved(scene, size, replications=6)]
    assert sum("drift" in one or "autocorrelation" in one for one in kinds) == COUNT
    assert sum(bool(one & {"sensor-change", "meter-offset", "table-rotation"}) for one in kinds) <= 1


@pytest.mark.parametrize("scene", ["slip-roll", "slip-pitch"])
@pytest.mark.parametrize("drift_arcsec", [2.0, 8.0, 40.0])
def test_a_table_that_slips_while_every_output_drifts_evenly_is_named_and_so_is_the_drift(
    scene: str, drift_arcsec: float
) -> None:
    """The drift has a likeliest step of its own, of each output, and larger than the slip: no sensor is blamed for it.

    Over the run it is 2 to 40″, against a slip of 10″; the turn that is told is that of the table alone.
    """
    drawn = mixed(
        {"drift-linear": drift_arcsec, scene: 10.0}, np.random.default_rng(17), 3, pitch_count=7, roll_count=8, **ALONE
    )
    assert drawn.event is not None
    for place in range(3):
        found = calibrate(observed(drawn, place), CalibrationRequest())
        slips = of_kind(found, "table-rotation")
        assert len(slips) == 3
        assert f"about {scene.partition('-')[2]}" in slips[0].text
        assert abs(slips[0].steps[0] - (int(drawn.event.dwell[place]) + 1)) <= 17
        assert float(slips[0].details["turned_arcsec"] or 0.0) == pytest.approx(10.0, rel=0.25)
        assert "drift" in told(found)
        assert not told(found) & {"sensor-change", "meter-offset", "meter-gain"}
        assert found.verdict == "not usable"


@pytest.mark.parametrize("size_v", [2e-4, 1e-3])
def test_one_output_that_steps_while_all_drift_is_the_sensors(size_v: float) -> None:
    for seed in (21, 22, 23):
        rows = there_and_back("roll", 0.0, (500, 936), seed, offset_of_x_v=size_v)
        passed: NDArray[np.float64] = np.linspace(0.0, 1.0, rows.rows)
        outputs = {name: values + 1e-4 * passed for name, values in rows.outputs.items()}
        found = calibrate(replace(rows, outputs=outputs), CalibrationRequest())
        (change,) = of_kind(found, "sensor-change")
        (own,) = (name for name in change.details if name.startswith("own_") and not name.endswith("uncertainty"))
        assert own.startswith("own_offset")
        assert own.endswith("_x")
        assert float(change.details[own] or 0.0) == pytest.approx(size_v, abs=1.5e-5)
        assert abs(change.steps[0] - 501) <= 6
        assert "table-rotation" not in told(found)
        assert all(any(f.kind == "drift" and f.is_significant for f in found.axes[name].findings) for name in "yz")


@pytest.mark.thorough
@pytest.mark.parametrize("scene", ["drift-linear", "drift-walk", "drift-warm-up"])
@pytest.mark.parametrize("size", [0.5, 2.0, 10.0])
def test_no_drift_of_sensors_alone_is_called_a_turn_of_the_table(scene: str, size: float) -> None:
    kinds = [told(found) for found, *_ in solved(scene, size, count=100, seed=5, pitch_count=7, roll_count=8)]
    assert sum("table-rotation" in one for one in kinds) <= 1


def test_one_dwell_that_is_wrong_makes_no_step_wherever_it_is() -> None:
    for place in (1, 20, 40, 300):
        found, drawn, _ = next(iter(solved("clean", 0.0, count=1)))
        rows = observed(drawn)
        struck = rows.outputs["y"].copy()
        struck[place] += 0.03
        found = calibrate(replace(rows, outputs={**rows.outputs, "y": struck}), CalibrationRequest())
        assert told(found) == {"wrong-dwell"}


def test_a_step_that_one_dwell_alone_shows_is_that_dwell() -> None:
    """The run begins at pitch −90°, where y and z sense no change of sensitivity nor of roll, until its ninth dwell."""
    rows = observed(next(iter(solved("clean", 0.0, count=1, pitch_count=7, roll_count=8)))[1])
    assert np.allclose(rows.pitch_rad[:8], np.deg2rad(-90.0))
    for axis in ("y", "z"):
        struck = rows.outputs[axis].copy()
        struck[8] += 0.03
        kinds = told(calibrate(replace(rows, outputs={**rows.outputs, axis: struck}), CalibrationRequest()))
        assert "wrong-dwell" in kinds
        assert not kinds & {"sensor-change", "table-rotation"}


def test_a_meter_that_reads_most_dwells_alike_is_solved() -> None:
    rows = observed(next(iter(solved("clean", 0.0, count=1)))[1])
    for step_v in (0.5e-3, 1e-3, 2e-3, 5e-3):
        coarse = {axis: step_v * np.round(reading / step_v) for axis, reading in rows.outputs.items()}
        found = calibrate(replace(rows, outputs=coarse), CalibrationRequest())
        assert not told(found) & {"table-rotation", "sensor-change", "meter-gain", "meter-offset"}


def test_a_transient_alike_in_every_replication_is_told_with_its_size() -> None:
    for found, *_ in solved("drift-settling", 2.0, replications=6):
        settling = [one for axis in found.axes.values() for one in axis.findings if one.details["test"] == SETTLING]
        assert all(one.is_significant for one in settling)
        assert "at the start of every replication" in settling[0].text
        volts_per_radian = 2.5
        size = np.rad2deg(abs(float(settling[0].details["size"] or 0.0)) / volts_per_radian) * 3600.0
        assert 0.6 * 3.3 < size < 1.6 * 3.3  # twice 1.65″, by an exponential of another time constant


def test_orders_drawn_anew_tell_a_transient_from_the_attitude() -> None:
    kinds = [told(found) for found, *_ in solved("drift-settling", 1.0, replications=6, order="random")]
    assert all("drift" in one for one in kinds)


GRID = np.deg2rad([(p, r) for p in range(-90, 91, 15) for r in range(-180, 180, 30)])


def force_g(pitch_rad: NDArray[np.float64], roll_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (N, 3) as a package on the table feels it, drawn here and not by the library."""
    across = np.cos(pitch_rad)
    return np.stack([np.sin(pitch_rad), -across * np.sin(roll_rad), -across * np.cos(roll_rad)], axis=1)


def there_and_back(
    axis: str, size_arcsec: float, part: tuple[int, int], seed: int, offset_of_x_v: float = 0.0
) -> Observations:
    """Return six replications there and back of three axes at 2.5 V/g, in which the table or x is off for a while.

    ``part``: of the dwells in time, the first that is off and the first that is right again.
    """
    order = np.arange(len(GRID))
    location = np.concatenate([order, order[::-1]] * 3)
    replication, chance = np.repeat(np.arange(1, 7), len(GRID)), np.random.default_rng(seed)
    pitch, roll = GRID[location].T
    is_off = (np.arange(location.size) >= part[0]) & (np.arange(location.size) < part[1])
    slip = np.deg2rad(size_arcsec / 3600.0) * is_off
    stood = force_g(pitch + slip * (axis == "pitch"), roll + slip * (axis == "roll"))
    outputs = {
        name: 0.002 + 2.5 * stood[:, which] + 2e-5 * chance.standard_normal(location.size)
        for which, name in enumerate("xyz")
    }
    outputs["x"] += offset_of_x_v * is_off
    steps, time_s = np.arange(1, location.size + 1), 90.0 * np.arange(location.size)
    return Observations(replication, location + 1, pitch, roll, outputs, time_s=time_s, step=steps)


@pytest.mark.parametrize("axis", ["roll", "pitch"])
@pytest.mark.parametrize("part", [(281, 655), (312, 468), (500, 560)], ids=["30 to 70 %", "the third", "a few"])
@pytest.mark.parametrize("size_arcsec", [5.0, 20.0, 72.0])
def test_a_table_that_slips_and_slips_back_is_named_with_its_dwells(
    axis: str, part: tuple[int, int], size_arcsec: float
) -> None:
    found = calibrate(there_and_back(axis, size_arcsec, part, seed=8), CalibrationRequest())
    slips = of_kind(found, "table-rotation")
    assert len(slips) == 3
    assert "the table, its base or the common fixture" in slips[0].text
    assert "and back" in slips[0].text
    assert abs(slips[0].steps[0] - (part[0] + 1)) <= 26  # at the ends of pitch two rows of dwells see no roll
    assert abs(slips[0].steps[-1] - part[1]) <= 26
    assert float(slips[0].details["turned_arcsec"] or 0.0) == pytest.approx(size_arcsec, abs=0.2 * size_arcsec)
    assert told(found) == {"table-rotation"}  # no K₂, K_io, K_ip, wrong dwell, settling or drift
    assert found.verdict == "not usable"


@pytest.mark.parametrize("part", [(281, 655), (312, 468)])
def test_one_arc_second_there_and_back_is_seen_in_most_runs(part: tuple[int, int]) -> None:
    runs = [calibrate(there_and_back("pitch", 1.5, part, seed), CalibrationRequest()) for seed in range(10)]
    assert sum("table-rotation" in told(found) for found in runs) >= 8


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_an_axis_by_itself_sees_the_table_slip_and_slip_back_where_it_senses_it(axis: str) -> None:
    about = "pitch" if axis == "x" else "roll"
    rows = there_and_back(about, 20.0, (281, 655), seed=9)
    found = calibrate(replace(rows, outputs={axis: rows.outputs[axis]}), CalibrationRequest())
    assert told(found) & {"table-rotation", "sensor-change"}
    assert "and back" in " ".join(found.axes[axis].warnings)
    assert found.verdict == "not usable"


@pytest.mark.parametrize("size_v", [6e-5, 2e-4, 1e-3])
def test_one_axis_of_three_that_is_off_for_a_while_is_the_sensors(size_v: float) -> None:
    found = calibrate(there_and_back("roll", 0.0, (281, 655), 10, offset_of_x_v=size_v), CalibrationRequest())
    assert told(found) == {"sensor-change"}
    assert [name for name, axis in found.axes.items() if any(f.is_significant for f in axis.findings)] == ["x"]
    (change,) = of_kind(found, "sensor-change")
    assert "and back" in change.text
    assert abs(change.steps[0] - 282) <= 6
    assert abs(change.steps[-1] - 655) <= 6
    assert found.verdict == "not usable"


def test_a_change_that_stays_is_not_told_as_one_that_came_back() -> None:
    texts = [
        finding.text
        for scene, size in (("slip-roll", 20.0), ("slip-pitch", 5.0), ("sensor-offset", 5.0))
        for found, *_ in solved(scene, size, count=6, replications=6)
        for axis in found.axes.values()
        for finding in axis.findings
        if finding.kind in ("table-rotation", "sensor-change") and finding.is_significant
    ]
    assert texts
    assert not any("and back" in text for text in texts)


def chances(count: int, seed: int, drift_per_dwell: float | None = None) -> NDArray[np.float64]:
    """p-values over white noise, of table and mount, and of one output: few dwells, missing at random, in any order.

    ``drift_per_dwell``: of the second and the third output, in standard deviations, with which it is known to drift.
    """
    chance = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        point = np.tile(np.arange(14), 5)[chance.random(70) > 0.1]
        pitch, roll = (angle[point] for angle in chance.uniform(-1.5, 1.5, (2, 14)))
        order = chance.permutation(point.size)
        readings = np.bincount(point, minlength=14)
        outputs = []
        drift = about_points(np.argsort(order) / 1.0, point)
        unit = drift / np.linalg.norm(drift)
        dof = int(point.size - np.count_nonzero(readings))
        for which, axis in enumerate(np.eye(3)):
            departures, free, known = about_points(chance.standard_normal(point.size), point), dof, None
            if drift_per_dwell is not None and which > 0:
                departures, free, known = departures + drift_per_dwell * drift, dof - 1, unit
                departures = departures - unit * (unit @ departures)
            outputs.append(Watched(departures, float(departures @ departures) / free, axis, np.sin(pitch), known))
        course = Course(layout_of_points(point), order, pitch, roll, dof)
        if not course.is_judged:
            continue
        scans = (8.0, scans_of_table(together(course, outputs))), (4.0, scans_of_output(course, outputs[2], 2))
        found.append([min(1.0, tried * min(one.p_value for one in changes_of(group))) for tried, group in scans])
    return np.array(found)


def about_points(column: NDArray[np.float64], point: NDArray[np.int64]) -> NDArray[np.float64]:
    return column - (np.bincount(point, column) / np.maximum(np.bincount(point), 1))[point]


@pytest.mark.parametrize("drift_per_dwell", [None, 10.0])
def test_the_bound_keeps_its_level_over_all_places(drift_per_dwell: float | None) -> None:
    p_values = chances(400, 11, drift_per_dwell)
    for level in (0.05, 0.01):
        for rings in (p_values <= level).sum(axis=0):
            assert binom.sf(int(rings) - 1, 400, level) > 1e-3
    assert (p_values <= 0.3).sum() > 40  # and is no bound that never rings


def test_beside_a_drift_a_change_explains_what_least_squares_with_both_do() -> None:
    """The sums over all places are those of a fit of one column and a drift of each output that drifts, place by place.

    There is no other arithmetic than of numpy's least squares here, over three outputs of which two drift.
    """
    chance, point = np.random.default_rng(5), np.tile(np.arange(14), 5)
    pitch, roll = (angle[point] for angle in chance.uniform(-1.5, 1.5, (2, 14)))
    order, drift = chance.permutation(point.size), np.zeros(point.size)
    drift[order] = np.arange(point.size)
    drift = about_points(drift, point) / np.linalg.norm(about_points(drift, point))
    noise = [about_points(chance.standard_normal(point.size), point) for _ in range(3)]
    outputs = [Watched(noise[0], 0.7, np.eye(3)[0], np.sin(pitch))]
    for which, variance in ((1, 1.3), (2, 2.0)):
        left = noise[which] - drift * (drift @ noise[which])
        outputs.append(Watched(left, variance, np.eye(3)[which], np.sin(pitch), drift))
    course = Course(layout_of_points(point), order, pitch, roll, point.size - 14)
    slip = (force_g(pitch, roll + 1e-4) - force_g(pitch, roll - 1e-4)).T / 2e-4
    y = np.concatenate([n / np.sqrt(o.variance) for n, o in zip(noise, outputs, strict=True)])
    drifts = np.kron([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], drift[:, None])
    explained = []
    for first in range(8, point.size - 7):
        since = np.zeros(point.size)
        since[order[first:]] = 1.0
        column = [about_points(s * since, point) / np.sqrt(o.variance) for s, o in zip(slip, outputs, strict=True)]
        both = np.column_stack([np.concatenate(column), drifts])
        explained.append(squares(drifts, y) - squares(both, y))
    (roll_scan, *_) = scans_of_table(together(course, outputs))
    (best, *_) = changes_of([roll_scan])
    assert best.index == 8 + int(np.argmax(explained))
    assert best.square == pytest.approx(max(explained), rel=1e-6)


def squares(columns: NDArray[np.float64], y: NDArray[np.float64]) -> float:
    """Return the sum of squares that columns leave of y."""
    left = y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]
    return float(left @ left)


@pytest.mark.soak
@pytest.mark.parametrize("drift_per_dwell", [None, 10.0])
def test_the_bound_keeps_its_level_over_all_places_of_many(drift_per_dwell: float | None) -> None:
    p_values = chances(20_000, 12, drift_per_dwell)
    for level in (0.05, 0.01, 0.002):
        for rings in (p_values <= level).sum(axis=0):
            assert binom.sf(int(rings) - 1, 20_000, level) > 1e-3
