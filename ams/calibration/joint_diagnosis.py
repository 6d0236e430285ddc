"""What the data of a joint fit contradict: the tests of any calibration, on attitudes that the fit has corrected.

The joint fit says where the package truly stood: the angles commanded, the table's errors as estimated, the mounting
and its seat. At these attitudes every mounting is a calibration like any other and is tested like one; what the table's
errors explain within their priors is no finding. The tests of all axes in all mountings are one family.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import LEVEL
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
from ams.solve.table_errors import WHOLE_TABLE, Mounting, TablePriors, nuisances_of, seat_effects
from ams.statistics.distributions import chi_square_tail
from ams.units import RAD_PER_ARCSEC

_FAR: Final = 3.0
"""Standard deviations."""
_LEAST_SHARE: Final = 0.1
"""Of a prior: what the rows say less about is not judged by them."""
_MOST_NAMED: Final = 3


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
        replications = {axis: solved_axis.replication for axis, solved_axis in solved.axes.items()} if not name else {}
        for axis, solved_axis in solved.axes.items():
            found[axis] += [replace(finding, text=f"{name}{finding.text}") for finding in solved_axis.findings]
    beyond = tuple(beyond_priors(fit))
    for axis in fit.axes:
        found[axis] += beyond
    return JointDiagnosis({axis: tuple(verdicts) for axis, verdicts in found.items()}, tuple(untested), replications)


def beyond_priors(fit: JointFit) -> Iterator[Finding]:
    """Yield a finding for each error of table and seat that the rows put far beyond what was declared of it.

    An estimate scatters by what its prior loses, √(prior² − u²), where the prior is true.
    """
    scatter = [
        np.sqrt(max(nuisance.prior_rad**2 - nuisance.standard_deviation_rad**2, 0.0)) for nuisance in fit.nuisances
    ]
    sized = [
        (
            nuisance,
            abs(nuisance.estimate_rad) / spread,
            float(chi_square_tail((nuisance.estimate_rad / spread) ** 2, 1.0)),
        )
        for nuisance, spread in zip(fit.nuisances, scatter, strict=True)
        if spread > _LEAST_SHARE * nuisance.prior_rad
    ]
    beyond = [(nuisance, p) for nuisance, size, p in sized if size > _FAR and p * len(sized) <= LEVEL]
    for nuisance, p_value in sorted(beyond, key=lambda pair: -abs(pair[0].estimate_rad) / pair[0].prior_rad)[
        :_MOST_NAMED
    ]:
        estimate, u, prior = (
            value / RAD_PER_ARCSEC
            for value in (nuisance.estimate_rad, nuisance.standard_deviation_rad, nuisance.prior_rad)
        )
        is_index = nuisance.name not in WHOLE_TABLE and not nuisance.name.startswith("seat")
        where = "its limit in the rig file" if is_index else "--prior; joint_priors_arcsec"
        text = (
            f"{nuisance.name}: {_signed(estimate)}″ ± {u:.2g}″, where {prior:.2g}″ (standard) is declared: the rows "
            f"contradict the prior, {abs(estimate) / prior:.2g} times over; the estimate is drawn towards it, and what "
            "it lacks is in the other errors of the table, in offset and sensitivities, and not in their "
            f"uncertainties; look at the table, or declare what it has ({where})"
        )
        details: dict[str, float | str | None] = {
            "test": "prior of the table",
            "nuisance": nuisance.name,
            "estimate_arcsec": estimate,
            "prior_arcsec": prior,
        }
        yield Finding("lack-of-fit" if is_index else "table-rotation", text, True, p_value, details=details)


def _signed(value: float) -> str:
    return f"{value:+.3g}".replace("-", "−")


def as_they_stood(mountings: Sequence[Mounting], fit: JointFit, priors: TablePriors) -> Iterator[Observations]:
    """Yield the rows of each mounting at the attitudes at which the package stood, as the fit has them."""
    mountings = [
        replace(mounting, observations=corrected(mounting.observations, priors.table)) for mounting in mountings
    ]
    nuisances = nuisances_of(mountings, priors)
    errors_rad = np.array([nuisance.estimate_rad for nuisance in fit.nuisances])
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
