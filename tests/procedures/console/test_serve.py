"""Where the console listens, and who keeps no place there."""

import asyncio
from pathlib import Path

import pytest
import uvicorn
from starlette.responses import PlainTextResponse

from procedures.console import serve
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
