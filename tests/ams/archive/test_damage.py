"""A damaged archive is one sentence for whoever reads it or writes to it, and the row is named where it can be."""

import re
import sqlite3
from collections.abc import Callable
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path
from shutil import copyfile

import pytest
from archived_runs import a_run, a_sensor

from ams.archive.connection import reading
from ams.archive.histories import history
from ams.archive.runs import adjustment_of, list_runs, publish_run, standards_used
from ams.archive.sets import list_sets, show
from ams.archive.signatures import sign_off, verify_archive
from ams.errors import ArchiveDamaged

NOW = datetime(2026, 6, 1, tzinfo=UTC)
SENTENCE = r"archive\.sqlite: the archive is damaged \(.+\); nothing was changed; restore a copy"
READERS: tuple[Callable[[str], object], ...] = (
    list_sets,
    list_runs,
    verify_archive,
    lambda url: show(url, "SN1"),
    lambda url: history(url, "SN1"),
    lambda url: sign_off(url, "SN1"),
)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("whole") / "archive.sqlite"
    publish_run(f"sqlite:///{path}", a_run(0), [a_sensor(0)], NOW)
    return path


def _changed(whole: Path, tmp_path: Path, *statements: str) -> str:
    path = tmp_path / "archive.sqlite"
    copyfile(whole, path)
    with closing(sqlite3.connect(path)) as connection, connection:
        for statement in statements:
            connection.execute(statement)
    return f"sqlite:///{path}"


def _publish_another(url: str) -> object:
    return publish_run(url, a_run(1), [a_sensor(1)], NOW)


@pytest.mark.parametrize(
    ("statement", "read", "fault"),
    [
        ("UPDATE sets SET created_utc = 'x'", list_sets, r"sets [0-9a-f]{64}: cannot be read \(Invalid isoformat"),
        ("UPDATE sets SET created_utc = 7", list_sets, "sets [0-9a-f]{64}: cannot be read"),
        ("DROP TABLE verdicts", _publish_another, "verdicts: cannot be read"),
        ("UPDATE sets SET document = x'00ff'", lambda url: show(url, "SN1"), "sets [0-9a-f]{64}: is not as it was"),
        ("UPDATE sets SET sensor = CAST(x'8c' AS TEXT)", list_sets, "sets [0-9a-f]{64}: cannot be read"),
        ("UPDATE points SET axes = axes || ' '", lambda url: history(url, "SN1"), "points .*: is not as it was"),
        ("UPDATE points SET axes = 'x,y,x'", lambda url: history(url, "SN1"), "points .*: is not as it was"),
        ("UPDATE points SET numbers = x'00'", lambda url: history(url, "SN1"), "points .*: is not as it was"),
        ("UPDATE adjustments SET document = '{'", lambda url: adjustment_of(url, "SN1"), "adjustments .*: is not as"),
        ("UPDATE runs SET started_utc = 'x'", list_runs, "runs .*: cannot be read"),
        (
            "UPDATE standards SET due = 'x'",
            lambda url: standards_used(url, a_run(0).journal_sha256),
            "standards .*: cannot be read",
        ),
        ("INSERT INTO durations VALUES ('a', 'b', 'rig', 0, 'x', 1, 1, 1, 1, 1)", None, "durations .*: cannot be read"),
        ("UPDATE records SET utc = 'x' WHERE sequence = 1", None, "record 1: cannot be read"),
        ("UPDATE records SET detail = 'x' WHERE sequence = 1", None, r"record 1 \(.*\): is not as it was"),
        ("DROP TABLE certificates", lambda url: sign_off(url, "SN1"), r"certificates: cannot be read \(no such table"),
    ],
)
def test_a_damaged_row_is_a_sentence_and_verify_names_it(
    statement: str, read: Callable[[str], object] | None, fault: str, whole: Path, tmp_path: Path
) -> None:
    url = _changed(whole, tmp_path, statement)
    before = (tmp_path / "archive.sqlite").read_bytes()
    if read is not None:
        with pytest.raises(ArchiveDamaged, match=SENTENCE):
            read(url)
    faults = verify_archive(url).faults
    assert any(re.search(fault, one) for one in faults), faults
    assert (tmp_path / "archive.sqlite").read_bytes() == before


def test_only_the_row_that_is_damaged_is_told(whole: Path, tmp_path: Path) -> None:
    url = _changed(whole, tmp_path, "UPDATE records SET utc = 'x' WHERE sequence = 1")
    (fault, *others) = verify_archive(url).faults
    assert fault.startswith("record 1: cannot be read")
    assert all(other.endswith("it was added behind the record") for other in others), "what that record told"


def test_a_schema_that_the_driver_cannot_decode_is_a_sentence_to_every_reader(whole: Path, tmp_path: Path) -> None:
    url = _changed(whole, tmp_path)
    path = tmp_path / "archive.sqlite"
    path.write_bytes(path.read_bytes().replace(b"CREATE TABLE", b"CREATE \x8cABLE"))
    before = path.read_bytes()
    for act in (*READERS, _publish_another):
        with pytest.raises(ArchiveDamaged, match=SENTENCE):
            act(url)
    assert path.read_bytes() == before


def test_a_defect_over_a_whole_archive_stays_one(whole: Path, tmp_path: Path) -> None:
    url = _changed(whole, tmp_path)
    with pytest.raises(ValueError, match="ours"), reading(url, 1.0):
        raise ValueError("ours")
