"""The server: bound to this machine before anything is told, ended by a signal, silent about what it was asked."""

import asyncio
import socket
from collections.abc import Callable
from contextlib import closing
from ipaddress import ip_address

import uvicorn

from procedures.console.app import Console, make_app
from procedures.errors import RequestError

DEFAULT_LISTEN = "127.0.0.1:8600"
LONGEST_MESSAGE = 1024
MOST_CONNECTIONS = 256


def bound(listen: str) -> socket.socket:
    """Return a socket that listens at HOST:PORT of this machine alone. Raises: RequestError."""
    host, _, port = listen.rpartition(":")
    host = host.strip("[]")
    try:
        number = int(port)
        is_own = host == "localhost" or ip_address(host).is_loopback
    except ValueError:
        raise RequestError(f"--listen: got {listen!r}, needed is HOST:PORT such as {DEFAULT_LISTEN}") from None
    if not is_own:
        raise RequestError(
            f"--listen: got {listen!r}; the pages are served to this machine alone (127.0.0.1, ::1 or localhost): from "
            f"another one look through ssh -L {number or 8600}:127.0.0.1:{number or 8600}; nothing was served"
        )
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    found = socket.socket(family, socket.SOCK_STREAM)
    try:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.bind((host, number))
    except OSError as error:
        found.close()
        raise RequestError(
            f"--listen {listen}: cannot be bound: {error.strerror}; another console may be there; give another port, "
            "or 0 for one that is free"
        ) from error
    return found


def hosts_of(listening: socket.socket) -> frozenset[str]:
    """Return what a browser of this machine may call it."""
    port = listening.getsockname()[1]
    return frozenset(f"{name}:{port}" for name in ("127.0.0.1", "localhost", "[::1]"))


def serve(listening: socket.socket, console: Console, tell: Callable[[str], None]) -> None:
    """Serve until a signal ends it; ``tell`` is given a link, and another each time one was used."""
    asyncio.run(_serve(listening, console, tell))


async def _serve(listening: socket.socket, console: Console, tell: Callable[[str], None]) -> None:
    app = make_app(console, hosts_of(listening))
    config = uvicorn.Config(
        app,
        log_level="critical",
        access_log=False,
        ws="websockets-sansio",
        ws_max_size=LONGEST_MESSAGE,
        limit_concurrency=MOST_CONNECTIONS,
        timeout_keep_alive=5,
        timeout_graceful_shutdown=2,
        server_header=False,
        lifespan="off",
    )
    host, port = listening.getsockname()[:2]
    where = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
    links = asyncio.ensure_future(_links(console, f"http://{where}/enter?key=", tell))
    with closing(listening):
        try:
            await uvicorn.Server(config).serve(sockets=[listening])
        finally:
            links.cancel()
            console.close()


async def _links(console: Console, address: str, tell: Callable[[str], None]) -> None:
    while True:
        console.entered.clear()
        tell(address + console.sessions.new_key())
        await console.entered.wait()
