"""What a person should do next, by the cause of a stop: on ``why.html``, in handover, web pages and messages.md."""

import shlex
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from ams.analysis.diagnostics.take_back import redo_command, void_command, ways_back, ways_in_words
from procedures.journal.voids import KIND as VOIDED
from procedures.journal.voids import keys_in
from procedures.records.dwells import DwellRecord, Event, measured_design
from procedures.records.progress import COMMON_MODE
from procedures.records.states import ACTIVE, ANSWERED_FOR, State

_NEVER_BEGUN: Final = "no run"
_SIGNED: Final = "--operator NAME --reason TEXT"
"""What a person alone can say; refused as it stands here."""

ADVICE: Mapping[str, str] = {
    "link": (
        "Check plug, cable, adapter and power of the device named above. The run tries again by itself, at "
        "least once a minute; when every device answers, it homes, measures the check set and goes on. Only "
        "stop or abort end that."
    ),
    "standstill": (
        "The run has ended, and not every axis could be seen to stand. Go and look at the machine: where "
        "something moves, press its stop button. Then mend the line or device named above (plug, cable, "
        "adapter, power) and {resume_signed}: it homes, measures the check set and goes on with the first "
        "missing dwell."
    ),
    "order in doubt": (
        "The run has ended and every axis was seen to stand, but no machine answered the order that is named above: it "
        "may still come. A stop that went out behind it settles that only where line and controller keep the order of "
        "what they are told: a terminal server, a converter or a bus need not, nor need a controller that takes stops "
        "first. Before hands go in, press the stop button or switch the drive off, then switch off and on what lies on "
        "the line, which empties it. Then {resume_signed}: what moves when the lines are opened is stopped and told, "
        "every axis is homed, and the run goes on with the first missing dwell."
    ),
    "home": "An axis lost its home, as after a power cut of its controller. The run homes and goes on by itself.",
    "suspend": (
        "The computer slept. Forbid it (docs/service.md). The run opens its lines anew, homes and goes on by itself."
    ),
    "interlock": (
        "The value named above left its band. A hold goes on by itself when it is back; what was measured "
        "meanwhile is taken back and measured again. A trip: remove the cause, then {resume_signed}. Where "
        "the band itself is wrong: first correct the key that is named above in the rig file; resume with "
        "--accept-changes takes bands of [interlocks] over, everything else needs a new run."
    ),
    "disk": "Free space on the disk of the run. It goes on by itself when there is room.",
    "storage": (
        "The disk refused the journal; everything committed before is intact. Repair or free it, then "
        "{resume}; where the journal itself is damaged, calrig salvage {run} first."
    ),
    "moved": (
        "Somebody moved, renamed or removed the folder of the run while it went on. Put it back where it was, or find "
        "where it is now; then {resume}, with its new path where it has one. Where it was removed, its dwells are in "
        "the copy that the cause names: calrig resume COPY. calrig ack {run} ends the alarm, by the name that the run "
        "had."
    ),
    "replaced": (
        "A file of the journal was removed, replaced or written to while the run went on, by a person or by a program "
        "that synchronises, restores or cleans: find out by which, and keep it from the folders of runs. The cause "
        "names the copy that was made of every dwell that was finished; {resume_signed}, with the path of that copy, "
        "goes on there. Leave the old folder as it is until then."
    ),
    "no run": (
        "The disk took no journal, so there is no run yet, and nothing moved. Make room or repair it, then "
        "begin the run again."
    ),
    "process died": (
        "The process of the run was killed, ran out of memory or open files, or was frozen and ended; its stop guard "
        "told every axis to stop. Find out what ended it and see that the axes stand, then {resume}."
    ),
    "link quality": "Look at cable, earth and adapter of the line named above, then {go_on}.",
    "noise": "Look for vibration, a loose cable, a failing sensor or meter, then {go_on}.",
    "suspect dwell": "See why the dwell was rejected, then {go_on}: it is measured again.",
    "motion": (
        "Something moved an axis that should rest. See who or what, see that the package still sits as it "
        "did, then {resume_signed}{if_moved}"
    ),
    "supervision": (
        "An axis left the way that it was sent, or who would stop it is gone. See who or what moved it, "
        "whether the line or the stop guard was meddled with, and that nothing was wound up or hit; then "
        "{resume_signed}."
    ),
    "device": (
        "A device reports a fault: limit switch, stop button, coupling, drive. Clear it at the machine, then "
        "{resume_signed}; releasing a button alone starts nothing."
    ),
    "broken line": (
        "A line broke while an axis turned or moved, and its stop did not reach it then. See that every axis stands; "
        "check plug, cable, adapter and power of the device named above, and what else talks on its line; then "
        "{resume_signed}."
    ),
    "chamber": (
        "The chamber is not at work as calrig told it; where its air is heading stands above. Go to its panel first: "
        "stop it, or set it back, where package or rig do not bear that. Where somebody set it, ask who and why; "
        "where it tells an alarm, clear the cause; where a set point was not taken, look at its line. Then "
        "{resume_signed}: the set point is written and read back anew, and the plateau soaked."
    ),
    "rig file": (
        "A device is set up otherwise than the rig file says; the key stands above in brackets. A resume "
        "before that is put right stops here again. Where the device is wrong: set it, then {resume_signed}. "
        "Where the file is wrong: correct that key, let calrig check and calrig prove pass, and begin a new "
        "run: this one keeps the file that it began with."
    ),
    "slip": (
        "The sensors say that an axis stands elsewhere than its read-back. The run homes, measures the check "
        "set and goes on; where homing does not help, the seam test trips. Look at coupling and encoder."
    ),
    "channels": (
        "Channels carry one another's readings: look at scanner, connectors and wiring, put them right, then "
        "{resume_signed}; the dwells in doubt were taken back and are measured again."
    ),
    "meter": (
        "The meter reads its short or its reference beyond the limit of the rig file; what was measured since "
        "its last good proof is taken back. Look at meter, scanner and reference; then {go_on}: it is read "
        "again at once. Where the limit itself is wrong: correct the key that is named above in the rig file "
        "and begin a new run."
    ),
    "process": "This process grew too far and ended the run in time: {resume} goes on; send its folder.",
    "identity": (
        "Another device answers than this run's, or a meter with other inputs selected: swapped cables, a replaced "
        "device, a key pressed at the meter. Put it right, then "
        "{resume_signed}. Where what answers now shall measure from here on: {take_over}: record, verdict and "
        "certificate tell which dwells each measured."
    ),
    "seam": (
        "The check set differs from the one before: look at what is named above. If the table turned, put it "
        "right first: dwells measured after a turn stand off the declared zero. {resume_signed} accepts the "
        "step, or goes on as before it where the rig stands again as it did then{if_moved}"
    ),
    "table": (
        "All sensors turned together: look at the table's coupling, its base and the common fixture. To "
        "measure the dwells in doubt again put it right, {stop}{take_back}; then {resume}. {go_on} keeps them, "
        "and the report says so. What is measured again on a table that has slipped and was not put right "
        "stands off its declared zero: such sets are not to be used."
    ),
    "mount": (
        "Package, wiring and rig file contradict each other as told. Correct it; a changed file needs a new run."
    ),
}
"""In braces: commands of a run, as its state takes them."""
OTHERWISE: Final = "Read the cause above; calrig handover {run} shows the whole state, {go_on} goes on where it can."

