"""Is the calibration trustworthy: one plain sentence, and the grounds it stands on.

Three answers only. *Sound*: finished, replicated, and no test speaks against model or stability beyond what the table's
certificate explains. *Reserved*: usable with the stated uncertainties, but somebody must read the grounds. *Unusable*:
there is no solution for at least one sensor, or with its new coefficients it does not meet the limits declared, or a
finding says that the stated uncertainties do not hold what it found.
"""

from collections.abc import Iterable, Sequence

import numpy as np

from ams.arrays import FloatArray
from ams.findings import ALL_AFTER, Finding, beyond_the_stated, significant_texts, turned_the_table
from ams.rounding import two_digits
from ams.sets.verdict_conditions import verdict_conditions
from ams.surveillance.turns import FIXTURE
from procedures.journal.audit.audit_trail import Interruption, Standstill
from procedures.numbers import angle, arcsec
from procedures.records.states import ANSWERED_FOR, RESUMABLE, State, state_sentence
from procedures.report.overview import Statement, stated_once, widest_arcsec
from procedures.report.view import AxisView, Counts, SensorView, Verdict


def judge(
    state: str,
    counts: Counts,
    sensors: Sequence[SensorView],
    interruptions: Sequence[Interruption],
    restart_steps: Sequence[str],
    table_arcsec: float | None,
    findings: Sequence[Finding] = (),
    run: str = "RUN",
    replaced: Sequence[str] = (),
) -> Verdict:
    """Return the verdict on a run.

    ``restart_steps``: what a check set after a restart found changed. ``table_arcsec``: standard uncertainty of one
    attitude of the table, pitch and roll together; None where none is declared. ``findings``: of all sensors together;
    they stand among the warnings of each, and are said once. ``run``: as commands take it.
    ``replaced``: devices that gave place to others.
    """
    names = [sensor.name for sensor in sensors]
    failures = stated_once(((sensor.name, "", sensor.failure) for sensor in sensors if sensor.failure), names)
    said = significant_texts(findings)
    turned = turned_the_table((*findings, *(found for sensor in sensors for found in _findings(sensor))))
    doubts = [
        *_run_doubts(state, counts, interruptions, run),
        *(f"{text}." for text in replaced),
        *(f"{text[0].upper()}{text[1:]}." for text in said),
        *_doubts_of_sensors(sensors, said),
        *(f"A restart made a step: {step}." for step in restart_steps),
        *(doubt for sensor in sensors for doubt in _conformity_doubts(sensor)),
    ]
    beyond = [text for sensor in sensors for text in _sentences(sensor, "as left", "fail")]
    facts = [
        *_explained(sensors, table_arcsec),
        *_went_on(interruptions),
        *(*_rejected(counts), *_made_again(counts)),
        *stated_once((remark for sensor in sensors for remark in _remarks(sensor)), names),
    ]
    results = [sensor.section.result for sensor in sensors if sensor.section is not None]
    result = "; ".join(results) if results else _result([sensor for sensor in sensors if sensor.axes])
    result += verdict_conditions(_remark_texts(sensors))
    if gone := list(_withdrawn(sensors)):
        return Verdict("unusable", f"Not to be used: {'; '.join(gone)}.", (*failures, *beyond, *doubts, *facts))
    if failures:
        without = [sensor.name for sensor in sensors if sensor.failure]
        whose = "any sensor" if len(without) == len(sensors) > 1 else ", ".join(without)
        sentence = f"There is no result to use of {whose}."
        return Verdict("unusable", sentence, (*failures, *doubts, *facts))
    if beyond_the_stated(findings):
        sentence = "Not to be used as it stands: lines of the run's record are lost, and what they took back may count."
        return Verdict("unusable", sentence, (*beyond, *doubts, *facts))
    if turned:
        sentence = f"Not to be used as it stands{_turned(turned, sensors, findings)}."
        return Verdict("unusable", sentence, (*beyond, *doubts, *facts))
    if beyond:
        sentence = f"At least one sensor does not meet its limits as left. {result}."
        return Verdict("unusable", sentence, (*beyond, *doubts, *facts))
    if exceeded := [sensor.name for sensor in sensors if beyond_the_stated(_findings(sensor))]:
        whose = "" if len(sensors) == 1 else f" of {', '.join(exceeded)}"
        sentence = f"Not to be used with the stated uncertainties{whose}: they do not hold all that was found."
        return Verdict("unusable", sentence, (*doubts, *facts))
    if doubts:
        sentence = f"Usable with the stated uncertainties, with reservations. {result}."
        return Verdict("reserved", sentence, (*doubts, *facts))
    return Verdict("sound", f"The calibration is sound. {result}.", tuple(facts))


