"""Errors of an axis that its certificate lists at angles: a file beside the rig file, kept whole in the description.

``angle_deg`` are the machine's own angles, as on its scale; ``error_arcsec`` is where it truly stands less what it
shows; ``uncertainty_arcsec`` is stated as the axis' own (a limit unless its standard says otherwise).
"""

import csv
from collections.abc import Iterable
from itertools import pairwise
from math import isclose, isfinite
from pathlib import Path

from rig.errors import DescriptionError
from rig.toml_file import StrictTable

COLUMNS = ("angle_deg", "error_arcsec", "uncertainty_arcsec")
FULL_TURN_DEG = 360.0
_SAME_INDEX_DEG = 1e-5
_SAME_NUMBER = 1e-9
"""As a part of it, and in arc seconds: two rows of one index that were computed, not copied."""
_LARGEST_STEP = 1.5
_FEWEST_OF_A_TURN = 3
"""Two indices, and the first again."""

_FAR = 4.0
"""Standard uncertainties: of normal errors one in 16 000 lies farther out."""
_OF_ALL_ERRORS = {
    "limit": "a limit: no index error is larger",
    "standard": "a standard uncertainty; 4 of them are allowed",
    "expanded": "an expanded uncertainty; 4 standard ones are allowed",
}


class IndexTable(StrictTable):
    """The rows of such a file."""

    file: str
    angle_deg: tuple[float, ...]
    error_arcsec: tuple[float, ...]
    uncertainty_arcsec: tuple[float, ...]


