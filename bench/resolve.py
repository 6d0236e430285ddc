"""Two hundred journals solved again: in this process, in two, and on a local Dask cluster of two workers.

Two thousand, as an archive of years has, take ten times as long, and tell no more of a journal or of the scaling: a
task has tens of journals, and the start of the workers is left out. One simulated run stands for all of them: every
job opens its journal, verifies it, solves it and compares the set.
Beside the scaling stands the machine's own, measured in the same run: what two processes of NumPy gain there that know
nothing of one another. Two hardware threads of one core, or a neighbour at work, leave less than two to be gained by
anybody: there two processes gave 1.15 × where the machine's own was 1.18 ×. What is demanded is nine tenths of the
machine's own, and 1.8 × where the machine has so much to give.
"""

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from timeit import Timer

import numpy as np

from bench.figure import Effort, Figure
from procedures.delivery.publish_folder import publish_folder
from procedures.delivery.resolve import Job, Mapper, chunks, jobs_of
from procedures.delivery.resolve_workers import LEAST_FITS_OF_A_TASK, chunk_size, in_processes, on_cluster
from procedures.delivery.worker_processes import worker_processes
from procedures.journal.header import make_header
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.run.begin import begin
from rig.assembly.open_rig import open_rig
from rig.description.read import read_rig

RIG = Path(__file__).parents[1] / "examples" / "rig.toml"
PROCEDURE = """
[procedure]
title = "small grid"
kind = "grid"
replications = 2
[design]
kind = "D"
pitch_deg = { from = -60.0, to = 60.0, step = 30.0 }
roll_deg = { from = -180.0, to = 120.0, step = 60.0 }
"""
WORKERS = 2
JOURNALS = 200
LEAST_SCALING = 1.8
LEAST_OF_THE_MACHINE = 0.9
ROUNDS = 4000


def figures(effort: Effort) -> Iterator[Figure]:
    """Seconds, and how many times faster two are than one."""
    with TemporaryDirectory() as folder:
        jobs = [finished(Path(folder))] * effort.amount(JOURNALS, 2)
        alone_s = seconds(in_processes(1), jobs, chunk_size(len(jobs), 1))
        each = f"{alone_s / len(jobs) * 1e3:.1f} ms each"
        yield Figure(f"{len(jobs)} journals solved again", alone_s, "s", 0.025 * len(jobs), at_most=True, note=each)
        machine = machine_scaling(effort.amount(ROUNDS, 10))
        yield Figure(
            "  one process / two processes of NumPy", machine, "×", 1.0, at_most=False, note="the machine's own"
        )
        pool_s = seconds(in_processes(WORKERS), jobs, chunk_size(len(jobs), WORKERS))
        yield from _scaling("two processes", alone_s / pool_s, machine)
        with local_cluster(in_processes=not effort.is_tiny) as address:
            dask_s = seconds(on_cluster(address), jobs, LEAST_FITS_OF_A_TASK)
        yield from _scaling("Dask, two workers", alone_s / dask_s, machine)


def _scaling(what: str, ratio: float, machine: float) -> Iterator[Figure]:
    demanded = min(LEAST_SCALING, LEAST_OF_THE_MACHINE * machine)
    yield Figure(f"  one process / {what}", ratio, "×", demanded, at_most=False)
    yield Figure(f"    {what}: share of the machine's own", ratio / machine, "", LEAST_OF_THE_MACHINE, at_most=False)


def machine_scaling(rounds: int) -> float:
    """Return how many times faster two processes do NumPy's work than one does the same, their start left out."""
    with worker_processes(WORKERS, numpy_work) as answers:
        list(answers([10] * WORKERS))
        alone_s = Timer(lambda: list(answers([WORKERS * rounds]))).timeit(1)
        together_s = Timer(lambda: list(answers([rounds] * WORKERS))).timeit(1)
    return alone_s / together_s


def numpy_work(rounds: int) -> float:
    """Solve small least squares, as a calibration does."""
    matrix = np.random.default_rng(1).normal(size=(60, 10))
    return float(sum(np.linalg.lstsq(matrix, matrix[:, index % 10], rcond=None)[0].sum() for index in range(rounds)))


def finished(folder: Path) -> Job:
    """Return a finished run, as the archive beside it knows it."""
    procedure, run_dir = folder / "procedure.toml", folder / "run"
    procedure.write_text(PROCEDURE, encoding="utf-8")
    run_dir.mkdir()
    description = read_rig(RIG)
    plan = make_plan(description, read_procedure(procedure))
    header = make_header(run_dir.name, plan, description, RIG, procedure, "bench", datetime.now(UTC))
    with open_rig(description) as rig:
        begin(run_dir, header, plan, rig)
    url = publish_folder(run_dir, lambda _: f"sqlite:///{folder / 'archive.sqlite'}").archive_url
    (job,) = jobs_of(url)
    return job


def seconds(workers: AbstractContextManager[Mapper], jobs: list[Job], size: int) -> float:
    """Of all jobs, the start of the workers left out."""
    with workers as mapper:
        outcomes = [answer.outcome for answers in mapper(chunks(jobs[:WORKERS], 1)) for answer in answers]
        taken = Timer(
            lambda: outcomes.extend(answer.outcome for part in mapper(chunks(jobs, size)) for answer in part)
        ).timeit(1)
    assert set(outcomes) == {"same"}, set(outcomes)
    return taken


@contextmanager
def local_cluster(*, in_processes: bool) -> Iterator[str]:
    """The address of a scheduler with two single-threaded workers, gone with the context."""
    from distributed import LocalCluster

    cluster = LocalCluster(  # type: ignore[no-untyped-call]
        n_workers=WORKERS, threads_per_worker=1, dashboard_address=":0", processes=in_processes, protocol="tcp://"
    )
    try:
        yield str(cluster.scheduler_address)
    finally:
        cluster.close()
