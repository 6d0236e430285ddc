"""An amplifier that meets its rail at both ends is no transient, where replications begin at one of them."""

import numpy as np
from physics_scenes import campaigns
from solved_campaigns import findings_of_lone_x

from ams.analysis.diagnostics.beliefs import SETTLING
from ams.findings import Finding

COUNT = 24


def findings_in(scene: str, size: float) -> list[list[Finding]]:
    return findings_of_lone_x(campaigns(scene, size, np.random.default_rng(20), COUNT), COUNT)


def settling(findings: list[Finding]) -> list[Finding]:
    return [finding for finding in findings if finding.details.get("test") == SETTLING]


def test_rails_just_inside_of_one_g_are_no_settling() -> None:
    """0.01 % inside: pitch of ±90° reads short by up to 20″, and replications begin at −90°."""
    found = findings_in("saturation", 0.01)
    assert sum(bool(settling(each)) for each in found) <= 1  # in eight of ten, with a size of 10″
    ends = {"cubic", "lack-of-fit"}  # a bend, or the one index at which the output is off
    assert sum(any(said.kind in ends for said in each) for each in found) >= COUNT // 2


def test_a_transient_that_is_there_is_told_and_says_what_an_index_would_do() -> None:
    found = findings_in("drift-settling", 2.0)
    settled = [said for each in found for said in settling(each)]
    assert len(settled) >= COUNT - 1
    assert all("or indices of the table are wrong, of which nothing is declared" in said.text for said in settled)
