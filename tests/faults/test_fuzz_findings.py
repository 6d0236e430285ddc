"""What the fuzz has found, each as it was found: a sentence where there was a traceback."""

from pathlib import Path

import pytest
from example_files import EXAMPLE_RIG
from journals import journal_with

from procedures.errors import JournalError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.storage import JOURNAL_FILE
from rig.description.read import read_rig
from rig.errors import DescriptionError
from rig.link.transcript import read_transcript
from rig.wire import esp301
from rig.wire.indexing_table import AskPosition, TableCodec
from rig.wire.table_dialect import load_dialect


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("[rig]", "[rig]\nx = " + "[" * 3000, "not valid TOML: brackets in brackets without an end"),
        ("[rig]", "[rig]\nx = " + "9" * 5000, "not valid TOML: Exceeds the limit"),
        ("limits_deg = [-180.0, 180.0]", "limits_deg = [-180.0]", "limits_deg"),
    ],
)
def test_a_rig_file_is_refused_with_a_sentence(tmp_path: Path, old: str, new: str, expected: str) -> None:
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "rig.toml").write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(DescriptionError, match=expected):
        read_rig(tmp_path / "rig.toml")


def test_a_transcript_of_brackets_is_refused_with_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "line.jsonl").write_text('{"transcript":' * 3000, encoding="utf-8")
    with pytest.raises(DescriptionError, match=r"line\.jsonl:1: not JSON"):
        read_transcript(tmp_path / "line.jsonl")


@pytest.mark.parametrize("content", [b"[" * 100_000, b"\xff\xfe", b"7"])
def test_a_count_that_is_none_is_refused_with_a_sentence(tmp_path: Path, content: bytes) -> None:
    whole = journal_with(tmp_path / JOURNAL_FILE, 1)
    whole.with_name("journal.count").write_bytes(content)
    with pytest.raises(JournalError, match=r"cannot be read: .*remove it to read the journal without it"):
        JournalReader.open(whole)


def test_a_journal_whose_text_is_no_text_is_refused_with_a_sentence(tmp_path: Path) -> None:
    whole = journal_with(tmp_path / JOURNAL_FILE, 1)
    content = whole.read_bytes()
    assert b"tester" in content
    whole.write_bytes(content.replace(b"tester", b"te\xa2\xa2er"))
    with pytest.raises(JournalError, match="is not a whole journal"):
        JournalReader.open(whole)


def test_a_number_without_an_end_is_no_reply() -> None:
    assert esp301.decode_error(b"0, " + b"1" * 5000 + b", NO ERROR DETECTED") is None
    assert esp301.decode_number(b"1" * 5000) is None
    assert esp301.decode_commands(b"1" * 5000 + b"PA10") == [None]
    assert TableCodec(load_dialect(None, 1.0)).decode_reply(b"1 POS +" + b"9" * 400 + b".0000", AskPosition(1)) is None
