"""Rejected dwells as rows of a table: each by itself, or many of one reason in one row."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from procedures.numbers import attitude
from procedures.report.view import RejectedDwell

MOST_ALIKE = 5
"""Of one reason, word for word: more were taken back together, and stand in one row."""


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
