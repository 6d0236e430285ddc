"""What the pages say: where a run stands, what the night was, and names of any script as text."""

import json
import sqlite3
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path
from typing import Any
from zoneinfo import ZoneInfo

import numpy as np
import pytest
from journals import a_clock
from run_folders import STARTED_UTC, make_run, stored_run
from starlette.testclient import TestClient

from ams.frames import from_level_axes
from ams.units import ARCSEC_PER_RAD
from procedures.accounts.people import People
from procedures.console import watched_run
from procedures.console.app import make_app
from procedures.console.gate import Site
from procedures.console.heat_map import heat_map
from procedures.console.night import evening_before
from procedures.console.sessions import Sessions
from procedures.console.shared import Console
from procedures.journal.journal import Journal
from procedures.journal.sidecar.owner import owning
from procedures.journal.status.follower import FollowedDwell
from procedures.journal.status.run_list import RunList
from procedures.journal.status.stop_advice import StopNumbers, numbers_of
from procedures.journal.storage import JOURNAL_FILE
from procedures.records.states import State

HOST = "127.0.0.1:8600"
NASTY = "<script>alert(1)</script>\"'&\u202e"


@pytest.fixture
def runs(tmp_path: Path) -> Path:
    folder = tmp_path / "runs"
    make_run(folder / "finished", State.FINISHED)
    tripped = make_run(folder / "tripped", State.STOPPED, started_utc=STARTED_UTC + timedelta(hours=1))
    with_note = Journal.open_for_append(tripped / JOURNAL_FILE)
    clock = a_clock()
    with_note.append_event("note", {"by": NASTY, "text": NASTY, "at_utc": "x"}, clock)
    with_note.append_event("state", {"to": "tripped", "by": "", "reason": f"pitch: {NASTY}", "cause": "device"}, clock)
    with_note.close()
    verdict = {"trust": "reserved", "sentence": f"Usable, {NASTY}", "grounds": [], "sensors": []}
    (folder / "finished" / "verdict.json").write_text(json.dumps(verdict))
    for name in ("broken", NASTY.replace("/", "")):
        (folder / name).mkdir()
        (folder / name / JOURNAL_FILE).write_bytes(b"no journal")
    return folder


@pytest.fixture
def browser(runs: Path) -> Iterator[TestClient]:
    clock = a_clock()
    sessions = Sessions(clock, People(runs.parent / "people.json"))
    archive = f"sqlite:///{runs.parent / 'none.sqlite'}"
    console = Console(
        RunList(runs, verifies=True),
        lambda: archive,
        clock,
        sessions,
        Site(frozenset([HOST])),
        runs.parent / "queues",
        runs.parent,
    )
    client = TestClient(make_app(console), base_url=f"http://{HOST}")
    client.get("/enter", params={"key": sessions.new_key()})
    yield client
    console.close()


def test_the_first_page_is_the_latest_run_and_says_why_it_stands_still(browser: TestClient, runs: Path) -> None:
    page = browser.get("/").text
    assert "TRIPPED" in page
    assert "What to do" in page
    assert "A device reports a fault" in page
    assert f"calrig resume {runs / 'tripped'}" in page
    assert "dwells (" in page


def test_a_run_that_goes_on_shows_no_verdict_of_the_stop_before(browser: TestClient, runs: Path) -> None:
    """A trip is delivered and reported; the resume leaves that report beside the journal."""
    folder = runs / "finished"
    assert "Usable, " in browser.get("/run/finished").text
    journal = Journal.open_for_append(folder / JOURNAL_FILE)
    journal.append_event("state", {"to": "running", "by": "ann", "reason": "looked at"}, a_clock())
    journal.close()
    with owning(folder):
        for path in ("/run/finished", "/night"):
            assert "Usable, " not in browser.get(path).text, path


def test_names_of_any_script_are_text_on_every_page(browser: TestClient) -> None:
    for path in ("/", "/night", "/run/finished", "/run/tripped"):
        page = browser.get(path).text
        assert "<script>alert" not in page
        assert "\u202e" not in page
    assert "&lt;script&gt;alert(1)" in browser.get("/").text
    assert browser.get("/").text.count("is not a journal") == 2, "folders that cannot be read are named, whatever it is"


def test_the_night_begins_with_what_waits_for_a_person(browser: TestClient) -> None:
    page = browser.get("/night").text
    order = [page.index(words) for words in ("title of tripped", "title of finished")]
    assert order == sorted(order)
    assert page.count("To do:") == 3, "the tripped one and the two that cannot be read"
    assert "Usable, &lt;script&gt;" in page
    assert "Nothing is archived yet" in page


def test_every_page_that_counts_dwells_says_that_the_journal_is_damaged(browser: TestClient, runs: Path) -> None:
    connection = sqlite3.connect(runs / "finished" / JOURNAL_FILE)
    assert connection.execute("UPDATE events SET detail = detail || ' ' WHERE sequence = 4").rowcount == 1
    connection.commit()
    connection.close()
    for path in ("/night", "/run/finished"):
        page = browser.get(path).text
        assert "counted by a journal that is damaged: event 4 (" in page, path
        assert f"calrig salvage {runs / 'finished'} takes the rest into a new folder" in page, path
    assert "by a damaged journal" in browser.get("/run/tripped").text
    listed = {Path(run["run"]).name: run for run in browser.get("/api/v1/runs").json()["runs"]}
    assert listed["finished"]["damaged"][0].startswith("event 4 (")
    figures = browser.get("/metrics").text.splitlines()
    assert 'calrig_run_damaged{run="tripped"} 0' in figures
    assert f'calrig_run_damaged{{run="finished"}} {len(listed["finished"]["damaged"])}' in figures


