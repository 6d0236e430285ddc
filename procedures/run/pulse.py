"""The pulse of a run: what is done at every look of every wait, whatever the engine waits for."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress

from procedures.errors import StorageFailed
from procedures.journal.sidecar.alert_record import EVENT as ALERTED
from procedures.journal.sidecar.live import LiveFile
from procedures.records.progress import LEASE
from procedures.run.progress_log import ProgressLog
from procedures.run.services import RunServices
from procedures.run.watch.clock_watch import GapWatch
from procedures.run.watch.watchdogs import Watchdogs


class RunPulse:
    """Called, it journals what happened since the last look and feeds the watchdogs.

    It returns within how many seconds it wants to be called again.
    """

    def __init__(
        self,
        progress_log: ProgressLog,
        services: RunServices,
        gaps: GapWatch,
        live: LiveFile,
        watchdogs: Watchdogs,
        sign_of_life: Callable[[], None],
    ) -> None:
        self._progress_log = progress_log
        self._services = services
        self._gaps = gaps
        self._live = live
        self._watchdogs = watchdogs
        self._sign_of_life = sign_of_life
        self._unwritten: deque[tuple[str, Mapping[str, object]]] = deque()

    def __call__(self) -> float:
        self._sign_of_life()
        if (gap := self._gaps.look()) is not None:
            self._progress_log.event("held_up", {"gap_s": round(gap.gap_s, 1), "text": gap.text})
        self._unwritten.extend((ALERTED, outcome) for outcome in self._services.pulse())
        self._unwritten.extend((LEASE, self._progress_log.tell_lease(news)) for news in self._services.lease_news())
        with suppress(StorageFailed):  # what became of an alert or a lease ends no run; a dwell that finds no room does
            while self._unwritten:
                self._progress_log.event(*self._unwritten[0])
                self._unwritten.popleft()
        self._live.look()
        return self._watchdogs.feed()

    @property
    def unwritten_alerts(self) -> Sequence[Mapping[str, object]]:
        """What became of alerts and the disk of the journal took no more."""
        return [outcome for kind, outcome in self._unwritten if kind == ALERTED]
