"""An amplifier that meets its rail at both ends is no transient, where replications begin at one of them."""

from dataclasses import replace

import numpy as np
from physics_scenes import campaigns
from solved_campaigns import rows_of_package

from ams.analysis.diagnostics.beliefs import SETTLING
from ams.calibration.packages import calibrate_packages
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest

COUNT = 24


def told_of_x(scene: str, size: float) -> list[list[Finding]]:
    """Return the significant findings of x, seen alone, of each campaign."""
    drawn = campaigns(scene, size, np.random.default_rng(20), COUNT)
    every = (rows_of_package(drawn, place) for place in range(COUNT))
    seen = (replace(rows, outputs={"x": rows.outputs["x"]}) for rows in every)
    found = (calibrate_packages({"p": rows}, CalibrationRequest())["p"].axes["x"] for rows in seen)
    return [[finding for finding in axis.findings if finding.is_significant] for axis in found]


def settling(findings: list[Finding]) -> list[Finding]:
    return [finding for finding in findings if finding.details.get("test") == SETTLING]


def test_rails_just_inside_of_one_g_are_no_settling() -> None:
    """0.01 % inside: pitch of ±90° reads short by up to 20″, and replications begin at −90°."""
    found = told_of_x("saturation", 0.01)
    assert sum(bool(settling(each)) for each in found) <= 1  # in eight of ten, with a size of 10″
    assert sum(any(said.kind == "cubic" for said in each) for each in found) >= COUNT // 2


def test_a_transient_that_is_there_is_told_and_says_what_an_index_would_do() -> None:
    found = told_of_x("drift-settling", 2.0)
    told = [said for each in found for said in settling(each)]
    assert len(told) >= COUNT - 1
    assert all("or indices of the table are wrong, of which nothing is declared" in said.text for said in told)
