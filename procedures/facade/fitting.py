"""``calrig.fit``: observations of a file or a table to coefficients, as the command of that name does."""

import math
from collections.abc import Mapping
from dataclasses import replace
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Literal

import pandas as pd

from ams.calibration.findings_document import full_document
from ams.calibration.linear_levels import Levels, calibrated_levels, levels_of_table, linear_document
from ams.errors import DesignError
from ams.inputs.csv_table import parse_csv, table_of
from ams.inputs.observations_csv import observations_of_table
from ams.inputs.reading_times import last_reading_utc
from ams.inputs.request import CalibrationRequest
from ams.models.registry import MODELS, senses_rates, takes_levels
from ams.models.thermal import TemperatureCoefficients
from procedures.data.solved import Solved
from procedures.errors import RequestError
from procedures.plan.gravity_of_site import read_rig_of_site
from procedures.records.overdue_standards import overdue_warnings
from procedures.solution.fit_options import (
    directions_of,
    errors_of_options,
    in_python,
    measured_utc,
    model_named,
    refuse_reference_temperature,
)
from procedures.solution.fitted import fitted
from procedures.solution.request import SolvedSensor
from procedures.solution.sensor_of_file import errors_of_file, named_sensor, require_sensor
from procedures.solution.type_b import on_table
from rig.local_time import local_day


def fit(
    observations: str | Path | pd.DataFrame,
    axes: Mapping[str, str],
    *,
    model: str = "pitch-roll",
    package: Literal["sting", "model"] | None = None,
    polarity: Mapping[str, Literal["+", "-"]] | None = None,
    temperature: Literal["none", "apply", "estimate"] = "none",
    temperature_order: Literal[1, 2] = 1,
    known_temperature: Mapping[str, TemperatureCoefficients] | None = None,
    reference_temperature_degc: float | None = None,
    extended: Literal["no", "test", "yes"] = "yes",
    time_term: Literal["none", "linear"] = "none",
    rig: str | Path | None = None,
    rate_uncertainty_ppm: float | None = None,
    direction_uncertainty_arcsec: float | None = None,
    largest_g_sensitivity_dps_per_g: float | None = None,
    rates_include_earth: bool = False,
    reference_uncertainty_ppm: float | None = None,
    reference_zero_uncertainty: float | None = None,
    sensor: str | None = None,
    calibrated_on: str | date | None = None,
) -> Solved:
    """Solve observations of a CSV file, or of a table with the same columns; equals ``calrig fit`` to the last bit.

    What is missing in a table (NaN, None) is an empty cell of the file, allowed and refused where that is.

    ``axes`` maps a sensor axis to its column, such as ``{"x": "sx_v"}``; every other argument is the option of that
    name of the command. ``package``: of ``pitch-yaw-roll``. ``polarity``: axis to sign, such as ``{"z": "-"}``.
    ``rig``: a rig file whose certificates are carried into the result. ``sensor``: one of that file, where there is
    one. ``calibrated_on``: the day of the readings, by which the due days of the rig's standards are judged; a column
    started_utc tells it. ``linear``: known levels in reference_<unit>, no attitudes and no rig, their standard
    uncertainties in ``reference_uncertainty_ppm`` and, in their unit, ``reference_zero_uncertainty``; two levels once
    have gain and offset in the document alone, since nothing tells an uncertainty.

    Raises: ams.errors.AmsError for observations that say something impossible or determine nothing; RequestError for
    another model, or a sensor that the rig file has not; rig.errors.DescriptionError for a wrong rig file.
    """
    wanted = MODELS[model_named(model, package, in_python)]
    if rig is not None and (senses_rates(model) or takes_levels(model)):
        raise RequestError(f"fit: rig: carries the indices of a table at rest: not allowed with model {model!r}")
    refuse_reference_temperature(reference_temperature_degc, temperature, in_python)
    stated = (
        rate_uncertainty_ppm, direction_uncertainty_arcsec, largest_g_sensitivity_dps_per_g, reference_uncertainty_ppm,
        reference_zero_uncertainty,
    )  # fmt: skip
    of_options = errors_of_options(stated, model, in_python, rates_include_earth=rates_include_earth)
    described = None if rig is None else read_rig_of_site(Path(rig))
    require_sensor(described, sensor, str(rig))
    sensor = named_sensor(described, sensor, axes.values())
    request = CalibrationRequest(
        model=wanted.name,
        nominal_axes={label: label for label in axes},
        temperature=temperature,
        temperature_order=temperature_order,
        known_temperature=known_temperature or {},
        reference_temperature_degc=reference_temperature_degc,
        extended=extended,
        time_term=time_term == "linear",
        declared=directions_of(polarity or {}, axes, model, (described, sensor), in_python),
        shared_errors=of_options if described is None else errors_of_file(described, sensor),
    )
    request = on_table(request, described)
    if isinstance(observations, pd.DataFrame):
        table = table_of({str(name): _cells(observations[name]) for name in observations.columns}, "table")
    else:
        table = parse_csv(Path(observations))
    name = sensor or "sensor"
    today = local_day(datetime.now(UTC))
    measured = measured_utc(last_reading_utc(table), calibrated_on, today, in_python)
    if wanted.takes_levels:
        return _lines(levels_of_table(table, axes), request, name)
    rows = observations_of_table(table, axes, wanted.columns, rates=wanted.needs_rates)
    overdue = () if described is None else overdue_warnings(described, today, measured)
    solved = fitted(name, rows, axes, request, described, doubts=overdue)
    assert solved.calibration is not None
    return Solved({name: solved}, full_document(solved.calibration, rows, solved.budgets))


def _cells(column: pd.Series) -> list[object]:
    """Return the values of a column, NaN for each kind of nothing that pandas knows."""
    return [math.nan if is_nothing else value for value, is_nothing in zip(column, column.isna(), strict=True)]


def _lines(levels: Mapping[str, Levels], request: CalibrationRequest, sensor: str) -> Solved:
    document = linear_document(levels, request)
    units = {axis: level.model.measured_unit for axis, level in levels.items()}
    rows = replace(next(iter(levels.values())).observations, units=units)
    try:
        solved = SolvedSensor(sensor, rows, calibrated_levels(levels, request), None)
    except DesignError as error:
        solved = SolvedSensor(sensor, rows, None, str(error))
    return Solved({sensor: solved}, document)
