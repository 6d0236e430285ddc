"""Dwells at a rail are told as that, and neither a coarse meter nor attitudes that repeat as one."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from physics_scenes import campaigns
from solved_campaigns import columns_of, rows_of

from ams.analysis.diagnostics.clipped import is_rail_by_expectation
from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest

Floats = NDArray[np.float64]


def _outputs(seed: int, **design: float) -> tuple[object, dict[str, Floats]]:
    drawn = campaigns("use-good", 0.0, np.random.default_rng(seed), 1, **design).calibration
    return drawn, {axis: columns_of(drawn, axis)[:, 0] for axis in "xyz"}


def _solved(drawn: object, outputs: dict[str, Floats]) -> Calibration:
    rows = rows_of(drawn)
    return calibrate(replace(rows, outputs=outputs, step=np.arange(1, rows.rows + 1)), CalibrationRequest())


def _clipped(solved: Calibration) -> dict[str, Finding]:
    return {
        axis: finding
        for axis, found in solved.axes.items()
        for finding in found.findings
        if finding.kind == "output-clipped"
    }


@pytest.mark.parametrize("pitch_limit_deg", [60.0, 90.0])
@pytest.mark.parametrize("share", [0.001, 0.015, 0.2])
@pytest.mark.parametrize("sides", [1, 2])
def test_a_rail_is_told_and_not_as_a_bend(pitch_limit_deg: float, share: float, sides: int) -> None:
    drawn, outputs = _outputs(3, pitch_limit_deg=pitch_limit_deg)
    read = outputs["z"]
    high = read.max() * (1.0 - share)
    low = read.min() * (1.0 - share) if sides == 2 else -np.inf
    is_cut = (read >= high) | (read <= low)
    solved = _solved(drawn, {**outputs, "z": np.clip(read, low, high)})
    found = _clipped(solved)
    assert set(found) == {"z"}
    assert set(found["z"].steps) == set((np.flatnonzero(is_cut) + 1).tolist())
    assert solved.verdict == "not usable"
    assert set(solved.unusable_axes) == {"z"}
    bends = {"quadratic", "cubic", "asymmetry", "cross-coupling"}
    assert not [one for one in solved.axes["z"].findings if one.kind in bends and one.is_significant]


@pytest.mark.parametrize("step_v", [1e-6, 1e-5, 5e-5, 5e-4, 5e-3])
@pytest.mark.parametrize("noise_arcsec", [0.0, 0.2, 1.65])
def test_steps_of_a_coarse_meter_are_no_rail(step_v: float, noise_arcsec: float) -> None:
    for limit in (30.0, 90.0):
        drawn, outputs = _outputs(4, pitch_limit_deg=limit, noise_arcsec=noise_arcsec)
        rounded = {axis: np.rint(values / step_v) * step_v for axis, values in outputs.items()}
        assert not _clipped(_solved(drawn, rounded))


def test_a_rail_behind_a_coarse_meter_is_told() -> None:
    drawn, outputs = _outputs(5)
    coarse = np.rint(np.minimum(outputs["y"], 0.9 * outputs["y"].max()) / 5e-4) * 5e-4
    assert set(_clipped(_solved(drawn, {**outputs, "y": coarse}))) == {"y"}


@pytest.mark.parametrize("replications", [1, 6])
def test_attitudes_that_repeat_without_noise_are_no_rail(replications: int) -> None:
    """At pitch ±90° x reads one number at every roll."""
    drawn, outputs = _outputs(6, pitch_limit_deg=90.0, noise_arcsec=0.0, replications=replications)
    bent = {axis: values + 1e-4 * (values / 2.5) ** 3 for axis, values in outputs.items()}
    for read in (outputs, bent):
        assert not _clipped(_solved(drawn, read))


@pytest.mark.parametrize("replications", [2, 3])
@pytest.mark.parametrize("share", [0.0005, 0.004])
def test_a_rail_that_one_attitude_met_in_few_replications_is_told(replications: int, share: float) -> None:
    drawn, outputs = _outputs(9, pitch_limit_deg=60.0, replications=replications)
    read = outputs["z"]
    found = _clipped(_solved(drawn, {**outputs, "z": np.minimum(read, read.max() * (1.0 - share))}))
    assert set(found) == {"z"}


@pytest.mark.parametrize("step_v", [1e-6, 2e-5])
@pytest.mark.parametrize("seed", range(20))
def test_two_equal_readings_behind_a_meter_are_no_rail(step_v: float, seed: int) -> None:
    drawn, outputs = _outputs(20 + seed, replications=2)
    assert not _clipped(_solved(drawn, {axis: np.rint(values / step_v) * step_v for axis, values in outputs.items()}))


@pytest.mark.parametrize(
    ("spread_sd", "is_told"), [(3.0, False), (6.5, False), (15.0, True), (25.0, True), (38.0, True)]
)
def test_equal_readings_are_a_rail_where_no_noise_would_bring_them_together(spread_sd: float, is_told: bool) -> None:
    """The range of 12 normal readings is above 6.4 standard deviations once in a thousand times (Harter's tables);
    behind a meter as coarse as that they may be equal, and 15 apart they may not."""
    sd, attitudes = 1e-5, 40
    output = np.linspace(-2.0, 2.0, attitudes)
    rows = np.arange(attitudes) >= attitudes - 12
    output[rows] = 2.0
    output[~rows] += 1e-9 * np.arange(attitudes - 12)
    output[0] = output[1] - 1e-9  # the meter is far finer than the noise
    predicted = output.copy()
    predicted[rows] += np.linspace(0.0, spread_sd * sd, 12)
    assert is_rail_by_expectation(rows, output, predicted, sd) is is_told
