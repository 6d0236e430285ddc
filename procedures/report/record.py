"""What the report needs of a run, read from its journal and from nothing else."""

from procedures.report.assemble import RunRecord
from procedures.run.journal_reader import JournalReader
from procedures.run.owner import is_owned
from procedures.run.states import ACTIVE, State
from rig.description import rig_from_json


def read_record(reader: JournalReader) -> RunRecord:
    """Everything at once, so that the page tells of one moment of the run.

    The journal is verified first, chain, dwells and all: no number is drawn from one that was changed.
    Raises: JournalError, PlanError or DescriptionError where the journal is damaged or of another version.
    """
    reader.verify()
    header = reader.header
    return RunRecord(
        run_id=header.run_id,
        state=str(_state(reader)),
        operator=header.operator,
        is_simulated=header.is_simulated,
        created_utc=header.created_utc,
        plan=header.plan,
        rig=rig_from_json(header.rig_json),
        events=tuple(reader.events()),
        dwells=tuple(reader.dwells()),
        hashes={
            "journal content": reader.sha256_of_content(),
            "plan": header.plan_sha256,
            "rig file": header.rig_sha256,
            "procedure file": header.procedure_sha256,
        },
        versions=header.software,
    )


def _state(reader: JournalReader) -> State:
    """A run whose process is gone does not run, whatever its last line says."""
    written = reader.state()
    return State.INTERRUPTED if written in ACTIVE and not is_owned(reader.path.parent) else written
