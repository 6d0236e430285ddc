"""Histories out of the archive: a sensor's calibrations among those of its kind.

A history reads the sensor's own calibrations and as many of others as its scatter is learned from, however large the
archive is. Only where something is found are all of the kind read: whose characteristics these are, and what the
witnesses of the same run say, is known by them alone.

A calibration that was withdrawn is told beside the charts, with what it had found: it is in no mean, in no limit and in
no scatter, and before no other.

What all sensors of a run changed alike is the meter's, is told as such, and is in nothing that a sensor is judged by.
Where the rig has a permanent check sensor, what it says of a run stands beside what a sensor is found to have done.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime

from sqlalchemy import ColumnElement, Connection, and_, not_, select, true

from ams.archive.approvals import is_withdrawn, withdrawals
from ams.archive.connection import reading
from ams.archive.quarantines import Quarantined, is_quarantined, quarantined_of
from ams.archive.sets import BUSY_TIMEOUT_S, stored_document
from ams.archive.tables import POINTS, SETS, in_code_points
from ams.errors import ArchiveError, ArchiveUnknown, SetError
from ams.sets.canonical import table
from ams.sets.stated_verdict import Withdrawal
from ams.surveillance.adjustment import acceptance_of
from ams.surveillance.between_runs import LEARNED_FROM, names_behind
from ams.surveillance.check_chart import CheckHistory, check_history, check_sensors, unexplained_changes
from ams.surveillance.control_chart import History, history_of
from ams.surveillance.history_points import unpack
from ams.surveillance.interval_advice import IntervalAdvice, cautious_interval
from ams.surveillance.series import PointLabel, Population
from ams.surveillance.shared_changes import SharedChange, shared_changes, without_shared
from ams.surveillance.stated_changes import stated_change, stated_families, stated_scatter


@dataclass(frozen=True)
class WithdrawnCalibration:
    """A calibration that must not be used: beside the charts, and no point of them."""

    sha256: str
    created_utc: datetime
    withdrawal: Withdrawal
    value: Mapping[str, float] = field(default_factory=dict)
    """What it had found, by the name and in the unit of a chart; empty where it was of other axes."""


@dataclass(frozen=True)
class SensorHistory:
    """Everything that the archive tells of one sensor over the years."""

    history: History
    check: CheckHistory | None
    """Where the sensor is itself a check sensor."""
    limit_deg: float | None
    """Largest error allowed, from its latest set."""
    advice: IntervalAdvice | None
    """None without a limit, or with one calibration."""
    in_quarantine: tuple[Quarantined, ...] = ()
    """Its calibrations in quarantine, which are no points of the charts, the earliest first."""
    withdrawn: tuple[WithdrawnCalibration, ...] = ()
    """Its calibrations that were withdrawn, which are no points of the charts either, the earliest first."""
    shared: tuple[SharedChange, ...] = ()
    """What sensors of its runs changed alike, the earliest first: in its values, in nothing that it is judged by."""

    @property
    def not_its_doing(self) -> tuple[str, ...]:
        """Sentences on what sensors of its runs changed alike, but those that a check sensor's findings say."""
        said = () if self.check is None else {finding.sentence for finding in self.check.findings}
        return tuple(change.sentence for change in self.shared if change.sentence not in said)


def history(
    archive_url: str, sensor: str, busy_timeout_s: float = BUSY_TIMEOUT_S, until_utc: datetime | None = None
) -> SensorHistory:
    """Return the control charts of a sensor, what was found, and advice on its interval.

    ``until_utc``: as the archive knew it after the calibrations made up to then, that moment included.

    Raises: ArchiveError; ArchiveUnknown where the sensor is not in the archive.
    """
    population = population_of(archive_url, sensor, busy_timeout_s, until_utc, only_needed=True)
    _require_points(population, sensor)
    if not population.numbers.sensitivity.all():
        raise ArchiveError(
            f"archive: sensor {sensor!r}: its sets have an equation of their own, without a direction of sensitivity; "
            "nothing of them is charted over the years"
        )
    shared = shared_changes(population)
    found, check = _of(population, sensor, shared)
    if found.findings or (check is not None and check.findings):
        population = population_of(archive_url, sensor, busy_timeout_s, until_utc)
        shared = shared_changes(population)
        found, check = _of(population, sensor, shared)
        found = with_rig_causes(without_shared(population, shared), found)
    with reading(archive_url, busy_timeout_s) as connection:
        held = quarantined_of(connection, sensor, until_utc)
        gone = _withdrawn_of(connection, population, sensor, until_utc)
        found = _with_stated(connection, without_shared(population, shared), found)
        check = _check_with_stated(connection, check)
        provenance = table(stored_document(connection, found.labels[-1].sha256)["provenance"])
    limits = acceptance_of(provenance).limits_deg
    limit = min(limits.values(), default=None)
    return SensorHistory(
        found,
        check,
        limit,
        None if limit is None else cautious_interval(population, found, shared, limit),
        held,
        gone,
        _of_its_runs(shared, found),
    )


