"""What the data of a joint fit contradict: the tests of any calibration, on attitudes that the fit has corrected.

The joint fit says where the package truly stood: the angles commanded, the table's errors as estimated, the mounting
and its seat. At these attitudes every mounting is a calibration like any other and is tested like one; what the table's
errors explain within their priors is no finding. The tests of all axes in all mountings are one family.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ams.calibration.calibrate import calibrate
from ams.calibration_result import Replication
from ams.errors import DesignError
from ams.findings import Finding
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.inputs.table_uncertainty import corrected
from ams.observations import Observations
from ams.solve.extension import angles_of_points
from ams.solve.joint import JointFit
from ams.solve.layout import layout_of
from ams.solve.table_errors import Mounting, TablePriors, nuisances_of, seat_effects


@dataclass(frozen=True)
class JointDiagnosis:
    """What was tested, and what was not."""

    findings: Mapping[str, tuple[Finding, ...]]
    """Of each axis, mounting by mounting; of several mountings each sentence names its own."""
    untested: tuple[str, ...] = ()
    """Why a mounting by itself could not be tested, a sentence each."""
    replications: Mapping[str, Replication | None] = field(default_factory=dict)
    """Axis to lack of fit and drift, where there is one mounting."""


def diagnose_joint(
    mountings: Sequence[Mounting], fit: JointFit, priors: TablePriors, tested_axes: int | None = None
) -> JointDiagnosis:
    """Test every mounting of a joint fit, axis by axis; ``tested_axes`` of the run, None: those of the fit."""
    found: dict[str, list[Finding]] = {axis: [] for axis in fit.axes}
    untested, replications = [], dict[str, Replication | None]()
    family = (tested_axes or len(fit.axes)) * len(mountings)
    request = CalibrationRequest("pitch-roll", {axis: axis for axis in fit.axes}, tested_axes=family)
    for number, rows in enumerate(as_they_stood(mountings, fit, priors), start=1):
        name = f"mounting {number}: " if len(mountings) > 1 else ""
        try:
            solved = calibrate(rows, request)
        except DesignError as error:
            untested.append(f"{name or 'joint fit: '}not tested by itself: {error}")
            continue
        replications = {axis: one.replication for axis, one in solved.axes.items()} if not name else {}
        for axis, one in solved.axes.items():
            found[axis] += [replace(finding, text=f"{name}{finding.text}") for finding in one.findings]
    return JointDiagnosis({axis: tuple(verdicts) for axis, verdicts in found.items()}, tuple(untested), replications)


def as_they_stood(mountings: Sequence[Mounting], fit: JointFit, priors: TablePriors) -> Iterator[Observations]:
    """Yield the rows of each mounting at the attitudes at which the package stood, as the fit has them."""
    mountings = [replace(one, observations=corrected(one.observations, priors.table)) for one in mountings]
    nuisances = nuisances_of(mountings, priors)
    errors_rad = np.array([one.estimate_rad for one in fit.nuisances])
    for number, mounting in enumerate(mountings):
        observations, M = mounting.observations, np.asarray(mounting.package_from_table, dtype=float)
        layout = layout_of(observations)
        pitch, roll = angles_of_points(observations, layout)
        turned = nuisances.effects(number, pitch, roll) @ errors_rad
        seated = seat_effects(specific_force(pitch, roll) @ M.T, nuisances.names, number) @ errors_rad
        force = specific_force(observations.pitch_rad, observations.roll_rad) @ M.T
        force = force + (turned @ M.T + seated)[layout.point]
        x, y, z = (force / np.linalg.norm(force, axis=1, keepdims=True)).T
        yield replace(observations, pitch_rad=np.arcsin(np.clip(x, -1.0, 1.0)), roll_rad=np.arctan2(-y, -z))
