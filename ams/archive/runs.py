"""A run published: the run, the standards behind it, its sets, and of every sensor what was found and left.

One transaction, told in one go: all of it is in the archive or nothing. What was found is worked out inside the
transaction, against the latest set that the archive then holds of that sensor, so that two publishers never disagree.
Publishing the same run again changes nothing and hands back what is there.

A standard whose due date was past when the run ended is refused, unless somebody overrides it by name and with a
reason; both go into the record. Simulated runs rest on no standard, so nothing of theirs expires.
"""

import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import date, datetime
from typing import Any

from sqlalchemy import Connection, literal, select

from ams.archive.approvals import withdrawals
from ams.archive.connection import reading, writing
from ams.archive.exchanges import exchanges_of
from ams.archive.ledger import ROWS_AT_ONCE, Written, write
from ams.archive.quarantines import is_quarantined, quarantine
from ams.archive.run_at_fault import run_at_fault
from ams.archive.set_before import set_before
from ams.archive.sets import BUSY_TIMEOUT_S, Publication, find_set, insert_sets, require_publishable, stored_set
from ams.archive.tables import ADJUSTMENTS, RUNS, SETS, STANDARDS, STANDARDS_USED, USES
from ams.errors import ArchiveError, ArchiveForbids, OutsideValidity
from ams.findings import Finding, significant_facts, withheld
from ams.observations import Observations
from ams.sets.canonical import Document, canonical_bytes, listed, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.stated_verdict import no_conformity
from ams.surveillance.adjustment import (
    Adjustment,
    acceptance_of,
    adjust,
    from_document,
    to_document,
    without_conformity,
)
from ams.surveillance.reference_attitude import ReferenceAttitude


@dataclass(frozen=True)
class RunEntry:
    """A run as the archive keeps it."""

    journal_sha256: str
    """Of the journal's content: what identifies the run."""
    run_id: str
    title: str
    rig: str
    operator: str
    simulated: bool
    started_utc: datetime
    ended_utc: datetime
    folder: str
    """Where it lay when it was published."""
    software_version: str


@dataclass(frozen=True)
class MeasuredSensor:
    """One sensor of a run: its set, and the rows that the set was solved from."""

    coefficients: CoefficientSet
    observations: Observations
    is_check: bool = False
    """A permanent check sensor."""
    findings: tuple[Finding, ...] = ()
    """Of the run as a whole, as far as they concern this sensor."""
    reference: ReferenceAttitude | None = None
    """What the attitudes of the rows are wrong by, where it is declared."""


@dataclass(frozen=True)
class Override:
    """Who answers for an expired standard, and why."""

    by: str
    reason: str


@dataclass(frozen=True)
class StandardUse:
    """A standard as a run used it."""

    name: str
    serial: str
    certificate: str
    due: date | None
    uncertainty: Mapping[str, object]

    @property
    def key(self) -> tuple[str, str]:
        return self.serial, self.certificate

    def is_expired(self, on: date) -> bool:
        return self.due is not None and self.due < on


@dataclass(frozen=True)
class PublishedRun:
    """What the archive holds of a run, whether it was new or not."""

    publications: tuple[Publication, ...]
    adjustments: Mapping[str, Adjustment]
    """Sensor to as found and as left; a sensor whose angles the set does not tell (gyros) is missing."""


