"""Files saved on Windows (a byte order mark in front, CR LF between) are read by every command as what they say."""

import hashlib
from pathlib import Path

import pytest
from command import call
from example_files import ROOT
from job_files import job
from solved import provenance, solved_package

from ams.exports.formats import FORMATS
from ams.sets.coefficients import build_set
from procedures.journal.audit.changes import changes_since
from procedures.journal.journal_reader import JournalReader
from procedures.queue.people import source_of

MARK = b"\xef\xbb\xbf"


def saved_on_windows(path: Path) -> Path:
    path.write_bytes(MARK + path.read_bytes().removeprefix(MARK).replace(b"\r\n", b"\n").replace(b"\n", b"\r\n"))
    return path


def test_check_says_the_same_of_both_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    procedure, rig = job(tmp_path)
    plain = call(capsys, "check", procedure, "--rig", rig, "--json")
    for path in (procedure, rig):
        saved_on_windows(Path(path))
    marked = call(capsys, "check", procedure, "--rig", rig, "--json")
    assert (marked.status, marked.document) == (plain.status, plain.document)


@pytest.mark.usefixtures("no_report")
def test_a_run_keeps_them_as_they_lie_there_and_a_mark_is_no_change(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """By the SHA-256 of the very file a queue finds the run that it began: another one would be begun beside it."""
    files = [saved_on_windows(Path(path)) for path in job(tmp_path)]
    ran = call(capsys, "run", files[0], "--rig", files[1], "--out", tmp_path / "runs", "--json")
    assert ran.status == 0, ran.err
    with JournalReader.open(Path(ran.document["run"])) as reader:
        header = reader.header
    assert [header.procedure_sha256, header.rig_sha256] == [source_of(path).sha256 for path in files]
    assert header.rig_sha256 == hashlib.sha256(files[1].read_bytes()).hexdigest()
    assert [change for change in changes_since(header) if "file" in change.where] == []
    for path in files:
        path.write_bytes(path.read_bytes().removeprefix(MARK).replace(b"\r\n", b"\n"))
    assert [change for change in changes_since(header) if "file" in change.where] == []


def test_observations_and_readings_are_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ("--axis", "x=sx_v", "--axis", "y=sy_v", "--axis", "z=sz_v", "--json")
    path = tmp_path / "observations.csv"
    path.write_bytes((ROOT / "examples" / "observations.csv").read_bytes())
    plain = call(capsys, "fit", path, *words).document
    assert call(capsys, "fit", saved_on_windows(path), *words).document["axes"] == plain["axes"]
    coefficients = tmp_path / "SN1047.json"
    coefficients.write_bytes(FORMATS["json"].to_bytes(build_set(solved_package(), provenance())))
    readings = tmp_path / "readings.csv"
    readings.write_bytes((ROOT / "examples" / "readings.csv").read_bytes())
    angles = call(capsys, "attitude", coefficients, readings)
    assert angles.status == 0, angles.err
    assert call(capsys, "attitude", coefficients, saved_on_windows(readings)).out == angles.out


@pytest.mark.parametrize("name", ["json", "csv", "c", "epics"])
def test_a_set_that_another_program_saved_is_named_as_that(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is used byte for byte as it was written or not at all."""
    path = tmp_path / FORMATS[name].file_name("SN1047")
    path.write_bytes(MARK + FORMATS[name].to_bytes(build_set(solved_package(), provenance())))
    refused = call(capsys, "verify", path)
    assert refused.status == 2
    assert f"{path}: begins with a byte order mark (bytes ef bb bf)" in refused.err
    assert "take an intact copy" in refused.err
