"""The run as a file of metrics, for the text-file collector of a node exporter.

Only where ``CALRIG_METRICS_FILE`` names one.
"""

import os
from contextlib import suppress
from pathlib import Path

from ams.whole_file import replace_file
from procedures.journal.sidecar.live import read_live
from procedures.journal.status.metrics import RunFigures, metrics_text
from procedures.observers.audience import ObserverKind
from procedures.records.progress import Progress, RunObserver
from procedures.records.states import ACTIVE
from rig.clock import Clock, SystemClock

VARIABLE = "CALRIG_METRICS_FILE"
EVERY_S = 1.0


class MetricsFile:
    """Renamed into place at every state and at most once a second between; a disk that refuses it is not told."""

    def __init__(self, path: Path, run_dir: Path, clock: Clock) -> None:
        self._path = path
        self._run_dir = run_dir
        self._clock = clock
        self._written_s = -EVERY_S

    def on_event(self, progress: Progress) -> None:
        now_s = self._clock.monotonic_s()
        if progress.event != "state" and now_s - self._written_s < EVERY_S:
            return
        self._written_s = now_s
        figures = RunFigures(self._run_dir.name, progress, read_live(self._run_dir), progress.state in ACTIVE, None)
        with suppress(OSError):
            replace_file(self._path, metrics_text([figures]).encode("utf-8"), is_synced=False)


def _make(run_dir: Path) -> RunObserver | None:
    named = os.environ.get(VARIABLE)
    return MetricsFile(Path(named), run_dir, SystemClock()) if named else None


OBSERVER = ObserverKind("metrics-file", _make)
