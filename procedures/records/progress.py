"""What a run tells while it goes on."""

from dataclasses import dataclass
from datetime import datetime
from typing import Protocol

from procedures.records.states import State
from rig.local_time import at_both
from rig.plain_text import one_line

COMMON_MODE = "common_mode"
"""The event of what a reference visit shows over all sensors."""
MADE_AGAIN = "again"
"""The event of a move, or of a search for home, that did not end at the first attempt and was made again."""
STRAY_MOTION = "stray_motion"
"""The event of an axis that was found moving, or elsewhere than it was left, when its line was opened."""
AT_REST = "at_rest"
"""The event of what is found while a run stands still, and answered when it goes on."""
OPENED_ANEW = "reconnect"
"""The event of an attempt to open lost lines: what kept one shut, where it was not that before, or nothing."""
LEASE, LEASE_LOST = "lease", "lease lost"
"""Events: held again; and an alarm though the run goes on. The first is the kind of both in the journal."""


@dataclass(frozen=True, slots=True)
class Progress:
    """One moment of a run."""

    event: str
    """``state``, ``dwell``, ``rejected``, ``void``, ``soak``, ``check``, ``refused`` (a request), or another kind."""
    state: State
    dwells_done: int
    """Accepted design dwells."""
    dwells_planned: int
    """0 where nobody knows: the journal cannot be read."""
    replication: int
    replications: int
    rate_per_min: float | None
    """Design dwells a minute of rig time in this epoch; None before the first."""
    eta_utc: datetime | None
    message: str
    requested_by: str = ""
    """Who or what asked for the state; empty where the run itself decided."""
    rejected: int = 0
    """Dwells that do not count."""
    late_utc: datetime | None = None
    """Later than this it ends in one case of ten."""
    cause: str = ""
    """Of the state, by which a person is told what to do first; empty where nothing caused it."""
    motion: str = ""
    """What is known of the axes since the state was entered; empty where nothing was looked at."""


class RunObserver(Protocol):
    """Is told everything worth drawing, in the engine's thread: be quick, and never raise."""

    def on_event(self, progress: Progress) -> None: ...


class SilentObserver:
    """Draws nothing."""

    def on_event(self, progress: Progress) -> None:  # noqa: ARG002  the signature of the ability
        return None


def line_of(progress: Progress) -> str:
    """Return progress in one line.

    ``running 120/1482 · replication 1 of 6 · 7.4 dwells/min · ends 2026-03-01 04:12 UTC · message``.
    """
    planned = progress.dwells_planned
    parts = [f"{progress.state} {progress.dwells_done}/{planned}" if planned else str(progress.state)]
    if progress.replication:
        parts.append(f"replication {progress.replication} of {progress.replications}")
    if progress.rate_per_min is not None:
        parts.append(f"{progress.rate_per_min:.3g} dwells/min")
    if progress.eta_utc is not None and progress.state is State.RUNNING:
        parts.append(f"ends {at_both(progress.eta_utc)}")
    return " · ".join([*parts, one_line(progress.message)] if progress.message else parts)
