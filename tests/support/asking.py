"""Requests of somebody who looked at the run a moment before: they expect the state in which it is."""

from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.spool import Request, Spool


def put(spool: Spool, kind: str, by: str, text: str = "", at_utc: str = "2026-03-01T13:00:00+00:00") -> None:
    """Put a request into the spool, past the refusals of `ask`."""
    with JournalReader.open(spool.folder.parent) as reader:
        entered = reader.last_event("state")
    assert entered is not None
    spool.submit(Request(kind, by, at_utc, text, entered.sequence))  # type: ignore[arg-type]
