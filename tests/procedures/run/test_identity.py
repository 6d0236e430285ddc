"""Which run it is, when it was, and what its record must never hold."""

import os
import re
import shutil
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import pytest
from journals import a_clock
from small_run import bench
from unattended_run import UnattendedRun, asks, events, run_unattended

from ams.errors import ArchiveForbids
from procedures.alerts.channels import without_secrets
from procedures.cli.main import run_command
from procedures.delivery.deliver import deliver, sets_of, solve_run
from procedures.delivery.publish_folder import publish_folder
from procedures.errors import RequestError
from procedures.journal.location import is_copy, location_of
from procedures.journal.requests.corrections import Authorisation, redo
from procedures.journal.status.status import status
from procedures.journal.storage import JOURNAL_FILE
from procedures.records.states import State
from procedures.run.handover import handover
from procedures.run.resume import resume
from procedures.run.watch.clock_watch import LONGEST_GAP_S, GapWatch
from rig.clock import SystemClock, VirtualClock


def test_fault_82_a_copied_run_is_resumed_only_by_somebody_who_answers_for_it(tmp_path: Path) -> None:
    """Detected: the journal keeps which file it is and where it lies, and the other one is still there.
    Response: refused, both places named; with a name and a reason that the record keeps the copy goes on.
    """
    small, run_dir = bench(tmp_path), tmp_path / "run"
    run_unattended(small, UnattendedRun(run_dir, after={5: asks("stop")}))
    copy = Path(shutil.copytree(run_dir, tmp_path / "copy"))
    with pytest.raises(RequestError, match="this is a copy, and both could go on"):
        resume(copy, "tester")
    moved = run_dir.rename(tmp_path / "moved")
    assert resume(moved, "tester").state is State.FINISHED
    moved.rename(run_dir)
    assert resume(copy, "anna", "the first disk fails", accepts_changes=True).state is State.FINISHED
    (answered,) = events(copy, "override")
    assert (answered.detail["by"], answered.detail["reason"]) == ("anna", "the first disk fails")

    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    publish_folder(run_dir, lambda _: url)
    solved = solve_run(copy)
    refused = deliver(replace(solved, record=replace(solved.record, run_id="run")), url)
    assert "the archive has it with another journal" in refused.parts["archive"]
    assert refused.parts["pdf"] == "done"


def test_a_copy_by_hard_links_is_a_copy_and_the_run_itself_goes_on_beside_it(tmp_path: Path) -> None:
    """``cp -al``, as backups make them: the journal is one file, the log beside it is not, and both could go on."""
    small, run_dir, linked = bench(tmp_path), tmp_path / "run", tmp_path / "linked"
    run_unattended(small, UnattendedRun(run_dir, after={5: asks("stop")}))
    shutil.copytree(run_dir, linked, copy_function=os.link)
    assert (linked / JOURNAL_FILE).samefile(run_dir / JOURNAL_FILE)
    with pytest.raises(RequestError, match="this is a copy, and both could go on"):
        resume(linked, "tester")
    place = location_of(run_dir)
    (tmp_path / "name").symlink_to(run_dir, target_is_directory=True)
    assert not is_copy(tmp_path / "name", place)
    assert is_copy(linked, place)
    other_name = {**place, "path": str(tmp_path / "name")}
    assert not is_copy(run_dir, other_name), "one folder by two names, as a bind mount gives it"
    assert resume(run_dir, "tester").state is State.FINISHED


def test_a_run_of_which_something_was_taken_back_is_published_again(tmp_path: Path) -> None:
    small, run_dir, url = bench(tmp_path), tmp_path / "run", f"sqlite:///{tmp_path / 'archive.sqlite'}"
    small.run(run_dir)
    publish_folder(run_dir, lambda _: url)
    redo(run_dir, 2, Authorisation("anna", "leaned on"))
    assert resume(run_dir, "tester").state is State.FINISHED
    published = publish_folder(run_dir, lambda _: url).run
    assert [publication.is_new for publication in published.publications] == [True]


