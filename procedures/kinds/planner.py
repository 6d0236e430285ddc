"""From a rig and a procedure to the plan of a run; every impossible wish is refused here, before any port is opened.

The kind lays out its steps; what every plan is held to stands here: sensors to calibrate, attitudes that the axes
reach, temperature terms that are measured.
"""

from collections.abc import Iterator, Mapping

from pydantic import JsonValue

from procedures.description.kind_tables import Static
from procedures.description.procedure_file import ProcedureDescription
from procedures.errors import PlanError
from procedures.kinds.kind import Kind, PlanRequest
from procedures.kinds.registry import KINDS
from procedures.kinds.unwritable_exports import unwritable_exports
from procedures.plan.adaptive import adaptive_refusals
from procedures.plan.channels import channels_of, sensors_that_measure
from procedures.plan.estimate import NOTHING_LEARNED, expected_duration
from procedures.plan.learned_times import LearnedTimes
from procedures.plan.plan import PLAN_VERSION, Plan
from procedures.plan.refusals import shared_refusals
from procedures.plan.sequential import sequential_of, sequential_refusals
from procedures.plan.unjudged_limits import limits_of_nobody
from procedures.plan.unreachable import unreachable
from procedures.solution.expected_readings import planned_readings
from rig.description.rig_file import RigDescription, Sensor


def make_plan(
    rig: RigDescription,
    procedure: ProcedureDescription,
    fresh_seed: int | None = None,
    learned: LearnedTimes = NOTHING_LEARNED,
) -> Plan:
    """Return the plan of a run. ``fresh_seed`` serves the order ``random``; by default it is drawn here and kept.

    ``learned``: what past runs of the rig taught of how long it takes.

    Raises: PlanError naming file, line and key of everything that the rig cannot do or the design cannot determine.
    """
    kind = KINDS[procedure.procedure.kind]
    sensors = _sensors(rig, procedure, kind)
    request = PlanRequest(rig, procedure, sensors, channels_of(rig, sensors), fresh_seed)
    schedule = kind.schedule(request)
    reasons = [
        *sequential_refusals(procedure, is_at_rest=kind.table is None),
        *adaptive_refusals(rig, procedure, sensors, is_at_rest=kind.table is None),
        *kind.refusals(request, schedule),
        *unreachable(rig, procedure, schedule.steps, kind.key_of_angle),
        *shared_refusals(rig, procedure, sensors, schedule.environment),
        *(_of_calibrations(kind, rig, procedure, sensors) if procedure.table_of(Static) is None else ()),
    ]
    if reasons:
        raise PlanError("\n".join(str(reason) for reason in reasons))
    readings = planned_readings(rig, procedure.dwell, procedure.solve, sensors)
    return Plan(
        version=PLAN_VERSION,
        title=procedure.procedure.title,
        kind=kind.name,
        axes=request.axes,
        sensors=sensors,
        channels=request.channels,
        settle_channel=request.channels[0],
        design=schedule.design,
        order=schedule.order,
        seed=schedule.seed,
        replications=schedule.replications,
        usage_pitch_deg=schedule.usage_pitch_deg,
        dwell=procedure.dwell,
        environment=schedule.environment,
        reference=schedule.reference,
        solve=procedure.solve,
        export_formats=procedure.export.formats,
        max_duration_s=procedure.stop.max_duration_s if procedure.stop else None,
        expected=expected_duration(rig, schedule.steps, procedure.dwell, request.channels, learned, readings),
        steps=schedule.steps,
        attitude_reference=rig.attitude_reference,
        kind_settings=_settings_of(procedure, kind),
        most_samples=schedule.most_samples,
        sequential=sequential_of(procedure, schedule.design, is_at_rest=kind.table is None),
        moving_together=rig.moving_together(),
        reading_together=rig.reading_together(),
        counts_earth=True,
        counts_temperature=True,
    )


def _settings_of(procedure: ProcedureDescription, kind: Kind) -> dict[str, dict[str, JsonValue]]:
    """Return the kind's own table by its name, every key of it as JSON has it; nothing where the kind has none."""
    if kind.table is None:
        return {}
    name, form = kind.table
    table = procedure.table_of(form)
    assert table is not None, "the file was refused without it"
    return {name: table.model_dump(mode="json")}


def _of_calibrations(
    kind: Kind, rig: RigDescription, procedure: ProcedureDescription, sensors: Mapping[str, Sensor]
) -> Iterator[PlanError]:
    """Tell what no calibration of these sensors can be held to, and no set of them written as."""
    yield from limits_of_nobody(rig, procedure, sensors)
    yield from unwritable_exports(kind, procedure, sensors)


def _sensors(rig: RigDescription, procedure: ProcedureDescription, kind: Kind) -> dict[str, Sensor]:
    wanted = kind.measures(procedure.solve.model)
    sensors = sensors_that_measure(rig, *wanted)
    if not sensors:
        measures = ", ".join(f"{name} ({sensor.measures})" for name, sensor in rig.sensors.items())
        raise procedure.error(
            ("procedure", "kind"),
            f"{kind.name!r} with model {procedure.solve.model!r} calibrates sensors that measure "
            f'{" or ".join(wanted)}, the rig has {measures}; declare measures = "{wanted[0]}" in the rig file, or '
            "choose another kind",
        )
    return sensors
