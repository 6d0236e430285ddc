"""Calibrate a package and the table it stands on in one fit, from the rows of one mounting.

The joint fit (:mod:`ams.solve.joint`) estimates the package with the table's errors as nuisance parameters under their
priors; what this adds is what any calibration has: the errors of meter and level that all rows share, residuals of
every row at the attitude at which the package stood, the replication tests, findings and warnings.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ams.arrays import FloatArray
from ams.calibration.joint_diagnosis import JointDiagnosis, as_they_stood, diagnose_joint
from ams.calibration.joint_document import joint_calibration, joint_warnings
from ams.calibration.solving.columns import plots_of
from ams.calibration_result import AxisCalibration, Calibration, VarianceComponent
from ams.errors import DesignError
from ams.inputs.request import CalibrationRequest, refuse_unusable
from ams.inputs.shared_errors import COURSES, HALF, Effect, SharedError, carriers, leaking_v
from ams.models.model import Model
from ams.observations import Observations
from ams.rounding import significant
from ams.solve.joint import JointFit, joint_fit
from ams.solve.layout import layout_of
from ams.solve.linearised import linearise
from ams.solve.mixed_model import estimate
from ams.solve.shifts_within import shifts_within
from ams.solve.table_errors import UPRIGHT, WHOLE_TABLE, Mounting, TablePriors
from ams.units import RAD_PER_ARCSEC

_OF_THE_CHANNEL: tuple[Effect, ...] = ("reading", "gain", "departure", "crosstalk")


def calibrate_jointly(observations: Observations, request: CalibrationRequest, priors: TablePriors) -> Calibration:
    """Calibrate the axes of a request together with the table; ``priors`` go before the level of ``request``.

    Raises:
        ObservationsError: rows that nothing can be solved from.
        DesignError: something is asked for that the joint fit does not have, or the points determine too little.
        SolveError: the scatter about the fit does not settle.
    """
    refuse_unusable(observations, request)
    _refuse_what_it_has_not(observations, request)
    rows = replace(observations, mounting=None)
    mountings, stated = [Mounting(rows)], with_level(priors, request.shared_errors)
    fit, diagnosis = solve_jointly(mountings, tuple(request.axes_of(rows)), request, stated)
    solved = joint_calibration(fit, diagnosis)
    stood = next(iter(as_they_stood(mountings, fit, stated)))
    to_read = tuple(joint_warnings(fit))
    axes = {
        label: replace(
            _with_residuals(axis, fit.sensors[label].model, stood),
            replication=diagnosis.replications.get(label),
            warnings=tuple(warning for warning in axis.warnings if warning not in to_read),
        )
        for label, axis in solved.axes.items()
    }
    return replace(solved, axes=axes, warnings=to_read, remarks=(*_of_the_table(fit), *solved.remarks))


def solve_jointly(
    mountings: Sequence[Mounting], axes: Sequence[str], request: CalibrationRequest, priors: TablePriors
) -> tuple[JointFit, JointDiagnosis]:
    """Fit package and table, with all that certificates state of the channels in the covariance, and test it.

    ``priors``: of the table, its level among them. Raises: as :func:`ams.solve.joint.joint_fit`.
    """
    fit = joint_fit(mountings, axes, priors, has_terms=request.extended == "yes")
    of_run = (request.known_of_run, request.single_approach)
    diagnosis = diagnose_joint(mountings, fit, priors, request.tested_axes, request.declared, *of_run)
    fit = _with_channels(fit, mountings, request.shared_errors)
    if any(error.effect in COURSES for errors in request.shared_errors.values() for error in errors):
        fit = _with_courses(fit, _in_package(mountings, fit, priors), request.shared_errors)
    return fit, diagnosis


def _in_package(mountings: Sequence[Mounting], fit: JointFit, priors: TablePriors) -> list[Observations]:
    """Return the rows of each mounting at attitudes of the package: of one upright as the table shows them."""
    return [
        mounting.observations if np.array_equal(mounting.package_from_table, UPRIGHT) else stood
        for mounting, stood in zip(mountings, as_they_stood(mountings, fit, priors), strict=True)
    ]


def _refuse_what_it_has_not(observations: Observations, request: CalibrationRequest) -> None:
    labels = [] if observations.mounting is None else np.unique(observations.mounting).tolist()
    reasons = [
        (request.model != "pitch-roll", f'model = "{request.model}", allowed is "pitch-roll"'),
        (request.temperature != "none", f'temperature = "{request.temperature}", allowed is "none"'),
        (request.extended == "test", 'extended = "test", allowed are "yes" and "no"'),
        (request.time_term, 'time_term = "linear", allowed is "none"'),
        (len(labels) > 1, f"{len(labels)} mountings, allowed is one: after a move the seat is not known"),
    ]
    for is_requested, what in reasons:
        if is_requested:
            raise DesignError(f"{observations.source}: joint fit: got {what}; nothing was solved; solve without joint")


def with_level(priors: TablePriors, shared: Mapping[str, Sequence[SharedError]]) -> TablePriors:
    """Return the priors with those of the level where none is given: a tilted base is an error of the table."""
    read = {error.effect: error.standard_uncertainty for errors in shared.values() for error in errors}
    return replace(
        priors,
        pitch_zero_rad=priors.pitch_zero_rad or read.get("pitch", 0.0),
        base_tilt_rad=priors.base_tilt_rad or read.get("base-tilt", 0.0),
    )


def _with_channels(
    fit: JointFit, mountings: Sequence[Mounting], shared: Mapping[str, Sequence[SharedError]]
) -> JointFit:
    """Return the fit with what meters and resistors may be wrong by: no row tells of it, so it is only added."""
    errors = dict.fromkeys(
        error for axis in fit.axes for error in shared.get(axis, ()) if error.effect in _OF_THE_CHANNEL
    )
    parts: dict[str, VarianceComponent] = {}
    for error in errors:
        covariance, common = np.zeros_like(fit.covariance), np.zeros((len(fit.covariance), 1))
        for axis in fit.axes:
            if error in shared.get(axis, ()):
                effects, block = error.standard_uncertainty * _effects(error, fit, axis, mountings), fit.block(axis)
                if error.is_of_one_channel:
                    covariance[block, block] = effects @ effects.T
                else:
                    common[block] = effects
        covariance += common @ common.T
        before = parts.get(error.name)
        added = covariance if before is None else before.covariance + covariance
        parts[error.name] = VarianceComponent(error.name, added, float("inf"))
    components = (*fit.components, *parts.values())
    return replace(fit, components=components, covariance=np.asarray(sum(part.covariance for part in components)))


def _with_courses(
    fit: JointFit, mountings: Sequence[Observations], shared: Mapping[str, Sequence[SharedError]]
) -> JointFit:
    """Return the fit with what the sensors may have done meanwhile, as each axis fitted by itself has it.

    ``mountings``: their rows at attitudes of the package. All rows together are about the mean of the mountings, and
    the variance of a mean is at most the mean of the variances.
    """
    parts = dict[str, VarianceComponent]()
    for axis in fit.axes:
        errors = [error for error in shared.get(axis, ()) if error.effect in COURSES]
        for rows in mountings if errors else ():
            layout, model = layout_of(rows), fit.sensors[axis].model
            problem = linearise([model], rows, layout, rows.outputs[axis][:, None], None)
            alone = estimate(
                problem.form,
                problem.alone,
                layout,
                problem.outputs,
                [],
                plots_of(model, rows, layout),
                is_weighted=False,
            )
            for part in shifts_within(problem, layout, alone, errors, is_measured=True):
                covariance = np.zeros_like(fit.covariance)
                covariance[fit.block(axis), fit.block(axis)] = part.covariance[0] / len(mountings)
                before = parts.get(part.name)
                added = covariance if before is None else before.covariance + covariance
                parts[part.name] = VarianceComponent(part.name, added, float("inf"))
    components = (*fit.components, *parts.values())
    return replace(fit, components=components, covariance=np.asarray(sum(part.covariance for part in components)))


def _effects(error: SharedError, fit: JointFit, axis: str, mountings: Sequence[Mounting]) -> FloatArray:
    """Return (P, q) what one unit of an error does to the primary parameters."""
    primary = fit.primary[axis]
    if error.effect == "crosstalk":
        every = [mounting.observations for mounting in mountings]
        model = fit.sensors[axis].model
        basis = np.concatenate([model.jacobian(primary, rows) for rows in every])
        volts = np.concatenate([leaking_v(error, model.nominal_axis, rows) for rows in every])
        return np.asarray(np.linalg.pinv(basis) @ volts)
    if error.effect == "departure":
        return np.asarray(HALF * np.eye(primary.size)[:, carriers(fit.sensors[axis].model)])
    return primary[:, None] if error.effect == "gain" else np.eye(primary.size)[:, :1]


def _with_residuals(axis: AxisCalibration, model: Model, stood: Observations) -> AxisCalibration:
    fitted = model.predict(axis.primary, stood)
    return replace(axis, fitted_v=fitted, residuals_v=stood.outputs[axis.axis] - fitted)


def _of_the_table(fit: JointFit) -> Iterator[str]:
    """Tell what the fit found of the table."""
    parts = [nuisance for nuisance in fit.nuisances if nuisance.name not in WHOLE_TABLE]
    sentences = [
        f"{nuisance.name} {nuisance.estimate_rad / RAD_PER_ARCSEC:+.2f}″ "
        f"(u {significant(nuisance.standard_deviation_rad / RAD_PER_ARCSEC)}″, "
        f"prior {significant(nuisance.prior_rad / RAD_PER_ARCSEC, 3)}″)"
        for nuisance in fit.nuisances
        if nuisance.name in WHOLE_TABLE
    ]
    several = [f"{len(parts)} parts of its index errors"] if parts else []
    yield (
        "package and table were solved together; of the table: "
        f"{', '.join((*sentences, *several)) or 'nothing, no error of it is declared'}"
    )
