"""Laws of where the sets of a run go: a run keeps the archive it was begun with, without any password of it."""

from pathlib import Path

import pytest
from command import call
from job_files import job
from small_run import StopAt, bench

from procedures.cli.steer.archive_url import archive_of_run, as_kept
from procedures.journal.journal_reader import JournalReader
from procedures.run.services import RunServices

SECRET = "hunter2"
WITH_PASSWORD = f"postgresql+psycopg://lab:{SECRET}@archive.example/calrig"


def stopped(folder: Path, archive: str) -> Path:
    """A run that was begun with an archive, and stopped after five dwells."""
    small, run = bench(folder), folder / "stopped"
    services = RunServices(archive=as_kept(archive, is_simulated=True))
    small.run(run, observer=StopAt(run, 5), services=services)
    return run


def test_solve_and_publish_go_where_the_run_went_unless_another_archive_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    procedure, rig = job(tmp_path)
    (tmp_path / "shared").mkdir()
    options = ("--rig", rig, "--out", tmp_path / "runs", "--archive", "sqlite:///shared/own.sqlite", "--json")
    run = call(capsys, "run", procedure, *options).document["run"]
    monkeypatch.chdir(tmp_path / "shared")  # a relative path is not looked up from here
    (tmp_path / "shared" / "own.sqlite").unlink()
    assert call(capsys, "solve", run, "--json").status == 0
    assert (tmp_path / "shared" / "own.sqlite").exists()
    (tmp_path / "shared" / "own.sqlite").unlink()
    published = call(capsys, "archive", "publish", run, "--json").document
    assert published["archive"] == f"sqlite:///{tmp_path / 'shared' / 'own.sqlite'}"
    assert not (tmp_path / "runs" / "archive.sqlite").exists()
    call(capsys, "solve", run, "--archive", f"sqlite:///{tmp_path / 'other.sqlite'}")
    assert (tmp_path / "other.sqlite").exists()


@pytest.mark.usefixtures("no_report")
def test_an_archive_of_no_bytes_is_refused_before_a_run_and_said_behind_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    procedure, rig = job(tmp_path)
    archive = tmp_path / "own.sqlite"
    options = (
        "run",
        procedure,
        "--rig",
        rig,
        "--out",
        tmp_path / "runs",
        "--archive",
        f"sqlite:///{archive}",
        "--json",
    )
    archive.write_bytes(b"")
    refused = call(capsys, *options)
    assert (refused.status, "has 0 bytes" in refused.err, "nothing was begun" in refused.err) == (2, True, True)
    assert not (tmp_path / "runs").exists()
    archive.unlink()
    run = call(capsys, *options).document["run"]
    archive.write_bytes(b"")
    again = call(capsys, "solve", run, "--json")
    assert (again.status, "it is begun anew; where it held sets, restore a copy" in again.err) == (0, True)


def test_a_resume_goes_on_with_the_archive_of_the_run_and_keeps_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    own, other = (f"sqlite:///{tmp_path / name}.sqlite" for name in ("own", "other"))
    run = stopped(tmp_path, own)
    assert call(capsys, "resume", run).status == 0
    assert (tmp_path / "own.sqlite").exists()
    assert not (tmp_path / "archive.sqlite").exists()
    with JournalReader.open(run) as reader:
        assert [event.detail["archive"] for event in reader.events("opened")] == [own, own]
    assert archive_of_run(run, other) == other


def test_no_password_is_kept_and_the_person_is_told_what_to_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("PGPASSWORD", raising=False)
    monkeypatch.delenv("CALRIG_ARCHIVE", raising=False)
    run = stopped(tmp_path, WITH_PASSWORD)
    assert SECRET.encode() not in b"".join(path.read_bytes() for path in run.rglob("*") if path.is_file())
    assert archive_of_run(run, None) == "postgresql+psycopg://lab@archive.example/calrig"
    assert "the run keeps no password; where the database wants one, give --archive again" in capsys.readouterr().err
    monkeypatch.setenv("CALRIG_ARCHIVE", WITH_PASSWORD)
    assert archive_of_run(run, None) == WITH_PASSWORD
    assert archive_of_run(run, "sqlite:///given.sqlite") == "sqlite:///given.sqlite"


@pytest.mark.parametrize("key", ["password", "sslpassword"])
def test_a_password_in_the_query_is_not_kept_either(key: str) -> None:
    kept = as_kept(f"postgresql+psycopg://archive.example/calrig?user=lab&{key}={SECRET}", is_simulated=False)
    assert SECRET not in kept
    assert "user=lab" in kept


def test_the_environment_names_the_archive_of_a_measured_run_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CALRIG_ARCHIVE", "sqlite:////lab/archive.sqlite")
    assert as_kept(None, is_simulated=False) == "sqlite:////lab/archive.sqlite"
    assert as_kept(None, is_simulated=True) == ""
