"""Calibrate a package that was moved on its seat in between: common offset and sensitivity, a direction per mounting.

The calibration that comes back is that of the last mounting, in the words of ``pitch-roll``; what the earlier ones
were is in its notes, and a warning says what was done (:mod:`ams.models.remounted` is the model).
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ams.calibration.calibrate import calibrate
from ams.calibration_result import AxisCalibration, Calibration
from ams.errors import DesignError
from ams.inputs.request import CalibrationRequest
from ams.models.accelerometer import PitchRoll
from ams.models.remounted import Remounted, is_of_a_mounting
from ams.observations import Observations


def calibrate_mountings(observations: Observations, request: CalibrationRequest) -> Calibration:
    """Calibrate as :func:`ams.calibration.calibrate.calibrate` does, over one mounting or several.

    Where ``observations.mounting`` holds one label, it is just that.

    Raises: as there; DesignError also where the model is not ``pitch-roll``.
    """
    labels = [] if observations.mounting is None else sorted(set(observations.mounting.tolist()))
    if len(labels) < 2:
        return calibrate(replace(observations, mounting=None), request)
    if request.model != "pitch-roll":
        raise DesignError(
            f"{observations.source}: got {len(labels)} mountings for model {request.model}, allowed one (several with "
            "pitch-roll only); nothing was solved; take back what was measured before the package was moved"
        )
    models = {label: Remounted(nominal, tuple(labels[:-1])) for label, nominal in request.axes_of(observations).items()}
    solved = calibrate(observations, replace(request, models=models))
    axes = {name: _of_last(axis, labels) for name, axis in solved.axes.items()}
    remark = (
        f"the package was moved: offset and sensitivity are common to mountings {', '.join(map(str, labels))}; coning "
        f"and azimuth are those of mounting {labels[-1]}, the last"
    )
    warnings = (*solved.warnings, remark, *_none_to_spare(observations, len(labels)))
    return replace(solved, axes=axes, model=PitchRoll.name, warnings=warnings)


def _none_to_spare(observations: Observations, mountings: int) -> Iterator[str]:
    replications = len(set(observations.replication.tolist()))
    if replications <= mountings:
        yield (
            f"{replications} replications over {mountings} mountings: drift between replications cannot be told from "
            "the moves and is not in the uncertainties; measure more replications of the last mounting"
        )


def _of_last(axis: AxisCalibration, labels: list[int]) -> AxisCalibration:
    """Return the axis without what belongs to earlier mountings; that goes into the notes."""
    kept = np.array([i for i, parameter in enumerate(axis.parameters) if not is_of_a_mounting(parameter.name)])
    primary = np.array([i for i, name in enumerate(axis.primary_names) if not is_of_a_mounting(name)])
    square = np.ix_(primary, primary)
    earlier = {parameter.name: parameter for parameter in axis.parameters if is_of_a_mounting(parameter.name)}
    return replace(
        axis,
        model=PitchRoll.name,
        parameters=tuple(axis.parameters[i] for i in kept),
        covariance=axis.covariance[np.ix_(kept, kept)],
        primary_names=tuple(axis.primary_names[i] for i in primary),
        primary=axis.primary[primary],
        primary_covariance=axis.primary_covariance[square],
        tp_primary_covariance=axis.tp_primary_covariance[square],
        primary_dof=axis.primary_dof[primary],
        variance_components=tuple(
            replace(part, covariance=part.covariance[square]) for part in axis.variance_components
        ),
        notes={**axis.notes, "mountings": {"labels": labels, "earlier": earlier}},
    )
