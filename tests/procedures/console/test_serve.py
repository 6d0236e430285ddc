"""Where the console listens, and who keeps no place there."""

import asyncio
import ssl
import subprocess
from contextlib import suppress
from pathlib import Path

import pytest
import uvicorn
from programs import require_program
from starlette.responses import PlainTextResponse
from starlette.types import Receive, Scope, Send

from procedures.console import serve
from procedures.console.gate import KNOWN
from procedures.console.serve import bound
from procedures.errors import RequestError


def test_who_says_nothing_whole_is_sent_away_and_who_listens_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serve, "FIRST_WORDS_S", 0.05)
    listening = bound("127.0.0.1:0")
    listening.socket.listen()
    config = uvicorn.Config(PlainTextResponse("ok"), http=serve.ImpatientProtocol, lifespan="off", log_level="critical")

    async def talk() -> tuple[bytes, bytes]:
        server = uvicorn.Server(config)
        serving = asyncio.ensure_future(server.serve(sockets=[listening.socket]))
        address = listening.socket.getsockname()
        slow_reader, slow = await asyncio.open_connection(*address)
        slow.write(b"POST / HTTP/1.1\r\nhost: ")
        quick_reader, quick = await asyncio.open_connection(*address)
        quick.write(b"GET / HTTP/1.1\r\nhost: x\r\nconnection: close\r\n\r\n")
        async with asyncio.timeout(10.0):
            quickly = await quick_reader.read()
            try:
                slowly = await slow_reader.read()
            except ConnectionResetError:
                slowly = b""
        server.should_exit = True
        slow.close()
        quick.close()
        await serving
        return quickly, slowly

    quickly, slowly = asyncio.run(talk())
    listening.socket.close()
    assert quickly.endswith(b"ok")
    assert slowly == b""


def test_a_flood_of_connections_makes_room_for_who_has_a_session(monkeypatch: pytest.MonkeyPatch) -> None:
    """Silent ones and ones that ask without a session, many times the places; someone who is known asks between."""
    monkeypatch.setattr(serve, "MOST_CONNECTIONS", 8)
    listening = bound("127.0.0.1:0")
    listening.socket.listen(64)

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        is_known = (b"cookie", b"known") in scope["headers"]
        if is_known:
            scope[KNOWN] = True
        await PlainTextResponse("ok" if is_known else "no", 200 if is_known else 401)(scope, receive, send)

    config = uvicorn.Config(app, http=serve.ImpatientProtocol, lifespan="off", log_level="critical")
    address = listening.socket.getsockname()

    async def ask(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, cookie: bytes) -> bytes:
        writer.write(b"GET / HTTP/1.1\r\nhost: x\r\ncookie: " + cookie + b"\r\n\r\n")
        return await reader.readline()

    async def talk() -> list[bytes]:
        server = uvicorn.Server(config)
        serving = asyncio.ensure_future(server.serve(sockets=[listening.socket]))
        stays = await asyncio.open_connection(*address)
        found, others = [await ask(*stays, b"known")], []
        async with asyncio.timeout(20.0):
            await stays[0].readuntil(b"ok")
            for number in range(40):
                others.append(await asyncio.open_connection(*address))
                if number % 2:
                    with suppress(ConnectionError):
                        await ask(*others[-1], b"none")
                if number % 10 == 9:
                    comes = await asyncio.open_connection(*address)
                    found.append(await ask(*comes, b"known"))
                    comes[1].close()
            found.append(await ask(*stays, b"known"))
        server.should_exit = True
        for _, writer in [*others, stays]:
            writer.close()
        await serving
        return found

    found = asyncio.run(talk())
    listening.socket.close()
    assert found == [b"HTTP/1.1 200 OK\r\n"] * 6


def test_tls_of_ones_own_is_served_and_who_begins_none_is_sent_away(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serve, "FIRST_WORDS_S", 0.5)
    certificate, key = str(tmp_path / "cert.pem"), str(tmp_path / "key.pem")
    words = ["req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2"]
    names = ["-subj", "/CN=localhost", "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", key, "-out", certificate]
    subprocess.run([require_program("openssl"), *words, *names], check=True, capture_output=True)
    listening = bound("127.0.0.1:0", (Path(certificate), Path(key)))
    address = listening.socket.getsockname()
    config = uvicorn.Config(
        PlainTextResponse("ok"), http=serve.ImpatientProtocol, lifespan="off", log_level="critical",
        ssl_certfile=certificate, ssl_keyfile=key,
    )  # fmt: skip

    async def talk() -> tuple[bytes, bytes]:
        server = uvicorn.Server(config)
        serving = asyncio.ensure_future(server.serve(sockets=[listening.socket]))
        while not server.started:
            await asyncio.sleep(0)
        silent_reader, silent = await asyncio.open_connection(*address)
        known = ssl.create_default_context(cafile=certificate)
        reader, writer = await asyncio.open_connection(*address, ssl=known)
        writer.write(b"GET / HTTP/1.1\r\nhost: x\r\nconnection: close\r\n\r\n")
        async with asyncio.timeout(10.0):
            answered = await reader.read()
            try:
                silently = await silent_reader.read()
            except ConnectionResetError:
                silently = b""
        server.should_exit = True
        silent.close()
        writer.close()
        await serving
        return answered, silently

    with asyncio.Runner(loop_factory=serve.ImpatientLoop) as runner:
        answered, silently = runner.run(talk())
    listening.socket.close()
    assert (listening.site.scheme, listening.site.cookie()) == ("https", "__Host-calrig")
    assert answered.endswith(b"ok")
    assert silently == b""


def test_a_proxy_names_the_site_and_nobody_is_here() -> None:
    listening = bound("127.0.0.1:0", proxy="https://rig.example")
    listening.socket.close()
    assert (listening.site.hosts, listening.site.scheme) == (frozenset(["rig.example"]), "https")
    assert listening.site.is_elsewhere({"client": ("127.0.0.1", 1)})
    assert listening.site.cookie() == "__Host-calrig"
    assert not listening.is_here


@pytest.mark.parametrize("proxy", ["http://rig.example", "rig.example", "https://rig.example/path", "https://"])
def test_a_proxy_is_told_by_its_address(proxy: str) -> None:
    with pytest.raises(RequestError, match="--proxy: got"):
        bound("127.0.0.1:0", proxy=proxy)


def test_a_certificate_that_is_none_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "cert.pem").write_text("none")
    with pytest.raises(RequestError, match="are no certificate with its key"):
        bound("127.0.0.1:0", (tmp_path / "cert.pem", tmp_path / "key.pem"))


def test_other_machines_need_tls_even_with_a_proxy() -> None:
    with pytest.raises(RequestError, match="needed are --tls-cert and --tls-key"):
        bound("0.0.0.0:0", proxy="https://rig.example")
