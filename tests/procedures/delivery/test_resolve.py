"""Archived runs solved again: the same numbers in this process, in others and on a cluster; what changed is told."""

import json
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import psutil
import pytest
from small_run import bench

from ams.archive.sets import list_sets
from procedures.cli.main import run_command
from procedures.delivery.deliver import primaries_of, sets_of, solve_run
from procedures.delivery.publish_folder import publish_folder
from procedures.delivery.resolve import Answer, Job, Mapper, Treatment, chunks, in_this_process, jobs_of, resolve_job
from procedures.delivery.resolve_workers import LEAST_FITS_OF_A_TASK, chunk_size, in_processes, on_cluster
from procedures.errors import RunFailed

WIDER = (
    ("from = -30.0, to = 30.0", "from = -60.0, to = 60.0"),
    ("from = -180.0, to = 90.0, step = 90.0", "from = -180.0, to = 120.0, step = 60.0"),
)


@dataclass(frozen=True)
class Archived:
    url: str
    run: Path
    job: Job


@pytest.fixture(scope="module")
def archived(tmp_path_factory: pytest.TempPathFactory) -> Archived:
    """One finished run, published."""
    folder = tmp_path_factory.mktemp("resolve")
    small = bench(folder, procedure=WIDER)
    small.run(folder / "run")
    url = publish_folder(folder / "run", lambda _: f"sqlite:///{folder / 'archive.sqlite'}").archive_url
    (job,) = jobs_of(url)
    return Archived(url, folder / "run", job)


def outcomes(mapper: Mapper, jobs: list[Job], size: int) -> list[Answer]:
    return [answer for answers in mapper(chunks(jobs, size)) for answer in answers]


def test_an_unchanged_run_gives_the_same_numbers_and_the_same_bytes(archived: Archived) -> None:
    assert resolve_job(archived.job).outcome == "same"
    first, again = (sets_of(solve_run(archived.run))["SN1"] for _ in range(2))
    assert first.sha256 == again.sha256 == list_sets(archived.url)[0].sha256


def test_a_number_beyond_rounding_is_told_with_its_size(archived: Archived) -> None:
    document = json.loads(archived.job.sets["SN1"])
    values = document["axes"]["y"]["primary"]["values"]
    scale = sum(map(abs, values.values()))
    values["k_y_v_per_g"] += 0.4e-12 * scale
    below = replace(archived.job, sets={"SN1": json.dumps(document)})
    assert resolve_job(below).outcome == "same"
    values["k_y_v_per_g"] += 3e-9 * scale
    answer = resolve_job(replace(archived.job, sets={"SN1": json.dumps(document)}))
    (change,) = answer.changes
    assert (change.sensor, change.axis, change.name) == ("SN1", "y", "k_y_v_per_g")
    assert change.of_scale == pytest.approx(3e-9, rel=1e-3)
    assert change.in_uncertainties is not None


def test_a_sensor_or_axis_that_came_or_went_is_a_change(archived: Archived) -> None:
    document = json.loads(archived.job.sets["SN1"])
    del document["axes"]["z"]
    gone = resolve_job(replace(archived.job, sets={"SN1": json.dumps(document), "SN2": archived.job.sets["SN1"]}))
    found = {(change.sensor, change.axis, change.name, change.old, change.new) for change in gone.changes}
    assert found == {("SN1", "z", "axis", None, 1.0), ("SN2", "", "sensor", 1.0, None)}


def test_another_treatment_changes_the_model_and_is_kept_only_when_asked(archived: Archived) -> None:
    linear = replace(archived.job, treatment=Treatment(extended="no"))
    answer = resolve_job(linear)
    assert answer.outcome == "changed"
    assert {"q_xx_v_per_g2", "u(k_x_v_per_g)"} <= {change.name for change in answer.changes}
    assert answer.measured == ()
    kept = resolve_job(replace(linear, keep=True))
    assert kept.measured[0].coefficients.axes["x"].model == "pitch-roll"


