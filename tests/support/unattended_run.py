"""A run with nobody there, but somebody's clock; things happen to the rig and heal again, all in virtual time."""

from collections.abc import Callable, Mapping
from datetime import datetime
from pathlib import Path

from asking import put
from faulty_rig import FaultyRig
from journals import a_clock
from small_run import Bench

from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.spool import Spool
from procedures.records.dwells import Event
from procedures.records.progress import Progress
from procedures.run.begin import begin
from procedures.run.ending import Outcome
from procedures.run.services import RunServices
from rig.assembly.open_rig import Rig, open_rig
from rig.errors import LinkLost
from rig.link.counts import ExchangeCounts

Happening = Callable[["UnattendedRun"], None]


class UnattendedRun:
    """Real seconds that cost none: ``at[n]`` happens at the n-th rest while the run stands still.

    Also the run's observer: ``after[n]`` happens when n dwells of the design are done.
    """

    slice_s = 0.1
    factor = 1.0

    def __init__(
        self, run_dir: Path, at: Mapping[int, Happening] | None = None, after: Mapping[int, Happening] | None = None
    ) -> None:
        self.run_dir = run_dir
        self.spool = Spool(run_dir)
        self.rig: Rig
        self.rests = 0
        self.heard: list[Progress] = []
        self._at, self._after = dict(at or {}), dict(after or {})
        self._clock = a_clock()

    def sleep(self, duration_s: float) -> None:
        self.rests += 1
        self._clock.sleep(duration_s)
        assert self.rests < 100_000, "the run stands still for ever"
        if happening := self._at.pop(self.rests, None):
            happening(self)

    def on_event(self, progress: Progress) -> None:
        self.heard.append(progress)
        if progress.event == "dwell" and (happening := self._after.pop(progress.dwells_done, None)):
            happening(self)

    def monotonic_s(self) -> float:
        return self._clock.monotonic_s()

    def boottime_s(self) -> float:
        return self._clock.boottime_s()

    def now_utc(self) -> datetime:
        return self._clock.now_utc()


def asks(kind: str) -> Happening:
    """Somebody comes by and asks for it."""
    return lambda unattended: put(unattended.spool, kind, "bert", f"please {kind}")


def run_unattended(
    small: Bench,
    unattended: UnattendedRun,
    services: RunServices | None = None,
    rig_of: Callable[[Rig], object] = lambda rig: rig,
) -> Outcome:
    """Run with nobody there; ``rig_of`` puts something around the rig."""
    unattended.run_dir.mkdir()
    with open_rig(small.rig) as rig:
        unattended.rig = rig
        header = small.header(unattended.run_dir)
        return begin(unattended.run_dir, header, small.plan, rig_of(rig), unattended, unattended, services)  # type: ignore[arg-type]


def events(run_dir: Path, kind: str | None = None) -> list[Event]:
    with JournalReader.open(run_dir) as reader:
        reader.verify()
        return list(reader.events(kind))


def states(run_dir: Path) -> list[str]:
    return [str(event.detail["to"]) for event in events(run_dir, "state")]


class RigReopenedLate(FaultyRig):
    """A rig whose adapter answers again only at the n-th attempt to open it."""

    def __init__(self, rig: Rig, answers_at: int, **wrong: object) -> None:
        super().__init__(rig, **wrong)  # type: ignore[arg-type]
        self._answers_at = answers_at
        self.attempts = 0

    def reconnect(self) -> None:
        self.attempts += 1
        if self.attempts < self._answers_at:
            raise LinkLost("readouts.dmm at /dev/serial/by-id/usb-x: cannot be opened; check the cable and the path")
        super().reconnect()


class RigWithBadLine(FaultyRig):
    """A rig whose table line answers badly at first, more often than it should."""

    share = 0.05

    def link_counts(self) -> Mapping[str, ExchangeCounts]:
        found = self._rig.link_counts()
        table = found["axes.pitch"]
        return {**found, "axes.pitch": ExchangeCounts(table.questions, 0, int(self.share * table.questions), 0, 0)}
