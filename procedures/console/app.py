"""The application: routes, and what each page is given. Whatever reads a disk does so in a thread."""

import asyncio
import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

from anyio.to_thread import run_sync
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect

from ams.archive.due_list import SENSOR_EVERY_DAYS, Due, due_list
from ams.archive.refusals import without_password
from ams.archive.run_search import FoundRun, search_runs
from ams.archive.sets import ArchivedSet, list_sets
from ams.errors import ArchiveAbsent, ArchiveError
from procedures.console.acting import Acting, new_key
from procedures.console.additions import Additions
from procedures.console.entrance import Entrance
from procedures.console.gate import Gate, token_of
from procedures.console.jogging import Jogging
from procedures.console.live_pages import ALL_TAKEN, PUT_ASIDE, LivePage
from procedures.console.night import Archived, archived, damage_words, needs_a_person, night
from procedures.console.queues import QueuePages, undecided_items
from procedures.console.sessions import Visitor
from procedures.console.shared import ARCHIVE_S, BESIDE_S, Console
from procedures.console.templates_of import HERE, Pages
from procedures.console.watched_run import RunPage
from procedures.console.withdrawn_sets import withdrawn_sentence
from procedures.console.withheld import withheld_sentence
from procedures.errors import ProcedureError
from procedures.journal.status.metrics import figures_of, metrics_text
from rig.local_time import local_day

MOST_NAMED = 12
"""Of other runs below one; the archive finds all."""
LOOK_S, ALIVE_EVERY_S = 0.25, 2.0
MOST_LISTED = 100
"""Runs on the page of the archive."""
REPORT_POLICY = "sandbox; default-src 'none'; img-src data:; style-src 'unsafe-inline'; frame-ancestors 'none'"
"""The report brings its own, stricter one; it never runs a script."""


def make_app(console: Console) -> ASGIApp:
    """Return the application behind its gate."""
    templates = Pages()
    pages, acting, entrance = _Pages(console, templates), Acting(console, templates), Entrance(console, templates)
    queues = QueuePages(console, templates, acting)
    jogging = Jogging(console, templates, acting)
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
        Route("/api/v1/runs/{name}/{act}", acting.on_run, methods=["POST"]),
        Route("/queue", queues.page),
        Route("/api/v1/queues", queues.api),
        Route("/api/v1/queues", Additions(console, acting).act, methods=["POST"]),
        Route("/api/v1/queues/{name}/{act}", queues.act, methods=["POST"]),
        Route("/jog", jogging.rigs),
        Route("/jog/{rig}", jogging.page),
        WebSocketRoute("/jog/{rig}", jogging.socket),
        Route("/api/v1/jog/{rig}/stop", jogging.stop, methods=["POST"]),
        Route("/metrics", pages.metrics),
        Route("/healthz", pages.healthz),
        Route("/enter", entrance.enter),
        Route("/login", entrance.login, methods=["GET", "POST"]),
        Route("/leave", entrance.leave, methods=["POST"]),
        Route("/code", entrance.code, methods=["POST"]),
        WebSocketRoute("/live/{name}", pages.live),
        Mount("/static", StaticFiles(directory=HERE / "static")),
    ]
    handlers = {
        HTTPException: pages.refused,
        ProcedureError: pages.failed,
        ArchiveError: pages.failed,
        OSError: pages.withheld,
    }
    return Gate(Starlette(routes=routes, exception_handlers=handlers), console.sessions, console.site)


