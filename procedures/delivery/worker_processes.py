"""Processes of this machine that do one task after another; one that dies is told at once, and nobody waits for it.

Each has a line to itself and is sent a task when it has answered the one before. Nobody else holds the other end of the
line, so the system closes it with the process: whoever waits for an answer, or is in the middle of sending a task of
any size, gets an error then. ``concurrent.futures`` writes the tasks of all its processes into a single pipe, from a
thread, and holds both ends of it: where a process is killed, it waits for that thread for ever (CPython gh-94777 up to
3.11.4; gh-114440, on Windows, up to 3.12.1).

A process has one BLAS thread: many small fits gain nothing from more, and lose to each other.
"""

import signal
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from traceback import format_exc
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

Task = TypeVar("Task")
Answer = TypeVar("Answer")


class WorkerDied(Exception):
    """A process ended before it had answered."""


@contextmanager
def worker_processes(
    count: int, work: Callable[[Task], Answer]
) -> Iterator[Callable[[Sequence[Task]], Iterator[Answer]]]:
    """Yield what has so many new processes do tasks, and yields the answers as they come, in any order.

    Tasks, answers and ``work`` travel by pickle. What ``work`` raises is raised again here, with its traceback as a
    note. The processes end with the context, whatever they are doing; answers are read to their end before the next
    tasks are given.

    Raises, where answers are taken: WorkerDied.
    """
    with ExitStack() as ending:
        lines = [ending.enter_context(_worker(work)) for _ in range(count)]
        yield lambda tasks: _answers(lines, tasks)


@contextmanager
def _worker(work: Callable[[Any], Any]) -> "Iterator[Connection[Any, Any]]":
    context = get_context("spawn")
    pair: tuple[Any, Any] = context.Pipe()  # of another class on Windows, with the same methods
    ours, theirs = pair
    process = context.Process(target=_serve, args=(theirs, work), daemon=True)
    process.start()
    theirs.close()  # only the process holds that end now
    try:
        yield ours
    finally:
        process.kill()
        process.join()
        ours.close()


def _answers(lines: "Sequence[Connection[Any, Any]]", tasks: Sequence[Any]) -> Iterator[Any]:
    left = deque(tasks)
    busy = list(lines[: len(left)])
    for line in busy:
        _send(line, left.popleft())
    while busy:
        ready = wait(busy)
        for line in [line for line in busy if line in ready]:
            answer = _received(line)
            if left:
                _send(line, left.popleft())
            else:
                busy.remove(line)
            yield answer


def _send(line: "Connection[Any, Any]", task: Any) -> None:
    try:
        line.send(task)
    except OSError as error:
        raise WorkerDied from error


def _received(line: "Connection[Any, Any]") -> Any:
    try:
        answer, error = line.recv()
    except (EOFError, OSError) as lost:
        raise WorkerDied from lost
    if error is not None:
        raise error
    return answer


def _serve(line: "Connection[Any, Any]", work: Callable[[Any], Any]) -> None:
    """Do what is sent until the other end is closed. An interrupt is for the process at that end to decide upon."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with line, suppress(EOFError, OSError):
        while True:
            line.send(_outcome(work, line.recv()))


def _outcome(work: Callable[[Any], Any], task: Any) -> tuple[Any, Exception | None]:
    try:
        with threadpool_limits(limits=1, user_api="blas"):
            return work(task), None
    except Exception as error:  # noqa: BLE001  raised again where the answer is taken
        error.add_note(format_exc())
        return None, error
