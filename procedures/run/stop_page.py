"""One page for every stop that nobody asked for: ``why.html`` and ``why.txt`` in the run's folder.

Cause, moment, that nothing moved since, what to do, and the last minutes of everything, out of the journal alone.
"""

import shlex
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

from ams.errors import WriteFailed
from ams.units import ARCSEC_PER_DEG
from ams.whole_file import write_whole
from procedures.errors import ProcedureError
from procedures.journal.audit.audit_trail import MadeAgain, made_again_in
from procedures.journal.journal_reader import JournalReader
from procedures.journal.sidecar.last_words import MOVED, REPLACED, STORAGE, TAKES_NOTHING
from procedures.journal.sidecar.owner import is_owned
from procedures.journal.sidecar.second_folder import make_beside
from procedures.journal.status.standing import derived_state, reason_now
from procedures.journal.status.stop_advice import StopNumbers, advice, numbers_of
from procedures.journal.storage import JOURNAL_FILE
from procedures.pages import page_environment
from procedures.records.dwells import DwellRecord, Event
from procedures.records.progress import OPENED_ANEW
from procedures.records.states import State
from procedures.run.ending import DIED, NO_RUN, PROCESS
from procedures.run.sparkline import Sparkline, sparkline
from rig.clock import SystemClock
from rig.local_time import at_both, local_clock
from rig.plain_text import one_line

UNASKED = (State.TRIPPED, State.FAILED)
"""Endings that nobody asked for; ``held`` is no ending and has its page as well."""
ENDED_BY = (*TAKES_NOTHING, PROCESS)
"""Causes of a stop that nobody asked for: of the disk and of our own process."""
PAGE, TEXT = "why.html", "why.txt"
TEMPLATES = Path(__file__).parent / "templates"
LAST = timedelta(minutes=15)
_MOST_ROWS = 40


@dataclass(frozen=True)
class Why:
    """What the page says."""

    run: str
    title: str
    state: str
    cause: str
    reason: str
    utc: datetime
    progress: str
    positions: str
    advice: str
    traces: Sequence[Sparkline]
    dwells: Sequence[DwellRecord]
    events: Sequence[tuple[datetime, str, str]]
    made_again: Sequence[MadeAgain] = ()
    """Of the whole run: what an axis did not do at once long before the stop may have to do with it."""


def explain(
    run_dir: Path,
    reason: str = "",
    positions_deg: Mapping[str, float] | None = None,
    second_folder: Path | None = None,
    cause: str = "",
    utc: datetime | None = None,
    journal_in: Path | None = None,
) -> Path | None:
    """Write both, where the disk of the run refuses them in a folder of the run's name in ``second_folder``.

    Returns the page; None where no place took it: that never keeps a run from its safe state. ``reason``, ``cause``
    and the moment ``utc``: where the journal could not take them. ``positions_deg``: read back at rest.
    ``journal_in``: the folder that holds the journal, where that of the run does not any more.
    """
    positions_deg = positions_deg or {}
    try:
        # What stands in the place of a journal that was replaced may be another run's.
        is_there = cause != REPLACED or journal_in is not None
        why = read_why(journal_in or run_dir, reason, positions_deg, cause, utc) if is_there else None
    except ProcedureError as error:
        why, reason = None, reason or str(error)
    why = why or _unread(run_dir, reason, positions_deg, cause)
    page = page_environment(TEMPLATES).get_template("why.html.j2").render(why=why, both=at_both, local=local_clock)
    for folder in (run_dir, *([] if second_folder is None else [second_folder / run_dir.name])):
        with suppress(WriteFailed, OSError):
            make_beside(folder, run_dir)
            write_whole(folder / TEXT, text_of(why).encode("utf-8"))
            write_whole(folder / PAGE, page.encode("utf-8"))
            return folder / PAGE
    return None


def _unread(run_dir: Path, reason: str, positions_deg: Mapping[str, float], cause: str) -> Why:
    """Return what can be said where the journal cannot even be read, or could not be made."""
    is_begun = (run_dir / JOURNAL_FILE).exists() or cause == REPLACED
    is_moved = not is_begun and cause == MOVED
    cause = cause if cause == REPLACED or is_moved else STORAGE if is_begun else NO_RUN
    state = "not known: the journal cannot be read" if is_begun else "not begun"
    return Why(
        run=str(run_dir),
        title=run_dir.name,
        state="not known: the folder of the run is not there" if is_moved else state,
        cause=cause,
        reason=reason,
        utc=SystemClock().now_utc(),
        progress="not known" if is_begun or is_moved else "nothing",
        positions=_positions(positions_deg),
        advice=advice(cause, State.FAILED, StopNumbers(shlex.quote(str(run_dir)))),
        traces=(),
        dwells=(),
        events=(),
    )


def read_why(
    run_dir: Path, reason: str, positions_deg: Mapping[str, float], cause: str = "", utc: datetime | None = None
) -> Why:
    """Return why a run stopped. Raises: JournalError."""
    with JournalReader.open(run_dir) as reader:
        events, state = list(reader.events()), reader.last_event("state")
        plan = reader.header.plan
        assert state is not None
        when = utc or state.utc
        since = when - LAST
        dwells = [dwell for dwell in reader.dwells() if dwell.ended_utc >= since]
        known = [] if positions_deg else _known_motion(reader)
        done = len(reader.accepted_steps() & {dwell.step for dwell in plan.design_dwells})
        cause = cause or str(state.detail.get("cause", ""))
        stands = derived_state(reader.state(), is_alive=utc is None and cause != DIED and is_owned(run_dir))
        return Why(
            run=run_dir.name,
            title=reader.header.title,
            state=stands,
            cause=cause or "unknown",
            reason=reason or reason_now(str(state.detail.get("reason", "")), _last_try(reader, state)),
            utc=when,
            progress=f"{done} of {len(plan.design_dwells)} dwells of the design",
            positions=_positions(positions_deg, known, _unknown_positions(reader, positions_deg)),
            advice=advice(cause, stands, numbers_of(str(run_dir), events, reader.dwells(with_samples=False))),
            traces=_traces(dwells),
            dwells=dwells[-_MOST_ROWS:],
            events=[(event.utc, event.kind, _in_words(event)) for event in events if event.utc >= since][-_MOST_ROWS:],
            made_again=made_again_in(events)[-_MOST_ROWS:],
        )


