"""Where archived runs are solved: in spawned processes of this machine, or on a Dask cluster.

A chunk is one task. On a cluster a task costs some milliseconds whatever it holds, so a chunk has at least fifty fits.
A Dask scheduler runs whatever it is sent, so an address that is not on this machine must be ``tls://``.
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from procedures.delivery.resolve import Answer, Job, Mapper, resolve_chunk
from procedures.delivery.worker_processes import WorkerDied, worker_processes
from procedures.errors import RequestError, RunFailed
from procedures.journal.header import calrig_version

if TYPE_CHECKING:
    from distributed import Client

LEAST_FITS_OF_A_TASK = 50
MOST_FITS_OF_A_CHUNK = 50
CHUNKS_OF_A_WORKER = 4
LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
CONNECT_S = 15


def chunk_size(jobs: int, workers: int) -> int:
    """Return the runs of one chunk in a process pool: several chunks a worker, so that none waits long for the last."""
    return max(1, min(MOST_FITS_OF_A_CHUNK, jobs // (CHUNKS_OF_A_WORKER * workers)))


@contextmanager
def in_processes(workers: int) -> Iterator[Mapper]:
    """Yield a mapper over so many processes of this machine."""
    with worker_processes(workers, resolve_chunk) as answers:
        yield lambda parts: _of_living(answers(parts))


def _of_living(answers: Iterator[list[Answer]]) -> Iterator[list[Answer]]:
    try:
        yield from answers
    except WorkerDied as error:
        raise RunFailed(
            "resolve: a worker process died (killed, or out of memory); nothing was written; "
            "do it again, with fewer --workers if memory was short"
        ) from error


@contextmanager
def on_cluster(address: str) -> Iterator[Mapper]:
    """Yield a mapper over a Dask cluster. Raises: RequestError for an address or workers that cannot be used."""
    _require_safe(address)
    client = _connected(address)
    try:
        ours = calrig_version()
        theirs: dict[str, Any] = client.run(calrig_version)
        others = {version for version in theirs.values() if version != ours}
        if not theirs or others:
            found = "no worker is there" if not theirs else f"workers have calrig {', '.join(sorted(map(str, others)))}"
            raise RequestError(
                f"--dask: {found}, this is {ours}; nothing was solved; start workers of the same version"
            )
        yield lambda parts: _on_client(client, parts)
    finally:
        client.close()  # type: ignore[no-untyped-call]


def _require_safe(address: str) -> None:
    protocol, _, host = address.rpartition("://")
    if protocol == "tls" or host.rpartition(":")[0] in LOOPBACK:
        return
    raise RequestError(
        f"--dask: got {address}, allowed are tls://HOST:PORT and, on this machine, tcp://127.0.0.1:PORT; nothing was "
        "solved; a scheduler without TLS runs whatever anybody sends it"
    )


def _connected(address: str) -> "Client":
    try:
        from distributed import Client
    except ImportError as error:
        raise RequestError(
            f"--dask: the library is missing: {error}; nothing was solved; pip install 'calrig[cluster]'"
        ) from error
    try:
        return Client(address, timeout=CONNECT_S, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError, TypeError) as error:
        raise RunFailed(
            f"--dask {address}: no scheduler answers within {CONNECT_S} s: {error}; nothing was solved; start it, and "
            "give its certificates in Dask's own settings (DASK_DISTRIBUTED__COMM__TLS__…)"
        ) from error


def _on_client(client: "Client", parts: Sequence[Sequence[Job]]) -> Iterator[list[Answer]]:
    from distributed import KilledWorker, as_completed

    waiting = client.map(resolve_chunk, parts, pure=False)
    try:
        for future, answers in as_completed(waiting, loop=client.loop, with_results=True):  # type: ignore[no-untyped-call]
            yield answers
            future.release()
    except (KilledWorker, CancelledError, OSError) as error:
        raise RunFailed(f"--dask: the cluster failed: {error}; nothing was written; look at its workers") from error
    finally:
        client.cancel(waiting)  # type: ignore[no-untyped-call]
