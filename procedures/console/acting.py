"""What is posted: read, allowed or refused, done once in a thread of its own, and answered to a page or a program."""

import secrets
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from anyio.to_thread import run_sync
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from procedures.console.acts import ACCEPTED, ON_RUNS, WRONG, Action, Answer, perform, read_act
from procedures.console.gate import read_fields, require_token
from procedures.console.rights import BEGINS_MOTION, LETS_MOVE, STOPS, Act, refusal
from procedures.console.shared import Console
from procedures.console.templates_of import Pages
from procedures.errors import RequestError
from procedures.queue.hands import ABORT, REMOUNTED, STOP, TAKEN_BACK, disarm_by_stop_of_run
from rig.description.rig_file import RigDescription

FORBIDDEN, TOO_MANY = 403, 429


class Acting:
    """One method a route."""

    def __init__(self, console: Console, pages: Pages) -> None:
        self._console = console
        self._pages = pages

    async def on_run(self, request: Request) -> Response:
        """Pause, continue, stop, abort, note, ack, void or redo."""
        act = next((known for known in ON_RUNS if known == request.path_params["act"]), None)
        if act is None:
            raise HTTPException(404, f"allowed on a run are {', '.join(ON_RUNS)}")
        folder = self._console.folder_of(request.path_params["name"])

        def rig(_action: Action) -> RigDescription:
            return self._console.rig_of(folder)

        return await self.answer(request, act, rig, partial(self._perform, folder), f"/run/{folder.name}")

    def _perform(self, folder: Path, action: Action) -> Answer:
        queues: list[str] = []
        if action.act in LETS_MOVE and not action.may_arm:  # before it: an armed queue may be about to resume the run
            queues = disarm_by_stop_of_run(self._console.queues, folder, TAKEN_BACK, self._console.clock)
        answer = perform(folder, action, self._console.clock, self._console.archive_url)
        remounting = {"void": REMOUNTED, "redo": REMOUNTED} if action.is_remounted else {}
        what = {"abort": ABORT, "stop": STOP, **remounting}.get(action.act)
        if answer.status == ACCEPTED and what is not None:
            queues += disarm_by_stop_of_run(self._console.queues, folder, what, self._console.clock)
        return Answer(answer.status, "; ".join((answer.message, *queues)))

    async def answer(
        self,
        request: Request,
        act: Act,
        rig: Callable[[Action], RigDescription | None],
        do: Callable[[Action], Answer],
        back: str,
        at_once: Callable[[Action], object] = id,
    ) -> Response:
        """Do an act for whoever may; the same act by the same key is answered as before. Raises: HTTPException.

        ``rig``: what allows it from elsewhere; None where nothing does. ``at_once`` is done before it, in this thread,
        also for a key that came before.
        """
        console, visitor = self._console, self._console.visitor(request)
        fields = await read_fields(request)
        require_token(request, fields, visitor)
        address = request.client.host if request.client else ""
        try:
            action = read_act(act, fields, visitor.name, address)
        except RequestError as error:
            return self._reply(request, Answer(WRONG, str(error)), back)
        slot, is_stop = (visitor.token, request.url.path, action.key), act in STOPS
        if not console.will_repeat(slot, is_stop=is_stop):
            is_elsewhere = console.site.is_elsewhere(request.scope)
            begins = act in (*BEGINS_MOTION, *LETS_MOVE)
            known_rig = await run_sync(rig, action) if is_elsewhere and begins else None
            if forbidden := refusal(act, visitor, known_rig, is_elsewhere=is_elsewhere):
                return self._reply(request, Answer(FORBIDDEN, forbidden), back)
            if not is_stop and not console.sessions.counts_act(visitor):
                return self._reply(request, Answer(TOO_MANY, "too many acts within a minute; nothing was done"), back)
            action = replace(action, may_arm=not refusal("arm", visitor, known_rig, is_elsewhere=is_elsewhere))
        at_once(action)
        return self._reply(request, await console.once(slot, partial(do, action), is_stop=is_stop), back)

    def _reply(self, request: Request, answer: Answer, back: str) -> Response:
        if "text/html" in request.headers.get("accept", ""):
            visitor = self._console.visitor(request)
            return self._pages.shown(
                "message.html.j2", answer.status, message=answer.message, back=back, visitor=visitor
            )
        return JSONResponse({"done": answer.status == ACCEPTED, "told": answer.message}, answer.status)


def new_key() -> str:
    """Return what makes an act of a page one act."""
    return secrets.token_hex(8)
