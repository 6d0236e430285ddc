"""From dwells to solved sensors, for runs of every kind."""

from collections.abc import Callable, Iterable

from ams.errors import AmsError
from procedures.kinds.registry import KINDS
from procedures.plan.plan import Plan
from procedures.records.dwells import DwellRecord
from procedures.solution.observations import design_dwells, observations_of
from procedures.solution.record import RunRecord
from procedures.solution.request import SensorRows, SolvedSensor
from procedures.solution.run_findings import of_sensor, run_findings, with_run_findings
from rig.description.rig_file import RigDescription, Sensor

Tell = Callable[[str], None]


def solve_record(record: RunRecord, tell: Tell = lambda _step: None) -> dict[str, SolvedSensor]:
    """Solve every sensor of a run from its accepted dwells, as its procedure asks; ``tell`` hears of each."""
    solved = solve_sensors(record.dwells, record.rig, record.plan, f"run {record.run_id}", tell)
    findings = run_findings(record)
    return {name: with_run_findings(sensor, of_sensor(findings, name)) for name, sensor in solved.items()}


def solve_sensors(
    dwells: Iterable[DwellRecord],
    rig: RigDescription,
    plan: Plan,
    source: str,
    tell: Tell = lambda _step: None,
) -> dict[str, SolvedSensor]:
    """Solve every sensor of a plan; a sensor that cannot be solved says why and hinders no other."""
    rows = tuple(design_dwells(dwells))
    solved = {}
    for index, (name, sensor) in enumerate(plan.sensors.items(), start=1):
        tell(f"solving {name} ({index} of {len(plan.sensors)})")
        solved[name] = _solve_sensor(name, sensor, rows, rig, plan, source)
    return solved


def _solve_sensor(
    name: str, sensor: Sensor, rows: tuple[DwellRecord, ...], rig: RigDescription, plan: Plan, source: str
) -> SolvedSensor:
    with_it = tuple(row for row in rows if set(sensor.channels.values()) <= row.readings.keys())
    item = SensorRows(name, sensor, with_it, rig, plan, f"{source}, {name}")
    if not rows:
        return _unsolved(item, "no dwell of the design is accepted")
    if len(with_it) < len(rows):
        return _unsolved(item, _dropped(len(rows) - len(with_it)))
    try:
        return KINDS[plan.kind].solve(item)
    except AmsError as error:
        return _unsolved(item, _without_source(str(error), item.source))


def _without_source(failure: str, source: str) -> str:
    """Return why, without run and sensor: whoever tells the failure of a sensor has named both."""
    return failure.removeprefix(source).lstrip(":, ") if failure.startswith(source) else failure


def _unsolved(item: SensorRows, failure: str) -> SolvedSensor:
    return SolvedSensor(item.name, observations_of(item.dwells, item.channels, source=item.source), None, failure)


def _dropped(dwells: int) -> str:
    """Return why a sensor is not solved: half a calibration would be one of other points than were planned."""
    return (
        f"it was dropped while the run went on without it ({dwells} accepted dwells lack it); nothing was solved; the "
        "report says why; mend it and measure it in a new run"
    )
