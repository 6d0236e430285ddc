"""The application: routes, and what each page is given. Whatever reads a disk does so in a thread."""

import asyncio
import json
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from threading import Lock

from anyio.to_thread import run_sync
from jinja2 import Environment
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect

from ams.archive.desk import due_list, search_runs
from ams.archive.refusals import without_password
from ams.archive.sets import list_sets
from ams.errors import ArchiveError
from procedures.console.gate import COOKIE, Gate
from procedures.console.night import needs_a_person, night
from procedures.console.sessions import LIFE_S, Sessions
from procedures.console.watched_run import RunPage, WatchedRun
from procedures.errors import ProcedureError
from procedures.journal.live import read_live
from procedures.journal.metrics import RunFigures, metrics_text
from procedures.journal.run_list import ListedRun, RunList
from procedures.journal.standing import progress_of
from procedures.journal.standing_words import duration
from procedures.journal.status import status
from procedures.pages import page_environment
from procedures.records.progress import at_both
from rig.clock import Clock

HERE = Path(__file__).parent
LOOK_S, ALIVE_EVERY_S = 0.25, 2.0
MOST_SOCKETS = 64
MOST_WATCHED = 8
REPORT_POLICY = "sandbox; default-src 'none'; img-src data:; style-src 'unsafe-inline'; frame-ancestors 'none'"
"""The report brings its own, stricter one; it never runs a script."""


@dataclass
class Console:
    """What the pages read, shared by all requests."""

    runs: RunList
    archive_url: str
    clock: Clock
    sessions: Sessions
    entered: asyncio.Event = field(default_factory=asyncio.Event)
    """Set when somebody entered: the next link can be told."""
    _watched: dict[str, WatchedRun] = field(default_factory=dict)
    _lock: Lock = field(default_factory=Lock)
    sockets: int = 0

    def listed(self) -> tuple[ListedRun, ...]:
        with self._lock:
            return self.runs.read()

    def watched(self, name: str) -> WatchedRun:
        """Return the run of a name that stands in the folder of runs. Raises: HTTPException, JournalError."""
        with self._lock:
            paths = {path.name: path for path in self.runs.paths() if not path.is_symlink()}
            if name not in paths:
                raise HTTPException(404, "there is no such run")
            if name not in self._watched:
                while len(self._watched) >= MOST_WATCHED:
                    self._watched.pop(next(iter(self._watched))).close()
                self._watched[name] = WatchedRun(paths[name], self.clock)
            return self._watched[name]

    def page(self, name: str) -> RunPage:
        return self.watched(name).page()

    def first(self) -> str | None:
        """Return the run that is alive, else the latest that can be read."""
        alive = self.runs.alive()
        if alive:
            return alive[0].name
        return next((run.path.name for run in self.listed() if not run.trouble), None)

    def close(self) -> None:
        for run in self._watched.values():
            run.close()
        self._watched.clear()


def make_app(console: Console, hosts: frozenset[str]) -> ASGIApp:
    """Return the application behind its gate."""
    pages = _Pages(console)
    routes = [
        Route("/", pages.home),
        Route("/run/{name}", pages.run),
        Route("/run/{name}/report", pages.report),
        Route("/night", pages.night),
        Route("/archive", pages.archive),
        Route("/archive/{sensor}", pages.sensor),
        Route("/api/v1/runs", pages.api_runs),
        Route("/api/v1/runs/{name}", pages.api_run),
        Route("/api/v1/runs/{name}/map", pages.api_map),
        Route("/metrics", pages.metrics),
        Route("/healthz", pages.healthz),
        Route("/enter", pages.enter),
        WebSocketRoute("/live/{name}", pages.live),
        Mount("/static", StaticFiles(directory=HERE / "static")),
    ]
    handlers = {HTTPException: pages.refused, ProcedureError: pages.failed, ArchiveError: pages.failed}
    return Gate(Starlette(routes=routes, exception_handlers=handlers), console.sessions, hosts)


def environment() -> Environment:
    """Return the templates with the filters of these pages."""
    found = page_environment(HERE / "templates")
    found.filters.update({"both": at_both, "lasting": duration, "local": _local})
    return found


def _local(moment: datetime) -> str:
    return f"{moment.astimezone():%a %H:%M:%S}"


