"""What the data of a joint fit contradict: the tests of any calibration, mounting by mounting.

What the fit has found of the whole table and of the seat is taken out of the outputs; what it does not know of droop
and squareness, and the index errors as their certificate has them, in the angles at which the package met them, stand
in the covariance of the tests. So every mounting is a calibration like any other and is tested like one, its table's
limit included; what the table's errors explain within their priors is no finding. The tests of all axes in all
mountings are one family.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import LEVEL
from ams.arrays import FloatArray
from ams.calibration.calibrate import calibrate
from ams.calibration_result import Replication
from ams.errors import DesignError
from ams.findings import Finding
from ams.frames import specific_force
from ams.inputs.declared_direction import NOTHING_DECLARED, DeclaredDirection
from ams.inputs.known_of_run import NOTHING_KNOWN, KnownOfRun
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import OF_THE_AXES, SharedError
from ams.inputs.table_uncertainty import IndexErrors, KnownErrors, TableUncertainty, corrected
from ams.observations import Observations
from ams.rounding import significant
from ams.solve.extension import angles_of_points
from ams.solve.joint import JointFit
from ams.solve.layout import layout_of
from ams.solve.table_errors import SEAT, UPRIGHT, WHOLE_TABLE, Mounting, TablePriors, nuisances_of, seat_effects
from ams.statistics.distributions import chi_square_tail
from ams.units import RAD_PER_ARCSEC, signed

_FAR: Final = 3.0
"""Standard deviations."""
_LEAST_SHARE: Final = 0.1
"""Of a prior: what the rows say less about is not judged by them."""
_MOST_NAMED: Final = 3
"""In one sentence."""


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
    mountings: Sequence[Mounting],
    fit: JointFit,
    priors: TablePriors,
    tested_axes: int | None = None,
    declared: Mapping[str, DeclaredDirection] = NOTHING_DECLARED,
    known_of_run: KnownOfRun = NOTHING_KNOWN,
    single_approach: frozenset[str] = frozenset(),
) -> JointDiagnosis:
    """Test every mounting of a joint fit, axis by axis; ``tested_axes`` of the run, None: those of the fit.

    ``known_of_run``: what is known of the table by all packages of a run. ``single_approach``: as of a request.
    """
    found: dict[str, list[Finding]] = {axis: [] for axis in fit.axes}
    untested, replications = [], dict[str, Replication | None]()
    family = (tested_axes or len(fit.axes)) * len(mountings)
    request = CalibrationRequest(
        "pitch-roll",
        {axis: axis for axis in fit.axes},
        declared,
        extended="yes" if fit.has_terms else "no",
        counts_tilts=False,
        tested_axes=family,
        known_of_run=known_of_run,
        single_approach=single_approach,
    )
    for number, mounting in enumerate(mountings, start=1):
        name = f"mounting {number}: " if len(mountings) > 1 else ""
        rows, table = _to_be_tested(mountings, number - 1, fit, priors)
        left = () if _angles_in_package(mounting) is None else tuple(_left_of_axes(fit))
        shared = dict.fromkeys(fit.axes, left)
        try:
            solved = calibrate(rows, replace(request, table=table, shared_errors=shared))
        except DesignError as error:
            untested.append(f"{name or 'joint fit: '}not tested by itself: {error}")
            continue
        replications = {axis: solved_axis.replication for axis, solved_axis in solved.axes.items()} if not name else {}
        for axis, solved_axis in solved.axes.items():
            found[axis] += [
                replace(finding, fact=f"{name}{finding.fact}{_sign(finding, mounting)}")
                for finding in solved_axis.findings
            ]
    beyond = tuple(beyond_priors(fit))
    for axis in fit.axes:
        found[axis] += beyond
    return JointDiagnosis({axis: tuple(verdicts) for axis, verdicts in found.items()}, tuple(untested), replications)


def _left_of_axes(fit: JointFit) -> Iterator[SharedError]:
    """Yield what is not known of droop and squareness once the fit's estimates are taken out.

    Zeros, tilts and seats turn a package as a whole, and offset and sensitivities have what is left of them. These two
    do not, and of one mounting no row tells them: one that its prior allows would pass for index errors or for terms.
    """
    for nuisance in fit.nuisances:
        if nuisance.name in OF_THE_AXES and nuisance.standard_deviation_rad > 0.0:
            yield SharedError(nuisance.name, nuisance.name, nuisance.standard_deviation_rad)


def _sign(finding: Finding, mounting: Mounting) -> str:
    """Say whose sign a turn of the table has where that is not the table's own."""
    is_the_table_s = np.array_equal(mounting.package_from_table, UPRIGHT)
    is_turn = finding.kind == "table-rotation" and finding.is_significant
    return " (turns in the sense of the package's own axes)" if is_turn and not is_the_table_s else ""


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
        is_index = nuisance.name not in WHOLE_TABLE and not nuisance.name.startswith(SEAT)
        where = "its limit in the rig file" if is_index else "--prior; joint_priors_arcsec"
        fact = (
            f"{nuisance.name}: {signed(estimate, 3)}″ ± {significant(u)}″, where {significant(prior)}″ (standard) is "
            f"declared: the rows contradict the prior, {significant(abs(estimate) / prior)} times over; the estimate "
            "is drawn towards it, and what it lacks is in the other errors of the table, in offset and sensitivities, "
            "and not in their uncertainties"
        )
        details: dict[str, float | str | None] = {
            "test": "prior of the table",
            "nuisance": nuisance.name,
            "estimate_arcsec": estimate,
            "prior_arcsec": prior,
        }
        yield Finding(
            "lack-of-fit" if is_index else "table-rotation",
            fact,
            True,
            p_value,
            details=details,
            is_held=False,
            what_to_do=f"look at the table, or declare what it has ({where})",
        )


