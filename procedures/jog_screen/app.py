"""The jog screen: keys become requests to the bench, its view becomes text. No device is ever waited for here.

The space bar stops every axis at any time, also while a number is being typed. A rate lives under a lease: this screen
asks its terminal for the cursor ten times a second, and only the terminal's own answer (or, for a held key, the key as
well) renews it. So a frozen screen, a hung line and a closed window all end it.
"""

import asyncio
import select
import signal
import sys
from collections.abc import Callable
from types import FrameType
from typing import ClassVar

from textual import events
from textual.app import App, ComposeResult
from textual.binding import Binding
from textual.containers import Vertical
from textual.widgets import Static

from procedures.jog_screen import panels
from procedures.jog_screen.heading import Heading
from procedures.jog_screen.prompts import Prompt, prompt_for
from procedures.jog_screen.values import AxisView, ClearStatistics, GoTo, Home, Snapshot
from procedures.jog_screen.worker import Bench
from rig.motion.jog_steps import nearest_step_deg
from rig.system_parts import ENDS, present

DRAW_S = 0.1
STOPS = ("space", "ctrl+c")
_PARTS = ("head", "axes", "channels", "around", "messages", "prompt", "keys")
ASK_TERMINAL = "\x1b[6n"
"""Device status report: where is the cursor? Every terminal answers it."""
KEYS = (
    ("←→", "step"),
    ("⇧←→", "turn"),
    ("↑↓", "axis"),
    ("− +", "step size"),
    ("g", "go to"),
    ("h", "home"),
    ("q", "quit"),
    ("r", "rate"),
    ("p", "pulse"),
    ("c", "chamber"),
    ("tab", "sensor"),
    (", .", "page"),
    ("n", "clear"),
    ("s", "snapshot"),
)


