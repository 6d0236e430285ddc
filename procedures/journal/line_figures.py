"""What happened on every line, for the record: kept every hundred dwells, before lines are opened anew, at the end."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from procedures.records.dwells import Event
from rig.link.counts import ExchangeCounts

KIND = "links"


@dataclass(frozen=True, slots=True)
class LineFigures:
    """Of one line, or of one device of several on it."""

    asked: int
    errors: int
    """Questions without a good answer, whether they were asked again or not."""
    stale_bytes: int
    """That nobody had asked for."""

    def in_words(self) -> str:
        """Describe the figures in one phrase."""
        rate = f" ({self.errors / self.asked:.2%})" if self.errors and self.asked else ""
        stale = f", {self.stale_bytes} bytes nobody asked for" if self.stale_bytes else ""
        return f"{self.asked} questions, {self.errors} without a good answer{rate}{stale}"


def link_detail(counts: Mapping[str, ExchangeCounts]) -> dict[str, object]:
    """Return the counts since the lines were opened as an event's detail."""
    return {name: [one.asked, one.errors, one.stale_bytes] for name, one in counts.items()}


def lines_in(events: Iterable[Event]) -> dict[str, LineFigures]:
    """Return the figures of every line over all connections of a run: counts begin from 0 with every one."""
    total: dict[str, LineFigures] = {}
    since: dict[str, LineFigures] = {}
    process: object = None
    for event in events:
        if event.kind == KIND:
            now = {name: _figures(numbers) for name, numbers in event.detail.items()}
            if any(one.asked < since[name].asked for name, one in now.items() if name in since):
                total = _added(total, since)
            since = now
        elif event.kind == "reconnect" and not event.detail.get("failed"):
            total, since = _added(total, since), {}
        elif event.kind == "opened" and event.detail.get("pid") != process:
            total, since, process = _added(total, since), {}, event.detail.get("pid")
    return _added(total, since)


def _figures(numbers: object) -> LineFigures:
    assert isinstance(numbers, list)
    return LineFigures(*map(int, numbers))


def _added(total: Mapping[str, LineFigures], more: Mapping[str, LineFigures]) -> dict[str, LineFigures]:
    found = dict(total)
    for name, one in more.items():
        before = found.get(name, LineFigures(0, 0, 0))
        found[name] = LineFigures(
            before.asked + one.asked, before.errors + one.errors, before.stale_bytes + one.stale_bytes
        )
    return found