_ENDED: Final = (
    "Read the cause above; calrig handover {run} shows the whole state. This run has ended, and what it measured is "
    "kept; begin a new one."
)


@dataclass(frozen=True)
class StopNumbers:
    """What a command has to name of a stopped run."""

    run: str
    """As a shell takes it: its folder or its name."""
    newest: int | str | None = None
    """Step of the dwell that was accepted last; None where none was."""
    ways_back: str = ""
    """Commands that take back the dwells in doubt by what held the run, with what each takes back; empty: none is."""


IN_GENERAL: Final = StopNumbers("RUN", "STEP", f"{void_command('STEP', 'RUN')} (or {redo_command('N', 'RUN')})")
"""For a page that is of no run."""


def numbers_of(run: str, events: Iterable[Event], dwells: Iterable[DwellRecord]) -> StopNumbers:
    """Return the numbers of a run from its journal; ``run``: its folder, or its name among the runs."""
    accepted = [dwell for dwell in dwells if dwell.accepted]
    *_, doubtful = set[int](), *left_in_doubt(events, lambda event: bool(event.detail.get("held")))
    return StopNumbers(
        shlex.quote(run),
        max(accepted, key=lambda dwell: (dwell.epoch, dwell.ended_s)).step if accepted else None,
        ways_in_words(ways_back(doubtful, measured_design(accepted), shlex.quote(run))),
    )


