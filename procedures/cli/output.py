"""How a command speaks: one JSON document on standard output, or text for a person."""

import json
import math
import sys
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from rig.plain_text import shown


def print_json(document: Mapping[str, Any]) -> None:
    """Print one JSON document, strict (no NaN), UTF-8, ended by a newline."""
    print(json.dumps(document, ensure_ascii=False, allow_nan=False))  # noqa: T201


def say(text: str = "") -> None:
    """Print a line for a person on standard output."""
    print(shown(text))  # noqa: T201


def note(text: str) -> None:
    """Print a line for a person that is no result on standard error."""
    with suppress(OSError):  # a closed terminal must not end what is being done
        print(shown(text), file=sys.stderr, flush=True)  # noqa: T201


def finite(value: float | None) -> float | None:
    """JSON has no NaN: what is not finite is null."""
    return None if value is None or not math.isfinite(value) else value
