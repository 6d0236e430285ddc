"""Observations from a CSV file.

Columns: ``replication,point,pitch_deg,roll_deg[,yaw_deg][,temperature_degc][,time_s],<name>_v…``, in any order.

Every refusal names file, line (the header is line 1) and column. Degrees become radians here and nowhere else.
"""

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ams.errors import ObservationsError
from ams.observations import Observations

FloatArray = NDArray[np.float64]

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_WHOLE = re.compile(r"\d{1,15}(\.0*)?", re.ASCII)
_OPTIONAL = ("yaw_deg", "temperature_degc", "time_s")
_LARGEST_SPREAD_DEG = 0.5
"""Attitudes of one point may differ by what a servo mechanism repeats to; more is another point."""
_LARGEST_ANGLE_DEG = 360.0
_COLDEST_DEGC = -273.15


@dataclass(frozen=True)
class _Table:
    file: str
    columns: tuple[str, ...]
    lines: tuple[int, ...]
    """Line of the file at which each row ends."""
    rows: tuple[tuple[str, ...], ...]

    def column(self, name: str) -> list[str]:
        place = self.columns.index(name)
        return [row[place].strip() for row in self.rows]


def read_csv(path: str | Path, axes: Mapping[str, str], angles: Sequence[str] = ("pitch", "roll")) -> Observations:
    """Read observations; ``axes`` maps a sensor axis label to its column, such as ``{"x": "sx_v"}``.

    ``angles`` are the angles that the file must state; with ``("pitch",)`` a file without roll_deg has roll 0°.

    Raises:
        ObservationsError: the file cannot be read or says something impossible; nothing was solved.
    """
    table = _parse(Path(path))
    _refuse_missing_columns(table, axes, angles)
    numbers = {name: _numbers(table, name) for name in (*_present(table, angles), *axes.values())}
    labels = {name: _labels(table, name) for name in ("replication", "point")}
    _refuse_repeated(table, labels)
    _refuse_impossible(table, numbers)
    _refuse_wandering_points(table, labels["point"], numbers)
    pitch = np.deg2rad(numbers["pitch_deg"])
    yaw_deg = numbers.get("yaw_deg")
    return Observations(
        replication=labels["replication"],
        point=labels["point"],
        pitch_rad=pitch,
        roll_rad=np.deg2rad(numbers["roll_deg"]) if "roll_deg" in numbers else np.zeros_like(pitch),
        outputs_v={label: numbers[column] for label, column in axes.items()},
        yaw_rad=None if yaw_deg is None else np.deg2rad(yaw_deg),
        temperature_degc=numbers.get("temperature_degc"),
        time_s=numbers.get("time_s"),
        source=str(path),
    )


def unit_warnings(observations: Observations) -> tuple[str, ...]:
    """Columns whose numbers can hardly be in the unit of their name, each in a sentence."""
    warnings = []
    angles = {"pitch_deg": observations.pitch_rad, "roll_deg": observations.roll_rad}
    widest_deg = max(float(np.rad2deg(np.abs(angle).max())) for angle in angles.values())
    irregular = any(_looks_like_radians(np.rad2deg(angle)) for angle in angles.values())
    if 0.0 < widest_deg <= 2.0 * np.pi and irregular:
        warnings.append(
            f"{observations.source}: columns pitch_deg and roll_deg: no angle is above {widest_deg:.4g}° and the steps "
            "are fractions of π: radians? nothing was converted"
        )
    for label, output in observations.outputs_v.items():
        largest = float(np.abs(output).max())
        if largest > 100.0:
            warnings.append(
                f"{observations.source}: output {label}: up to {largest:.4g} V: millivolts? nothing was converted"
            )
    return tuple(warnings)


def _looks_like_radians(angle_deg: FloatArray) -> bool:
    """Whole degrees come out when the numbers are taken as radians, and do not as they stand."""
    as_radians = np.rad2deg(angle_deg)
    moved = angle_deg[np.abs(angle_deg) > 0.0]
    if moved.size == 0:
        return False
    is_whole = np.abs(as_radians - np.round(as_radians)) < 1e-3
    stands = np.abs(angle_deg * 1e3 - np.round(angle_deg * 1e3)) < 1e-7
    return bool(is_whole.mean() > 0.9 and stands.mean() < 0.5)


def _present(table: _Table, angles: Sequence[str]) -> tuple[str, ...]:
    wanted = [f"{angle}_deg" for angle in ("pitch", "roll", *angles)]
    return tuple(name for name in dict.fromkeys((*wanted, *_OPTIONAL)) if name in table.columns)


def _read_text(path: Path) -> str:
    try:
        content = path.read_bytes()
    except OSError as failure:
        reason = failure.strerror or str(failure)
        raise ObservationsError(
            f"{path}: cannot be read: {reason}; nothing was solved; name a readable file"
        ) from failure
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as failure:
        line = content.count(b"\n", 0, failure.start) + 1
        raise ObservationsError(
            f"{path}: line {line}: not UTF-8: byte 0x{content[failure.start]:02x}; nothing was solved; "
            "save the file as CSV UTF-8"
        ) from failure


def _parse(path: Path) -> _Table:
    text = _read_text(path)
    if "\x00" in text:
        line = text.count("\n", 0, text.index("\x00")) + 1
        raise ObservationsError(
            f"{path}: line {line}: a NUL character: not a CSV file; nothing was solved; export it as CSV"
        )
    reader = csv.reader(StringIO(text, newline=""), strict=True)
    lines, rows = [], []
    try:
        for cells in reader:
            if any(cell.strip() for cell in cells):
                lines.append(reader.line_num)
                rows.append(tuple(cells))
    except csv.Error as failure:
        raise ObservationsError(
            f"{path}: line {reader.line_num}: not a CSV line ({failure}); nothing was solved; correct the line"
        ) from failure
    if not rows:
        raise ObservationsError(
            f"{path}: empty: no header and no rows; nothing was solved; export the observations again"
        )
    columns = tuple(cell.strip() for cell in rows[0])
    table = _Table(str(path), columns, tuple(lines[1:]), tuple(rows[1:]))
    _refuse_shape(table)
    return table


