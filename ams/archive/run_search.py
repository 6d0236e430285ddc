"""Runs by any word that is known of them, and what was measured with a standard."""

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from sqlalchemy import ColumnElement, Connection, String, and_, cast, func, or_, select

from ams.archive.connection import reading
from ams.archive.runs import RunEntry
from ams.archive.sets import BUSY_TIMEOUT_S
from ams.archive.tables import RUNS, SETS, STANDARDS, STANDARDS_USED, USES
from ams.errors import ArchiveUnknown

RUNS_AT_ONCE = 200
"""Runs whose documents one query reads."""
_PROVENANCE = re.compile(r'"provenance":\s*')
_FIELDS = ("run_id", "title", "rig", "operator", "folder", "software_version", "journal_sha256")


@dataclass(frozen=True, slots=True)
class FoundRun:
    """A run with the sensors that it measured and the standards that it used."""

    run: RunEntry
    sensors: tuple[str, ...]
    standards: tuple[str, ...]
    """Serial numbers."""


def search_runs(
    archive_url: str,
    words: Sequence[str],
    standard: str | None = None,
    busy_timeout_s: float = BUSY_TIMEOUT_S,
) -> tuple[FoundRun, ...]:
    """Return the runs of which every word is known, the newest first.

    A word is looked for, in any case, in what stands of the run, of its sensors and standards, and in every text that
    the rig file declared (customer, order and every other field). No word: every run. ``standard``: only what was
    measured with the standard of this serial number, exactly: what is recalled when it was wrong.

    Raises: ArchiveError; ArchiveUnknown where the archive has no such standard.
    """
    columns = [RUNS.c[name] for name in RunEntry.__dataclass_fields__]
    wanted = [_may_know(word) for word in words if word.isascii()]  # what a database calls the same letter differs
    with reading(archive_url, busy_timeout_s) as connection:
        if standard is not None:
            _require_standard(connection, standard)
            with_it = and_(USES.c.journal_sha256 == RUNS.c.journal_sha256, USES.c.serial == standard)
            wanted.append(select(USES.c.serial).where(with_it).exists())
        query = select(*columns).where(*wanted).order_by(RUNS.c.started_utc.desc(), RUNS.c.journal_sha256)
        runs = [RunEntry(*tuple(row)) for row in connection.execute(query)]
        measured = _by_key(connection.execute(select(SETS.c.run_id, SETS.c.sensor).order_by(SETS.c.sensor)))
        used = _by_key(connection.execute(select(USES.c.journal_sha256, USES.c.serial).order_by(USES.c.serial)))
        found = [FoundRun(run, measured.get(run.run_id, ()), used.get(run.journal_sha256, ())) for run in runs]
        return tuple(_known(connection, found, [word.casefold() for word in words]))


def _require_standard(connection: Connection, serial: str) -> None:
    """Refuse a serial number that no run was measured with: an empty recall list would be believed."""
    known = sorted(set(connection.execute(select(STANDARDS.c.serial)).scalars()))
    if serial not in known:
        raise ArchiveUnknown(
            f"standard: got serial number {serial!r}, which stands behind no run of the archive; nothing was searched; "
            f"it has {', '.join(known) or 'no standard'}"
        )


def _known(connection: Connection, found: Sequence[FoundRun], words: Sequence[str]) -> Iterator[FoundRun]:
    """Yield the runs of which every word stands in a text: the database also finds it in a name or a number."""
    of_standards = select(USES.c.journal_sha256, STANDARDS.c.name, STANDARDS.c.serial, STANDARDS.c.certificate)
    standards = _texts(connection.execute(of_standards.select_from(STANDARDS_USED)))
    serials = _texts(connection.execute(select(SETS.c.run_id, SETS.c.sensor, SETS.c.serial)))
    texts = {
        item.run.journal_sha256: [
            *(str(getattr(item.run, name)).casefold() for name in (*_FIELDS, "started_utc", "ended_utc")),
            *standards.get(item.run.journal_sha256, ()),
            *serials.get(item.run.run_id, ()),
        ]
        for item in found
    }

    def lacks(item: FoundRun) -> bool:
        return not all(any(word in text for text in texts[item.run.journal_sha256]) for word in words)

    for start in range(0, len(found), RUNS_AT_ONCE):
        part = found[start : start + RUNS_AT_ONCE]
        declared = _declared(connection, [item.run.run_id for item in part if lacks(item)])
        for item in part:
            texts[item.run.journal_sha256] += declared.get(item.run.run_id, ())
            if not lacks(item):
                yield item


def _declared(connection: Connection, run_ids: Sequence[str]) -> Mapping[str, Sequence[str]]:
    """Return every text in the provenance of the sets of some runs; nothing else of a document is taken apart."""
    query = select(SETS.c.run_id, SETS.c.document).where(SETS.c.run_id.in_(run_ids))
    found: dict[str, list[str]] = {}
    for run_id, document in connection.execution_options(yield_per=RUNS_AT_ONCE).execute(query) if run_ids else ():
        if key := _PROVENANCE.search(document):
            provenance, _ = json.JSONDecoder().raw_decode(document, key.end())
            found.setdefault(run_id, []).extend(text.casefold() for text in _leaves(provenance))
    return found


def _leaves(value: object) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for inner in value.values():
            yield from _leaves(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from _leaves(inner)


def _texts(rows: Iterable[Sequence[str | None]]) -> Mapping[str, Sequence[str]]:
    found: dict[str, list[str]] = {}
    for key, *texts in rows:
        found.setdefault(str(key), []).extend(text.casefold() for text in texts if text)
    return found


def _may_know(word: str) -> ColumnElement[bool]:
    """Return the condition that something of a run holds the word, wherever in a document: never too narrow."""
    of_run = [_holds(RUNS.c[name], word) for name in _FIELDS]
    of_run += [_holds(cast(RUNS.c[name], String), word) for name in ("started_utc", "ended_utc")]
    written = json.dumps(word)[1:-1]  # as it stands inside a document where letters are escaped
    document = or_(_holds(SETS.c.document, word), _holds(SETS.c.document, written))
    of_sets = select(SETS.c.sha256).where(
        SETS.c.run_id == RUNS.c.run_id, or_(_holds(SETS.c.sensor, word), _holds(SETS.c.serial, word), document)
    )
    of_standards = (
        select(USES.c.serial)
        .select_from(STANDARDS_USED)
        .where(
            USES.c.journal_sha256 == RUNS.c.journal_sha256,
            or_(*(_holds(STANDARDS.c[name], word) for name in ("name", "serial", "certificate"))),
        )
    )
    return or_(*of_run, of_sets.exists(), of_standards.exists())


def _holds(column: ColumnElement[str], word: str) -> ColumnElement[bool]:
    return func.lower(column).contains(word.lower(), autoescape=True)


def _by_key(rows: Iterator[tuple[str, str]]) -> Mapping[str, tuple[str, ...]]:
    found: dict[str, dict[str, None]] = {}
    for key, value in rows:
        found.setdefault(key, {})[value] = None
    return {key: tuple(values) for key, values in found.items()}
