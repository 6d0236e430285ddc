"""What happened on every line, for the record: kept every hundred dwells, before lines are opened anew, at the end."""

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

from procedures.records.dwells import Event
from procedures.records.progress import OPENED_ANEW
from procedures.records.states import State
from rig.link.counts import ExchangeCounts

KIND = "links"
_LOST: Final = re.compile(r"link lost: (?P<line>[^\s:]+)")
"""How the reason of a hold begins whose line was lost."""


@dataclass(frozen=True, slots=True)
class LineFigures:
    """Of one line, or of one device of several on it."""

    questions: int
    errors: int
    """Questions without a good answer, whether they were asked again or not."""
    stale_bytes: int
    """That nobody had asked for."""
    lost: int = 0
    """How often the run was held because the line was lost: a port that is gone gives no answer, not a bad one."""

    def in_words(self) -> str:
        """Describe the figures in one phrase."""
        rate = f" ({self.errors / self.questions:.2%})" if self.errors and self.questions else ""
        stale = f", {self.stale_bytes} bytes nobody asked for" if self.stale_bytes else ""
        lost = f", lost {'once' if self.lost == 1 else f'{self.lost} times'}" if self.lost else ""
        return f"{self.questions} questions, {self.errors} without a good answer{rate}{stale}{lost}"


def lines_in_words(lines: Mapping[str, LineFigures]) -> list[str]:
    """Tell of every line: those that had trouble one by one, the others together."""
    counted = "as last counted (every hundred dwells and at a stop)"
    good = {name: line for name, line in lines.items() if not (line.errors or line.stale_bytes or line.lost)}
    with_trouble = [f"line of {name}, {counted}: {line.in_words()}" for name, line in lines.items() if name not in good]
    questions = ", ".join(f"{name} ({line.questions} questions)" for name, line in good.items())
    return [*with_trouble, f"lines without a bad answer, {counted}: {questions}"] if good else with_trouble


def link_detail(counts: Mapping[str, ExchangeCounts]) -> dict[str, object]:
    """Return the counts since the lines were opened as an event's detail."""
    return {name: [count.questions, count.errors, count.stale_bytes] for name, count in counts.items()}


@dataclass(slots=True)
class LineTally:
    """Over all connections of a run, event by event: counts begin from 0 with every connection."""

    _total: dict[str, LineFigures] = field(default_factory=dict)
    _since: dict[str, LineFigures] = field(default_factory=dict)
    _lost: Counter[str] = field(default_factory=Counter)
    _process: object = None

    def take(self, event: Event) -> None:
        if event.kind == KIND:
            now = {name: _figures(numbers) for name, numbers in event.detail.items()}
            if any(
                figures.questions < self._since[name].questions for name, figures in now.items() if name in self._since
            ):
                self._total = _added(self._total, self._since)
            self._since = now
        elif lost := _LOST.match(str(event.detail.get("reason", ""))) if event.detail.get("to") == State.HELD else None:
            self._lost[lost["line"]] += 1
        elif event.kind == OPENED_ANEW and not event.detail.get("failed"):
            self._begin_anew()
        elif event.kind == "opened" and event.detail.get("pid") != self._process:
            self._begin_anew()
            self._process = event.detail.get("pid")

    def figures(self) -> dict[str, LineFigures]:
        """Return the figures of every line, so far."""
        found = _added(self._total, self._since)
        return {name: replace(figures, lost=self._lost[name]) for name, figures in found.items()}

    def _begin_anew(self) -> None:
        self._total, self._since = _added(self._total, self._since), {}


def lines_in(events: Iterable[Event]) -> dict[str, LineFigures]:
    """Return the figures of every line over a whole run."""
    tally = LineTally()
    for event in events:
        tally.take(event)
    return tally.figures()


def _figures(numbers: object) -> LineFigures:
    assert isinstance(numbers, list)
    return LineFigures(*map(int, numbers))


def _added(total: Mapping[str, LineFigures], more: Mapping[str, LineFigures]) -> dict[str, LineFigures]:
    found = dict(total)
    for name, figures in more.items():
        before = found.get(name, LineFigures(0, 0, 0))
        found[name] = LineFigures(
            before.questions + figures.questions,
            before.errors + figures.errors,
            before.stale_bytes + figures.stale_bytes,
        )
    return found
