"""A line for a display on the wall, renewed whenever a run tells something: ``state done/planned``."""

from pathlib import Path

from procedures.observers.audience import ObserverKind
from procedures.records.progress import Progress

DISPLAY = "wall.txt"


class Wall:
    """Writes what a display shows into a file of the run's folder."""

    def __init__(self, run_dir: Path) -> None:
        self._file = run_dir / DISPLAY

    def on_event(self, progress: Progress) -> None:
        """Tell it at once; a display that fails is told no more, and the run goes on."""
        self._file.write_text(f"{progress.state} {progress.dwells_done}/{progress.dwells_planned}\n", encoding="utf-8")


OBSERVER = ObserverKind("wall", Wall)
