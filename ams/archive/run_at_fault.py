"""Why a run says nothing of how a sensor was found: a finding against the run itself, not against the sensor.

As found is judged by the attitudes and readings of the run, and not by the new coefficients. What a finding says of the
sensor (a term of its own, its step, its drift) is an error that its users had, and leaves as found standing. What it
says of the table, its base, the meter, the chamber or a dwell that was not at rest is an error of the reference: where
the new calibration falls by that, as found falls with it. So it does where readings and declaration contradict each
other: nothing says which is wrong, and errors told in another unit or by other angles are no sensor's. A smaller one,
which the stated uncertainties hold or which is a reservation of a usable calibration, takes neither.
"""

from collections.abc import Iterable
from typing import Final

from ams.analysis.diagnostics.beliefs import OF_THE_ORDER, SETTLING, SQUARENESS, TABLE_LIMIT
from ams.finding_kinds import kinds_of
from ams.findings import Finding, beyond_the_stated, significant_facts, turned_the_table
from ams.sets.coefficients import CoefficientSet
from ams.sets.stated_findings import findings_of_set

KINDS_OF_THE_RUN: Final = kinds_of("table", "meter", "run")
TESTS_OF_THE_RUN: Final = frozenset({TABLE_LIMIT, SQUARENESS, SETTLING, *OF_THE_ORDER})
"""Findings of other kinds that are the table's or the chamber's by the test that made them."""


def run_at_fault(new: CoefficientSet, findings: Iterable[Finding] = ()) -> str | None:
    """Return why the run that a set was solved from does not tell how its sensor was found; None where it does.

    ``findings``: of the run as a whole, beside those that the set states.
    """
    every = (*findings, *findings_of_set(new))
    against = (*turned_the_table(every), *(finding for finding in beyond_the_stated(every) if _is_of_the_run(finding)))
    return "; ".join(dict.fromkeys(significant_facts(against))) or None


def _is_of_the_run(finding: Finding) -> bool:
    return finding.kind in KINDS_OF_THE_RUN or finding.details.get("test") in TESTS_OF_THE_RUN