def _refuse_shape(table: _Table) -> None:
    if len(table.columns) == 1 and re.search(r"[;\t]", table.columns[0]):
        character = "semicolons" if ";" in table.columns[0] else "tabs"
        raise ObservationsError(
            f"{table.file}: line 1: columns are separated by {character}; allowed: commas, with decimal points; "
            "nothing was solved; export with comma and point, not with the local separators"
        )
    for name in table.columns:
        if table.columns.count(name) > 1:
            raise ObservationsError(
                f"{table.file}: line 1: column {name!r} stands {table.columns.count(name)} times; allowed once; "
                "nothing was solved; rename or remove one"
            )
    if not table.rows:
        raise ObservationsError(
            f"{table.file}: a header and no rows; nothing was solved; export the observations again"
        )
    for line, row in zip(table.lines, table.rows, strict=True):
        if len(row) != len(table.columns):
            raise ObservationsError(
                f"{table.file}: line {line}: {len(row)} cells, allowed {len(table.columns)} as in the "
                f"header; nothing was "
                "solved; complete the line (a decimal comma splits a number in two, a cut file ends in the middle)"
            )


def _refuse_missing_columns(table: _Table, axes: Mapping[str, str], angles: Sequence[str]) -> None:
    if not axes:
        raise ObservationsError(f"{table.file}: no sensor axis was named; nothing was solved; name at least one column")
    wanted = ("replication", "point", *(f"{angle}_deg" for angle in angles), *axes.values())
    missing = [name for name in dict.fromkeys(wanted) if name not in table.columns]
    if missing:
        raise ObservationsError(
            f"{table.file}: line 1: column {' and '.join(map(repr, missing))} missing; found: "
            f"{', '.join(table.columns)}; "
            "nothing was solved; add the column or name another"
        )


def _refuse_cell(table: _Table, name: str, line: int, cell: str, allowed: str) -> None:
    what = "the cell is empty" if cell == "" else f"got {cell!r}"
    raise ObservationsError(
        f"{table.file}: line {line}: column {name}: {what}, allowed {allowed}; nothing was solved; "
        f"correct or remove the row"
    )


def _numbers(table: _Table, name: str) -> FloatArray:
    cells = table.column(name)
    for line, cell in zip(table.lines, cells, strict=True):
        if _NUMBER.fullmatch(cell) is None:
            _refuse_cell(table, name, line, cell, "a finite number with a decimal point")
    values = np.array([float(cell) for cell in cells])
    if not np.isfinite(values).all():
        row = int(np.flatnonzero(~np.isfinite(values))[0])
        _refuse_cell(table, name, table.lines[row], cells[row], "a finite number with a decimal point")
    return values


def _labels(table: _Table, name: str) -> NDArray[np.int64]:
    cells = table.column(name)
    for line, cell in zip(table.lines, cells, strict=True):
        if _WHOLE.fullmatch(cell) is None:
            _refuse_cell(table, name, line, cell, "a whole number, 0 or more")
    return np.array([int(cell.partition(".")[0]) for cell in cells], dtype=np.int64)


def _refuse_repeated(table: _Table, labels: Mapping[str, NDArray[np.int64]]) -> None:
    seen: dict[tuple[int, int], int] = {}
    for line, replication, point in zip(table.lines, labels["replication"], labels["point"], strict=True):
        pair = (int(replication), int(point))
        if pair in seen:
            raise ObservationsError(
                f"{table.file}: line {line}: columns replication and point: replication {pair[0]}, point "
                f"{pair[1]} stands on "
                f"line {seen[pair]} already; allowed once; nothing was solved; remove one or give it a label of its own"
            )
        seen[pair] = line


def _refuse_impossible(table: _Table, numbers: Mapping[str, FloatArray]) -> None:
    for name, values in numbers.items():
        if name.endswith("_deg"):
            outside, allowed = np.abs(values) > _LARGEST_ANGLE_DEG, "−360° to 360°"
        elif name.endswith("_degc"):
            outside, allowed = values < _COLDEST_DEGC, "−273.15 °C or more"
        else:
            continue
        if outside.any():
            row = int(np.flatnonzero(outside)[0])
            _refuse_cell(table, name, table.lines[row], f"{values[row]:g}", allowed)


def _refuse_wandering_points(table: _Table, point: NDArray[np.int64], numbers: Mapping[str, FloatArray]) -> None:
    _, first, index = np.unique(point, return_index=True, return_inverse=True)
    for name in (column for column in ("pitch_deg", "roll_deg", "yaw_deg") if column in numbers):
        off = np.mod(numbers[name] - numbers[name][first][index] + 180.0, 360.0) - 180.0
        if np.abs(off).max() > _LARGEST_SPREAD_DEG:
            row = int(np.argmax(np.abs(off)))
            raise ObservationsError(
                f"{table.file}: line {table.lines[row]}: column {name}: point {point[row]} has "
                f"{numbers[name][row]:g}° here and "
                f"{numbers[name][first][index][row]:g}° on line {table.lines[int(first[index[row]])]}; "
                f"allowed a difference up to "
                f"{_LARGEST_SPREAD_DEG:g}°; nothing was solved; correct the angle or the point label"
            )
