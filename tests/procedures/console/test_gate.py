"""Who may look at the pages: each attack is refused, and no run notices."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from starlette.testclient import WebSocketTestSession
from starlette.websockets import WebSocketDisconnect
from visited_console import BASE, HOST, Visited

from procedures.console.serve import bound
from procedures.console.sessions import LIFE_S, MOST_WRONG
from procedures.errors import RequestError


@pytest.fixture
def visited(tmp_path: Path) -> Iterator[Visited]:
    found = Visited(tmp_path)
    (found.run / "report.html").write_text("<script>alert(1)</script>")
    before = found.digest()
    yield found
    found.console.close()
    assert found.digest() == before, "a page changed a run"


@pytest.mark.parametrize(
    "path", ["/", "/night", "/run/night-1", "/archive", "/api/v1/runs", "/metrics", "/static/console.js"]
)
def test_nothing_is_shown_without_a_session(visited: Visited, path: str) -> None:
    assert visited.browser.get(path).status_code == 401
    for token in ("", "x", "a" * 43):
        assert visited.browser.get(path, headers={"cookie": f"calrig={token}"}).status_code == 401
    assert visited.enter().get(path).status_code == 200


def test_a_link_works_once_and_a_session_for_twelve_hours(visited: Visited) -> None:
    key = visited.sessions.new_key()
    entered = visited.browser.get("/enter", params={"key": key})
    flags = entered.headers["set-cookie"].lower()
    assert "httponly" in flags
    assert "samesite=strict" in flags
    assert visited.new_browser().get("/enter", params={"key": key}).status_code == 403
    assert visited.browser.get("/").status_code == 200
    visited.clock.sleep(LIFE_S)
    assert visited.browser.get("/").status_code == 401


def test_keys_that_are_tried_lock_the_door_for_everybody_for_a_minute(visited: Visited) -> None:
    for _ in range(MOST_WRONG):
        assert visited.browser.get("/enter", params={"key": "guess"}).status_code == 403
    key = visited.sessions.new_key()
    assert visited.browser.get("/enter", params={"key": key}).status_code == 403
    visited.clock.sleep(61.0)
    assert visited.browser.get("/enter", params={"key": key}).status_code == 200


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1:1", "127.0.0.1", "localhost.evil.example:8600", ""])
def test_a_name_that_was_bent_to_this_machine_is_refused(visited: Visited, host: str) -> None:
    assert visited.enter().get("/", headers={"host": host}).status_code == 421


@pytest.mark.parametrize("method", ["PUT", "DELETE", "PATCH", "OPTIONS", "TRACE"])
def test_nothing_but_reading_and_posting_is_known(visited: Visited, method: str) -> None:
    assert visited.enter().request(method, "/run/night-1", content=b"x" * 70_000).status_code == 405


@pytest.mark.parametrize(
    "headers",
    [{"origin": "https://evil.example"}, {"origin": "null"}, {"origin": "http://127.0.0.1:9"},
     {"sec-fetch-site": "cross-site"}, {"sec-fetch-site": "same-site"}],
)  # fmt: skip
def test_what_another_site_asks_is_refused(visited: Visited, headers: dict[str, str]) -> None:
    assert visited.enter().get("/api/v1/runs", headers=headers).status_code == 403


@pytest.mark.parametrize("origin", [None, "https://evil.example", "null", "http://localhost:8600"])
def test_a_socket_is_opened_by_our_own_pages_alone(visited: Visited, origin: str | None) -> None:
    headers = {} if origin is None else {"origin": origin}
    browser = visited.enter()
    with pytest.raises(WebSocketDisconnect), browser.websocket_connect(f"ws://{HOST}/live/night-1", headers=headers):
        pytest.fail("it was accepted")
    with (
        pytest.raises(WebSocketDisconnect),
        visited.new_browser().websocket_connect(f"ws://{HOST}/live/night-1", headers={"origin": BASE}),
    ):
        pytest.fail("without a session it was accepted")


def test_a_socket_ends_with_its_session(visited: Visited) -> None:
    with visited.enter().websocket_connect(f"ws://{HOST}/live/night-1", headers={"origin": BASE}) as socket:
        assert "FINISHED" in socket.receive_json()["banner"]
        visited.clock.sleep(LIFE_S)
        with pytest.raises(WebSocketDisconnect):
            _hear_until_it_ends(socket)


def _hear_until_it_ends(socket: WebSocketTestSession) -> None:
    for _ in range(20):
        socket.receive_json()


@pytest.mark.parametrize(
    "path",
    ["/run/..", "/run/%2e%2e", "/run/..%2f..%2fetc", "/run/no-such", "/run/night-1%00", "/static/../app.py",
     "/static/%2e%2e/app.py", "/run/night-1/../../etc/passwd", "/archive/%2e%2e%2f", "/run/linked", "/live/night-1"],
)  # fmt: skip
def test_no_path_leads_out_of_the_folder_of_runs(visited: Visited, path: str) -> None:
    (visited.run.parent / "linked").symlink_to(visited.run, target_is_directory=True)
    answer = visited.enter().get(path)
    assert answer.status_code in (307, 404, 500)
    assert "root:" not in answer.text
    assert "def make_app" not in answer.text


def test_a_long_address_is_refused(visited: Visited) -> None:
    assert visited.enter().get("/archive", params={"q": "x" * 4000}).status_code == 414


def test_every_page_forbids_the_browser_what_it_does_not_need(visited: Visited) -> None:
    browser = visited.enter()
    for path in ("/", "/night", "/run/no-such", "/static/console.css"):
        headers = browser.get(path).headers
        assert headers["content-security-policy"].startswith("default-src 'none'; script-src 'self'")
        assert "frame-ancestors 'none'" in headers["content-security-policy"]
        assert (headers["x-content-type-options"], headers["referrer-policy"]) == ("nosniff", "same-origin")
        assert "server" not in headers
    assert (
        browser.get("/run/night-1/report").headers["content-security-policy"].startswith("sandbox; default-src 'none'")
    )


def test_a_line_break_in_what_is_asked_comes_back_in_no_header(visited: Visited) -> None:
    answer = visited.enter().get("/archive?q=%0d%0aset-cookie:%20a=b")
    assert "set-cookie" not in answer.headers


@pytest.mark.parametrize("listen", ["0.0.0.0:8600", "192.0.2.1:80", "[::]:8600", "bench:80", "8600", "127.0.0.1:x", ""])
def test_only_this_machine_is_listened_to(listen: str) -> None:
    with pytest.raises(RequestError, match="--listen: got"):
        bound(listen)
