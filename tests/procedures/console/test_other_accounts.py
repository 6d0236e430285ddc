"""A console that looks at runs of another account: it says so, crashes nothing, and moves nothing."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from open_folder import open_folder
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect
from visited_console import BASE, HOST, Visited

from procedures.journal.sidecar.owner import owning
from procedures.records.states import State

NOBODY = 65534
OWN = {"origin": BASE}
RUN = "/api/v1/runs/night-1"
WHOSE = "belongs to another account of this machine"
PAGES = ("/", "/run/night-1", "/night", "/archive", "/queue", "/metrics", RUN, f"{RUN}/map", "/api/v1/runs")
pytestmark = pytest.mark.skipif(os.name == "nt" or os.getuid() != 0, reason="needs two accounts")


@pytest.fixture
def visited() -> Iterator[Visited]:
    """A paused run that a process of this account has, in a folder that every account can look into."""
    with open_folder() as folder:
        (folder / "files").mkdir()
        found = Visited(folder, State.PAUSED)
        browser, away = found.enter(), folder / "away"
        # What the console's own files hold is read now: they may be this account's alone.
        for page in (*PAGES, "/run/none"):
            browser.get(page)
        found.run.rename(away)
        browser.get("/")
        away.rename(found.run)
        with owning(found.run):
            yield found
        found.console.close()


@contextmanager
def _as_nobody() -> Iterator[None]:
    os.setegid(NOBODY)
    os.seteuid(NOBODY)
    try:
        yield
    finally:
        os.seteuid(0)
        os.setegid(0)


def _content(run: Path) -> dict[str, tuple[int, bytes]]:
    return {
        path.name: (path.stat().st_mtime_ns, path.read_bytes()) for path in sorted(run.rglob("*")) if path.is_file()
    }


def _withhold(visited: Visited, how: str) -> None:
    """Leave of the run what another account may not read: all of it, its journal, or who has it."""
    match how:
        case "folder":
            visited.run.chmod(0o700)
        case "journal":
            (visited.run / "journal.sqlite").chmod(0o600)
        case "owner":
            (visited.run / "owner.lock").chmod(0o600)


def _anew(visited: Visited) -> TestClient:
    """A browser of a console that has not read anything of the run."""
    watched = visited.console.__dict__["_watched"]
    while watched:
        watched.popitem()[1].close()
    return visited.browser


@pytest.mark.parametrize("how", ["folder", "journal", "owner"])
def test_what_may_not_be_read_is_said_to_be_anothers(visited: Visited, how: str) -> None:
    _withhold(visited, how)
    before, browser = _content(visited.run), _anew(visited)
    with _as_nobody():
        answers = {page: browser.get(page) for page in PAGES}
        shown = {page: answer.text for page, answer in answers.items()}
    assert {page: answer.status_code for page, answer in answers.items() if answer.status_code not in (200, 404)} in (
        {},
        dict.fromkeys(("/run/night-1", RUN, f"{RUN}/map"), 500),
    )
    assert "night-1" in shown["/"]
    assert "ermission denied" in shown["/"], "the first page says which folder it may not read"
    assert not [page for page, text in shown.items() if "Traceback" in text or text == "Internal Server Error"]
    if how != "journal":  # that is the journal's own sentence
        assert WHOSE in shown["/"]
        assert WHOSE in shown["/run/night-1"]
    assert _content(visited.run) == before


@pytest.mark.parametrize("how", ["readable", "folder", "journal", "owner"])
@pytest.mark.parametrize("act", ["pause", "continue", "stop", "abort", "note", "ack", "void", "redo"])
def test_what_may_not_be_written_is_refused_in_words_and_nothing_is_written(
    visited: Visited, how: str, act: str
) -> None:
    fields = visited.fields(visited.browser, text="x", number="1")
    _withhold(visited, how)
    before, browser = _content(visited.run), _anew(visited)
    with _as_nobody():
        answer = browser.post(f"{RUN}/{act}", data=fields, headers=OWN)
    told = answer.json()["told"]
    assert answer.status_code in (404, 409, 500), told
    assert told
    assert "night-1" in told or answer.status_code == 404
    assert _content(visited.run) == before


def test_a_socket_of_such_a_run_ends_and_no_other_with_it(visited: Visited) -> None:
    _withhold(visited, "owner")
    browser = _anew(visited)
    with _as_nobody(), browser.websocket_connect(f"ws://{HOST}/live/night-1", headers=OWN) as socket:
        with pytest.raises(WebSocketDisconnect) as ended:
            socket.receive_json()
        assert ended.value.code == 1011
        assert browser.get("/healthz").text == "ok\n"
