"""Line templates that work both ways: written with fields filled in, and recognised with the fields read out.

A template is text with named fields, such as ``{axis} MOVE {target_deg:+09.4f}``. What a field may hold follows from
its name, and from the format for a number: exactly as many decimals, sign and zeros as it says, so that a shortened
or damaged number is no number. Recognition is of the whole line or not at all.
"""

import re
from string import Formatter

FieldValue = int | float | str

_PATTERNS = {"axis": r"\d{1,2}", "text": r".*", "words": r"[A-Za-z0-9_]+(?: [A-Za-z0-9_]+)*"}
_NUMBER_FORMAT = re.compile(r"(?P<sign>\+?)(?P<zeros>0\d+)?\.(?P<decimals>\d)f")
_MORE_DIGITS = 6
"""Before the point than a format asks for: a number that is longer is noise."""


class Template:
    """One line of a dialect. Raises: ValueError where the text is no template."""

    def __init__(self, text: str) -> None:
        self.text = text
        pieces = [_piece(literal, name, spec or "") for literal, name, spec, _ in Formatter().parse(text)]
        self.fields = frozenset(name for _, name in pieces if name)
        self._pattern = re.compile("".join(pattern for pattern, _ in pieces))

    def render(self, **fields: FieldValue) -> str:
        """Return the line, without terminator."""
        return self.text.format(**fields)

    def match(self, line: str) -> dict[str, FieldValue] | None:
        """Return the fields of ``line``, or None where it is another line."""
        found = self._pattern.fullmatch(line)
        return None if found is None else {name: _value(name, text) for name, text in found.groupdict().items()}


def _piece(literal: str, name: str | None, spec: str) -> tuple[str, str]:
    if name is None:
        return re.escape(literal), ""
    pattern = _number_pattern(spec) if name.endswith("_deg") else _PATTERNS.get(name)
    if pattern is None:
        raise ValueError(f"unknown field {{{name}}} (allowed: axis, target_deg, position_deg, words, text)")
    return f"{re.escape(literal)}(?P<{name}>{pattern})", name


def _number_pattern(spec: str) -> str:
    found = _NUMBER_FORMAT.fullmatch(spec)
    if found is None:
        raise ValueError(f"a number needs a format such as {{target_deg:+09.4f}}, got {spec!r}")
    decimals = int(found["decimals"])
    sign = "[+-]" if found["sign"] else "-?"
    places = int(found["zeros"] or 0) - decimals - 1 - len(found["sign"])
    whole = max(places, 1)
    return rf"{sign}\d{{{whole},{whole + _MORE_DIGITS}}}" + (rf"\.\d{{{decimals}}}" if decimals else "")


def _value(name: str, text: str) -> FieldValue:
    if name.endswith("_deg"):
        return float(text)
    return int(text) if name == "axis" else text
