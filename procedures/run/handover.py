"""The whole state of a run on one page, for whoever takes over the shift."""

import shlex
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from ams.analysis.diagnostics.take_back import void_command
from ams.finding_kinds import OF_THE_METER
from procedures.common_mode.ways_out import measured_again
from procedures.journal.audit.audit_trail import clock_words, dwells_on_one_clock, on_one_clock
from procedures.journal.audit.dropped_sensors import DroppedSensor, read_dropped
from procedures.journal.audit.known_devices import replacements, tenures_in
from procedures.journal.journal_reader import JournalReader
from procedures.journal.plan_file import changed_plan_sentence
from procedures.journal.sidecar.delivering import delivered_by
from procedures.journal.sidecar.guard_record import EVENT as GUARDED
from procedures.journal.sidecar.guard_record import guard_sentence, read_guard_record
from procedures.journal.sidecar.last_words import LastWords, read_last_words
from procedures.journal.sidecar.unwritten import unwritten_sentence
from procedures.journal.sidecar.verdict_file import grounds_in, has_earlier_verdict, hindered_in, read_verdict, rows_in
from procedures.journal.status.status import status
from procedures.journal.status.stop_advice import (
    StopNumbers,
    advice,
    held_before,
    left_in_doubt,
    next_step,
    numbers_of,
    of_damage,
)
from procedures.journal.voids import DROPPED, QUARANTINED
from procedures.records.dwells import DwellRecord, Event
from procedures.records.progress import LEASE, MADE_AGAIN, STRAY_MOTION
from procedures.records.states import ACTIVE, State, state_sentence
from procedures.run.ending import Outcome
from procedures.run.stop_page import ENDED_BY, PAGE, UNASKED
from rig.local_time import at_both
from rig.plain_text import one_line

_MOST = 8


def handover(run_dir: Path, second_folder: Path | None = None) -> str:
    """Return the text of at most a page. Raises: JournalError."""
    stands = status(run_dir)
    with JournalReader.open(run_dir) as reader:
        header, stamped = reader.header, list(reader.events())
        events = list(on_one_clock(stamped))
        dwells = list(dwells_on_one_clock(reader.dwells(with_samples=False), stamped))
        damage, left_out = reader.damage(), reader.quarantined()
        dropped = read_dropped(reader)
    last = next(event for event in reversed(events) if event.kind == "state")
    cause = str(last.detail.get("cause", ""))
    doubts, numbers = _meter_doubts(run_dir, events, dwells), numbers_of(str(run_dir), events, dwells)
    next_words = _next(run_dir, stands.state, cause, held_before(events), doubts, numbers)
    lines = [
        one_line(header.title),
        f"run        {run_dir}",
        f"state      {_standing(stands.state, last, events[-1], read_last_words(run_dir, second_folder))}",
        f"progress   {stands.dwells_done} of {stands.dwells_planned} dwells of the design"
        f"{', by a journal that is damaged' if damage.names else ''}",
        *(
            [f"ends       {at_both(stands.eta_utc)}, as it goes now"]
            if stands.eta_utc and stands.state in ACTIVE
            else []
        ),
        f"operator   {one_line(header.operator)} began it {at_both(header.created_utc)}"
        f"{', simulated' if header.is_simulated else ''}",
        f"mounting   {max((dwell.mounting for dwell in dwells), default=1)}",
        *_temperatures(dwells),
        *_rejected(dwells),
        *_accepted(run_dir, dwells),
        *[f"damaged    {what} is not as it was written" for what in damage.in_words],
        *([f"plan       {plan}"] if (plan := changed_plan_sentence(run_dir, header)) else []),
        *[f"left out   {name}" for name in left_out],
        *_listed("stops", [event for event in events if _is_stop(event)]),
        *_listed("moves made again", [event for event in events if event.kind == MADE_AGAIN]),
        *_listed("moved unasked", [event for event in events if event.kind == STRAY_MOTION]),
        *_listed("terminal", [event for event in events if event.kind == "terminal"]),
        *[one_line(f"clock      {word}") for word in clock_words(events)],
        *_listed("lease", [event for event in events if event.kind == LEASE]),
        *_guarded(run_dir, events),
        *_listed("notes", [event for event in events if event.kind == "note"]),
        *_listed("salvaged", [event for event in events if event.kind == QUARANTINED and event.detail.get("reason")]),
        *_listed("taken back", [event for event in events if event.kind == "voided"]),
        *_dropped(run_dir, events, dropped),
        *_listed("answered for", [event for event in events if event.kind == "override"]),
        *[one_line(f"device     {sentence}") for sentence in replacements(tenures_in(events, dwells, header.plan))],
        *_listed("acknowledged", [event for event in events if event.kind == "ack"]),
        "",
        f"next       {of_damage(run_dir) if damage.names else next_words}",
        *_solved(run_dir, stands.state),
    ]
    return "\n".join(lines) + "\n"


