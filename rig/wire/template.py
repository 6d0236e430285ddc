"""Line templates that work both ways: written with fields filled in, and recognised with the fields read out.

A template is text with named fields, such as ``{axis} MOVE {target_deg:+09.4f}``. What a field may hold follows from
its name, and from the format for a number: exactly as many decimals, sign and zeros as it says, so that a shortened
or damaged number is no number. Recognition is of the whole line or not at all.

An angle is written in degrees (``target_deg``), in the machine's counts (``target_counts``), or as whole degrees,
minutes and seconds (``target_d``, ``target_m``, ``target_s``); a status as words, or as one word of bits: decimal
(``{status:d}``), hexadecimal (``{status:x}``), or as ones and noughts with the first bit at the right
(``{status:08b}``) or at the left (``{status:08l}``). ``{position_deg:g}`` takes any number of decimals: for a machine
whose manual does not say how many it writes. What a meter of angles reads is a number of its own unit (``x``, ``y``).
"""

import re
from collections.abc import Iterator, Mapping
from string import Formatter

FieldValue = int | float | str

ANGLES = ("target", "position")
_PATTERNS = {
    "text": r".*",
    "words": r"[A-Za-z0-9_]+(?: [A-Za-z0-9_]+)*",
    "serial": r"[^\r\n,]{1,40}",
    "unit": r"[^\s,;]{1,8}",
}
_STATUS = {
    "d": r"\d{1,10}",
    "x": r"[0-9A-Fa-f]{1,8}",
    "X": r"[0-9A-Fa-f]{1,8}",
    "b": r"[01_]{1,40}",
    "l": r"[01_]{1,40}",
}
_NUMBER_FORMAT = re.compile(r"(?P<sign>\+?)(?P<zeros>0\d+)?\.(?P<decimals>\d)f")
_ANY_DECIMALS, _FREE_NUMBER = "g", r"[+-]?\d{1,7}(?:\.\d{1,9})?"
_NUMBERS = ("rate_dps", "speed_dps", "x", "y")
_WHOLE_FORMAT = re.compile(r"(?P<sign>\+?)(?P<zeros>0\d+)?d")
_MORE_DIGITS = 6
"""Before the point than a format asks for: a number that is longer is noise."""
_ALLOWED = (
    "axis, text, words, serial, unit, status, rate_dps, speed_dps, x, y, and target or position with _deg, _counts, _d,"
    " _m, _s"
)


