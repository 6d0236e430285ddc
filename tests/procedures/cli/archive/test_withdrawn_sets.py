"""What the commands say of a set that was withdrawn: the withdrawal is its verdict, and nothing of it is made again."""

import json
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from archived_runs import a_run, a_sensor
from command import call
from finished_job import FinishedJob

from ams.archive.runs import publish_run
from ams.archive.sets import list_sets, show
from ams.archive.signatures import sign
from ams.exports.formats import export_set, load_set

NOW = datetime(2026, 3, 5, tzinfo=UTC)
SAID = "withdrawn by C. Lim on 2026-03-05 (UTC): wrong mount"


@pytest.fixture
def url(tmp_path: Path) -> str:
    """An archive of two calibrations, the second withdrawn."""
    archive = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    for day in (0, 180):
        publish_run(archive, a_run(day), [a_sensor(day)], NOW)
    sign(archive, "SN1", "withdrawn", "C. Lim", NOW, "wrong mount")
    return archive


def test_list_and_show_tell_the_withdrawal_as_the_verdict(url: str, capsys: pytest.CaptureFixture[str]) -> None:
    listed = call(capsys, "archive", "list", "--archive", url).out.splitlines()
    assert listed[2].endswith(f"pitch-roll, {SAID}: not to be used")
    assert not any(word in listed[2] for word in ("sound", "usable", "pass", "fail", "verdict"))
    first, second = call(capsys, "archive", "list", "--archive", url, "--json").document["sets"]
    assert (second["status"], second["verdict"], second["as_found"], second["as_left"]) == ("withdrawn", *[None] * 3)
    assert second["withdrawal"] == {
        "name": "C. Lim", "withdrawn_utc": "2026-03-05T00:00:00+00:00", "reason": "wrong mount"
    }  # fmt: skip
    assert first["withdrawal"] is None
    shown = call(capsys, "archive", "show", "SN1", "--archive", url).out
    assert "\nverdict: withdrawn, not to be used (the calibration had said " in shown
    assert "verdict of the calibration" not in shown
    assert "as found: none (not judged, the set of this run is withdrawn)" in shown
    whole = call(capsys, "archive", "show", first["sha256"], "--archive", url).out
    assert "\nverdict of the calibration: " in whole
    assert "withdrawn" not in whole


def test_a_run_whose_set_was_withdrawn_is_solved_without_a_set_and_says_so(
    finished_job: FinishedJob, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = finished_job.copied_to(tmp_path)
    url, written = f"sqlite:///{run.parent / 'archive.sqlite'}", run / "coefficients" / "SN1047.json"
    sign(url, "SN1047", "withdrawn", "C. Lim", NOW, "wrong mount")
    written.unlink()
    solved = call(capsys, "solve", run)
    assert SAID in " ".join(solved.out.split())
    assert not written.exists()
    assert [entry.status for entry in list_sets(url)] == ["withdrawn"]
    page = (run / "report.html").read_text(encoding="utf-8")
    assert f"WITHDRAWN <span>The set of SN1047 is {SAID}. It must not be used.</span>" in page
    assert f"verdict: Not to be used: the set of SN1047 is {SAID}." in call(capsys, "status", run).out
    published = call(capsys, "archive", "publish", run, "--archive", url)
    assert SAID in published.out + published.err
    assert [entry.status for entry in list_sets(url)] == ["withdrawn"]


def test_a_set_of_a_file_is_published_by_its_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`calrig fit --set` writes one: it was "a file and not a run's journal.sqlite"."""
    observations = Path(__file__).parents[4] / "examples" / "observations.csv"
    stored, url = tmp_path / "SN1047.json", f"sqlite:///{tmp_path / 'archive.sqlite'}"
    axes = [word for axis in "xyz" for word in ("--axis", f"{axis}=s{axis}_v")]
    stated = ("--sensor", "SN1047", "--gravity-mps2", 9.79826, "--calibrated-on", "2026-03-01", "--set", stored)
    call(capsys, "fit", observations, *axes, *stated)
    sha256 = load_set(stored).sha256
    for is_new, outcome in ((True, "published"), (False, "was there already")):
        if is_new:
            (entry,) = call(capsys, "archive", "publish", stored, "--archive", url, "--json").document["sets"]
            assert entry == {
                "sha256": sha256, "sensor": "SN1047", "is_new": True, "exchanged": "", "exchanged_before": "",
                "withdrawal": None,
            }  # fmt: skip
            continue
        assert (
            f"{sha256[:12]}  SN1047           {outcome}"
            in call(capsys, "archive", "publish", stored, "--archive", url).out
        )
    assert show(url, "SN1047").document == json.loads(stored.read_text(encoding="utf-8"))
    sign(url, "SN1047", "withdrawn", "C. Lim", NOW, "wrong mount")
    again = call(capsys, "archive", "publish", stored, "--archive", url)
    assert f"was there already, {SAID}: it must not be used" in again.out


def test_what_is_no_set_of_a_file_is_not_published_as_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    url = f"sqlite:///{tmp_path / 'archive.sqlite'}"
    of_run, text = tmp_path / "of-run.json", tmp_path / "words.txt"
    export_set(a_sensor(0).coefficients, "json", of_run)
    text.write_text("words", encoding="utf-8")
    refused = call(capsys, "archive", "publish", of_run, "--archive", url)
    assert (refused.status, "is the set of the run run-0" in refused.err) == (2, True)
    assert "calrig archive publish run-0" in refused.err
    refused = call(capsys, "archive", "publish", text, "--archive", url)
    assert (refused.status, "is no coefficient set by its name" in refused.err) == (2, True)
    answered = ("--override", "late", "--operator", "A. Ray")
    assert "belong to runs" in call(capsys, "archive", "publish", of_run, *answered, "--archive", url).err
    assert not (tmp_path / "archive.sqlite").exists()


def test_a_set_whose_run_was_published_again_is_not_signed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As by `calrig resolve --publish`: two sets of one run stood side by side, and either could be signed."""
    archive, run = f"sqlite:///{tmp_path / 'archive.sqlite'}", a_run(0)
    publish_run(archive, run, [a_sensor(0)], NOW)
    publish_run(archive, run, [a_sensor(0, gain=1.001)], NOW + timedelta(days=1))
    before, after = (entry.sha256[:12] for entry in list_sets(archive))
    refused = call(capsys, "archive", "sign", before, "prepared", "--operator", "A. Ray", "--archive", archive)
    assert (refused.status, f"was published again since, as set {after}" in refused.err) == (2, True)
    allowed = call(capsys, "archive", "sign", after, "prepared", "--operator", "A. Ray", "--archive", archive)
    assert "nobody of that name has an account" in allowed.err
    sign(archive, after, "withdrawn", "C. Lim", NOW, "wrong treatment")
    again = call(capsys, "archive", "sign", before, "prepared", "--operator", "A. Ray", "--archive", archive)
    assert "nobody of that name has an account" in again.err