def unfinished(run_dir: Path, second_folder: Path) -> list[str]:
    """Return how a run stands that did not finish: state and cause, the page that explains it, what comes next.

    Raises: JournalError where the journal cannot be read.
    """
    state = status(run_dir).state
    with JournalReader.open(run_dir) as reader:
        stamped = list(reader.events())
        events = list(on_one_clock(stamped))
        dwells = list(dwells_on_one_clock(reader.dwells(with_samples=False), stamped))
    last = next(event for event in reversed(events) if event.kind == "state")
    before = held_before(events)
    numbers, cause = numbers_of(str(run_dir), events, dwells), str(last.detail.get("cause", ""))
    is_explained = state in (*UNASKED, State.HELD) or cause in ENDED_BY or bool(before)
    pages = [folder / PAGE for folder in (run_dir, second_folder / run_dir.name)]
    return [
        f"state      {_standing(state, last, events[-1], read_last_words(run_dir, second_folder))}",
        *[f"page       {page}" for page in pages if is_explained and page.exists()][:1],
        f"next       {_next(run_dir, state, cause, before, '', numbers)}",
    ]


def left_elsewhere(run_dir: Path, second_folder: Path, outcome: Outcome) -> list[str]:
    """Return what :func:`unfinished` does of a run whose journal is not in its folder any more."""
    pages = [folder / PAGE for folder in (run_dir, second_folder / run_dir.name)]
    to_do = advice(outcome.cause, outcome.state, StopNumbers(shlex.quote(str(outcome.copy or run_dir))))
    return [*[f"page       {page}" for page in pages if page.exists()][:1], f"next       {to_do}"]


def _standing(state: State, entered: Event, newest: Event, words: LastWords | None) -> str:
    """Say the state, since when and why; an interruption stands in no journal before the resume."""
    if state is not State.INTERRUPTED or state == entered.detail["to"]:
        return f"{state} since {at_both(entered.utc)}{_reason(entered)}"
    if words is None:
        return f"{state}, last heard of {at_both(newest.utc)}"
    return one_line(f"{state} since {at_both(words.stopped_utc)}: {words}")


def _next(run_dir: Path, state: State, cause: str, before: str, meter_doubts: str, numbers: StopNumbers) -> str:
    """Say what comes next; of a finished run by its verdict.

    ``before``: the cause of the hold that it was stopped in. ``meter_doubts``: the way out of what visits found of the
    meter; empty where nothing of it still counts.
    """
    if state is not State.FINISHED:
        return next_step(state, cause, numbers, before)
    if deliverer := delivered_by(run_dir):
        return f"wait: its results are being delivered by {deliverer}; then look at this page again"
    verdict = read_verdict(run_dir, state)
    if verdict is None:
        return f"calrig solve {numbers.run}{f'; {meter_doubts}' if meter_doubts else ''}"
    if hindered := hindered_in(verdict):
        return hindered
    solve = f"what is missing is made by calrig solve {numbers.run}"
    if meter_doubts:
        return f"it is solved, and the meter changed while it measured: {meter_doubts}; {solve}"
    if verdict.get("trust") == "sound":
        return f"nothing, it is solved; {solve}"
    if verdict.get("trust") == "unusable":
        return f"{_mended_by(verdict, numbers.run)}; {solve}"
    return f"it is solved; read the verdict and its grounds below first: each says what it leaves open; {solve}"


def _mended_by(verdict: Mapping[str, object], run: str) -> str:
    """Say of a result that is not to be used which of its grounds name the commands that mend it."""
    ways = [number for number, ground in enumerate(grounds_in(verdict), start=1) if "calrig " in ground]
    if not ways:
        return "it is solved, and not to be used as it stands: each of the grounds below says what it leaves open"
    which = f"ground{'' if len(ways) == 1 else 's'} {', '.join(map(str, ways))}"
    return (
        f"it is solved, and not to be used as it stands: leave the sensors as they are mounted; {which} below "
        f"{'names' if len(ways) == 1 else 'name'} the dwells in doubt and the command that takes them back, and "
        f"calrig resume {run} then measures them again"
    )


def _meter_doubts(run_dir: Path, events: Sequence[Event], dwells: Sequence[DwellRecord]) -> str:
    """Return how the dwells are measured again that a change of the meter left in doubt and nobody took back since."""
    doubtful = set[int]().union(*left_in_doubt(events, _is_of_meter))
    return measured_again(doubtful, dwells, shlex.quote(str(run_dir))).text if doubtful else ""


def _is_of_meter(event: Event) -> bool:
    kinds = event.detail.get("kinds")
    return isinstance(kinds, list) and not OF_THE_METER.isdisjoint(kinds)


