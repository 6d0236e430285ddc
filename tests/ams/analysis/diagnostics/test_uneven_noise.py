"""A replication that was shaken is told as that: no change of the sensor, no memory, and its own wrong dwells only."""

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from physics_scenes import Campaign, campaigns, mixed
from solved_campaigns import columns_of, rows_of

from ams.analysis.diagnostics.residuals import grid_residuals
from ams.analysis.diagnostics.uneven_noise import uneven_noise
from ams.calibration.calibrate import calibrate
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest

Noise = Callable[[np.random.Generator, tuple[int, ...]], NDArray[np.float64]]
CHANGES = {"sensor-change", "table-rotation", "meter-gain", "meter-offset", "autocorrelation", "wrong-dwell"}


def _significant(drawn: Campaign, index: int) -> dict[str, list[Finding]]:
    """Return what is told of each axis of one campaign."""
    time_s = drawn.schedule.time_s[drawn.schedule.grid_rows()].ravel()
    outputs = {axis: columns_of(drawn, axis)[:, index] for axis in drawn.setup.axes}
    rows = replace(rows_of(drawn), time_s=time_s, outputs=outputs)
    solved = calibrate(rows, CalibrationRequest(nominal_axes={axis: axis for axis in outputs}))
    return {
        axis: [finding for finding in found.findings if finding.is_significant] for axis, found in solved.axes.items()
    }


@pytest.mark.parametrize("louder", [3.0, 9.0])
def test_a_noisy_replication_is_named_and_nothing_else_is_blamed_for_it(louder: float) -> None:
    """Its noise was told as changes of the sensor that came back, and as memories of 4600″, in a good part of them."""
    drawn = campaigns("noisy-replication", louder, np.random.default_rng(3), 12)
    blamed = 0
    for index in range(drawn.campaigns):
        told = _significant(drawn, index)
        of_noise = [finding for found in told.values() for finding in found if finding.kind == "uneven-noise"]
        assert len(of_noise) == 3
        which = {re.search(r"replication (\d+) scatters ([\d.]+) times", finding.text) for finding in of_noise}
        assert None not in which
        ratios = [float(found.group(2)) for found in which if found is not None]
        assert ratios == pytest.approx([1.0 + louder] * len(ratios), rel=0.3)
        assert len({found.group(1) for found in which if found is not None}) == 1
        blamed += any(finding.kind in CHANGES for found in told.values() for finding in found)
    assert blamed <= 2


@pytest.mark.parametrize("noise", [np.random.Generator.standard_normal, lambda chance, n: chance.standard_t(5, n)])
def test_even_noise_is_told_as_uneven_no_more_often_than_stated(noise: Noise) -> None:
    """Also where its tails are long: of Student's t with five degrees of freedom."""
    chance, replications, points = np.random.default_rng(8), 6, 78
    basis, dwells = chance.standard_normal((points, 4)), np.arange(replications * points)
    found = []
    for _ in range(1500):
        grid = grid_residuals(basis, noise(chance, (dwells.size,))[:, None], dwells, replications, points)
        test = uneven_noise(grid)
        assert test is not None
        found.append(test.p_value)
    assert np.mean(np.array(found) <= 0.01) <= 0.02
    assert np.mean(np.array(found) <= 0.05) <= 0.075


def test_a_slip_is_still_the_tables_in_a_run_with_a_noisy_replication() -> None:
    drawn = mixed({"noisy-replication": 3.0, "slip-roll": 72.0}, np.random.default_rng(6), 8)
    for index in range(drawn.campaigns):
        kinds = {finding.kind for found in _significant(drawn, index).values() for finding in found}
        assert "table-rotation" in kinds
        assert "sensor-change" not in kinds


def test_a_wrong_dwell_of_a_noisy_replication_is_told_as_far_off_as_it_reads() -> None:
    """Judged by the noise of its own replication, and told in the size that the file has."""
    drawn = mixed({"noisy-replication": 3.0, "wrong-dwell": 100.0}, np.random.default_rng(9), 30)
    sizes = []
    for index in range(drawn.campaigns):
        axis = drawn.setup.axes[drawn.event.axis[index]]
        wrong = [finding for finding in _significant(drawn, index)[axis] if finding.kind == "wrong-dwell"]
        assert len(wrong) == 1
        size = re.search(r"is off by (−?)([\d.]+)″", wrong[0].text)
        assert size is not None
        sizes.append(float(size.group(2)))
    assert np.median(sizes) == pytest.approx(165.0, rel=0.05)  # in two digits
    assert np.all(np.abs(np.array(sizes) - 165.0) < 0.2 * 165.0)
