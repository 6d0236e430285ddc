"""What dwells and points of an axis do not tell, as remarks: no test found it, and none could have.

What leaves an uncertainty of nothing is a warning.
"""

from math import nan
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import SETTLING
from ams.analysis.diagnostics.steps.step_scan import LEAST_DOF
from ams.analysis.diagnostics.wrong_dwells import smallest_detected
from ams.calibration.output.diagnosis import Diagnosis, scale_of
from ams.calibration.solving.columns import SolvedColumns
from ams.solve.resolution import NAME as RESOLUTION

_FAR: Final = 8.0
"""Standard deviations of a dwell: in four replications of a dozen points, six or seven are enough for a finding."""

_EXACT: Final = 1e-9
"""Of the largest reading: what scatters by less is arithmetic."""


def untold_noise(label: str, solved: SolvedColumns, row: int) -> tuple[str, ...]:
    """Return that the readings show neither noise nor a step, where nothing says how wrong they are."""
    has_steps = any(part.name == RESOLUTION and part.covariance[row].any() for part in solved.components)
    if has_steps or solved.standard_error_v[row] > _EXACT * np.abs(solved.problem.outputs[:, row]).max():
        return ()
    return (
        f"axis {label}: nothing scatters, and no step of a meter shows: neither its noise nor its resolution is in the "
        "uncertainties, and 0 is none that was measured; give single readings, with all digits of the meter",
    )


def undetected_dwell(label: str, found: Diagnosis) -> tuple[str, ...]:
    """Return how far a single dwell may be off without a finding, where that is far."""
    dwells = found.tests.dwells
    smallest = nan if dwells is None else smallest_detected(dwells, found.tests.conviction_level)
    if dwells is None or not smallest > _FAR:
        return ()
    size = scale_of(found.solved, found.row).words(smallest * float(np.sqrt(dwells.squares[0] / dwells.dof)))
    return (
        f"axis {label}: among so few dwells a single one that is wrong is found only from about {smallest:.0f} "
        f"standard deviations of a dwell on ({size}); add points or replications to find a smaller one",
    )


def untold_transient(label: str, found: Diagnosis) -> tuple[str, ...]:
    """Return that the points do not tell a transient at the start of every replication, where they do not."""
    if not found.tests.tests or SETTLING in found.tests.tests:
        return ()
    return (
        f"axis {label}: whether the output settles at the start of every replication is not told by these points: what "
        "it does then passes for offset and sensitivities, and is not in the uncertainty; let the sensor settle first, "
        "or add points",
    )


def untold_of_few(label: str, found: Diagnosis) -> tuple[str, ...]:
    """Return that dwells so few tell neither a change in mid-run nor a share of them that is wrong, where they are."""
    left = found.solved.layout.rows - found.solved.layout.points
    if not found.tests.tests or left >= LEAST_DOF:
        return ()
    return (
        f"axis {label}: so few dwells ({left} more than points) do not tell a fifth of them that read to one side, "
        "and no change of table, meter or sensor in mid-run is looked for; either may move offset and "
        "sensitivities by more than the uncertainty holds; add points or replications",
    )
