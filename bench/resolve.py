"""Two thousand journals solved again: in this process, in two, and on a local Dask cluster of two workers.

One rehearsed run stands for all of them: every job opens its journal, verifies it, solves it and compares the set.
"""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from timeit import Timer

from bench.figure import Figure
from procedures.delivery.resolve import Job, Mapper, chunks, in_this_process, jobs_of
from procedures.delivery.resolve_workers import LEAST_FITS_OF_A_TASK, chunk_size, in_processes, on_cluster

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
JOURNALS = 2000
WORKERS = 2
LEAST_SCALING = 1.5


def figures() -> Iterator[Figure]:
    """Seconds, and how many times faster two are than one."""
    with TemporaryDirectory() as folder:
        job = rehearsed(Path(folder))
        jobs = [job] * JOURNALS
        alone_s = seconds(in_this_process(), jobs, 1)
        each = f"{alone_s / JOURNALS * 1e3:.1f} ms each"
        yield Figure(f"{JOURNALS} journals solved again", alone_s, "s", 120.0, at_most=True, note=each)
        pool_s = seconds(in_processes(WORKERS), jobs, chunk_size(JOURNALS, WORKERS))
        yield _scaling("two processes", alone_s, pool_s)
        with local_cluster() as address:
            dask_s = seconds(on_cluster(address), jobs, LEAST_FITS_OF_A_TASK)
        yield _scaling("Dask, two workers", alone_s, dask_s)


def _scaling(what: str, alone_s: float, together_s: float) -> Figure:
    ratio = alone_s / together_s
    return Figure(f"  one process / {what}", ratio, "×", LEAST_SCALING, at_most=False, note=f"{together_s:.1f} s")


def rehearsed(folder: Path) -> Job:
    """A finished run, as the archive beside it knows it."""
    procedure = folder / "procedure.toml"
    procedure.write_text(PROCEDURE, encoding="utf-8")
    command = [sys.executable, "-m", "procedures.cli.main", "run", str(procedure), "--rig", str(RIG), "--rehearse"]
    subprocess.run([*command, "--out", str(folder / "runs")], check=True, capture_output=True)
    (job,) = jobs_of(f"sqlite:///{folder / 'runs' / 'archive.sqlite'}")
    return job


def seconds(place: AbstractContextManager[Mapper], jobs: list[Job], size: int) -> float:
    """Of all jobs, the start of the workers left out."""
    with place as mapper:
        told = [one.outcome for answers in mapper(chunks(jobs[:WORKERS], 1)) for one in answers]
        taken = Timer(lambda: told.extend(one.outcome for part in mapper(chunks(jobs, size)) for one in part)).timeit(1)
    assert set(told) == {"same"}, set(told)
    return taken


@contextmanager
def local_cluster() -> Iterator[str]:
    """The address of a scheduler with two single-threaded workers, gone with the context."""
    from distributed import LocalCluster

    cluster = LocalCluster(n_workers=WORKERS, threads_per_worker=1, dashboard_address=None)  # type: ignore[no-untyped-call]
    try:
        yield str(cluster.scheduler_address)
    finally:
        cluster.close()  # type: ignore[no-untyped-call]
