"""What stands before every page: whose request it is, from which page it comes, and what a browser may do with it.

A request is let through where its ``Host`` is this console's own (a name that was bent to this machine is not), it
does not come out of another site's page, and it has a session. What is more than reading says from which page it comes
and carries the token of its session, which no page of another site knows. No address is trusted.
"""

import asyncio
import json
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from ipaddress import ip_address
from urllib.parse import parse_qsl

from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from procedures.console.sessions import Sessions, Visitor

COOKIE = "calrig"
OPEN = ("/enter", "/login", "/healthz", "/static/console.css")
"""Answered without a session: the ways in, what they look like, and whether the console lives."""
KNOWN = "calrig.known"
"""In the scope of a request that has a session, its token: whose connections keep their places."""
LONGEST_TARGET = 2048
LONGEST_BODY = 16_384
BODY_S = 5.0
FORM = "application/x-www-form-urlencoded"
MOST_FIELDS = 20
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "form-action 'self'; base-uri 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "content-security-policy": POLICY,
    "x-frame-options": "DENY",
    "x-content-type-options": "nosniff",
    "referrer-policy": "same-origin",  # with no-referrer a form of our own would come from "null"
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}
NO_ENTRY = "calrig console: no session; open the link that `calrig console` printed, each works once, or /login\n"


@dataclass(frozen=True)
class Site:
    """By which names the console is reached, and how."""

    hosts: frozenset[str]
    """What stands in ``Host`` of a request to this console."""
    scheme: str = "http"
    is_proxied: bool = False
    """A proxy stands before it: then whoever asks is elsewhere."""

    @property
    def is_secret(self) -> bool:
        """Whether nobody on the way can read it: then cookies go no other way."""
        return self.scheme == "https"

    def cookie(self) -> str:
        """Return the cookie's name; with ``__Host-`` a browser takes it from this very host alone."""
        return f"__Host-{COOKIE}" if self.is_secret else COOKIE

    def is_elsewhere(self, scope: Scope) -> bool:
        """Return whether the browser is on another machine, as far as anybody can tell."""
        host = (scope.get("client") or ("",))[0]
        try:
            return self.is_proxied or not ip_address(host).is_loopback
        except ValueError:
            return True


class Gate:
    """ASGI, around the application."""

    def __init__(self, app: ASGIApp, sessions: Sessions, site: Site) -> None:
        self._app = app
        self._sessions = sessions
        self._site = site

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        refusal = self._refusal(scope)
        if scope["type"] == "websocket":
            if refusal is not None:
                await send({"type": "websocket.close", "code": 1008})  # before it is accepted: the answer is 403
                return
            await self._app(scope, receive, send)
            return
        guarded = _with_headers(send)
        if refusal is not None:
            await refusal(scope, receive, guarded)
        else:
            await self._app(scope, receive, guarded)

    def _refusal(self, scope: Scope) -> Response | None:
        # The name first: what was bent to this machine is of its own site to a browser, and passes all that follows.
        headers = Headers(scope=scope)
        is_socket = scope["type"] == "websocket"
        is_act = not is_socket and scope["method"] == "POST"
        if headers.getlist("host") not in [[host] for host in self._site.hosts]:
            return PlainTextResponse("calrig console: it is not reached by this name\n", 421)
        if not is_socket and scope["method"] not in ("GET", "HEAD", "POST"):
            return PlainTextResponse("calrig console: pages are read, and acts are posted\n", 405)
        if len(scope["raw_path"]) + len(scope["query_string"]) > LONGEST_TARGET:
            return PlainTextResponse("calrig console: the address is too long\n", 414)
        origins = headers.getlist("origin")
        same_origin = [[f"{self._site.scheme}://{headers['host']}"]]
        if ((is_socket or is_act) and origins not in same_origin) or (origins and origins not in same_origin):
            return PlainTextResponse("calrig console: asked by a page of another site\n", 403)
        is_open = scope["path"] in OPEN and not is_socket
        # A link that is followed from a mail is cross-site to a browser: the ways in stand before that is looked at.
        if is_open and not is_act:
            return None
        if headers.get("sec-fetch-site", "none") not in ("none", "same-origin"):
            return PlainTextResponse("calrig console: asked by a page of another site\n", 403)
        if (visitor := self._sessions.visitor(token_of(headers, self._site))) is not None:
            scope[KNOWN] = visitor.token
            return None
        if is_open:
            return None
        if not is_socket and not is_act and "text/html" in headers.get("accept", ""):
            return RedirectResponse("/login", 303)
        return PlainTextResponse(NO_ENTRY, 401)


def token_of(headers: Headers, site: Site) -> str | None:
    """Return what the browser was given when it entered."""
    try:
        cookie = SimpleCookie(headers.get("cookie", ""))
    except CookieError:
        return None
    return cookie[site.cookie()].value if site.cookie() in cookie else None


async def read_fields(request: Request) -> Mapping[str, str]:
    """Return the fields of a form or of a flat JSON object. Raises: HTTPException for too much, too slow or neither."""
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind not in (FORM, "application/json"):
        raise HTTPException(415, f"an act is sent as {FORM} or application/json")
    body = b""
    try:
        async with asyncio.timeout(BODY_S):
            async for part in request.stream():
                body += part
                if len(body) > LONGEST_BODY:
                    raise HTTPException(413, f"an act is at most {LONGEST_BODY} bytes long")
    except TimeoutError:
        raise HTTPException(408, "the act came too slowly; nothing was done") from None
    try:
        if kind == FORM:
            return dict(parse_qsl(body.decode("utf-8"), strict_parsing=bool(body), max_num_fields=MOST_FIELDS))
        return {str(name): _as_text(value) for name, value in dict(json.loads(body)).items()}
    except (ValueError, TypeError, RecursionError):
        raise HTTPException(400, "the act cannot be read; nothing was done") from None


def _as_text(value: object) -> str:
    """Return a value of JSON as a form would send it. Raises: ValueError for what no form sends."""
    if value is None or value is False:
        return ""
    if isinstance(value, (str, int)):
        return "1" if value is True else str(value)
    raise ValueError("not a text, a number or a truth")


def require_token(request: Request, fields: Mapping[str, str], visitor: Visitor) -> None:
    """Refuse an act without the token of its session. Raises: HTTPException."""
    given = request.headers.get("x-csrf-token") or fields.get("csrf", "")
    if not secrets.compare_digest(given.encode("utf-8", errors="surrogateescape"), visitor.csrf.encode()):
        raise HTTPException(403, "the act does not carry the token of its page; nothing was done; load the page again")


def _with_headers(send: Send) -> Send:
    async def guarded(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in HEADERS.items():
                headers.setdefault(name, value)
        await send(message)

    return guarded
