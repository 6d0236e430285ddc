"""What a text may hold that people and programs are to read: no control, nothing that turns the direction of reading.

One definition for everything that is typed, read from a file, or drawn: refused where a text comes in, shown as a code
point where an older record or a device holds it all the same.
"""

import unicodedata

_TURNS = frozenset("\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
"""Marks, embeddings, overrides and isolates of the bidirectional algorithm (Unicode UAX 9)."""
_LAYOUT = "\n\t"


def is_hidden(letter: str) -> bool:
    """Return whether a letter acts on the screen instead of being seen there.

    Controls, line separators, halves of a pair do.
    """
    return letter in _TURNS or unicodedata.category(letter) in ("Cc", "Cs", "Zl", "Zp")


def hidden_in(text: str) -> tuple[str, ...]:
    """Return the names of letters that a text from outside must not hold; line breaks and tabs are allowed."""
    found = (letter for letter in text if letter not in _LAYOUT and is_hidden(letter))
    return tuple(dict.fromkeys(code_point(letter) for letter in found))


def shown(text: str, kept: str = _LAYOUT) -> str:
    """Return the text with each hidden letter as its code point; those ``kept`` stay as they are."""
    if text.isprintable() and not _TURNS.intersection(text):
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
