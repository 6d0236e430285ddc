"""From dwells to solved sensors, for runs of every kind."""

import re
import traceback
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ams.calibration.together.table_dwell_search import StoodPackage
from ams.calibration.together.table_dwells import DwellsOfTable, judge_dwells
from ams.errors import AmsError
from ams.frames import ANGLES
from ams.inputs.known_of_run import NOTHING_KNOWN, KnownOfRun, ProvedChange
from ams.observations import Observations
from procedures.errors import ProcedureError
from procedures.kinds.registry import KINDS
from procedures.plan.plan import Plan
from procedures.records.dwells import DwellRecord
from procedures.solution.observations import design_dwells, observations_of
from procedures.solution.record import RunRecord
from procedures.solution.request import SensorRows, SolvedSensor
from procedures.solution.run_findings import findings_of_sensor, proved_changes, with_run_findings
from procedures.solution.standing_sides import StandingSides, with_standing_side
from procedures.solution.wild_temperatures import without_wild_temperatures
from rig.defects import defect_text
from rig.description.rig_file import RigDescription
from rig.errors import RigError

Tell = Callable[[str], None]


def solve_record(record: RunRecord, tell: Tell = lambda _step: None) -> dict[str, SolvedSensor]:
    """Solve every sensor of a run from its accepted dwells, as its procedure asks; ``tell`` hears of each.

    A defect costs the sensors that it concerns their result, and says so; where it is in what is told of all of them
    together, none has one.
    """
    run, source = record.run, f"run {record.run_id}"
    try:
        changes = proved_changes(record)
        solved = solve_sensors(record.dwells, record.rig, record.plan, source, tell, changes, run)
        sides = StandingSides(record)
        solved = {name: with_standing_side(sensor, sides) for name, sensor in solved.items()}
        return {name: with_run_findings(sensor, findings_of_sensor(record, sensor)) for name, sensor in solved.items()}
    except (AmsError, ProcedureError, RigError):
        raise
    except Exception as error:  # noqa: BLE001  a rim: without a page nobody is told that the dwells are kept
        names = record.plan.sensors
        return {name: _hindered(SolvedSensor(name, _no_rows(source), None, ""), error, run) for name in names}


def solve_sensors(
    dwells: Iterable[DwellRecord],
    rig: RigDescription,
    plan: Plan,
    source: str,
    tell: Tell = lambda _step: None,
    changes: tuple[ProvedChange, ...] = (),
    run: str = "",
) -> dict[str, SolvedSensor]:
    """Solve every sensor of a plan; a sensor that cannot be solved says why and hinders no other.

    ``changes``: of table or meter, as visits have proved them; no sensor is blamed for what they did. ``run``: as
    commands take it.
    Where all of them together show that the table stood off at single dwells, they are solved again with these dwells
    in no test of a sensor, and all carry the one finding.
    """
    rows = tuple(design_dwells(dwells))

    def solve_each(known_of_run: KnownOfRun) -> dict[str, SolvedSensor]:
        solved = {}
        for index, (name, sensor) in enumerate(plan.sensors.items(), start=1):
            tell(f"solving {name} ({index} of {len(plan.sensors)})")
            known = replace(known_of_run if sensor.rolls else NOTHING_KNOWN, changes=changes)
            with_it = tuple(row for row in rows if set(sensor.channels.values()) <= row.readings.keys())
            item = SensorRows(name, sensor, with_it, rig, plan, f"{source}, {name}", known, run)
            solved[name] = _solve_sensor(item, rows)
        return solved

    solved = solve_each(NOTHING_KNOWN)
    try:
        on_table = _dwells_of_table(solved, plan, changes)
    except Exception as error:  # noqa: BLE001  a rim: what no table turns was solved without it
        return {
            name: _hindered(sensor, error, run) if plan.sensors[name].rolls else sensor
            for name, sensor in solved.items()
        }
    if not on_table.known.has_dwells:
        return solved
    return {
        name: with_run_findings(again, on_table.findings) if plan.sensors[name].rolls else again
        for name, again in solve_each(on_table.known).items()
    }


def _dwells_of_table(solved: Mapping[str, SolvedSensor], plan: Plan, changes: Sequence[ProvedChange]) -> DwellsOfTable:
    """Return at which dwells the table stood off, by all packages that all of its axes turn."""
    if not plan.is_at_rest or not set(plan.axes) <= set(ANGLES):
        return DwellsOfTable()
    packages = [
        StoodPackage(name, sensor.observations, sensor.calibration)
        for name, sensor in solved.items()
        if sensor.calibration is not None
        and plan.sensors[name].measures == "acceleration"
        and plan.sensors[name].rolls  # what a sting carries turns with other axes
    ]
    return judge_dwells(packages, sum(len(sensor.channels) for sensor in plan.sensors.values()), changes)


def _solve_sensor(item: SensorRows, rows: tuple[DwellRecord, ...]) -> SolvedSensor:
    """``rows``: all accepted dwells of the design, also those that lack the sensor."""
    if not rows:
        return _unsolved(item, "no dwell of the design is accepted")
    if len(item.dwells) < len(rows):
        return _unsolved(item, _dropped(len(rows) - len(item.dwells)))
    try:
        measured, set_aside = without_wild_temperatures(item)
        return with_run_findings(KINDS[item.plan.kind].solve(measured), set_aside)
    except AmsError as error:
        return _unsolved(item, _of_what_is_there(_without_source(str(error), item.source), item))
    except (ProcedureError, RigError):
        raise
    except Exception as error:  # noqa: BLE001  a rim: a defect at one sensor takes the result of no other
        return _hindered(SolvedSensor(item.name, _no_rows(item.source), None, ""), error, item.run)


def _without_source(failure: str, source: str) -> str:
    """Return why, without run and sensor: whoever tells the failure of a sensor has named both."""
    return failure.removeprefix(source).lstrip(":, ") if failure.startswith(source) else failure


def _of_what_is_there(failure: str, item: SensorRows) -> str:
    """Return why, of a run that lacks dwells: its points are planned, and to add others is no way out."""
    planned = len(item.plan.design_dwells)
    if len(item.dwells) >= planned:
        return failure
    return re.sub(r"; add points[^;]*$", f"; {len(item.dwells)} of {planned} dwells of the design are there", failure)


def _unsolved(item: SensorRows, failure: str) -> SolvedSensor:
    return SolvedSensor(item.name, observations_of(item.dwells, item.channels, source=item.source), None, failure)


def _hindered(sensor: SolvedSensor, error: Exception, run: str) -> SolvedSensor:
    """Return a sensor that an error which nobody expected kept from being solved, with what to do about it."""
    what = str(error) if isinstance(error, AmsError) else defect_text(error)
    failure = (
        f"{what}; it was not solved, and every dwell of the run is kept in its journal: send the run's folder; "
        f"calrig solve {run or 'RUN'} with a newer version of calrig does it"
    )
    return replace(
        sensor, calibration=None, failure=failure, budgets={}, traceback="".join(traceback.format_exception(error))
    )


def _no_rows(source: str) -> Observations:
    """Return the rows of a sensor whose own could not even be put together."""
    none, labels = np.zeros(0), np.zeros(0, dtype=np.int64)
    return Observations(labels, labels, none, none, {}, source=source)


def _dropped(dwells: int) -> str:
    """Return why a sensor is not solved: half a calibration would be one of other points than were planned."""
    return (
        f"it was dropped while the run went on without it ({dwells} accepted dwells lack it); nothing was solved; the "
        "report says why; mend it and measure it in a new run"
    )
