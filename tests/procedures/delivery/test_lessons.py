"""Laws of learning from the archive: a run that is published teaches the next `check` of its rig, and no other."""

from dataclasses import replace
from pathlib import Path

import pytest
from command import call
from finished_job import FinishedJob

from ams.archive.lessons import keep_lesson, past_lessons
from procedures.check.candidate import SearchRange
from procedures.cli.prepare import plan
from procedures.delivery.lessons import learned
from rig.description.read import read_rig


@pytest.fixture
def taught(finished_job: FinishedJob, tmp_path: Path) -> str:
    """The job's archive, with its run as if it had been made four times."""
    finished_job.copied_to(tmp_path)
    url = f"sqlite:///{tmp_path / 'runs' / 'archive.sqlite'}"
    rig = read_rig(finished_job.folder / "rig.toml")
    (lesson,) = past_lessons(url, rig.rig.name, simulated=True, most=30)
    for name in "abc":
        keep_lesson(url, replace(lesson, journal_sha256=name * 64))
    return url


def test_a_published_run_teaches_and_check_says_by_how_many(taught: str, finished_job: FinishedJob, capsys) -> None:
    files = finished_job.folder / "procedure.toml", "--rig", finished_job.folder / "rig.toml"
    first = call(capsys, "check", *files, "--out", finished_job.folder / "nowhere", "--json").document
    outcome = call(capsys, "check", *files, "--archive", taught, "--json").document
    assert (first["duration_learned_from"], outcome["duration_learned_from"]) == (0, 4)
    assert outcome["duration_s"]["p50"] == pytest.approx(first["duration_s"]["p50"], rel=0.1)
    assert sum(part["p50"] for part in outcome["duration_parts_s"].values()) == pytest.approx(
        outcome["duration_s"]["p50"]
    )
    sources = {
        axis["noise_source"]
        for axes in outcome["expected_standard_uncertainty"].values()
        for axis in axes.values()
    }  # fmt: skip
    assert all("4 past runs of this rig" in source for source in sources)
    shown = call(capsys, "check", *files, "--archive", taught)
    assert "by 4 past runs of this rig" in " ".join(shown.out.split())


def test_a_plan_takes_the_hours_that_past_runs_of_the_rig_took_and_says_so(
    taught: str, finished_job: FinishedJob, capsys, monkeypatch
) -> None:
    """Past runs that took twice as long make every candidate take twice as long."""
    few = SearchRange(
        grids=((4, 6),), fractions=(), optimal=(), replications=(3,), samples=(5,), orders=("serpentine",)
    )
    monkeypatch.setattr(plan, "SEARCH_RANGE", few)
    rig = read_rig(finished_job.folder / "rig.toml")
    text = "plan", "--rig", finished_job.folder / "rig.toml", "--hours", "100", "--archive", taught
    before = call(capsys, *text, "--json").document
    for lesson in past_lessons(taught, rig.rig.name, simulated=True, most=30):
        slower = [replace(part, measured_s=2.0 * part.measured_s) for part in lesson.parts]
        keep_lesson(taught, replace(lesson, parts=slower))
    after = call(capsys, *text, "--json").document
    assert (before["duration_learned_from"], after["duration_learned_from"]) == (4, 4)
    for entry, other in zip(before["candidates"], after["candidates"], strict=True):
        assert other["hours"] == pytest.approx(2.0 * entry["hours"], rel=1e-6)
    assert "by 4 past runs of this rig" in " ".join(call(capsys, *text).out.split())
    nowhere = "plan", "--rig", finished_job.folder / "rig.toml", "--hours", "100", "--runs", finished_job.folder / "no"
    assert "by the files alone" in " ".join(call(capsys, *nowhere).out.split())


def test_a_real_rig_learns_nothing_from_simulated_runs(taught: str, finished_job: FinishedJob) -> None:
    rig = read_rig(finished_job.folder / "rig.toml")
    assert learned(taught, rig).times.runs == 4
    real = rig.model_copy(update={"twin": None, **_on_real_ports(rig)})
    assert not real.is_simulated
    assert learned(taught, real).times.runs == 0
    assert learned(taught, real).pilot is None


def _on_real_ports(rig) -> dict[str, object]:
    indices = {"axes": "port", "readouts": "resource", "environment": "port"}
    return {
        table: {name: entry.model_copy(update={key: "socket://h:1"}) for name, entry in getattr(rig, table).items()}
        for table, key in indices.items()
    }


def test_an_archive_that_cannot_be_asked_teaches_nothing_and_refuses_nothing(
    finished_job: FinishedJob, tmp_path: Path
) -> None:
    rig = read_rig(finished_job.folder / "rig.toml")
    (tmp_path / "broken.sqlite").write_bytes(b"no database")
    for name in ("missing", "broken"):
        assert learned(f"sqlite:///{tmp_path / name}.sqlite", rig).times.runs == 0
