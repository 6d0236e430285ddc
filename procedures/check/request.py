"""A design asked for on the command line, in the words of its options."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from pydantic import ValidationError

from procedures.description import procedure_file
from procedures.description.procedure_file import Range
from procedures.errors import PlanError, RequestError
from procedures.plan import designs
from procedures.plan.design_kind import DESIGNS, DesignKind, Wanted
from procedures.plan.designs import Design

LEVEL_DEG = (0.0,)
Given = TypeVar("Given")


@dataclass(frozen=True, slots=True)
class DesignRequest:
    """The options of ``calrig design`` that say which design is meant."""

    kind: str | None = None
    """Default: ``fractional`` where a fraction is given, ``file`` where a file is, else ``D1``, and ``D0`` for a list
    of pitch values."""
    pitch: str | None = None
    """``from:to:count`` or ``from/to/step``, degrees."""
    pitch_list: str | None = None
    """``a,b,…`` in degrees; a value may stand more than once."""
    roll: str | None = None
    """A count, uniform on [−180°, 180° − ΔR], or a range as for pitch. Without it, or with one value, there is no
    roll."""
    repeat_roll: bool = False
    fractional: str | None = None
    """``Ka,KR``."""
    usage: str | None = None
    """``from:to``, pitch in degrees."""
    file: Path | None = None


def requested_design(request: DesignRequest) -> Design:
    """Return the design of a request.

    Raises: RequestError naming the option, PlanError for sets that the kind forbids.
    """
    kind = _kind(request)
    _refuse_of_other_kinds(request, kind)
    if "pitch_deg" not in kind.takes:
        owner = "--file" if "file" in kind.takes else f"--kind {kind.name}"
        _refuse_beside(request, owner, "pitch", "pitch_list", *(("roll",) if "file" in kind.takes else ()))
        path = _needed(request.file, "--file", "the path of a CSV file") if "file" in kind.takes else None
        table: dict[str, object] = {} if path is None else {"file": str(path)}
    else:
        table = {"pitch_deg": _pitch(request), "roll_deg": _roll(request)}
        if "fractional" in kind.takes:
            text = _needed(request.fractional, "--fractional", "Ka,KR such as 3,4")
            parts = text.split(",")
            if len(parts) != 2:
                raise _wrong("--fractional", text, "Ka,KR such as 3,4")
            table["fractional"] = _count(parts[0], "--fractional"), _count(parts[1], "--fractional")
    with_roll = request.roll is None or len(_roll(request)) > 1
    return kind.made(Wanted(_table(kind, table), with_roll, Path()))


def requested_usage_deg(request: DesignRequest) -> tuple[float, float] | None:
    """Return the pitch range of later use, in degrees, or None. Raises: RequestError."""
    if request.usage is None:
        return None
    low, high = _numbers(request.usage, ":", "--usage", "from:to such as -30:30", 2)
    if not low < high:
        raise _wrong("--usage", request.usage, "from:to with from below to")
    return low, high


def kinds() -> list[str]:
    """Return what ``--kind`` allows."""
    return [name for name, kind in DESIGNS.items() if kind.is_on_command_line]


def _kind(request: DesignRequest) -> DesignKind:
    if request.kind is not None and request.kind not in kinds():
        raise _wrong("--kind", request.kind, ", ".join(kinds()))
    if request.kind is not None:
        return DESIGNS[request.kind]
    if request.fractional is not None:
        return DESIGNS["fractional"]
    if request.file is not None:
        return DESIGNS["file"]
    return DESIGNS["D1" if request.pitch_list is None else "D0"]


def _table(kind: DesignKind, values: dict[str, object]) -> procedure_file.Design:
    try:
        return procedure_file.Design.model_validate({"kind": kind.name, **values})
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(part) for part in first["loc"])
        raise RequestError(f"design: {where}: {first['msg'].removeprefix('Value error, ')}") from None


def _pitch(request: DesignRequest) -> tuple[float, ...]:
    if (request.pitch is None) == (request.pitch_list is None):
        raise RequestError("design: give either --pitch=from:to:count or --pitch-list=a,b,…")
    if request.pitch is not None:
        return _range(request.pitch, "--pitch")
    assert request.pitch_list is not None
    return tuple(_numbers(request.pitch_list, ",", "--pitch-list", "degrees separated by commas", None))


def _roll(request: DesignRequest) -> tuple[float, ...]:
    if request.roll is None:
        return LEVEL_DEG
    if ":" in request.roll or "/" in request.roll:
        values = _range(request.roll, "--roll")
    else:
        count = _count(request.roll, "--roll")
        values = designs.uniform_circle_deg(count) if count > 1 else LEVEL_DEG
    return designs.with_repeated_roll(values) if request.repeat_roll and len(values) > 1 else values


def _range(text: str, option: str) -> tuple[float, ...]:
    allowed = "from:to:count such as -45:45:33, or from/to/step such as -90/90/10"
    by_step = "/" in text
    start, stop, last = _numbers(text, "/" if by_step else ":", option, allowed, 3)
    try:
        if by_step:
            return Range.model_validate({"from": start, "to": stop, "step": last}).values()
        return Range.model_validate({"from": start, "to": stop, "count": int(last) if last % 1 == 0 else last}).values()
    except ValidationError as error:
        reason = error.errors(include_url=False)[0]["msg"].removeprefix("Value error, ")
        raise RequestError(f"design: {option}: got {text!r}: {reason}; allowed {allowed}") from None


def _count(text: str, option: str) -> int:
    if not text.strip().isdecimal() or not 1 <= int(text) <= 100_000:
        raise _wrong(option, text, "a whole number of 1 or more")
    return int(text)


def _numbers(text: str, separator: str, option: str, allowed: str, count: int | None) -> Sequence[float]:
    parts = text.split(separator)
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        raise _wrong(option, text, allowed) from None
    if (count is not None and len(parts) != count) or not all(abs(number) <= 100_000.0 for number in numbers):
        raise _wrong(option, text, allowed)
    return numbers


def _needed(given: Given | None, option: str, what: str) -> Given:
    if given is None:
        raise RequestError(f"design: {option}: is missing; give {what}")
    return given


def _refuse_of_other_kinds(request: DesignRequest, kind: DesignKind) -> None:
    """Refuse the options that a kind would not read."""
    for key in ("fractional", "file", "repeat_roll"):
        if getattr(request, key) in (None, False) or key in kind.takes:
            continue
        *others, last = (name for name in kinds() if key in DESIGNS[name].takes)
        owners = f"{', '.join(others)} or {last}" if others else last
        raise RequestError(f"design: --{key.replace('_', '-')}: belongs to --kind {owners}, not to --kind {kind.name}")
    if request.repeat_roll and len(_roll(request)) == 1:
        raise RequestError("design: --repeat-roll: belongs to --roll of more than one value, which is missing")


def _refuse_beside(request: DesignRequest, owner: str, *others: str) -> None:
    for other in others:
        if getattr(request, other) is not None:
            raise RequestError(f"design: --{other.replace('_', '-')}: has no meaning beside {owner}; leave one out")


def _wrong(option: str, text: str, allowed: str) -> PlanError | RequestError:
    return RequestError(f"design: {option}: got {text!r}, allowed {allowed}")
