"""``calrig attitude``: readings of a calibrated package to angles with standard deviations, from a file or a stream."""

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from shutil import copyfileobj
from tempfile import SpooledTemporaryFile
from typing import IO, Annotated, Final, cast

from cyclopts import Parameter

from ams.inference.aided_rates import AidedAngles
from ams.inference.angle_stream import AngleStream
from ams.inference.inference import MODEL, Package, inference
from ams.inputs.number_blocks import csv_blocks, parquet_blocks
from ams.whole_file import whole_file
from procedures.cli.attitude_lines import is_line, opened_source, opened_target
from procedures.cli.attitude_rows import JsonRows, Rows, writer_named
from procedures.cli.attitude_source import Named, OfGyros, OfSamples, angles_of_gyros, package_of
from procedures.cli.attitude_stream import answer_stream
from procedures.cli.options import require_folder_of
from procedures.cli.output import note
from procedures.errors import RequestError

_IN_MEMORY_BYTES: Final = 1 << 26
"""Of answers for standard output that wait until the last row is read; more wait on the disk."""


def attitude(
    coefficient_set: Path,
    data: Annotated[str, Parameter(allow_leading_hyphen=True)],
    /,
    *,
    out: str | None = None,
    axis: Named = None,
    model_set: Path | None = None,
    model_axis: Named = None,
    reading_sd_v: float | None = None,
    gravity_mps2: float | None = None,
    upright: bool = True,
    right_wing_down: bool = True,
    intervals: bool = False,
    gyros: OfGyros | None = None,
    samples: OfSamples | None = None,
) -> None:
    """Turn outputs into angles with standard deviations.

    Of accelerometers at rest, row by row; of gyros from a start, sample by sample, with what the angles have grown to
    lack; of gyros and accelerometers together by a Kalman filter. The answer has the columns pitch_deg, pitch_sd_deg,
    roll_deg, roll_sd_deg, for gyros and a sting package yaw_deg and yaw_sd_deg, and flag, one row for each row of the
    data. An angle that the outputs do not tell is an empty cell, and flag names why.

    Parameters
    ----------
    coefficient_set
        A set of accelerometers, one, two or three axes, or of three gyros, of any format.
    data
        A CSV or Parquet file of any size, or - for rows that arrive on standard input, header first; what has arrived
        is answered at once. Also socket://HOST:PORT and udp://HOST:PORT.
    out
        The file to write, .csv, .jsonl (JSON lines) or .parquet, or udp://HOST:PORT for JSON lines in datagrams; by
        default CSV on standard output.
    axis
        AXIS=COLUMN where the columns are not called x_v, y_v, z_v; only the axes named are used.
    model_set
        With a sting package: the set of the model package, for roll as well; its columns are model_x_v and so on.
    model_axis
        AXIS=COLUMN for the model package.
    reading_sd_v
        Standard deviation of one reading where the set is used; by default the calibration's standard error.
    gravity_mps2
        Local gravity where accelerometers are used; by default that of the calibration, which sets are in.
    upright
        Two axes have two answers: roll within ±90° (upright) or beyond.
    right_wing_down
        The same for a package of x and z.
    intervals
        Also pitch_half_95_deg and so on: half-widths of 95 % intervals, by Student's factor for what the calibration
        rests on.
    """
    if not _is_sent(out):
        require_folder_of(_path(out), "--out")
    package = package_of(coefficient_set, axis, "--axis", "")
    if not package.senses_rates:
        package = replace(package, site_gravity_mps2=gravity_mps2)
    second = None if model_set is None else package_of(model_set, model_axis, "--model-axis", "model_", gravity_mps2)
    if model_set is None and model_axis:
        raise RequestError("--model-axis: belongs to --model-set, which is missing")
    geometry = {"upright": upright, "right_wing_down": right_wing_down, "intervals": intervals}
    before = samples or OfSamples()
    angles = _angles_of(package, second, reading_sd_v, gyros or OfGyros(), before, gravity_mps2, geometry)
    found = before.before(angles)
    if package.model == MODEL:
        note(f"{package.coefficients.sensor}: a model package alone: yaw is taken as 0")
    if data == "-":
        _answer_stream(found, sys.stdin.buffer, out)
    elif is_line(data):
        with opened_source(data) as source:
            _answer_stream(found, source, out)
    else:
        _answer_file(found, Path(data), out)
    if isinstance(angles, AidedAngles):
        note(angles.consistency())


def _angles_of(
    package: Package,
    second: Package | None,
    reading_sd_v: float | None,
    settings: OfGyros,
    before: OfSamples,
    gravity_mps2: float | None,
    geometry: Mapping[str, bool],
) -> AngleStream:
    """Return what makes angles of the sets. Raises: RequestError, OutsideValidity, SetError."""
    if not package.senses_rates:
        settings.refuse_for(package.model)
        before.refuse_idle_rate()
        return inference(package, second, reading_sd_v, **geometry)
    if second is not None:
        raise RequestError("--model-set: belongs to a sting package of accelerometers, got a set of gyros")
    if geometry != {"upright": True, "right_wing_down": True, "intervals": False}:
        raise RequestError("--intervals, --no-upright, --no-right-wing-down: belong to accelerometers, got gyros")
    return angles_of_gyros(package, reading_sd_v, settings, before.rate_hz, gravity_mps2)


def _answer_stream(found: AngleStream, source: IO[bytes], out: str | None) -> None:
    """Block by block, into a file as well: what was answered stays when the stream breaks."""
    if out is None:
        answer_stream(
            found, lambda columns: (writer_named(None, sys.stdout.buffer, columns), sys.stdout.buffer), source
        )
        return
    if is_line(out):
        with opened_target(out) as target:
            answer_stream(found, lambda columns: (JsonRows(target, columns), target), source)
        return
    if out.endswith(".parquet"):
        raise RequestError(f"--out {out}: a stream is written as .csv or .jsonl; nothing was written")
    with Path(out).open("wb") as file:
        answer_stream(found, lambda columns: (writer_named(Path(out), file, columns), file), source)


def _answer_file(found: AngleStream, data: Path, out: str | None) -> None:
    """Answer a file piece by piece; nothing is written where one of them is wrong."""
    read = parquet_blocks if data.suffix == ".parquet" else csv_blocks
    with _output(out) as target:
        writer = JsonRows(target, found.answers) if _is_sent(out) else writer_named(_path(out), target, found.answers)
        for readings in read(data, found.needed, found.optional):
            writer.write(Rows.of(found.answer(readings)))
            if _is_sent(out):
                target.flush()
        writer.write(Rows.of(found.finish()))
        writer.close()


def _is_sent(out: str | None) -> bool:
    return out is not None and is_line(out)


def _path(out: str | None) -> Path | None:
    return None if out is None else Path(out)


@contextmanager
def _output(out: str | None) -> Iterator[IO[bytes]]:
    """Yield what becomes the file, or goes to standard output, when all is written."""
    if out is not None and is_line(out):
        with opened_target(out) as target:
            yield target
        return
    if out is not None:
        with whole_file(Path(out)) as file:
            yield file
        return
    with SpooledTemporaryFile(max_size=_IN_MEMORY_BYTES) as memory:
        yield cast(IO[bytes], memory)
        memory.seek(0)
        copyfileobj(memory, sys.stdout.buffer)
        sys.stdout.buffer.flush()
