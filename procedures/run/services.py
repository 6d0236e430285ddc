"""What surrounds a run beside its rig, its journal and its screen: all of it may be left out."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from procedures.journal.header import RunHeader
from procedures.lease.keeper import LeaseNews
from procedures.plan.plan import Plan
from procedures.records.dwells import DwellRecord
from procedures.records.sufficiency import Sufficiency
from procedures.run.judgement.run_limits import RunLimits, run_limits_of
from procedures.run.watch.disk_space import free_bytes
from rig.assembly.open_rig import Claim, claimed_by_nobody_else
from rig.description.read import rig_from_json
from rig.description.rig_file import RigDescription

Enough = Callable[[RigDescription, Plan, Sequence[DwellRecord]], Sufficiency]
"""From the dwells of whole replications to what ``[stop] half_width_deg`` says of them."""
Pulse = Callable[[], Sequence[Mapping[str, object]]]


def _nothing() -> Sequence[Mapping[str, object]]:
    return ()


def _tell_nobody() -> None:
    return None


def _no_lease() -> Sequence[LeaseNews]:
    return ()


@dataclass(frozen=True, slots=True)
class RunServices:
    """Collaborators of an unattended run."""

    run_limits: RunLimits = field(default_factory=RunLimits)
    pulse: Pulse = _nothing
    """Called at every look of every wait: a heartbeat goes out while the engine really lives. What it returns, such as
    what became of an alert, is journalled."""
    free_bytes: Callable[[Path], int] = free_bytes
    """Of the disk that holds a folder."""
    begun: Callable[[], None] = _tell_nobody
    """Called when nothing refuses the run any more: it is owned and its journal is open, and nothing has moved."""
    ended: Callable[[], None] = _tell_nobody
    """Called when the end of the run is on record, in its journal or as last words beside it, with the page that is
    due: who closes the rig before that has it told as the run's death."""
    second_folder: Path | None = None
    """Where an emergency copy of the journal goes when its own disk fails."""
    claim: Claim = claimed_by_nobody_else
    """Of devices that other computers reach as well, where this process opens the rig."""
    lease_news: Callable[[], Sequence[LeaseNews]] = _no_lease
    """What became of that claim since the last look."""
    archive: str = ""
    """Where the sets of the run go, as its journal may keep it; empty where nobody named an archive."""
    ring: Sequence[str] = ()
    """The command by which the stop guard tells people where this process ends without a word."""
    enough: Enough | None = None
    """None: every replication is measured, and a plan that has the rule is refused."""
    described: RigDescription | None = None
    """The rig as the journal has it."""


def with_run_limits(services: RunServices | None, header: RunHeader) -> RunServices:
    """Return the services with what the journal's own rig description asks for."""
    described = rig_from_json(header.rig_json)
    return replace(services or RunServices(), run_limits=run_limits_of(described), described=described)
