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
        test = uneven_noise(grid, grid.residuals[:, 0])
        assert test is not None
        found.append(test.p_value)
    assert np.mean(np.array(found) <= 0.01) <= 0.02
    assert np.mean(np.array(found) <= 0.05) <= 0.075


@pytest.mark.parametrize(("replications", "points"), [(4, 56), (6, 156)])
@pytest.mark.parametrize("louder", [4.0, 10.0])
def test_two_loud_replications_are_both_named_and_no_third(replications: int, points: int, louder: float) -> None:
    """Each is in the mean of every point: of four, one of the two was named, or none of them, in 0.5 to 0.8."""
    chance, times = np.random.default_rng(12), np.ones(replications)
    times[[1, 2]] = louder
    basis, dwells = chance.standard_normal((points, 4)), np.arange(replications * points)
    named, ratios = [], []
    for _ in range(100):
        noise = times[:, None] * chance.standard_normal((replications, points))
        found = uneven_noise(grid_residuals(basis, noise.reshape(-1, 1), dwells, replications, points), noise.ravel())
        assert found is not None
        named.append(np.array_equal(found.excess > 1.0, times > 1.0))
        ratios.append(found.excess[[1, 2]])
    assert np.mean(named) >= 0.95
    assert np.median(ratios) == pytest.approx(louder, rel=0.1)


def test_of_replications_that_do_not_scatter_at_all_the_one_that_does_is_named() -> None:
    """A meter of few digits reads the same three times."""
    chance, readings = np.random.default_rng(15), np.zeros((4, 56))
    readings[2] = chance.standard_normal(56)
    grid = grid_residuals(np.ones((56, 1)), readings.reshape(-1, 1), np.arange(readings.size), 4, 56)
    found = uneven_noise(grid, readings.ravel())
    assert found is not None
    assert found.is_loud.tolist() == [False, False, True, False]


@pytest.mark.parametrize("design", [{"replications": 4, "pitch_count": 7, "roll_count": 8}, {}])
def test_two_loud_replications_are_blamed_on_nothing_else(design: dict[str, int]) -> None:
    """A wrong dwell was told of one axis in six of four replications; of six, what one left in the other."""
    drawn = campaigns("clean", 0.0, np.random.default_rng(13), 20, axes="x", **design)
    chance, blamed = np.random.default_rng(14), 0
    noise_v = 1.65 / 3600.0 * np.pi / 180.0 * drawn.package.sensitivity_v_per_g[:, None]
    is_loud = np.isin(drawn.schedule.replication, [0, 2])[None, :, None, None]
    output_v = drawn.output_v + 30.0 * noise_v * is_loud * chance.standard_normal(drawn.output_v.shape)
    for index in range(drawn.campaigns):
        told = _significant(replace(drawn, output_v=output_v), index)["x"]
        assert any(finding.kind == "uneven-noise" for finding in told)
        blamed += any(finding.kind != "uneven-noise" for finding in told)
    assert blamed <= 3


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
