"""Every orderly ending at any moment: the run ends as its table says, goes on, and has the numbers of its brother.

A moment is so long after one of the things that a run tells, by the clock and not by the engine: it falls into commits,
waits, motions and the safe stop alike.
"""

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from small_run import Bench, bench, in_child, measured_in, resumed

from procedures.errors import RequestError
from procedures.journal.requests.spool import ask
from procedures.journal.status.status import status
from procedures.records.progress import Progress
from procedures.records.states import State
from rig.clock import SystemClock

pytestmark = [pytest.mark.usefixtures("terminal_signals"), pytest.mark.timeout(3600)]
CLOCK = SystemClock()
MOST_RESUMES = 2
LATEST_S = 0.03
"""Longer than the run works between two things that it tells."""


class _Says:
    """Tells the process that listens of everything that a run tells."""

    def __init__(self, pipe: int) -> None:
        self._pipe = pipe

    def on_event(self, progress: Progress) -> None:
        with suppress(BrokenPipeError):
            os.write(self._pipe, b".")


@dataclass(frozen=True)
class Brothers:
    """A small run that nobody ended, and how much it told."""

    small: Bench
    clean: Path
    events: int


@pytest.fixture(scope="module")
def brothers(tmp_path_factory: pytest.TempPathFactory) -> Brothers:
    folder = tmp_path_factory.mktemp("brothers")
    small, found = bench(folder), 0
    with _at_work(small, folder / "clean") as (_, heard):
        while os.read(heard, 1):
            found += 1
    return Brothers(small, folder / "clean", found)


@contextmanager
def _at_work(small: Bench, run_dir: Path) -> Iterator[tuple[int, int]]:
    """A run in a process of its own, and what it tells; waited for at the end."""
    heard, said = os.pipe()
    child = in_child(lambda: (os.close(heard), small.run(run_dir, observer=_Says(said))))
    os.close(said)
    try:
        yield child, heard
    finally:
        os.close(heard)
        os.waitpid(child, 0)


def _signals(*numbers: signal.Signals) -> Callable[[int, Path], None]:
    def send(child: int, _run_dir: Path) -> None:
        for number in numbers:
            os.kill(child, number)
            CLOCK.sleep(0.002)

    return send


def _abort(_child: int, run_dir: Path) -> None:
    with suppress(RequestError):  # it has just finished
        ask(run_dir, "abort", "anna", CLOCK.now_utc())


ENDINGS = {
    "TERM": (_signals(signal.SIGTERM), State.STOPPED),
    "HUP": (_signals(signal.SIGHUP), State.FINISHED),
    "abort": (_abort, State.ABORTED),
    "Ctrl-C twice": (_signals(signal.SIGINT, signal.SIGINT), State.ABORTED),
}
SEEDS = [1, *[pytest.param(seed, marks=pytest.mark.soak) for seed in range(2, 101)]]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    "how", ["TERM", "abort", *[pytest.param(how, marks=pytest.mark.thorough) for how in ("HUP", "Ctrl-C twice")]]
)
def test_fault_76_an_orderly_ending_at_any_moment_costs_no_run(
    brothers: Brothers, tmp_path: Path, how: str, seed: int
) -> None:
    end, state = ENDINGS[how]
    run_dir, chance = tmp_path / "run", np.random.default_rng([seed, len(how)])
    with _at_work(brothers.small, run_dir) as (child, heard):
        for _ in range(int(chance.integers(1, brothers.events))):
            os.read(heard, 1)
        CLOCK.sleep(float(chance.uniform(0.0, LATEST_S)))
        end(child, run_dir)
    # A second interrupt that comes when the first has stopped the run, and all that comes behind the end, ends nothing.
    assert status(run_dir).state in {state, State.FINISHED, *([State.STOPPED] if how == "Ctrl-C twice" else [])}
    for _ in range(MOST_RESUMES):
        if status(run_dir).state is not State.FINISHED:
            resumed(run_dir)
    assert status(run_dir).state is State.FINISHED
    assert measured_in(run_dir) == measured_in(brothers.clean)
