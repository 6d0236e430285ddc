"""The one importer of the solvers: what a rig and a procedure say, as a request; what a run measured, as calibrations.

The command, the running estimate and the report all solve through here, so that the same observations always meet the
same model, the same table and the same treatment of temperature.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import radians
from types import MappingProxyType
from typing import TYPE_CHECKING

from procedures.certificates import (
    ARCSEC_PER_DEG,
    gravity_of,
    shared_errors,
    standard_uncertainty_arcsec,
    table_in_words,
)
from procedures.description import Solve
from procedures.report.observations import TemperatureChannel, observations_of
from procedures.run.records import DwellRecord
from rig.description import RigDescription, Sensor

if TYPE_CHECKING:
    from ams.observations import Observations
    from ams.request import CalibrationRequest
    from ams.solve.result import Calibration
    from ams.uncertainty.calibration_budget import AxisBudget
    from ams.uncertainty.shared_errors import SharedError
    from ams.uncertainty.table import TableUncertainty
    from procedures.motion_solving import StaticAxis


@dataclass(frozen=True)
class SolvedSensor:
    """One package of a run: its rows, and its calibration or why there is none."""

    name: str
    observations: "Observations"
    calibration: "Calibration | None"
    failure: str | None
    budgets: "Mapping[str, AxisBudget]" = field(default_factory=dict)
    """Axis to its uncertainty budget."""
    static: "Mapping[str, StaticAxis]" = field(default_factory=dict)
    """Axis to what a long rest showed; there is no calibration then."""


def solve_sensors(
    dwells: Iterable[DwellRecord], rig: RigDescription, sensors: Mapping[str, Sensor], solve: Solve, source: str
) -> dict[str, SolvedSensor]:
    """Solve every sensor of a run from its dwells; a sensor that cannot be solved says why and hinders no other."""
    rows = tuple(dwells)
    return {name: _solve_sensor(name, rows, rig, sensor, solve, source) for name, sensor in sensors.items()}


def solve_observations(observations: "Observations", request: "CalibrationRequest") -> "Calibration":
    """Solve observations that came from a file. Raises: ams.errors.AmsError."""
    from ams.calibrate import calibrate

    return calibrate(observations, request)


def table_uncertainty(rig: RigDescription) -> "TableUncertainty | None":
    """The rig's indices, as standard uncertainties; None where no axis has any."""
    from ams.uncertainty.table import TableUncertainty

    axes = ("pitch", "roll", "yaw")
    pitch_rad, roll_rad, yaw_rad = (_arcsec_to_rad(standard_uncertainty_arcsec(rig, axis)) for axis in axes)
    if pitch_rad == roll_rad == yaw_rad == 0.0:
        return None
    return TableUncertainty(pitch_rad, roll_rad, kind="standard", yaw_rad=yaw_rad)


def request_for(
    sensor_name: str,
    channels: Iterable[str],
    solve: Solve,
    table: "TableUncertainty | None",
    shared: "Mapping[str, tuple[SharedError, ...]]" = MappingProxyType({}),
) -> "CalibrationRequest":
    """What a procedure's ``[solve]`` asks of one sensor, under the certificates of its rig."""
    from ams.models.thermal import TemperatureCoefficients
    from ams.request import CalibrationRequest

    axes = tuple(channels)
    known = {
        axis: solve.known_temperature[key]
        for axis in axes
        if (key := f"{sensor_name}.{axis}") in solve.known_temperature
    }
    references = {item.reference_temperature_degc for item in known.values()}
    return CalibrationRequest(
        model=model_name(solve, sensor_name),
        nominal_axes={axis: axis for axis in axes},
        temperature=solve.temperature,
        known_temperature={
            axis: TemperatureCoefficients(item.offset_tc_v_per_degc, item.sensitivity_tc_per_degc)
            for axis, item in known.items()
        },
        reference_temperature_degc=references.pop() if len(references) == 1 else None,
        extended=solve.extended,
        time_term=solve.time_term == "linear",
        table=table,
        shared_errors=shared,
    )


