"""How far a run is, told to whoever draws it: a Rich bar in a terminal, plain lines elsewhere."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import timedelta
from typing import TextIO

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar

from procedures.records.progress import Progress, RunObserver, line_of


class SilentObserver:
    """Draws nothing."""

    def on_event(self, progress: Progress) -> None:  # noqa: ARG002  the signature of the ability
        return None


@dataclass(slots=True)
class Pace:
    """Rate and end from the time measured in this epoch, blended with the time planned."""

    planned_s: float
    """Seconds a design dwell by the plan."""
    started_s: float
    weight: float = 5.0
    """So many dwells of the plan's rate count beside those measured."""
    done: int = 0

    def rate_per_min(self, now_s: float) -> float | None:
        elapsed_s = now_s - self.started_s
        return 60.0 * self.done / elapsed_s if self.done and elapsed_s > 0.0 else None

    def remaining(self, left: int, now_s: float) -> timedelta:
        elapsed_s = now_s - self.started_s
        each_s = (self.weight * self.planned_s + elapsed_s) / (self.weight + self.done)
        return timedelta(seconds=left * each_s)


class Lines:
    """Writes lines to a stream; a screen that has gone away (a closed terminal, ``| head``) never stops a run."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._is_gone = False

    def __call__(self, line: str) -> None:
        if self._is_gone:
            return
        try:
            print(line, file=self._stream, flush=True)
        except OSError:
            self._is_gone = True


class PlainLines:
    """One line a state, a rejection, and a twentieth of the run."""

    def __init__(self, write: Callable[[str], None], parts: int = 20) -> None:
        self._write = write
        self._parts = parts
        self._shown_part = -1

    def on_event(self, progress: Progress) -> None:
        part = self._parts * progress.dwells_done // max(progress.dwells_planned, 1)
        if progress.event == "dwell" and part == self._shown_part:
            return
        if progress.event == "dwell":
            self._shown_part = part
        self._write(line_of(progress))


@contextmanager
def shown_on(stream: TextIO) -> Iterator[RunObserver]:
    """Yield an observer that draws on ``stream``: a live bar where it is a terminal, plain lines otherwise."""
    if not stream.isatty():
        yield PlainLines(Lines(stream))
        return
    with _bar_on(stream) as observer:
        yield observer


@contextmanager
def _bar_on(stream: TextIO) -> Iterator[RunObserver]:
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[told]}"))
    with Bar(*columns, TimeElapsedColumn(), console=Console(file=stream), refresh_per_second=5) as bar:
        task = bar.add_task("planned", total=None, told="")

        class Drawn:
            def on_event(self, progress: Progress) -> None:
                figures = line_of(progress).partition(" · ")[2]
                bar.update(
                    task,
                    description=str(progress.state),
                    total=progress.dwells_planned,
                    completed=progress.dwells_done,
                    told="" if progress.event in ("rejected", "void") else figures,
                )
                if progress.event in ("rejected", "void"):
                    bar.console.print(progress.message, markup=False, highlight=False)

        yield Drawn()
