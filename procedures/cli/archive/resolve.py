"""``calrig resolve``: solve archived runs again, thousands at once, and tell what changed."""

import os
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict
from pathlib import Path
from typing import Literal

from ams.archive.refusals import without_password
from ams.archive.runs import publish_run
from procedures.cli.archive.text import plain
from procedures.cli.locations import archive_url
from procedures.cli.options import Archive, Flag, Json
from procedures.cli.output import note, print_json, say
from procedures.delivery.resolve import Answer, Mapper, Treatment, chunks, in_this_process, jobs_of
from procedures.delivery.resolve_workers import LEAST_FITS_OF_A_TASK, chunk_size, in_processes, on_cluster
from procedures.errors import ExitStatus, RequestError
from rig.clock import SystemClock

LONGEST_LIST = 20


def resolve(
    *,
    archive: Archive = None,
    runs: Path | None = None,
    workers: int | None = None,
    dask: str | None = None,
    temperature: Literal["none", "apply", "estimate"] | None = None,
    extended: Literal["no", "test", "yes"] | None = None,
    publish: Flag = False,
    json: Json = False,
) -> int:
    """Solve every archived run again from its journal and tell what changed beyond rounding (1e-12 of the scale).

    Nothing is written unless --publish is given. Exit status 1 where a journal is missing or a run cannot be solved.

    Parameters
    ----------
    runs
        A folder of run folders, looked in where a run no longer lies where it was published from.
    workers
        Processes of this machine; by default one a processor.
    dask
        Address of a Dask scheduler to use instead: tls://HOST:PORT, or tcp://127.0.0.1:PORT.
    temperature
        Solve with another treatment of temperature than the procedure's.
    extended
        Solve with another choice of the extended model than the procedure's.
    publish
        Publish the new set of every run that changed; the old one stays.
    """
    url = archive_url(archive)
    jobs = jobs_of(url, runs, Treatment(temperature, extended), keep=publish)
    where, size = _resolved(len(jobs), workers, dask)
    answers = _answered(jobs, where, size)
    published = _publish(url, answers) if publish else 0
    _tell(without_password(url), answers, published, json=json)
    return ExitStatus.FAILED if any(answer.outcome in ("missing", "failed") for answer in answers) else ExitStatus.DONE


def _resolved(
    jobs: int, workers: int | None, dask: str | None
) -> tuple[Callable[[], AbstractContextManager[Mapper]], int]:
    """Return what solves, and how many runs it takes at once."""
    if dask is not None:
        if workers is not None:
            raise RequestError("give --workers or --dask, not both; nothing was solved")
        return lambda: on_cluster(dask), LEAST_FITS_OF_A_TASK
    count = (os.cpu_count() or 1) if workers is None else workers
    if count < 1:
        raise RequestError(f"--workers: got {count}, allowed are 1 and more; nothing was solved")
    count = min(count, jobs)
    if count < 2:
        return in_this_process, 1
    return lambda: in_processes(count), chunk_size(jobs, count)


def _answered(jobs: Sequence[object], where: Callable[[], AbstractContextManager[Mapper]], size: int) -> list[Answer]:
    answers: list[Answer] = []
    shown_tenth = 0
    with where() as mapper:
        for part in mapper(chunks(jobs, size)):  # type: ignore[arg-type]
            answers += part
            tenth = 10 * len(answers) // max(len(jobs), 1)
            if tenth > shown_tenth:
                shown_tenth = tenth
                note(f"{len(answers)}/{len(jobs)} runs")
    return sorted(answers, key=lambda answer: answer.run_id)


def _publish(url: str, answers: Sequence[Answer]) -> int:
    count = 0
    for answer in answers:
        if answer.entry is not None:
            now, usage = SystemClock().now_utc(), answer.usage_pitch_deg
            done = publish_run(url, answer.entry, answer.measured, now, usage_pitch_deg=usage)
            count += sum(publication.is_new for publication in done.publications)
    return count


def _tell(url: str, answers: Sequence[Answer], published: int, *, json: bool) -> None:
    kinds = {
        kind: [answer for answer in answers if answer.outcome == kind]
        for kind in ("same", "changed", "missing", "failed")
    }
    if json:
        changed = [
            {"run_id": answer.run_id, "changes": [asdict(change) for change in answer.changes]}
            for answer in kinds["changed"]
        ]
        hindered = {
            kind: [{"run_id": answer.run_id, "message": answer.message} for answer in kinds[kind]]
            for kind in ("missing", "failed")
        }
        counts = {"archive": url, "runs": len(answers), "same": len(kinds["same"]), "published": published}
        print_json(plain({**counts, "changed": changed, **hindered}))
        return
    listed = ", ".join(f"{len(found)} {kind}" for kind, found in kinds.items() if found or kind == "same")
    say(f"{len(answers)} runs of {url}: {listed}")
    for answer in kinds["changed"][:LONGEST_LIST]:
        say(f"{answer.run_id}: {len(answer.changes)} numbers changed, most: {_largest(answer)}")
    for answer in (*kinds["missing"], *kinds["failed"])[:LONGEST_LIST]:
        say(f"{answer.run_id}: {answer.outcome}: {answer.message}")
    if any(len(found) > LONGEST_LIST for kind, found in kinds.items() if kind != "same"):
        say(f"only the first {LONGEST_LIST} of each are listed; --json has all")
    if published:
        say(f"{published} new sets published; the old ones stay")


def _largest(answer: Answer) -> str:
    change = max(answer.changes, key=lambda moved: float("inf") if moved.of_scale is None else moved.of_scale)
    where = " ".join(part for part in (change.sensor, change.axis, change.name) if part)
    if change.old is None or change.new is None:
        return f"{where} {'is new' if change.old is None else 'is gone'}"
    of_u = "" if change.in_uncertainties is None else f", {change.in_uncertainties:.2g} standard uncertainties"
    return f"{where} {change.old:.9g} to {change.new:.9g} ({change.of_scale:.1e} of the scale{of_u})"
