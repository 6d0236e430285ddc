"""``calrig attitude``: readings of a calibrated package to angles with standard deviations, from a file or a stream."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import copyfileobj
from tempfile import SpooledTemporaryFile
from typing import IO, Annotated, Final, cast

from cyclopts import Parameter

from ams.exports.formats import load_set
from ams.inference.inference import MODEL, Inference, Package, inference
from ams.inputs.number_blocks import csv_blocks, parquet_blocks
from ams.whole_file import whole_file
from procedures.cli.attitude_rows import Rows, writer_named
from procedures.cli.attitude_stream import answer_stream
from procedures.cli.options import require_folder_of
from procedures.cli.output import note
from procedures.errors import RequestError

_IN_MEMORY_BYTES: Final = 1 << 26
"""Of answers for standard output that wait until the last row is read; more wait on the disk."""
Named = Annotated[list[str] | None, Parameter(negative=())]


def attitude(
    coefficient_set: Path,
    data: Annotated[str, Parameter(allow_leading_hyphen=True)],
    /,
    *,
    out: Path | None = None,
    axis: Named = None,
    model_set: Path | None = None,
    model_axis: Named = None,
    reading_sd_v: float | None = None,
    upright: bool = True,
    right_wing_down: bool = True,
    intervals: bool = False,
) -> None:
    """Turn outputs into angles with standard deviations.

    The answer has the columns pitch_deg, pitch_sd_deg, roll_deg, roll_sd_deg, for a sting package yaw_deg and
    yaw_sd_deg, and flag, one row for each row of the data. An angle that the outputs do not tell is an empty cell, and
    flag names why.

    Parameters
    ----------
    coefficient_set
        A set of one, two or three axes, of any format.
    data
        A CSV or Parquet file of any size, or - for rows that arrive on standard input, header first; what has arrived
        is answered at once.
    out
        The file to write, .csv, .jsonl (JSON lines) or .parquet; by default CSV on standard output.
    axis
        AXIS=COLUMN where the columns are not called x_v, y_v, z_v; only the axes named are used.
    model_set
        With a sting package: the set of the model package, for roll as well; its columns are model_x_v and so on.
    model_axis
        AXIS=COLUMN for the model package.
    reading_sd_v
        Standard deviation of one reading where the set is used; by default the calibration's standard error.
    upright
        Two axes have two answers: roll within ±90° (upright) or beyond.
    right_wing_down
        The same for a package of x and z.
    intervals
        Also pitch_half_95_deg and so on: half-widths of 95 % intervals, by Student's factor for what the calibration
        rests on.
    """
    require_folder_of(out, "--out")
    package = package_of(coefficient_set, axis, "--axis", "")
    second = None if model_set is None else package_of(model_set, model_axis, "--model-axis", "model_")
    if model_set is None and model_axis:
        raise RequestError("--model-axis: belongs to --model-set, which is missing")
    found = inference(
        package, second, reading_sd_v, upright=upright, right_wing_down=right_wing_down, intervals=intervals
    )
    if package.model == MODEL:
        note(f"{package.coefficients.sensor}: a model package alone: yaw is taken as 0")
    if data == "-":
        _answer_stream(found, out)
    else:
        _answer_file(found, Path(data), out)


def package_of(path: Path, pairs: list[str] | None, option: str, prefix: str) -> Package:
    """Return the set of a file with the columns of its axes.

    Raises: RequestError for a pair that is none; SetError.
    """
    coefficients = load_set(path)
    coefficients.check_vectors(str(path))
    columns: dict[str, str] = {}
    for pair in pairs or [f"{axis}={prefix}{axis}_v" for axis in coefficients.axes]:
        name, _, column = pair.partition("=")
        if name not in coefficients.axes or not column or name in columns:
            raise RequestError(
                f"{option} {pair}: allowed is AXIS=COLUMN, each of {', '.join(coefficients.axes)} at most once"
            )
        columns[name] = column
    return Package(coefficients, columns)


def _answer_stream(found: Inference, out: Path | None) -> None:
    """Block by block, into a file as well: what was answered stays when the stream breaks."""
    if out is None:
        answer_stream(found, lambda columns: (writer_named(None, sys.stdout.buffer, columns), sys.stdout.buffer))
        return
    if out.suffix == ".parquet":
        raise RequestError(f"--out {out}: a stream is written as .csv or .jsonl; nothing was written")
    with out.open("wb") as target:
        answer_stream(found, lambda columns: (writer_named(out, target, columns), target))


def _answer_file(found: Inference, data: Path, out: Path | None) -> None:
    """Answer a file piece by piece; nothing is written where one of them is wrong."""
    read = parquet_blocks if data.suffix == ".parquet" else csv_blocks
    with _output(out) as target:
        writer = writer_named(out, target, found.answers)
        for readings in read(data, found.needed, ("temperature_degc",)):
            writer.write(Rows.of(found.answer(readings)))
        writer.close()


@contextmanager
def _output(out: Path | None) -> Iterator[IO[bytes]]:
    """Yield what becomes the file, or goes to standard output, when all is written."""
    if out is not None:
        with whole_file(out) as file:
            yield file
        return
    with SpooledTemporaryFile(max_size=_IN_MEMORY_BYTES) as memory:
        yield cast(IO[bytes], memory)
        memory.seek(0)
        copyfileobj(memory, sys.stdout.buffer)
        sys.stdout.buffer.flush()
