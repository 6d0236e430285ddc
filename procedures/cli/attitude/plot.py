"""Answers kept for a picture: of however many rows, so many that a picture shows, evenly taken."""

from pathlib import Path
from typing import Final

import numpy as np

from ams.whole_file import write_whole
from procedures.cli.attitude.rows import Rows, RowWriter
from procedures.errors import RequestError
from procedures.report.attitude_figure import attitude_figure

MOST_ROWS: Final = 20_000


class PlottedRows:
    """Answers that are written and, when the last has come, drawn."""

    def __init__(self, sensor: str, plot: Path, writer: RowWriter) -> None:
        if plot.suffix != ".svg":
            raise RequestError(f"--plot {plot}: the name must end in .svg; nothing was written")
        self.sensor, self.plot = sensor, plot
        self._writer = writer
        self._every, self._seen = 1, 0
        self._row: list[np.ndarray] = []
        self._columns: dict[str, list[np.ndarray]] = {}
        self._is_flagged: list[np.ndarray] = []

    def write(self, rows: Rows) -> None:
        """Write rows and keep every so many of them; twice as few wherever the picture is full."""
        self._writer.write(rows)
        number = self._seen + np.arange(rows.indices.size)
        self._seen += rows.indices.size
        kept = np.flatnonzero(number % self._every == 0)
        self._row.append(number[kept])
        self._is_flagged.append(rows.indices[kept] > 0)
        for name, values in rows.columns.items():
            self._columns.setdefault(name, []).append(values[kept])
        if sum(part.size for part in self._row) > MOST_ROWS:
            self._halve()

    def close(self) -> None:
        """Finish what is written, and draw. Raises: WriteFailed."""
        self._writer.close()
        row = np.concatenate([np.empty(0, dtype=np.int64), *self._row])
        if not row.size:
            return
        columns = {name: np.concatenate(parts) for name, parts in self._columns.items()}
        write_whole(self.plot, attitude_figure(self.sensor, row, columns, np.concatenate(self._is_flagged)).svg)

    def discard(self) -> None:
        """End without a picture."""
        self._writer.discard()

    def _halve(self) -> None:
        self._every *= 2
        row = np.concatenate(self._row)
        kept = np.flatnonzero(row % self._every == 0)
        self._row = [row[kept]]
        self._is_flagged = [np.concatenate(self._is_flagged)[kept]]
        self._columns = {name: [np.concatenate(parts)[kept]] for name, parts in self._columns.items()}
