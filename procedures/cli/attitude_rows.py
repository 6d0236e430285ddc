"""Rows of angles as text."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any


def csv_lines(names: Sequence[str], answer: Mapping[str, Any]) -> Iterator[str]:
    """Header and one line a row."""
    yield ",".join(names) + "\n"
    yield from row_lines(names, answer)


def row_lines(names: Sequence[str], answer: Mapping[str, Any]) -> Iterator[str]:
    """Yield one line a row; what is not a number is an empty cell."""
    for row in zip(*(answer[name] for name in names), strict=True):
        yield ",".join(cell if isinstance(cell, str) else _cell(cell) for cell in row) + "\n"


def _cell(value: float) -> str:
    return "" if value != value else f"{value:.9g}"
