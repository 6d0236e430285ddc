"""An axis that reads far less or more than the others of its package is told, unless somebody declared how much."""

from dataclasses import replace
from typing import Any

import calrig
import numpy as np
import pandas as pd
import pytest
from physics_scenes import campaigns
from solved_campaigns import rows_of_package

from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.findings import Finding
from ams.inputs.declared_direction import DeclaredDirection, NominalSensitivity
from ams.inputs.request import CalibrationRequest


def solved(factors: dict[str, float], declared: dict[str, float] | None = None) -> Calibration:
    """Return a package of which some outputs read a factor times what they should; ``declared``: V/g of some axes."""
    drawn = campaigns("wave-along-pitch", 0.0, np.random.default_rng(3), 1, pitch_count=7, roll_count=8)
    rows = rows_of_package(drawn, 0)
    outputs = {axis: factors.get(axis, 1.0) * read for axis, read in rows.outputs.items()}
    stated = {
        axis: DeclaredDirection(axis, sensitivity=NominalSensitivity(size)) for axis, size in (declared or {}).items()
    }
    return calibrate(replace(rows, outputs=outputs), CalibrationRequest(declared=stated))


def told(calibration: Calibration) -> dict[str, Finding]:
    return {
        label: finding
        for label, axis in calibration.axes.items()
        for finding in axis.findings
        if finding.is_significant and "of the other axes" in finding.text
    }


@pytest.mark.parametrize(
    ("factors", "unlike"),
    [
        ({}, set()),
        ({"x": 0.1}, set()),
        ({"x": 0.2, "y": 5.0}, set()),
        ({"x": 0.01}, {"x"}),
        ({"z": -1e3}, {"z"}),
        ({"x": 0.001, "z": 1e3}, {"x", "z"}),
    ],
)
def test_the_axis_that_is_unlike_is_told_by_its_name(factors: dict[str, float], unlike: set[str]) -> None:
    calibration = solved(factors)
    assert set(told(calibration)) == unlike
    assert all(finding.text in calibration.axes[label].warnings for label, finding in told(calibration).items())
    assert calibration.verdict == "usable"
    assert not calibration.unusable_axes


def test_a_declared_sensitivity_is_what_an_axis_is_held_against_instead() -> None:
    volts = abs(float(solved({}).axes["x"].primary[1]))
    meant = solved({"x": 0.01}, {"x": 0.01 * volts})
    assert not told(meant)


def lines(factors: tuple[float, ...], unit: str) -> Any:
    """Return the documents of lines of the same levels in µT; each reads a factor times that, with noise, in a unit."""
    chance, levels = np.random.default_rng(4), np.tile(np.linspace(-50.0, 50.0, 5), 4)
    read = {
        f"m{axis}_{unit}": factor * (levels + 0.05 * chance.standard_normal(levels.size))
        for axis, factor in zip("xyz", factors, strict=False)
    }
    labels = {"replication": np.repeat(range(1, 5), 5), "point": np.tile(range(1, 6), 4), "reference_ut": levels}
    axes = {axis: f"m{axis}_{unit}" for axis, _ in zip("xyz", factors, strict=False)}
    return calrig.fit(pd.DataFrame(labels | read), axes, model="linear").document["axes"]


@pytest.mark.parametrize(("factors", "unlike"), [((1.0, 0.5, 0.01), "z"), ((0.01, 1.0), "x"), ((1.0, 0.5, 0.2), "")])
def test_lines_are_held_against_each_other(factors: tuple[float, ...], unlike: str) -> None:
    axes = lines(factors, "counts")
    assert {axis for axis, found in axes.items() if "of the other axes" in str(found["findings"])} == set(unlike)


def test_a_line_that_reads_in_the_unit_of_its_levels_is_held_against_that_unit() -> None:
    axes = lines((1.0, 1.1, 10.0), "ut")
    said = {axis: str(found["findings"]) for axis, found in axes.items()}
    assert [axis for axis, text in said.items() if "the numbers look like mG" in text] == ["z"]
    assert not any("of the other axes" in text for text in said.values())
