"""Files that a rig file and a procedure file name: a run keeps what they held, and a resume over another is refused."""

import hashlib
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from command import call
from named_files_scene import DIALECT, INDEX_ERRORS, MOVE, OTHER_MOVE, POINTS, bench_with_files, replace_text
from small_run import Bench, StopAt

from procedures.description import named_files
from procedures.description.procedure_file import Design
from procedures.errors import RequestError
from procedures.journal.audit.changes import changes_since
from procedures.journal.header import RunHeader
from procedures.journal.journal_reader import JournalReader
from procedures.journal.storage import JOURNAL_FILE
from procedures.kinds.read import procedure_form
from procedures.records.states import State
from procedures.run.resume import resume
from procedures.solution.record import read_record
from rig.assembly.open_rig import open_rig
from rig.description.read import rig_form
from rig.toml_file import StrictTable

LIKE_A_FILE = re.compile(r"(^|_)(file|files|path|folder|dialect|table|csv)$")
CHANGES = (
    (DIALECT, MOVE, OTHER_MOVE, 'rig file: axes.pitch.dialect: mytable.toml: move.command: was "{axis} MOVE'),
    (DIALECT, 'fault = "FAULT"', 'fault = "BROKEN"', 'mytable.toml: words.fault: was "FAULT", is "BROKEN"'),
    (INDEX_ERRORS, "0,-1.0,0.2", "0,-2.0,0.2", 'rig file: axes.pitch.index_table: index.csv: line 3: was "0,-1.0,0.2"'),
    (POINTS, "30,90\n", "90,90\n", 'procedure file: design.file: points.csv: line 13: was "30,90", is "90,90"'),
)


@pytest.fixture
def named(tmp_path: Path) -> Bench:
    return bench_with_files(tmp_path)


def _stopped(named: Bench) -> Path:
    run_dir = named.folder / "stopped"
    assert named.run(run_dir, observer=StopAt(run_dir, 5)).state is State.STOPPED
    return run_dir


@pytest.mark.parametrize(("file", "was", "becomes", "sentence"), CHANGES)
def test_fault_70_a_file_that_is_named_is_refused_where_it_was_changed_whoever_answers(
    named: Bench, file: str, was: str, becomes: str, sentence: str
) -> None:
    run_dir = _stopped(named)
    replace_text(named.folder / file, was, becomes)
    before = (run_dir / JOURNAL_FILE).read_bytes()
    with pytest.raises(RequestError, match=re.escape(sentence)):
        resume(run_dir, "carla")
    with pytest.raises(RequestError, match="a run keeps what it began with") as refused:
        resume(run_dir, "carla", "another table", accepts_changes=True)
    assert sentence in str(refused.value)
    assert (run_dir / JOURNAL_FILE).read_bytes() == before
    replace_text(named.folder / file, becomes, was)
    assert resume(run_dir, "carla").state is State.FINISHED


def test_a_comment_of_a_named_file_may_change_and_a_file_that_is_gone_is_not_needed(named: Bench) -> None:
    run_dir = _stopped(named)
    replace_text(named.folder / DIALECT, MOVE, f"{MOVE}  # as on the label")
    (named.folder / INDEX_ERRORS).unlink()
    (named.folder / POINTS).unlink()
    assert resume(run_dir, "carla", observer=StopAt(run_dir, 9)).state is State.STOPPED
    (named.folder / DIALECT).unlink()
    assert resume(run_dir, "carla").state is State.FINISHED


def test_a_rig_speaks_the_dialect_that_was_read_however_often_its_lines_are_opened(named: Bench) -> None:
    replace_text(named.folder / DIALECT, MOVE, OTHER_MOVE)
    for _ in range(2):
        with open_rig(named.rig) as rig:
            assert rig.description.axes["pitch"].spoken().move.command == MOVE.removeprefix("command = ").strip('"')  # type: ignore[attr-defined]


def test_what_is_too_long_to_be_kept_is_told_by_its_hash(named: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(named_files, "MOST_KEPT_BYTES", 150)
    header = named.header(named.folder / "run")
    assert {file.key: file.text is None for file in header.named_files}["axes.pitch.dialect"]
    replace_text(named.folder / DIALECT, MOVE, OTHER_MOVE)
    (first, second) = changes_since(header)
    assert str(first).startswith('rig file: axes.pitch.dialect: mytable.toml: sha256: was "')
    assert second.where == "rig file: axes.roll.dialect: mytable.toml: sha256"


def test_many_lines_that_differ_are_counted(named: Bench) -> None:
    header = named.header(named.folder / "run")
    replace_text(named.folder / POINTS, "0\n", "0 \n")
    *_, last = changes_since(header)
    assert (
        str(last) == 'procedure file: design.file: points.csv: further lines: was "as the run has them", is "7 differ"'
    )


def test_a_header_of_before_they_were_kept_is_read_and_contradicts_nothing(named: Bench) -> None:
    text = named.header(named.folder / "run").to_json()
    kept = RunHeader.from_json(text)
    assert kept.to_json() == text
    assert len(kept.named_files) == 4
    replace_text(named.folder / DIALECT, MOVE, OTHER_MOVE)
    of_before = RunHeader.from_json(re.sub(r', "named_files": \[.*\](?=[,}])', "", text))
    assert of_before.named_files == ()
    assert changes_since(of_before) == ()


@pytest.mark.usefixtures("no_report")
def test_the_command_keeps_them_and_its_record_has_their_hashes(
    named: Bench, capsys: pytest.CaptureFixture[str]
) -> None:
    files = named.folder / "procedure.toml", named.folder / "rig.toml"
    ran = call(capsys, "run", files[0], "--rig", files[1], "--out", named.folder / "runs", "--json")
    assert ran.status == 0, ran.err
    with JournalReader.open(Path(ran.document["run"])) as reader:
        record = read_record(reader)
    for where, file in (
        ("rig file: axes.pitch.dialect", DIALECT),
        ("rig file: axes.roll.dialect", DIALECT),
        ("rig file: axes.pitch.index_table", INDEX_ERRORS),
        ("procedure file: design.file", POINTS),
    ):
        content = (named.folder / file).read_bytes()
        assert record.hashes[f"{where}: {file}"] == hashlib.sha256(content).hexdigest()


def _tables(form: type[StrictTable]) -> Iterator[type[StrictTable]]:
    for table in form.__subclasses__():
        yield table
        yield from _tables(table)


def test_every_key_that_reads_as_one_of_a_file_is_declared_as_one() -> None:
    """Of every table of both files, those of all drivers, kinds and designs among them."""
    assert rig_form()
    assert procedure_form()
    of_files = {
        (table.__name__, key)
        for table in _tables(StrictTable)
        for key in table.model_fields
        if LIKE_A_FILE.search(key) and key not in table.names_files
    }
    assert of_files == {("IndexTable", "file")}, "what such a file is called, once it is read"
    assert "file" in Design.names_files
