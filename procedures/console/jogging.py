"""Jogging from a browser: the pages, the socket of each, and the stop that needs no socket.

A page names a rig by its file in the console's folder, as the queue does. What it says is passed on to the process that
has the devices (:mod:`procedures.console.benches`) with the name of who says it; who may is looked at here.
"""

import asyncio
import json
import secrets
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from anyio.to_thread import run_sync
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response
from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from procedures.console.acting import Acting, new_key
from procedures.console.acts import ACCEPTED, REFUSED, Action, Answer
from procedures.console.additions import is_rig_file, offered
from procedures.console.benches import Benches
from procedures.console.gate import token_of
from procedures.console.rights import refusal
from procedures.console.sessions import Visitor
from procedures.console.shared import Console
from procedures.console.templates_of import Pages
from procedures.queue.hands import JOG_STOP, disarm_by_stop_of_rig
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription
from rig.errors import RigError
from rig.guard.ask import of_rig
from rig.guard.ask import stop as stop_by_guard
from rig.lines.lock import owner_of

FIRST_WORDS_S = 5.0
MOST_WORDS_A_SECOND = 60
"""Of one page; it beats twenty times."""
MOST_PAGES = 16
"""Of all rigs, open at once: the one that was silent for longest makes room, unless it has a bench."""
SESSION_S = 1.0
"""So often a page that only looks is looked at: whose session has ended sees the bench no more."""
ENDED = (
    "the session has ended, or its account is another one now; what moved by this page was stopped; load the page again"
)
FIELDS = ("say", "tick", "press", "held", "away", "act", "axis", "degrees")
"""All that a page says to a bench."""
POLICY, TOO_MANY = 1008, 1013


@dataclass
class _Page:
    """One tab: what it is told next is always the newest; a slow one misses what was in between."""

    socket: WebSocket
    is_elsewhere: bool
    heard_s: float
    """When it said something last, or came."""
    name: str = ""
    """Of whose page it is; empty before its first words."""
    client: str = field(default_factory=lambda: secrets.token_hex(8))
    news: dict[str, Any] = field(default_factory=dict)
    has_news: asyncio.Event = field(default_factory=asyncio.Event)
    words: int = 0
    since_s: float = 0.0

    @property
    def address(self) -> str:
        return self.socket.client.host if self.socket.client else ""

    def hear(self, document: dict[str, Any]) -> None:
        self.news |= document
        self.has_news.set()

    def is_too_loud(self, now_s: float) -> bool:
        """Count a word; return whether there were too many within the last second."""
        self.heard_s = now_s
        if now_s - self.since_s > 1.0:
            self.words, self.since_s = 0, now_s
        self.words += 1
        return self.words > MOST_WORDS_A_SECOND


