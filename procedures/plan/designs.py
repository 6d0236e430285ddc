"""Experimental designs: which attitudes a package is shown, as values that know nothing of rigs and files.

D is any pitch set with any roll set. D0 has its roll set uniform on [−180°, 180° − ΔR], D1 its pitch set uniform and
symmetric about zero as well; the usual bench form repeats the roll point at +180°. T is the tumble test. A fractional
design thins the interior rows and columns of a grid and keeps its borders. Source: TP 4.1, TP 7, figure 21.
"""

import csv
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from procedures.errors import PlanError

TUMBLE_WITH_ROLL_DEG = ((-90.0, 0.0), (0.0, 0.0), (90.0, 0.0), (180.0, 0.0), (0.0, -90.0), (0.0, 90.0))
"""(pitch, roll) of TP (56)."""
TUMBLE_WITHOUT_ROLL_DEG = ((-90.0, 0.0), (0.0, 0.0), (90.0, 0.0), (180.0, 0.0))
"""(pitch, roll) of TP (57)."""
HALF_TURN_DEG = 180.0
FACTORIAL_PITCH_DEG = (-75.0, -25.0, 25.0, 75.0)
"""Not ±90°, where all rolls but a turn are one attitude."""
FACTORIAL_LEVELS = (4, 6)
"""Of pitch and of roll."""
SPACING_TOLERANCE_DEG = 1e-9


@dataclass(frozen=True, slots=True)
class DesignPoint:
    """One attitude of a design."""

    label: int
    """1-based; the same in every replication."""
    pitch_deg: float
    roll_deg: float
    yaw_deg: float = 0.0
    """Of a gimbal, between pitch and roll."""


@dataclass(frozen=True, slots=True)
class Design:
    """A set of attitudes. The order in which they are visited is no part of it."""

    kind: str
    """One of ``calrig.designs``, or ``schedule``: what the kinds with motion, fields and rests plan by themselves."""
    points: tuple[DesignPoint, ...]
    """In the order of their labels, 1 to K."""
    pitch_values_deg: tuple[float, ...]
    """The N pitch values of the grid, ascending; a value may repeat (TP table 1 has 16 points at each of ±30°)."""
    roll_values_deg: tuple[float, ...]
    """The M roll values of the grid, ascending; one value where there is no roll."""
    yaw_values_deg: tuple[float, ...] = (0.0,)
    """Ascending; one value where there is no yaw."""

    @property
    def has_roll(self) -> bool:
        return len(set(self.roll_values_deg)) > 1


def full_grid(pitch_deg: Sequence[float], roll_deg: Sequence[float]) -> Design:
    """Return Design D: every pitch with every roll."""
    return _thinned("D", pitch_deg, roll_deg, lambda _row, _column: True)


def uniform_roll(pitch_deg: Sequence[float], roll_deg: Sequence[float]) -> Design:
    """Design D0. Raises: PlanError unless roll is uniform on [−180°, 180° − ΔR], +180° repeated or not."""
    require_uniform_circle(roll_deg)
    return _thinned("D0", pitch_deg, roll_deg, lambda _row, _column: True)


def uniform_symmetric(pitch_deg: Sequence[float], roll_deg: Sequence[float]) -> Design:
    """Design D1. Raises: PlanError unless roll is as for D0 and pitch is uniform and symmetric about 0°."""
    require_uniform_circle(roll_deg)
    require_uniform_symmetric(pitch_deg)
    return _thinned("D1", pitch_deg, roll_deg, lambda _row, _column: True)


