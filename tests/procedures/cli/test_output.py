"""Laws of how a command speaks to a person."""

from io import StringIO

import pytest

from procedures.cli.output import note_paragraph, say_paragraph

SENTENCE = "no certificate could be issued: nobody has approved the set (approved_by); an/unbroken-" + "x" * 50


class Terminal(StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(("stream", "tell"), [("stdout", say_paragraph), ("stderr", note_paragraph)])
def test_sentences_break_between_words_at_a_terminal_and_nowhere_else(
    monkeypatch: pytest.MonkeyPatch, stream: str, tell: object
) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    assert callable(tell)
    for location, is_broken in ((Terminal(), True), (StringIO(), False)):
        monkeypatch.setattr(f"sys.{stream}", location)
        tell(SENTENCE)
        lines = location.getvalue().splitlines()
        assert " ".join(lines) == SENTENCE, "no word is cut, none lost"
        assert all(len(line) <= 40 or " " not in line for line in lines) is is_broken
