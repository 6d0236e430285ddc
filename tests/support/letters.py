"""Letters of every script: one of each block of Unicode, or all of them; and those that nobody may write."""

import unicodedata
from functools import cache

from fontTools.unicodedata import Blocks

_END = 0x110000
_UNSEEN = ("Cc", "Cs", "Zl", "Zp")
_IGNORABLE = (
    (0xAD, 0xAD), (0x34F, 0x34F), (0x61C, 0x61C), (0x115F, 0x1160), (0x17B4, 0x17B5), (0x180E, 0x180E),
    (0x200B, 0x200B), (0x200E, 0x200F), (0x202A, 0x202E), (0x2060, 0x206F), (0x3164, 0x3164), (0xFEFF, 0xFEFF),
    (0xFFA0, 0xFFA0), (0xFFF0, 0xFFFB), (0x1BCA0, 0x1BCA3), (0x1D173, 0x1D17A), (0xE0000, 0xE00FF),
    (0xE01F0, 0xE0FFF),
)  # fmt: skip
"""Default_Ignorable_Code_Point of Unicode's DerivedCoreProperties, and the anchors of annotations; without joiners and
what chooses the form of the letter before it."""
_TURNING = ("LRE", "RLE", "PDF", "LRO", "RLO", "LRI", "RLI", "FSI", "PDI")
_MARKS = ("\u061c", "\u200e", "\u200f")


def acts(letter: str) -> bool:
    """Whether a letter acts on a screen or turns the reading, is never seen, or is none, by Unicode's own tables."""
    if any(first <= ord(letter) <= last for first, last in _IGNORABLE):
        return True
    if ord(letter) % 0x10000 >= 0xFFFE or 0xFDD0 <= ord(letter) <= 0xFDEF:  # noncharacters
        return True
    return unicodedata.category(letter) in _UNSEEN or unicodedata.bidirectional(letter) in _TURNING or letter in _MARKS


@cache
def of_every_block() -> str:
    """Return the first letter of each block that has one which can be seen."""
    ends = [*Blocks.RANGES[1:], _END]
    firsts = (_first(range(begin, end)) for begin, end in zip(Blocks.RANGES, ends, strict=True))
    return "".join(letter for letter in firsts if letter)


@cache
def all_letters() -> str:
    """Return every letter that Unicode has a name for, and some of those that it has not: private ones, none yet.

    Of the thousands of like ones (ideographs, syllables of Hangul) it is one in 97: a page has to hold them.
    """
    unnamed = [0xE000, 0xF8FF, 0x0378, 0x3FFFD, 0xF0000, 0x10FFFD]
    codes = [code for code in range(0x21, _END) if unicodedata.category(chr(code)) not in ("Cn", "Co", "Zs")]
    kept = [code for code in codes if not _is_one_of_many(code) or code % 97 == 0]
    return "".join(letter for letter in map(chr, [*kept, *unnamed]) if not acts(letter))


def _is_one_of_many(code: int) -> bool:
    name = unicodedata.name(chr(code), "")
    return name.startswith(("CJK UNIFIED", "CJK COMPAT", "HANGUL SYLLABLE", "TANGUT", "NUSHU", "KHITAN", "EGYPTIAN"))


def that_act() -> list[str]:
    """Return every letter that acts or is never seen; of the many ignorable ones at the end of Unicode, some."""
    codes = [*range(0x1FFFF), 0xE0001, 0xE0041, 0xE007F, 0xE0FFF]
    return [letter for letter in map(chr, codes) if acts(letter)]


def _first(codes: range) -> str:
    return next(
        (letter for letter in map(chr, codes) if unicodedata.category(letter) not in ("Cn", "Zs") and not acts(letter)),
        "",
    )