class _Pages:
    """One method a route."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._templates = environment()

    async def home(self, request: Request) -> Response:
        name = await run_sync(self._console.first)
        if name is None:
            return await self._shown("empty.html.j2", here="run", folder=str(self._console.runs.folder))
        return await self._run_page(name)

    async def run(self, request: Request) -> Response:
        return await self._run_page(request.path_params["name"])

    async def _run_page(self, name: str) -> Response:
        page = await run_sync(self._console.page, name)
        others = [run for run in await run_sync(self._console.listed) if run.path.name != name and not run.trouble]
        return await self._shown("run.html.j2", here="run", page=page, others=others[:12], waits=needs_a_person(page))

    async def report(self, request: Request) -> Response:
        watched = await run_sync(self._console.watched, request.path_params["name"])
        file = watched.folder / "report.html"
        if not file.is_file() or file.is_symlink():
            raise HTTPException(404, "this run has no report")
        return FileResponse(file, media_type="text/html", headers={"content-security-policy": REPORT_POLICY})

    async def night(self, request: Request) -> Response:
        console = self._console
        listed = await run_sync(console.listed)
        told = await run_sync(night, listed, console.archive_url, console.clock.now_utc())
        return await self._shown("night.html.j2", here="night", night=told, today=console.clock.now_utc().date())

    async def archive(self, request: Request) -> Response:
        words = request.query_params.get("q", "")
        url = self._console.archive_url
        found = await run_sync(search_runs, url, words.split())
        sets = await run_sync(list_sets, url)
        due = await run_sync(due_list, url)
        sensors = {one.sensor: one for one in sets}
        return await self._shown(
            "archive.html.j2", here="archive", words=words, found=found[:100], count=len(found), sensors=sensors,
            due=due, today=self._console.clock.now_utc().date(), archive=without_password(url),
        )  # fmt: skip

    async def sensor(self, request: Request) -> Response:
        sensor = request.path_params["sensor"]
        sets = await run_sync(list_sets, self._console.archive_url, sensor)
        if not sets:
            raise HTTPException(404, "the archive holds no such sensor")
        return await self._shown("sensor.html.j2", here="archive", sensor=sensor, sets=list(reversed(sets)))

    async def api_runs(self, request: Request) -> Response:
        listed = await run_sync(self._console.listed)
        return JSONResponse({"runs": [one.to_document() for one in listed]})

    async def api_run(self, request: Request) -> Response:
        page = await run_sync(self._console.page, request.path_params["name"])
        document = {**page.status.to_document(), "run": page.run_id, "alive": page.is_alive}
        return JSONResponse(document | {"rows": dict(page.rows), "verdict": page.verdict})

    async def api_map(self, request: Request) -> Response:
        watched = await run_sync(self._console.watched, request.path_params["name"])
        picture = await run_sync(watched.picture)
        return JSONResponse(None if picture is None else picture.to_document())

    async def metrics(self, request: Request) -> Response:
        return PlainTextResponse(await run_sync(self._metrics), media_type="text/plain; version=0.0.4")

    def _metrics(self) -> str:
        return metrics_text(
            RunFigures(one.path.name, progress_of("state", status(one.path)), read_live(one.path), one.is_alive)
            for one in self._console.listed()
            if not one.trouble
        )

    async def healthz(self, request: Request) -> Response:
        return PlainTextResponse("ok\n")

    async def enter(self, request: Request) -> Response:
        token = self._console.sessions.enter(request.query_params.get("key", ""))
        if token is None:
            return PlainTextResponse("calrig console: this link was used, or is none; the terminal has the next\n", 403)
        self._console.entered.set()
        response = await self._shown("entered.html.j2", here="")
        response.set_cookie(COOKIE, token, max_age=int(LIFE_S), httponly=True, samesite="strict")
        return response

    async def live(self, socket: WebSocket) -> None:
        console = self._console
        if console.sockets >= MOST_SOCKETS:
            await socket.close(1013)
            return
        console.sockets += 1
        try:
            await socket.accept()
            await self._tell(socket, socket.path_params["name"])
        except (WebSocketDisconnect, RuntimeError):  # the browser went away, also in the middle of a sending
            pass
        except (HTTPException, ProcedureError):
            with suppress(RuntimeError):
                await socket.close(1011)
        finally:
            console.sockets -= 1

    async def _tell(self, socket: WebSocket, name: str) -> None:
        """Send the changing part of the page whenever it is another, and a sign of life between."""
        template, version, told_s = self._templates.get_template("standing.html.j2"), "", 0.0
        token = socket.cookies.get(COOKIE)
        gone = asyncio.ensure_future(_gone(socket))
        try:
            while not gone.done() and self._console.sessions.knows(token):
                page, now_s = await run_sync(self._console.page, name), self._console.clock.monotonic_s()
                if page.version != version:
                    html = template.render(page=page, waits=needs_a_person(page))
                    await socket.send_text(json.dumps({"html": html, "done": page.status.dwells_done}))
                    version, told_s = page.version, now_s
                elif now_s - told_s >= ALIVE_EVERY_S:
                    await socket.send_text("{}")
                    told_s = now_s
                await asyncio.wait([gone], timeout=LOOK_S)
            if not gone.done():
                await socket.close(1008)
        finally:
            gone.cancel()

    async def refused(self, request: Request, error: Exception) -> Response:
        assert isinstance(error, HTTPException)
        return await self._shown("error.html.j2", error.status_code, here="", told=error.detail)

    async def failed(self, request: Request, error: Exception) -> Response:
        return await self._shown("error.html.j2", 500, here="", told=str(error))

    async def _shown(self, template: str, status_code: int = 200, **values: object) -> HTMLResponse:
        now = datetime.now(UTC)
        return HTMLResponse(self._templates.get_template(template).render(now=now, **values), status_code)


async def _gone(socket: WebSocket) -> None:
    """Return when the browser leaves, or says anything: there is nothing to be said."""
    with suppress(WebSocketDisconnect, RuntimeError):
        await socket.receive()