def read_index_table(path: Path, limits_deg: tuple[float, float]) -> IndexTable:
    """Read the list of an axis that goes to ``limits_deg``.

    Raises: DescriptionError naming file, line and column of the first thing that is wrong.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise DescriptionError(f"{path}: cannot be read: {error}; give the path relative to the rig file") from None
    rows = list(csv.reader(lines))
    if not rows or tuple(cell.strip() for cell in rows[0]) != COLUMNS:
        got = ", ".join(rows[0]) if rows else "an empty file"
        raise DescriptionError(f"{path}:1: header: got {got}, allowed {','.join(COLUMNS)}; correct the first line")
    filled = [(number, cells) for number, cells in enumerate(rows[1:], start=2) if cells]
    values = [_numbers(path, number, cells) for number, cells in filled]
    complaint = next(iter(_complaints([number for number, _ in filled], values, limits_deg)), None)
    if complaint is not None:
        raise DescriptionError(f"{path}:{complaint}")
    kept = values[:-1] if _spans_turn(values) else values
    angle_deg, error_arcsec, uncertainty_arcsec = zip(*kept, strict=True)
    return IndexTable(
        file=path.name, angle_deg=angle_deg, error_arcsec=error_arcsec, uncertainty_arcsec=uncertainty_arcsec
    )


def beyond_declared(rows: IndexTable, uncertainty_arcsec: float, kind: str, k: float) -> str | None:
    """Return where a list contradicts what the axis declares of all its index errors; None where it does not.

    What lies between the listed angles is known by that declaration alone: one that is too small would make every
    attitude between them better known than it is. ``kind`` and ``k``: of the standard that stands behind it.
    """
    allowed_arcsec = uncertainty_arcsec * {"limit": 1.0, "standard": _FAR, "expanded": _FAR / k}[kind]
    listed = zip(rows.angle_deg, rows.error_arcsec, rows.uncertainty_arcsec, strict=True)
    excesses = [(abs(error) - of_list - allowed_arcsec, angle, error) for angle, error, of_list in listed]
    excess_arcsec, angle_deg, error_arcsec = max(excesses)
    if excess_arcsec <= 0.0:
        return None
    return (
        f"{rows.file} lists an error of {error_arcsec:g}″ at {angle_deg:g}°, which uncertainty_arcsec = "
        f"{uncertainty_arcsec:g} ({_OF_ALL_ERRORS[kind]}) does not allow; nothing else says how large the errors are "
        "between the listed angles: give the uncertainty of all index errors, or correct the list"
    )


def _numbers(path: Path, line: int, cells: list[str]) -> tuple[float, float, float]:
    if len(cells) != len(COLUMNS):
        raise DescriptionError(f"{path}:{line}: got {len(cells)} cells, allowed {len(COLUMNS)}: {', '.join(COLUMNS)}")
    found = []
    for column, cell in zip(COLUMNS, cells, strict=True):
        try:
            value = float(cell)
        except ValueError:
            value = float("nan")
        if not isfinite(value) or (column == COLUMNS[2] and value < 0.0):
            allowed = "0 or more" if column == COLUMNS[2] else "a finite number"
            raise DescriptionError(f"{path}:{line}: {column}: got {cell.strip() or 'nothing'}, allowed {allowed}")
        found.append(value)
    return found[0], found[1], found[2]


def _complaints(
    lines: list[int], values: list[tuple[float, float, float]], limits_deg: tuple[float, float]
) -> Iterable[str]:
    angles = [row[0] for row in values]
    if len(angles) < 2:
        yield f"1: got {len(angles)} angles, allowed 2 or more; list the certificate's angles"
        return
    for line, (before, angle) in zip(lines[1:], pairwise(angles), strict=True):
        if angle - before < _SAME_INDEX_DEG:
            yield f"{line}: angle_deg: got {angle:g} after {before:g}, allowed rising angles; sort the rows by angle"
    span_deg = angles[-1] - angles[0]
    if span_deg > FULL_TURN_DEG + _SAME_INDEX_DEG:
        yield (
            f"{lines[-1]}: angle_deg: got {angles[0]:g} to {angles[-1]:g}, allowed at most one turn: the axis has one "
            "error at each index, however often it goes round; list each index once"
        )
    elif _spans_turn(values):
        yield from _disagreeing_ends(lines[-1], values)
        return
    step_deg = max(after - before for before, after in pairwise(angles))
    goes_round = FULL_TURN_DEG - span_deg <= _LARGEST_STEP * step_deg
    if not goes_round and not (angles[0] <= limits_deg[0] and limits_deg[1] <= angles[-1]):
        is_within_a_turn = limits_deg[1] - limits_deg[0] < FULL_TURN_DEG
        or_limits = f" or the axis' limits {limits_deg[0]:g} to {limits_deg[1]:g}" if is_within_a_turn else ""
        or_narrower = ", or narrow limits_deg" if is_within_a_turn else ""
        yield (
            f"{lines[-1]}: angle_deg: got {angles[0]:g} to {angles[-1]:g}, needed are the whole turn (such as -180 to "
            f"180, both ends written or one){or_limits}; add the angles that are missing{or_narrower}"
        )


def _spans_turn(values: list[tuple[float, float, float]]) -> bool:
    """Tell whether the last row is the index of the first, a turn on."""
    return abs(values[-1][0] - values[0][0] - FULL_TURN_DEG) <= _SAME_INDEX_DEG


def _disagreeing_ends(line: int, values: list[tuple[float, float, float]]) -> Iterable[str]:
    """Yield what two rows say of one index where they disagree."""
    start, end = values[0], values[-1]
    if len(values) < _FEWEST_OF_A_TURN:
        yield f"{line}: angle_deg: got one index, {start[0]:g} and {end[0]:g}, allowed 2 or more; list those between"
    for column, at_start, at_end in zip(COLUMNS[1:], start[1:], end[1:], strict=True):
        if not isclose(at_start, at_end, rel_tol=_SAME_NUMBER, abs_tol=_SAME_NUMBER):
            yield (
                f"{line}: {column}: got {at_end:.10g} at {end[0]:g} and {at_start:.10g} at {start[0]:g}, allowed the "
                "same: the two are one index; correct one, or remove the row"
            )