def publish_run(
    archive_url: str,
    run: RunEntry,
    sensors: Sequence[MeasuredSensor],
    published_utc: datetime,
    *,
    usage_pitch_deg: tuple[float, float] | None = None,
    override: Override | None = None,
    lineage: Collection[str] = (),
    supersede: Override | None = None,
    busy_timeout_s: float = BUSY_TIMEOUT_S,
) -> PublishedRun:
    """Put a run, its sets and its adjustments into the archive, all or nothing.

    ``usage_pitch_deg``: where the sensors will be used; limits what is judged. ``lineage``: contents that this journal
    had when it was published before, as before a replication was taken back. ``supersede``: who answers for it that
    this journal takes the place of another one of the same run.

    Raises: ArchiveError where the archive cannot be written or a standard has expired; ArchiveForbids where the
    archive has this run with another journal, as of a copy that went its own way; VectorsDisagree for a set that
    contradicts itself.
    """
    sets = [sensor.coefficients for sensor in sensors]
    require_publishable(sets, published_utc)
    standards = standards_of(sets)
    expired = (
        [] if run.simulated else [standard for standard in standards if standard.is_expired(_local_day(run.ended_utc))]
    )
    _check_override(run, expired, override)
    _require_name(run, supersede)
    with writing(archive_url, busy_timeout_s) as connection:
        strangers = _strangers(connection, run, lineage)
        if strangers and supersede is None:
            raise _refusal_of_a_copy(run, strangers)
        words = {standard.key: override for standard in expired if override}
        _insert_run(connection, run, published_utc, standards, words, _supersession(strangers, supersede))
        checks = {sensor.coefficients.sensor: sensor.is_check for sensor in sensors}
        publications = insert_sets(connection, sets, published_utc, checks)
        before = {made.sensor: set_before(connection, made) for made in sets}
        exchanges = exchanges_of(connection, sets, before)
        mixed = {name: found.sentence for name, found in exchanges.items() if not found.is_of_before}
        adjustments: dict[str, Adjustment] = {}
        for sensor in sensors:
            made, swap = sensor.coefficients, mixed.get(sensor.coefficients.sensor)
            if reasons := [*significant_facts(withheld(sensor.findings)), *([] if swap is None else [swap])]:
                quarantine(connection, [made.sha256], "; ".join(reasons), published_utc)
            adjusted = _adjusted(connection, sensor, before[made.sensor], published_utc, usage_pitch_deg, swap)
            if adjusted is not None:
                adjustments[made.sensor] = adjusted
    back = {name: found.sentence for name, found in exchanges.items() if found.is_of_before}
    published = tuple(
        replace(entry, exchanged=mixed.get(entry.sensor, ""), exchanged_before=back.get(entry.sensor, ""))
        for entry in publications
    )
    return PublishedRun(published, adjustments)


def adjustment_of(archive_url: str, key: str, busy_timeout_s: float = BUSY_TIMEOUT_S) -> Adjustment | None:
    """Return as found and as left of a set (a sensor's latest, or by checksum); None where the archive holds none.

    Raises: ArchiveError.
    """
    with reading(archive_url, busy_timeout_s) as connection:
        return _stored_adjustment(connection, find_set(connection, key))


def list_runs(archive_url: str, busy_timeout_s: float = BUSY_TIMEOUT_S) -> tuple[RunEntry, ...]:
    """Return every run, oldest first. Raises: ArchiveError."""
    columns = [RUNS.c[name] for name in RunEntry.__dataclass_fields__]
    with reading(archive_url, busy_timeout_s) as connection:
        rows = connection.execute(select(*columns).order_by(RUNS.c.started_utc, RUNS.c.journal_sha256)).all()
    return tuple(RunEntry(*tuple(row)) for row in rows)


def run_primaries(archive_url: str, busy_timeout_s: float = BUSY_TIMEOUT_S) -> dict[str, dict[str, str]]:
    """Run to sensor to the primary parameters of its set, ``{"axes": {"x": {"primary": …}}}`` as JSON text.

    Of several solutions of a run the last published counts. Documents are read a few at a time: an archive of ten
    thousand does not have to fit into memory.

    Raises: ArchiveError.
    """
    columns = (SETS.c.run_id, SETS.c.sensor, SETS.c.document)
    query = select(*columns).where(SETS.c.run_id.is_not(None)).order_by(SETS.c.published_utc, SETS.c.sha256)
    found: dict[str, dict[str, str]] = {}
    with reading(archive_url, busy_timeout_s) as connection:
        for run_id, sensor, text in connection.execution_options(yield_per=ROWS_AT_ONCE).execute(query):
            axes = {name: {"primary": axis["primary"]} for name, axis in json.loads(text)["axes"].items()}
            found.setdefault(run_id, {})[sensor] = json.dumps({"axes": axes})
    return found


