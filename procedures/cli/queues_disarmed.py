"""What a command that has a rig, or stops one, says of the queues of this account that wait for it."""

from pathlib import Path

from procedures.cli.locations import queues_of_here
from procedures.cli.output import note
from procedures.queue.hands import disarm_by_stop_of_rig, disarm_by_stop_of_run, heed_all
from rig.clock import SystemClock


def note_disarmed() -> None:
    """Say which queues are disarmed by this command, which has the rig now."""
    for sentence in heed_all(queues_of_here(), SystemClock()):
        note(sentence)


def disarmed_by(what: str, *, run: Path | None = None, rig: Path | None = None) -> list[str]:
    """Return a sentence for every queue that is disarmed by what is done to a run, or to a rig, from elsewhere."""
    if run is not None:
        return disarm_by_stop_of_run(queues_of_here(), run, what, SystemClock())
    return [] if rig is None else disarm_by_stop_of_rig(queues_of_here(), rig, what, SystemClock())
