"""No secret of the console stands anywhere but with who has it: no log, journal, page, file or list of processes."""

import json
import urllib.request
from collections.abc import Iterator
from http.cookies import SimpleCookie
from pathlib import Path
from urllib.error import HTTPError
from urllib.parse import urlencode

import psutil
import pytest
from consoles import ServedConsole, served_console
from run_folders import make_run

from procedures.accounts.people import People
from procedures.journal.sidecar.owner import owning
from procedures.records.states import State
from rig.clock import SystemClock

CLOCK = SystemClock()
MISTYPED = "wrong-horse-battery"
GUESS = "a-link-that-is-none"


class _Staying(urllib.request.HTTPRedirectHandler):
    def redirect_request(self, *_: object) -> None:  # type: ignore[override]
        return None


class _Browser:
    """One session; keeps every answer, its headers and what was in it."""

    def __init__(self, base: str) -> None:
        self.base, self.cookie, self.csrf = base, "", ""
        self.answers: dict[str, str] = {}
        self._open = urllib.request.build_opener(_Staying).open

    def ask(self, path: str, fields: dict[str, str] | None = None, **headers: str) -> int:
        body = None if fields is None else urlencode(fields).encode()
        given = {"cookie": self.cookie, "origin": self.base, **headers}
        try:
            answer = self._open(urllib.request.Request(f"{self.base}{path}", body, given))
        except HTTPError as refused:
            answer = refused
        with answer:
            text = answer.read().decode(errors="replace")
            if found := answer.headers.get("set-cookie"):
                self.cookie = f"calrig={SimpleCookie(found)['calrig'].value}"
            del answer.headers["set-cookie"]
            self.answers[f"{path} {answer.status}"] = f"{answer.headers}{text}"
        if 'name="csrf" value="' in text:
            self.csrf = text.partition('name="csrf" value="')[2].partition('"')[0]
        return int(answer.status)


@pytest.fixture
def runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv("CALRIG_PEOPLE", str(tmp_path / "people.json"))
    monkeypatch.setenv("CALRIG_LOG", str(tmp_path / "calrig.log"))
    monkeypatch.setenv("CALRIG_LOG_LEVEL", "debug")
    monkeypatch.setenv("CALRIG_QUEUES", str(tmp_path / "queues"))
    folder = tmp_path / "runs"
    with owning(make_run(folder / "alive", State.PAUSED)):
        make_run(folder / "ended", State.STOPPED)
        yield folder


def _processes(console: ServedConsole) -> str:
    process = psutil.Process(console.process.pid)
    return json.dumps([one.cmdline() for one in (process, *process.children(recursive=True))])


def test_no_secret_is_found_where_others_read(runs: Path, tmp_path: Path) -> None:
    secret = People(tmp_path / "people.json").add("Anna Ray", "move", CLOCK.now_utc())
    with served_console(runs, tmp_path / "archive.sqlite") as console:
        link = console.link()
        base, key = link.partition("/enter?key=")[::2]
        by_link, by_name = _Browser(base), _Browser(base)
        assert by_link.ask(f"/enter?key={key}") == 200
        assert by_name.ask("/login", {"name": "Anna Ray", "secret": secret}) == 303
        stranger = _Browser(base)
        assert stranger.ask("/login", {"name": "Anna Ray", "secret": MISTYPED}) == 403
        assert stranger.ask(f"/enter?key={GUESS}") == 403
        assert stranger.ask(f"/enter?key={key}") == 403, "a link that was used"
        assert stranger.ask("/code", {"csrf": by_name.csrf, "code": MISTYPED}) == 401
        for browser in (by_link, by_name):
            for path in ("/run/alive", "/run/none", "/archive/none", "/jog/none.toml", "/night", "/api/v1/runs/ended"):
                browser.ask(path)
            fields = {"csrf": browser.csrf, "text": "a note", "key": "k1"}
            assert browser.csrf
            assert browser.ask("/api/v1/runs/alive/note", fields, accept="application/json") == 202
            assert browser.ask("/api/v1/runs/ended/note", fields | {"key": "k2"}) == 202
            assert browser.ask("/api/v1/runs/alive/pause", fields | {"csrf": "x", "key": "k3"}) == 403
            assert browser.ask("/api/v1/runs/alive/none", fields) == 404
        processes = _processes(console)
        next_key = console.link().partition("/enter?key=")[2]
        tokens = [browser.cookie.partition("=")[2] for browser in (by_link, by_name)]
    never = {"secret": secret, "key": key, "next key": next_key, "a mistyped secret": MISTYPED, "a guess": GUESS}
    never |= {f"token {number}": token for number, token in enumerate(tokens)}
    tokens_of_pages = {f"token of the page {n}": browser.csrf for n, browser in enumerate((by_link, by_name))}
    assert all(len(value) > 8 for value in (never | tokens_of_pages).values())
    files = {path.relative_to(tmp_path).as_posix(): path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert {"calrig.log", "people.json", "runs/ended/journal.sqlite"} <= files.keys()
    assert any(name.startswith("runs/alive/requests/") for name in files), "a request lies there"
    for what, value in (never | tokens_of_pages).items():
        assert [name for name, content in files.items() if value.encode() in content] == [], what
        assert value not in processes, what
    for what, value in never.items():  # the token of a page stands in its own forms, and nowhere else
        for browser in (by_link, by_name, stranger):
            assert [path for path, text in browser.answers.items() if value in text.replace(path, "")] == [], what
    for one, other in ((by_link, by_name), (by_name, by_link), (by_link, stranger)):
        assert not [path for path, text in other.answers.items() if one.csrf in text]
