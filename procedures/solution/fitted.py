"""Observations that came from a file or a table, solved: the one way of ``calrig fit`` and of ``calrig.fit``."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ams.inputs.observations_csv import unit_warnings
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from procedures.solution.by_model import solve_observations
from procedures.solution.request import SolvedSensor, budgets_of
from procedures.solution.type_b import level_remarks
from rig.description.rig_file import RigDescription, Sensor


def fitted(
    name: str,
    observations: Observations,
    columns: Mapping[str, str],
    request: CalibrationRequest,
    rig: RigDescription | None,
    *,
    doubts: Sequence[str] = (),
    trials: int = 0,
) -> SolvedSensor:
    """Solve observations and say what is doubtful about them, with the budgets of what the rig declares.

    ``columns``: sensor axis to the column that it was read from. Raises: ams.errors.AmsError.
    """
    solved = solve_observations(observations, request)
    warnings = (*unit_warnings(observations, columns), *doubts, *solved.warnings)
    remarks = (*solved.remarks, *(() if rig is None else level_remarks(rig)))
    calibration = replace(solved, warnings=warnings, remarks=remarks)
    return SolvedSensor(name, observations, calibration, None, budgets_of(calibration, request, rig, trials))


def sensor_of(rig: RigDescription, name: str | None) -> Sensor | None:
    """Return the sensor whose channels stand in the rig file.

    The one named, else the only one; None where that is open.
    """
    if name is not None and name in rig.sensors:
        return rig.sensors[name]
    return next(iter(rig.sensors.values())) if len(rig.sensors) == 1 else None
