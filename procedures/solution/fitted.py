"""Observations that came from a file or a table, solved: the one way of ``calrig fit`` and of ``calrig.fit``."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Final

from ams.calibration.packages import calibrate_packages
from ams.findings import Said
from ams.frames import ANGLES
from ams.inputs.copied_replications import refuse_copies
from ams.inputs.observations_csv import unit_warnings
from ams.inputs.possible_outputs import refuse_impossible_outputs, refuse_overloads
from ams.inputs.reading_times import clock_warnings
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SharedError
from ams.models.registry import MODELS
from ams.observations import Observations
from ams.sets.sensed_quantity import FIELDS
from ams.sets.stated_findings import RATES_NOT_COUNTED, TABLE_NOT_COUNTED
from procedures.errors import RequestError
from procedures.plan.channels import environment_of
from procedures.records.declared_gaps import (
    crosstalk_remarks,
    gravity_remarks,
    meter_remarks,
    temperature_remarks,
    thermometer_remarks,
    undeclared_directions,
)
from procedures.solution.crosstalk import with_scanned_volts
from procedures.solution.declared_temperature import temperature_warnings
from procedures.solution.dominating_limits import dominating_limits
from procedures.solution.earth_turn import EARTH_DPS
from procedures.solution.level_of_base import level_remarks, level_warnings
from procedures.solution.meter_reach import meter_reach
from procedures.solution.request import SolvedSensor, budgets_of
from procedures.solution.run_findings import with_run_findings
from procedures.solution.temperature_of_use import at_use, warnings_of_use
from procedures.solution.type_b import direction_error, gravity_on_gyros_remarks, gravity_warnings, shared_errors
from procedures.solution.undeclared import Undeclared
from rig.description.rig_file import RigDescription, Sensor

BY_A_RIG_FILE: Final = f"{TABLE_NOT_COUNTED}; a rig file (--rig of calrig fit, rig of calrig.fit) brings them in"
OF_THIS_RIG_FILE: Final = f"{TABLE_NOT_COUNTED}; the rig file states 0 of them ([axes.NAME] uncertainty_arcsec)"


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
    refuse_copies(observations)
    refuse_overloads(observations, columns)
    if not MODELS[request.model].needs_rates:
        reach = {} if rig is None else meter_reach(rig, sensor_of(rig, name))
        refuse_impossible_outputs(observations, columns, reach)
    used, recorded_degc = None if rig is None else sensor_of(rig, name), observations.temperature_degc
    request = at_use(request, used, recorded_degc)
    observations = observations if rig is None else with_scanned_volts(observations, rig, used)
    solved = calibrate_packages({name: observations}, request)[name]
    of_rig = (*_of_level(request, rig), *_of_gravity(request, rig), *not_counted(request, rig))
    of_rig += () if rig is None else temperature_warnings(observations, rig, sensor_of(rig, name))
    of_rig += () if rig is None else sensor_warnings(rig, name)
    warnings = (
        *unit_warnings(observations, columns),
        *clock_warnings(observations),
        *doubts,
        *solved.warnings,
        *of_rig,
        *warnings_of_use(used, request.temperature, recorded_degc),
    )
    undeclared, of_thermometer = Undeclared(directions=_of_directions(request)), tuple[Said, ...]()
    if rig is not None:
        measured = sensor_of(rig, name)
        undeclared = Undeclared(
            level_remarks(rig),
            meter_remarks(rig, measured),
            gravity=gravity_remarks(rig, senses_gravity=_senses_gravity(request)),
            crosstalk=crosstalk_remarks(rig, measured),
        )
        of_thermometer = thermometer_remarks(rig, [] if measured is None else [measured], request.temperature)
    remarks = (
        *solved.remarks,
        *rate_remarks(request),
        *undeclared.remarks,
        *temperature_remarks(observations, None if rig is None else use_degc_of(sensor_of(rig, name))),
        *(said.text for said in of_thermometer),
    )
    calibration = replace(solved, warnings=warnings, remarks=remarks)
    budgets = budgets_of(calibration, request, rig, trials)
    calibration = replace(calibration, remarks=(*remarks, *dominating_limits(calibration.axes, budgets)))
    return with_run_findings(SolvedSensor(name, observations, calibration, None, budgets), undeclared.findings)


def _of_level(request: CalibrationRequest, rig: RigDescription | None) -> tuple[str, ...]:
    """Say it where attitudes are counted from the base; it does not turn what sensors of rates sense."""
    return level_warnings(rig) if rig is not None and not MODELS[request.model].needs_rates else ()


def _of_gravity(request: CalibrationRequest, rig: RigDescription | None) -> tuple[str, ...]:
    """Say it where gravity is what the model senses."""
    return gravity_warnings(rig, None) if rig is not None and _senses_gravity(request) else ()


def _senses_gravity(request: CalibrationRequest) -> bool:
    return request.model in FIELDS and FIELDS[request.model].unit == "g"


def rate_error(uncertainty_ppm: float) -> SharedError:
    """Return the one error of all rates of a table, as a relative standard uncertainty states it."""
    return SharedError("rate of the table", "rate", 1e-6 * uncertainty_ppm, stated=f"u {uncertainty_ppm:g} ppm")


def direction_errors(u_arcsec: float) -> tuple[SharedError, ...]:
    """Return how far the axes of a table lean, each by itself, as one standard uncertainty of all of them states it."""
    return tuple(direction_error(axis, u_arcsec, f"u {u_arcsec:g}″ to either side") for axis in ANGLES)


def not_counted(request: CalibrationRequest, rig: RigDescription | None = None) -> tuple[str, ...]:
    """Say that nobody stated how far the table may be wrong, so that the uncertainties are too small by it.

    ``rig``: of the fit, where it was given one.
    """
    if MODELS[request.model].needs_rates:
        is_known = any(error.effect == "rate" for errors in request.shared_errors.values() for error in errors)
        of_rates = (
            f"{RATES_NOT_COUNTED}: a rate that is wrong by a part is a sensitivity that is wrong by it; "
            "--rate-uncertainty-ppm of calrig fit brings them in"
        )
        return () if is_known else (of_rates,)
    if request.table is not None:
        return ()
    return (BY_A_RIG_FILE if rig is None else OF_THIS_RIG_FILE,)


def _of_directions(request: CalibrationRequest) -> tuple[Said, ...]:
    """Say of gyros that nobody stated how far the axes lean that they turned about."""
    errors = (error for errors in request.shared_errors.values() for error in errors)
    if not MODELS[request.model].needs_rates or any(error.effect == "spin-direction" for error in errors):
        return ()
    return (undeclared_directions("state it (--direction-uncertainty-arcsec of calrig fit)"),)


def rate_remarks(request: CalibrationRequest) -> tuple[str, ...]:
    """Say what of the rates is not in the values of gyros that are solved from a file."""
    if not MODELS[request.model].needs_rates:
        return ()
    return (
        f"rates are taken as those of the file: the Earth's rotation ({EARTH_DPS:.2g} °/s) is in the uncertainties "
        "nowhere; where it matters put it into the rates, or calibrate by a run, which takes latitude_deg and "
        "heading_deg of the rig file",
        *gravity_on_gyros_remarks(request.shared_errors, senses_rates=True),
    )


def require_sensor(rig: RigDescription | None, name: str | None, source: str) -> None:
    """Check that a sensor that is named stands in the rig file ``source``. Raises: RequestError where it does not."""
    if rig is not None and name is not None and name not in rig.sensors:
        raise RequestError(
            f"sensor {name!r}: {source} has no [sensors.{name}] (allowed: {', '.join(sorted(rig.sensors))}); nothing "
            "was solved; name one of these, or add it to the rig file"
        )


def named_sensor(rig: RigDescription | None, name: str | None, columns: Iterable[str]) -> str | None:
    """Return the sensor that is named; of several in a rig file the one whose name all columns begin with.

    ``columns``: of the file, such as ``SN1047_x_v``. None where nothing names one.
    """
    if rig is None or name is not None or len(rig.sensors) < 2:
        return name
    written = tuple(columns)
    matching = [sensor for sensor in rig.sensors if all(_begins_with(column, sensor) for column in written)]
    return matching[0] if len(matching) == 1 else None


def _begins_with(column: str, sensor: str) -> bool:
    return column.startswith(sensor) and not column[len(sensor) : len(sensor) + 1].isalnum()


def sensor_warnings(rig: RigDescription, name: str | None) -> tuple[str, ...]:
    """Say of a rig file of several sensors, none of them named, what of it was held against nothing."""
    if sensor_of(rig, name) is not None or not rig.sensors:
        return ()
    return (
        f"the rig file has {len(rig.sensors)} sensors ({', '.join(sorted(rig.sensors))}) and nothing says which was "
        "measured: sensitivity, direction and polarity that it declares were not held against the readings, and the "
        "meter and the limits of a sensor's data sheet are not in the uncertainties; name it (--sensor NAME of calrig "
        "fit, sensor of calrig.fit; columns that begin with its name do it too)",
    )


def errors_of_file(rig: RigDescription, name: str | None) -> dict[str, tuple[SharedError, ...]]:
    """Return what the rig file declares of the readings of a file; the sensor as :func:`sensor_of` takes it."""
    sensor = sensor_of(rig, name)
    return shared_errors(rig, sensor, None if sensor is None else environment_of(rig, sensor))


def use_degc_of(sensor: Sensor | None) -> tuple[float, float] | None:
    """Return the declared range of use; None where none is, or no sensor is known."""
    return None if sensor is None else sensor.use_temperature_degc


def sensor_of(rig: RigDescription, name: str | None) -> Sensor | None:
    """Return the sensor whose channels stand in the rig file.

    The one named, else the only one; None where that is open.
    """
    if name is not None and name in rig.sensors:
        return rig.sensors[name]
    return next(iter(rig.sensors.values())) if len(rig.sensors) == 1 else None
