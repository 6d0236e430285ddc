"""What changed in mid-run as it concerns one output, and what becomes of its tests."""

from dataclasses import dataclass, replace
from typing import Final

from ams.analysis.diagnostics.beliefs import BY_A_DRIFT, DRIFT_OF, OVER_TIME, SLIP, STEP, AxisTests, BeliefTest
from ams.calibration.steps.step_columns import Changed, Drifting
from ams.findings import Finding


@dataclass(frozen=True)
class UndecidedStep:
    """A change of one output that a drift explains as well."""

    test: str
    words: str
    """What changed, and between which dwells."""
    findings: tuple[Finding, ...]
    """Significant, of what is told where no drift is."""


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
    drifting: frozenset[Drifting] = frozenset()
    """What drifts evenly beside them."""
    undecided: UndecidedStep | None = None

    def beside(self, tests: AxisTests) -> "StepsOfOutput":
        """Return the same with a change that is undecided told where no drift is; where one is, the drift says it."""
        undecided = self.undecided
        if undecided is None or any(map(_is_drift, filter(tests.is_significant.get, tests.tests))):
            return self
        named, findings = self.named | {undecided.test}, (*self.findings, *undecided.findings)
        return replace(self, named=named, findings=findings, undecided=None)

    def with_undecided(self, findings: tuple[Finding, ...]) -> tuple[Finding, ...]:
        """Return the findings of an output, the first that tells a drift with the change that explains it as well."""
        undecided = self.undecided
        drifts = (at for at, said in enumerate(findings) if said.is_significant and _is_drift(said.details.get("test")))
        at = None if undecided is None else next(drifts, None)
        if undecided is None or at is None:
            return findings
        said = findings[at].adding(f"{undecided.words} explains it as well")
        return (*findings[:at], said, *findings[at + 1 :])


NO_STEPS: Final = StepsOfOutput()


def _is_drift(test: object) -> bool:
    """Return whether a test tells of a drift through the run."""
    return isinstance(test, str) and (test == OVER_TIME or test.startswith(DRIFT_OF))


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
