"""What happened in a run, in the words of a page: one line for each event that a person wants to read."""

from collections.abc import Mapping

from procedures.journal.sidecar.guard_record import EVENT as GUARDED
from procedures.journal.voids import DROPPED, QUARANTINED
from procedures.journal.voids import KIND as VOIDED
from procedures.records.dwells import Event
from procedures.records.states import state_sentence

SILENT = ("intent", "links", "process", "identities", "readiness", "opened", "safe", "meter", "soaked")
"""Of the record; nobody reads them as news."""


def event_words(event: Event) -> str:
    """Return one line; empty for what is no news."""
    detail = event.detail
    match event.kind:
        case "state":
            why = state_sentence(_text(detail, "reason"), _text(detail, "by"))
            return f"{_text(detail, 'to')}{f': {why}' if why else ''}"
        case "dwell":
            reasons = detail.get("reasons")
            joined = "; ".join(map(str, reasons)) if isinstance(reasons, list) else ""
            return "" if detail.get("accepted") else f"step {detail.get('step')} rejected: {joined}"
        case "request":
            refused = _text(detail, "refused")
            request = f"{_text(detail, 'kind')} asked for by {_text(detail, 'by')}"
            return f"request refused: {refused}" if refused else request
        case "note" | "ack":
            word = "note" if event.kind == "note" else "acknowledged"
            return f"{word} by {_text(detail, 'by')}: {_text(detail, 'text')}".rstrip(": ")
        case _ if event.kind == DROPPED:
            return f"{_text(detail, 'sensor')} was dropped, the other sensors go on: {_text(detail, 'reason')}"
        case _ if event.kind in (VOIDED, QUARANTINED):
            return f"{event.kind}: {_text(detail, 'reason')}"
        case _ if event.kind == GUARDED:
            return f"stop guard: {_text(detail, 'why')}"
        case _ if event.kind in SILENT:
            return ""
    joined = _text(detail, "text") or _text(detail, "reason") or _text(detail, "failed")
    return f"{event.kind.replace('_', ' ')}: {joined}" if joined else ""


def _text(detail: Mapping[str, object], name: str) -> str:
    return str(detail.get(name) or "")
