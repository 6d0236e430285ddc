"""The one importer of the solvers: what a rig and a procedure say, as a request; what a run measured, as calibrations.

The command, the running estimate and the report all solve through here, so that the same observations always meet the
same model, the same table and the same treatment of temperature.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

from ams.calibration.calibrate import calibrate
from ams.calibration.mountings import calibrate_mountings
from ams.calibration_result import Calibration
from ams.errors import AmsError
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from procedures.description.procedure_file import Solve
from procedures.plan.channels import temperature_source
from procedures.records.dwells import DwellRecord
from procedures.solution.observations import observations_of
from procedures.solution.request import SolvedSensor, budgets_of, request_of
from procedures.solution.type_b import level_remarks
from rig.description.rig_file import RigDescription, Sensor


def solve_sensors(
    dwells: Iterable[DwellRecord], rig: RigDescription, sensors: Mapping[str, Sensor], solve: Solve, source: str
) -> dict[str, SolvedSensor]:
    """Solve every sensor of a run from its dwells; a sensor that cannot be solved says why and hinders no other."""
    rows = tuple(dwells)
    return {name: _solve_sensor(name, rows, rig, sensor, solve, source) for name, sensor in sensors.items()}


def solve_observations(observations: Observations, request: CalibrationRequest) -> Calibration:
    """Solve observations that came from a file. Raises: ams.errors.AmsError."""
    return calibrate(observations, request)


def _solve_sensor(
    name: str, rows: tuple[DwellRecord, ...], rig: RigDescription, sensor: Sensor, solve: Solve, source: str
) -> SolvedSensor:
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
        told = replace(solved, remarks=(*solved.remarks, *_told(solve, with_it), *level_remarks(rig)))
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
