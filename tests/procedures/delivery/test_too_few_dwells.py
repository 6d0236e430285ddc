"""A run that ended before its design can be solved: the page says how many dwells it has and what measures the rest."""

import json
from datetime import UTC, datetime
from pathlib import Path

import pytest
from command import call
from small_run import Bench, bench

from ams.errors import WriteFailed
from procedures.journal.requests.spool import Request, Spool
from procedures.records.progress import Progress, SilentObserver
from procedures.records.states import State


class StopsEarly(SilentObserver):
    """Somebody who stops a run after two dwells of its design."""

    def __init__(self, run: Path) -> None:
        self._spool, self._is_asked = Spool(run), False

    def on_event(self, progress: Progress) -> None:
        if progress.dwells_done == 2 and not self._is_asked:
            self._is_asked = True
            self._spool.submit(Request("stop", "anna", datetime.now(UTC).isoformat()))


@pytest.fixture(scope="module")
def early(tmp_path_factory: pytest.TempPathFactory) -> Path:
    small: Bench = bench(tmp_path_factory.mktemp("bench"))
    run = small.folder / "early"
    assert small.run(run, observer=StopsEarly(run)).state is State.STOPPED
    return run


def test_the_page_says_how_many_dwells_are_needed_and_what_measures_them(
    early: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    solved = call(capsys, "solve", early)
    verdict = json.loads((early / "verdict.json").read_text(encoding="utf-8"))
    done = int(call(capsys, "status", early, "--json").document["dwells_done"])
    why, *_ = verdict["grounds"]
    assert solved.status == 1
    assert f"{done} observations cannot determine 4 parameters" in why
    assert why.endswith(
        f"allowed 4 distinct points or more; nothing was solved; {done} of 24 dwells of the design are there"
    )
    (missing,) = [ground for ground in verdict["grounds"] if "planned design dwells are missing" in ground]
    assert missing.startswith(f"{24 - done} of 24 planned design dwells are missing: calrig resume ")
    page = (early / "report.html").read_text(encoding="utf-8")
    assert "calrig resume" in page
    assert "add points" not in page + solved.out + solved.err


def test_solve_promises_page_and_paper_alone_where_the_disk_took_neither(
    early: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object) -> None:
        raise WriteFailed("report.pdf: cannot be written: No space left on device")

    monkeypatch.setattr("procedures.delivery.deliver.write_paper", full)
    told = call(capsys, "solve", early).err
    assert f"calrig solve {early} makes what is missing of page and paper; " in told
    assert f"dwells that are missing are measured by calrig resume {early}" in told
