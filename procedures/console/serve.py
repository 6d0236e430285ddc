"""The server: bound before anything is told, ended by a signal, silent about what it was asked."""

import asyncio
import socket
import ssl
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from ipaddress import ip_address
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import uvicorn
from psutil import net_if_addrs
from starlette.responses import PlainTextResponse
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from procedures.console.address import DEFAULT_LISTEN
from procedures.console.app import make_app
from procedures.console.gate import KNOWN, Site
from procedures.console.jogging import MOST_PAGES
from procedures.console.live_pages import MOST_SOCKETS
from procedures.console.sessions import MOST as MOST_SESSIONS
from procedures.console.shared import Console
from procedures.errors import RequestError

FAMILIES = (socket.AF_INET, socket.AF_INET6)
LONGEST_MESSAGE = 1024
OF_A_BROWSER = 6
"""Connections that a browser opens for requests to one host, its sockets beside them."""
MOST_CONNECTIONS = MOST_SESSIONS * OF_A_BROWSER + MOST_SOCKETS + MOST_PAGES
"""All that every session's browser can ask for at once, and every socket that there is a place for: 272."""
FULL = (
    f"calrig console: {MOST_CONNECTIONS} connections are open, and none has to make room; nothing was done; close "
    "pages that nobody looks at, then load this one again; what stops at once is the button at the machine\n"
)
FIRST_WORDS_S = 5.0
"""Who has connected and not asked anything whole for so long is sent away: he keeps a place from somebody."""
TAKES_S = 15.0
"""Who takes nothing of what he is sent for so long is sent away: a phone that sleeps asks again when it wakes."""


@dataclass(frozen=True)
class Listening:
    """Where the pages are served, and how."""

    socket: socket.socket
    site: Site
    is_here: bool
    """Whether only this machine reaches it: then a link that the terminal shows opens it."""
    tls: tuple[Path, Path] | None = None
    """Certificate and key."""


def bound(listen: str, tls: tuple[Path, Path] | None = None, names: tuple[str, ...] = (), proxy: str = "") -> Listening:
    """Return a socket that listens at HOST:PORT: this machine alone, or another address with TLS.

    ``names``: by which else browsers reach it; ``proxy``: the address of a proxy on this machine that does the TLS.
    Raises: RequestError.
    """
    host, _, port = listen.rpartition(":")
    host = host.strip("[]")
    try:
        number = int(port)
        is_here = host == "localhost" or ip_address(host).is_loopback
    except ValueError:
        raise RequestError(f"--listen: got {listen!r}, needed is HOST:PORT such as {DEFAULT_LISTEN}") from None
    if not is_here and (tls is None or proxy):
        raise RequestError(
            f"--listen: got {listen!r}, which other machines reach: needed are --tls-cert and --tls-key; nothing was "
            "served; or listen to this machine alone (127.0.0.1, ::1 or localhost), behind a proxy (--proxy) or "
            f"through ssh -L {number or 8600}:127.0.0.1:{number or 8600}"
        )
    if tls is not None:
        _require_tls(tls)
    proxied = _proxied(proxy) if proxy else None
    listening = _socket(listen, host, number)
    if proxied is not None:
        return Listening(listening, proxied, is_here=False)
    allowed = _names(listening, is_here, names)
    return Listening(listening, Site(allowed, "http" if tls is None else "https"), is_here, tls)