def _withdrawn(sensors: Iterable[SensorView]) -> Iterable[str]:
    """Yield whose set must not be used any more, by whose word and why."""
    for sensor in sensors:
        if sensor.signed is not None and sensor.signed.withdrawal is not None:
            yield f"the set of {sensor.name} is {sensor.signed.withdrawal}"


def _turned(turned: Sequence[Finding], sensors: Sequence[SensorView], together: Sequence[Finding]) -> str:
    """Say what turned, and of which sensors nothing is to be used where the others stand as they did.

    ``turned``: what is found of it, of sensors and of all ``together``.
    """
    table = "the table, its base or the fixture"
    if all(finding.details.get(ALL_AFTER) for finding in turned):
        return f": {table} turned away from the declared zero before what counts was measured"
    if turned_the_table(together) or any(finding.details.get("cause") != FIXTURE for finding in turned):
        return f": {table} turned while the run measured"
    askew = [sensor.name for sensor in sensors if turned_the_table(_findings(sensor))]
    whose = "" if len(askew) == len(sensors) else f" of {', '.join(askew)}"
    return f"{whose}: {', '.join(askew)} turned on the mount, or with the fixture, while the run measured"


def _findings(sensor: SensorView) -> Iterable[Finding]:
    """Return what was found of every axis, of straight lines as well."""
    return (found for axis in sensor.findings for found in axis.findings)


def _result(sensors: Sequence[SensorView]) -> str:
    """Say which axes, over which attitudes, how good; the worst axis speaks for several sensors."""
    axes = [axis for sensor in sensors for axis in sensor.axes]
    if not axes:
        return "Nothing was solved"
    error = max(arcsec(axis.calibration.standard_error_v, axis.sensitivity_v_per_g) for axis in axes)
    names = (
        f"{sensors[0].name} ({', '.join(axis.axis for axis in axes)})"
        if len(sensors) == 1
        else f"{len(sensors)} sensors"
    )
    text = f"{names}: standard error of one dwell at most {two_digits(error)}″"
    seen = [rows for sensor in sensors if sensor.axes and (rows := sensor.observations) is not None]
    if not seen:
        return text
    widest = max(widest for sensor in sensors if (widest := widest_arcsec(sensor)) is not None)
    where = f"{_span('pitch', seen[0].pitch_rad)} and {_span('roll', seen[0].roll_rad)}"
    return f"{text}; over {where} the fitted output is known to ±{two_digits(widest)}″ or better (95 %)"


def _span(name: str, angle_rad: FloatArray) -> str:
    low, high = float(np.rad2deg(angle_rad.min())), float(np.rad2deg(angle_rad.max()))
    return f"{name} {angle(low)}" if high - low < 1e-6 else f"{name} {angle(low)} to {angle(high)}"


def _run_doubts(state: str, counts: Counts, interruptions: Sequence[Interruption], run: str) -> Iterable[str]:
    if state != "finished":
        yield _unfinished(state, next((stretch for stretch in interruptions[-1:] if stretch.ended_utc is None), None))
    missing = counts.design_planned - counts.design_accepted
    if missing > 0:
        yield f"{missing} of {counts.design_planned} planned design dwells are missing{_measured_by(state, run)}."


def _measured_by(state: str, run: str) -> str:
    """Say what measures the dwells that a run lacks: solving it again, however often, does not."""
    if state in RESUMABLE:
        who = " --operator NAME --reason TEXT" if state in ANSWERED_FOR else ""
        return f": calrig resume {run}{who} measures them, and solves with them what cannot be solved without"
    return ": this run goes on no more, a new one measures them" if state in (State.FAILED, State.CLOSED) else ""


def _unfinished(state: str, stretch: Interruption | None) -> str:
    """Say in which state a run ended, since when, why and whether anything moved since; then what came before."""
    last, *earlier = (None,) if stretch is None else stretch.newest_first
    if last is None or last.what not in (state, State.HELD, State.INTERRUPTED):
        return f"The run did not finish (state “{state}”)."
    sentences = [
        f"The run did not finish (state “{state}”){_since(last)}.",
        *([last.axes] if last.axes else []),
        *(f"Before that it was {stood.what}{_since(stood)}." for stood in earlier),
    ]
    return " ".join(sentences)


def _since(stood: Standstill) -> str:
    why = state_sentence(stood.reason, stood.by)
    return f", since {stood.began_utc:%Y-%m-%d %H:%M} UTC{f': {why}' if why else ''}"


