"""Letters on paper: every one is printed or visibly named, whatever somebody is called or has noted.

PDF/A asks for a glyph of every letter, and typst refuses the whole document where one is missing. Its own fonts have
the letters of European languages; DejaVu Sans, which comes with matplotlib, stands behind them with Arabic, Armenian,
Georgian, Hebrew and many signs. What neither has (Chinese, Japanese, Korean, emoji) is printed as its code point; the
page on the screen shows it as it was written. The angle brackets of a code point have no direction of their own: beside
letters that run from right to left they would be turned and taken apart, on paper and in what is copied from it, so
marks of the code point's direction stand around it.
"""

import re
from functools import cache
from pathlib import Path
from typing import Any

from rig.plain_text import code_point, is_hidden

_LONG_WORD = re.compile(r"\S{65,}")
_PIECE = re.compile(r"<U\+[0-9A-F]{4,6}>|[^<]{16}")
_CODE_POINTS = re.compile(r"(?:<U\+[0-9A-F]{4,6}>)+")
_LEFT_TO_RIGHT = "\u200e"
"""Left-to-right mark: seen by nobody, and no text that comes in may hold it."""
_MAY_BREAK = "\u200b"
"""Zero width space: seen by nobody, and it stands in long words alone."""


def printable(value: Any) -> Any:
    """Return a JSON value with each letter that no font has as its code point."""
    match value:
        case str():
            named = value if value.isascii() and value.isprintable() else "".join(map(_printed, value))
            return _CODE_POINTS.sub(rf"{_LEFT_TO_RIGHT}\g<0>{_LEFT_TO_RIGHT}", named)
        case list():
            return [printable(item) for item in value]
        case dict():
            return {key: printable(item) for key, item in value.items()}
    return value


def breakable(node: dict[str, Any]) -> dict[str, Any]:
    """Return an element of the page whose words may break, where longer than any hash: none runs off the paper."""
    children = [_broken(child) if isinstance(child, str) else breakable(child) for child in node["children"]]
    return {**node, "children": children}


def _broken(text: str) -> str:
    return _LONG_WORD.sub(lambda word: _PIECE.sub(rf"\g<0>{_MAY_BREAK}", word[0]), text)


@cache
def _printed(letter: str) -> str:
    if letter in "\n\t ":
        return letter
    return letter if ord(letter) in _known() and not is_hidden(letter) else code_point(letter)


@cache
def fonts() -> Path:
    """Return the folder of matplotlib's fonts."""
    import matplotlib as mpl

    return Path(mpl.get_data_path()) / "fonts" / "ttf"


@cache
def _known() -> frozenset[int]:
    """Return what the font behind all others has a glyph of."""
    from matplotlib.ft2font import FT2Font

    return frozenset(FT2Font(fonts() / "DejaVuSans.ttf").get_charmap())
