"""Who may jog from a browser: every other way to a motion is refused, and no bench is even opened."""

import json
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from starlette.testclient import TestClient, WebSocketTestSession
from starlette.websockets import WebSocketDisconnect
from table_bench import rig_file
from visited_console import BASE, HOST, Visited

from procedures.console import jogging
from procedures.console.benches import Benches

SOCKET = f"ws://{HOST}/jog/rig.toml"
OWN = {"origin": BASE}


@pytest.fixture
def visited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Visited]:
    (tmp_path / "files").mkdir()
    (tmp_path / "files" / "rig.toml").write_text(rig_file(tmp_path).read_text(encoding="utf-8"), encoding="utf-8")
    opened: list[Path] = []

    async def open_none(_benches: Benches, rig: Path) -> None:
        opened.append(rig)
        raise OSError("a bench was opened")

    monkeypatch.setattr(Benches, "open", open_none)
    found = Visited(tmp_path)
    found.opened = opened  # type: ignore[attr-defined]
    yield found
    found.console.close()


def _opened(visited: Visited) -> list[Path]:
    return visited.opened  # type: ignore[attr-defined,no-any-return]


def _hello(visited: Visited, browser: TestClient, socket: WebSocketTestSession) -> None:
    socket.send_text(json.dumps({"csrf": visited.csrf(browser)}))
    assert "you" in socket.receive_json()


def _require_ended(socket: WebSocketTestSession) -> None:
    for _ in range(100):
        try:
            socket.receive_text()
        except WebSocketDisconnect:
            return
    pytest.fail("it goes on")


@pytest.mark.parametrize("path", ["none.toml", "..%2Frig.toml", "%2Fetc%2Fpasswd", "procedure.toml", "rig.toml%00"])
def test_a_page_names_no_file_but_a_rig_of_the_folder(visited: Visited, path: str) -> None:
    browser = visited.enter()
    assert browser.get(f"/jog/{path}").status_code == 404
    headers = {**OWN, "content-type": "application/json"}
    fields = json.dumps(visited.fields(browser))
    assert browser.post(f"/api/v1/jog/{path}/stop", content=fields, headers=headers).status_code == 404


@pytest.mark.parametrize("origin", [None, "https://evil.example", "null"])
def test_a_socket_of_another_site_is_not_accepted(visited: Visited, origin: str | None) -> None:
    browser = visited.enter()
    with (
        pytest.raises(WebSocketDisconnect),
        browser.websocket_connect(SOCKET, headers={} if origin is None else {"origin": origin}),
    ):
        pytest.fail("it was accepted")


def test_without_a_session_there_is_neither_page_nor_socket(visited: Visited) -> None:
    assert visited.browser.get("/jog/rig.toml").status_code == 401
    with pytest.raises(WebSocketDisconnect), visited.browser.websocket_connect(SOCKET, headers=OWN):
        pytest.fail("it was accepted")


@pytest.mark.parametrize("first", ["{}", '{"csrf": "x"}', '{"csrf": 1}', "take", "[]", '{"say": "take"}', "[" * 900])
def test_first_words_without_the_token_end_the_socket(visited: Visited, first: str) -> None:
    browser = visited.enter()
    with browser.websocket_connect(SOCKET, headers=OWN) as socket:
        socket.send_text(first)
        _require_ended(socket)
    assert _opened(visited) == []


def test_who_says_nothing_is_sent_away(visited: Visited, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jogging, "FIRST_WORDS_S", 0.02)
    with visited.enter().websocket_connect(SOCKET, headers=OWN) as socket:
        _require_ended(socket)


@pytest.mark.parametrize("role", ["watch", "operate"])
def test_only_who_may_move_takes_a_bench(visited: Visited, role: str) -> None:
    browser = visited.person("Anna", role)
    with browser.websocket_connect(SOCKET, headers=OWN) as socket:
        _hello(visited, browser, socket)
        socket.send_json({"say": "take"})
        assert f"jog needs the role move, and Anna has the role {role}" in socket.receive_json()["told"]
    assert _opened(visited) == []


