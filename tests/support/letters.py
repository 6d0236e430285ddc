"""Letters of every script: one of each block of Unicode, or all of them; and those that nobody may write."""

import unicodedata
from functools import cache

from fontTools.unicodedata import Blocks

_END = 0x110000
_UNSEEN = ("Cc", "Cs", "Zl", "Zp")
_TURNING = ("LRE", "RLE", "PDF", "LRO", "RLO", "LRI", "RLI", "FSI", "PDI")
_MARKS = ("\u061c", "\u200e", "\u200f")


def acts(letter: str) -> bool:
    """Whether a letter acts on a screen or on the direction of reading, by Unicode's own tables."""
    return unicodedata.category(letter) in _UNSEEN or unicodedata.bidirectional(letter) in _TURNING or letter in _MARKS


@cache
def of_every_block() -> str:
    """Return the first letter of each block that has one which can be seen."""
    ends = [*Blocks.RANGES[1:], _END]
    firsts = (_first(range(begin, end)) for begin, end in zip(Blocks.RANGES, ends, strict=True))
    return "".join(letter for letter in firsts if letter)


@cache
def all_letters() -> str:
    """Return every letter that Unicode has a name for, and some of those that it has not: private, none.

    Of the thousands of like ones (ideographs, syllables of Hangul) it is one in 97: a page has to hold them.
    """
    unnamed = [0xE000, 0xF8FF, 0xFDD0, 0xFFFE, 0xFFFF, 0x1FFFE, 0xF0000, 0x10FFFF]
    codes = [code for code in range(0x21, _END) if unicodedata.category(chr(code)) not in ("Cn", "Co", "Zs")]
    kept = [code for code in codes if not _is_one_of_many(code) or code % 97 == 0]
    return "".join(letter for letter in map(chr, [*kept, *unnamed]) if not acts(letter))


def _is_one_of_many(code: int) -> bool:
    name = unicodedata.name(chr(code), "")
    return name.startswith(("CJK UNIFIED", "CJK COMPAT", "HANGUL SYLLABLE", "TANGUT", "NUSHU", "KHITAN", "EGYPTIAN"))


def that_act() -> list[str]:
    """Return every letter that acts, but for line break and tab, which texts may have."""
    return [letter for letter in map(chr, range(_END)) if acts(letter) and letter not in "\n\t"]


def _first(codes: range) -> str:
    return next(
        (letter for letter in map(chr, codes) if unicodedata.category(letter) not in ("Cn", "Zs") and not acts(letter)),
        "",
    )