def _socket(listen: str, host: str, number: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    found = socket.socket(family, socket.SOCK_STREAM)
    try:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.bind((host, number))
    except (OSError, OverflowError) as error:
        found.close()
        raise RequestError(
            f"--listen {listen}: cannot be bound: {getattr(error, 'strerror', error)}; another console may be there; "
            "give another port, or 0 for one that is free"
        ) from error
    return found


def _require_tls(tls: tuple[Path, Path]) -> None:
    try:
        ssl.create_default_context(ssl.Purpose.CLIENT_AUTH).load_cert_chain(*tls, password="")
    except (OSError, ValueError) as error:
        raise RequestError(
            f"--tls-cert {tls[0]}, --tls-key {tls[1]}: are no certificate with its key: {error}; nothing was served"
        ) from error


def _proxied(proxy: str) -> Site:
    parts = urlsplit(proxy)
    if parts.scheme != "https" or not parts.hostname or parts.path not in ("", "/"):
        raise RequestError(f"--proxy: got {proxy!r}, needed is the address that browsers use, as https://rig.example")
    return Site(frozenset([parts.netloc]), "https", is_proxied=True)


def _names(listening: socket.socket, is_here: bool, names: tuple[str, ...]) -> frozenset[str]:
    """Return what a browser may call it. An address in figures cannot be bent to this machine, as a name can."""
    host, port = listening.getsockname()[:2]
    if is_here:
        here = {"127.0.0.1", "localhost", "::1"}
    else:
        here = {host, socket.gethostname().lower()} if host not in ("0.0.0.0", "::") else _addresses_of_here()  # noqa: S104
    ways = {f"[{name}]" if ":" in name else name for name in here | set(names)}
    return frozenset(f"{name}:{port}" for name in ways) | (frozenset(ways) if port == 443 else frozenset())


def _addresses_of_here() -> set[str]:
    found = {
        address.address for addresses in net_if_addrs().values() for address in addresses if address.family in FAMILIES
    }
    return {socket.gethostname().lower()} | {address.partition("%")[0] for address in found}


class _Taken(asyncio.Protocol):
    """What is sent has to be taken: one message waits for a slow reader, and no reader waits for another."""

    loop: asyncio.AbstractEventLoop
    transport: asyncio.Transport
    _patience_left: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        transport.set_write_buffer_limits(high=1, low=0)  # whatever the system does not take at once is told below
        super().connection_made(transport)

    def pause_writing(self) -> None:
        super().pause_writing()
        self._patience_left = self.loop.call_later(TAKES_S, self.transport.abort)

    def resume_writing(self) -> None:
        self._be_patient()
        super().resume_writing()

    def connection_lost(self, exc: Exception | None) -> None:
        self._be_patient()
        super().connection_lost(exc)

    def _be_patient(self) -> None:
        if self._patience_left is not None:
            self._patience_left.cancel()
            self._patience_left = None


class ImpatientSocket(_Taken, WebSocketsSansIOProtocol):
    """A socket of a page."""


class ImpatientProtocol(_Taken, H11Protocol):
    """HTTP that gives nobody a place for nothing: half-open connections and slow headers end in time.

    Where all places are taken, who has no session makes room for who comes, the longest there first, then whose session
    has more than a browser opens: a flood of connections keeps nobody else with a session from a stop.
    """

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self._came_s = self.loop.time()
        self._make_room()
        self._patience = self.loop.call_later(FIRST_WORDS_S, self._end_where_silent)

    def connection_lost(self, exc: Exception | None) -> None:
        self._patience.cancel()
        super().connection_lost(exc)

    def _make_room(self) -> None:
        while len(self.connections) > MOST_CONNECTIONS:
            if (leaving := self._who_leaves()) is None:
                self.app, self.ws_protocol_class = PlainTextResponse(FULL, 503, {"connection": "close"}), None
                return
            self.connections.discard(leaving)
            leaving.transport.abort()

    def _who_leaves(self) -> "ImpatientProtocol | None":
        of: dict[str, list[ImpatientProtocol]] = {}
        for connection in self.connections:
            if isinstance(connection, ImpatientProtocol) and connection is not self:
                of.setdefault(connection._session, []).append(connection)
        crowd = of.get("") or max(of.values(), key=len, default=[])
        if not of.get("") and len(crowd) <= OF_A_BROWSER:
            return None
        return min(crowd, key=lambda connection: connection._came_s)

    @property
    def _session(self) -> str:
        """The session of the newest request; empty for a stranger."""
        return str((getattr(self, "scope", None) or {}).get(KNOWN, ""))  # typed as if it were always there

    def _end_where_silent(self) -> None:
        has_request = getattr(self, "cycle", None) is not None  # typed as if it were always there
        if not has_request and self.transport.get_protocol() is self:  # a socket of a page has gone on to another
            self.transport.abort()


class ImpatientLoop(asyncio.SelectorEventLoop):
    """A loop in which who begins no TLS is sent away as soon as who says nothing: the protocol learns of him later."""

    async def create_server(self, *args: Any, **options: Any) -> asyncio.Server:
        if options.get("ssl") is not None:
            options["ssl_handshake_timeout"] = FIRST_WORDS_S
        server: asyncio.Server = await super().create_server(*args, **options)
        return server


def serve(listening: Listening, console: Console, tell: Callable[[str], None]) -> None:
    """Serve until a signal ends it; ``tell`` is given a link, and another each time one was used."""
    with asyncio.Runner(loop_factory=ImpatientLoop) as runner:
        runner.run(_serve(listening, console, tell))


async def _serve(listening: Listening, console: Console, tell: Callable[[str], None]) -> None:
    tls: dict[str, Any] = {}
    if listening.tls is not None:
        tls = {"ssl_certfile": str(listening.tls[0]), "ssl_keyfile": str(listening.tls[1])}
    config = uvicorn.Config(
        make_app(console),
        log_level="critical",
        access_log=False,
        http=ImpatientProtocol,
        ws=ImpatientSocket,
        ws_max_size=LONGEST_MESSAGE,
        timeout_keep_alive=5,
        timeout_graceful_shutdown=2,
        server_header=False,
        proxy_headers=False,
        lifespan="off",
        **tls,
    )
    telling = asyncio.ensure_future(_links(listening, console, tell) if listening.is_here else _codes(console, tell))
    with closing(listening.socket):
        try:
            await uvicorn.Server(config).serve(sockets=[listening.socket])
        finally:
            telling.cancel()
            console.close()


async def _links(listening: Listening, console: Console, tell: Callable[[str], None]) -> None:
    host, port = listening.socket.getsockname()[:2]
    address = f"{console.site.scheme}://{f'[{host}]' if ':' in host else host}:{port}/enter?key="
    while True:
        console.entered.clear()
        tell(address + console.sessions.new_key())
        await console.entered.wait()


async def _codes(console: Console, tell: Callable[[str], None]) -> None:
    """Tell the code that a browser of another machine needs before it begins motion."""
    while True:
        console.entered.clear()
        tell(f"code at the rig, for one browser that is to begin motion from elsewhere: {console.sessions.new_code()}")
        await console.entered.wait()
