"""Files and streams of readings to angles with a coefficient set, beside what pandas and pyarrow take for them alone.

Processor time of one process; pandas reads and pyarrow writes the same numbers on their own beside it.
"""

import io
import sys
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from ams.calibration.calibrate import calibrate
from ams.frames import specific_force
from ams.inference.inference import Inference, Package, inference
from ams.inputs.number_blocks import csv_blocks, parquet_blocks
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.provenance import Provenance
from bench.attitude import best_s, processor_s
from bench.figure import Effort, Figure
from procedures.cli.attitude.rows import CsvRows, JsonRows, ParquetRows, Rows
from procedures.cli.attitude.stream import answer_stream

K = np.array([[2.5, 0.02, -0.03], [0.01, -2.4, 0.04], [-0.02, 0.03, 2.6]])
OFFSET_V = np.array([0.01, -0.02, 0.03])
NOISE_V = 1e-5
BEND_V = 1e-4
STREAM_ROWS_PER_S = 50_000
Writer = type[CsvRows] | type[JsonRows] | type[ParquetRows]
COLUMNS = {axis: f"{axis}_v" for axis in "xyz"}


def figures(effort: Effort) -> Iterator[Figure]:
    """Rates of files, streams and numbers in memory."""
    rows = effort.amount(500_000, 2_000)
    rng = np.random.default_rng(1)
    pitch, roll = rng.uniform(-1.2, 1.2, rows), rng.uniform(-3.0, 3.0, rows)
    force, noise_v = specific_force(pitch, roll), NOISE_V * rng.normal(size=(rows, 3))
    frame = pd.DataFrame(_outputs_v(force) + noise_v, columns=list(COLUMNS.values()))
    line = inference(Package(_set("no"), COLUMNS), reading_sd_v=NOISE_V)
    bent = inference(Package(_set("yes"), COLUMNS), reading_sd_v=NOISE_V)
    readings = _readings(frame.to_numpy())
    bent_readings = _readings(_outputs_v(force, BEND_V) + noise_v)
    doubtful = {name: values * (1.0 + 3e-5 * (np.arange(rows) % 6 == 0)) for name, values in readings.items()}
    for what, found, columns, target in (
        ("straight", line, readings, 5.0),
        ("straight, a sixth of rows disagree", line, doubtful, 4.0),
        ("with terms of second and third order", bent, bent_readings, 0.5),
    ):
        yield Figure(
            f"angles in memory, set {what}",
            rows / best_s(_answering(found, columns)) / 1e6,
            "M/s",
            target,
            at_most=False,
        )
    with TemporaryDirectory() as folder:
        yield from _files(line, frame, Path(folder))
    yield from _writing(line, readings)
    yield from _streams(line, frame, effort)


def _outputs_v(force: NDArray[np.float64], bend_v: float = 0.0) -> NDArray[np.float64]:
    return np.asarray(OFFSET_V + force @ K.T + bend_v * force**2)


