"""A drift that goes with the order of the points, drawn here: levels and rates, with replications and without."""

import re
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from physics_scenes import campaigns
from solved_campaigns import rows_of_package

from ams.calibration.calibrate import calibrate
from ams.calibration_result import AxisCalibration
from ams.frames import body_rates_rad_s
from ams.inputs.request import CalibrationRequest
from ams.models.straight_line import StraightLine
from ams.observations import Observations

UP = (-50.0, -25.0, 0.0, 25.0, 50.0)
GAIN_UT_PER_COUNTS = 1.0 / 31.24


def _line(
    order: Sequence[Sequence[float]],
    drift_sd: float,
    *,
    term: bool = False,
    seed: int = 0,
    has_times: bool = True,
    is_sorted: bool = False,
) -> AxisCalibration:
    """Solve 31.24 counts/µT with 1 count of noise; the offset drifts evenly by so many counts over the run.

    ``is_sorted``: the rows are given point by point, not as they were measured.
    """
    levels = np.concatenate(order)
    time_s = 30.0 * np.arange(levels.size)
    drift = drift_sd * (time_s / time_s[-1] - 0.5)
    counts = 12.0 + levels / GAIN_UT_PER_COUNTS + drift + np.random.default_rng(seed).standard_normal(levels.size)
    replication = np.repeat(np.arange(1, len(order) + 1), [len(entry) for entry in order])
    point = np.concatenate([np.argsort(np.argsort(entry)) + 1 for entry in order])
    nothing = np.zeros(levels.size)
    at = np.lexsort((replication, point)) if is_sorted else np.arange(levels.size)
    rows = Observations(
        replication[at], point[at], nothing, nothing, {"x": counts[at]}, time_s=time_s[at] if has_times else None,
        reference_level=levels[at], units={"x": "counts"},
    )  # fmt: skip
    model = StraightLine("x", "ut", "counts")
    return calibrate(rows, CalibrationRequest(nominal_axes={"x": "x"}, models={"x": model}, time_term=term)).axes["x"]


def _told(axis: AxisCalibration) -> list[str]:
    return [finding.text for finding in axis.findings if finding.kind == "time-confounded" and finding.is_significant]


def _gain_off_u(axis: AxisCalibration) -> float:
    gain = axis.parameters[0]
    assert gain.value is not None
    assert gain.standard_uncertainty is not None
    return (gain.value - GAIN_UT_PER_COUNTS) / gain.standard_uncertainty


def _is_held(axis: AxisCalibration) -> bool:
    interval = axis.parameters[0].interval_95
    assert interval is not None
    return interval[0] <= GAIN_UT_PER_COUNTS <= interval[1]


@pytest.mark.parametrize("replications", [1, 4])
def test_levels_always_upward_cannot_be_told_from_time_and_levels_up_and_down_can(replications: int) -> None:
    up = _told(_line([UP] * replications, 0.0))
    assert [text for text in up if "time and level go together" in text]
    if replications > 1:
        assert not _told(_line([UP, UP[::-1]] * 2, 0.0))
    assert not _told(_line([UP] * 4, 0.0, term=True))


def test_two_levels_always_in_one_order_are_confounded_with_time_too() -> None:
    assert _told(_line([(-50.0, 50.0)] * 4, 0.0))
    assert not _told(_line([(-50.0, 50.0), (50.0, -50.0)] * 2, 0.0))


def test_a_drift_with_the_levels_is_told_as_what_it_does_to_the_gain() -> None:
    """20/19 counts from dwell to dwell and 25 µT between them are 0.0421 counts/µT: 4.31e-5 µT/counts of the gain."""
    axis = _line([UP] * 4, 20.0)
    (text,) = (text for text in _told(axis) if "drifts evenly" in text)
    assert abs(_gain_off_u(axis)) > 3.0
    said = re.search(r"gain by −([0-9.e-]+) µT/counts", text.replace("e−", "e-"))
    assert said is not None
    assert float(said[1]) == pytest.approx(4.31e-5, rel=0.12), "three standard deviations of the drift as it is found"
    assert "--time-term linear" in text
    assert not any("contained" in warning for warning in axis.warnings if "from replication to replication" in warning)