def _of_its_runs(shared: Sequence[SharedChange], found: History) -> tuple[SharedChange, ...]:
    """Return what changed on a rig between the first and last calibration of a sensor there, unless it stayed apart."""
    kept = []
    for change in shared:
        times = [label.created_utc for label in found.labels if label.rig == change.rig]
        if found.sensor not in change.apart and times and min(times) < change.since_utc <= max(times):
            kept.append(change)
    return tuple(kept)


def _with_stated(connection: Connection, population: Population, found: History) -> History:
    """Return the history with what its newest calibration changed beyond what its sets state, while few tell more.

    Degrees of freedom are no part of a point: the sets themselves are read, of a few calibrations.
    """
    if not found.rests_on_few:
        return found
    try:
        stated = [stated_scatter(stored_document(connection, label.sha256), label.sensor) for label in found.labels]
    except SetError as error:
        unknown = f"whether the newest calibration changed beyond what the sets state is not known: {error}"
        return replace(found, unexplained=unknown)
    change = stated_change(population, found.sensor, stated)
    return replace(found, unexplained=change.sentence, explained_deg=change.explained_deg)


def _check_with_stated(connection: Connection, check: CheckHistory | None) -> CheckHistory | None:
    """Return the check sensor's chart with what its sets do not explain of the latest run, while few runs tell more."""
    if check is None or not check.rests_on_few:
        return check
    try:
        stated = [stated_families(stored_document(connection, label.sha256), check.sensor) for label in check.labels]
    except SetError as error:
        return replace(
            check, unexplained=(f"whether anything changed beyond what the sets state is not known: {error}",)
        )
    return replace(check, unexplained=unexplained_changes(check, stated))


def _require_points(population: Population, sensor: str) -> None:
    """Check that anything is charted of a sensor. Raises: ArchiveUnknown."""
    rows = population.rows_of(sensor)
    if rows.start == rows.stop:
        raise ArchiveUnknown(
            f"archive: sensor {sensor!r}: no calibration of it counts: all are withdrawn, in quarantine or later than "
            f"was asked for; nothing is charted; calrig archive list --sensor {sensor} names them"
        )


def _withdrawn_of(
    connection: Connection, population: Population, sensor: str, until_utc: datetime | None
) -> tuple[WithdrawnCalibration, ...]:
    """Return the withdrawn calibrations of a sensor; their values per the g of its latest one that counts."""
    query = select(SETS.c.sha256, SETS.c.created_utc).where(SETS.c.sensor == sensor, is_withdrawn(SETS.c.sha256))
    found = [
        WithdrawnCalibration(sha256, created_utc, withdrawals(connection, sha256)[sha256])
        for sha256, created_utc in connection.execute(query.order_by(SETS.c.created_utc, SETS.c.sha256)).all()
        if until_utc is None or created_utc <= until_utc
    ]
    numbers, first = population.numbers, population.rows_of(sensor)
    is_simulated = connection.execute(
        select(SETS.c.simulated).where(SETS.c.sha256 == population.labels[first.start].sha256)
    ).scalar_one()
    kind = _Kind(",".join(numbers.axes), numbers.sensitivity_name, bool(is_simulated))
    rows = _rows(connection, kind, [sensor], is_withdrawn(SETS.c.sha256))
    beside = _rows(connection, kind, [sensor])
    value = _values_beside(kind, rows, sorted(_known(beside, until_utc), key=lambda row: row[3]))
    return tuple(replace(entry, value=value.get(entry.sha256, {})) for entry in found)


