"""What is said of sensors that a run went on without, before hours are spent on measuring without them again."""

import shlex
from pathlib import Path

from procedures.cli.output import note
from procedures.journal.audit.dropped_sensors import read_dropped
from procedures.journal.journal_reader import JournalReader


def tell_dropped(folder: Path) -> None:
    """Say of every sensor that was dropped whether a resume measures it again. Raises: JournalError."""
    with JournalReader.open(folder) as reader:
        for sensor in read_dropped(reader):
            note(sensor.sentence(shlex.quote(str(folder))))
