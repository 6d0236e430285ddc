"""What the report needs of a run, read from its journal and from nothing else."""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from pathlib import Path

from procedures.common_mode.visit_watch import Judged, judge_run
from procedures.journal.audit.audit_trail import dwells_on_one_clock, on_one_clock
from procedures.journal.audit.known_devices import Tenure, tenures_in
from procedures.journal.journal_reader import JournalReader
from procedures.journal.sidecar.owner import is_owned
from procedures.plan.plan import Plan
from procedures.records.declared_supply import correcting
from procedures.records.dwells import DwellRecord, Event
from procedures.records.states import ACTIVE, State
from procedures.solution.taken_back_visits import left_in_doubt
from rig.description.rig_file import RigDescription


@dataclass(frozen=True)
class RunRecord:
    """What the journal holds, as the report needs it."""

    run_id: str
    folder: Path
    """Where its journal was read, as whoever asked for it named it."""
    state: str
    operator: str
    is_simulated: bool
    created_utc: datetime
    plan: Plan
    rig: RigDescription
    events: Sequence[Event]
    dwells: Sequence[DwellRecord]
    """Both with the dates that count, whatever was done to the clock."""
    hashes: Mapping[str, str]
    """What was hashed (``journal content``, ``plan``, ``rig file`` …) to its SHA-256."""
    versions: Mapping[str, str]
    lineage: Sequence[str] = ()
    """Contents of the journal when the run had finished before, and something was taken back since."""

    @property
    def run(self) -> str:
        """As commands take it where this was asked for: its name alone is found under ./runs only."""
        return shlex.quote(str(self.folder))

    @cached_property
    def judged_visits(self) -> tuple[Judged, ...]:
        """Every reference visit and later check set as it is judged; solution, archive and report all ask.

        A visit that was taken back is among them where dwells that are in doubt by it still count.
        """
        dwells = sorted(self.dwells, key=lambda dwell: (dwell.epoch, dwell.started_s))
        chains = correcting(self.rig.chain)
        found = judge_run(self.plan, chains, dwells, self.events)
        return (*found, *left_in_doubt(self.plan, chains, dwells, self.events, found))

    @cached_property
    def tenures(self) -> Mapping[str, tuple[Tenure, ...]]:
        """Which devices measured which dwells, by table."""
        return tenures_in(self.events, self.dwells, self.plan)

    @property
    def ended_utc(self) -> datetime:
        """When the run came to its last state: people write notes into the journal long afterwards."""
        return max((event.utc for event in self.events if event.kind == "state"), default=self.created_utc)

    @property
    def measured_utc(self) -> datetime:
        """When its last accepted dwell ended: the date of what was measured."""
        return max((dwell.ended_utc for dwell in self.dwells if dwell.accepted), default=self.created_utc)


def read_record(reader: JournalReader) -> RunRecord:
    """Read everything at once, so that the page tells of one moment of the run.

    The journal is verified first, chain, dwells and all: no number is drawn from one that was changed.
    Raises: JournalError, PlanError or DescriptionError where the journal is damaged or of another version.
    """
    header, (stamped, verified) = reader.header, reader.verified()
    dwells = tuple(verified)
    content, *earlier = reader.contents()
    # One whose process is gone does not run, whatever its last line says.
    written = reader.state()
    return RunRecord(
        run_id=header.run_id,
        folder=reader.path.parent,
        state=str(State.INTERRUPTED if written in ACTIVE and not is_owned(reader.path.parent) else written),
        operator=header.operator,
        is_simulated=header.is_simulated,
        created_utc=header.created_utc,
        plan=header.plan,
        rig=reader.rig,
        events=tuple(on_one_clock(stamped)),
        dwells=tuple(dwells_on_one_clock(dwells, stamped)),
        hashes={
            "journal content": content,
            "plan": header.plan_sha256,
            "rig file": header.rig_sha256,
            "procedure file": header.procedure_sha256,
            **{named.label: named.sha256 for named in header.named_files},
        },
        versions=header.software,
        lineage=tuple(earlier),
    )
