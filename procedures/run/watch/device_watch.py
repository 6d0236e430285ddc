"""Whether the devices that answer are those of the run; another one is taken over by name and reason alone."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from procedures.journal.audit.changes import KIND as OVERRIDE
from procedures.journal.audit.known_devices import ANSWERED, TAKEN_OVER, KnownDevices, is_used, other_devices
from procedures.plan.plan import Plan

UNSEEN = "--accept-changes takes over only what the run stopped at before: look at it, then give it again"
RecordEvent = Callable[[str, Mapping[str, object]], object]


@dataclass(frozen=True, slots=True)
class TakesOver:
    """Who answers for devices that are other ones, and why."""

    by: str
    reason: str


class DeviceWatch:
    """Compares the answers of every epoch of a process with the devices that the run knows."""

    def __init__(self, known: KnownDevices, takes_over: TakesOver | None, record: RecordEvent) -> None:
        """``takes_over``: holds for the first comparison alone; a line that is lost later brings no permission."""
        self._of_run, self._seen_last = dict(known.of_run), known.seen_last
        self._takes_over, self._record = takes_over, record

    def refusal(self, found: Mapping[str, str], plan: Plan) -> str:
        """Record who answers; return why the run does not go on with them, empty where it does."""
        self._record(ANSWERED, dict(found))
        takes_over, self._takes_over = self._takes_over, None
        known = self._of_run or found
        others = {name: said for name, said in other_devices(known, found).items() if is_used(name, plan)}
        sentence = f"not the devices of this run: {'; '.join(others.values())}"
        if others and takes_over is None:
            return sentence
        if others and takes_over is not None and not self._takes(others, found, takes_over):
            return f"{sentence}; {UNSEEN}"
        self._of_run, self._seen_last = {**known, **found}, found
        return ""

    def _takes(self, others: Mapping[str, str], found: Mapping[str, str], takes_over: TakesOver) -> bool:
        """Record who answers for these devices, unless the run has not stopped at every one of them before."""
        if any(found.get(name) != self._seen_last.get(name) for name in others):
            return False
        differences = [f"another device: {said}" for said in others.values()]
        devices = {name: found[name] for name in others if name in found}
        detail = {"by": takes_over.by, "reason": takes_over.reason, "differences": differences, TAKEN_OVER: devices}
        self._record(OVERRIDE, detail)
        return True
