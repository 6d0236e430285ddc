"""What a text may hold that people and programs are to read: what is seen, and nothing that turns the reading.

One definition for everything that is typed, read from a file, or drawn: refused where a text comes in, shown as a code
point where an older record or a device holds it all the same. How long a text may be, and how many marks one letter may
carry, is refused only: a page can show what an older record holds of it.
"""

import unicodedata
from itertools import groupby

_JOINERS = "\u200c\u200d"
"""Not seen themselves, but Persian, the scripts of India and emoji are written with them."""
_SEEN_FORMATS = (
    *range(0x0600, 0x0606), 0x06DD, 0x070F, 0x0890, 0x0891, 0x08E2, 0x110BD, 0x110CD, *range(0x13430, 0x13440)
)  # fmt: skip
"""Signs around numbers and groups of hieroglyphs: formats by their category, and seen."""
_FILLERS = "\u034f\u115f\u1160\u17b4\u17b5\u2065\u3164\uffa0"
"""Letters and marks by their category, and never seen."""
_UNSEEN = frozenset([*_FILLERS, *map(chr, range(0xFFF0, 0xFFF9)), *map(chr, range(0xE0000, 0xE1000))]) - frozenset(
    map(chr, range(0xE0100, 0xE01F0))
)
"""Default ignorable by Unicode's DerivedCoreProperties, beside formats; variation selectors choose a form, and stay."""
_SEEN = frozenset([*_JOINERS, *map(chr, _SEEN_FORMATS)])
_BREAKS = "\n\r\t\u2028\u2029"
_NONCHARACTERS = range(0xFDD0, 0xFDF0)
"""And the last two of every plane: never a letter, and not for exchange (Unicode 23.7)."""
LONGEST_NAME, LONGEST_TEXT, LONGEST_OF_FILE = 200, 2_000, 10_000
"""Letters of who says something, of what somebody says, and of one value in a file."""
MOST_MARKS = 30
"""On one letter: "significantly beyond what is required for any linguistic or technical usage", as no script stacks a
third of it. Source: Unicode Standard Annex 15, Stream-Safe Text Format.
"""
BYTE_ORDER_MARK = "\ufeff"
"""What Windows' editor and spreadsheets put in front of a text in UTF-8: no part of it."""
PARAGRAPHS = _LAYOUT = "\n\t"
"""Of a text of several lines."""


def is_hidden(letter: str) -> bool:
    """Return whether a letter acts on the screen instead of being seen there, or is not seen at all.

    Controls, line separators, marks of direction, halves of a pair, noncharacters and invisible letters do.
    """
    if letter in _UNSEEN or _is_noncharacter(ord(letter)):
        return True
    return letter not in _SEEN and unicodedata.category(letter) in ("Cc", "Cf", "Cs", "Zl", "Zp")


def _is_noncharacter(number: int) -> bool:
    return number & 0xFFFE == 0xFFFE or number in _NONCHARACTERS


def hidden_in(text: str, kept: str = "") -> tuple[str, ...]:
    """Return the names of letters that a text from outside must not hold; those ``kept`` are allowed."""
    if text.isprintable() and not _UNSEEN.intersection(text):
        return ()
    found = (letter for letter in text if letter not in kept and is_hidden(letter))
    return tuple(dict.fromkeys(code_point(letter) for letter in found))


def text_complaint(text: str, kept: str = "", longest: int = LONGEST_TEXT) -> str:
    """Return what is wrong with a text from outside, as the end of a sentence; empty where nothing is.

    ``kept``: hidden letters that it may hold all the same; ``longest``: how many letters it may have.
    """
    if len(text) > longest:
        return f"has {len(text)} letters, allowed are {longest}; shorten it"
    if (marks := _most_marks(text)) > MOST_MARKS:
        return f"has {marks} marks on one letter, allowed are {MOST_MARKS}; leave them out"
    found = hidden_in(text, kept)
    if not found:
        return ""
    if set(found) <= {code_point(letter) for letter in _BREAKS}:
        return f"holds {', '.join(found)}, a line break or a tab; write it in one line"
    return f"holds {', '.join(found)}, which nobody sees, or which acts on a screen; leave it out"


def _most_marks(text: str) -> int:
    most = 0
    for is_mark, marks in groupby(
        () if text.isascii() else text, lambda letter: unicodedata.category(letter)[0] == "M"
    ):
        most = max(most, sum(1 for _ in marks)) if is_mark else most
    return most


def shown(text: str, kept: str = _LAYOUT) -> str:
    """Return the text with each hidden letter as its code point; those ``kept`` stay as they are."""
    if text.isprintable() and not _UNSEEN.intersection(text):
        return text
    return "".join(code_point(letter) if letter not in kept and is_hidden(letter) else letter for letter in text)


def one_line(text: str) -> str:
    """Return the text as :func:`shown`, with line breaks and tabs shown as well.

    Nothing in a list can pass for another line of it.
    """
    return shown(text, kept="")


def code_point(letter: str) -> str:
    """Return a letter's code point, ``<U+202E>``: letters that every font and every terminal has."""
    return f"<U+{ord(letter):04X}>"
