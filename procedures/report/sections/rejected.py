"""The dwells that were not believed, and the moves that were made again, with their reasons.

Each dwell by itself, or many of one reason in one row.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime

from procedures.journal.audit.audit_trail import MadeAgain, made_again_in
from procedures.numbers import attitude
from procedures.records.dwells import DwellRecord
from procedures.report.section import Section, SectionSource, fragment_beside

MOST_ALIKE = 5
"""Of one reason, word for word: more were taken back together, and stand in one row."""


@dataclass(frozen=True)
class RejectedDwell:
    """A dwell that was judged and not used."""

    utc: datetime
    step: int
    purpose: str
    replication: int
    point: int
    attempt: int
    targets_deg: Mapping[str, float]
    reasons: tuple[str, ...]


@dataclass(frozen=True)
class RejectedRow:
    """One row; of several dwells from the first to the last."""

    dwells: tuple[RejectedDwell, ...]
    steps: str
    purpose: str
    replication: str
    point: str
    attempt: str
    attitude: str
    reason: str


@dataclass(frozen=True)
class NotBelieved:
    """What the section brings."""

    dwells: tuple[RejectedDwell, ...]
    made_again: tuple[MadeAgain, ...]
    """Moves that did not end at the first attempt."""

    @property
    def rows(self) -> list[RejectedRow]:
        return rejected_rows(self.dwells)


def rejected_rows(rejected: Sequence[RejectedDwell]) -> list[RejectedRow]:
    """Return the rows, in the order in which each reason was first given."""
    alike: dict[tuple[str, ...], list[RejectedDwell]] = {}
    for dwell in rejected:
        alike.setdefault(dwell.reasons, []).append(dwell)
    groups = [group for group in alike.values() if len(group) > MOST_ALIKE]
    several = {id(dwell) for group in groups for dwell in group}
    rows = [_row((dwell,)) for dwell in rejected if id(dwell) not in several]
    rows += [_row(tuple(group)) for group in groups]
    return sorted(rows, key=lambda row: row.dwells[0].utc)


def _row(dwells: tuple[RejectedDwell, ...]) -> RejectedRow:
    is_single = len(dwells) == 1
    first = dwells[0]
    return RejectedRow(
        dwells,
        _span(dwell.step for dwell in dwells),
        ", ".join(dict.fromkeys(dwell.purpose for dwell in dwells)),
        _span(dwell.replication for dwell in dwells),
        _span(dwell.point for dwell in dwells),
        _span(dwell.attempt for dwell in dwells),
        attitude(first.targets_deg) if is_single else f"{len(dwells)} dwells",
        "; ".join(first.reasons),
    )


def _span(numbers: Iterable[int]) -> str:
    """Return from the least to the largest; zeros are none."""
    known = sorted({number for number in numbers if number})
    if not known:
        return "—"
    return f"{known[0]}" if len(known) == 1 else f"{known[0]} to {known[-1]}"


def _rejected(dwell: DwellRecord) -> RejectedDwell:
    return RejectedDwell(
        utc=dwell.started_utc,
        step=dwell.step,
        purpose=dwell.purpose,
        replication=dwell.replication,
        point=dwell.point,
        attempt=dwell.attempt,
        targets_deg=dwell.targets_deg,
        reasons=dwell.reasons,
    )


def not_believed(source: SectionSource) -> NotBelieved:
    """Return the dwells of a run that do not count, in the order of time, and its moves that were made again."""
    dwells = sorted(source.record.dwells, key=lambda dwell: (dwell.epoch, dwell.started_s))
    rejected = tuple(_rejected(dwell) for dwell in dwells if not dwell.accepted)
    return NotBelieved(rejected, made_again_in(source.record.events))


SECTION = Section(
    "rejected",
    500,
    fragment_beside(__file__),
    lambda _view: {"rejected": "Rejected dwells"},
    data=not_believed,
)
