"""Observations of a run's sensor, solved by the model of its procedure with everything that the rig declares.

The run, the running estimate and the report all solve through here, so that the same observations always meet the
same model, the same table and the same treatment of temperature.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ams.calibration.jointly import calibrate_jointly
from ams.calibration.mountings import calibrate_mountings
from ams.models.registry import MODELS
from ams.observations import Observations
from procedures.description.procedure_file import Solve
from procedures.plan.channels import temperature_source
from procedures.plan.sequential import stopped_in_words
from procedures.records.declared_gaps import (
    crosstalk_remarks,
    direction_remarks,
    gravity_remarks,
    meter_remarks,
    rate_remarks,
    table_remarks,
    temperature_remarks,
    thermometer_remarks,
)
from procedures.records.dwells import DwellRecord
from procedures.solution.adaptive_words import adaptive_in_words
from procedures.solution.crosstalk import with_scanned_volts
from procedures.solution.dominating_limits import dominating_limits
from procedures.solution.earth_turn import earth_remarks, mean_rotations, with_turned_earth
from procedures.solution.level_of_base import level_remarks, level_warnings
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
from procedures.solution.temperature_of_use import warnings_of_use
from procedures.solution.type_b import (
    gravity_on_gyros_remarks,
    gravity_warnings,
    single_approach,
)
from procedures.solution.undeclared import Undeclared
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
    # A tilted base does not turn what sensors of rates sense.
    model = MODELS.get(item.plan.solve.model)
    is_levelled = model is None or not model.needs_rates
    undeclared = Undeclared(
        level_remarks(item.rig) if is_levelled else (),
        meter_remarks(item.rig, item.sensor),
        rate_remarks(item.rig, item.sensor, item.plan.axes),
        gravity_remarks(item.rig, senses_gravity=item.sensor.measures == "acceleration"),
        table_remarks(item.rig, item.sensor, item.plan.axes),
        direction_remarks(item.rig, item.sensor, item.plan.axes),
        crosstalk_remarks(item.rig, item.sensor),
    )
    stopped = stopped_in_words(item.plan, max(dwell.replication for dwell in item.dwells))
    remarks = (
        *solved.remarks,
        *_remarks(item.plan.solve, item.dwells),
        *undeclared.remarks,
        *temperature_remarks(observations, item.sensor.use_temperature_degc),
        *(said.text for said in thermometer_remarks(item.rig, [item.sensor], request.temperature)),
        *(earth_remarks(item.rig, item.sensor) if item.plan.counts_earth else ()),
        *gravity_on_gyros_remarks(request.shared_errors, senses_rates=model is not None and model.needs_rates),
        *(text for text in (stopped, adaptive_in_words(item)) if text is not None),
    )
    warnings = (
        *solved.warnings,
        *(level_warnings(item.rig) if is_levelled else ()),
        *gravity_warnings(item.rig, item.sensor),
        *warnings_of_use(item.sensor, solve.temperature, observations.temperature_degc),
    )
    priors = joint_priors_in_words(solve.joint_priors_arcsec.items())
    budgets = budgets_of(solved, request, item.rig, priors_in_words=priors)
    remarks = (*remarks, *dominating_limits(solved.axes, budgets))
    calibration = replace(solved, remarks=remarks, warnings=warnings)
    reference = reference_of(item.rig, solve, request.shared_errors)
    sensor = SolvedSensor(item.name, observations, calibration, None, budgets, reference=reference)
    return with_run_findings(sensor, undeclared.findings)


def checked_by_monte_carlo(
    solved: SolvedSensor, rig: RigDescription, sensor: Sensor, solve: Solve, trials: int
) -> SolvedSensor:
    """Return the sensor with the Monte Carlo check beside every budget."""
    if solved.calibration is None or solved.calibration.convention == "SR":
        return solved
    request = request_of(solved.name, rig, sensor, solve, solved.observations)
    words = joint_priors_in_words(solve.joint_priors_arcsec.items())
    return replace(solved, budgets=budgets_of(solved.calibration, request, rig, trials, words))


def _remarks(solve: Solve, rows: Sequence[DwellRecord]) -> Iterator[str]:
    """Tell what a reader of the result must know about what was asked for."""
    if solve.time_term == "linear":
        first = min(rows, key=lambda row: row.step)
        yield f"time term: the run's times count from {first.started_utc:%Y-%m-%d %H:%M:%S} UTC, its first dwell"
