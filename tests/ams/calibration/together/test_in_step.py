"""What comes and goes in step with the replications is told as that, as far as the order of the points lets it be seen.

Readings are made here from gravity in package axes: three axes at 2.5 V/g, 1.65″ a dwell, thirteen pitch angles by
twelve roll angles in six replications; a disturbance of so many periods over the 156 dwells of a replication.
"""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from physics_scenes import campaigns
from physics_scenes.rotations import ARCSEC
from solved_campaigns import rows_of, solved

from ams.analysis.diagnostics.beliefs import IN_STEP
from ams.calibration.calibrate import calibrate
from ams.calibration.output.believed import evidence_of
from ams.calibration.together.in_step import judge_in_step
from ams.calibration.together.in_step_found import InStep
from ams.calibration_result import Calibration
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from ams.statistics.intervals import t_quantile

FloatArray = NDArray[np.float64]
SHARE = 0.05 / 38.0
REPLICATIONS, DWELLS = 6, 156
V_PER_ARCSEC = 2.5 * ARCSEC
SENSITIVITY = np.array([[2.5, 0.01, 0.02], [-0.015, 2.48, 0.012], [0.02, -0.011, 2.52]])
"""V/g: of x, y and z along x, y and z."""
THERE, BACK = range(0, 13, 2), range(11, 0, -2)
GRID = [(15.0 * p - 90.0, 30.0 * r - 180.0) for p in (*THERE, *BACK) for r in range(12)[:: (-1) ** p]]
SINE, COSINE = -0.5 * np.pi, 0.0
"""Phases."""
Disturbance = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
"""(N,) phases of a replication, pitch and roll to (N, 3) volts."""


def measured(disturbance: Disturbance, seed: int, *, order: str = "there-and-back", axes: str = "xyz") -> Observations:
    """Return a campaign; ``order``: "random" is drawn anew for every replication."""
    chance = np.random.default_rng(seed)
    kept = [np.arange(DWELLS) if order != "random" else chance.permutation(DWELLS) for _ in range(REPLICATIONS)]
    point = np.concatenate(kept)
    pitch, roll = np.deg2rad(np.array(GRID)[point]).T
    phase = 2.0 * np.pi * np.tile(np.arange(DWELLS), REPLICATIONS) / DWELLS
    force = np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)], axis=1)
    read = 0.005 + force @ SENSITIVITY.T + disturbance(phase, pitch, roll)
    read += 1.65 * V_PER_ARCSEC * chance.standard_normal(force.shape)
    outputs = {axis: read[:, "xyz".index(axis)] for axis in axes}
    replication = np.repeat(np.arange(REPLICATIONS), DWELLS)
    return Observations(replication, point, pitch, roll, outputs, time_s=np.arange(0.0, 30.0 * point.size, 30.0))


def still(phase: FloatArray, pitch: FloatArray, roll: FloatArray) -> FloatArray:
    return np.zeros((phase.size, 3))


def voltage(
    arcsec: float, phase: float, periods: int = 1, by_output: tuple[float, float, float] = (1, 1, 1)
) -> Disturbance:
    """Return a wave on the outputs, on each times its part of ``by_output``."""
    return lambda at, pitch, roll: np.outer(arcsec * V_PER_ARCSEC * np.cos(periods * at + phase), by_output)


def rocking(arcsec: float, phase: float) -> Disturbance:
    """Return a base that tilts to and fro about its forward axis, once a replication."""

    def tilted(at: FloatArray, pitch: FloatArray, roll: FloatArray) -> FloatArray:
        sideways = np.stack([0.0 * roll, np.cos(roll), -np.sin(roll)], axis=1)
        return np.asarray((arcsec * ARCSEC * np.cos(at + phase))[:, None] * sideways @ SENSITIVITY.T)

    return tilted


def told(found: Calibration) -> list[Finding]:
    return [said for axis in found.axes.values() for said in axis.findings if said.is_significant]


def in_step(found: Calibration) -> list[Finding]:
    return [said for said in told(found) if said.details["test"] == IN_STEP]


def fit(rows: Observations) -> Calibration:
    return calibrate(rows, CalibrationRequest())


@pytest.mark.parametrize("periods", [1, 2, 3])
def test_one_voltage_on_all_outputs_is_told_with_its_size_and_as_nothing_else(periods: int) -> None:
    """It was a memory of the sensor, and a lack of fit."""
    found = fit(measured(voltage(1.0, SINE, periods), 3))
    assert [said.kind for said in told(found)] == ["meter-offset"] * 3
    said = in_step(found)[0]
    assert float(said.details["amplitude_v"] or 0.0) == pytest.approx(V_PER_ARCSEC, abs=0.2 * V_PER_ARCSEC)
    assert said.details["periods_in_a_replication"] == str(periods)
    assert not said.is_held
    assert found.verdict == "not usable"


