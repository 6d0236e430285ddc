"""A rig on simulated ports whose roll turns, a console beside it, and pages of it that a test drives word by word."""

import json
import socket
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from http.cookies import SimpleCookie
from pathlib import Path
from urllib.error import HTTPError
from urllib.parse import urlencode
from urllib.request import HTTPRedirectHandler, Request, build_opener, urlopen

from consoles import ServedConsole, served_console
from turning_rig import QUICK_METER, STAGE_FOR_ROLL, served
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin

from rig.assembly.simulate import SimulatedRig
from rig.clock import SystemClock

CLOCK = SystemClock()
WITHIN_S = 30.0
HOMED, STANDS = "roll: homed", "every axis stands still"
RIG = "rig.toml"


@dataclass
class JogBench:
    """The console over the rig, and the bodies that really turn."""

    console: ServedConsole
    simulated: SimulatedRig
    files: Path

    def rate_dps(self) -> float:
        return self.simulated.world.axes["roll"].rate_dps(CLOCK.monotonic_s())

    def late_s(self, since_s: float) -> float:
        """Wait until roll stands; how long after that moment it came to stand."""
        until_s = CLOCK.monotonic_s() + WITHIN_S
        while self.rate_dps() != 0.0:
            assert CLOCK.monotonic_s() < until_s, "it turns on"
            CLOCK.sleep(0.005)
        return self.simulated.world.axes["roll"].still_from_s - since_s

    def until_turning(self) -> None:
        until_s = CLOCK.monotonic_s() + WITHIN_S
        while self.rate_dps() == 0.0:
            assert CLOCK.monotonic_s() < until_s, "it does not turn"
            CLOCK.sleep(0.005)

    def log(self) -> list[dict[str, object]]:
        text = (self.files / "rig.jog.jsonl").read_text(encoding="utf-8")
        return [json.loads(line) for line in text.splitlines()]


@contextmanager
def jog_bench(folder: Path, extra: str = "") -> Iterator[JogBench]:
    files = folder / "files"
    for location in (files, folder / "runs", folder / "ports"):
        location.mkdir()
    with served(folder / "ports", CLOCK, QUICK_METER, STAGE_FOR_ROLL) as (simulated, path):
        (files / RIG).write_text(path.read_text(encoding="utf-8") + extra, encoding="utf-8")
        with served_console(folder / "runs", folder / "none.sqlite", files) as console:
            yield JogBench(console, simulated, files)


@dataclass
class WordPage:
    """A page without a browser: it answers every tick until it is told otherwise."""

    line: ClientConnection
    wire: socket.socket
    base: str
    cookie: str
    csrf: str
    seen: dict[str, object] = field(default_factory=dict)
    messages: list[str] = field(default_factory=list)
    press: int = 0
    held: dict[str, object] | None = None
    answers: bool = True

    def say(self, **order: object) -> None:
        self.line.send(json.dumps(order))

    def beat(self) -> None:
        self.say(say="beat", tick=self.seen.get("tick", 0), press=self.press, held=self.held)

    def hold(self, rate_dps: float) -> None:
        self.press += 1
        self.held = {"axis": "roll", "rate_dps": rate_dps}
        self.beat()

    def release(self) -> None:
        self.held = None
        self.beat()

    def listen(self) -> None:
        try:
            for text in self.line:
                news = json.loads(text)
                self.seen |= news
                self.messages += [str(news[key]) for key in ("told", "closed") if key in news]
                if self.answers and "tick" in news and self.has_bench():
                    self.beat()
        except (ConnectionClosed, OSError):
            return

    def has_bench(self) -> bool:
        holder = self.seen.get("holder")
        return isinstance(holder, dict) and holder.get("client") == self.seen.get("you")

    def until(self, words: str) -> None:
        """Wait until something was told."""
        until_s = CLOCK.monotonic_s() + WITHIN_S
        while words not in (text := self._heard()):
            assert CLOCK.monotonic_s() < until_s, text
            CLOCK.sleep(0.01)

    def _heard(self) -> str:
        return f"{self.messages} {self.seen.get('messages')}"

    def take(self) -> None:
        self.say(say="take")
        until_s = CLOCK.monotonic_s() + WITHIN_S
        while not self.has_bench():
            assert CLOCK.monotonic_s() < until_s, self.messages
            CLOCK.sleep(0.01)

    def home(self) -> None:
        """Home roll; again where a machine without a processor for this page stopped it, and it stands still."""
        until_s = CLOCK.monotonic_s() + WITHIN_S
        while HOMED not in self._heard():
            stops = self._heard().count(STANDS)
            self.say(say="do", act="home", axis="roll", tick=self.seen["tick"])
            while HOMED not in (text := self._heard()) and text.count(STANDS) <= stops:
                assert CLOCK.monotonic_s() < until_s, text
                CLOCK.sleep(0.01)


class _Staying(HTTPRedirectHandler):
    def redirect_request(self, *_: object) -> None:  # type: ignore[override]
        return None


def _entered(console: ServedConsole, account: tuple[str, str] | None) -> str:
    """Return the cookie of a new session: by the link, or by name and secret."""
    if account is None:
        with urlopen(console.link()) as answer:
            return _cookie(answer.headers["set-cookie"])
    base = console.address
    form = urlencode({"name": account[0], "secret": account[1]}).encode()
    try:
        build_opener(_Staying).open(Request(f"{base}/login", form, {"origin": base}))
    except HTTPError as moved:  # to the first page
        return _cookie(moved.headers["set-cookie"])
    raise AssertionError("the secret was not taken")


def _cookie(form: str) -> str:
    return f"calrig={SimpleCookie(form)['calrig'].value}"


@contextmanager
def word_page(
    bench: JogBench,
    via: tuple[str, int] | None = None,
    *,
    console: ServedConsole | None = None,
    account: tuple[str, str] | None = None,
) -> Iterator[WordPage]:
    """A session of its own; ``via`` is another address by which the console is reached."""
    console = console or bench.console
    base, cookie = console.address, _entered(console, account)
    with urlopen(Request(f"{base}/jog/{RIG}", headers={"cookie": cookie})) as answer:
        csrf = answer.read().decode().partition('name="csrf" value="')[2].partition('"')[0]
    host, _, port = base[7:].partition(":")
    with ExitStack() as stack:
        wire = stack.enter_context(socket.create_connection(via or (host, int(port))))
        where, headers = f"ws://{host}:{port}/jog/{RIG}", {"cookie": cookie}
        line = stack.enter_context(
            connect(where, sock=wire, origin=Origin(base), additional_headers=headers, ping_interval=None)
        )
        page = WordPage(line, wire, base, cookie, csrf)
        page.say(csrf=csrf)
        thread = threading.Thread(target=page.listen, daemon=True)
        thread.start()
        try:
            yield page
        finally:
            line.close()
            thread.join()
