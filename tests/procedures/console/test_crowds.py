"""Many who connect, and some who take nothing: each place has its reason, and nobody pays for another's."""

import asyncio
import socket
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path

import pytest
import uvicorn
from starlette.responses import PlainTextResponse
from starlette.testclient import TestClient
from starlette.types import Receive, Scope, Send
from starlette.websockets import WebSocketDisconnect
from visited_console import BASE, HOST, Visited

from procedures.console import live_pages, serve
from procedures.console.app import ALIVE_EVERY_S
from procedures.console.gate import KNOWN
from procedures.console.live_pages import ALL_TAKEN, PUT_ASIDE, LivePages
from procedures.console.serve import FULL, MOST_CONNECTIONS, OF_A_BROWSER, bound
from procedures.console.sessions import MOST as MOST_SESSIONS

Connection = tuple[asyncio.StreamReader, asyncio.StreamWriter]
LIVE, OWN = f"ws://{HOST}/live/night-1", {"origin": BASE}
PIECE = 50_000
MOST_IN_THE_SYSTEM = 30_000_000
"""Bytes that Linux may keep of one connection between two processes, both sides together."""


async def _app(scope: Scope, receive: Receive, send: Send) -> None:
    """Says who asks; its session is its cookie."""
    session = dict(scope["headers"]).get(b"cookie", b"").decode()
    if session:
        scope[KNOWN] = session
    await PlainTextResponse(session or "stranger")(scope, receive, send)


async def _ask(connection: Connection, session: str) -> str:
    """Ask once; the whole answer, empty where the connection is gone."""
    reader, writer = connection
    try:
        writer.write(f"GET / HTTP/1.1\r\nhost: x\r\ncookie: {session}\r\n\r\n".encode())
        head = (await reader.readuntil(b"\r\n\r\n")).decode().lower()
        length = int(head.partition("content-length: ")[2].partition("\r\n")[0])
        return (await reader.readexactly(length)).decode()
    except (ConnectionError, asyncio.IncompleteReadError):
        return ""


def _served(app: object, talk: Callable[[uvicorn.Server, tuple[str, int]], Awaitable[None]]) -> None:
    listening = bound("127.0.0.1:0")
    listening.socket.listen(512)
    config = uvicorn.Config(
        app, http=serve.ImpatientProtocol, ws=serve.ImpatientSocket, lifespan="off",  # type: ignore[arg-type]
        log_level="critical", timeout_keep_alive=60, timeout_graceful_shutdown=1,
    )  # fmt: skip

    async def all_of_it() -> None:
        server = uvicorn.Server(config)
        serving = asyncio.ensure_future(server.serve(sockets=[listening.socket]))
        async with asyncio.timeout(60.0):
            await talk(server, listening.socket.getsockname())
        server.should_exit = True
        await serving

    asyncio.run(all_of_it())
    listening.socket.close()


def test_every_browser_of_every_session_has_its_place_and_one_more_is_told_why_it_has_none() -> None:
    """Exactly at the figure nobody goes, one above it who comes is told; whoever opens more loses his own."""

    async def talk(server: uvicorn.Server, address: tuple[str, int]) -> None:
        async def connected() -> Connection:
            return await asyncio.open_connection(*address)

        kept: list[tuple[str, Connection]] = []
        for number in range(MOST_CONNECTIONS):
            session = f"session {number // OF_A_BROWSER}"
            kept.append((session, await connected()))
            assert await _ask(kept[-1][1], session) == session
        for session in ("", "session 0", "session 40"):
            refused = await connected()
            assert await _ask(refused, session) == FULL
            refused[1].close()
            await refused[1].wait_closed()
        assert [await _ask(one, session) for session, one in kept] == [session for session, _ in kept]
        kept.pop()[1][1].close()  # now there is one place, and somebody who takes many
        while len(server.server_state.connections) >= MOST_CONNECTIONS:
            await asyncio.sleep(0)
        flood: list[Connection] = []
        while len(flood) < 3 * OF_A_BROWSER:
            flood.append(await connected())
            assert await _ask(flood[-1], "session 7") == "session 7"
        answers = [await _ask(one, session) for session, one in kept if session != "session 7"]
        assert answers == [session for session, _ in kept if session != "session 7"], "it cost nobody else a place"
        for connection in [*flood, *(one for _, one in kept)]:
            connection[1].close()

    _served(_app, talk)


def test_the_figure_is_what_sessions_and_sockets_come_to() -> None:
    assert MOST_CONNECTIONS == MOST_SESSIONS * 6 + 64 + 16
    assert str(MOST_CONNECTIONS) in FULL


def test_a_thousand_strangers_keep_nobody_from_what_he_may() -> None:
    async def talk(server: uvicorn.Server, address: tuple[str, int]) -> None:
        stays = await asyncio.open_connection(*address)
        assert await _ask(stays, "session 1") == "session 1"
        strangers = [await asyncio.open_connection(*address) for _ in range(1000)]
        comes = await asyncio.open_connection(*address)
        assert await _ask(comes, "session 2") == "session 2"
        assert await _ask(stays, "session 1") == "session 1"
        assert len(server.server_state.connections) <= MOST_CONNECTIONS
        for connection in [*strangers, stays, comes]:
            connection[1].close()

    _served(_app, talk)


