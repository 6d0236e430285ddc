"""What a set states of the dwells of its run that do not count: how many of how many, which, and why.

A reader who signs must see it: what is rejected and taken back is chosen after it was measured.
Source: ISO/IEC 17025:2017, 7.5.1, 7.11.3.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from ams.sets.canonical import Document, listed, number, table

MOST_ALIKE: Final = 5
"""Of one reason, word for word: more were taken back together, and stand in one line."""
MOST_LINES: Final = 20
"""Of what is printed; the set has all of them."""


@dataclass(frozen=True)
class RejectedLine:
    """Dwells that do not count, for one reason."""

    where: str
    why: str


def dwells_in_words(document: Document) -> str:
    """Return how many dwells were measured and how many of them count, as a sentence."""
    provenance = table(document["provenance"])
    stated = provenance.get("dwells")
    if stated is None:
        if provenance["run_id"] is None:
            return "The readings came from a file: what was left out before it was written is not known."
        return "The set does not state how many dwells of its run were rejected or taken back."
    known = table(stated)
    measured, rejected = int(number(known["measured"])), listed(known["rejected"])
    visits = int(number(known.get("reference_visits", 0)))
    among = f", {measured - visits} of the design and {visits} at reference attitudes" if visits else ""
    if not rejected:
        return f"All {measured} dwells that were measured count{among}; none was rejected or taken back."
    again = sum(bool(table(dwell)["measured_again"]) for dwell in rejected)
    lost, was = len(rejected), "was" if len(rejected) == 1 else "were"
    if again == lost:
        repeated = "it was measured again" if lost == 1 else "each was measured again"
    elif lost == 1:
        repeated = "it was not measured again"
    else:
        repeated = f"{again or 'none'} of them {'was' if again <= 1 else 'were'} measured again"
    counts = "does not count" if lost == 1 else "do not count"
    of = f" ({among.removeprefix(', ')})" if among else ""
    return f"Of {measured} dwells that were measured{of} {lost} {was} rejected or taken back and {counts}; {repeated}."


def rejected_lines(document: Document) -> list[RejectedLine]:
    """Return the dwells that do not count, many of one reason in one line, in the order in which they were measured."""
    stated = table(document["provenance"]).get("dwells")
    alike: dict[tuple[str, ...], list[Document]] = {}
    for dwell in () if stated is None else map(table, listed(table(stated)["rejected"])):
        alike.setdefault(tuple(map(str, listed(dwell["reasons"]))), []).append(dwell)
    lines = [line for reasons, dwells in alike.items() for line in _lines(reasons, dwells)]
    further = len(lines) - MOST_LINES
    if further > 0:
        lines = [*lines[:MOST_LINES], RejectedLine(f"{further} more", "each with its reasons in the coefficient set")]
    return lines


def _lines(reasons: tuple[str, ...], dwells: list[Document]) -> Iterator[RejectedLine]:
    why = "; ".join(reasons) or "no reason is recorded"
    if len(dwells) <= MOST_ALIKE:
        yield from (RejectedLine(_where(dwell), why) for dwell in dwells)
        return
    spans = (f"{name}{_span(dwells, name)}" for name in ("replication", "point") if _span(dwells, name))
    yield RejectedLine(f"{len(dwells)} dwells, {', '.join(spans)}".rstrip(", "), why)


def _where(dwell: Document) -> str:
    numbers = (f"{name} {dwell[name]}" for name in ("replication", "point", "attempt") if dwell[name])
    return ", ".join([str(dwell["purpose"]), *numbers])


def _span(dwells: list[Document], name: str) -> str:
    known = {int(number(dwell[name])) for dwell in dwells if dwell[name]}
    if not known:
        return ""
    return f" {min(known)}" if len(known) == 1 else f"s {min(known)} to {max(known)}"