@pytest.mark.usefixtures("no_report")
def test_fault_83_a_clock_that_is_set_in_the_night_dates_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Detected: the wall clock against one that nobody sets, between any two dwells.
    Response: recorded, and told in report and set; the dates stay those of the clock with which the run began.
    """
    small = bench(tmp_path)
    plain, stepped = UnattendedRun(tmp_path / "plain"), UnattendedRun(tmp_path / "run", after={10: _next_year})
    for unattended in (plain, stepped):
        assert run_unattended(small, unattended).state is State.FINISHED
    before, after = (solve_run(unattended.run_dir) for unattended in (plain, stepped))
    for instant in ("measured_utc", "ended_utc"):  # since the run began: they did not begin at one time
        lasted = [getattr(run.record, instant) - run.record.created_utc for run in (before, after)]
        assert abs(lasted[1] - lasted[0]) < timedelta(seconds=2.0)
    (said,) = sets_of(after).values()
    assert "the computer's clock was set by +31536000.0 s" in str(said.document["warnings"])
    delivered = deliver(after, None)
    assert delivered.view is not None
    assert any("clock was set" in note.text for note in delivered.view.notes)
    latest = after.record.created_utc + timedelta(days=1.0)
    assert all(note.utc < latest for note in delivered.view.notes)
    found = status(stepped.run_dir)
    assert found.since_utc == after.record.ended_utc < latest
    assert found.to_document()["clock_set_by_s"] == pytest.approx(31_536_000.0, abs=1.0)
    assert "clock_set_by_s" not in status(plain.run_dir).to_document()
    years = set(re.findall(r"\b(20\d\d)-\d\d", handover(stepped.run_dir)))
    assert years == {str(after.record.created_utc.year)}
    assert run_command(["status", str(stepped.run_dir)]) == 0
    assert "clock: the computer's clock was set by +31536000.0 s" in capsys.readouterr().out


def _next_year(unattended: UnattendedRun) -> None:
    clock = unattended.rig.clock
    assert isinstance(clock, VirtualClock)
    clock.step_wall(31_536_000.0)


def test_a_process_that_was_frozen_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    machine = a_clock()
    monkeypatch.setattr(SystemClock, "monotonic_s", lambda _: machine.monotonic_s())
    silences = {"axes.pitch": 3, "readouts.dmm": 2}
    watch = GapWatch(SystemClock(), lambda: silences)
    assert watch.look() is None
    machine.sleep(0.5 * LONGEST_GAP_S)
    assert watch.look() is None
    machine.sleep(60.0)
    frozen = watch.look()
    assert frozen is not None
    assert frozen.text == "this process did not run for 60 s: stopped by a signal, or starved"
    machine.sleep(60.0)
    silences.update({"axes.pitch": 12, "readouts.dmm": 1})  # the meter's line was opened anew meanwhile
    waited = watch.look()
    assert waited is not None
    assert waited.text.startswith(
        "nothing was looked at for 60 s: questions had no answer on axes.pitch (9), readouts.dmm (1);"
    ), "a process that waits for a device is not one that somebody stopped"


def test_fault_84_what_an_alert_was_sent_with_does_not_get_into_the_record() -> None:
    """Detected: every argument and address of alerts.toml, whole or in parts, is looked for in what failed.
    Response: left out of the record; the name of the program is told.
    """
    secrets = ("--token=xoxb-123456", "https://user:hunter22@hc.example/ping/abcdef", "-v")
    text = "ring: xoxb-123456 refused by hc.example for hunter22 at /ping/abcdef, exit status 1"
    assert without_secrets(text, secrets) == "ring: … refused by … for … at /ping/…, exit status 1"


def test_an_archive_takes_the_journal_of_a_copy_only_by_name(tmp_path: Path) -> None:
    small, url = bench(tmp_path), f"sqlite:///{tmp_path / 'archive.sqlite'}"
    for location in ("one", "two"):
        (tmp_path / location).mkdir()
        small.run(tmp_path / location / "run")
    publish_folder(tmp_path / "one" / "run", lambda _: url)
    with pytest.raises(ArchiveForbids, match="--supersede"):
        publish_folder(tmp_path / "two" / "run", lambda _: url)