def test_before_the_first_archived_run_the_archive_says_that_it_is_empty(browser: TestClient) -> None:
    answer = browser.get("/archive")
    assert (answer.status_code, "Nothing is archived yet" in answer.text) == (200, True)
    assert "none.sqlite" in answer.text
    assert browser.get("/archive/P-1").status_code == 404


def test_the_night_begins_yesterday_in_the_evening_of_the_reader() -> None:
    morning = datetime(2026, 3, 2, 6, 0, tzinfo=UTC)
    east = timezone(timedelta(hours=9))
    assert evening_before(morning, east) == datetime(2026, 3, 1, 16, tzinfo=east)
    summer_began = datetime(2026, 3, 29, 4, 0, tzinfo=UTC)
    assert evening_before(summer_began, ZoneInfo("Europe/Berlin")) == datetime(2026, 3, 28, 15, tzinfo=UTC)


def test_programs_are_told_the_same(browser: TestClient) -> None:
    listed = browser.get("/api/v1/runs").json()["runs"]
    assert {entry["state"] for entry in listed} == {"finished", "tripped", None}
    entry = browser.get("/api/v1/runs/tripped").json()
    assert (entry["state"], entry["alive"]) == ("tripped", False)
    assert 'calrig_run_state{run="tripped",state="tripped"} 1' in browser.get("/metrics").text


def test_a_page_is_small(browser: TestClient) -> None:
    sizes = [len(browser.get(path).content) for path in ("/", "/static/console.css", "/static/console.js")]
    assert sum(sizes) < 60_000


@pytest.mark.parametrize("is_gimbal", [False, True])
def test_residuals_are_those_of_a_line_through_the_dwells_that_count(is_gimbal: bool) -> None:
    """Against the same line by the normal equations; a dwell that is off stands out in its own column alone."""
    chance, attitudes = np.random.default_rng(3), [(p, r) for p in range(-60, 61, 30) for r in range(-180, 180, 60)]
    pitch, roll = np.deg2rad(np.array(attitudes, dtype=float)).T
    yaws_deg = chance.uniform(-60.0, 60.0, len(attitudes)) * is_gimbal
    force = from_level_axes(pitch, np.deg2rad(yaws_deg), roll) @ np.array([0.0, 0.0, -1.0])
    sensitivity = np.array([2.5, 0.02, -0.01])
    means = 0.003 + force @ sensitivity + 1e-5 * chance.normal(size=len(attitudes))
    means[7] += 1e-3
    dwells = [
        _dwell(index, (*attitude, float(yaw_deg)) if is_gimbal else attitude, float(mean))
        for index, (attitude, yaw_deg, mean) in enumerate(zip(attitudes, yaws_deg, means, strict=True))
    ]
    found = heat_map(dwells, frozenset([(7, 1, 1)]), {"dmm.x"})
    assert found is not None
    kept = np.arange(len(attitudes)) != 7
    design = np.column_stack([np.ones(kept.sum()), force[kept]])
    solved = np.linalg.solve(design.T @ design, design.T @ means[kept])
    residual_v = means - np.column_stack([np.ones(len(means)), force]) @ solved
    expected = residual_v * ARCSEC_PER_RAD / np.linalg.norm(solved[1:])
    assert found.channels == ("dmm.x",), "a supply of 15 V has no arc seconds: it would set the colours of all others"
    assert np.array(found.arcsec[0], dtype=float) == pytest.approx(expected, abs=0.006)
    assert (found.marks[7], set(found.marks) - {"x"}) == ("x", {"d"})


def _dwell(step: int, attitude: tuple[float, ...], mean: float) -> FollowedDwell:
    _, dwells = stored_run()
    record = replace(
        dwells[0], step=step, attempt=1, epoch=1, accepted=True, purpose="design",
        measured_deg=dict(zip(("pitch", "roll", "yaw"), attitude, strict=False)),
    )  # fmt: skip
    return FollowedDwell(record, {"dmm.x": mean, "dmm.supply": 15.0}, {"dmm.x": 1e-5, "dmm.supply": 1e-4})


def test_a_run_that_stands_still_is_read_once_for_its_advice(runs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []

    def read(run: str, *journal: Any) -> StopNumbers:
        asked.append(run)
        return numbers_of(run, *journal)

    monkeypatch.setattr(watched_run, "numbers_of", read)
    watched = watched_run.WatchedRun(runs / "tripped", a_clock())
    pages = [watched.page().advice for _ in range(3)]
    assert asked == [str(runs / "tripped")]
    assert len(set(pages)) == 1
    assert f"calrig resume {runs / 'tripped'} --operator NAME --reason TEXT" in pages[0]
    noted = Journal.open_for_append(runs / "tripped" / JOURNAL_FILE)
    noted.append_event("note", {"by": "anna", "text": "looked", "at_utc": "x"}, a_clock())
    noted.close()
    watched.page()
    assert asked == [str(runs / "tripped")] * 2
    watched.close()


def test_the_night_says_what_a_defect_kept_from_being_solved(runs: Path, browser: TestClient) -> None:
    row = {"sensor": "SN1", "verdict": "not usable", "failure": "a defect of calrig: send the folder"}
    document = {"trust": "unusable", "sentence": "There is no result to use of SN1.", "grounds": [], "sensors": [row]}
    (runs / "finished" / "verdict.json").write_text(json.dumps(document))
    assert "no result to use of SN1: a defect of calrig: send the folder" in browser.get("/night").text
