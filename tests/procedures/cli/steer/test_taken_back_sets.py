"""Dwells taken back after a run had finished: the sets that rested on them are nobody's to use any more."""

import shutil
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from archived_runs import a_run, a_sensor
from command import call
from finished_job import FinishedJob

from ams.archive.runs import publish_run
from ams.archive.sets import list_sets
from ams.archive.signatures import sign, verify_archive
from ams.errors import ArchiveForbids, SetWithdrawn
from ams.exports.formats import load_set
from ams.exports.withdrawn_folder import WITHDRAWN_FILE
from ams.surveillance.adjustment import Adjustment
from procedures.delivery.deliver import SolvedRun, sets_of, solve_run
from procedures.delivery.publish import publish_solved
from procedures.delivery.taken_back_sets import require_standing_dwells, taken_back_of, withdraw_previous
from procedures.journal.audit.taken_back import taken_back_since
from procedures.journal.requests.corrections import Authorisation, redo

NOW = datetime(2026, 3, 5, tzinfo=UTC)
SENSOR = "SN1047"
WHY = ("--reason", "fixture was loose", "--operator", "Anna")


@pytest.fixture
def run(finished_job: FinishedJob, tmp_path: Path) -> Path:
    return finished_job.copied_to(tmp_path)


@pytest.fixture
def url(run: Path) -> str:
    """The archive that the run was published to."""
    return f"sqlite:///{run.parent / 'archive.sqlite'}"


@pytest.fixture
def untold(run: Path, url: str) -> str:
    """A second archive with the same set, which nobody tells of what becomes of the run."""
    shutil.copyfile(run.parent / "archive.sqlite", run.parent / "second.sqlite")
    return url.replace("archive.sqlite", "second.sqlite")


def _first_step(run: Path) -> int:
    return next(dwell.step for dwell in solve_run(run).record.dwells if dwell.accepted and dwell.purpose == "design")


