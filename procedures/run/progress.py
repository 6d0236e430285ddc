"""How far a run is, told to whoever draws it: a Rich bar in a terminal, plain lines elsewhere."""

import io
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import timedelta
from typing import TextIO, cast

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar

from procedures.records.progress import Progress, RunObserver, line_of
from rig.plain_text import one_line


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


class Unbreakable(io.TextIOBase):
    """A stream on which nothing raises once the terminal behind it has gone away."""

    def __init__(self, stream: TextIO) -> None:
        super().__init__()
        self._stream = stream

    def write(self, text: str) -> int:
        with suppress(OSError, ValueError):
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        with suppress(OSError, ValueError):
            self._stream.flush()

    def isatty(self) -> bool:
        return self._stream.isatty()

    @property
    def encoding(self) -> str:  # type: ignore[override]
        return self._stream.encoding

    def fileno(self) -> int:
        return self._stream.fileno()


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
    console = Console(file=cast(TextIO, Unbreakable(stream)))
    with Bar(*columns, TimeElapsedColumn(), console=console, refresh_per_second=5) as bar:
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
                    bar.console.print(one_line(progress.message), markup=False, highlight=False)

        yield Drawn()
