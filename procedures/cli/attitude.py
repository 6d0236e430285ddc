"""``calrig attitude``: readings of a calibrated package to angles with standard deviations, from a file or a stream."""

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from io import BytesIO, StringIO
from pathlib import Path
from typing import Annotated, Any, TextIO

import numpy as np
from cyclopts import Parameter

from ams.exports.formats import load_set
from ams.inference.inference import MODEL, Inference, Package, inference
from ams.inputs.csv_table import numbers, parse_csv, refuse_missing_columns
from ams.whole_file import write_whole
from procedures.cli.attitude_rows import csv_lines
from procedures.cli.attitude_stream import answer_stream
from procedures.cli.options import require_folder_of
from procedures.cli.output import note
from procedures.errors import RequestError

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
        A CSV or Parquet file, or - for rows that arrive on standard input, header first; each is answered at once.
    out
        The file to write, CSV or Parquet; by default CSV on standard output.
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
    """Line by line, into a file as well: what was answered stays when the stream breaks."""
    if out is None:
        answer_stream(found, sys.stdout)
        return
    _check_csv(out)
    with out.open("w", encoding="utf-8", newline="") as target:
        answer_stream(found, target)


def _answer_file(found: Inference, data: Path, out: Path | None) -> None:
    readings = _read_parquet(found, data) if data.suffix == ".parquet" else _read_csv(found, data)
    answer = found.infer(readings)
    if out is not None and out.suffix == ".parquet":
        _write_parquet(out, answer)
        return
    with _output(out) as target:
        for line in csv_lines(found.answers, answer):
            target.write(line)


def _read_csv(found: Inference, data: Path) -> dict[str, Any]:
    table = parse_csv(data)
    refuse_missing_columns(table, found.needed)
    optional = [name for name in ("temperature_degc",) if name in table.columns]
    return {name: numbers(table, name) for name in dict.fromkeys((*found.needed, *optional))}


def _read_parquet(found: Inference, data: Path) -> dict[str, Any]:
    arrow = _parquet()
    try:
        table = arrow.read_table(data)
    except (OSError, ValueError) as error:
        raise RequestError(f"{data}: cannot be read as Parquet: {str(error).splitlines()[0]}") from error
    missing = [name for name in found.needed if name not in table.column_names]
    if missing:
        raise RequestError(f"{data}: column {', '.join(missing)} missing; found: {', '.join(table.column_names)}")
    readings = {}
    for name in dict.fromkeys((*found.needed, *({"temperature_degc"} & set(table.column_names)))):
        try:
            readings[name] = np.asarray(table.column(name).to_pandas(), dtype=float)
        except (TypeError, ValueError):
            raise RequestError(f"{data}: column {name}: holds no numbers; nothing was computed") from None
        wrong = np.flatnonzero(~np.isfinite(readings[name]))
        if wrong.size:
            raise RequestError(
                f"{data}: row {int(wrong[0]) + 1}: column {name}: no finite number; nothing was computed"
            )
    return readings


def _write_parquet(out: Path, answer: Mapping[str, Any]) -> None:
    import pandas as pd

    _parquet()
    memory = BytesIO()
    pd.DataFrame({name: list(values) for name, values in answer.items()}).to_parquet(memory, index=False)
    write_whole(out, memory.getvalue())


def _parquet() -> Any:
    if find_spec("pyarrow") is None:
        raise RequestError(
            "Parquet: the library pyarrow is not installed; nothing was written; install calrig[export], or use CSV"
        )
    return import_module("pyarrow.parquet")


@contextmanager
def _output(out: Path | None) -> Iterator[TextIO]:
    """Yield standard output, or a text that becomes the file, whole and synced, when all is written."""
    if out is None:
        yield sys.stdout
        return
    _check_csv(out)

    memory = StringIO()
    yield memory
    write_whole(out, memory.getvalue().encode("utf-8"))


def _check_csv(out: Path) -> None:
    if out.suffix != ".csv":
        raise RequestError(f"--out {out}: the name must end in .csv or, for files, .parquet; nothing was written")
