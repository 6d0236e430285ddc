"""Under which conditions a run was measured, out of its journal: meters' proofs, watchdogs, lines."""

from collections.abc import Iterable, Mapping, Sequence

from procedures.journal.audit.line_figures import lines_in
from procedures.records.dwells import Event
from procedures.run.watch import meter_checks, watchdogs

MILLIVOLT = 1e-3


def condition_sections(events: Sequence[Event]) -> dict[str, dict[str, str]]:
    """Return heading to rows of text; what a run has not, has no section."""
    sections = {
        **_meters(event for event in events if event.kind == meter_checks.KIND),
        "watchdogs of the axes": _watchdogs(event for event in events if event.kind == watchdogs.KIND),
        "lines": {name: figures.in_words() for name, figures in lines_in(events).items()},
    }
    return {heading: rows for heading, rows in sections.items() if rows}


def _watchdogs(events: Iterable[Event]) -> dict[str, str]:
    """Return the latest word on each axis' watchdog."""
    return {str(event.detail["axis"]): str(event.detail["told"]) for event in events}


def _meters(events: Iterable[Event]) -> dict[str, dict[str, str]]:
    found: dict[str, list[Event]] = {}
    for event in events:
        found.setdefault(f"checks of {event.detail['readout']}", []).append(event)
    return {heading: _meter(checks) for heading, checks in found.items()}


def _meter(checks: Sequence[Event]) -> dict[str, str]:
    occasions = [str(check.detail["occasion"]) for check in checks]
    rows = {"checked": f"{len(checks)} times ({', '.join(_counted(occasions))})"}
    temperatures = [float(str(degc)) for check in checks if (degc := check.detail["temperature_degc"]) is not None]
    if temperatures:
        rows["own temperature"] = f"{min(temperatures):.1f} to {max(temperatures):.1f} °C"
    if calibrated := [check for check in checks if check.detail["is_calibrated_anew"]]:
        rows["calibrated itself"] = f"{len(calibrated)} times, last {calibrated[-1].utc:%Y-%m-%d %H:%M} UTC"
    return rows | _proofs(checks)


def _counted(words: Sequence[str]) -> list[str]:
    return [f"{words.count(word)} × {word}" for word in dict.fromkeys(words)]


def _proofs(checks: Sequence[Event]) -> dict[str, str]:
    """Return how far every short and reference was off at most, and what was allowed."""
    read: dict[str, list[Mapping[str, object]]] = {}
    for check in checks:
        proofs = check.detail["proofs"]
        assert isinstance(proofs, list)
        for proof in proofs:
            read.setdefault(str(proof["what"]), []).append(proof)
    return {what: _proof(proofs) for what, proofs in read.items()}


def _proof(proofs: Sequence[Mapping[str, object]]) -> str:
    read = [proof for proof in proofs if proof["value_v"] is not None]
    offs_v = [_number(proof["value_v"]) - _number(proof["expected_v"]) for proof in read]
    overloaded, limit = len(proofs) - len(offs_v), proofs[-1]["limit_v"]
    limit_v = None if limit is None else _number(limit)
    unit, per_v = ("µV", 1e6) if max(map(abs, [*offs_v, limit_v or 0.0])) < MILLIVOLT else ("V", 1.0)
    text = "never read"
    if offs_v:
        low, high = (f"{end_v * per_v:+.3g}" for end_v in (min(offs_v), max(offs_v)))
        text = f"off by {low if low == high else f'{low} to {high}'} {unit}"
    text += "" if limit_v is None else f", allowed ±{limit_v * per_v:.3g} {unit}"
    bad = sum(not proof["is_good"] for proof in proofs)
    return text + (f", {bad} beyond it" if bad else "") + (f", {overloaded} overloaded" if overloaded else "")


def _number(value: object) -> float:
    assert isinstance(value, int | float)
    return float(value)
