"""A key of a file changed in a small job, and what is seen of it.

Most keys need no word: the job that has their table is found, and the value is changed by its form. Where that would
be refused for another reason, or would need a partner, a :class:`Trial` says how; one line a key.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import zip_longest
from pathlib import Path
from typing import Any, Literal
from zlib import crc32

import pytest
from file_keys import Document, changed, is_a_value, other_value, paths_of, value_at
from key_jobs import jobs, merged
from observed_job import Job, stages
from pydantic.fields import FieldInfo

File = Literal["rig", "procedure"]
REMOVED = object()
"""In place of a value: the key is taken away."""


@dataclass(frozen=True)
class Trial:
    """How a key is changed so that something must be seen of it."""

    value: Any = None
    """What it becomes; None: another value of its form."""
    job: str | None = None
    """A name of :func:`key_jobs.jobs`; None: the first that has the key, else the first that has its table."""
    rig: Document = field(default_factory=dict)
    procedure: Document = field(default_factory=dict)
    """What else the key needs, in the job before the change and after it."""
    faults: Mapping[str, Mapping[str, object]] | None = None
    files: Mapping[str, str] = field(default_factory=dict)
    at: str = ""
    """A name in the path, where the key stands in several places."""


def marks_of(key: str) -> tuple[pytest.MarkDecorator, ...]:
    """Return the mark of eleven keys in twelve, which CI tries; what every change tries is always the same twelfth."""
    return () if crc32(key.encode()) % 12 == 0 else (pytest.mark.thorough,)


def what_a_change_does(file: File, key: str, form: FieldInfo, trial: Trial, folder: Path) -> str | None:
    """Return the first stage at which the change is seen; None: the key is dead."""
    name, job, path = _job_with(file, key, trial)
    document = job.rig if file == "rig" else job.procedure
    before = value_at(document, path)
    after = other_value(form, before) if trial.value is None else trial.value
    assert after is not None, f"{key}: no other value can be made up; give it a Trial"
    assert after != before, f"{key}: {after!r} is what stands there"
    assert after is REMOVED or is_a_value(form, after), (
        f"{key}: {after!r} is refused for its own form, which shows nothing; give another"
    )
    now = replace(job, **{file: changed(document, path, None if after is REMOVED else after)})
    plain = trial == Trial(trial.value, trial.job, at=trial.at)
    then = _as_it_is(name, folder.parent) if plain else _read_lazily(job, folder / "before")
    seen: dict[str, str] = {}
    after_it = stages(now, folder / "after", lambda: seen.get("wire", ""))
    return next(((new or old)[0] for old, new in zip_longest(_noted(then, seen), after_it) if old != new), None)


def _noted(expected: Iterable[tuple[str, str]], seen: dict[str, str]) -> Iterator[tuple[str, str]]:
    for stage, text in expected:
        seen[stage] = text
        yield stage, text


def _job_with(file: File, key: str, trial: Trial) -> tuple[str, Job, tuple[str, ...]]:
    found: list[tuple[bool, str, Job, tuple[str, ...]]] = []
    for name, plain in jobs().items():
        if trial.job not in (None, name):
            continue
        job = Job(
            merged(plain.rig, trial.rig),
            merged(plain.procedure, trial.procedure),
            plain.faults if trial.faults is None else trial.faults,
            trial.files,
        )
        document = job.rig if file == "rig" else job.procedure
        found += [
            (value_at(document, path) is None, name, job, path)
            for path in paths_of(document, key)
            if not trial.at or trial.at in path
        ]
    assert found, f"{key}: no job has its table; give it one in key_jobs or a Trial that adds it"
    _, name, job, path = min(found, key=lambda entry: entry[0])
    return name, job, path


def _read_lazily(job: Job, folder: Path) -> Iterator[tuple[str, str]]:
    return _sound(stages(job, folder))


@cache
def _as_it_is(name: str, folder: Path) -> tuple[tuple[str, str], ...]:
    """Done once for all keys of a job."""
    return tuple(_sound(stages(jobs()[name], folder / f"as-it-is-{name}")))


def _sound(expected: Iterator[tuple[str, str]]) -> Iterator[tuple[str, str]]:
    for stage, text in expected:
        assert stage != "refusal", f"the job itself is refused before anything is changed: {text}"
        yield stage, text
