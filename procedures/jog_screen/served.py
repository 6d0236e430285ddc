"""A session at the bench for pages of a browser: orders come in as lines of JSON, ticks and what is seen go out.

It is a process of its own, so that whoever serves the pages can hang, end or be overwhelmed without keeping anything
turning: leases are kept here, and when the orders end, every axis is stopped.
"""

import json
import signal
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from threading import Event
from types import FrameType
from typing import IO, Any

from procedures.errors import ExitStatus
from procedures.jog_screen.control import Control
from procedures.jog_screen.inferred import InferredAttitude
from procedures.jog_screen.leaving import close, leave_anyway
from procedures.jog_screen.log import ActionLog, Snapshots
from procedures.jog_screen.values import Asker, AxisView, BenchView, ChannelView
from procedures.jog_screen.worker import Bench
from procedures.numbers import finite
from rig.assembly.open_rig import Rig
from rig.clock import SystemClock
from rig.system_parts import ENDS
from rig.threads import begun

TICK_S = 0.05
VIEW_EVERY = 4
"""Ticks from one view to the next."""
SHOWN_LINES = 12
LONGEST_ORDER = 65_536


def jog_for_pages(
    rig: Rig,
    log: Path,
    snapshots: Path,
    inferred: InferredAttitude | None,
    orders: IO[bytes],
    out: IO[bytes],
    note: Callable[[str], None],
) -> ExitStatus:
    """Serve until the bench is given back or the orders end; every axis is stopped then, and whether it stands is told.

    ``orders`` is not buffered: a thread waits in it to the last. ``note`` hears why it ended where nobody gave it back,
    and where not every axis was seen to stand, which is status 1.
    """
    clock = SystemClock()
    actions = ActionLog(log, clock)
    bench = Bench(rig, actions, Snapshots(snapshots, clock), clock, inferred)
    control, ended = Control(bench, clock), Event()

    def lost(number: int, frame: FrameType | None) -> None:  # noqa: ARG001  the signature of a handler
        bench.guard.lose(f"{signal.Signals(number).name}: the session was ended")

    for number in ENDS:
        signal.signal(number, lost)
    try:
        begun(partial(leave_anyway, bench, ended), "the end of the bench")
        bench.start()
        begun(partial(_hear, orders, control, bench), "the orders of the console")
        _tell(out, control, bench, clock)
    finally:
        close(bench, note)
        actions.close()
        ended.set()
    if bench.guard.lost or not bench.last_stop.is_clean:
        note(f"{bench.guard.lost or 'the bench is closed'}; {bench.last_stop.in_words}")
    return bench.last_stop.exit_status(bench.guard.lost)


def _hear(orders: IO[bytes], control: Control, bench: Bench) -> None:
    """Take orders until they end. A line that is none ends the session: whoever sends it is not the console."""
    try:
        for line in _lines(orders):
            order = json.loads(line)
            control.hear(order, Asker(str(order["client"]), str(order["name"]), str(order["place"])))
        bench.guard.lose("the console is gone")
    except Exception as error:
        bench.guard.lose(f"the orders cannot be read: {error}")
        raise


def _lines(orders: IO[bytes]) -> Iterator[bytes]:
    """Yield what comes, line by line; too long a line is none. Raises: ValueError."""
    rest = b""
    while data := orders.read(LONGEST_ORDER):
        *lines, rest = (rest + data).split(b"\n")
        yield from lines
        if len(rest) > LONGEST_ORDER:
            raise ValueError("an order without an end")


def _tell(out: IO[bytes], control: Control, bench: Bench, clock: SystemClock) -> None:
    """Count ticks and show the bench, until nobody has it, or nobody listens."""
    try:
        while not (control.is_over or bench.guard.lost):
            document: dict[str, Any] = {"tick": control.tick()}
            if document["tick"] % VIEW_EVERY == 1:
                document |= view_document(bench.view, control.holder)
            out.write(json.dumps(document, allow_nan=False).encode() + b"\n")
            out.flush()
            clock.sleep(TICK_S)
            control.look()
    except OSError:
        bench.guard.lose("the console is gone")


def view_document(view: BenchView, holder: Asker | None) -> dict[str, Any]:
    """Return what is seen, as a page is given it."""
    return {
        "holder": None if holder is None else {"name": holder.name, "client": holder.client},
        "doing": view.doing,
        "stopping": view.is_stopping,
        "waits": view.waits_for,
        "axes": [_axis(axis) for axis in view.axes],
        "channels": [_channel(channel) for channel in view.channels],
        "chambers": [
            {
                "name": chamber.name,
                "temperature_degc": chamber.temperature_degc,
                "setpoint_degc": chamber.setpoint_degc,
                "silence": chamber.silence,
            }
            for chamber in view.chambers
        ],
        "attitude": None
        if view.attitude is None
        else {
            "sensor": view.attitude.sensor,
            "angles": [[name, finite(deg), finite(sd_deg)] for name, deg, sd_deg in view.attitude.angles],
            "flag": view.attitude.flag,
        },
        "messages": [[message.clock, message.tone, message.text] for message in view.messages[-SHOWN_LINES:]],
    }


def _axis(view: AxisView) -> dict[str, Any]:
    state = view.state
    return {
        "name": view.name,
        "limits_deg": view.limits_deg,
        "steps_deg": view.steps_deg,
        "top_rate_dps": view.top_rate_dps,
        "position_deg": None if state is None or state.unknown else finite(state.position_deg),
        "is_homed": state is not None and state.is_homed,
        "is_moving": state is not None and state.is_moving,
        "fault": "" if state is None else state.fault,
        "target_deg": view.target_deg,
        "rate_dps": None if view.measured is None else finite(view.measured.rate_dps),
        "wound_turns": finite(view.wound_turns),
        "silence": view.silence,
    }


def _channel(view: ChannelView) -> dict[str, Any]:
    return {
        "name": view.name,
        "unit": view.unit,
        "mean": finite(view.mean),
        "sd": finite(view.standard_deviation),
        "n": view.count,
        "overloads": view.overloads,
        "silence": view.silence,
    }
