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

from ams.calibration.calibrate import calibrate
from ams.frames import specific_force
from ams.inference.inference import Inference, Package, inference
from ams.inputs.number_blocks import csv_blocks, parquet_blocks
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.provenance import Provenance
from bench.attitude import best_s
from bench.figure import Effort, Figure
from procedures.cli.attitude.rows import CsvRows, JsonRows, ParquetRows, Rows
from procedures.cli.attitude.stream import answer_stream

K = np.array([[2.5, 0.02, -0.03], [0.01, -2.4, 0.04], [-0.02, 0.03, 2.6]])
OFFSET_V = np.array([0.01, -0.02, 0.03])
NOISE_V = 1e-5
Writer = type[CsvRows] | type[JsonRows] | type[ParquetRows]
COLUMNS = {axis: f"{axis}_v" for axis in "xyz"}


def figures(effort: Effort) -> Iterator[Figure]:
    """Rates of files, streams and numbers in memory."""
    rows = effort.amount(500_000, 2_000)
    rng = np.random.default_rng(1)
    pitch, roll = rng.uniform(-1.2, 1.2, rows), rng.uniform(-3.0, 3.0, rows)
    outputs = OFFSET_V + specific_force(pitch, roll) @ K.T + NOISE_V * rng.normal(size=(rows, 3))
    frame = pd.DataFrame(outputs, columns=list(COLUMNS.values()))
    line = inference(Package(_set("no"), COLUMNS), reading_sd_v=NOISE_V)
    bent = inference(Package(_set("yes"), COLUMNS), reading_sd_v=NOISE_V)
    readings = {name: np.ascontiguousarray(frame[name], dtype=float) for name in COLUMNS.values()}
    for what, found, target in (("straight", line, 5.0), ("with terms of second and third order", bent, 0.5)):
        yield Figure(
            f"angles in memory, set {what}", rows / best_s(_answering(found, readings)) / 1e6, "M/s", target,
            at_most=False,
        )  # fmt: skip
    with TemporaryDirectory() as folder:
        yield from _files(line, frame, Path(folder))
    yield from _writing(line, readings)
    yield from _streams(line, frame, effort)


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
    yield Figure("Parquet read and solved", rows / parquet_s / 1e6, "M/s", 2.0, at_most=False)


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
        own_s = best_s(partial(_rewrite, writer, found, rows))
        note = f"{own_s / alone_s:.1f} × pyarrow writing CSV alone, digits and all" if what == "CSV" else ""
        yield Figure(f"{what} written", file.tell() / 1e6 / own_s, "MB/s", target, at_most=False, note=note)


def _rewrite(writer: Writer, found: Inference, rows: Rows) -> None:
    _write(writer, io.BytesIO(), found, rows)


def _write(writer: Writer, file: io.BytesIO, found: Inference, rows: Rows) -> None:
    own = writer(file, found.answers)
    own.write(rows)
    own.close()


def _streams(found: Inference, frame: pd.DataFrame, effort: Effort) -> Iterator[Figure]:
    rows = effort.amount(200_000, 500)
    text = frame.head(rows).to_csv(index=False).encode()
    batched_s = best_s(lambda: _stream(found, io.BytesIO(text)))
    yield Figure("stream, as fast as it comes", rows / batched_s, "/s", 50_000.0, at_most=False)
    few = effort.amount(500, 20)
    lines = frame.head(few).to_csv(index=False).encode().splitlines(keepends=True)
    alone_s = best_s(lambda: _stream(found, _LineByLine(lines)))
    yield Figure("stream, a row that comes alone", alone_s / few * 1e3, "ms", 20.0, at_most=True)


class _LineByLine(io.BytesIO):
    """A source that has one more line at every look."""

    def __init__(self, lines: list[bytes]) -> None:
        super().__init__()
        self._lines = iter(lines)

    def read1(self, size: int | None = -1, /) -> bytes:  # noqa: ARG002 a line is shorter
        return next(self._lines, b"")


def _stream(found: Inference, source: io.BytesIO) -> None:
    target = io.BytesIO()
    answer_stream(found, lambda columns: (CsvRows(target, columns), target), source)


def _set(extended: Literal["yes", "no"]) -> CoefficientSet:
    """Return a package solved from two replications of a grid."""
    grid = [(p, r) for p in range(-90, 91, 30) for r in range(-180, 180, 60)] * 2
    pitch, roll = np.deg2rad(np.array(grid, dtype=float)).T
    force, count = specific_force(pitch, roll), len(grid) // 2
    rng = np.random.default_rng(2)
    outputs = OFFSET_V + force @ K.T + 1e-4 * force**2 + NOISE_V * rng.normal(size=(len(grid), 3))
    rows = Observations(
        np.repeat([1, 2], count), np.tile(np.arange(count), 2), pitch, roll, dict(zip("xyz", outputs.T, strict=True))
    )
    where = Provenance(
        "BENCH", gravity_mps2=9.80665, gravity_source="none", simulated=True, rig="", procedure="benchmark",
        created_utc=datetime(2026, 1, 1, tzinfo=UTC), software_version=sys.version.split()[0],
        pitch_range_deg=(-90.0, 90.0), roll_range_deg=(-180.0, 180.0),
    )  # fmt: skip
    return build_set(calibrate(rows, CalibrationRequest(extended=extended)), where)