def test_a_base_that_tilts_to_and_fro_is_told_as_that() -> None:
    found = fit(measured(rocking(2.0, SINE), 4))
    said = in_step(found)
    assert [each.kind for each in said] == ["table-rotation"] * 3
    assert float(said[0].details["amplitude_arcsec"] or 0.0) == pytest.approx(2.0, abs=0.5)
    assert found.verdict == "not usable"


def test_what_each_output_has_of_its_own_is_told_of_each() -> None:
    found = fit(measured(voltage(2.0, SINE, by_output=(0.0, 1.0, -0.7)), 5))
    said = in_step(found)
    assert [each.kind for each in said] == ["autocorrelation"] * 3
    assert float(said[0].details["amplitude_arcsec"] or 0.0) == pytest.approx(2.0, abs=0.4)


def test_what_goes_with_the_attitudes_is_told_by_nothing_and_passes_for_a_sensitivity() -> None:
    """There and back, one cosine a replication is −sin of pitch at every point: no test can see it."""
    undisturbed, disturbed = (fit(measured(wave, 6)) for wave in (still, voltage(2.0, COSINE)))
    assert not in_step(disturbed)
    moved = np.array([disturbed.axes[axis].primary[1] - undisturbed.axes[axis].primary[1] for axis in "xyz"])
    np.testing.assert_allclose(moved, -2.0 * V_PER_ARCSEC, rtol=0.1)


@pytest.mark.parametrize("phase", [SINE, COSINE])
def test_an_order_drawn_anew_for_every_replication_makes_noise_of_it_and_tells_it_whole(phase: float) -> None:
    """It was a settling at the start of every replication, and not usable, in one campaign of three."""
    held = []
    for seed in range(4):
        found = fit(measured(voltage(2.0, phase), seed, order="random"))
        assert [said.kind for said in in_step(found)] == ["meter-offset"] * 3
        assert not {"drift", "autocorrelation"} & {said.kind for said in told(found)}
        assert float(in_step(found)[0].details["amplitude_v"] or 0.0) == pytest.approx(2.0 * V_PER_ARCSEC, rel=0.15)
        assert found.verdict == "usable"
        for row, axis in enumerate("xyz"):
            solution = found.axes[axis]
            half = t_quantile(0.95, solution.primary_dof[1:4]) * np.sqrt(np.diag(solution.primary_covariance)[1:4])
            held.extend(np.abs(solution.primary[1:4] - SENSITIVITY[row]) <= half)
    assert np.mean(held) >= 0.85


def test_a_lone_axis_is_not_asked() -> None:
    assert not in_step(fit(measured(voltage(2.0, SINE), 7, axes="y")))


def judged(scene: str, size: float, count: int, level: float, seed: int, **design: object) -> list[InStep | None]:
    alone = {"sensors": 1, "reference_every": 0, "check_set": False, "order": "there-and-back"}
    drawn = campaigns(scene, size, np.random.default_rng(seed), count, **{**alone, **design})
    rows = rows_of(drawn)
    evidence = {axis: evidence_of(columns, rows) for axis, columns in solved(drawn).items()}
    return [judge_in_step([(evidence[axis], index) for axis in "xyz"], level) for index in range(drawn.campaigns)]


@pytest.mark.parametrize("order", ["there-and-back", "raster", "random"])
def test_where_nothing_is_wrong_it_is_told_no_more_often_than_the_level(order: str) -> None:
    """Nine waves are asked for, some of which have much in common: Bonferroni's bound is not reached."""
    level, runs = 0.05, 200
    found = judged("clean", 0.0, runs, level, 7, order=order, pitch_count=9, roll_count=8, replications=4)
    share = np.mean([each is not None for each in found])
    assert 0.0 < share <= level + 3.0 * np.sqrt(level / runs)


@pytest.mark.parametrize(
    ("scene", "size"),
    [("soft-mount", 50.0), ("k3", 50.0), ("table-once", 20.0), ("table-teeth", 20.0), ("table-wrong-zero", 100.0)],
)
def test_neither_terms_of_sensors_nor_errors_of_the_table_pass_for_it(scene: str, size: float) -> None:
    assert sum(found is not None for found in judged(scene, size, 30, SHARE, 22)) <= 1
