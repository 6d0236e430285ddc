"""The words of the tutorials that a newcomer may not know stand in the glossary, each once and in order."""

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
TUTORIALS = sorted((DOCS / "tutorials").glob("*.md"))
WORDS = (
    "attitude", "azimuth", "coefficient set", "coning angle", "covariance", "degrees of freedom", "design", "dwell",
    "flag", "journal", "lack of fit", "level", "nominal sensitivity", "observations", "offset", "order", "plateau",
    "pitch", "prediction interval", "rehearse", "replication", "reservation", "residual", "roll", "sensitivity",
    "settling", "standard uncertainty", "test vector", "twin", "usage range", "verdict", "virtual time",
)  # fmt: skip
"""Of the field and of calrig; which of them a tutorial uses is looked up."""
NAMED = {"rehearse": "rehearsal", "test vector": "test vectors", "pitch": "pitch, roll", "roll": "pitch, roll"}
"""How the glossary names a word where the tutorials have another form of it."""


def terms() -> list[str]:
    return re.findall(r"^(.+)\n: ", (DOCS / "glossary.md").read_text(encoding="utf-8"), re.MULTILINE)


def test_terms_stand_once_and_in_order() -> None:
    assert terms() == sorted(set(terms()), key=str.lower)


@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_the_words_of_a_tutorial_are_explained(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    italic = [word.removesuffix("s") for word in re.findall(r"(?<!\*)\*(\w[^*\n]*)\*(?!\*)", text)]
    used = [word for word in WORDS if re.search(rf"\b{word}", text.lower())]
    assert len(used) >= 5
    assert [word for word in (*used, *italic) if NAMED.get(word, word) not in terms()] == []
