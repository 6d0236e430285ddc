"""Counts of a board that are large beside the noise: told from the samples of a run, and foreseen."""

from pathlib import Path

import numpy as np
import pytest
from motion_runs import EXAMPLES, motion_run
from report_dwells import dwell

from ams.analysis.calibration_budget import SOURCES
from procedures.description.procedure_file import Solve
from procedures.solution.beliefs import beliefs_of
from procedures.solution.expected_points import by_lines, expected_points
from procedures.solution.observations import observations_of
from rig.description.read import read_rig
from rig.description.signal_chain import Chain

FASTER = {r"replications = 6": "replications = 4", r"samples = 60": "samples = 20", "forward-reverse": "raster"}
"""In an order that leaves the drift of the board out of what differs between replications."""
QUIET = {r"noise = 0.002": "noise = 0.0002"}
"""Of an SCA3000: a quarter of its count, 1/1333 g."""
SCA3000 = {"x": (0.996810, -0.020594), "y": (0.972952, 0.064118), "z": (0.988240, 0.024014)}
"""SR's appendix: what an axis reads of 1 g, and at none."""


def test_means_of_counts_are_uncertain_by_the_count_as_it_was_foreseen(tmp_path: Path) -> None:
    run = motion_run(tmp_path, "servo-mechanism", "accelerometer", FASTER, QUIET)
    foreseen = expected_points(run.rig, run.plan, "SCA3000", run.plan.sensors["SCA3000"], by_lines)
    solved = run.solved()
    calibration = solved.sensors["SCA3000"].calibration
    assert calibration is not None, solved.failures
    for axis, (per_g, at_zero) in SCA3000.items():
        gain, offset = calibration.axes[axis].parameters
        for found, truth in ((gain, 1.0 / per_g), (offset, -at_zero / per_g)):
            assert found.interval_95 is not None
            assert found.interval_95[0] <= truth <= found.interval_95[1], (axis, found)
        parts = {part.name: part.covariance[1, 1] ** 0.5 for part in calibration.axes[axis].variance_components}
        assert parts["resolution"] > parts["replications"]
        expected = foreseen[axis].solution.parameters[0].standard_uncertainty
        assert gain.standard_uncertainty == pytest.approx(expected, rel=0.4)
        lines = [line.source for line in solved.sensors["SCA3000"].budgets[axis].lines]
        assert SOURCES["resolution"][0] in lines


def test_what_is_believed_of_a_board_has_its_count_and_the_scatter_of_rounded_samples() -> None:
    rig = read_rig(EXAMPLES / "servo-mechanism" / "rig.toml")
    believed = beliefs_of(rig, Solve(), 60, 6, rig.sensors)["SCA3000", "x"].belief(60, 6)
    chance, count = np.random.default_rng(1), 1.0 / 1333.0
    rounded = count * np.rint(chance.uniform(0.0, 1.0, (4000, 1)) + 2.666 * chance.standard_normal((4000, 60)))
    assert believed.sampled is not None
    assert (believed.sampled.step, believed.sampled.points) == (pytest.approx(count), 6)
    assert believed.sampled.variance == pytest.approx(rounded.var(axis=1).mean(), rel=0.02)


def test_the_step_of_samples_is_told_as_they_were_read_and_brought_to_the_declared_supply() -> None:
    """Of a millivolt, at supplies that divide it out of its decimals: 5.5 V of 5 V makes 10/11 of it."""
    reads = [(-1.203, -1.202), (1.344, 1.344), (-1.202, -1.203), (1.343, 1.344)]
    rows = [
        dwell(step, replication=1 + step // 2, point=1 + step % 2, volts={"dmm.x": read, "dmm.s": (5.5, 5.5)})
        for step, read in enumerate(reads)
    ]
    chain = Chain(ratiometric=True, supply_channel="dmm.s", supply_nominal_v=5.0)
    found = observations_of(rows, {"x": "dmm.x"}, chains={"dmm.x": chain}).sampled["x"]
    assert found.step == pytest.approx(1e-3 / 1.1)
    assert found.variance == pytest.approx(0.75 * 0.25e-6 / 1.1**2)  # three of four dwells read two values