def _values_beside(kind: "_Kind", rows: Sequence["_Row"], counted: Sequence["_Row"]) -> dict[str, dict[str, float]]:
    """Return the characteristics of withdrawn calibrations by checksum; the latest that counts stands last."""
    every = [*rows, *counted]
    packed = unpack(kind.axes.split(","), [row[-1] for row in every], kind.sensitivity_name)
    found = Population([PointLabel(*row[:-1]) for row in every], packed).characteristics
    return {
        row[0]: dict(zip(found.names, values.tolist(), strict=True))
        for row, values in zip(rows, found.value, strict=False)
    }


def _of(population: Population, sensor: str, shared: Sequence[SharedChange]) -> tuple[History, CheckHistory | None]:
    found = history_of(without_shared(population, shared), sensor)
    return found, check_history(population, sensor, shared) if found.labels[-1].is_check else None


def with_rig_causes(population: Population, found: History) -> History:
    """Return the findings of a sensor, each with what the check sensors of its rig say of the same run."""
    rigs = {finding.at.rig for finding in found.findings}
    watchers = [name for rig in sorted(rigs) for name in check_sensors(population, rig) if name != found.sensor]
    sentences: dict[str | None, str] = {}
    for name in watchers:
        for finding in check_history(population, name).findings:
            if finding.cause in ("table", "meter") and finding.at.run_id is not None:
                sentences.setdefault(finding.at.run_id, finding.sentence)
    findings = tuple(replace(finding, rig_cause=sentences.get(finding.at.run_id)) for finding in found.findings)
    return replace(found, findings=findings)


def population_of(
    archive_url: str,
    sensor: str,
    busy_timeout_s: float = BUSY_TIMEOUT_S,
    until_utc: datetime | None = None,
    *,
    only_needed: bool = False,
) -> Population:
    """Return all calibrations of the sensor's kind (same axes, same unit).

    Of several solutions of a run the one that was published last counts. Simulated calibrations count only for a sensor
    that was never measured. Sets in quarantine and sets that were withdrawn are left out.

    ``only_needed``: the sensor's own and those of others that
    :func:`ams.surveillance.between_runs.pooled_scatter` learns from.

    Raises: ArchiveError; ArchiveUnknown where the sensor is not in the archive.
    """
    with reading(archive_url, busy_timeout_s) as connection:
        both = SETS.join(POINTS, SETS.c.sha256 == POINTS.c.sha256)
        query = (
            select(POINTS.c.axes, POINTS.c.sensitivity_name, SETS.c.simulated)
            .select_from(both)
            .where(SETS.c.sensor == sensor)
            .order_by(SETS.c.simulated, SETS.c.created_utc.desc())
            .limit(1)
        )
        found = connection.execute(query).first()
        if found is None:
            raise ArchiveUnknown(f"archive: sensor {sensor!r}: has no set here; calrig archive list tells the names")
        kind = _Kind(str(found.axes), str(found.sensitivity_name), bool(found.simulated))
        if only_needed:
            kept = _needed(connection, sensor, kind, until_utc)
        else:
            kept = _known(_rows(connection, kind, None), until_utc)
        kept.sort(key=lambda row: (row[1], row[3], row[0]))
        labels = [PointLabel(*row[:-1]) for row in kept]
        return Population(labels, unpack(kind.axes.split(","), [row[-1] for row in kept], kind.sensitivity_name))


_Row = tuple[str, str, str | None, datetime, str, bool, float, bytes]
"""The fields of a label and the packed numbers."""
_NAMES_AT_ONCE = 500
_MOST_BESIDE = 32
"""Of the sensors that went through a run with a sensor, so many are asked what they changed alike."""


@dataclass(frozen=True)
class _Kind:
    """What a calibration must share with a sensor's to be compared with it."""

    axes: str
    sensitivity_name: str
    is_simulated: bool