class Jogging:
    """One method a route."""

    def __init__(self, console: Console, pages: Pages, acting: Acting) -> None:
        self._console = console
        self._pages = pages
        self._acting = acting
        self._benches = Benches()
        self._open: list[_Page] = []
        self._closing: set[asyncio.Task[None]] = set()

    async def rigs(self, request: Request) -> Response:
        """Show which rigs there are, and who has each."""
        found = await run_sync(self._rigs)
        return self._pages.shown(
            "jogs.html.j2", here="jog", rigs=found, folder=self._console.files, visitor=self._console.visitor(request)
        )

    def _rigs(self) -> list[tuple[str, str]]:
        return [(name, self._owner(self._console.files / name)) for name in offered(self._console.files).rigs]

    def _owner(self, rig: Path) -> str:
        """Return who has a rig; empty where nobody has."""
        owner = owner_of(str(rig))
        return "" if owner is None else str(owner)

    async def page(self, request: Request) -> Response:
        rig = await run_sync(self._file, request.path_params["rig"])
        visitor = self._console.visitor(request)
        try:
            description = await run_sync(read_rig, rig)
        except RigError as error:
            raise HTTPException(409, str(error)) from error
        is_elsewhere = self._console.site.is_elsewhere(request.scope)
        return self._pages.shown(
            "jog.html.j2",
            here="jog",
            rig=rig.name,
            name=description.rig.name,
            is_simulated=description.is_simulated,
            sensors={name: list(sensor.channels.values()) for name, sensor in description.sensors.items()},
            owner=await run_sync(self._owner, rig),
            refusal=refusal("jog", visitor, description, is_elsewhere=is_elsewhere),
            is_elsewhere=is_elsewhere,
            visitor=visitor,
            key=new_key(),
        )

    def _file(self, name: str) -> Path:
        """Return a rig file of the console's folder by its plain name. Raises: HTTPException."""
        if not is_rig_file(self._console.files, name):
            raise HTTPException(404, "there is no such rig file in the folder of the console")
        return self._console.files / name

    # A stop, by a form: it needs neither script nor socket, and waits for no other page and no disk before it is told.

    async def stop(self, request: Request) -> Response:
        name = request.path_params["rig"]

        def tell_bench(action: Action) -> None:
            if (bench := self._benches.find(self._console.files / name)) is not None:
                bench.send("form", action.by, action.address, {"say": "stop"})

        return await self._acting.answer(
            request, "halt", lambda _: None, partial(self._halt, name), f"/jog/{name}", at_once=tell_bench
        )

    def _halt(self, name: str, action: Action) -> Answer:
        rig = self._console.files / name
        if self._benches.find(rig) is None:  # of one that is open the file may be gone
            rig = self._file(name)
        outcomes: dict[str, str] = {}
        for guard in of_rig(str(rig)):
            outcomes |= stop_by_guard(guard, None, action.by) or {}
        outcome_text = "; ".join(f"{axis}: {outcome}" for axis, outcome in sorted(outcomes.items()))
        if not outcome_text and self._benches.find(rig) is None:
            return Answer(REFUSED, "stop: no calrig of this machine moves that rig, so nothing moves by it")
        queues = disarm_by_stop_of_rig(self._console.queues, rig, JOG_STOP, self._console.clock)
        return Answer(
            ACCEPTED, "; ".join((f"stop was asked for{f' ({outcome_text})' if outcome_text else ''}", *queues))
        )

    # The socket.

    async def socket(self, socket: WebSocket) -> None:
        """Hear one page until it leaves, says what no page says, its session ends, or it makes room for another."""
        page = _Page(socket, self._console.site.is_elsewhere(socket.scope), self._console.clock.monotonic_s())
        if not self._has_room_for(page):
            await socket.close(TOO_MANY)
            return
        try:
            rig = await run_sync(self._file, socket.path_params["rig"])
            await socket.accept()
            page.name = (await self._visitor_of(socket)).name
            await self._serve(rig, page)
        except HTTPException as error:
            await _end(page, error.detail)
        except (
            WebSocketDisconnect,
            RuntimeError,
            KeyError,
        ):  # bytes are no words; or the browser went away, also in the middle of a sending
            pass
        finally:
            if page in self._open:
                self._open.remove(page)

    def _has_room_for(self, page: _Page) -> bool:
        """Take a place for a page; False where every one is that of a page that has a bench."""
        if len(self._open) >= MOST_PAGES:
            idle = [page for page in self._open if not self._benches.has(page.client)]
            if not idle:
                return False
            silent = min(idle, key=lambda page: page.heard_s)
            self._open.remove(silent)
            closing = asyncio.create_task(_put_aside(silent))  # one that takes nothing keeps nobody waiting
            self._closing.add(closing)
            closing.add_done_callback(self._closing.discard)
        self._open.append(page)
        return True

    async def _visitor_of(self, socket: WebSocket) -> Visitor:
        """Return whose page it is: its first words are the token that no page of another site knows."""
        visitor = self._console.sessions.visitor(token_of(socket.headers, self._console.site))
        try:
            async with asyncio.timeout(FIRST_WORDS_S):
                given = _order(await socket.receive_text()).get("csrf")
        except TimeoutError:
            given = None
        if (
            visitor is None
            or not isinstance(given, str)
            or not secrets.compare_digest(given.encode("utf-8", errors="surrogateescape"), visitor.csrf.encode())
        ):
            raise HTTPException(403, ENDED)
        return visitor

    async def _serve(self, rig: Path, page: _Page) -> None:
        page.hear({"you": page.client, "owner": await run_sync(self._owner, rig)})
        if (bench := self._benches.find(rig)) is not None:
            page.hear(bench.latest)
        self._benches.listen(rig, page.hear)
        telling = asyncio.create_task(self._tell(page))
        try:
            while not telling.done():
                order = _order(await page.socket.receive_text())
                visitor = self._session_of(page)
                if page.is_too_loud(self._console.clock.monotonic_s()):
                    raise HTTPException(403, "the page said too much; what moved by it was stopped; load it again")
                await self._hear(rig, page, visitor, order)
        finally:
            telling.cancel()
            self._benches.leave(rig, page.hear)
            self._say(rig, page, {"say": "gone"})

    def _session_of(self, page: _Page) -> Visitor:
        """Return who the page is. Raises: HTTPException where its session stands no more."""
        found = self._console.sessions.visitor(token_of(page.socket.headers, self._console.site))
        if found is None:
            raise HTTPException(403, ENDED)
        return found

    async def _tell(self, page: _Page) -> None:
        """Send the newest of everything, as fast as the page takes it, while its session stands."""
        seen_s = self._console.clock.monotonic_s()
        while True:
            await page.has_news.wait()
            page.has_news.clear()
            if (now_s := self._console.clock.monotonic_s()) - seen_s > SESSION_S:
                seen_s = now_s
                try:
                    self._session_of(page)
                except HTTPException as error:
                    await _end(page, error.detail)
                    return
            news, page.news = page.news, {}
            await page.socket.send_text(json.dumps(news))

    async def _hear(self, rig: Path, page: _Page, visitor: Visitor, order: dict[str, Any]) -> None:
        say = order.get("say")
        if say == "stop":
            if complaint := refusal("halt", visitor, None, is_elsewhere=False):
                page.hear({"told": complaint})
            else:
                self._say(rig, page, {"say": "stop"})
        elif say == "take":
            await self._take(rig, page, visitor)
        elif say in ("beat", "do", "give"):
            bench = self._benches.find(rig)
            if bench is not None and bench.has(page.client):
                self._say(rig, page, {name: order[name] for name in FIELDS if name in order})
            elif say == "do":
                page.hear({"told": f"{page.name} does not have the bench; nothing moved"})

    def _say(self, rig: Path, page: _Page, order: dict[str, Any]) -> None:
        if (bench := self._benches.find(rig)) is not None:
            bench.send(page.client, page.name, page.address, order)

    async def _take(self, rig: Path, page: _Page, visitor: Visitor) -> None:
        """Give the bench to a page that may have it; it is opened where it is not."""
        description = await run_sync(_described, rig) if page.is_elsewhere else None
        if complaint := refusal("jog", visitor, description, is_elsewhere=page.is_elsewhere):
            page.hear({"told": complaint})
            return
        if not self._console.sessions.counts_act(visitor):
            page.hear({"told": "too many acts within a minute; nothing was done"})
            return
        try:
            bench = await self._benches.open(rig)
        except (OSError, NotImplementedError) as error:
            page.hear({"told": f"the bench cannot be opened here: {error}"})
            return
        if bench.holder and not bench.has(page.client):
            page.hear({"told": f"{bench.holder} has the bench; nothing was done"})
        bench.send(page.client, page.name, page.address, {"say": "take"})


def _described(rig: Path) -> RigDescription | None:
    """Return what the rig file allows; None where it cannot be read: then nothing is allowed by it."""
    try:
        return read_rig(rig)
    except RigError:
        return None


def _order(text: str) -> dict[str, Any]:
    """Return what a page says. Raises: HTTPException for what is no object of JSON."""
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise HTTPException(400)
    return found


async def _end(page: _Page, message: str) -> None:
    """Say why the page is heard no more, and end it."""
    with suppress(RuntimeError, WebSocketDisconnect):
        if page.socket.application_state is WebSocketState.CONNECTED:
            await page.socket.send_text(json.dumps({"told": message}))
        await page.socket.close(POLICY)


async def _put_aside(page: _Page) -> None:
    with suppress(RuntimeError, WebSocketDisconnect):
        await page.socket.close(TOO_MANY)
