"""How far a run is, told to whoever draws it: a live screen in a terminal, plain lines elsewhere."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import timedelta
from math import sqrt
from pathlib import Path
from typing import TextIO, cast

from rich.console import Console, RenderableType
from rich.live import Live as LiveDrawing
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from procedures.journal.sidecar.live import read_live
from procedures.journal.status.standing_words import rows_of
from procedures.records.progress import Progress, RunObserver, line_of
from procedures.records.states import State
from procedures.run.unhindered import Unhindered
from rig.clock import Clock, SystemClock
from rig.plain_text import one_line

COLOURS = {State.HELD: "bold yellow", State.TRIPPED: "bold red", State.FAILED: "bold red", State.PAUSED: "yellow"}


@dataclass(slots=True)
class Pace:
    """Rate and end from the time measured in this epoch, blended with the time planned."""

    planned_s: float
    """Seconds a design dwell by the plan."""
    started_s: float
    weight: float = 5.0
    """So many dwells of the plan's rate count beside those measured."""
    done: int = 0
    spread_s: float = 0.0
    """From the p50 to the p90 of the whole plan."""

    def rate_per_min(self, now_s: float) -> float | None:
        elapsed_s = now_s - self.started_s
        return 60.0 * self.done / elapsed_s if self.done and elapsed_s > 0.0 else None

    def remaining(self, left: int, now_s: float) -> timedelta:
        elapsed_s = now_s - self.started_s
        each_s = (self.weight * self.planned_s + elapsed_s) / (self.weight + self.done)
        return timedelta(seconds=left * each_s)

    def spread(self, left: int, planned: int) -> timedelta:
        """Return by how much one case of ten ends later, with so many dwells left."""
        return timedelta(seconds=self.spread_s * sqrt(left / max(planned, 1)))


class Lines:
    """Writes lines to a stream; a screen that has gone away (``| head``), or is held, never stops a run."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = Unhindered(stream)

    def __call__(self, line: str) -> None:
        self._stream.write(f"{line}\n")
        self._stream.flush()


class PlainLines:
    """One line a state, a rejection, and a twentieth of the run."""

    def __init__(self, write: Callable[[str], None], parts: int | None = 20) -> None:
        """``parts``: None tells every dwell."""
        self._write = write
        self._parts = parts
        self._shown_part = -1

    def on_event(self, progress: Progress) -> None:
        if progress.event == "dwell" and self._parts is not None:
            part = self._parts * progress.dwells_done // max(progress.dwells_planned, 1)
            if part == self._shown_part:
                return
            self._shown_part = part
        self._write(line_of(progress))


@contextmanager
def shown_on(stream: TextIO, run_dir: Path | None = None, clock: Clock | None = None) -> Iterator[RunObserver]:
    """Yield an observer that draws on ``stream``: a live screen where it is a terminal, plain lines otherwise.

    ``run_dir``: whose ``live.json`` tells what happens between two commits.
    """
    if not stream.isatty():
        yield PlainLines(Lines(stream))
        return
    with _screen_on(stream, run_dir, clock or SystemClock()) as observer:
        yield observer


@contextmanager
def _screen_on(stream: TextIO, run_dir: Path | None, clock: Clock) -> Iterator[RunObserver]:
    console = Console(file=cast(TextIO, Unhindered(stream)))
    screen = RunScreen(run_dir, clock)
    with LiveDrawing(console=console, get_renderable=screen.drawn, refresh_per_second=4, transient=True) as drawing:
        screen.write = lambda line: drawing.console.print(line, markup=False, highlight=False)
        yield screen
        drawing.refresh()
    console.print(screen.drawn())


class RunScreen:
    """Where a run stands, drawn anew a few times a second; what happened goes by above it."""

    def __init__(self, run_dir: Path | None, clock: Clock) -> None:
        self._run_dir = run_dir
        self._clock = clock
        self._last: Progress | None = None
        self._reason = ""
        self.write: Callable[[str], None] = lambda _line: None

    def on_event(self, progress: Progress) -> None:
        """Keep what is told; what is no step forward is written above the screen."""
        if progress.event == "state":
            self._reason = progress.message
        self._last = progress
        if progress.event not in ("state", "dwell", "soak", "check") and progress.message:
            self.write(one_line(progress.message))

    def drawn(self) -> RenderableType:
        """Return what stands on the screen now, for any width."""
        if self._last is None:
            return Text("planned")
        live = None if self._run_dir is None else read_live(self._run_dir)
        bar = ProgressBar(self._last.dwells_planned or None, self._last.dwells_done)
        rows = Table.grid(padding=(0, 2), expand=True)
        rows.add_column(style="dim", no_wrap=True)
        rows.add_column(overflow="fold", ratio=1)
        for name, text in rows_of(self._last, self._reason, live, self._clock.now_utc()):
            rows.add_row(Text(name), Text(text, style=COLOURS.get(self._last.state, "") if name == "state" else ""))
        rows.add_row("", bar)
        return rows
