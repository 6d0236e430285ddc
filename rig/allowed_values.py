"""What may stand in a key of a file, as people read it: in place of a validator's own complaint."""

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from math import isfinite
from re import findall
from types import MappingProxyType
from typing import Any, Final

_TABLE: Final = "a table: keys in braces, or a [section] of its own"
_LIST: Final = "a list in square brackets"
_OF_TYPE: Final[Mapping[str, str]] = MappingProxyType(
    {
        "string_type": "text in quotes",
        "int_type": "a whole number",
        "float_type": "a number",
        "finite_number": "a finite number",
        "bool_type": "true or false",
        "date_type": "a day, such as 2026-03-01, without quotes",
        "tuple_type": _LIST,
        "list_type": _LIST,
        "dict_type": _TABLE,
        "model_type": _TABLE,
    }
)
_OF_BOUND: Final[Mapping[str, str]] = MappingProxyType(
    {
        "literal_error": "{expected}",
        "greater_than": "above {gt}",
        "greater_than_equal": "{ge} or more",
        "less_than": "below {lt}",
        "less_than_equal": "at most {le}",
        "too_short": "{min_length} or more entries",
        "too_long": "at most {max_length} entries",
        "string_too_short": "{min_length} or more characters",
        "string_too_long": "at most {max_length} characters",
        "string_pattern_mismatch": "text of the form {pattern}",
    }
)
_OF_NUMBERS: Final = frozenset(
    {"int_type", "float_type", "finite_number", "greater_than", "greater_than_equal", "less_than", "less_than_equal"}
)


def allowed_in_words(kind: str, context: Mapping[str, Any], bounds: Sequence[object]) -> str | None:
    """Return what is allowed where a validator complains of a ``kind``; None where it says so itself.

    ``bounds``: what the key declares of its numbers, so that a refusal names both ends.
    """
    words = _OF_TYPE.get(kind)
    if words is None and kind in _OF_BOUND:
        words = _OF_BOUND[kind].format(**{name: _as_written(value) for name, value in context.items()})
    interval = _interval(bounds) if kind in _OF_NUMBERS else None
    if words is None or interval is None:
        return words
    return f"{words}, {interval}" if kind in _OF_TYPE else interval


def near_to(given: object, allowed: str) -> str:
    """Return a hint where a word is nearly one of those that stand in quotes in ``allowed``, else nothing."""
    near = get_close_matches(str(given), findall(r"'([^']*)'", allowed), n=1)
    return f"; did you mean {near[0]!r}?" if near else ""


def _interval(bounds: Sequence[object]) -> str | None:
    """Return both ends in words; None where fewer are declared."""
    low = next(((name, value) for name in ("gt", "ge") if (value := _declared(bounds, name)) is not None), None)
    high = next(((name, value) for name in ("lt", "le") if (value := _declared(bounds, name)) is not None), None)
    if low is None or high is None:
        return None
    if (low[0], high[0]) == ("ge", "le"):
        return f"{low[1]} to {high[1]}"
    start = f"above {low[1]}" if low[0] == "gt" else f"{low[1]} or more"
    return f"{start} and {f'below {high[1]}' if high[0] == 'lt' else f'at most {high[1]}'}"


def _declared(bounds: Sequence[object], name: str) -> object | None:
    return next((_as_written(getattr(bound, name)) for bound in bounds if hasattr(bound, name)), None)


def _as_written(value: object) -> object:
    return f"{value:.10g}" if isinstance(value, float) and isfinite(value) else value
