"""What all outputs of a package show together, taken out of each before its own tests are made."""

from collections.abc import Iterator
from typing import Protocol

from ams.analysis.diagnostics.beliefs import AxisTests, BeliefTest
from ams.analysis.diagnostics.evidence import Evidence
from ams.arrays import FloatArray
from ams.findings import Finding


class PackageWide(Protocol):
    """A disturbance of a whole package."""

    @property
    def test(self) -> BeliefTest:
        """As one of every output of the package."""

    def taken_by(self, evidence: Evidence, output: int) -> tuple[FloatArray, FloatArray]:
        """Return (N, c) columns of what it does to an output, and their (c,) sizes; the products in its unit."""

    def finding(self) -> Finding:
        """Return what is said of it."""


def package_wide_findings(wide: PackageWide | None, tests: AxisTests) -> Iterator[Finding]:
    """Yield what is said of it where the tests of an output were decided with it."""
    if wide is not None and tests.is_significant.get(wide.test.name):
        yield wide.finding()
