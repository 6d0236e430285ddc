"""What a jog session leaves behind: every action as a JSON line, and snapshots as rows of a CSV file."""

import csv
import getpass
import io
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path

from procedures.errors import RequestError
from procedures.jog_screen.values import BenchView
from rig.clock import Clock


class ActionLog:
    """JSON lines, appended; each line is on disk before the next thing happens.

    What keeps a line from it is told to ``lose``, once, and raises nothing: who writes may be about to stop an axis.
    """

    def __init__(self, path: Path, clock: Clock) -> None:
        self.path = path
        self.lose: Callable[[str], None] = lambda _why: None
        self._clock = clock
        self._is_lost = False
        try:
            # A page may send half a surrogate pair, which is no text in UTF-8: it is written as JSON escapes it.
            self._file = path.open("ab", buffering=0)
        except OSError as error:
            raise RequestError(
                f"{path}: cannot be written: {error.strerror}; nothing was opened; name another with --log"
            ) from error
        self._who = {"operator": getpass.getuser(), "pid": os.getpid()}

    def write(self, kind: str, **fields: object) -> None:
        stamp = self._clock.now_utc().isoformat(timespec="milliseconds")
        line = {"utc": stamp, "kind": kind, **self._who, **fields}
        data = json.dumps(line, ensure_ascii=False, allow_nan=False).encode("utf-8", errors="backslashreplace") + b"\n"
        if self._is_lost:
            return
        try:
            while data:
                data = data[self._file.write(data) :]
        except OSError as error:
            self._is_lost = True
            self.lose(f"{self.path}: cannot be written: {error.strerror}; nothing moves without a record of it")

    def close(self) -> None:
        self._file.close()


class Snapshots:
    """Rows of one CSV file: time, positions, temperatures, and mean, spread and count of every channel."""

    def __init__(self, path: Path, clock: Clock) -> None:
        self.path = path
        self._clock = clock

    def append(self, view: BenchView) -> int:
        """Write what the view shows; returns the number of the row. Raises: RequestError."""
        row = {"utc": self._clock.now_utc().isoformat(timespec="milliseconds"), **_cells(view)}
        header = ",".join(row)
        try:
            lines = self.path.read_text(encoding="utf-8").splitlines() if self.path.exists() else []
            if lines and lines[0] != header:
                raise RequestError(f"{self.path}: has other columns; nothing was written; name another with --snapshot")
            with self.path.open("a", encoding="utf-8", newline="") as file:
                file.write("" if lines else header + "\n")
                text = io.StringIO()
                csv.writer(text, lineterminator="\n").writerow(row.values())
                file.write(text.getvalue())
        except (OSError, UnicodeDecodeError) as error:
            raise RequestError(f"{self.path}: cannot be written: {error}; name another with --snapshot") from error
        return max(len(lines), 1)


def _cells(view: BenchView) -> Mapping[str, object]:
    cells: dict[str, object] = {}
    for axis in view.axes:
        cells[f"{axis.name}_deg"] = "" if axis.state is None or axis.state.unknown else f"{axis.state.position_deg:.6f}"
    for chamber in view.chambers:
        cells[f"{chamber.name}_degc"] = "" if chamber.temperature_degc is None else f"{chamber.temperature_degc:.4f}"
    for channel in view.channels:
        cells |= {
            f"{channel.name}_{channel.unit}": _number(channel.mean),
            f"{channel.name}_sd_{channel.unit}": _number(channel.standard_deviation),
            f"{channel.name}_n": channel.count,
        }
    for name, degrees, sd_deg in view.attitude.angles if view.attitude else ():
        cells |= {f"inferred_{name}_deg": _number(degrees), f"inferred_{name}_sd_deg": _number(sd_deg)}
    return cells


def _number(value: float) -> str:
    return "" if value != value else f"{value:.10g}"
