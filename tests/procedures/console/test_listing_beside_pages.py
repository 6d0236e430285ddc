"""A list of runs that takes its time, since it verifies long journals, keeps no page of a run from what happens."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Event

from visited_console import Visited

from procedures.journal.status.run_list import ListedRun, RunList

AT_MOST_S = 30.0
"""Far longer than a page takes: a page that waits for the list would wait until this is over."""


class _SlowList(RunList):
    """Verifies until it is told that it is done."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self.began, self.may_end = Event(), Event()

    def read(self) -> tuple[ListedRun, ...]:
        self.began.set()
        assert self.may_end.wait(2.0 * AT_MOST_S)
        return super().read()


def test_a_page_is_shown_while_the_list_is_being_read(tmp_path: Path) -> None:
    visited = Visited(tmp_path)
    slow = _SlowList(tmp_path / "runs")
    visited.console.runs = slow
    with ThreadPoolExecutor(2) as threads:
        listing = threads.submit(visited.console.listed)
        try:
            assert slow.began.wait(AT_MOST_S)
            page = threads.submit(visited.console.page, "night-1").result(AT_MOST_S)
            assert not listing.done()
        finally:
            slow.may_end.set()
        assert page is not None
        assert [run.path.name for run in listing.result(AT_MOST_S)] == ["night-1"]
    visited.console.close()