def left_in_doubt(events: Iterable[Event], is_meant: Callable[[Event], bool]) -> list[set[int]]:
    """Return the steps that each visit which is meant left in doubt, without those that were taken back since."""
    found: list[set[int]] = []
    for event in events:
        steps = event.detail.get("doubtful")
        if event.kind == COMMON_MODE and isinstance(steps, list) and is_meant(event):
            found.append(set(steps))
        elif event.kind == VOIDED:
            taken_back = {step for step, _, _ in keys_in(event)}
            found = [left - taken_back for left in found]
    return found


def held_before(events: Iterable[Event]) -> str:
    """Return the cause of the hold that the last state ended, which has to be settled first; empty where none was."""
    states = [event for event in events if event.kind == "state"]
    before = states[-2] if len(states) > 1 else None
    return str(before.detail.get("cause", "")) if before and before.detail.get("to") == State.HELD else ""


def next_step(state: State, cause: str, numbers: StopNumbers, before: str = "") -> str:
    """Return what a person does next of a run in any state but finished, where its verdict says it.

    ``before``: the cause of the hold that a person stopped the run in; empty where it was none.
    """
    run = numbers.run
    if state in (State.HELD, State.TRIPPED):
        return advice(cause, state, numbers)
    if state in ANSWERED_FOR:
        return f"calrig resume {run} {_SIGNED}; calrig close {run} --reason TEXT ends it"
    if state is State.PAUSED:
        return f"it waits: calrig continue {run}"
    if state in ACTIVE:
        return f"nothing; calrig status {run} shows how far it is, calrig stop {run} ends it after the dwell"
    if state in (State.STOPPED, State.INTERRUPTED):
        if before:
            return f"it was held before. {advice(before, state, numbers)}"
        return f"calrig resume {run}; calrig close {run} --reason TEXT ends it"
    return "this run has ended; read the cause, and begin a new one"


def of_damage(run_dir: Path) -> str:
    """Say what becomes of a run of which something is damaged."""
    salvage = f"calrig salvage {shlex.quote(str(run_dir))} takes the rest into a new folder"
    return f"calrig solve and calrig resume refuse the run; {salvage}, where a resume measures again what is missing"


def advice_of(run: str) -> Callable[[str, State], str]:
    """Return what :func:`advice` says of a run by cause and state, where nobody reads its journal first."""
    numbers = StopNumbers(shlex.quote(run))
    return lambda cause, state: advice(cause, state, numbers)


def advice(cause: str, state: State, numbers: StopNumbers) -> str:
    """Return what to do next of a run that stands in ``state`` for ``cause``, with whole commands.

    A run that a person stopped in a hold, or that was interrupted in it, takes neither a stop nor a continue.
    """
    run, is_held = numbers.run, state is State.HELD
    signed = f"calrig resume {run} {_SIGNED}"
    resume = signed if state is State.TRIPPED else f"calrig resume {run}"
    has_ended = state in (State.FAILED, State.CLOSED) and cause not in ADVICE
    text = ADVICE.get(cause, _ENDED if has_ended else OTHERWISE).format(
        run=run,
        resume=resume,
        resume_signed=signed,
        take_over=f"{signed} --accept-changes",
        go_on=f"calrig continue {run}" if is_held else resume,
        stop=f"calrig stop {run}, then " if is_held else "",
        take_back=_take_back(numbers),
        if_moved=_if_moved(numbers),
    )
    is_whole = is_held or has_ended or cause == _NEVER_BEGUN or "calrig resume" in text
    return text if is_whole else f"{text} {resume}"


def _take_back(numbers: StopNumbers) -> str:
    otherwise = f"take back what was measured since (calrig handover {numbers.run} lists the steps)"
    return numbers.ways_back or otherwise


def _if_moved(numbers: StopNumbers) -> str:
    if numbers.newest is None:
        return "."
    return f"; if the package was moved, first {void_command(numbers.newest, numbers.run)} --remounted."