class JogApp(App[None]):
    """``bench`` is started by the screen and closed by whoever made it."""

    ENABLE_COMMAND_PALETTE = False
    CSS = """
    Screen { background: #10151a; color: #d8dee6; }
    #head { height: 2; padding: 0 1; background: #182028; }
    .panel { border: round #2c3844; border-title-color: #5fd7d7; padding: 0 1; height: auto; }
    #messages { border-subtitle-color: #9aa5b1; }
    #messages { height: 1fr; min-height: 3; }
    #around.left-out { display: none; }
    #foot { dock: bottom; height: auto; }
    #prompt { display: none; height: 3; padding: 0 1; border: round #ffd75f; border-title-color: #ffd75f; }
    #prompt.asked { display: block; }
    #keys { height: auto; padding: 0 1; background: #182028; }
    """
    BINDINGS: ClassVar = [
        Binding("escape", "leave_prompt", priority=True),
        Binding("tab", "watch_next", priority=True),
    ]

    def __init__(self, bench: Bench, heading: Heading) -> None:
        super().__init__()
        self.bench = bench
        self.selected = bench.view.axes[0].name
        self.step_deg = nearest_step_deg(bench.view.axes[0].steps_deg, 1.0)
        self.held_rate_dps = 1.0
        self._heading = heading
        self._prompt: Prompt | None = None
        self._typed = ""
        self._watched = ""
        """The sensor whose readings are shown; empty for all."""
        self._page = 0
        self._stopped_at = 0.0
        self._drawn: tuple[object, ...] = ()
        self._commands: dict[str, Callable[[], object]] = {
            "left": lambda: self._step(-1),
            "right": lambda: self._step(1),
            "shift+left": lambda: self._turn(-1),
            "shift+right": lambda: self._turn(1),
            "up": lambda: self._select(-1),
            "down": lambda: self._select(1),
            "-": lambda: self._resize_step(-1),
            "+": lambda: self._resize_step(1),
            "=": lambda: self._resize_step(1),
            "g": lambda: self._ask("goto"),
            "r": lambda: self._ask("rate"),
            "p": lambda: self._ask("pulse"),
            "c": lambda: self._ask("chamber"),
            ",": lambda: self._turn_page(-1),
            ".": lambda: self._turn_page(1),
            "h": lambda: bench.ask(Home(self.selected)),
            "n": lambda: bench.ask(ClearStatistics()),
            "s": lambda: bench.ask(Snapshot()),
            "q": self.exit,  # whoever closes the bench stops every axis first
        }
        self._loop_of_screen: asyncio.AbstractEventLoop | None = None

    def compose(self) -> ComposeResult:
        yield Static(id="head")
        for name, title in (
            ("axes", "axes"),
            ("channels", "readings"),
            ("around", "surroundings"),
            ("messages", "log"),
        ):
            panel = Static(id=name, classes="panel")
            panel.border_title = title
            yield panel
        with Vertical(id="foot"):
            yield Static(id="prompt")
            yield Static(id="keys")

    def on_mount(self) -> None:
        self._loop_of_screen = asyncio.get_running_loop()
        self.bench.start()
        self.set_interval(DRAW_S, self._beat)
        self.query_one("#messages", Static).border_subtitle = self._heading.log
        self._draw()

    # Losing the operator.

    def heed_signals(self) -> None:
        """Stop every axis on a lost terminal (HUP) or a request to end, and refuse to be suspended.

        A suspended process could not stop anything.
        """
        for number in ENDS:
            signal.signal(number, self._lost)
        for number in present("SIGTSTP", "SIGTTIN", "SIGTTOU"):
            signal.signal(number, signal.SIG_IGN)

    def _lost(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002  the signature of a handler
        self.bench.guard.lose(f"{signal.Signals(number).name}: the operator is gone")
        if self._loop_of_screen is not None and not self._loop_of_screen.is_closed():  # it is behind the screen
            self._loop_of_screen.call_soon_threadsafe(self.exit)

    def _beat(self) -> None:
        if is_hung_up():
            self.bench.guard.lose("the terminal is gone")
            self.exit()
        if self._driver is not None and self.bench.guard.has_leases:
            self._driver.write(ASK_TERMINAL)
        self._draw()

    def on_cursor_position(self, event: events.CursorPosition) -> None:  # noqa: ARG002  that it came is the answer
        self.bench.guard.answer()

    # Keys. None goes to a field that might not have the focus yet: a digit is a digit of the number that was asked for.

    async def on_event(self, event: events.Event) -> None:
        """Let a key that stops overtake every key before it, which then count for nothing: they wait in queues."""
        if isinstance(event, events.Key) and event.key in STOPS:
            self._stopped_at = event.time
            self.bench.stop("the operator pressed stop")
            self.action_leave_prompt()
        else:
            await super().on_event(event)

    def action_leave_prompt(self) -> None:
        self._prompt, self._typed = None, ""
        self._draw()

    def on_key(self, event: events.Key) -> None:
        if event.time <= self._stopped_at:
            return
        key = event.character if event.character is not None and event.character.isprintable() else event.key
        if self._prompt is not None:
            if key == "enter":
                request = self._prompt.request_of(self._typed)
                self.action_leave_prompt()
                if isinstance(request, str):
                    self.bench.refuse(request)
                else:
                    self.bench.ask(request)
            elif key == "backspace":
                self._typed = self._typed[:-1]
            elif len(key) == 1:
                self._typed += key
        elif command := self._commands.get(key):
            command()
        self._draw()

    def _step(self, way: int) -> None:
        self.bench.ask(GoTo(self.selected, way * self.step_deg, is_step=True))

    def _turn(self, way: int) -> None:
        self.bench.turn_while_pressed(self.selected, way * min(self.held_rate_dps, self.axis.top_rate_dps or 1.0))

    def _select(self, way: int) -> None:
        names = [axis.name for axis in self.bench.view.axes]
        self.selected = names[(names.index(self.selected) + way) % len(names)]
        self.step_deg = nearest_step_deg(self.axis.steps_deg, self.step_deg)

    def _resize_step(self, way: int) -> None:
        steps = self.axis.steps_deg
        self.step_deg = steps[min(max(steps.index(self.step_deg) + way, 0), len(steps) - 1)]

    def _ask(self, what: str) -> None:
        """Ask for a number; what is wrong with the question itself is told instead."""
        prompt = prompt_for(what, self.axis, self.bench.view, self._set_held_rate)
        if isinstance(prompt, str):
            self.bench.refuse(prompt)
        else:
            self._prompt, self._typed = prompt, ""

    def action_watch_next(self) -> None:
        """Show the readings of the next sensor; after the last one those of all."""
        names = ["", *self._heading.sensors]
        self._watched, self._page = names[(names.index(self._watched) + 1) % len(names)], 0
        self._draw()

    def _turn_page(self, way: int) -> None:
        self._page = max(self._page + way, 0)  # no farther than the last page when it is drawn

    def _set_held_rate(self, rate_dps: float) -> None:
        self.held_rate_dps = abs(rate_dps)

    # A defect of the screen goes where every defect of calrig goes, once the axes stand; it is not printed here.

    @property
    def defect(self) -> Exception | None:
        return self._exception

    def _print_error_renderables(self) -> None: ...

    # Drawing.

    @property
    def axis(self) -> AxisView:
        """The selected one."""
        return next(axis for axis in self.bench.view.axes if axis.name == self.selected)

    def _draw(self) -> None:
        view = self.bench.view
        now = (view, self.selected, self.step_deg, self.size, self._prompt, self._typed, self._watched, self._page)
        # When the screen closes its parts leave one after the other, while the timer may still ask for a picture.
        if now == self._drawn or not all(self.query(f"#{part}") for part in _PARTS):
            return
        self._drawn = now
        field = self.query_one("#prompt", Static)
        field.set_class(self._prompt is not None, "asked")
        field.border_title = self._prompt.title if self._prompt else ""
        key_lines = panels.MOST_KEY_LINES if self.size.height >= panels.TALL else 2
        width, room = (
            self.size.width,
            panels.room_of(view, self.size.height, key_lines, has_question=self._prompt is not None),
        )
        keys = panels.keys_lines(KEYS, width - 2, panels.MOST_KEY_LINES if self.size.height >= panels.TALL else 2)
        watched = self._heading.sensors.get(self._watched)
        channels = [channel for channel in view.channels if watched is None or channel.name in watched]
        page = panels.page_of(channels, room.channels, self._page)
        self._page = page.number
        self.query_one("#around", Static).set_class(not room.has_surroundings, "left-out")
        readings = self.query_one("#channels", Static)
        readings.border_title = f"readings of {self._watched}" if self._watched else "readings"
        readings.border_subtitle = panels.sweep_text(view.channels) or page.label
        messages = self.query_one("#messages").size
        drawn: dict[str, Callable[[], object]] = {
            "#head": lambda: panels.head(self._heading, view),
            "#axes": lambda: panels.axes_panel(view, self.selected, self.step_deg, width),
            "#channels": lambda: panels.channels_panel(page.channels, width),
            "#around": lambda: panels.surroundings_panel(view),
            "#messages": lambda: panels.messages_panel(view.messages, messages.height, messages.width),
            "#prompt": lambda: panels.prompt_line(self._typed),
            "#keys": lambda: keys,
        }
        for part, text in drawn.items():
            self.query_one(part, Static).update(text())  # type: ignore[arg-type]


def is_hung_up() -> bool:
    """Return True where the terminal behind standard input was closed."""
    if sys.platform != "win32" and sys.__stdin__ is not None and sys.__stdin__.isatty():
        poller = select.poll()
        poller.register(sys.__stdin__.fileno(), 0)  # hang-ups and errors are always told
        return bool(poller.poll(0))
    return False  # Windows tells a console that is closed by a signal
