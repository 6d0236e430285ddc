"""An archive whose server takes a connection and never answers: its pages say so in time, no stop waits for them."""

import asyncio
import socket
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event

import httpx2
import pytest
from starlette.testclient import TestClient
from table_bench import rig_file
from visited_console import BASE, Visited

from procedures.console import acting, app, jogging, shared
from procedures.console.acts import ACCEPTED, Answer
from procedures.console.app import make_app

OWN = {"origin": BASE}
READERS = 80
WITHIN_S = 5.0
"""A stop is answered in hundredths of a second; what waits for a page waits until the test has ended."""


@pytest.fixture
def visited(tmp_path: Path) -> Iterator[Visited]:
    (tmp_path / "files").mkdir()
    (tmp_path / "files" / "rig.toml").write_text(rig_file(tmp_path).read_text(encoding="utf-8"), encoding="utf-8")
    found = Visited(tmp_path)
    yield found
    found.console.close()


@contextmanager
def _hanging(monkeypatch: pytest.MonkeyPatch, owner: object, name: str) -> Iterator[None]:
    """Have a function return only after the block."""
    answers = Event()

    def hang(*_: object, **__: object) -> Answer:
        answers.wait(60.0)
        return Answer(ACCEPTED, "done")

    monkeypatch.setattr(owner, name, hang)
    try:
        yield
    finally:
        answers.set()


def _talk(visited: Visited, browser: TestClient, talk: Callable[[httpx2.AsyncClient], Awaitable[None]]) -> None:
    """Ask many things of one console at once, as one server does."""
    transport = httpx2.ASGITransport(make_app(visited.console), client=("127.0.0.1", 50000))

    async def all_of_it() -> None:
        async with httpx2.AsyncClient(transport=transport, base_url=BASE, cookies=dict(browser.cookies)) as client:
            await talk(client)

    asyncio.run(all_of_it())


async def _while_others_wait(asking: list[asyncio.Task[httpx2.Response]], answer: Awaitable[httpx2.Response]) -> int:
    """Return the status of an answer that came while every one of the others was waited for."""
    await asyncio.wait(asking, timeout=0.5)
    assert [task for task in asking if task.done()] == [], "they must hang"
    async with asyncio.timeout(WITHIN_S):
        status = (await answer).status_code
    assert [task for task in asking if task.done()] == []
    return status


@pytest.mark.parametrize("path", ["/archive", "/archive/SN1", "/night", "/"])
def test_a_stop_waits_for_no_page_that_waits_for_the_archive(
    visited: Visited, monkeypatch: pytest.MonkeyPatch, path: str
) -> None:
    browser = visited.enter()
    (visited.run / "verdict.json").write_text(
        '{"trust": "sound", "sentence": "Sound.", "grounds": [], "sensors": []}', encoding="utf-8"
    )
    fields, part = visited.fields(browser), _archive_of(path)

    async def talk(client: httpx2.AsyncClient) -> None:
        asking = [asyncio.ensure_future(client.get(path)) for _ in range(READERS)]
        with _hanging(monkeypatch, *part):
            stop = client.post("/api/v1/jog/rig.toml/stop", data=fields, headers=OWN)
            assert await _while_others_wait(asking, stop) == 409, "nothing moves that rig"
            assert await _while_others_wait(asking, client.get("/jog")) == 200, "pages without the archive go on, too"
        await asyncio.gather(*asking, return_exceptions=True)

    _talk(visited, browser, talk)


def _archive_of(path: str) -> tuple[object, str]:
    return app, {"/archive": "search_runs", "/archive/SN1": "list_sets", "/night": "archived"}.get(
        path, "withdrawn_sentence"
    )


def test_a_stop_waits_for_no_page_at_all(visited: Visited, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every thread of the pages waits for a disk that hangs."""
    browser = visited.enter()

    async def talk(client: httpx2.AsyncClient) -> None:
        asking = [asyncio.ensure_future(client.get("/jog")) for _ in range(READERS)]
        with _hanging(monkeypatch, jogging, "offered"):
            stop = client.post("/api/v1/jog/rig.toml/stop", data=visited.fields(browser), headers=OWN)
            assert await _while_others_wait(asking, stop) == 409
        await asyncio.gather(*asking, return_exceptions=True)

    _talk(visited, browser, talk)


def test_a_stop_waits_for_no_other_act(visited: Visited, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is taken back is withdrawn in the archive before it is answered."""
    browser = visited.enter()
    fields = visited.fields(browser)

    async def talk(client: httpx2.AsyncClient) -> None:
        asking = [
            asyncio.ensure_future(client.post("/api/v1/runs/night-1/ack", data=fields | {"key": f"k{n}"}, headers=OWN))
            for n in range(20)
        ]
        with _hanging(monkeypatch, acting, "perform"):
            stop = client.post("/api/v1/jog/rig.toml/stop", data=fields, headers=OWN)
            assert await _while_others_wait(asking, stop) == 409
        await asyncio.gather(*asking, return_exceptions=True)

    _talk(visited, browser, talk)


def test_a_page_says_in_time_that_the_archive_gives_no_answer(
    visited: Visited, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A real server that never answers; what stands beside the archive is shown all the same."""
    for module in (app, shared):
        for name in ("ARCHIVE_S", "BESIDE_S"):
            monkeypatch.setattr(module, name, 0.2)
    (visited.run / "verdict.json").write_text(
        '{"trust": "sound", "sentence": "Sound.", "grounds": [], "sensors": []}', encoding="utf-8"
    )
    with socket.create_server(("127.0.0.1", 0)) as silent:
        port = silent.getsockname()[1]
        visited.console.archive_of_now = lambda: f"postgresql+psycopg://lab:word@127.0.0.1:{port}/a"
        browser = visited.enter()
        for path in ("/archive", "/archive/SN1"):
            page = browser.get(path)
            assert (page.status_code, "the archive gave no answer within 0.2 s" in page.text) == (500, True)
            assert "word@" not in page.text
        night, run = browser.get("/night"), browser.get("/run/night-1")
        assert (night.status_code, run.status_code) == (200, 200)
        assert "the archive gave no answer within 0.2 s" in night.text
        assert "title of night-1" in night.text
        assert "Whether its set was withdrawn since is not known" in run.text
