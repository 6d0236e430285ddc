"""Processes that do tasks: all are answered, and a process that dies, stands still or fails keeps nobody waiting."""

import math
import os
from signal import SIGINT, SIGKILL, SIGSTOP, raise_signal

import psutil
import pytest
from blas_threads import blas_threads

from procedures.delivery.worker_processes import WorkerDied, worker_processes

LARGER_THAN_ANY_BUFFER = 10_000_000


def workers() -> list[psutil.Process]:
    children = [child for child in psutil.Process().children() if child.status() != psutil.STATUS_ZOMBIE]
    return [child for child in children if "spawn_main" in " ".join(child.cmdline())]


def test_every_task_is_answered_once_and_the_processes_do_the_next() -> None:
    with worker_processes(2, math.factorial) as answers:
        assert sorted(answers(range(7))) == [1, 1, 2, 6, 24, 120, 720]
        assert list(answers([])) == []
        assert list(answers([4])) == [24]


def test_a_process_that_dies_at_its_task_is_told() -> None:
    with worker_processes(1, raise_signal) as answers, pytest.raises(WorkerDied):
        list(answers([SIGKILL, SIGINT]))


def test_a_process_that_was_killed_takes_no_task_however_large() -> None:
    with worker_processes(1, len) as answers:
        assert list(answers([b""])) == [0]
        (worker,) = workers()
        worker.kill()
        with pytest.raises(WorkerDied):
            list(answers([bytes(LARGER_THAN_ANY_BUFFER)] * 3))


def test_processes_end_with_the_context_whatever_they_do() -> None:
    with worker_processes(2, raise_signal) as answers:
        next(answers([SIGINT, SIGSTOP]))
        os.waitid(os.P_ALL, 0, os.WSTOPPED | os.WNOWAIT)
        running = workers()
        assert len(running) == 2
    assert not any(worker.is_running() for worker in running)


def test_an_interrupt_is_left_to_the_process_that_gives_the_tasks() -> None:
    with worker_processes(1, raise_signal) as answers:
        assert list(answers([SIGINT])) == [None]


def test_what_a_task_raises_is_raised_again_with_its_traceback() -> None:
    with worker_processes(1, math.sqrt) as answers:
        with pytest.raises(ValueError, match="math domain error") as caught:
            list(answers([-1.0]))
        assert "worker_processes.py" in "".join(caught.value.__notes__)
        assert list(answers([4.0])) == [2.0]


def test_linear_algebra_has_one_thread_in_each(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    with worker_processes(1, blas_threads) as answers:
        (threads,) = answers([8])
    assert set(threads) == {1}