def budgets_of(
    calibration: "Calibration", request: "CalibrationRequest", rig: RigDescription | None, trials: int = 0
) -> "dict[str, AxisBudget]":
    """Axis to its budget under what was asked for; ``trials`` of a Monte Carlo check, 0: none."""
    from ams.uncertainty.calibration_budget import axis_budget

    gravity = None if rig is None else gravity_of(rig)
    told = {} if rig is None else {"table": table_in_words(rig)}
    return {
        label: axis_budget(axis, request.shared_errors.get(label, ()), gravity, stated=told, trials=trials)
        for label, axis in calibration.axes.items()
    }


def model_name(solve: Solve, sensor: str) -> str:
    """What the mathematics calls the model of one sensor: CR's two packages are two models."""
    if solve.model == "pitch-yaw-roll":
        return f"pitch-yaw-roll-{solve.packages.get(sensor, 'model')}"
    return "linear-accelerometer" if solve.model == "linear" else solve.model


def _solve_sensor(
    name: str, rows: tuple[DwellRecord, ...], rig: RigDescription, sensor: Sensor, solve: Solve, source: str
) -> SolvedSensor:
    from ams.errors import AmsError
    from ams.mountings import calibrate_mountings

    with_it = tuple(row for row in rows if not row.accepted or set(sensor.channels.values()) <= row.readings.keys())
    observations = observations_of(
        with_it,
        {str(axis): channel for axis, channel in sensor.channels.items()},
        temperature_source(rig, sensor),
        f"{source}, {name}",
        rig.chain,
    )
    if len(with_it) < len(rows):
        return SolvedSensor(name, observations, None, _dropped(len(rows) - len(with_it)))
    try:
        request = request_of(name, rig, sensor, solve)
        solved = calibrate_mountings(observations, request)
        told = replace(solved, remarks=(*solved.remarks, *_told(solve, with_it)))
        return SolvedSensor(name, observations, told, None, budgets_of(solved, request, rig))
    except AmsError as error:
        return SolvedSensor(name, observations, None, str(error))


def checked_by_monte_carlo(
    solved: SolvedSensor, rig: RigDescription, sensor: Sensor, solve: Solve, trials: int
) -> SolvedSensor:
    """With the Monte Carlo check beside every budget."""
    if solved.calibration is None:
        return solved
    request = request_of(solved.name, rig, sensor, solve)
    return replace(solved, budgets=budgets_of(solved.calibration, request, rig, trials))


def request_of(name: str, rig: RigDescription, sensor: Sensor, solve: Solve) -> "CalibrationRequest":
    """What is asked of one sensor of a run."""
    source = temperature_source(rig, sensor)
    errors = shared_errors(rig, sensor, source if isinstance(source, str) else None)
    return request_for(name, sensor.channels, solve, table_uncertainty(rig), errors)


def _told(solve: Solve, rows: tuple[DwellRecord, ...]) -> Iterator[str]:
    """What a reader of the result must know about what was asked for."""
    if solve.time_term == "linear":
        first = min((row for row in rows if row.accepted and row.purpose == "design"), key=lambda row: row.step)
        yield f"time term: the run's times count from {first.started_utc:%Y-%m-%d %H:%M:%S} UTC, its first dwell"
    if solve.model == "linear":
        yield "straight lines make no coefficient set: take them from this document or the report"


def _dropped(dwells: int) -> str:
    """Half a calibration would be one of other points than were planned."""
    return (
        f"it was dropped while the run went on without it ({dwells} accepted dwells lack it); nothing was solved; the "
        "report says why; mend it and measure it in a new run"
    )


def temperature_source(rig: RigDescription, sensor: Sensor) -> TemperatureChannel | str | None:
    """The sensor's own channel, else the rig's only environment, else none."""
    if sensor.temperature is not None:
        own = sensor.temperature
        return TemperatureChannel(own.channel, own.offset_degc, own.slope_degc_per_v)
    return next(iter(rig.environment)) if len(rig.environment) == 1 else None


def _arcsec_to_rad(value_arcsec: float) -> float:
    return radians(value_arcsec / ARCSEC_PER_DEG)
