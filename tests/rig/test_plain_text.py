"""What a text may hold: every script as it is written, and nothing that no script has."""

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.plain_text import LONGEST_TEXT, MOST_MARKS, shown, text_complaint

NONCHARACTERS = [
    *range(0xFDD0, 0xFDF0),
    *(plane << 16 | last for plane in range(17) for last in (0xFFFE, 0xFFFF)),
]
"""All 66. Source: The Unicode Standard, 23.7."""
WRITTEN = (
    unicodedata.normalize("NFD", "Nguyễn Thị Ngọc Ánh"),
    "בְּרֵאשִׁ֖ית בָּרָ֣א אֱלֹהִ֑ים",  # Hebrew, with vowels and cantillation
    "བྲཱཾ ཧྐྵྨླྺྼྻྂ",  # Tibetan, the letter with the most signs below it that anybody writes
    "กิ๊บ ผู้ใหญ่",  # Thai
    "ក្ស្រ្តី",  # Khmer
    "د. عَبْدُ ٱللَّٰه",  # Arabic, with all vowels
    "👩🏽\u200d🔬 und ❤\ufe0f",
)


@pytest.mark.parametrize("text", WRITTEN)
def test_what_people_write_may_stand(text: str) -> None:
    assert text_complaint(text) == ""
    assert shown(text) == text


@pytest.mark.parametrize("number", NONCHARACTERS)
def test_a_number_that_is_never_a_letter_may_not(number: int) -> None:
    assert text_complaint(f"a{chr(number)}b").startswith(f"holds <U+{number:04X}>, ")
    assert shown(f"a{chr(number)}b") == f"a<U+{number:04X}>b"


def test_a_text_has_an_end() -> None:
    assert text_complaint("ä" * LONGEST_TEXT) == ""
    assert text_complaint("ä" * 100_000) == "has 100000 letters, allowed are 2000; shorten it"


@pytest.mark.parametrize("mark", ["\u0301", "\u0489", "\u0e49", "\u0f90"])
def test_marks_that_pile_up_on_one_letter_may_not(mark: str) -> None:
    assert text_complaint(f"a{mark * MOST_MARKS}b{mark * MOST_MARKS}") == ""
    said = "has 1000 marks on one letter, allowed are 30; leave them out"
    assert text_complaint(f"an{mark * 1000}na") == said
    assert text_complaint(mark * 1000) == said


@given(st.text(st.characters(codec="utf-8", categories=["L", "N", "P", "S", "Zs"]), max_size=100))
def test_letters_digits_and_signs_of_every_script_may_stand(text: str) -> None:
    unseen = "\u115f\u1160\u3164\uffa0"
    assert (text_complaint(text) == "") == (not set(unseen) & set(text))
