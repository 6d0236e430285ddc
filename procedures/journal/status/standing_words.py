"""Where a run stands, in rows of words: the same in the terminal, in ``calrig status`` and on the console's page."""

from collections.abc import Iterator, Mapping
from datetime import datetime, tzinfo

from procedures.journal.sidecar.live import Live, Target
from procedures.numbers import duration
from procedures.records.progress import Progress
from procedures.records.states import GOING, State
from rig.local_time import at_both
from rig.plain_text import one_line

Row = tuple[str, str]
"""What it is, and how it is."""


def rows_of(
    progress: Progress, reason: str, live: Live | None, now_utc: datetime, zone: tzinfo | None = None
) -> list[Row]:
    """Return the rows, the most important first; ``reason``: why the run is in its state, in full.

    ``zone``: of the reader; by default that of this machine.
    """
    goes_on = progress.state in GOING  # whoever waits for a person or for a cable has no end
    return [
        ("state", f"{str(progress.state).upper()}{f': {one_line(reason)}' if reason else ''}"),
        ("done", _done(progress)),
        *([("ends", _ends(progress.eta_utc, progress.late_utc, zone))] if goes_on and progress.eta_utc else []),
        *([("asked", _pending(live, progress.state))] if live is not None and live.pending_request else []),
        *([] if live is None else live_rows(live, now_utc)),
    ]


def _pending(live: Live, state: State) -> str:
    """Return what was asked for, and when it will be done."""
    ahead = ["the soak"] * (live.phase == "soaking") + ["the check set"] * (state is State.CHECKING) or ["this dwell"]
    return f"{one_line(live.pending_request)}: waits for the end of {' and '.join(ahead)}"


def _ends(eta_utc: datetime, late_utc: datetime | None, zone: tzinfo | None) -> str:
    """Return when it ends as it goes now, and when in nine cases of ten."""
    late = "" if late_utc is None else f"; later than {at_both(late_utc, zone)} in one case of ten"
    return f"{at_both(eta_utc, zone)}{late}"


def _done(progress: Progress) -> str:
    planned = progress.dwells_planned
    share = f" ({100 * progress.dwells_done // planned} %)" if planned else ""
    parts = [f"{progress.dwells_done} of {planned} dwells{share}"]
    if progress.replication:
        parts.append(f"replication {progress.replication} of {progress.replications}")
    parts.append(f"{progress.rejected} rejected")
    if progress.rate_per_min is not None:
        parts.append(f"{progress.rate_per_min:.3g} a minute")
    return ", ".join(parts)


def live_rows(live: Live, now_utc: datetime) -> Iterator[Row]:
    """Yield what the engine does at this moment."""
    if live.phase:
        since = live.phase_since_utc
        lasts = "" if since is None else f" for {duration((now_utc - since).total_seconds())}"
        waits = f", waiting for {one_line(live.waiting_for)}" if live.waiting_for else ""
        yield "now", f"{live.phase}{lasts}{_usually(live)}{waits}"
    if live.now is not None:
        yield "at", f"{_target(live.now)}; seen at {_angles(live.positions_deg) or 'no position yet'}"
    if live.next is not None:
        yield "next", _target(live.next)
    for name, degc in live.temperature_degc.items():
        setpoint = f", set to {live.setpoint_degc[name]:g}" if name in live.setpoint_degc else ""
        yield one_line(name), f"{degc:.2f} °C{setpoint}"
    if live.soak_left_s is not None:
        yield "soak", f"{duration(live.soak_left_s)} left at the least"


def _usually(live: Live) -> str:
    if live.usual_s is None or live.seldom_over_s is None:
        return ""
    seldom = "" if live.seldom_over_s <= live.usual_s else f", seldom over {duration(live.seldom_over_s)}"
    return f" (usually {duration(live.usual_s)}{seldom})"


def _target(target: Target) -> str:
    return f"step {target.step} ({target.purpose}), {_angles(target.targets_deg)}"


def _angles(angles_deg: Mapping[str, float]) -> str:
    return ", ".join(f"{one_line(name)} {angle_deg:+.4g}" for name, angle_deg in angles_deg.items())
