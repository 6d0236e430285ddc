"""Laws of what past runs teach: kept as told, by rig, simulated apart from real, the latest first, never doubled."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from ams.archive.lessons import AxisComponents, Lesson, PartDuration, keep_lesson, past_lessons
from ams.errors import ArchiveAbsent

NOON = datetime(2026, 3, 1, 12, tzinfo=UTC)
LESSON = Lesson(
    "a" * 64, "table", False, NOON,
    (PartDuration("settle", 40, 120.0, 131.5, 360.0, 2.5), PartDuration("read", 40, 480.0, 481.0, 5760.0, 0.1)),
    (AxisComponents("SN1", "x", "three-axis package", 2e-6, 1e-7, 3e-7, 4e-7, 5e-8),),
)  # fmt: skip


@pytest.fixture
def url(tmp_path: Path) -> str:
    return f"sqlite:///{tmp_path / 'archive.sqlite'}"


def test_a_lesson_comes_back_as_it_was_kept(url: str) -> None:
    keep_lesson(url, LESSON)
    keep_lesson(url, LESSON)
    (found,) = past_lessons(url, "table", simulated=False, most=30)
    assert sorted(found.parts, key=lambda part: part.part) == sorted(LESSON.parts, key=lambda part: part.part)
    assert (found.journal_sha256, found.ended_utc, found.components) == (LESSON.journal_sha256, NOON, LESSON.components)


def test_what_is_told_again_takes_the_place_of_what_was_told(url: str) -> None:
    keep_lesson(url, LESSON)
    keep_lesson(url, replace(LESSON, parts=LESSON.parts[:1], components=()))
    (found,) = past_lessons(url, "table", simulated=False, most=30)
    assert (len(found.parts), found.components) == (1, ())


def test_simulated_runs_teach_simulated_rigs_and_no_rig_another(url: str) -> None:
    keep_lesson(url, LESSON)
    keep_lesson(url, replace(LESSON, journal_sha256="b" * 64, simulated=True))
    keep_lesson(url, replace(LESSON, journal_sha256="c" * 64, rig="another"))
    for simulated, sha256 in ((False, "a"), (True, "b")):
        assert [
            past_lesson.journal_sha256[0] for past_lesson in past_lessons(url, "table", simulated=simulated, most=30)
        ] == [sha256]


def test_the_latest_come_first_and_no_more_than_asked_for(url: str) -> None:
    for day, name in enumerate("dacb"):
        keep_lesson(url, replace(LESSON, journal_sha256=name * 64, ended_utc=NOON + timedelta(days=day)))
    found = past_lessons(url, "table", simulated=False, most=3)
    assert [entry.journal_sha256[0] for entry in found] == ["b", "c", "a"]


def test_an_archive_that_is_not_there_is_a_sentence(url: str) -> None:
    with pytest.raises(ArchiveAbsent, match="there is no archive"):
        past_lessons(url, "table", simulated=False, most=3)
