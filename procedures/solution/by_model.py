"""Observations of a run's sensor, solved by the model of its procedure with everything that the rig declares.

The run, the running estimate and the report all solve through here where a sensor is no straight line, so that the same
observations always meet the same model, the same table and the same treatment of temperature.
"""

from dataclasses import replace

import numpy as np

from ams.calibration.jointly import calibrate_jointly
from ams.calibration.mountings import calibrate_mountings
from ams.observations import Observations
from procedures.description.procedure_file import Solve
from procedures.plan.channels import temperature_source
from procedures.solution.crosstalk import with_scanned_volts
from procedures.solution.dominating_limits import dominating_limits
from procedures.solution.earth_turn import mean_rotations, with_turned_earth
from procedures.solution.observations import design_dwells, observations_of
from procedures.solution.request import (
    SensorRows,
    SolvedSensor,
    budgets_of,
    joint_priors,
    joint_priors_in_words,
    reference_of,
    request_of,
)
from procedures.solution.run_findings import with_run_findings
from procedures.solution.said_of_run import said_of_run
from procedures.solution.type_b import (
    single_approach,
)
from rig.description.rig_file import RigDescription, Sensor


def observed(item: SensorRows) -> Observations:
    """Return one row a dwell. Raises: JournalError."""
    temperature = temperature_source(item.rig, item.sensor)
    counts = item.rig.channel_counts()
    rows = observations_of(item.dwells, item.channels, temperature, item.source, item.rig.chain, item.run, counts)
    rows = rows if item.sensor.rolls else on_the_sting(rows)
    rows = with_scanned_volts(rows, item.rig, item.sensor, design_dwells(item.dwells))
    if not item.plan.counts_earth or item.sensor.measures != "rate" or rows.euler_rate_rad_s is None:
        return rows
    yaw = np.zeros(rows.rows) if rows.yaw_rad is None else rows.yaw_rad
    at = {"pitch": rows.pitch_rad, "yaw": yaw, "roll": rows.roll_rad}
    return with_turned_earth(rows, item.rig, item.sensor, mean_rotations(item.dwells, item.plan, at))


def on_the_sting(rows: Observations) -> Observations:
    """Return the rows of a sensor that roll does not carry: its own attitude has none."""
    rates = rows.euler_rate_rad_s
    still = None if rates is None else rates * np.array([1.0, 1.0, 0.0])
    return replace(rows, roll_rad=np.zeros_like(rows.roll_rad), euler_rate_rad_s=still)


def solve_by_model(item: SensorRows, observations: Observations) -> SolvedSensor:
    """Solve a sensor by the model of its procedure, with everything that the rig declares. Raises: AmsError."""
    solve = item.plan.solve
    request_of_sensor = request_of(item.name, item.rig, item.sensor, solve, observations)
    request = replace(
        request_of_sensor,
        tested_axes=item.tested_axes,
        counts_temperature=item.plan.counts_temperature,
        known_of_run=item.known_of_run,
        single_approach=single_approach(item.rig),
    )
    if solve.joint:
        solved = calibrate_jointly(observations, request, joint_priors(item.rig, solve))
    else:
        solved = calibrate_mountings(observations, request)
    said = said_of_run(item, observations, request.shared_errors)
    remarks, warnings = (*solved.remarks, *said.remarks), (*solved.warnings, *said.warnings)
    priors = joint_priors_in_words(solve.joint_priors_arcsec.items())
    budgets = budgets_of(solved, request, item.rig, priors_in_words=priors)
    remarks = (*remarks, *dominating_limits(solved.axes, budgets))
    calibration = replace(solved, remarks=remarks, warnings=warnings)
    reference = reference_of(item.rig, solve, request.shared_errors)
    sensor = SolvedSensor(item.name, observations, calibration, None, budgets, reference=reference)
    return with_run_findings(sensor, said.undeclared.findings)


def checked_by_monte_carlo(
    solved: SolvedSensor, rig: RigDescription, sensor: Sensor, solve: Solve, trials: int
) -> SolvedSensor:
    """Return the sensor with the Monte Carlo check beside every budget."""
    if solved.calibration is None or solved.calibration.convention == "SR":
        return solved
    request = request_of(solved.name, rig, sensor, solve, solved.observations)
    words = joint_priors_in_words(solve.joint_priors_arcsec.items())
    return replace(solved, budgets=budgets_of(solved.calibration, request, rig, trials, words))
