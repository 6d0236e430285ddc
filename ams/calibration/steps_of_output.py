"""What changed in mid-run as it concerns one output, and what becomes of its tests."""

from dataclasses import dataclass, replace
from typing import Final

from ams.analysis.diagnostics.beliefs import BY_A_DRIFT, SLIP, STEP, AxisTests, BeliefTest
from ams.calibration.step_columns import Changed
from ams.findings import Finding


@dataclass(frozen=True)
class StepsOfOutput:
    """What concerns one output."""

    tests: tuple[BeliefTest, ...] = ()
    named: frozenset[str] = frozenset()
    """Names of the tests that are told; a change that is plain and no single step is not."""
    findings: tuple[Finding, ...] = ()
    """Significant, of what is told."""
    during: tuple[Changed, ...] = ()
    """What is told of any output of the package, or was proved of the table."""
    drifts: bool = False
    """Whether an even drift of the output stands beside them."""


NO_STEPS: Final = StepsOfOutput()


def with_steps(tests: AxisTests, steps: StepsOfOutput) -> AxisTests:
    """Return the tests with those of changes as significant as they are told: a drift is told as what it is."""
    searched = [name for name in (SLIP, STEP) if name in tests.tests]
    if not any(tests.is_significant[name] or name in steps.named for name in searched):
        return tests
    flags = {**tests.is_significant, **{name: name in steps.named for name in searched}}
    explained = {
        name: tests.tests[name]._replace(explained_by=BY_A_DRIFT if tests.is_significant[name] else "")
        for name in searched
        if name not in steps.named
    }
    return replace(tests, tests={**tests.tests, **explained}, is_significant=flags)
