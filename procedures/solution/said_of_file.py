"""What is said of a file's result beside the tests of its data, whether its table was solved with it or not.

The counterpart of :mod:`procedures.solution.said_of_run` for rows that no run of calrig recorded: what a column looks
like, what nobody declared, and what the rig file contradicts itself in.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.findings import Said
from ams.inputs.observations_csv import unit_warnings
from ams.inputs.reading_times import clock_warnings
from ams.inputs.request import CalibrationRequest
from ams.models.registry import MODELS
from ams.observations import Observations
from ams.sets.sensed_quantity import FIELDS
from ams.sets.stated_findings import RATES_NOT_COUNTED, TABLE_NOT_COUNTED
from procedures.plan.undeclared import Undeclared
from procedures.records.declared_gaps import (
    crosstalk_remarks,
    gravity_remarks,
    level_remarks,
    meter_remarks,
    temperature_remarks,
    thermometer_remarks,
    undeclared_directions,
)
from procedures.solution.declared_temperature import temperature_warnings
from procedures.solution.earth_turn import EARTH_DPS
from procedures.solution.level_of_base import level_warnings
from procedures.solution.sensor_of_file import sensor_of
from procedures.solution.temperature_of_use import warnings_of_use
from procedures.solution.type_b import gravity_on_gyros_remarks, gravity_warnings
from rig.description.rig_file import RigDescription, Sensor

BY_A_RIG_FILE: Final = f"{TABLE_NOT_COUNTED}; a rig file (--rig of calrig fit, rig of calrig.fit) brings them in"
OF_THIS_RIG_FILE: Final = f"{TABLE_NOT_COUNTED}; the rig file states 0 of them ([axes.NAME] uncertainty_arcsec)"


@dataclass(frozen=True)
class SaidOfFile:
    """Of one sensor."""

    undeclared: Undeclared
    remarks: tuple[str, ...]
    """What nobody declared is among them."""
    warnings: tuple[str, ...]


def said_of_file(
    mountings: Sequence[Observations],
    columns: Mapping[str, str],
    request: CalibrationRequest,
    rig: RigDescription | None,
    name: str | None,
    *,
    stands_level: bool = False,
) -> SaidOfFile:
    """Return what is said of one sensor.

    ``mountings``: the rows of the file, those of each mounting by themselves. ``columns``: sensor axis to the column
    that it was read from. ``name``: of the sensor, as :func:`sensor_of` takes it. ``stands_level``: whether the
    operator stated how far the base and its zeros may be wrong.
    """
    used, recorded_degc = None if rig is None else sensor_of(rig, name), recorded_temperatures(mountings)
    senses_gravity = request.model in FIELDS and FIELDS[request.model].unit == "g"
    undeclared = Undeclared(directions=_of_directions(request))
    of_thermometer, of_rig = tuple[Said, ...](), tuple[str, ...]()
    if rig is not None:
        undeclared = Undeclared(
            () if stands_level else level_remarks(rig),
            meter_remarks(rig, used),
            gravity=gravity_remarks(rig, senses_gravity=senses_gravity),
            crosstalk=crosstalk_remarks(rig, used),
        )
        of_thermometer = thermometer_remarks(rig, [] if used is None else [used], request.temperature)
        of_rig = tuple(_of_rig(mountings, rig, used, senses_gravity=senses_gravity))
    warnings = (
        *(text for rows in mountings for text in unit_warnings(rows, columns)),
        *(text for rows in mountings for text in clock_warnings(rows)),
        *not_counted(request, rig),
        *of_rig,
        *warnings_of_use(used, request.temperature, recorded_degc),
    )
    use_degc = None if used is None else used.use_temperature_degc
    remarks = (
        *rate_remarks(request),
        *undeclared.remarks,
        *temperature_remarks(mountings[0], use_degc),
        *(said.text for said in of_thermometer),
    )
    return SaidOfFile(undeclared, remarks, tuple(dict.fromkeys(warnings)))


def recorded_temperatures(mountings: Sequence[Observations]) -> FloatArray | None:
    """Return the temperatures of all rows, °C; None where the file has none."""
    read = [rows.temperature_degc for rows in mountings if rows.temperature_degc is not None]
    return np.concatenate(read) if read else None


def _of_rig(
    mountings: Sequence[Observations], rig: RigDescription, used: Sensor | None, *, senses_gravity: bool
) -> Iterator[str]:
    yield from level_warnings(rig)
    if senses_gravity:
        yield from gravity_warnings(rig, None)
    for rows in mountings:
        yield from temperature_warnings(rows, rig, used)
    if used is None and rig.sensors:
        yield (
            f"the rig file has {len(rig.sensors)} sensors ({', '.join(sorted(rig.sensors))}) and nothing says which "
            "was measured: sensitivity, direction and polarity that it declares were not held against the readings, "
            "and the meter and the limits of a sensor's data sheet are not in the uncertainties; name it (--sensor "
            "NAME of calrig fit, sensor of calrig.fit; columns that begin with its name do it too)"
        )


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
    is_counted = any(error.effect == "rotation" for errors in request.shared_errors.values() for error in errors)
    of_earth = (
        f"the Earth's rotation ({EARTH_DPS:.4f} °/s) is in the uncertainty, in a direction that nothing states; put it "
        "into the rates (latitude and heading of the table tell it) and say so by --rates-include-earth of calrig fit, "
        "or calibrate by a run, which takes latitude_deg and heading_deg of the rig file"
        if is_counted
        else "the rates are stated to include the Earth's (--rates-include-earth of calrig fit): its rotation is in no "
        "uncertainty"
    )
    return (
        of_earth,
        *gravity_on_gyros_remarks(request.shared_errors, senses_rates=True),
    )
