"""What is said of a test that another finding explains: the explanation is the test's own, whatever its name."""

import pytest

from ams.analysis.diagnostics.beliefs import (
    BY_A_DRIFT,
    BY_TEMPERATURE,
    BY_THE_DWELL_BEFORE,
    DRIFT_OF,
    ROBUST,
    SETTLING,
    STEP,
    AxisTests,
    BeliefTest,
)
from ams.analysis.diagnostics.size_words import AxisWords, Scale
from ams.analysis.diagnostics.words.wording import findings_of
from ams.findings import EXPLAINED_BY, Finding, Said

WORDS = AxisWords(
    Scale("V", 1.0),
    0.001,
    has_table=False,
    is_of_levels=False,
    order_repeats=False,
    lack_is=Said("it is held"),
    drift_is="it is held",
    drifts={},
)


@pytest.mark.parametrize("explained_by", [BY_A_DRIFT, BY_TEMPERATURE, BY_THE_DWELL_BEFORE])
@pytest.mark.parametrize("name", [SETTLING, f"{DRIFT_OF}offset", ROBUST, STEP])
def test_what_explains_a_test_is_told_as_the_test_carries_it(name: str, explained_by: str) -> None:
    test = BeliefTest(name, "drift", 1e-9, 1e-6, 1e-7, explained_by=explained_by)
    (finding,) = findings_of(AxisTests({name: test}, {name: False}), WORDS, {})
    assert finding.fact.startswith(f"{name}: explained by {explained_by}")
    assert finding.details[EXPLAINED_BY] == explained_by
    assert not finding.what_to_do


@pytest.mark.parametrize("is_held", [True, False])
def test_a_finding_blocks_the_verdict_as_its_test_says(is_held: bool) -> None:
    test = BeliefTest(SETTLING, "drift", 1e-9, 1e-6, 1e-7, is_held=is_held)
    (finding,) = findings_of(AxisTests({SETTLING: test}, {SETTLING: True}), WORDS, {})
    assert finding.is_held == is_held
    assert EXPLAINED_BY not in finding.details


def test_a_change_in_mid_run_is_told_by_its_diagnosis_alone() -> None:
    tests = AxisTests({STEP: BeliefTest(STEP, "sensor-change", 1e-9)}, {STEP: True})
    assert findings_of(tests, WORDS, {}) == ()
    worded = Finding("sensor-change", "the offset stepped", is_significant=True)
    assert findings_of(tests, WORDS, {STEP: worded}) == (worded,)
