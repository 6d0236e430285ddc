"""Archived runs solved again: the same numbers, or what changed beyond rounding.

One job is one run: its journal, and the sets that the archive holds of it. A job is solved from the journal alone, by
this version of the software, and its primary parameters and their standard uncertainties are compared with the archived
ones: a difference counts from 1e-12 of the axis' scale (|b| + Σ|k|). Nothing is written. Jobs and answers are plain
values, so that they travel to other processes and machines.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any, Literal

from ams.archive.runs import MeasuredSensor, RunEntry, list_runs, run_primaries
from ams.errors import AmsError
from procedures.delivery.deliver import SolvedRun, primaries_of, sets_of
from procedures.delivery.number_changes import NumberChange, number_changes
from procedures.delivery.publish import measured_sensors, run_entry
from procedures.errors import ProcedureError
from procedures.journal.journal_reader import JournalReader
from procedures.kinds.solve import solve_record
from procedures.solution.record import RunRecord, read_record
from rig.errors import DescriptionError

Outcome = Literal["same", "changed", "missing", "failed"]


@dataclass(frozen=True)
class Treatment:
    """How to solve otherwise than the procedure asked; None: as it asked."""

    temperature: Literal["none", "apply", "estimate"] | None = None
    extended: Literal["no", "test", "yes"] | None = None

    def __bool__(self) -> bool:
        return self != Treatment()


@dataclass(frozen=True)
class Job:
    """One archived run."""

    run_id: str
    journal_sha256: str
    folders: tuple[str, ...]
    """Where its journal may lie; the first that is there and is the archived one counts."""
    sets: Mapping[str, str]
    """Sensor to the primary parameters of the archived set, as JSON text."""
    treatment: Treatment = Treatment()
    keep: bool = False
    """Hand back the new sets of what changed, to be published."""


@dataclass(frozen=True)
class Answer:
    """What became of one run."""

    run_id: str
    outcome: Outcome
    changes: tuple[NumberChange, ...] = ()
    message: str = ""
    entry: RunEntry | None = None
    measured: tuple[MeasuredSensor, ...] = ()
    usage_pitch_deg: tuple[float, float] | None = None


def resolve_chunk(jobs: Sequence[Job]) -> list[Answer]:
    """Solve jobs one after the other; what hinders one hinders no other."""
    return [resolve_job(job) for job in jobs]


def resolve_job(job: Job) -> Answer:
    """Solve one archived run again."""
    try:
        run = _solved(job)
        if run is None:
            return Answer(job.run_id, "missing", message=f"no journal in {' or '.join(job.folders) or 'any folder'}")
        return _compared(job, run)
    except (ProcedureError, AmsError, DescriptionError) as error:
        return Answer(job.run_id, "failed", message=str(error))


def jobs_of(
    archive_url: str, elsewhere: Path | None = None, treatment: Treatment | None = None, *, keep: bool = False
) -> list[Job]:
    """Return every run of an archive with the sets that it holds of it.

    ``elsewhere``: a folder of run folders to look in too.

    Raises: ams.errors.ArchiveError.
    """
    archived = run_primaries(archive_url)
    return [
        Job(
            run.run_id,
            run.journal_sha256,
            tuple(str(folder) for folder in _folders(run.folder, run.run_id, elsewhere)),
            archived.get(run.run_id, {}),
            treatment or Treatment(),
            keep,
        )
        for run in list_runs(archive_url)
    ]


def chunks(jobs: Sequence[Job], size: int) -> list[Sequence[Job]]:
    """Split the jobs, in order, into chunks of at most ``size``."""
    iterator = iter(jobs)
    return list(iter(lambda: list(islice(iterator, size)), []))


def _solved(job: Job) -> SolvedRun | None:
    for folder in map(Path, job.folders):
        if not (folder / "journal.sqlite").exists():
            continue
        with JournalReader.open(folder) as reader:
            found = reader.sha256_of_content()
            if found == job.journal_sha256:
                return _solve(folder, read_record(reader), job.treatment)
        raise ProcedureError(
            f"{folder}: the journal is not the archived one: its content is {found[:12]}, the archive has "
            f"{job.journal_sha256[:12]}; it was not solved; publish the run again if it was written to since"
        )
    return None


def _solve(folder: Path, record: RunRecord, treatment: Treatment) -> SolvedRun:
    wanted = {name: value for name, value in vars(treatment).items() if value is not None}
    if wanted:
        record = replace(record, plan=replace(record.plan, solve=record.plan.solve.model_copy(update=wanted)))
    return SolvedRun(folder, record, solve_record(record))


def _compared(job: Job, run: SolvedRun) -> Answer:
    primaries = primaries_of(run)
    changes = [
        change
        for sensor, text in job.sets.items()
        for change in _of_sensor(sensor, json.loads(text), primaries.get(sensor))
    ]
    changes += [
        NumberChange(sensor, "", "sensor", None, 1.0, None, None) for sensor in primaries if sensor not in job.sets
    ]
    if run.failures:
        return Answer(job.run_id, "failed", tuple(changes), "; ".join(run.failures))
    if not changes:
        return Answer(job.run_id, "same")
    if not job.keep:
        return Answer(job.run_id, "changed", tuple(changes))
    measured = measured_sensors(run.record, run.sensors, sets_of(run))
    entry = run_entry(run.folder, run.record)
    return Answer(job.run_id, "changed", tuple(changes), "", entry, tuple(measured), run.record.plan.usage_pitch_deg)


def _of_sensor(sensor: str, old: Mapping[str, Any], new: Mapping[str, Any] | None) -> Iterable[NumberChange]:
    if new is None:
        return [NumberChange(sensor, "", "sensor", 1.0, None, None, None)]
    return number_changes(sensor, old, new)


def _folders(folder: str, run_id: str, elsewhere: Path | None) -> Iterator[Path]:
    if folder:
        yield Path(folder)
    if elsewhere is not None:
        yield elsewhere / run_id


Mapper = Callable[[Sequence[Sequence[Job]]], Iterator[list[Answer]]]
"""Chunks of jobs to their answers, in any order, as they come."""


@contextmanager
def in_this_process() -> Iterator[Mapper]:
    """Yield a mapper that solves in this process: for one worker and for tests."""
    yield lambda parts: (resolve_chunk(part) for part in parts)
