"""What the outputs of one group were solved under, and what is known of all of them together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ams.analysis.diagnostics.beliefs import BeliefTest
from ams.analysis.diagnostics.table_curves import TableLimit
from ams.arrays import FloatArray
from ams.calibration.steps.steps_of_output import NO_STEPS, StepsOfOutput
from ams.calibration.together.backlash_found import Play
from ams.calibration.together.package_wide import PackageWide
from ams.findings import Finding
from ams.inputs.declared_direction import DeclaredDirection
from ams.inputs.known_of_run import DwellLabels
from ams.inputs.shared_errors import SharedError
from ams.inputs.table_uncertainty import TableUncertainty
from ams.observations import Observations


@dataclass(frozen=True)
class Circumstances:
    """What the observations were solved under."""

    rows: Observations
    outputs: FloatArray
    """(N, m) as read."""
    table: TableUncertainty | None
    shared: Sequence[SharedError]
    limits: Sequence[TableLimit | None] = ()
    """Of each output, what the package that it belongs to says of the table's declared limit; empty: not asked."""
    family: int = 1
    """How many axes a run has, whose tests are one family; 1: every output is judged by itself."""

    order: Sequence[Finding] = ()
    """What is said of the order of the points already."""

    steps: Sequence[StepsOfOutput] = ()
    """Of each output, what changed in mid-run; empty: not asked."""

    declared: Sequence[DeclaredDirection] = ()
    """Of each output, the direction that is declared of it; empty: its nominal axis, of either polarity."""

    together: Sequence[BeliefTest | None] = ()
    """Of each output, what its package shows together, as large as it is of this one; empty: not asked."""

    alike: Mapping[DwellLabels, str] = field(default_factory=dict)
    """Dwells at which the table may have stood off, and by how much."""

    single_approach: frozenset[str] = frozenset()
    """Axes of the table that the machine lets come from one side always."""

    plays: Sequence[Sequence[Play]] = ()
    """Of each output, the play of the table that its package shows; empty: none."""

    package_wide: PackageWide | None = None
    """What all outputs of the package show together, beside the play; None: nothing."""

    signs: Sequence[Sequence[Finding]] = ()
    """Of each output, what says that the angles or the outputs have another sign or order, all through the run or in a
    replication; empty: not asked."""

    def together_of(self, index: int) -> BeliefTest | None:
        return self.together[index] if self.together else None

    def plays_of(self, index: int) -> Sequence[Play]:
        return self.plays[index] if self.plays else ()

    def signs_of(self, index: int) -> Sequence[Finding]:
        return self.signs[index] if self.signs else ()

    def limit_of(self, index: int) -> TableLimit | None:
        return self.limits[index] if self.limits else None

    def steps_of(self, index: int) -> StepsOfOutput:
        return self.steps[index] if self.steps else NO_STEPS