def fractional(pitch_deg: Sequence[float], roll_deg: Sequence[float], every: tuple[int, int]) -> Design:
    """Thin a grid by ``every`` = (K_α, K_R).

    A point stays on every K_α-th pitch, on every K_R-th roll and on the borders. Where the grid divides evenly the
    count is C′ of TP (109).

    Raises: PlanError for a factor below 1, or one so large that no interior row or column would stay.
    """
    for name, factor, values in (("K_alpha", every[0], pitch_deg), ("K_R", every[1], roll_deg)):
        if not 1 <= factor < max(len(values), 2):
            raise PlanError(
                f"fractional design: {name} got {factor}, allowed 1 to {max(len(values) - 1, 1)} for {len(values)} "
                "values; no design was made"
            )
    rows, columns = _kept(len(pitch_deg), every[0]), _kept(len(roll_deg), every[1])
    return _thinned("fractional", pitch_deg, roll_deg, lambda row, column: row in rows or column in columns)


def factorial(pitch_deg: Sequence[float], roll_deg: Sequence[float]) -> Design:
    """24 points: four levels of pitch, which tell a cubic, with six of roll, which tell every term of second order.

    Raises: PlanError for other numbers of levels.
    """
    for name, values, levels in zip(("pitch", "roll"), (pitch_deg, roll_deg), FACTORIAL_LEVELS, strict=True):
        if len(set(values)) != levels or len(values) != levels:
            raise PlanError(
                f"factorial design: {name} got {len(values)} values, allowed are {levels} different ones; no design "
                "was made; use kind D for any other set"
            )
    return _thinned("factorial", pitch_deg, roll_deg, lambda _row, _column: True)


def tumble(with_roll: bool) -> Design:
    """Return Design T: six points with roll, TP (56), or four without, TP (57)."""
    return scattered("T", TUMBLE_WITH_ROLL_DEG if with_roll else TUMBLE_WITHOUT_ROLL_DEG)


def up_down() -> Design:
    """Return SR's two positions of every axis, up and down: the attitudes of the six-point tumble. Source: SR 4.1.1."""
    return scattered("up-down", TUMBLE_WITH_ROLL_DEG)


def with_yaw(design: Design, yaw_deg: Sequence[float]) -> Design:
    """Return every attitude of a design at every yaw, yaw by yaw."""
    yaws = tuple(sorted(set(yaw_deg)))
    turned = [replace(point, yaw_deg=yaw) for yaw in yaws for point in design.points]
    points = tuple(replace(point, label=index) for index, point in enumerate(turned, start=1))
    return replace(design, points=points, yaw_values_deg=yaws)


def scattered(kind: str, attitudes_deg: Sequence[tuple[float, ...]]) -> Design:
    """Return a design of any list of (pitch, roll) or (pitch, roll, yaw), labelled in the order given."""
    points = tuple(DesignPoint(index, *attitude) for index, attitude in enumerate(attitudes_deg, start=1))
    pitch, roll = ({point.pitch_deg for point in points}, {point.roll_deg for point in points})
    yaw = {point.yaw_deg for point in points}
    return Design(kind, points, tuple(sorted(pitch)), tuple(sorted(roll)), tuple(sorted(yaw)))


