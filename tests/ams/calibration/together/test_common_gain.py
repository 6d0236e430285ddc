"""A gain of the meter that changed between replications is told by all outputs together, and by no lone one."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from physics_scenes import Campaign, campaigns
from solved_campaigns import columns_of, rows_of, rows_of_package

from ams.arrays import FloatArray
from ams.calibration.calibrate import calibrate
from ams.calibration.together.common_gain import GAIN
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest, select_rows

PPM = 1e-6
Gain = Callable[[FloatArray, str], FloatArray]
"""Of the replications (N,) and the axis, what is read of one."""


def _found(drawn: Campaign, gain: Gain, without: Sequence[int] = ()) -> list[list[Finding]]:
    """Return what is told of the gain of the meter, campaign by campaign, each of its axes after the other."""
    kept = ~np.isin(np.arange(rows_of(drawn).rows), without)
    found = []
    for index in range(drawn.campaigns):
        whole = rows_of_package(drawn, index)
        replication = np.asarray(whole.replication)
        read = {axis: values * gain(replication - replication.min(), axis) for axis, values in whole.outputs.items()}
        rows = select_rows(replace(whole, outputs=read), kept)
        axes = calibrate(rows, CalibrationRequest()).axes.values()
        found.append([said for axis in axes for said in axis.findings if said.kind == "meter-gain"])
    return found


def _between(told: list[list[Finding]]) -> list[list[Finding]]:
    """Return what is said of the campaigns in which a gain between replications is told."""
    found = ([said for said in findings if said.details["test"] == GAIN] for findings in told)
    return [findings for findings in found if findings]


def _stepped(ppm: float, *axes: str, at: int = 3) -> Gain:
    return lambda replication, axis: 1.0 + ppm * PPM * (replication >= at) * (axis in axes)


def _clean(count: int, seed: int = 5) -> Campaign:
    return campaigns("clean", 0.0, np.random.default_rng(seed), count)


def test_a_gain_of_the_meter_is_told_between_which_replications_and_with_its_size() -> None:
    drawn = _clean(24)
    told, third = _found(drawn, _stepped(2.5, "x", "y", "z")), int(np.min(rows_of(drawn).replication)) + 2
    named = _between(told)
    assert len(named) >= 5  # beside those in which the search between all dwells finds a step
    assert sum(map(bool, told)) >= 12
    for findings in named:
        assert len(findings) == 3  # of every axis
        assert all(finding.is_significant and not finding.is_held for finding in findings)
        assert all(f"{axis} " in findings[0].fact for axis in "xyz")
    sizes = np.array([[finding.details["size"], finding.details["standard_uncertainty"]] for (finding, *_) in named])
    assert np.all(np.abs(sizes[:, 0] - 2.5) <= 3.0 * sizes[:, 1])
    assert np.mean([f"between replications {third} and {third + 1}" in findings[0].fact for findings in named]) >= 0.5


def test_dwells_that_are_missing_hide_no_gain() -> None:
    assert _between(_found(_clean(16), _stepped(2.5, "x", "y", "z"), without=[7, 200, 201, 640]))


def test_what_one_sensor_does_or_each_does_otherwise_is_no_gain_of_the_meter() -> None:
    assert not _between(_found(_clean(6), _stepped(8.0, "y")))

    def opposite(replication: FloatArray, axis: str) -> FloatArray:
        return _stepped(-3.0 if axis == "z" else 3.0, "x", "y", "z")(replication, axis)

    assert not _between(_found(_clean(6), opposite))


def test_where_nothing_changed_no_gain_is_told() -> None:
    assert len(_between(_found(_clean(40, seed=9), _stepped(0.0)))) <= 1


def test_a_solved_run_is_not_usable_as_it_stands_where_its_gain_changed() -> None:
    drawn = _clean(1)
    rows = rows_of(drawn)
    late = np.asarray(rows.replication) >= np.median(rows.replication)
    outputs = {axis: columns_of(drawn, axis)[:, 0] * (1.0 + 5.0 * PPM * late) for axis in drawn.setup.axes}
    solution = calibrate(replace(rows, outputs=outputs), CalibrationRequest())
    for axis in solution.axes.values():
        assert any("meter" in warning for warning in axis.warnings)