def standards_used(
    archive_url: str, journal_sha256: str, busy_timeout_s: float = BUSY_TIMEOUT_S
) -> tuple[tuple[StandardUse, Override | None], ...]:
    """Return the standards behind a run, an overridden one with who answers for it. Raises: ArchiveError."""
    query = select(STANDARDS, USES.c.overridden_by, USES.c.override_reason).select_from(STANDARDS_USED)
    wanted = query.where(USES.c.journal_sha256 == journal_sha256).order_by(STANDARDS.c.name)
    with reading(archive_url, busy_timeout_s) as connection:
        rows = connection.execute(wanted).mappings().all()
    return tuple(
        (
            StandardUse(
                row["name"], row["serial"], row["certificate"], row["due"], json.loads(row["uncertainty"])
            ),
            None if row["overridden_by"] is None else Override(row["overridden_by"], row["override_reason"]),
        )
        for row in rows
    )  # fmt: skip


def standards_of(sets: Sequence[CoefficientSet]) -> tuple[StandardUse, ...]:
    """Return every standard that the sets name, each certificate once."""
    found: dict[tuple[str, str], StandardUse] = {}
    for coefficients in sets:
        for entry in map(table, listed(coefficients.provenance["standards"])):
            serial, certificate, due = (entry[name] for name in ("serial", "certificate", "due"))
            use = StandardUse(
                name=str(entry["name"]),
                serial=str(serial or ""),
                certificate=str(certificate or ""),
                due=None if due is None else date.fromisoformat(str(due)),
                uncertainty=table(entry["uncertainty"] or {}),
            )
            found.setdefault(use.key, use)
    return tuple(found.values())


def _local_day(moment_utc: datetime) -> date:
    """Return the day on a calendar at the wall: a certificate's due day is such a day, and holds to its end."""
    return moment_utc.astimezone().date()


def _check_override(run: RunEntry, expired: Sequence[StandardUse], override: Override | None) -> None:
    if expired and override is None:
        overdue = ", ".join(
            f"{standard.name} ({standard.certificate or 'no certificate'}, due {standard.due})" for standard in expired
        )
        raise ArchiveError(
            f"run {run.run_id}: standards expired before the run ended on {_local_day(run.ended_utc)}: {overdue}; "
            "nothing was published; have them calibrated and measure again, or answer for it: calrig archive publish "
            "RUN --override REASON --operator NAME"
        )
    _require_name(run, override)


def _require_name(run: RunEntry, override: Override | None) -> None:
    if override is not None and not (override.by.strip() and override.reason.strip()):
        raise ArchiveError(
            f"run {run.run_id}: an override needs a name and a reason: got {override.by!r} and {override.reason!r}; "
            "nothing was published"
        )


def _insert_run(
    connection: Connection,
    run: RunEntry,
    published_utc: datetime,
    standards: Sequence[StandardUse],
    overridden: Mapping[tuple[str, str], Override],
    supersession: Document,
) -> None:
    if _has(connection, RUNS.c.journal_sha256 == run.journal_sha256):
        return
    new = [
        standard
        for standard in standards
        if not _has(connection, STANDARDS.c.serial == standard.serial, STANDARDS.c.certificate == standard.certificate)
    ]
    uses = [_use_row(run, standard, overridden.get(standard.key)) for standard in standards]
    written = [
        Written(RUNS, [{**vars(run), "published_utc": published_utc}]),
        Written(STANDARDS, [_standard_row(standard) for standard in new]),
        Written(USES, uses),
    ]
    overrides: Document = {
        standard.name: {"by": word.by, "reason": word.reason}
        for standard in standards
        if (word := overridden.get(standard.key)) is not None
    }
    remarks = ({"overrides": overrides} if overrides else {}) | supersession
    write(connection, published_utc, "run", written, remarks)


def _strangers(connection: Connection, run: RunEntry, lineage: Collection[str]) -> list[str]:
    """Return the journals of this run in the archive that are neither this one nor what it once was."""
    if _has(connection, RUNS.c.journal_sha256 == run.journal_sha256):
        return []
    found = connection.execute(select(RUNS.c.journal_sha256).where(RUNS.c.run_id == run.run_id)).scalars()
    return sorted(set(found) - set(lineage))


