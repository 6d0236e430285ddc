"""Observations that came from a file or a table, solved: the one way of ``calrig fit`` and of ``calrig.fit``."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ams.calibration.packages import calibrate_packages
from ams.inputs.copied_replications import refuse_copies
from ams.inputs.possible_outputs import refuse_impossible_outputs, refuse_overloads
from ams.inputs.request import CalibrationRequest
from ams.models.registry import MODELS
from ams.observations import Observations
from procedures.solution.crosstalk import with_scanned_volts
from procedures.solution.dominating_limits import dominating_limits
from procedures.solution.meter_reach import meter_reach
from procedures.solution.request import SolvedSensor, budgets_of
from procedures.solution.run_findings import with_run_findings
from procedures.solution.said_of_file import said_of_file
from procedures.solution.sensor_of_file import sensor_of
from procedures.solution.temperature_of_use import at_use
from rig.description.rig_file import RigDescription


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

    ``columns``: sensor axis to the column that it was read from. ``doubts``: what the caller knows beside. Raises:
    ams.errors.AmsError.
    """
    used = None if rig is None else sensor_of(rig, name)
    refuse_copies(observations)
    refuse_overloads(observations, columns)
    if not MODELS[request.model].needs_rates:
        refuse_impossible_outputs(observations, columns, {} if rig is None else meter_reach(rig, used))
    request = at_use(request, used, observations.temperature_degc)
    observations = observations if rig is None else with_scanned_volts(observations, rig, used)
    said = said_of_file([observations], columns, request, rig, name)
    solved = calibrate_packages({name: observations}, request)[name]
    remarks = (*solved.remarks, *said.remarks)
    calibration = replace(solved, warnings=(*doubts, *said.warnings, *solved.warnings), remarks=remarks)
    budgets = budgets_of(calibration, request, rig, trials)
    calibration = replace(calibration, remarks=(*remarks, *dominating_limits(calibration.axes, budgets)))
    return with_run_findings(SolvedSensor(name, observations, calibration, None, budgets), said.undeclared.findings)