@pytest.mark.parametrize("what", ["void", "redo"])
def test_sets_whose_dwells_were_taken_back_are_withdrawn_in_the_archive_of_the_run(
    what: str, run: Path, url: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A set of a run that was voided whole stayed usable, was signed, exported, certified and the next "as found"."""
    (before,) = list_sets(url)
    assert before.status == "engineering"
    which = ("--from", _first_step(run)) if what == "void" else ("--replication", 1)
    told = call(capsys, what, run, *which, *WHY)
    assert told.status == 0
    assert f"withdrawn in the archive {url}: set {before.sha256[:12]} of {SENSOR}; not to be used" in told.out
    (word,) = taken_back_since(run).values()
    (after,) = list_sets(url)
    assert (after.status, after.verdict, after.as_left) == ("withdrawn", None, None)
    assert after.withdrawal is not None
    assert (after.withdrawal.name, after.withdrawal.reason) == (
        "Anna",
        f"{word.dwells} dwells of its run {run.name} were taken back after it was made: fixture was loose",
    )
    with pytest.raises(ArchiveForbids, match="is withdrawn"):
        sign(url, SENSOR, "prepared", "B. Sun", NOW)
    assert call(capsys, "archive", "export", SENSOR, "--to", "json", "--archive", url).status == 2
    call(capsys, "certificate", SENSOR, "--number", "1", "--specimen", "--archive", url, "--out", run.parent)
    page = (run.parent / "specimen-1.html").read_text(encoding="utf-8")
    assert "As the run stood when the set was made: " in page
    assert "fixture was loose" in page
    assert verify_archive(url).faults == ()


def test_a_set_is_refused_by_its_journal_where_its_archive_was_not_told(
    run: Path, untold: str, capsys: pytest.CaptureFixture[str]
) -> None:
    first = _first_step(run)
    where = ("--archive", untold)
    assert call(capsys, "void", run, "--from", first, *WHY).status == 0
    (word,) = taken_back_since(run).values()
    said = f"{word.dwells} dwells of its run {run.name} were taken back after it was made, by Anna on "
    asks = (
        ("archive", "sign", SENSOR, "prepared", "--operator", "B. Sun"),
        ("archive", "accept", SENSOR, "x.cubic", "--operator", "B. Sun", "--reason", "small"),
        ("archive", "export", SENSOR, "--to", "json", "--out", run.parent / f"{SENSOR}.json"),
        ("certificate", SENSOR, "--number", "1", "--out", run.parent),
        ("certificate", SENSOR, "--number", "1", "--specimen", "--out", run.parent),
    )
    for words in asks:
        refused = call(capsys, *words, *where)
        assert (refused.status, said in refused.err, "fixture was loose" in refused.err) == (2, True, True), words
    for words in ("show", "history"):
        assert said in call(capsys, "archive", words, SENSOR, *where).err
    assert not (run.parent / f"{SENSOR}.json").exists()
    call(capsys, "solve", run, *where)
    assert [entry.status for entry in list_sets(untold)] == ["withdrawn"], "as the refusal says"


def test_nothing_is_found_by_a_set_whose_dwells_were_taken_back(
    run: Path, untold: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The next run took it as "as found"."""
    solved = solve_run(run)
    first = _first_step(run)
    shutil.copyfile(run.parent / "second.sqlite", run.parent / "third.sqlite")
    by_a_standing_one = _published_later(solved, untold.replace("second", "third"))
    assert by_a_standing_one.as_found is not None
    call(capsys, "void", run, "--from", first, *WHY)
    assert _published_later(solved, untold).as_found is None
    assert next(entry.status for entry in list_sets(untold)) == "withdrawn"


def _published_later(solved: SolvedRun, archive_url: str) -> Adjustment:
    """Publish a run like it of a day later; return what was found and left."""
    day = timedelta(days=1)
    events = [replace(event, utc=event.utc + day) for event in solved.record.events]
    dwells = [replace(dwell, ended_utc=dwell.ended_utc + day) for dwell in solved.record.dwells]
    hashes = {**solved.record.hashes, "journal content": "0" * 64}
    record = replace(solved.record, run_id="later", events=events, dwells=dwells, hashes=hashes)
    sets = sets_of(replace(solved, record=record))
    return publish_solved(archive_url, solved.folder, record, solved.sensors, sets).adjustments[SENSOR]


def test_a_folder_that_cannot_be_looked_into_keeps_nothing_from_being_signed_or_published(tmp_path: Path) -> None:
    """As that of another account; here a name that is too long for any system."""
    url, run = f"sqlite:///{tmp_path / 'archive.sqlite'}", replace(a_run(0), folder=f"/{'x' * 5000}")
    publish_run(url, run, [a_sensor(0)], NOW)
    assert taken_back_of(url, "SN1") == ""
    require_standing_dwells(url, "SN1", "nothing was signed")
    withdraw_previous(url, ["SN1"], "later", is_simulated=False)
    assert [entry.status for entry in list_sets(url)] == ["engineering"]


def test_an_archive_that_does_not_answer_is_named_with_what_remains_to_be_done(
    run: Path, url: str, capsys: pytest.CaptureFixture[str]
) -> None:
    first, archive = _first_step(run), run.parent / "archive.sqlite"
    aside = archive.rename(run.parent / "aside.sqlite")
    archive.write_bytes(b"no database" * 100)
    told = call(capsys, "void", run, "--from", first, *WHY)
    assert told.status == 0
    assert "the sets of this run still stand in the archive" in told.err
    assert f"calrig solve {run} withdraws them there" in told.err
    aside.replace(archive)
    call(capsys, "solve", run)
    assert [entry.status for entry in list_sets(url)] == ["withdrawn"]


def test_files_that_rest_on_dwells_taken_back_are_moved_aside_and_say_so(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """They stayed where they were, with a report that read "usable", and every command took them."""
    sets, sealed = run / "coefficients", (run / "coefficients" / f"{SENSOR}.json").read_bytes()
    exports, report = sorted(path.name for path in (run / "exports").iterdir()), (run / "report.html").read_bytes()
    told = call(capsys, "void", run, "--from", _first_step(run), *WHY)
    aside = run / "superseded-1"
    assert f"{aside}: holds the sets, exports and report of before, which must not be used any more" in told.out
    assert not sets.exists()
    assert not (run / "exports").exists()
    assert (aside / "coefficients" / f"{SENSOR}.json").read_bytes() == sealed, "no sealed byte changed"
    assert (aside / "report.html").read_bytes() == report
    assert sorted(path.name for path in (aside / "exports").iterdir()) == sorted([*exports, WITHDRAWN_FILE])
    assert "set aside  superseded-1: made before dwells were taken back" in call(capsys, "handover", run).out
    page = (run / "report.html").read_text(encoding="utf-8")
    assert "were taken back after it was made, by Anna on " in page
    assert "There is no result to use" in page
    moved = load_set(aside / "coefficients" / f"{SENSOR}.json")
    with pytest.raises(SetWithdrawn, match=r"withdrawn by Anna on .* fixture was loose"):
        moved.require_standing("here", "nothing was done")
    refused = call(capsys, "export", aside / "coefficients" / f"{SENSOR}.json", "--to", "c", "--out", run / "x.h")
    assert (refused.status, "withdrawn by Anna" in refused.err) == (2, True)
    rows = run / "rows.csv"
    rows.write_text("time_s,x,y,z\n0,0.1,0.1,2.5\n", encoding="utf-8")
    read = call(capsys, "attitude", aside / "coefficients" / f"{SENSOR}.json", rows)
    assert (read.status, "withdrawn by Anna" in read.err) == (2, True)


def test_a_run_that_is_solved_again_leaves_no_file_of_what_was_taken_back(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """After dwells were taken back by a version that moved nothing: the report had no result, and 77 exports stayed."""
    for replication in (1, 2):
        redo(run, replication, Authorisation("Anna", "fixture was loose"))
    assert (run / "coefficients").is_dir()
    call(capsys, "solve", run)
    assert not (run / "coefficients").exists()
    assert not (run / "exports").exists()
    assert (run / "superseded-1" / "exports" / WITHDRAWN_FILE).is_file()
    assert "calibration report" in (run / "report.html").read_text(encoding="utf-8")
    call(capsys, "solve", run)
    assert not (run / "superseded-2").exists(), "once"


def test_files_of_a_sensor_that_has_no_set_any_more_are_moved_aside(
    run: Path, url: str, capsys: pytest.CaptureFixture[str]
) -> None:
    sign(url, SENSOR, "withdrawn", "C. Lim", NOW, "wrong mount")
    call(capsys, "solve", run)
    assert list((run / "coefficients").iterdir()) == list((run / "exports").iterdir()) == []
    moved = run / "superseded-1" / "coefficients" / f"{SENSOR}.json"
    assert load_set(moved).standing == "withdrawn by C. Lim on 2026-03-05 (UTC): wrong mount"