def _needed(connection: Connection, sensor: str, kind: _Kind, until_utc: datetime | None) -> list[_Row]:
    """Return the calibrations of the sensor, and of those behind it by name until there are enough."""
    found = _known(_rows(connection, kind, [sensor]), until_utc)
    runs = {run_id for _, _, run_id, *_ in found if run_id is not None}
    last, others = sensor, 0
    while others < LEARNED_FROM:
        batch = _names_behind(connection, sensor, last, LEARNED_FROM - others)[:_NAMES_AT_ONCE]
        if not batch:
            return found
        batch_rows = _known(_rows(connection, kind, batch), until_utc)
        last, others = batch[-1], others + sum(not is_check for *_, is_check, _, _ in batch_rows)
        found += batch_rows
    beside = {name for _, name, run_id, *_ in found if run_id in runs and name != sensor}
    missing = _beside(connection, sensor, last, max(_MOST_BESIDE - len(beside), 0))
    return found + _known(_rows(connection, kind, missing), until_utc)


def _behind(connection: Connection, names: ColumnElement[str], sensor: str, last: str) -> list[ColumnElement[bool]]:
    """Return where the names behind the last one are, going round to the sensor: one stretch after the other."""
    name = in_code_points(connection, names)
    return [name > last, name < sensor] if last >= sensor else [and_(name > last, name < sensor)]


def _names_behind(connection: Connection, sensor: str, last: str, sets: int) -> list[str]:
    """Return the names of so many sets, in the order of their names behind the last one, going round to the sensor."""
    found: list[str] = []
    order = in_code_points(connection, SETS.c.sensor)
    for stretch in _behind(connection, SETS.c.sensor, sensor, last):
        query = select(SETS.c.sensor).where(stretch).order_by(order).limit(sets - len(found))
        found += connection.execute(query).scalars()
    return list(dict.fromkeys(found))


def _beside(connection: Connection, sensor: str, last: str, most: int) -> list[str]:
    """Return sensors that went through a run with a sensor: the first behind the last name, of each run so many."""
    runs = select(SETS.c.run_id).where(SETS.c.sensor == sensor, SETS.c.run_id.is_not(None)).distinct().subquery()
    other = SETS.alias()
    order, found = in_code_points(connection, other.c.sensor), set[str]()
    for stretch in _behind(connection, other.c.sensor, sensor, last):
        near = select(other.c.sha256).where(other.c.run_id == runs.c.run_id, stretch).order_by(order).limit(most)
        query = select(SETS.c.sensor).select_from(runs.join(SETS, SETS.c.sha256.in_(near.correlate(runs))))
        found.update(connection.execute(query.distinct()).scalars())
    return names_behind(found, last)[:most]


def _known(rows: Sequence[_Row], until_utc: datetime | None) -> list[_Row]:
    """Return the rows up to a moment, of each run of a sensor the one that was published last."""
    known = [row for row in rows if until_utc is None or row[3] <= until_utc]
    return list({(sensor, run_id or sha256): row for row in known for sha256, sensor, run_id in (row[:3],)}.values())


def _standing() -> ColumnElement[bool]:
    """Return the condition that nobody withdrew a set, and that it is in no quarantine."""
    return and_(not_(is_quarantined(SETS.c.sha256)), not_(is_withdrawn(SETS.c.sha256)))


def _rows(
    connection: Connection, kind: _Kind, sensors: Sequence[str] | None, which: ColumnElement[bool] | None = None
) -> list[_Row]:
    """Return the calibrations of a kind, of the named sensors or of all, in the order in which they were published.

    ``which``: None: those that stand.
    """
    columns = (SETS.c.sha256, SETS.c.sensor, SETS.c.run_id, SETS.c.created_utc, POINTS.c.rig, POINTS.c.check_sensor,
               POINTS.c.gravity_mps2, POINTS.c.numbers)  # fmt: skip
    both = SETS.join(POINTS, SETS.c.sha256 == POINTS.c.sha256)
    query = (
        select(*columns)
        .select_from(both)
        .where(POINTS.c.axes == kind.axes, POINTS.c.sensitivity_name == kind.sensitivity_name)
        .where(SETS.c.simulated == kind.is_simulated)
        .where(true() if sensors is None else SETS.c.sensor.in_(sensors))
        .where(_standing() if which is None else which)
        .order_by(SETS.c.published_utc, SETS.c.sha256)
    )
    return [tuple(row) for row in connection.execute(query)]