def test_motion_from_elsewhere_needs_the_rig_file_and_the_code(visited: Visited) -> None:
    browser = visited.person("Anna", "move", "192.0.2.7")
    rig = visited.console.files / "rig.toml"
    with browser.websocket_connect(SOCKET, headers=OWN) as socket:
        _hello(visited, browser, socket)
        socket.send_json({"say": "take"})
        assert "motion_from_elsewhere = true" in socket.receive_json()["told"]
        rig.write_text(
            rig.read_text(encoding="utf-8") + "\n[console]\nmotion_from_elsewhere = true\n", encoding="utf-8"
        )
        socket.send_json({"say": "take"})
        assert "tell first the code" in socket.receive_json()["told"]
        assert _opened(visited) == []
        code = visited.sessions.new_code()
        page = browser.get("/jog/rig.toml")
        assert "Code on the terminal" in page.text
        text = browser.post("/code", data={"csrf": visited.csrf(browser), "code": code}, headers=OWN)
        assert text.status_code == 200
        socket.send_json({"say": "take"})
        assert "a bench was opened" in socket.receive_json()["told"]
    assert _opened(visited) == [rig]


@pytest.mark.parametrize("how", ["removed", "role", "left", "old"])
def test_a_session_that_ends_ends_the_socket_at_its_next_word(visited: Visited, how: str) -> None:
    browser = visited.person("Anna", "move")
    with browser.websocket_connect(SOCKET, headers=OWN) as socket:
        _hello(visited, browser, socket)
        match how:
            case "removed":
                visited.people.remove("Anna")
            case "role":
                visited.people.add("Anna", "watch", visited.clock.now_utc(), renews=True)
            case "left":
                browser.post("/leave", data={"csrf": visited.csrf(browser)}, headers=OWN)
            case "old":
                visited.clock.sleep(13 * 3600.0)
        socket.send_json({"say": "take"})
        _require_ended(socket)
    assert _opened(visited) == []


def test_a_page_that_floods_is_sent_away(visited: Visited) -> None:
    browser = visited.enter()
    with browser.websocket_connect(SOCKET, headers=OWN) as socket:
        _hello(visited, browser, socket)
        for _ in range(jogging.MOST_WORDS_A_SECOND + 1):
            socket.send_json({"say": "beat"})
        _require_ended(socket)


def test_orders_of_a_page_without_the_bench_reach_none(visited: Visited) -> None:
    browser = visited.enter()
    with browser.websocket_connect(SOCKET, headers=OWN) as socket:
        _hello(visited, browser, socket)
        socket.send_json({"say": "do", "act": "home", "axis": "pitch", "tick": 1})
        assert "does not have the bench; nothing moved" in socket.receive_json()["told"]
    assert _opened(visited) == []


def test_a_stop_is_a_form_that_needs_its_token_and_the_role(visited: Visited) -> None:
    browser = visited.enter()
    path = "/api/v1/jog/rig.toml/stop"
    assert browser.get(path).status_code == 405
    assert browser.post(path, data={"key": "k"}, headers=OWN).status_code == 403
    assert browser.post(path, data=visited.fields(browser)).status_code == 403
    found = browser.post(path, data=visited.fields(browser), headers=OWN)
    assert (found.status_code, "no calrig of this machine moves that rig" in found.json()["told"]) == (409, True)
    watcher = visited.person("Bob", "watch")
    refused = watcher.post(path, data=visited.fields(watcher), headers=OWN)
    assert (refused.status_code, "halt needs the role operate" in refused.json()["told"]) == (403, True)


def test_silent_pages_make_room_the_longest_silent_first(visited: Visited, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jogging, "MOST_PAGES", 3)
    browser = visited.enter()
    with ExitStack() as stack:
        sockets = [stack.enter_context(browser.websocket_connect(SOCKET, headers=OWN)) for _ in range(3)]
        for socket in (sockets[1], sockets[2], sockets[0]):  # the first is the latest that was heard
            visited.clock.sleep(1.0)
            _hello(visited, browser, socket)
            socket.send_json({"say": "beat"})
            socket.send_json({"say": "do"})
            socket.receive_json()
        for put_aside in (sockets[1], sockets[2]):
            visited.clock.sleep(1.0)
            _hello(visited, browser, stack.enter_context(browser.websocket_connect(SOCKET, headers=OWN)))
            with pytest.raises(WebSocketDisconnect) as ended:
                put_aside.receive_json()
            assert ended.value.code == jogging.TOO_MANY
        sockets[0].send_json({"say": "do"})
        assert "does not have the bench" in sockets[0].receive_json()["told"]


def test_pages_that_have_a_bench_make_no_room(visited: Visited, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jogging, "MOST_PAGES", 1)
    monkeypatch.setattr(Benches, "has", lambda self, client: True)
    browser = visited.enter()
    with browser.websocket_connect(SOCKET, headers=OWN) as socket:
        _hello(visited, browser, socket)
        with pytest.raises(WebSocketDisconnect), browser.websocket_connect(SOCKET, headers=OWN):
            pytest.fail("it was accepted")
