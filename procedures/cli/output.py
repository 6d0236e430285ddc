"""How a command speaks: one JSON document on standard output, or text for a person."""

import json
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from shutil import get_terminal_size
from textwrap import fill
from typing import Any, TextIO

from procedures.cli.standard_streams import let_go_of
from rig.plain_text import shown

_NARROWEST = 20
"""Columns; a terminal that tells fewer does not know them."""


def print_json(document: Mapping[str, Any]) -> None:
    """Print one JSON document, strict (no NaN), UTF-8, ended by a newline."""
    print(json.dumps(document, ensure_ascii=False, allow_nan=False))  # noqa: T201


def say(text: str = "") -> None:
    """Print a line for a person on standard output."""
    print(shown(text))  # noqa: T201


def say_paragraph(text: str) -> None:
    """Print sentences for a person on standard output, broken between words where a terminal would break inside one.

    What is no terminal gets them as one line.
    """
    say(_between_words(shown(text), sys.stdout))


def say_lines(lines: Iterable[str]) -> None:
    """Print lines for a person on standard output, those too long for a terminal broken as :func:`say_paragraph` does.

    What is broken goes on four columns further in than its line begins.
    """
    for line in lines:
        for part in shown(line).split("\n"):
            say(_between_words(part, sys.stdout, " " * (len(part) - len(part.lstrip()) + 4)))


def _between_words(text: str, stream: TextIO, further: str = "") -> str:
    if not stream.isatty():
        return text
    width = max(get_terminal_size().columns, _NARROWEST)
    return fill(
        text,
        width,
        subsequent_indent=further,
        break_long_words=False,
        break_on_hyphens=False,
        replace_whitespace=False,
    )


def note(text: str) -> None:
    """Print a line for a person that is no result on standard error."""
    with suppress(OSError):  # a closed terminal must not end what is being done
        print(shown(text), file=sys.stderr, flush=True)  # noqa: T201


def note_paragraph(text: str) -> None:
    """Print sentences as :func:`note`, broken as :func:`say_paragraph` does."""
    note(_between_words(shown(text), sys.stderr))


@contextmanager
def telling_what_is_done(folder: Path) -> Iterator[None]:
    """Inside, what is done already is told on standard output; where that takes nothing, the telling ends and no more.

    ``folder``: of the run, where all of it stands.
    """
    try:
        yield
        sys.stdout.flush()
    except OSError as error:
        let_go_of(sys.stdout)
        if not isinstance(error, BrokenPipeError):  # `calrig … | head` has read what it wanted
            note(f"standard output: {error.strerror}; everything is written; calrig solve {folder} tells it again")