def _solved(run_dir: Path, state: State) -> Iterable[str]:
    """Tell a finished run's verdict with its grounds and its report, where it was solved."""
    verdict = read_verdict(run_dir, state) if state is State.FINISHED else None
    if verdict is not None:
        yield one_line(f"verdict    {verdict.get('sentence', '')}")
        grounds = grounds_in(verdict)
        for number, ground in enumerate(grounds, start=1):
            if number <= _MOST or "calrig " in ground:
                yield one_line(f"  {number}. {ground}")
        if len(grounds) > _MOST:
            yield f"  ({len(grounds)} grounds; the report has all)"
        unusable = [str(row.get("sensor")) for row in rows_in(verdict) if row.get("verdict") == "not usable"]
        yield from ([one_line(f"not usable {', '.join(unusable)}")] if unusable else [])
    elif unwritten := unwritten_sentence(run_dir, state):
        yield one_line(f"results    {unwritten}")
    report = run_dir / "report.html"
    if state is State.FINISHED and report.exists() and not has_earlier_verdict(run_dir, state):
        yield f"report     {report}"
    if aside := sorted(path.name for path in run_dir.glob("superseded-*")):
        yield f"set aside  {', '.join(aside)}: made before dwells were taken back, or withdrawn; not to be used"


def _dropped(run_dir: Path, events: Iterable[Event], sensors: Iterable[DroppedSensor]) -> Iterable[str]:
    """Tell who was dropped when, and how each stands now."""
    yield from _listed("dropped", [event for event in events if event.kind == DROPPED])
    for sensor in sensors:
        yield one_line(f"  {sensor.sentence(shlex.quote(str(run_dir)))}")


def _is_stop(event: Event) -> bool:
    """Return whether the event is a stop, whoever or whatever asked for it."""
    ends = event.detail.get("to") in (State.STOPPED, State.ABORTED, State.CLOSED)
    return event.kind == "state" and bool(event.detail.get("cause") or ends)


def _reason(event: Event) -> str:
    reason = state_sentence(str(event.detail.get("reason", "")), str(event.detail.get("by", "")))
    return one_line(f": {reason}") if reason else ""


def _temperatures(dwells: Iterable[DwellRecord]) -> Iterable[str]:
    seen: dict[str, list[float]] = {}
    for dwell in dwells:
        for name, degc in dwell.temperature_degc.items():
            seen.setdefault(name, []).append(degc)
    for name, values in seen.items():
        yield f"{name:<10} {values[-1]:.2f} °C, from {min(values):.2f} to {max(values):.2f} °C so far"


def _rejected(dwells: Iterable[DwellRecord]) -> Iterable[str]:
    reasons: Counter[str] = Counter()
    for dwell in dwells:
        if not dwell.accepted and dwell.reasons:
            what, _, why = dwell.reasons[0].partition(":")
            reasons[f"{what}:{why.partition(':')[0][:40]}"] += 1
    if reasons:
        listed = "; ".join(f"{count} × {reason}" for reason, count in reasons.most_common(4))
        yield one_line(f"rejected   {sum(reasons.values())} dwells: {listed}")


def _accepted(run_dir: Path, dwells: Sequence[DwellRecord]) -> Iterable[str]:
    """Tell the newest steps that count: what ``calrig void --from`` is given."""
    counted = [dwell for dwell in dwells if dwell.accepted]
    if not counted:
        return
    take_back = void_command(counted[-1].step, shlex.quote(str(run_dir)))
    yield f"accepted ({len(counted)}), the newest last; {take_back} takes back the newest, an earlier step all after it"
    for dwell in counted[-_MOST:]:
        angles = ", ".join(f"{name} {angle_deg:g}°" for name, angle_deg in dwell.targets_deg.items())
        what = f"{dwell.purpose}, replication {dwell.replication}" if dwell.replication else dwell.purpose
        yield f"  {at_both(dwell.ended_utc)} step {dwell.step}: {what}, {angles}"


def _guarded(run_dir: Path, events: Iterable[Event]) -> Iterable[str]:
    """Tell what the stop guard did: as it is journalled, and since then."""
    documents = [event.detail for event in events if event.kind == GUARDED]
    since = read_guard_record(run_dir)
    for document in documents if since is None else [*documents, since]:
        yield one_line(guard_sentence(document))


def _listed(name: str, events: list[Event]) -> Iterable[str]:
    if not events:
        return
    yield f"{name} ({len(events)})"
    for event in events[-_MOST:]:
        text = event.detail.get("text") or event.detail.get("reason") or event.detail.get("to") or ""
        by = f" {event.detail['by']}:" if event.detail.get("by") else ""
        whom = f" {event.detail['sensor']}:" if event.detail.get("sensor") else ""
        yield one_line(f"  {at_both(event.utc)}{by}{whom} {text}")