class Template:
    """One line of a dialect. Raises: ValueError where the text is no template."""

    def __init__(self, text: str, counts_per_deg: float | None = None) -> None:
        self.text = text
        self._counts_per_deg = counts_per_deg
        self._pieces = [(literal, name, spec or "") for literal, name, spec, _ in Formatter().parse(text)]
        self.fields = frozenset(name for _, name, _ in self._pieces if name)
        self._pattern = re.compile("".join(self._patterns()))
        if counts_per_deg is None and any(name.endswith("_counts") for name in self.fields):
            raise ValueError("counts need counts_per_turn in the dialect")

    def _patterns(self) -> Iterator[str]:
        """Yield the pattern of every piece; a field that stands twice holds the same text twice."""
        seen: set[str] = set()
        for literal, name, spec in self._pieces:
            yield f"{re.escape(literal)}(?P={name})" if name in seen else _piece(literal, name, spec)
            seen |= {name} if name else set()

    def render(self, **fields: FieldValue) -> str:
        """Return the line, without terminator. Angles are given in degrees, ``status`` as a number."""
        return "".join(literal + self._written(name, spec, fields) for literal, name, spec in self._pieces)

    def match(self, line: str) -> dict[str, FieldValue] | None:
        """Return the fields of ``line``, angles in degrees, or None where it is another line."""
        found = self._pattern.fullmatch(line)
        if found is None:
            return None
        groups = found.groupdict()
        specs = {name: spec for _, name, spec in self._pieces if name}
        values: dict[str, FieldValue] = {}
        for name, text in groups.items():
            angle = name.partition("_")[0]
            if angle in ANGLES:
                values[f"{angle}_deg"] = self._degrees(angle, groups)
            elif name == "status":
                values[name] = _status(text.replace("_", ""), specs[name][-1])
            elif name in _NUMBERS:
                values[name] = float(text)
            else:
                values[name] = int(text) if name == "axis" else text
        return values

    def _written(self, name: str | None, spec: str, fields: Mapping[str, FieldValue]) -> str:
        if name is None:
            return ""
        angle, _, part = name.partition("_")
        if angle in ANGLES and part != "deg":
            value_deg = float(fields[f"{angle}_deg"])
            if part == "counts":
                assert self._counts_per_deg is not None
                return format(round(value_deg * self._counts_per_deg), spec)
            seconds = round(abs(value_deg) * 3600.0, 1)
            minutes, rest_s = divmod(seconds, 60.0)
            degrees, rest_m = divmod(int(minutes), 60)
            if part == "m":
                return format(rest_m, spec)
            if part == "s":
                return format(int(rest_s) if spec.endswith("d") else rest_s, spec)
            written = format(degrees, spec)  # the sign of -0° 30' is not that of a number
            return written if value_deg >= 0.0 else "-" + written.removeprefix("+")
        if spec == _ANY_DECIMALS:
            return format(float(fields[name]) + 0.0, ".4f")
        if spec.endswith("l"):
            return format(int(fields[name]), spec[:-1] + "b")[::-1]
        return format(fields[name], spec)

    def _degrees(self, angle: str, groups: Mapping[str, str]) -> float:
        if (text := groups.get(f"{angle}_deg")) is not None:
            return float(text)
        if (text := groups.get(f"{angle}_counts")) is not None:
            assert self._counts_per_deg is not None
            return int(text) / self._counts_per_deg
        whole = groups.get(f"{angle}_d", "0")
        size = abs(int(whole)) + float(groups.get(f"{angle}_m", 0)) / 60.0 + float(groups.get(f"{angle}_s", 0)) / 3600.0
        return -size if whole.startswith("-") else size


def _status(text: str, kind: str) -> int:
    if kind in "bl":
        return int(text[::-1] if kind == "l" else text, 2)
    return int(text, 10 if kind == "d" else 16)


def _piece(literal: str, name: str | None, spec: str) -> str:
    if name is None:
        return re.escape(literal)
    angle, _, part = name.partition("_")
    if name == "axis":
        pattern: str | None = r"\d{1,2}"
    elif name in _NUMBERS or (angle in ANGLES and part in ("deg", "s") and not spec.endswith("d")):
        pattern = _number_pattern(spec)
    elif angle in ANGLES and part in ("counts", "d", "m", "s"):
        found = _WHOLE_FORMAT.fullmatch(spec)
        if found is None:
            raise ValueError(f"a whole number needs a format such as {{target_counts:+07d}}, got {spec!r}")
        pattern = _digits(found, 0)
    elif name == "status":
        if spec[-1:] not in _STATUS:
            raise ValueError(f"a status needs a format d, x, b or l such as {{status:x}}, got {spec!r}")
        pattern = _STATUS[spec[-1]]
    else:
        pattern = _PATTERNS.get(name)
    if pattern is None:
        raise ValueError(f"unknown field {{{name}}} (allowed: {_ALLOWED})")
    return f"{re.escape(literal)}(?P<{name}>{pattern})"


def _number_pattern(spec: str) -> str:
    if spec == _ANY_DECIMALS:
        return _FREE_NUMBER
    found = _NUMBER_FORMAT.fullmatch(spec)
    if found is None:
        raise ValueError(f"a number needs a format such as {{target_deg:+09.4f}}, got {spec!r}")
    decimals = int(found["decimals"])
    point = decimals + 1 if decimals else 0
    return _digits(found, point) + (rf"\.\d{{{decimals}}}" if decimals else "")


def _digits(found: re.Match[str], behind: int) -> str:
    whole = max(int(found["zeros"] or 0) - behind - len(found["sign"]), 1)
    longest = whole + _MORE_DIGITS
    if found["sign"]:
        return rf"[+-]\d{{{whole},{longest}}}"
    below_zero = max(whole - 1, 1)  # a minus takes the place of a nought
    return rf"(?:-\d{{{below_zero},{longest}}}|\d{{{whole},{longest}}})"
