"""Sensors that a run went on without: which stay dropped, and which a person brought back by taking dwells back."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from procedures.journal.journal_reader import JournalReader
from procedures.journal.voids import DROPPED
from procedures.journal.voids import KIND as VOIDED
from procedures.records.dwells import DwellRecord, Event
from rig.description.rig_file import Sensor

OF_PEOPLE = ("void", "redo")
"""Causes of a line that takes dwells back, where a person did."""


@dataclass(frozen=True, slots=True)
class DroppedSensor:
    """One sensor that was dropped, and how it stands by the dwells that count now."""

    name: str
    step: int
    """At which it was dropped last."""
    is_taken_back: bool
    """Whether a person took dwells back since."""
    lacking: tuple[int, ...]
    """Steps of the dwells that count and lack it, in the order of time; those of check sets, which every epoch measures
    anew, are left out."""

    @property
    def is_measured_again(self) -> bool:
        """Whether a run that goes on reads its channels: it is solved from dwells that all have it, or not at all."""
        return self.is_taken_back and not self.lacking

    def sentence(self, run: str) -> str:
        """Say how it stands; ``run`` as the shell takes it."""
        if self.is_measured_again:
            return f"{self.name} was dropped at step {self.step}; what lacks it was taken back: it is measured again"
        if not self.lacking:
            return f"{self.name} stays dropped since step {self.step}: measure it in a new run"
        count = len(self.lacking)
        return (
            f"{self.name} stays dropped since step {self.step}: {count} dwell{'s' if count > 1 else ''} that "
            f"count{'' if count > 1 else 's'} lack{'' if count > 1 else 's'} it; measure it in a new run, or take back "
            f"what lacks it: calrig void {run} --from {self.lacking[0]} --operator NAME --reason TEXT"
        )


def read_dropped(reader: JournalReader) -> tuple[DroppedSensor, ...]:
    """Return every sensor that the run of a journal went on without. Raises: JournalError."""
    if reader.last_event(DROPPED) is None:
        return ()
    return dropped_sensors(reader.events(), tuple(reader.dwells()), reader.header.plan.sensors)


def dropped_sensors(
    events: Iterable[Event], dwells: Sequence[DwellRecord], sensors: Mapping[str, Sensor]
) -> tuple[DroppedSensor, ...]:
    """Return every sensor that was dropped, in the order in which it was first.

    Args:
        dwells: with their samples and in the order of commitment, as the journal gives them: what was taken back is
            not accepted.
        sensors: of the plan.
    """
    found: dict[str, tuple[int, bool]] = {}
    for event in events:
        if event.kind == DROPPED:
            found[str(event.detail["sensor"])] = (int(str(event.detail["step"])), False)
        elif event.kind == VOIDED and event.detail.get("cause") in OF_PEOPLE:
            found = {name: (step, True) for name, (step, _) in found.items()}
    counted = [dwell for dwell in dwells if dwell.accepted and dwell.purpose != "check"]
    return tuple(
        DroppedSensor(name, step, is_taken_back, _lacking(counted, sensors[name]))
        for name, (step, is_taken_back) in found.items()
    )


def _lacking(dwells: Iterable[DwellRecord], sensor: Sensor) -> tuple[int, ...]:
    channels = set(sensor.channels.values())
    return tuple(dwell.step for dwell in dwells if not channels <= dwell.readings.keys())