class _Pages:
    """One method a route."""

    def __init__(self, console: Console, templates: Pages) -> None:
        self._console = console
        self._templates = templates

    async def home(self, request: Request) -> Response:
        name = await run_sync(self._console.first)
        if name is None:
            folder, listed = str(self._console.runs.folder), await run_sync(self._console.listed)
            return self._shown(request, "empty.html.j2", here="run", folder=folder, unread=listed[:MOST_NAMED])
        return await self._run_page(request, name)

    async def run(self, request: Request) -> Response:
        return await self._run_page(request, request.path_params["name"])

    async def _run_page(self, request: Request, name: str) -> Response:
        page = await run_sync(self._console.page, name)
        listed = await run_sync(self._console.listed)
        others = [run for run in listed if run.path.name != name]
        return self._shown(
            request,
            "run.html.j2",
            here="run",
            damaged=next((damage_words(run) for run in listed if run.path.name == name and run.damaged), ""),
            others=[run for run in others if not run.trouble][:MOST_NAMED],
            unread=[run for run in others if run.trouble][:MOST_NAMED],
            **await self._banner_of(page),
            key=new_key(),
        )

    async def _banner_of(self, page: RunPage) -> dict[str, Any]:
        """Return what the banner of a run is made from."""
        return {
            "page": page,
            "waits": needs_a_person(page),
            "item": await run_sync(self._item_of, page),
            "verdict": await self._verdict(page),
        }

    async def _verdict(self, page: RunPage) -> Mapping[str, object] | None:
        """Return what a run came to; of one whose set was withdrawn since, that, or that nobody knows."""
        if not page.verdict:
            return page.verdict
        url = self._console.archive_url
        try:
            gone = await self._console.of_archive(partial(withdrawn_sentence, url, page.run_id), BESIDE_S)
        except ArchiveError as error:
            known = f"{page.verdict.get('sentence', '')} Whether its set was withdrawn since is not known: {error}."
            return {**page.verdict, "sentence": known}
        return {**page.verdict, "sentence": gone, "trust": "unusable"} if gone else page.verdict

    def _item_of(self, page: RunPage) -> int | None:
        """Return the number of the queue's item that waits for what becomes of this run; None where none does."""
        if page.is_alive:
            return None
        items = undecided_items(self._console.queues, self._console.clock)
        return items.get((self._console.runs.folder / page.run_id).resolve())

    async def report(self, request: Request) -> Response:
        watched = await run_sync(self._console.watched, request.path_params["name"])
        file = watched.folder / "report.html"
        if not file.is_file() or file.is_symlink():
            raise HTTPException(404, "this run has no report")
        return FileResponse(file, media_type="text/html", headers={"content-security-policy": REPORT_POLICY})

    async def night(self, request: Request) -> Response:
        console = self._console
        listed = await run_sync(console.listed)
        items = await run_sync(undecided_items, console.queues, console.clock)
        now_utc = console.clock.now_utc()
        try:
            known = await console.of_archive(partial(archived, listed, console.archive_url, now_utc), ARCHIVE_S)
        except ArchiveError as error:
            known = Archived((), str(error), {})
        summary = await run_sync(night, listed, known, now_utc, items)
        return self._shown(request, "night.html.j2", here="night", night=summary, today=local_day(now_utc))

    async def archive(self, request: Request) -> Response:
        words, standard = request.query_params.get("q", ""), request.query_params.get("standard")
        url, absent = self._console.archive_url, False
        try:
            found, sets, due = await self._console.of_archive(
                partial(_of_the_archive, url, words.split(), standard), ARCHIVE_S
            )
        except ArchiveAbsent:  # as on every new bench: the first finished run makes it
            found, sets, due, absent = (), (), (), True
        sensors = {coefficients.sensor: coefficients for coefficients in sets}
        return self._shown(
            request, "archive.html.j2", here="archive", absent=absent, words=words, standard=standard,
            found=found[:MOST_LISTED], count=len(found), sensors=sensors, due=due, every_days=SENSOR_EVERY_DAYS,
            today=local_day(self._console.clock.now_utc()), archive=without_password(url),
        )  # fmt: skip

    async def sensor(self, request: Request) -> Response:
        sensor = request.path_params["sensor"]
        try:
            url = self._console.archive_url
            sets = await self._console.of_archive(partial(list_sets, url, sensor), ARCHIVE_S)
        except ArchiveAbsent:
            sets = ()
        if not sets:
            raise HTTPException(404, "the archive holds no such sensor")
        return self._shown(request, "sensor.html.j2", here="archive", sensor=sensor, sets=list(reversed(sets)))

    async def api_runs(self, request: Request) -> Response:
        listed = await run_sync(self._console.listed)
        return JSONResponse({"runs": [run.to_document() for run in listed]})

    async def api_run(self, request: Request) -> Response:
        page = await run_sync(self._console.page, request.path_params["name"])
        document = {**page.status.to_document(), "run": page.run_id, "alive": page.is_alive}
        document["state_sequence"] = page.status.state_sequence
        return JSONResponse(document | {"rows": dict(page.rows), "verdict": await self._verdict(page)})

    async def api_map(self, request: Request) -> Response:
        watched = await run_sync(self._console.watched, request.path_params["name"])
        picture = await run_sync(watched.picture)
        return JSONResponse(None if picture is None else picture.to_document())

    async def metrics(self, request: Request) -> Response:
        return PlainTextResponse(await run_sync(self._metrics), media_type="text/plain; version=0.0.4")

    def _metrics(self) -> str:
        return metrics_text(figures_of(self._console.listed()))

    async def healthz(self, request: Request) -> Response:
        return PlainTextResponse("ok\n")

    async def live(self, socket: WebSocket) -> None:
        console, live_page = self._console, None
        try:
            visitor = console.visitor(socket)
            await socket.accept()
            if (live_page := console.live_pages.take(visitor.token)) is None:
                await socket.close(PUT_ASIDE, ALL_TAKEN)
            else:
                await self._tell(socket, socket.path_params["name"], live_page)
        except (WebSocketDisconnect, RuntimeError):  # the browser went away, also in the middle of a sending
            pass
        except (HTTPException, ProcedureError, OSError):
            with suppress(RuntimeError):
                await socket.close(1011)
        finally:
            if live_page is not None:
                console.live_pages.give_back(live_page)

    async def _tell(self, socket: WebSocket, name: str, live_page: LivePage) -> None:
        """Send the changing parts of the page whenever they are others, and a sign of life between."""
        version, offered, sent_s = "", "", 0.0
        token = token_of(socket.headers, self._console.site)
        gone = asyncio.ensure_future(_gone(socket))
        try:
            while (
                not (gone.done() or live_page.leaves) and (visitor := self._console.sessions.visitor(token)) is not None
            ):
                page, now_s = await run_sync(self._console.page, name), self._console.clock.monotonic_s()
                if page.version != version:
                    banner = self._templates.html("banner.html.j2", **await self._banner_of(page))
                    html = self._templates.html("standing.html.j2", page=page)
                    news = {"banner": banner, "html": html, "done": page.status.dwells_done}
                    if (now_offered := _offered(page, visitor)) != offered:
                        news["acts"] = self._templates.html("acts.html.j2", page=page, visitor=visitor, key=new_key())
                        offered = now_offered
                    await socket.send_text(json.dumps(news))
                    version, sent_s = page.version, now_s
                elif now_s - sent_s >= ALIVE_EVERY_S:
                    await socket.send_text("{}")
                    sent_s = now_s
                await asyncio.wait([gone], timeout=LOOK_S)
            if live_page.leaves:
                await socket.close(PUT_ASIDE, ALL_TAKEN)
            elif not gone.done():
                await socket.close(1008)
        finally:
            gone.cancel()

    async def refused(self, request: Request, error: Exception) -> Response:
        assert isinstance(error, HTTPException)
        return self._failed(request, error.status_code, error.detail)

    async def withheld(self, request: Request, error: Exception) -> Response:
        assert isinstance(error, OSError)
        return self._failed(request, 500, withheld_sentence(error))

    async def failed(self, request: Request, error: Exception) -> Response:
        return self._failed(request, 500, str(error))

    def _failed(self, request: Request, status_code: int, message: str) -> Response:
        if request.method == "POST" and "text/html" not in request.headers.get("accept", ""):
            return JSONResponse({"done": False, "told": message}, status_code)
        return self._shown(request, "error.html.j2", status_code, message=message)

    def _shown(self, request: Request, template: str, status_code: int = 200, **values: object) -> Response:
        visitor = self._console.sessions.visitor(token_of(request.headers, self._console.site))
        return self._templates.shown(template, status_code, visitor=visitor, **values)


def _of_the_archive(
    url: str, words: list[str], standard: str | None
) -> tuple[Sequence[FoundRun], Sequence[ArchivedSet], Sequence[Due]]:
    """Return what the page of the archive shows."""
    return search_runs(url, words, standard), list_sets(url), due_list(url)


def _offered(page: RunPage, visitor: Visitor) -> str:
    """Return what another set of buttons would differ in."""
    return f"{page.status.state_sequence} {page.status.state} {page.is_alive} {visitor.role}"


async def _gone(socket: WebSocket) -> None:
    """Return when the browser leaves, or says anything: there is nothing to be said."""
    with suppress(WebSocketDisconnect, RuntimeError):
        await socket.receive()
