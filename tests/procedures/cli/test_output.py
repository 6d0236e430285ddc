"""Laws of how a command speaks to a person."""

from io import StringIO

import pytest

from procedures.cli.output import note_paragraph, say_lines, say_paragraph

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


def test_lines_too_long_for_a_terminal_go_on_further_in_and_short_ones_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    lines = ("", "axis x   (standard error 1e-05 V)", f"  remark: {SENTENCE}")
    for location in (Terminal(), StringIO()):
        monkeypatch.setattr("sys.stdout", location)
        say_lines(lines)
        told = location.getvalue().splitlines()
        if not location.isatty():
            assert told == list(lines)
            continue
        assert told[:2] == list(lines[:2])
        assert all(line.startswith("      ") for line in told[3:])
        assert " ".join(line.strip() for line in told[2:]) == lines[2].strip()
        assert all(len(line) <= 40 or " " not in line.strip() for line in told)