def read_points(path: Path) -> Design:
    """Read a design from a CSV file.

    Columns: ``pitch_deg`` and, where the package is rolled, ``roll_deg``; on a gimbal also ``yaw_deg``.

    Raises: PlanError naming file and line.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        why = (error.strerror if isinstance(error, OSError) else None) or error
        raise PlanError(f"{path}: the points cannot be read: {why}; no design was made") from None
    try:
        return _of_rows(path, csv.DictReader(text.splitlines()))
    except csv.Error as error:
        raise PlanError(
            f"{path}: not a CSV file ({error}); no design was made; correct it, or export it anew"
        ) from None


def _of_rows(path: Path, reader: "csv.DictReader[str]") -> Design:
    if not {"pitch_deg"} <= set(reader.fieldnames or ()) <= {"pitch_deg", "roll_deg", "yaw_deg"}:
        found = ", ".join(reader.fieldnames or ()) or "nothing"
        raise PlanError(
            f"{path}:1: columns: got {found}, needed pitch_deg and, with roll, roll_deg (a gimbal: yaw_deg)"
        )
    return scattered("file", [_attitude(path, reader.line_num, row) for row in reader] or _no_points(path))


def uniform_circle_deg(count: int, repeat: bool = False) -> tuple[float, ...]:
    """``count`` roll values uniform on [−180°, 180° − 360°/count]; ``repeat`` adds +180°."""
    values = tuple(float(Fraction(360 * index, count) - 180) for index in range(count))
    return with_repeated_roll(values) if repeat else values


def with_repeated_roll(roll_deg: Sequence[float]) -> tuple[float, ...]:
    """Return the roll set with +180° at its end, where it does not stand there already."""
    return tuple(roll_deg) if HALF_TURN_DEG in roll_deg else (*roll_deg, HALF_TURN_DEG)


def require_uniform_circle(roll_deg: Sequence[float]) -> None:
    """Check that a roll set is uniform on [−180°, 180° − ΔR], with +180° or without; one value passes.

    Raises: PlanError.
    """
    values = sorted(roll_deg)
    circle = values[:-1] if values[-1] == HALF_TURN_DEG and len(values) > 1 else values
    if len(values) > 1 and not _agree(circle, uniform_circle_deg(len(circle))):
        raise PlanError(
            f"roll: got {_span(values)}, allowed for D0 and D1 is a set uniform on [−180°, 180° − ΔR], "
            "with +180° repeated or not; no design was made; use kind D for any other set"
        )


def require_uniform_symmetric(pitch_deg: Sequence[float]) -> None:
    """Check that a pitch set is uniform and symmetric about 0°, each value once. Raises: PlanError."""
    values, last = sorted(pitch_deg), len(pitch_deg) - 1
    uniform = [-values[last] + 2.0 * values[last] * index / max(last, 1) for index in range(last + 1)]
    if last < 1 or values[last] <= 0.0 or not _agree(values, uniform):
        raise PlanError(
            f"pitch: got {_span(values)}, allowed for D1 are two or more values uniform and symmetric about 0°; "
            "no design was made; use kind D0 for any other pitch set"
        )


def _thinned(
    kind: str, pitch_deg: Sequence[float], roll_deg: Sequence[float], keeps: Callable[[int, int], bool]
) -> Design:
    pitch, roll = tuple(sorted(pitch_deg)), tuple(sorted(roll_deg))
    kept = [(a, r) for row, a in enumerate(pitch) for column, r in enumerate(roll) if keeps(row, column)]
    points = tuple(DesignPoint(index, *attitude) for index, attitude in enumerate(kept, start=1))
    return Design(kind, points, pitch, roll)


def _kept(count: int, every: int) -> frozenset[int]:
    return frozenset(range(0, count, every)) | {count - 1}


def _agree(values: Sequence[float], wanted: Sequence[float]) -> bool:
    return all(abs(a - b) <= SPACING_TOLERANCE_DEG for a, b in zip(values, wanted, strict=True))


def _span(values: Sequence[float]) -> str:
    return f"{len(values)} values from {values[0]:g}° to {values[-1]:g}°"


def _attitude(path: Path, line: int, row: dict[str, str | None]) -> tuple[float, ...]:
    if None in row:
        raise PlanError(f"{path}:{line}: more values than columns; no design was made")
    columns = ("pitch_deg", "roll_deg", "yaw_deg")
    return tuple(_angle(path, line, row, name) if name in row else 0.0 for name in columns)


def _angle(path: Path, line: int, row: dict[str, str | None], column: str) -> float:
    text = row[column]
    try:
        value = float(text or "")
    except ValueError:
        value = float("nan")
    if not -360.0 <= value <= 360.0:
        raise PlanError(f"{path}:{line}: {column}: got {text!r}, allowed −360 to 360 degrees; no design was made")
    return value


def _no_points(path: Path) -> list[tuple[float, float]]:
    raise PlanError(f"{path}: holds no points; give at least one line of pitch_deg and roll_deg")
