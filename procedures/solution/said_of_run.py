"""What is said of a run's result beside the tests of its data, whatever it was solved by.

What nobody declared, what was asked for in its files, and what the rig file contradicts itself in: every solver of runs
says it from here, so that no way to a number is silent of what another tells.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from ams.inputs.shared_errors import SharedError
from ams.observations import Observations
from procedures.description.procedure_file import Solve
from procedures.plan.sequential import stopped_in_words
from procedures.plan.undeclared import Undeclared, undeclared_of
from procedures.records.declared_gaps import temperature_remarks, thermometer_remarks
from procedures.records.dwells import DwellRecord
from procedures.solution.adaptive_words import adaptive_in_words
from procedures.solution.earth_turn import earth_remarks
from procedures.solution.level_of_base import level_warnings
from procedures.solution.request import SensorRows
from procedures.solution.temperature_of_use import warnings_of_use
from procedures.solution.type_b import gravity_on_gyros_remarks, gravity_warnings


@dataclass(frozen=True)
class SaidOfRun:
    """Of one sensor."""

    undeclared: Undeclared
    remarks: tuple[str, ...]
    """What nobody declared is among them."""
    warnings: tuple[str, ...]


def said_of_run(
    item: SensorRows,
    observations: Observations,
    errors: Mapping[str, tuple[SharedError, ...]],
) -> SaidOfRun:
    """Return what is said of one sensor.

    ``errors``: sensor axis to the errors that it was solved with.
    """
    rig, sensor, plan = item.rig, item.sensor, item.plan
    undeclared = undeclared_of(rig, sensor, plan)
    stopped = stopped_in_words(plan, max(dwell.replication for dwell in item.dwells))
    remarks = (
        *_time_term(plan.solve, item.dwells),
        *undeclared.remarks,
        *temperature_remarks(observations, sensor.use_temperature_degc),
        *(said.text for said in thermometer_remarks(rig, [sensor], plan.solve.temperature)),
        *(earth_remarks(rig, sensor) if plan.counts_earth else ()),
        *gravity_on_gyros_remarks(errors, senses_rates=sensor.measures == "rate"),
        *(text for text in (stopped, adaptive_in_words(item)) if text is not None),
    )
    warnings = (
        # A tilted base does not turn what sensors of rates sense.
        *(level_warnings(rig) if sensor.measures != "rate" else ()),
        *gravity_warnings(rig, sensor),
        *warnings_of_use(sensor, plan.solve.temperature, observations.temperature_degc),
    )
    return SaidOfRun(undeclared, remarks, warnings)


def _time_term(solve: Solve, rows: Sequence[DwellRecord]) -> Iterator[str]:
    if solve.time_term == "linear":
        first = min(rows, key=lambda row: row.step)
        yield f"time term: the run's times count from {first.started_utc:%Y-%m-%d %H:%M:%S} UTC, its first dwell"