def _last_try(reader: JournalReader, state: Event) -> str:
    """Return what the last attempt to open lost lines found, since the state was entered."""
    tried = reader.last_event(OPENED_ANEW)
    return "" if tried is None or tried.sequence < state.sequence else str(tried.detail["failed"])


def text_of(why: Why) -> str:
    """Return the page as text for a terminal or a mail."""
    lines = [
        one_line(f"{why.title}: {why.state}"),
        f"run      {why.run}",
        f"when     {at_both(why.utc, to_the_second=True)}",
        one_line(f"cause    {why.reason}"),
        f"so far   {why.progress}",
        f"axes     {why.positions}",
        f"to do    {why.advice}",
        *(["moves made again, by the local clock:"] if why.made_again else []),
        *(one_line(f"  {local_clock(move.utc)}  {move.axis}: {move.found}") for move in why.made_again),
        "",
        "last events, by the local clock:",
        *(one_line(f"  {local_clock(utc)}  {kind:<11} {words}") for utc, kind, words in why.events),
    ]
    return "\n".join(lines) + "\n"


def _positions(positions_deg: Mapping[str, float], known: Sequence[str] = (), unknown: Sequence[str] = ()) -> str:
    """``known``: of axes that do not answer, before they were looked for in vain. ``unknown``: axes, and why."""
    if not positions_deg and known:
        return f"no axis could be read back now: {'; '.join(known)}; go and look before anything is moved"
    if not positions_deg and unknown:
        return f"not known: {'; '.join(unknown)}; go and look before anything is moved"
    if not positions_deg:
        return "not known: no axis was read back; go and look before anything is moved"
    positions = ", ".join(f"{name} at {degrees:.4f}°" for name, degrees in positions_deg.items())
    return f"at rest, read back: {'; '.join([positions, *unknown])}; nothing has been moved since"


def _unknown_positions(reader: JournalReader, positions_deg: Mapping[str, float]) -> list[str]:
    """Return of which axes the last stop of all found no position, and why; none of those that were read back since."""
    unknown = _of_last_stop(reader).get("unknown")
    missing = unknown if isinstance(unknown, dict) else {}
    return [f"{name}: {why}" for name, why in missing.items() if name not in positions_deg]


def _known_motion(reader: JournalReader) -> list[str]:
    """Return what the last stop of all axes left known of those that did not answer."""
    known = _of_last_stop(reader).get("known")
    return [str(sentence) for sentence in known] if isinstance(known, list) else []


def _of_last_stop(reader: JournalReader) -> Mapping[str, object]:
    """Return what is on record of the last stop of all axes; nothing where one may have moved since."""
    safe = reader.last_event("safe")
    since = [event.sequence for kind in ("opened", "intent") if (event := reader.last_event(kind)) is not None]
    return {} if safe is None or safe.sequence < max(since, default=0) else safe.detail


def _traces(dwells: Sequence[DwellRecord]) -> list[Sparkline]:
    if not dwells:
        return []
    minutes = [(dwell.ended_utc - dwells[-1].ended_utc).total_seconds() / 60.0 for dwell in dwells]
    channels = list(dwells[-1].readings)
    rows: list[tuple[str, str, list[float]]] = [
        (f"{name}: scatter", "µV", [1e6 * _scatter(dwell, name) for dwell in dwells]) for name in channels
    ]
    rows += [
        (name, "°C", [dwell.temperature_degc.get(name, float("nan")) for dwell in dwells])
        for name in dwells[-1].temperature_degc
    ]
    rows += [
        (f"{name}: read-back less target", "″",
         [ARCSEC_PER_DEG * (dwell.measured_deg.get(name, float("nan")) - target) for dwell in dwells
          for target in (dwell.targets_deg.get(name, float("nan")),)])
        for name in dwells[-1].targets_deg
    ]  # fmt: skip
    rows.append(("settling", "s", [dwell.settle_s for dwell in dwells]))
    return [sparkline(name, unit, minutes, values) for name, unit, values in rows]


def _scatter(dwell: DwellRecord, channel: str) -> float:
    """Return the scatter of a channel; NaN for a dwell without it: not every motion records every axis."""
    return dwell.readings[channel].standard_deviation if channel in dwell.readings else float("nan")


def _in_words(event: Event) -> str:
    detail = event.detail
    match event.kind:
        case "state":
            return f"{detail.get('to')}: {detail['reason']}" if detail.get("reason") else str(detail.get("to"))
        case "dwell":
            reasons = detail.get("reasons")
            judged = "accepted" if detail.get("accepted") else f"rejected: {_plain(reasons)}"
            return f"step {detail.get('step')}, attempt {detail.get('attempt')}: {judged}"
    return ", ".join(f"{key} {_plain(value)}" for key, value in detail.items() if value not in ("", None))[:300]


def _plain(value: object) -> str:
    """Return a value as a person reads it: tables and lists of the journal without their brackets."""
    match value:
        case bool():
            return "yes" if value else "no"
        case float():
            return f"{value:g}"
        case Mapping():
            return " ".join(f"{name} {_plain(item)}" for name, item in value.items())
        case list() | tuple():
            return ", ".join(map(_plain, value))
    return str(value)