async def _endless(scope: Scope, receive: Receive, send: Send) -> None:
    """Sends for ever, by either way; what it has sent stands in its state."""
    if scope["path"] == "/quick":
        await PlainTextResponse("ok")(scope, receive, send)
        return
    piece = b"x" * PIECE
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.accept"})
    else:
        await send({"type": "http.response.start", "status": 200, "headers": []})
    while not SENT["is over"]:
        if scope["type"] == "websocket":
            await send({"type": "websocket.send", "bytes": piece})
        else:
            await send({"type": "http.response.body", "body": piece, "more_body": True})
        SENT["bytes"] += PIECE
        await asyncio.sleep(0)


SENT = {"bytes": 0, "is over": 0}
UPGRADE = (
    b"GET /live HTTP/1.1\r\nhost: x\r\nconnection: upgrade\r\nupgrade: websocket\r\n"
    b"sec-websocket-version: 13\r\nsec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
)


@pytest.mark.parametrize("asked", [b"GET /page HTTP/1.1\r\nhost: x\r\n\r\n", UPGRADE], ids=["page", "socket"])
def test_who_takes_nothing_is_dropped_fills_no_memory_and_slows_nobody(
    monkeypatch: pytest.MonkeyPatch, asked: bytes
) -> None:
    monkeypatch.setattr(serve, "TAKES_S", 0.5)
    SENT.update({"bytes": 0, "is over": 0})

    async def talk(server: uvicorn.Server, address: tuple[str, int]) -> None:
        slow = socket.create_connection(address)
        slow.sendall(asked)
        connections, largest, quick = server.server_state.connections, 0, 0
        while not connections:
            await asyncio.sleep(0)
        (of_slow,) = connections
        while SENT["bytes"] == 0:
            await asyncio.sleep(0)
        (of_slow,) = connections  # a socket has taken the place of its request
        while of_slow in connections:
            largest = max(largest, of_slow.transport.get_write_buffer_size())
            reader, writer = await asyncio.open_connection(*address)
            writer.write(b"GET /quick HTTP/1.1\r\nhost: x\r\nconnection: close\r\n\r\n")
            assert (await reader.read()).endswith(b"ok")
            quick += 1
            writer.close()
        assert quick > 1, "others were answered while it was waited for"
        assert largest < 2 * PIECE, "one piece waits for it"
        assert SENT["bytes"] < MOST_IN_THE_SYSTEM
        SENT["is over"] = 1
        slow.close()

    _served(_endless, talk)


def test_who_takes_slowly_but_takes_is_not_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    """A page over a poor line: each piece within its time, though all of it takes many times that."""
    monkeypatch.setattr(serve, "TAKES_S", 0.5)
    SENT.update({"bytes": 0, "is over": 0})

    async def talk(server: uvicorn.Server, address: tuple[str, int]) -> None:
        reader, writer = await asyncio.open_connection(*address)
        writer.write(b"GET /page HTTP/1.1\r\nhost: x\r\n\r\n")
        taken, until_s = 0, asyncio.get_running_loop().time() + 2.0
        while asyncio.get_running_loop().time() < until_s:
            taken += len(await reader.read(PIECE))
        assert taken > 0
        assert len(server.server_state.connections) == 1
        SENT["is over"] = 1
        writer.close()

    _served(_endless, talk)


def test_who_follows_most_makes_room_and_nobody_for_himself(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(live_pages, "MOST_SOCKETS", 4)
    crowd = LivePages()
    taken = [crowd.take("a") for _ in range(4)]
    assert crowd.take("a") is None, "a fifth tab of one person puts none of his own aside"
    second = crowd.take("b")
    assert second is not None
    assert [place is not None and place.leaves for place in taken] == [True, False, False, False]
    assert crowd.take("b") is not None
    assert crowd.take("b") is None, "two have half each"
    assert [place is not None and place.leaves for place in taken] == [True, True, False, False]
    crowd.give_back(second)
    crowd.give_back(second)
    assert crowd.take("a") is not None


@pytest.fixture
def visited(tmp_path: Path) -> Iterator[Visited]:
    found = Visited(tmp_path)
    yield found
    found.console.close()


def test_a_page_that_has_no_place_is_told_so(visited: Visited, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(live_pages, "MOST_SOCKETS", 2)
    browser, other = visited.enter(), visited.person("Anna Ray", "watch")

    def ended(page: TestClient) -> tuple[int, str]:
        with page.websocket_connect(LIVE, headers=OWN) as third, pytest.raises(WebSocketDisconnect) as left:
            third.receive_json()
        return left.value.code, left.value.reason or ""

    with browser.websocket_connect(LIVE, headers=OWN) as first, browser.websocket_connect(LIVE, headers=OWN) as second:
        for page in (first, second):
            assert "banner" in page.receive_json()
        assert ended(browser) == (PUT_ASIDE, ALL_TAKEN)
        with other.websocket_connect(LIVE, headers=OWN) as comes:
            assert "banner" in comes.receive_json()
            with pytest.raises(WebSocketDisconnect) as left:
                first.receive_json()
            assert (left.value.code, left.value.reason) == (PUT_ASIDE, ALL_TAKEN)
            visited.clock.sleep(ALIVE_EVERY_S)
            assert second.receive_json() == {}, "the one beside it follows on"
