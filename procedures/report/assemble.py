"""From a journal's content to the view: who, what, when, with what, and what came of it.

Nothing is measured or solved here; what the journal does not say is not on the page.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import datetime

import numpy as np

from ams.calibration_result import SensorVerdict
from ams.findings import Finding, withheld
from ams.units import label_and_unit
from procedures.journal.audit.audit_trail import interruptions_in, made_again_in, missing_in, notes_in
from procedures.journal.audit.known_devices import replacements
from procedures.kinds.registry import KINDS
from procedures.records.declared_supply import at_declared, correcting
from procedures.records.dwells import measured_again
from procedures.report.conclusions import axis_view
from procedures.report.section import with_data_of_sections
from procedures.report.stability import check_comparisons, reference_traces, restart_steps, temperature_traces
from procedures.report.truth import truth_of
from procedures.report.verdict import judge
from procedures.report.view import AxisFindings, Counts, DesignView, Past, RunView, SensorView
from procedures.solution.record import RunRecord
from procedures.solution.request import SolvedSensor
from procedures.solution.run_findings import findings_beside_dwells, of_sensor
from procedures.solution.type_b import gravity_of
from rig.description.rig_file import Sensor

UNFINISHED = ("running", "checking", "planned")


def assemble_view(
    record: RunRecord,
    solved: Mapping[str, SolvedSensor],
    table_arcsec: float | None = None,
    past: Past | None = None,
    only: str | None = None,
) -> RunView:
    """Assemble the run as every screen draws it, or as the document of the sensor ``only`` does: without the others.

    ``solved``: sensor name to its solution. ``table_arcsec``: standard uncertainty of one attitude of the table.
    ``past``: what the archive says of the sensors.
    """
    findings = findings_beside_dwells(record, solved)
    sensors = _sensor_views(record, solved, past or Past(), findings, only)
    labels = _labels(record, sensors)
    dwells = sorted(record.dwells, key=lambda dwell: (dwell.epoch, dwell.started_s))
    counts = _counts(record)
    interruptions = interruptions_in(record.events)
    chains = correcting(record.rig.chain)
    declared = [at_declared(dwell, chains) for dwell in dwells]
    checks = check_comparisons(declared, labels, record.events, record.judged_visits)
    view = RunView(
        title=record.plan.title,
        run_id=record.run_id,
        state=record.state,
        operator=record.operator,
        rig=record.rig.rig.name,
        gravity=gravity_of(record.rig),
        is_simulated=record.is_simulated,
        approved_by=record.rig.approved_by,
        began_utc=record.created_utc,
        started_utc=dwells[0].started_utc if dwells else record.created_utc,
        ended_utc=_ended_utc(record),
        verdict=judge(
            record.state,
            counts,
            sensors,
            interruptions,
            restart_steps(checks),
            table_arcsec,
            findings if only is None else of_sensor(findings, only),
            record.run,
            replacements(record.tenures),
        ),
        design=_design_view(record),
        counts=counts,
        sensors=sensors,
        interruptions=interruptions,
        notes=notes_in(record.events),
        temperature=temperature_traces(dwells),
        reference=reference_traces(dwells, labels),
        checks=checks,
        missing=() if record.is_simulated else missing_in(record.events),
    )
    return with_data_of_sections(record, solved, view)


def _sensor_views(
    record: RunRecord,
    solved: Mapping[str, SolvedSensor],
    known: Past,
    findings: Sequence[Finding],
    only: str | None,
) -> tuple[SensorView, ...]:
    """Return every sensor, or ``only`` that one, with what the run as a whole and the archive say of it."""
    return tuple(
        replace(
            _as_the_run_is(_sensor_view(record, name, sensor, solved.get(name), index), findings),
            adjustment=known.adjustments.get(name),
            history=known.histories.get(name),
            signed=known.signed.get(name),
        )
        for index, (name, sensor) in enumerate(record.plan.sensors.items(), start=1)
        if only in (None, name)
    )


def _sensor_view(record: RunRecord, name: str, sensor: Sensor, solved: SolvedSensor | None, index: int) -> SensorView:
    observations = None if solved is None else solved.observations
    calibration = None if solved is None else solved.calibration
    failure = "it was not solved" if solved is None else solved.why_not_usable
    budgets = {} if solved is None else solved.budgets
    section = None if solved is None else KINDS[record.plan.kind].section(record, solved)
    axes = () if calibration is None or observations is None or section is not None else tuple(
        axis_view(
            axis, sensor.channels[axis], result, observations,  # type: ignore[index]
            truth_of(record.rig, name, axis, observations, result), budgets.get(axis),
        )
        for axis, result in calibration.axes.items()
    )  # fmt: skip
    mount = ", ".join(f"{axis} along {getattr(sensor.mount, axis)}" for axis in "xyz")
    return SensorView(
        name=name,
        model=sensor.model,
        mount=f"{mount}{f'; datum {sensor.mount.datum}' if sensor.mount.datum else ''}",
        is_check_sensor=sensor.check_sensor,
        observations=observations,
        axes=axes,
        warnings=() if calibration is None else calibration.warnings,
        remarks=() if calibration is None else calibration.remarks,
        failure=failure,
        number=index,
        findings=()
        if calibration is None
        else tuple(
            AxisFindings(
                axis,
                sensor.channels.get(axis, axis),  # type: ignore[call-overload]
                result.findings,
                label_and_unit(result.primary_names[0])[1] or "V",
            )
            for axis, result in calibration.axes.items()
        ),
        section=section,
        verdict=_verdict_of(solved, failure),
    )


def _verdict_of(solved: SolvedSensor | None, failure: str | None) -> SensorVerdict:
    """Return what is said of a sensor in one word: a rest, which solves nothing, is sound where every drift holds."""
    if solved is None or failure:
        return "not usable"
    if solved.static:
        return "sound" if all(axis.holds for axis in solved.static.values()) else "usable"
    return "not usable" if solved.calibration is None else solved.calibration.verdict


def _as_the_run_is(sensor: SensorView, findings: Sequence[Finding]) -> SensorView:
    """Return the sensor as the verdict on the run has it: where the table turned, or the record lost what may have
    taken dwells back, none of its sets is to be used.
    """
    return replace(sensor, verdict="not usable") if withheld(of_sensor(findings, sensor.name)) else sensor


def _labels(record: RunRecord, sensors: Sequence[SensorView]) -> dict[str, tuple[str, float]]:
    """Return channel to how it is called and the sensitivity that turns its volts into angles."""
    labels: dict[str, tuple[str, float]] = {}
    for view in sensors:
        sensor = record.plan.sensors[view.name]
        solved = {axis.axis: axis.sensitivity_v_per_g for axis in view.axes}
        for axis, channel in sensor.channels.items():
            labels[channel] = (f"{view.name} {axis}", solved.get(axis, abs(sensor.nominal_v_per_g(axis))))
    return labels


def _counts(record: RunRecord) -> Counts:
    accepted = [dwell for dwell in record.dwells if dwell.accepted]
    return Counts(
        planned=len(record.plan.dwells),
        accepted=len({dwell.step for dwell in accepted}),
        rejected=len(record.dwells) - len(accepted),
        rejected_and_repeated=sum(
            again and not dwell.accepted
            for dwell, again in zip(record.dwells, measured_again(record.dwells), strict=True)
        ),
        design_planned=len(record.plan.design_dwells),
        design_accepted=sum(dwell.purpose == "design" for dwell in accepted),
        moves_made_again=len(made_again_in(record.events)),
    )


def _design_view(record: RunRecord) -> DesignView:
    plan = record.plan
    first = [dwell for dwell in plan.design_dwells if dwell.replication == 1]
    angles = {
        axis: np.array([dwell.targets_deg.get(axis, 0.0) for dwell in first], dtype=float) for axis in ("pitch", "roll")
    }
    return DesignView(
        kind=plan.design.kind,
        order=plan.order,
        replications=plan.replications,
        point=np.array([dwell.point for dwell in first], dtype=np.int64),
        pitch_deg=angles["pitch"],
        roll_deg=angles["roll"],
    )


def _ended_utc(record: RunRecord) -> datetime | None:
    if record.state in UNFINISHED:
        return None
    return record.ended_utc
