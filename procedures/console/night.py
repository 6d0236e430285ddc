"""The night on one page: what ran since yesterday evening, what stood still and why, what a person must do first."""

import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import date, datetime, time, timedelta, tzinfo
from pathlib import Path

from ams.archive.due_list import Due, due_list
from ams.errors import ArchiveAbsent, ArchiveError
from procedures.console.watched_run import RunPage
from procedures.console.withdrawn_sets import withdrawn_sentence
from procedures.errors import ProcedureError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.sidecar.verdict_file import hindered_in, read_verdict
from procedures.journal.status.run_list import ListedRun
from procedures.journal.status.stop_advice import held_before, next_step, numbers_of, of_damage
from procedures.journal.taken_away import is_taken_away
from procedures.records.dwells import Event
from procedures.records.states import GOING, State, is_unasked, state_sentence
from rig.local_time import from_the_wall, local_day

EVENING_HOUR = 16
DUE_WITHIN_DAYS = 30
MOST_DAMAGE_NAMED = 5


@dataclass(frozen=True, slots=True)
class Stop:
    """A run stood still though nobody asked for it."""

    utc: datetime
    state: str
    why: str
    lasted_s: float | None
    """None while it lasts."""


@dataclass(frozen=True, slots=True)
class NightRun:
    """One run of the night."""

    run: ListedRun
    stops: tuple[Stop, ...]
    verdict: str
    trust: str
    to_do: str
    """What a person must do; empty where nothing."""
    item: int | None = None
    """Of a queue, which waits for what becomes of the run."""


@dataclass(frozen=True, slots=True)
class Archived:
    """What the archive tells of a night."""

    due: tuple[Due, ...]
    trouble: str
    """Why it tells nothing."""
    gone: Mapping[str, str]
    """Of each run whose set was withdrawn since, the sentence that says so."""


@dataclass(frozen=True, slots=True)
class Night:
    """The page."""

    since_utc: datetime
    runs: tuple[NightRun, ...]
    """What waits for a person first, then the newest."""
    due: tuple[Due, ...]
    trouble: str
    """Why the archive tells nothing."""


def evening_before(now_utc: datetime, zone: tzinfo | None = None) -> datetime:
    """Return when yesterday's evening began where the reader is."""
    evening = datetime.combine(local_day(now_utc, zone) - timedelta(days=1), time(EVENING_HOUR))
    return from_the_wall(evening, zone)


def archived(listed: Iterable[ListedRun], archive_url: str, now_utc: datetime) -> Archived:
    """Return what the archive tells of the night; one that tells nothing is asked no second time."""
    due, trouble = _due(archive_url, local_day(now_utc))
    if trouble:
        return Archived((), trouble, {})
    names = [run.path.name for run in _of_the_night(listed, now_utc)]
    try:
        return Archived(due, "", {name: gone for name in names if (gone := withdrawn_sentence(archive_url, name))})
    except ArchiveError as error:
        return Archived(due, str(error), {})


def night(listed: Iterable[ListedRun], known: Archived, now_utc: datetime, undecided: Mapping[Path, int]) -> Night:
    """Return what the page tells.

    Args:
        undecided: Items of queues that wait for what becomes of their run, by its folder.
    """
    runs = [
        _night_run(run, undecided.get(run.path.resolve()), known.gone.get(run.path.name, ""))
        for run in _of_the_night(listed, now_utc)
    ]
    runs.sort(key=lambda run: not run.to_do)
    return Night(evening_before(now_utc), tuple(runs), known.due, known.trouble)


def _of_the_night(listed: Iterable[ListedRun], now_utc: datetime) -> list[ListedRun]:
    since_utc = evening_before(now_utc)
    return [run for run in listed if run.is_alive or run.modified_utc >= since_utc]


def _due(archive_url: str, today: date) -> tuple[tuple[Due, ...], str]:
    try:
        found = due_list(archive_url)
    except ArchiveAbsent:
        return (), "Nothing is archived yet: what is due will stand here."
    except ArchiveError as error:
        return (), str(error)
    soon = [item for item in found if (left := item.days_left(today)) is not None and left <= DUE_WITHIN_DAYS]
    return tuple(soon), ""


def _night_run(run: ListedRun, item: int | None, gone: str) -> NightRun:
    if run.trouble or run.state is None:
        return NightRun(
            run,
            (),
            "",
            "",
            run.trouble
            if is_taken_away(run.path)
            else f"its journal cannot be read: {run.trouble}; calrig salvage {shlex.quote(str(run.path.absolute()))}",
        )
    verdict = read_verdict(run.path, run.state) or {}
    if verdict and gone:
        verdict = {**verdict, "sentence": gone, "trust": "unusable"}
    try:
        with JournalReader.open(run.path) as reader:
            states = list(reader.events("state"))
            to_do = damage_words(run) if run.damaged else _to_do(reader, run.state, states, verdict)
    except ProcedureError as error:
        return NightRun(run, (), "", "", str(error))
    return NightRun(
        run,
        tuple(_stops(states)),
        str(verdict.get("sentence", "")),
        str(verdict.get("trust", "")),
        to_do,
        item,
    )


def damage_words(run: ListedRun) -> str:
    """Say of a run whose journal is damaged that its counts are by that, and what comes of it."""
    named = ", ".join(run.damaged[:MOST_DAMAGE_NAMED])
    more = len(run.damaged) - MOST_DAMAGE_NAMED
    return (
        f"its dwells are counted by a journal that is damaged: {named}{f' and {more} more' if more > 0 else ''} not as "
        f"written; {of_damage(run.path.absolute())}"
    )


def _stops(states: list[Event]) -> Iterable[Stop]:
    for index, event in enumerate(states):
        state, by = State(str(event.detail["to"])), str(event.detail.get("by", ""))
        if not is_unasked(state, by):
            continue
        after = states[index + 1] if index + 1 < len(states) else None
        lasted_s = None if after is None else (after.utc - event.utc).total_seconds()
        yield Stop(event.utc, state, state_sentence(str(event.detail.get("reason", "")), by), lasted_s)


def _to_do(reader: JournalReader, state: State, states: Sequence[Event], verdict: Mapping[str, object]) -> str:
    """Return what a person must do; empty where a run goes on, has its result or was closed."""
    if state is State.FINISHED:
        return hindered_in(verdict)
    if state in (*GOING, State.PLANNED, State.CLOSED):
        return ""  # what a command has to name is found out of the whole journal, which a run that goes on needs not
    numbers = numbers_of(str(reader.path.parent.absolute()), reader.events(), reader.dwells(with_samples=False))
    return next_step(state, str(states[-1].detail.get("cause", "")), numbers, held_before(states))


def needs_a_person(page: RunPage) -> bool:
    """Return whether somebody must act before the run goes on."""
    return page.is_unasked_stop or page.status.state is State.PAUSED