def test_a_run_whose_journal_is_gone_or_another_says_so(archived: Archived, tmp_path: Path) -> None:
    gone = resolve_job(replace(archived.job, folders=(str(tmp_path / "nowhere"),)))
    assert (gone.outcome, gone.message) == ("missing", f"no journal in {tmp_path / 'nowhere'}")
    other = resolve_job(replace(archived.job, journal_sha256="0" * 64))
    assert other.outcome == "failed"
    assert "the journal is not the archived one" in other.message


def test_a_moved_run_is_found_in_the_folder_that_is_named(archived: Archived, tmp_path: Path) -> None:
    shutil.copytree(archived.run, tmp_path / archived.job.run_id)
    (job,) = jobs_of(archived.url, tmp_path)
    assert resolve_job(replace(job, folders=job.folders[1:])).outcome == "same"


@pytest.mark.thorough
def test_two_processes_tell_what_one_tells(archived: Archived) -> None:
    jobs = [archived.job, replace(archived.job, run_id="gone", folders=()), archived.job]
    with in_this_process() as mapper:
        alone = outcomes(mapper, jobs, 1)
    with in_processes(2) as mapper:
        together = outcomes(mapper, jobs, 1)
    assert (
        sorted(entry.outcome for entry in together)
        == sorted(entry.outcome for entry in alone)
        == ["missing", "same", "same"]
    )


def test_a_worker_that_is_killed_is_a_sentence(archived: Archived) -> None:
    with in_processes(1) as mapper:
        answers = mapper(chunks([archived.job] * 200, 1))
        next(answers)
        for child in psutil.Process().children(recursive=True):
            if child.status() != psutil.STATUS_ZOMBIE and "spawn_main" in " ".join(child.cmdline()):
                child.kill()
        with pytest.raises(RunFailed, match=r"resolve: a worker process died .*; nothing was written; do it again"):
            list(answers)


@contextmanager
def cluster() -> Iterator[str]:
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None, protocol="tcp", host="127.0.0.1"
    ) as running:
        yield str(running.scheduler_address)


@pytest.mark.filterwarnings("default")  # the library's own, of its own parts
def test_a_dask_cluster_tells_the_same_in_chunks(archived: Archived) -> None:
    with cluster() as address, on_cluster(address) as mapper:
        answers = outcomes(mapper, [archived.job] * 3, LEAST_FITS_OF_A_TASK)
    assert [answer.outcome for answer in answers] == ["same"] * 3


def test_chunks_are_large_enough_for_the_pool_and_keep_every_job(archived: Archived) -> None:
    assert (chunk_size(2000, 2), chunk_size(10, 2), chunk_size(1, 2)) == (50, 1, 1)
    parts = chunks([replace(archived.job, run_id=str(index)) for index in range(7)], 3)
    assert [[job.run_id for job in part] for part in parts] == [["0", "1", "2"], ["3", "4", "5"], ["6"]]


def test_publishing_what_changed_keeps_the_old_and_then_nothing_changes_any_more(
    archived: Archived, capsys: pytest.CaptureFixture[str]
) -> None:
    text = ["resolve", "--archive", archived.url, "--workers", "1", "--extended", "no", "--json"]
    assert run_command([*text, "--publish"]) == 0
    assert json.loads(capsys.readouterr().out)["published"] == 1
    assert len(list_sets(archived.url)) == 2
    assert run_command(text) == 0
    assert json.loads(capsys.readouterr().out)["same"] == 1


def test_what_is_compared_is_what_stands_in_the_set(archived: Archived) -> None:
    solved = solve_run(archived.run)
    built = sets_of(solved)
    assert primaries_of(solved).keys() == built.keys()
    for name, primary in primaries_of(solved).items():
        document = built[name].document["axes"]
        assert {axis: section["primary"] for axis, section in document.items()} == {
            axis: section["primary"] for axis, section in primary["axes"].items()
        }