@pytest.mark.parametrize("replications", [2, 4])
@pytest.mark.parametrize("drift_sd", [0.0, 2.0, 4.0, 8.0, 16.0, 32.0])
def test_without_times_a_drift_in_the_order_of_the_rows_is_in_the_interval_or_told(
    drift_sd: float, replications: int
) -> None:
    """The order of the rows is taken as evenly spaced time; rows without times are no finding while nothing drifts."""
    levels = np.linspace(-50.0, 50.0, 25).tolist()
    axes = [_line([levels] * replications, drift_sd, seed=seed, has_times=False) for seed in range(60)]
    told = [bool(_told(axis)) for axis in axes]
    assert np.mean([_is_held(axis) or said for axis, said in zip(axes, told, strict=True)]) >= 0.93
    assert drift_sd > 0.0 or np.mean(told) <= 0.05
    for axis in axes:
        assert not any("it is contained" in text for text in axis.warnings if "changed from" in text)
        assert all("no times are given" in text and "give the column time_s" in text for text in _told(axis))


def test_rows_sorted_by_point_without_times_say_that_a_drift_inside_replications_cannot_be_judged() -> None:
    axis = _line([UP] * 4, 20.0, has_times=False, is_sorted=True)
    said = [text for text in axis.warnings if "from replication to replication" in text]
    assert said
    assert all("cannot be judged" in text and "give the column time_s" in text for text in said)
    assert any("cannot be judged" in finding.text for finding in axis.findings if finding.kind == "time-confounded")


def test_where_the_order_keeps_a_drift_out_nothing_is_told_of_the_gain_and_the_drift_is_contained() -> None:
    axis = _line([UP, UP[::-1]] * 2, 20.0)
    assert abs(_gain_off_u(axis)) < 3.0
    assert not _told(axis)
    assert all("contained" in warning for warning in axis.warnings if "offset" in warning)


def test_a_rest_at_the_end_of_every_replication_hides_no_rates_in_ascending_order() -> None:
    """Rates about each axis from −60 to 60 °/s and a rest: 10 standard deviations of drift over four replications."""
    rates = [rate * np.eye(3)[axis] for rate in (-60.0, -30.0, 30.0, 60.0) for axis in range(3)]
    euler_rate = np.deg2rad(np.tile([*rates, np.zeros(3)], (4, 1)))
    euler = np.zeros_like(euler_rate)
    rows = euler.shape[0]
    sensed = np.rad2deg(body_rates_rad_s(euler, euler_rate)) @ np.array([0.02, 1e-4, 0.0])
    time_s = 300.0 * np.arange(rows)
    drift = 2e-3 * (time_s / time_s[-1] - 0.5)
    output = 0.01 + sensed + drift + 2e-4 * np.random.default_rng(1).standard_normal(rows)
    replication, point = np.divmod(np.arange(rows), 13)
    nothing = np.zeros(rows)
    observations = Observations(
        replication + 1, point + 1, nothing, nothing, {"x": output}, time_s=time_s, yaw_rad=nothing,
        euler_rate_rad_s=euler_rate,
    )  # fmt: skip
    found = _told(calibrate(observations, CalibrationRequest(model="gyro", nominal_axes={"x": "x"})).axes["x"])
    assert any("time and rate go together" in text for text in found)


def test_the_order_of_rows_without_times_that_goes_with_the_level_is_remarked() -> None:
    """A drift that is alike in every replication is in no residual: only the order tells that it may be there."""
    up = _line([UP] * 4, 0.0, has_times=False)
    assert any("would pass for offset and sensitivity, and is not in the uncertainty" in text for text in up.remarks)
    mixed = np.random.default_rng(4).permutation(UP).tolist()
    assert not any("no times are given" in text for text in _line([mixed] * 4, 0.0, has_times=False).remarks)


def _campaigns_that_say_it(scene: str, size: float, **design: Any) -> int:
    """Return in how many of 24 campaigns of the laboratory x says that a drift is in its parameters."""
    drawn = campaigns(scene, size, np.random.default_rng(20), 24, **design)
    every = (
        replace(rows, outputs={"x": rows.outputs["x"]}) for rows in map(partial(rows_of_package, drawn), range(24))
    )
    return sum(
        "drifts evenly through the run" in " ".join(_told(calibrate(x, CalibrationRequest()).axes["x"])) for x in every
    )


def test_what_changes_between_the_replications_alone_is_in_none_of_them() -> None:
    """Levels that lie along a slope by chance are no drift that an order of the points could let in."""
    assert _campaigns_that_say_it("drift-replications", 5.0) == 0  # in one of six, by what is even in the levels
    assert _campaigns_that_say_it("drift-raster", 5.0, order="raster") == 24
