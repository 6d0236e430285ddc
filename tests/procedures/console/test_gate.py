"""Who may look at the pages: each attack is refused, and no run notices."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from starlette.testclient import TestClient, WebSocketTestSession
from starlette.websockets import WebSocketDisconnect
from visited_console import BASE, HOST, Visited

from procedures.console.serve import bound
from procedures.console.sessions import BY_LINKS, LIFE_S, MOST, MOST_WRONG, OF_AN_ACCOUNT
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


def test_keys_that_are_tried_lock_the_door_for_everybody_for_a_minute_and_say_so(visited: Visited) -> None:
    key = visited.sessions.new_key()
    for number in range(MOST_WRONG):
        wrong = visited.browser.get("/enter", params={"key": "guess"})
        assert (wrong.status_code, "was used, or is none" in wrong.text) == (403, number + 1 < MOST_WRONG)
    locked = visited.browser.get("/enter", params={"key": key})
    assert (locked.status_code, "no link is looked at for 60 s" in locked.text) == (403, True)
    assert "is none" not in locked.text, "the terminal has no other: this one still opens it"
    visited.clock.sleep(61.0)
    assert visited.browser.get("/enter", params={"key": key}).status_code == 200


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_what_pages_of_other_sites_fetch_locks_nobody_out(visited: Visited, site: str) -> None:
    """An image of any page that is open at the machine; a link in a mail comes the same way, and enters."""
    headers = {"sec-fetch-site": site}
    for _ in range(2 * MOST_WRONG):
        assert visited.browser.get("/enter", params={"key": "x"}, headers=headers).status_code == 403
    assert visited.browser.get("/enter", params={"key": visited.sessions.new_key()}).status_code == 200
    key = visited.sessions.new_key()
    assert visited.new_browser().get("/enter", params={"key": key}, headers=headers).status_code == 200


def _logs_in(visited: Visited, name: str, secret: str) -> tuple[TestClient, int, str]:
    browser = visited.new_browser()
    answer = browser.post("/login", data={"name": name, "secret": secret}, headers={"origin": BASE})
    return browser, answer.status_code, answer.text


def test_an_account_ends_its_own_oldest_session_and_nobody_elses(visited: Visited) -> None:
    """Whoever only looks could take the stop from everybody by logging in again and again."""
    by_link, operator = visited.enter(), visited.person("Olga", "operate")
    secret = visited.people.add("Wim", "watch", visited.clock.now_utc())
    watchers = [_logs_in(visited, "Wim", secret)[0] for _ in range(MOST + 1)]
    assert [browser.get("/healthz").status_code for browser in (by_link, operator)] == [200, 200]
    assert [browser.get("/").status_code for browser in (by_link, operator)] == [200, 200]
    assert [browser.get("/").status_code for browser in watchers] == [401] * (MOST + 1 - OF_AN_ACCOUNT) + [
        200
    ] * OF_AN_ACCOUNT


def test_accounts_that_have_every_place_keep_out_the_next_but_no_link_and_put_nobody_aside(visited: Visited) -> None:
    secrets = {f"P{n}": visited.people.add(f"P{n}", "watch", visited.clock.now_utc()) for n in range(8)}
    crowd = [_logs_in(visited, name, secrets[name])[0] for name in list(secrets)[:7] for _ in range(OF_AN_ACCOUNT)]
    assert len(crowd) == MOST - OF_AN_ACCOUNT
    _, code, text = _logs_in(visited, "P7", secrets["P7"])
    assert (code, "none is yours; nobody was let in" in text) == (503, True)
    links = [visited.new_browser() for _ in range(BY_LINKS)]
    for browser in links:
        assert browser.get("/enter", params={"key": visited.sessions.new_key()}).status_code == 200
    assert [browser.get("/").status_code for browser in crowd] == [200] * len(crowd)
    assert [browser.get("/").status_code for browser in links].count(200) == OF_AN_ACCOUNT, "32 at once in all"
    visited.people.remove("P0")
    assert _logs_in(visited, "P7", secrets["P7"])[1] == 303, "the places of an account that has gone are free"
    assert [browser.get("/").status_code for browser in crowd[OF_AN_ACCOUNT:]] == [200] * (len(crowd) - OF_AN_ACCOUNT)


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
