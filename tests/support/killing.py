"""Runs in forked children that are killed, and what the journal must hold afterwards.

One warmed process forks a child a kill: everything is imported already, so a kill costs what it interrupts.
"""

import os
import signal
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from small_run import Bench, dwells_of, measured, resumed
from without_times import without_times

from procedures.delivery.deliver import sensors_document, solve_run
from procedures.journal.sidecar.owner import is_owned
from procedures.journal.status.status import status
from procedures.journal.storage import JOURNAL_FILE
from procedures.records.dwells import DwellRecord
from procedures.records.progress import Progress, RunObserver
from procedures.records.states import State
from procedures.run.ending import Outcome
from procedures.run.resume import resume
from rig.clock import SystemClock
from rig.crash_points import VARIABLE

Aim = Callable[[int], None]
"""Kills a child, or leaves it alone; given its process id. Called in the parent."""
RunOnce = Callable[[RunObserver], Outcome]


class Acknowledges:
    """Tells a pipe of every dwell that the engine says is stored: what an operator has seen on the screen."""

    def __init__(self, pipe: int) -> None:
        self._pipe = pipe

    def on_event(self, progress: Progress) -> None:
        if progress.event in ("dwell", "rejected"):
            os.write(self._pipe, b".")


@dataclass
class Killed:
    """How one child ended."""

    was_killed: bool
    acknowledged: int


def run_child(work: RunOnce, crash: str | None, aim: Aim = lambda child: None) -> Killed:
    """``work`` in a child with ``crash`` in the variable of the crash points; ``aim`` may kill it from outside."""
    ours, theirs = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(ours)
        _live(work, crash, theirs)
    os.close(theirs)
    try:
        aim(child)
        _, ended = os.waitpid(child, 0)
        acknowledged = _drained(ours)
    finally:
        os.close(ours)
    assert os.WIFSIGNALED(ended) or os.waitstatus_to_exitcode(ended) == 0, "the child failed by itself"
    return Killed(os.WIFSIGNALED(ended), acknowledged)


def _live(work: RunOnce, crash: str | None, pipe: int) -> None:
    ended = 1
    try:
        if crash is not None:
            os.environ[VARIABLE] = crash
        work(Acknowledges(pipe))
        ended = 0
    finally:
        os._exit(ended)


def _drained(pipe: int) -> int:
    count = 0
    while data := os.read(pipe, 65536):
        count += len(data)
    return count


def after(delay_s: float) -> Aim:
    """SIGKILL from outside after so long."""

    def aim(child: int) -> None:
        SystemClock().sleep(delay_s)
        os.kill(child, signal.SIGKILL)

    return aim


@dataclass
class Target:
    """A campaign, what it measures when nobody kills it, and how long that takes."""

    bench: Bench
    folder: Path
    clean: Mapping[int, tuple[object, ...]]
    solution: Mapping[str, object]
    whole_s: float
    made: int = 0

    @staticmethod
    def of(bench: Bench, folder: Path) -> "Target":
        clock = SystemClock()
        bench.run(folder / "warm-up")
        began_s = clock.monotonic_s()
        assert bench.run(folder / "clean").state is State.FINISHED
        whole_s = clock.monotonic_s() - began_s
        found = measured(dwells_of(folder / "clean"))
        assert found.keys() == {dwell.step for dwell in bench.plan.dwells if dwell.purpose != "check"}
        return Target(bench, folder, found, without_times(sensors_document(solve_run(folder / "clean"))), whole_s)

    def new_folder(self) -> Path:
        self.made += 1
        return self.folder / f"run-{self.made}"

    def require_the_clean_result(self, run_dir: Path) -> None:
        """Identical dwells, identical coefficients."""
        assert measured(dwells_of(run_dir)) == self.clean
        assert without_times(sensors_document(solve_run(run_dir))) == self.solution


def require_kept(run_dir: Path, acknowledged: int, before: list[DwellRecord]) -> list[DwellRecord]:
    """After a kill: every dwell of before as it was, all that were acknowledged, at most one more.

    The reader verifies file, chain and every SHA-256.
    """
    assert not is_owned(run_dir)
    dwells = dwells_of(run_dir)
    assert [dwell.sha256 for dwell in dwells[: len(before)]] == [dwell.sha256 for dwell in before]
    assert acknowledged <= len(dwells) - len(before) <= acknowledged + 1
    return dwells


def kill_and_resume(target: Target, first: tuple[str | None, Aim | None], chance: np.random.Generator) -> int:
    """One run, killed first as told and then at random moments until it is finished; returns how often."""
    run_dir = target.new_folder()
    crash, aim = first
    ended = run_child(lambda seen: target.bench.run(run_dir, observer=seen), crash, aim or (lambda child: None))
    kills, dwells = int(ended.was_killed), []
    while (run_dir / JOURNAL_FILE).exists():  # else it was killed before there was a run, and nothing had moved
        dwells = require_kept(run_dir, ended.acknowledged, dwells)
        if not ended.was_killed:
            break
        assert status(run_dir).state in (State.INTERRUPTED, State.FINISHED)
        if status(run_dir).state is State.FINISHED:
            break
        if chance.uniform() < 0.5:
            assert resumed(run_dir).state is State.FINISHED
            break
        aim = after(chance.uniform(0.0, target.whole_s))
        ended = run_child(lambda seen: resume(run_dir, "tester", "after the kill", seen), None, aim)
        kills += ended.was_killed
    if (run_dir / JOURNAL_FILE).exists():
        target.require_the_clean_result(run_dir)
    return kills
