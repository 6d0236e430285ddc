"""A run as tables, from its journal: what ``calrig.read_run`` gives and ``calrig data`` writes."""

from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import pandas as pd

from procedures.data.archived import archived_run
from procedures.data.solved import Solved
from procedures.data.tables import dwells_table, events_table, readings_table, samples_table
from procedures.delivery.deliver import sensors_document, solve_run
from procedures.errors import RequestError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.storage import JOURNAL_FILE
from procedures.journal.taken_away import require_not_taken_away


@dataclass(frozen=True, eq=False)
class RunData:
    """One run as it stood when it was read. Made by :func:`read_run`; docs/data.md lists the columns."""

    path: Path
    """The run's folder."""
    run: str
    """Its identity, which also stands in the first column of the dwells."""
    title: str
    dwells: pd.DataFrame
    """A row for every judged dwell, by its number in the journal."""
    readings: pd.DataFrame
    """A row for every channel of every dwell: ``readings.join(dwells[["pitch_deg", "roll_deg"]])`` finds where."""
    events: pd.DataFrame
    """The audit trail."""

    def samples(self) -> pd.DataFrame:
        """Return every sample of every dwell of these tables. Raises: JournalError."""
        last = max(self.dwells.index, default=0)
        with JournalReader.open(self.path) as reader:
            known = [(number, dwell) for number, dwell in reader.numbered_dwells() if number <= last]
            return samples_table(known, reader.header.plan.sensors)

    def solve(self) -> Solved:
        """Solve every sensor again, as ``calrig solve`` does, and write nothing. Raises: JournalError, PlanError."""
        solved = solve_run(self.path)
        return Solved(solved.sensors, {"sensors": sensors_document(solved)})

    def plot(self, channel: str | None = None) -> Any:
        """Draw the mean of every accepted dwell of the design against pitch, a panel a channel, as a Figure."""
        from procedures.data.drawings import means_against_pitch

        return means_against_pitch(self.dwells, self.readings, channel)

    def _repr_html_(self) -> str:
        accepted = int(self.dwells["accepted"].sum())
        counts = f"{len(self.dwells)} dwells, {accepted} of them accepted; {len(self.readings)} readings"
        return f"<p><b>{escape(self.title)}</b> ({self.run}): {counts}</p>{self.dwells.head().to_html()}"


def read_run(path: str | Path, *, archive: str | None = None) -> RunData:
    """Read a run's folder, or its journal, into tables; the journal is verified first and never written to.

    ``archive``: the URL of an archive, in which ``path`` is then the identity of a run; its journal must be the one
    that was archived.

    Raises: RequestError where no run is there; JournalError or PlanError where it is damaged or of another version.
    """
    folder = Path(path) if archive is None else archived_run(str(path), archive)
    folder = folder.parent if folder.name == JOURNAL_FILE else folder
    require_not_taken_away(folder)
    if not (folder / JOURNAL_FILE).exists():
        raise RequestError(f"{path}: no run is there: it holds no {JOURNAL_FILE}; give the folder of a run")
    with JournalReader.open(folder) as reader:
        reader.verify()
        header = reader.header
        dwells = list(reader.numbered_dwells())
        return RunData(
            path=folder,
            run=header.run_id,
            title=header.title,
            dwells=dwells_table(header.run_id, dwells),
            readings=readings_table(dwells, header.plan.sensors),
            events=events_table(reader.events()),
        )
