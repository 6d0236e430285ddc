"""The index of the decision records names each of them once, as it names itself."""

import re
from pathlib import Path

RECORDS = Path(__file__).parents[2] / "docs" / "decisions"
LINE = re.compile(r"^- \[(?P<number>\d+)\. (?P<title>.+)\]\((?P<file>[^)]+)\)$", re.MULTILINE)
HEADING = re.compile(r"# 0*(?P<number>\d+)\.? (?P<title>.+)")


def test_the_index_has_every_record_once_by_number_and_heading() -> None:
    listed = [line.groups() for line in LINE.finditer((RECORDS / "index.md").read_text(encoding="utf-8"))]
    there = []
    for path in sorted(RECORDS.glob("0*.md")):
        heading = HEADING.fullmatch(path.read_text(encoding="utf-8").splitlines()[0])
        assert heading is not None, path.name
        assert path.name.startswith(f"{int(heading['number']):04}-"), path.name
        there.append((*heading.groups(), path.name))
    assert sorted(listed, key=lambda line: line[2]) == there
    assert len(there) >= 70


def test_every_line_of_the_index_stands_under_a_subject() -> None:
    page = (RECORDS / "index.md").read_text(encoding="utf-8")
    subjects = re.split(r"^## .+$", page, flags=re.MULTILINE)[1:]
    assert not LINE.findall(page.partition("## ")[0])
    assert all(LINE.findall(subject) for subject in subjects)
