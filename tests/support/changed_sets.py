"""Sets written by hand: a document changed and sealed again, so that only its meaning is wrong."""

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ams.sets.canonical import render, with_checksum
from ams.sets.coefficients import CoefficientSet


def changed(coefficients: CoefficientSet, change: Callable[[dict[str, Any]], object]) -> dict[str, Any]:
    """The sealed document after the change."""
    document = copy.deepcopy(coefficients.document)
    change(document)
    return with_checksum(document)


def write_changed(path: Path, coefficients: CoefficientSet, change: Callable[[dict[str, Any]], object]) -> Path:
    """An intact JSON file of the changed document."""
    path.write_bytes(render(changed(coefficients, change)))
    return path