def _readings(outputs_v: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    return dict(zip(COLUMNS.values(), np.ascontiguousarray(outputs_v.T), strict=True))


def _answering(found: Inference, readings: dict[str, NDArray[np.float64]]) -> Callable[[], object]:
    return lambda: found.answer(readings)


def _files(found: Inference, frame: pd.DataFrame, folder: Path) -> Iterator[Figure]:
    csv, parquet = folder / "d.csv", folder / "d.parquet"
    frame.to_csv(csv, index=False)
    frame.to_parquet(parquet)
    megabytes, rows = csv.stat().st_size / 1e6, len(frame)
    pandas_s = best_s(lambda: pd.read_csv(csv))
    csv_s = best_s(lambda: [found.answer(block) for block in csv_blocks(csv, found.needed)])
    parquet_s = best_s(lambda: [found.answer(block) for block in parquet_blocks(parquet, found.needed)])
    note = f"{csv_s / pandas_s:.1f} × pandas reading alone"
    yield Figure("CSV read and solved", megabytes / csv_s, "MB/s", 40.0, at_most=False, note=note)
    pyarrow_s = best_s(lambda: pd.read_parquet(parquet))
    beside = f"{parquet_s / pyarrow_s:.0f} × pyarrow reading alone"
    yield Figure("Parquet read and solved", rows / parquet_s / 1e6, "M/s", 2.0, at_most=False, note=beside)


def _writing(found: Inference, readings: dict[str, NDArray[np.float64]]) -> Iterator[Figure]:
    import pyarrow
    from pyarrow import csv

    rows = Rows.of(found.answer(readings))
    table = pyarrow.table({**rows.columns, "flag": rows.flags})
    alone_s = best_s(lambda: csv.write_csv(table, io.BytesIO()))
    for writer, what, target in (
        (CsvRows, "CSV", 40.0),
        (JsonRows, "JSON lines", 20.0),
        (ParquetRows, "Parquet", 20.0),
    ):
        file = io.BytesIO()
        _write(writer, file, found, rows)
        writer_s = best_s(partial(_rewrite, writer, found, rows))
        note = f"{writer_s / alone_s:.1f} × pyarrow writing CSV alone, digits and all" if what == "CSV" else ""
        yield Figure(f"{what} written", file.tell() / 1e6 / writer_s, "MB/s", target, at_most=False, note=note)


def _rewrite(writer: Writer, found: Inference, rows: Rows) -> None:
    _write(writer, io.BytesIO(), found, rows)


def _write(writer: Writer, file: io.BytesIO, found: Inference, rows: Rows) -> None:
    out = writer(file, found.answers)
    out.write(rows)
    out.close()


def _streams(found: Inference, frame: pd.DataFrame, effort: Effort) -> Iterator[Figure]:
    rows = effort.amount(200_000, 500)
    text = frame.head(rows).to_csv(index=False).encode()
    batched_s = best_s(lambda: _stream(found, io.BytesIO(text)))
    pandas_s = best_s(lambda: pd.read_csv(io.BytesIO(text)))
    note = f"{batched_s / pandas_s:.1f} × pandas reading the same text at once"
    yield Figure("stream, as fast as it comes", rows / batched_s, "/s", 50_000.0, at_most=False, note=note)
    few = effort.amount(500, 20)
    lines = frame.head(few).to_csv(index=False).encode().splitlines(keepends=True)
    alone_s = best_s(lambda: _stream(found, _LineByLine(lines)))
    yield Figure("stream, a row that comes alone", alone_s / few * 1e3, "ms", 20.0, at_most=True)
    at_rate = _LineByRate(frame.head(effort.amount(50_000, 500)).to_csv(index=False).encode(), STREAM_ROWS_PER_S)
    with threadpool_limits(limits=1, user_api="blas"):
        _stream(found, at_rate)
    waited_ms = float(np.percentile(at_rate.waited_s, 99.0)) * 1e3
    yield Figure(f"stream at {STREAM_ROWS_PER_S} rows/s, p99 of the wait", waited_ms, "ms", 20.0, at_most=True)


class _LineByLine(io.BytesIO):
    """A source that has one more line at every look."""

    def __init__(self, lines: list[bytes]) -> None:
        super().__init__()
        self._lines = iter(lines)

    def read1(self, size: int | None = -1, /) -> bytes:  # noqa: ARG002 a line is shorter
        return next(self._lines, b"")


class _LineByRate(io.BytesIO):
    """A source whose rows arrive one by one at a rate, on a clock that runs with the processor.

    What has arrived by now is read together; where nothing has, the clock is put on to the next row.
    """

    def __init__(self, text: bytes, rows_per_s: float) -> None:
        header, *lines = text.splitlines(keepends=True)
        super().__init__()
        self._header, self._lines = header, lines
        self._arrives_s = np.arange(len(lines)) / rows_per_s
        self._read = self._answered = 0
        self._started_s, self._idle_s = processor_s(), 0.0
        self.waited_s = np.empty(len(lines))

    def read1(self, size: int | None = -1, /) -> bytes:  # noqa: ARG002 what has arrived is less
        if self._header:
            header, self._header = self._header, b""
            return header
        now_s = processor_s() - self._started_s + self._idle_s
        self.waited_s[self._answered : self._read] = now_s - self._arrives_s[self._answered : self._read]
        self._answered = self._read
        if self._read == len(self._lines):
            return b""
        if now_s < self._arrives_s[self._read]:
            self._idle_s += self._arrives_s[self._read] - now_s
            now_s = self._arrives_s[self._read]
        self._read = int(np.searchsorted(self._arrives_s, now_s, side="right"))
        return b"".join(self._lines[self._answered : self._read])


def _stream(found: Inference, source: io.BytesIO) -> None:
    target = io.BytesIO()
    answer_stream(found, lambda columns: (CsvRows(target, columns), target), source)


def _set(extended: Literal["yes", "no"]) -> CoefficientSet:
    """Return a package solved from two replications of a grid."""
    grid = [(p, r) for p in range(-90, 91, 30) for r in range(-180, 180, 60)] * 2
    pitch, roll = np.deg2rad(np.array(grid, dtype=float)).T
    force, count = specific_force(pitch, roll), len(grid) // 2
    rng = np.random.default_rng(2)
    bend_v = BEND_V if extended == "yes" else 0.0
    outputs = _outputs_v(force, bend_v) + NOISE_V * rng.normal(size=(len(grid), 3))
    rows = Observations(
        np.repeat([1, 2], count), np.tile(np.arange(count), 2), pitch, roll, dict(zip("xyz", outputs.T, strict=True))
    )
    where = Provenance(
        "BENCH", gravity_mps2=9.80665, gravity_source="none", simulated=True, rig="", procedure="benchmark",
        created_utc=datetime(2026, 1, 1, tzinfo=UTC), software_version=sys.version.split()[0],
        pitch_range_deg=(-90.0, 90.0), roll_range_deg=(-180.0, 180.0),
    )  # fmt: skip
    return build_set(calibrate(rows, CalibrationRequest(extended=extended)), where)
