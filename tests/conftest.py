"""For all tests: what no law depends on, so that they pass wherever they are run, and what is made once for many.

How long an example of hypothesis takes is no part of any law: a busy machine fails nothing by it; what hangs is ended
by pytest's own time-out.
"""

import os
from collections.abc import Iterator
from functools import partial

import pytest
from finished_job import FinishedJob, finish_job
from hypothesis import settings
from machine_folder_of_tests import enter_machine_folder, leave_machine_folder
from made_once import made_once
from memory_folder import keep_temporary_files_in_memory
from reports_left_out import reports_left_out
from signals import default_signals

settings.register_profile("calrig", deadline=None, max_examples=50)
settings.load_profile("calrig")


def pytest_configure(config: pytest.Config) -> None:
    """Keep what tests write in memory where that can be: journals sync at every dwell, and a disk takes its time.

    Nothing of it goes into the log of whoever tests, and nobody who tests beside it holds its rigs.
    """
    os.environ["CALRIG_LOG"] = "off"
    keep_temporary_files_in_memory()
    config.add_cleanup(partial(leave_machine_folder, enter_machine_folder()))


def pytest_xdist_auto_num_workers() -> int:
    """Have half as many workers again as processors: a third of the time is spent waiting for ports and processes."""
    return round(1.5 * (os.cpu_count() or 1))


@pytest.fixture
def terminal_signals() -> Iterator[None]:
    """Give the test the signals of a terminal, also where the tests run under ``nohup``."""
    with default_signals():
        yield


@pytest.fixture
def wide_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give the test lines of 200 columns: words are looked for as they stand, not as a narrow terminal breaks them."""
    monkeypatch.setenv("COLUMNS", "200")


@pytest.fixture
def no_report() -> Iterator[None]:
    """Leave page, figures and paper out of every delivery: most of a small job's time, where nobody looks at them."""
    with reports_left_out():
        yield


@pytest.fixture(scope="session")
def finished_job(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> FinishedJob:
    """Return the one finished job of the session, made by the first worker that asks; tests that change it copy it."""
    return FinishedJob(made_once("finished-job", finish_job, tmp_path_factory, request.config))