def as_they_stood(mountings: Sequence[Mounting], fit: JointFit, priors: TablePriors) -> Iterator[Observations]:
    """Yield the rows of each mounting at the attitudes at which the package stood, as the fit has them."""
    errors_rad = np.array([nuisance.estimate_rad for nuisance in fit.nuisances])
    for number, mounting in enumerate(mountings):
        observations = corrected(mounting.observations, priors.table)
        force = specific_force(observations.pitch_rad, observations.roll_rad) @ _rotation(mounting).T
        force = force + _turned(mountings, number, priors, errors_rad)
        x, y, z = (force / np.linalg.norm(force, axis=1, keepdims=True)).T
        yield replace(observations, pitch_rad=np.arcsin(np.clip(x, -1.0, 1.0)), roll_rad=np.arctan2(-y, -z))


def _turned(mountings: Sequence[Mounting], number: int, priors: TablePriors, errors_rad: FloatArray) -> FloatArray:
    """Return the (N, 3) change of specific force in package axes at the rows of a mounting by errors of the fit."""
    seen = [replace(m, observations=corrected(m.observations, priors.table)) for m in mountings]
    observations, M = seen[number].observations, _rotation(mountings[number])
    layout = layout_of(observations)
    pitch, roll = angles_of_points(observations, layout)
    nuisances = nuisances_of(seen, priors)
    turned = nuisances.effects(number, pitch, roll) @ errors_rad
    seated = seat_effects(specific_force(pitch, roll) @ M.T, nuisances.names, number) @ errors_rad
    return np.asarray((turned @ M.T + seated)[layout.point])


def _to_be_tested(
    mountings: Sequence[Mounting], number: int, fit: JointFit, priors: TablePriors
) -> tuple[Observations, TableUncertainty | None]:
    """Return the rows of one mounting at the package's angles, and the table that it stood on in these angles.

    The outputs are less what whole table and seat do to them. A mounting on its side has no such angles: it stands as
    the fit has it, the index errors with it, and its table is none.
    """
    mounting = mountings[number]
    turn = _angles_in_package(mounting)
    if turn is None:
        return list(as_they_stood(mountings, fit, priors))[number], None
    is_whole = [name in WHOLE_TABLE or name.startswith(SEAT) for name in (n.name for n in fit.nuisances)]
    errors_rad = np.array([nuisance.estimate_rad for nuisance in fit.nuisances]) * is_whole
    observations = mounting.observations
    here = corrected(observations, priors.table)
    force = specific_force(here.pitch_rad, here.roll_rad) @ _rotation(mounting).T
    turned = _turned(mountings, number, priors, errors_rad)
    outputs = {axis: observations.outputs[axis] - np.sum(turned * fit.slope(axis, force), axis=1) for axis in fit.axes}
    angles = {"pitch": observations.pitch_rad, "roll": observations.roll_rad}
    pitch, roll = (sign * angles[axis] + shift for axis, (sign, shift) in turn.items())
    rows = replace(observations, pitch_rad=pitch, roll_rad=roll, outputs=outputs)
    return rows, None if priors.table is None else _in_package(priors.table, turn)


def _rotation(mounting: Mounting) -> FloatArray:
    return np.asarray(mounting.package_from_table, dtype=float)


def _angles_in_package(mounting: Mounting) -> Mapping[str, tuple[float, float]] | None:
    """Return axis to (sign, shift): what the axis shows, times the sign and shifted, is the angle of the package.

    None for a mounting that is no half turn.
    """
    rotation = _rotation(mounting)
    if not np.array_equal(np.abs(rotation), np.eye(3)):
        return None
    x, y, z = np.diag(rotation).tolist()
    return {"pitch": (x, 0.0), "roll": (y * z, 0.0 if z > 0.0 else float(np.pi))}


def _in_package(table: TableUncertainty, turn: Mapping[str, tuple[float, float]]) -> TableUncertainty:
    """Return what is declared of the axes at the angles that a package in another mounting has for theirs."""
    errors = {
        axis: _seen_from(declared, *turn[axis]) if axis in turn else declared for axis, declared in table.errors.items()
    }
    return replace(table, errors=errors)


def _seen_from(declared: IndexErrors, sign: float, shift: float) -> IndexErrors:
    zero_rad = None if declared.zero_rad is None else sign * declared.zero_rad + shift
    known = declared.known
    if known is not None:
        step = 1 if sign > 0.0 else -1
        known = KnownErrors(
            (sign * known.angle_rad + shift)[::step],
            (sign * known.error_rad)[::step],
            known.standard_uncertainty_rad[::step],
        )
    return replace(declared, zero_rad=zero_rad, known=known)
