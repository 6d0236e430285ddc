"""One axis alone on the table: what drifts is told as a drift, and a step that drifts explain as well with its dwell.

Campaigns are those of the laboratory of ``physics_scenes``; a truth that is a step is named in a kind or in words.
"""

import numpy as np
import pytest
from physics_scenes import campaigns
from solved_campaigns import findings_of_lone_x

from ams.analysis.diagnostics.beliefs import OVER_TIME, STEP, AxisTests, BeliefTest
from ams.calibration.steps.steps_of_output import StepsOfOutput, UndecidedStep
from ams.findings import Finding

COUNT = 24
STEPS = {"meter-offset", "meter-gain", "sensor-change", "table-rotation"}
AS_WELL = "explains it as well"


def findings_in(scene: str, size: float, **design: object) -> list[list[Finding]]:
    return findings_of_lone_x(campaigns(scene, size, np.random.default_rng(20), COUNT, **design), COUNT)


def kinds(findings: list[Finding]) -> set[str]:
    return {finding.kind for finding in findings}


@pytest.mark.parametrize(("scene", "size"), [("drift-warm-up", 2.0), ("temperature-self-heating", 1.0)])
def test_a_drift_that_has_just_been_seen_is_no_step_of_meter_or_sensor(scene: str, size: float) -> None:
    found = findings_in(scene, size)
    assert (
        sum(bool(kinds(findings) & STEPS) for findings in found) <= COUNT // 8
    )  # of any likeliest step one in two is told
    assert sum("drift" in kinds(findings) for findings in found) >= COUNT - COUNT // 8


def test_a_step_is_told_or_named_beside_the_drift_that_explains_it_as_well() -> None:
    """A step of 0.6 standard deviations of a dwell, at any dwell but those at the ends."""
    found = findings_in("drift-step", 1.0)
    as_step = [bool(kinds(findings) & STEPS) for findings in found]
    named = [
        any("a step of the offset between" in said.text and AS_WELL in said.text for said in each) for each in found
    ]
    assert sum(one or other for one, other in zip(as_step, named, strict=True)) >= COUNT - 1
    assert sum(as_step) >= COUNT // 2


def test_a_turn_that_drift_does_not_explain_stays_a_turn() -> None:
    alone = {"sensors": 1, "reference_every": 0, "check_set": False}
    found = findings_in("slip-pitch", 2.0, **alone)
    assert sum("table-rotation" in kinds(findings) for findings in found) >= COUNT - 1


def test_what_is_either_is_told_as_the_step_where_no_drift_is_told() -> None:
    """Nothing that the dwells show is left unsaid for want of a decision."""
    step = Finding("sensor-change", f"the offset stepped; a drift {AS_WELL}", True, 1e-6)
    either = StepsOfOutput(undecided=UndecidedStep(STEP, "a step of the offset between 3 and 4", (step,)))
    tests = {OVER_TIME: BeliefTest(OVER_TIME, "drift", 1e-6), STEP: BeliefTest(STEP, "sensor-change", 1e-6)}
    drift = Finding("drift", "the offset drifts", True, 1e-6, details={"test": OVER_TIME})
    as_drift = either.beside(AxisTests(tests, {OVER_TIME: True, STEP: True}))
    assert as_drift.findings == ()
    (said,) = as_drift.with_undecided((drift,))
    assert said.text == f"the offset drifts; a step of the offset between 3 and 4 {AS_WELL}"
    as_step = either.beside(AxisTests(tests, {OVER_TIME: False, STEP: True}))
    assert as_step.findings == (step,)
    assert as_step.named == {STEP}
    assert as_step.with_undecided((drift,)) == (drift,)