def _doubts_of_sensors(sensors: Sequence[SensorView], said: Sequence[str]) -> Iterable[str]:
    """Yield what speaks against sensors, each thing once with all of whom it is true."""
    yield from (doubt for sensor in sensors if sensor.section is not None for doubt in sensor.section.doubts)
    doubts = (doubt for sensor in sensors if sensor.section is None for doubt in _sensor_doubts(sensor, said))
    yield from stated_once(doubts, [sensor.name for sensor in sensors])


def _sensor_doubts(sensor: SensorView, said: Sequence[str]) -> Iterable[Statement]:
    """Yield every warning of a sensor and its axes, significant findings among them; a failure is told already."""
    if any(not axis.tests for axis in sensor.axes):
        yield sensor.name, "", "one replication only, so lack of fit and drift could not be tested."
    yield from (
        (sensor.name, axis.axis, text)
        for axis in sensor.axes
        for text in axis.calibration.warnings
        if text not in (sensor.failure or "") and text not in said
    )
    yield from ((sensor.name, "", warning) for warning in sensor.warnings if warning not in said)


def _remark_texts(sensors: Sequence[SensorView]) -> Iterable[str]:
    return (text for sensor in sensors for _, _, text in _remarks(sensor))


def _remarks(sensor: SensorView) -> Iterable[Statement]:
    """Yield what was asked for and what it means; nothing to hold against the result."""
    yield from ((sensor.name, "", text) for text in sensor.remarks)
    of_axes = dict.fromkeys(text for axis in sensor.axes for text in axis.calibration.remarks)  # each is said once
    yield from ((sensor.name, "", text) for text in of_axes)


def _conformity_doubts(sensor: SensorView) -> Iterable[str]:
    """Yield what the limits leave open, and what users of the sensor must be told about the time before."""
    yield from _sentences(sensor, "as left", "conditional")
    for text in _sentences(sensor, "as found", "fail"):
        yield f"{text} What was measured with it since its last calibration is affected."


def _sentences(sensor: SensorView, kind: str, verdict: str) -> Iterable[str]:
    """Yield the judgements of one kind that came out so."""
    adjustment = sensor.adjustment
    condition = adjustment and (adjustment.as_left if kind == "as left" else adjustment.as_found)
    for judgement in condition.judgements if condition else ():
        if judgement.verdict == verdict:
            yield f"{sensor.name} {kind}: {judgement.sentence}."


def _explained(sensors: Sequence[SensorView], table_arcsec: float | None) -> Iterable[str]:
    axes = [
        f"{sensor.name} {axis.axis}"
        for sensor in sensors
        for axis in sensor.axes
        if any(test.is_explained for test in axis.tests) and not _repeats(axis) and not _is_beyond(axis)
    ]
    if axes and table_arcsec is not None:
        yield (
            f"Residuals that repeat were found ({', '.join(axes)}), no larger than the table's index errors explain "
            f"(standard uncertainty {two_digits(table_arcsec)}″, pitch and roll together); they are contained in the "
            "stated uncertainties."
        )


def _repeats(axis: AxisView) -> bool:
    """Return whether the residuals repeat more than the table explains."""
    return any(finding.kind == "lack-of-fit" and finding.is_significant for finding in axis.calibration.findings)


def _is_beyond(axis: AxisView) -> bool:
    """Return whether anything was found of the axis that the stated uncertainties do not hold."""
    return bool(beyond_the_stated(axis.calibration.findings))


def _went_on(interruptions: Sequence[Interruption]) -> Iterable[str]:
    count = len(interruptions)
    if count:
        times = "once" if count == 1 else f"{count} times"
        yield f"The run was interrupted {times}; every interruption is listed below."


def _rejected(counts: Counts) -> Iterable[str]:
    if not counts.rejected:
        return
    plural, again = "dwell was" if counts.rejected == 1 else "dwells were", counts.rejected_and_repeated
    if again == counts.rejected:
        repeated = ", and measured again"
    elif again:
        repeated = f"; {again} of them {'was' if again == 1 else 'were'} measured again, {counts.rejected - again} not"
    else:
        repeated = f" and {'was' if counts.rejected == 1 else 'were'} not measured again"
    listed = "it is" if counts.rejected == 1 else "they are"
    yield f"{counts.rejected} {plural} rejected or taken back{repeated}; {listed} listed below by reason."


def _made_again(counts: Counts) -> Iterable[str]:
    if moves := counts.moves_made_again:
        was = "1 move was" if moves == 1 else f"{moves} moves were"
        yield f"{was} made again; {'it is' if moves == 1 else 'they are'} listed below with what was found."
