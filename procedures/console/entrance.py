"""The ways in and out: the link that the terminal told, a name with its secret, the code at the rig."""

from anyio.to_thread import run_sync
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import PlainTextResponse, RedirectResponse, Response

from procedures.console.gate import read_fields, require_token, token_of
from procedures.console.sessions import LIFE_S, LOCKED_S, MOST_WRONG
from procedures.console.shared import Console
from procedures.console.templates_of import Pages
from procedures.errors import RequestError

WRONG = "name or secret is wrong, or too many were tried: then wait a minute"
NO_LINK = "calrig console: this link was used, or is none; the terminal has the next\n"
LOCKED = (
    f"calrig console: {MOST_WRONG} wrong links were tried, so that no link is looked at for {LOCKED_S:.0f} s; nobody "
    "was let in, and no link was used up; open the one that the terminal told last once more then\n"
)
OF_HERE = ("none", "same-origin")
"""As a browser says it of what a person typed or opened. A link in a mail is of another site, and so is what any page
fetches that is open in it: that enters where it is right, and locks nobody out where it is wrong."""


class Entrance:
    """One method a route."""

    def __init__(self, console: Console, pages: Pages) -> None:
        self._console = console
        self._pages = pages

    async def enter(self, request: Request) -> Response:
        before = token_of(request.headers, self._console.site)
        counts = request.headers.get("sec-fetch-site", "none") in OF_HERE
        token = self._console.sessions.enter(request.query_params.get("key", ""), before, counts=counts)
        if token is None:
            return PlainTextResponse(LOCKED if self._console.sessions.is_link_locked() else NO_LINK, 403)
        self._console.entered.set()
        return self._let_in(self._pages.shown("entered.html.j2"), token)

    async def login(self, request: Request) -> Response:
        """Show the form, or look at what it was filled in with."""
        if request.method != "POST":
            return self._pages.shown("login.html.j2", message="")
        fields, sessions = await read_fields(request), self._console.sessions
        name, secret = fields.get("name", "")[:200], fields.get("secret", "")[:200]
        async with self._console.logging_in:
            person = None
            if not sessions.is_locked(name):
                person = await run_sync(sessions.people.identify, name, secret)
                try:
                    token = sessions.log_in(name, person, token_of(request.headers, self._console.site))
                except RequestError as error:
                    return self._pages.shown("login.html.j2", 503, message=str(error))
        if person is None or token is None:
            return self._pages.shown("login.html.j2", 403, message=WRONG)
        return self._let_in(RedirectResponse("/", 303), token)

    async def leave(self, request: Request) -> Response:
        visitor = self._console.visitor(request)
        require_token(request, await read_fields(request), visitor)
        self._console.sessions.end(token_of(request.headers, self._console.site))
        response = RedirectResponse("/login", 303)
        response.delete_cookie(self._console.site.cookie())
        return response

    async def code(self, request: Request) -> Response:
        """Take the code that stands at the rig: from then on this session may begin motion from where it is."""
        visitor = self._console.visitor(request)
        fields = await read_fields(request)
        require_token(request, fields, visitor)
        token = token_of(request.headers, self._console.site)
        if not self._console.sessions.tell_code(token, fields.get("code", "")[:40]):
            raise HTTPException(403, "that is not the code, or too many were tried: then wait a minute")
        self._console.entered.set()
        return self._pages.shown(
            "message.html.j2", message="this browser may begin motion until its session ends", back="/"
        )

    def _let_in(self, response: Response, token: str) -> Response:
        site = self._console.site
        response.set_cookie(
            site.cookie(), token, max_age=int(LIFE_S), httponly=True, samesite="strict", secure=site.is_secret
        )
        return response
