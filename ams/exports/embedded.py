"""The whole document inside the comments of a text format, so that nothing is lost where the format holds little.

It is the document as JSON in plain ASCII, cut into lines; characters that mean something to a compiler, a macro
processor or a comment's end are written as JSON's own escapes, so that joining the lines gives JSON again.
"""

import json
import textwrap

from ams.errors import SetError
from ams.exports.checksum_line import INTACT
from ams.exports.json_text import parsed
from ams.sets.coefficients import CoefficientSet, from_document

LINE_WIDTH = 100
MARK = "document_json| "
RISKY = "*$?@%&<>"
PAIRS = (("*/", "* /"), ("/*", "/ *"), ("$(", "$ ("), ("${", "$ {"), ("??", "? ?"))


def document_lines(coefficients: CoefficientSet) -> list[str]:
    """Return the document as comment lines, each beginning with the mark."""
    text = json.dumps(coefficients.document, separators=(",", ":"), allow_nan=False)
    for letter in RISKY:
        text = text.replace(letter, f"\\u{ord(letter):04x}")
    return [MARK + text[start : start + LINE_WIDTH] for start in range(0, len(text), LINE_WIDTH)]


def document_from(body: bytes, before: str, where: str) -> CoefficientSet:
    """Return the set in the marked lines of a file, each with ``before`` in front. Raises: SetError."""
    begin = before + MARK
    lines = [line[len(begin) :] for line in body.decode("ascii", "replace").split("\n") if line.startswith(begin)]
    if not lines:
        raise SetError(f"{where}: has no line that begins with {begin!r}: the set itself is missing; {INTACT}")
    return from_document(parsed("".join(lines).encode(), f"{where}: document_json"), where)


def comment_lines(texts: list[str]) -> list[str]:
    """Return the texts as lines of a comment.

    They are ASCII, wrapped, without anything that ends a comment or calls a macro.
    """
    return [line for text in texts for line in textwrap.wrap(harmless(text), LINE_WIDTH, subsequent_indent="    ")]


def harmless(text: str) -> str:
    """Return the text in printable ASCII on one line, with risky pairs of characters set apart."""
    plain = " ".join(text.split()).encode("ascii", "backslashreplace").decode()
    plain = "".join(letter if letter.isprintable() else "?" for letter in plain)
    for pair, apart in PAIRS:
        plain = plain.replace(pair, apart)
    return plain
