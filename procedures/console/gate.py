"""What stands before every page: whose request it is, from which page it comes, and what a browser may do with it.

A request is let through where its ``Host`` is this console's own (a name that was bent to this machine is not), it
does not come out of another site's page, it only reads, and it has a session. No address is trusted.
"""

from http.cookies import CookieError, SimpleCookie

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from procedures.console.sessions import Sessions

COOKIE = "calrig"
OPEN = ("/enter", "/healthz")
"""Answered without a session: the way in, and whether the console lives."""
LONGEST_TARGET = 2048
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "form-action 'self'; base-uri 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "content-security-policy": POLICY,
    "x-frame-options": "DENY",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}
NO_ENTRY = "calrig console: no session; open the link that `calrig console` printed, each works once\n"


class Gate:
    """ASGI, around the application."""

    def __init__(self, app: ASGIApp, sessions: Sessions, hosts: frozenset[str]) -> None:
        """``hosts``: what stands in ``Host`` of a request to this console."""
        self._app = app
        self._sessions = sessions
        self._hosts = hosts

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
        headers = Headers(scope=scope)
        is_socket = scope["type"] == "websocket"
        if headers.getlist("host") not in [[host] for host in self._hosts]:
            return PlainTextResponse("calrig console: it is not reached by this name\n", 421)
        if not is_socket and scope["method"] not in ("GET", "HEAD"):
            return PlainTextResponse("calrig console: nothing is steered here\n", 405, {"allow": "GET, HEAD"})
        if len(scope["raw_path"]) + len(scope["query_string"]) > LONGEST_TARGET:
            return PlainTextResponse("calrig console: the address is too long\n", 414)
        origins = headers.getlist("origin")
        own = [[f"http://{headers['host']}"]]
        if (is_socket and origins not in own) or (origins and origins not in own):
            return PlainTextResponse("calrig console: asked by a page of another site\n", 403)
        if scope["path"] in OPEN and not is_socket:
            return None
        if headers.get("sec-fetch-site", "none") not in ("none", "same-origin"):
            return PlainTextResponse("calrig console: asked by a page of another site\n", 403)
        return None if self._sessions.knows(token_of(headers)) else PlainTextResponse(NO_ENTRY, 401)


def token_of(headers: Headers) -> str | None:
    """Return what the browser was given when it entered."""
    try:
        cookie = SimpleCookie(headers.get("cookie", ""))
    except CookieError:
        return None
    return cookie[COOKIE].value if COOKIE in cookie else None


def _with_headers(send: Send) -> Send:
    async def guarded(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in HEADERS.items():
                headers.setdefault(name, value)
        await send(message)

    return guarded