def _refusal_of_a_copy(run: RunEntry, strangers: Sequence[str]) -> ArchiveForbids:
    return ArchiveForbids(
        f"run {run.run_id}: the archive has it with another journal "
        f"({', '.join(stranger[:12] for stranger in strangers)}), and this one ({run.journal_sha256[:12]}) did not "
        "grow out of it: a copy of the run folder went its own way; nothing was published; keep one of the two, or "
        "answer for this one: calrig archive publish RUN --supersede REASON --operator NAME"
    )


def _supersession(strangers: Sequence[str], word: Override | None) -> Document:
    if not strangers or word is None:
        return {}
    return {"supersedes": {"journals": list(strangers), "by": word.by, "reason": word.reason}}


def _has(connection: Connection, *conditions: Any) -> bool:
    return connection.execute(select(literal(1)).where(*conditions).limit(1)).first() is not None


def _standard_row(standard: StandardUse) -> dict[str, Any]:
    text = canonical_bytes(dict(standard.uncertainty)).decode("utf-8")  # type: ignore[arg-type]
    return {**vars(standard), "uncertainty": text}


def _use_row(run: RunEntry, standard: StandardUse, override: Override | None) -> dict[str, Any]:
    return {
        "journal_sha256": run.journal_sha256,
        "serial": standard.serial,
        "certificate": standard.certificate,
        "overridden_by": None if override is None else override.by,
        "override_reason": None if override is None else override.reason,
    }


def _adjusted(
    connection: Connection,
    sensor: MeasuredSensor,
    before: CoefficientSet | None,
    published_utc: datetime,
    usage_pitch_deg: tuple[float, float] | None,
    swap: str | None,
) -> Adjustment | None:
    """Return the adjustment that is stored already, else find and store it.

    ``before``: the sensor's latest set from an earlier calibration. ``swap``: that it looks exchanged with another.
    """
    new = sensor.coefficients
    stored = _stored_adjustment(connection, new.sha256)
    if stored is not None:
        return stored
    at_fault = run_at_fault(new, sensor.findings) or swap
    is_held = bool(withheld(sensor.findings)) or swap is not None
    previous = None if at_fault else before
    acceptance = acceptance_of(new.provenance)
    try:
        found = adjust(
            previous, new, sensor.observations, acceptance, usage_pitch_deg, at_fault, sensor.reference,
            is_in_quarantine=is_held,
        )  # fmt: skip
    except OutsideValidity:
        return None
    row = {
        "sha256": new.sha256,
        "previous_sha256": None if previous is None else previous.sha256,
        "as_found": None if found.as_found is None else found.as_found.verdict,
        "as_left": found.as_left.verdict,
        "as_found_error_deg": None if found.as_found is None else found.as_found.largest_error_deg,
        "as_left_error_deg": found.as_left.largest_error_deg,
        "document": canonical_bytes(to_document(found)).decode("utf-8"),
    }
    write(connection, published_utc, "adjustment", [Written(ADJUSTMENTS, [row])], {})
    return found


def _stored_adjustment(connection: Connection, sha256: str) -> Adjustment | None:
    text = connection.execute(select(ADJUSTMENTS.c.document).where(ADJUSTMENTS.c.sha256 == sha256)).scalar()
    if text is None:
        return None
    is_held = (
        connection.execute(select(SETS.c.sha256).where(SETS.c.sha256 == sha256, is_quarantined(SETS.c.sha256))).first()
        is not None
    )
    stored = stored_set(connection, sha256)
    why = no_conformity(stored.verdict, is_in_quarantine=is_held, is_withdrawn=stored.withdrawal is not None)
    found = without_conformity(from_document(json.loads(text), acceptance_of(stored.provenance)), why)
    if found.as_found is None:
        return found
    if stored.withdrawal is not None:
        return replace(found, as_found=None, no_as_found="not judged, the set of this run is withdrawn")
    previous = found.as_found.set_sha256
    return replace(found, withdrawn_since=withdrawals(connection, previous).get(previous))
