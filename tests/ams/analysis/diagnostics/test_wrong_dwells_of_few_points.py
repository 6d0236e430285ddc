"""A dwell that is wrong among six points: named, and not mistaken for a sensor that changed between replications."""

import numpy as np
import pytest
from numpy.typing import NDArray

from ams.calibration.calibrate import calibrate
from ams.calibration_result import AxisCalibration
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

FloatArray = NDArray[np.float64]
SIX = np.deg2rad([(90.0, 0.0), (-90.0, 0.0), (0.0, 0.0), (0.0, 90.0), (0.0, 180.0), (0.0, -90.0)])
NOISE_V, SENSITIVITY_V_PER_G = 2e-5, 2.5


def _solved(replications: int, added_sd: FloatArray, chance: np.random.Generator) -> AxisCalibration:
    """Solve six points; ``added_sd`` (n, 6) is what the output has beside its noise, in standard deviations of it."""
    pitch, roll = np.tile(SIX, (replications, 1)).T
    force = specific_force(pitch, roll)
    noise = chance.standard_normal(pitch.size) + added_sd.ravel()
    outputs = 0.002 + force @ [SENSITIVITY_V_PER_G, 0.015, -0.01] + NOISE_V * noise
    replication, point = np.divmod(np.arange(pitch.size), len(SIX))
    rows = Observations(replication + 1, point + 1, pitch, roll, {"x": outputs})
    return calibrate(rows, CalibrationRequest()).axes["x"]


def _named(solved: AxisCalibration) -> list[str]:
    return [entry.text for entry in solved.findings if entry.kind == "wrong-dwell" and entry.is_significant]


def _remarks(solved: AxisCalibration) -> list[str]:
    return [text for text in solved.remarks if "a single one that is wrong is found only from" in text]


@pytest.mark.parametrize(("replications", "size", "least"), [(4, 10.0, 0.85), (4, 30.0, 1.0), (3, 15.0, 0.85)])
def test_one_wrong_dwell_of_six_points_is_named(replications: int, size: float, least: float) -> None:
    """Its replication's own sensitivities took two thirds of it: none of 10 σ in four replications was named."""
    named = []
    for seed in range(20):
        chance = np.random.default_rng([1, seed])
        replication, point = int(chance.integers(replications)), int(chance.integers(len(SIX)))
        added = np.zeros((replications, len(SIX)))
        added[replication, point] = size * chance.choice([-1.0, 1.0])
        said = _named(_solved(replications, added, chance))
        named.append(len(said) == 1 and f"replication {replication + 1}, point {point + 1} " in said[0])
    assert np.mean(named) >= least


@pytest.mark.parametrize("size", [5.0, *(pytest.param(size, marks=pytest.mark.thorough) for size in (0.0, 3.0, 10.0))])
@pytest.mark.parametrize("replications", [4, 8])
@pytest.mark.parametrize("which", ["one", "all"])
def test_a_sensor_that_changes_between_replications_has_no_wrong_dwell(
    which: str, replications: int, size: float
) -> None:
    """The sensitivity of one replication, or of each, differs by ``size`` standard deviations of a dwell a g."""
    rings = 0
    for seed in range(20):
        chance = np.random.default_rng([2, seed])
        change = chance.standard_normal((replications, 3)) if which == "all" else np.zeros((replications, 3))
        if which == "one":
            change[int(chance.integers(replications)), 0] = 1.0
        rings += bool(_named(_solved(replications, size * change @ specific_force(*SIX.T).T, chance)))
    assert rings <= 2


@pytest.mark.parametrize(("replications", "share"), [(2, 1.0), (4, 0.2)])
def test_what_so_few_dwells_do_not_find_is_a_remark(replications: int, share: float) -> None:
    """Two replications find a wrong dwell from far off only; four find one of seven σ, unless they differ by chance."""
    none = np.zeros((replications, len(SIX)))
    remarks = [_remarks(_solved(replications, none, np.random.default_rng([3, seed]))) for seed in range(10)]
    assert np.mean([bool(said) for said in remarks]) == pytest.approx(share, abs=0.2)
    assert all("standard deviations of a dwell on (" in text for said in remarks for text in said)


def test_a_transient_that_six_points_do_not_tell_is_a_remark() -> None:
    """It goes the same way through the points in every replication, and passes for offset and sensitivities."""
    settles = 15.0 * np.exp(-2.0 * np.arange(len(SIX))) * np.ones((4, 1))
    solved = _solved(4, settles, np.random.default_rng(4))
    told = [entry for entry in solved.findings if entry.is_significant and "settling" in str(entry.details.get("test"))]
    assert told or any("settles at the start of every replication is not told" in text for text in solved.remarks)


@pytest.mark.parametrize(("replications", "is_few"), [(4, True), (12, False)])
def test_what_few_dwells_tell_of_a_share_of_them_and_of_a_step_is_a_remark(replications: int, is_few: bool) -> None:
    """Five of 24 that read 8 standard deviations high are told by nothing."""
    chance = np.random.default_rng(5)
    added = np.zeros(replications * len(SIX))
    added[chance.choice(added.size, added.size // 5, replace=False)] = 8.0
    solved = _solved(replications, added.reshape(replications, len(SIX)), chance)
    said = [text for text in solved.remarks if "do not tell a fifth of them" in text]
    assert bool(said) == is_few
    assert all("no change of table, meter or sensor in mid-run is looked for" in text for text in said)
