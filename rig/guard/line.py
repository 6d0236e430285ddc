"""A line of the engine's as its stop guard holds it: what is sent on it, with and without an answer.

While an engine lives it may be reading, and two that read one line take each other's bytes: so :meth:`Line.stop` only
writes, and :meth:`Line.aim` is for the line of an engine that is dead or has given it back.
"""

import os
import select
import socket
import sys
import termios
from contextlib import suppress
from threading import Lock
from typing import Any

from rig.clock import SystemClock
from rig.guard.outcomes import SLOWED, STOOD, STOP_SENT, WAY_UNKNOWN, goes_on
from rig.guard.servo_stop import ServoStop, Untrusted, pulse_us

CLOCK = SystemClock()
LINE_S = 2.0
QUIET_LIMIT_S = 5.0
"""A line that is not silent for once within this time is not asked."""
TAIL_S = 0.05
"""Behind an answer: what still comes makes it none."""
SETTLED_S = 0.15
"""In which a servo is back from where it went on to between its answer and its order."""
ROUNDS = 4
"""Servos are asked so often: where they are, and whether they are where they were sent."""
GIVEN_BACK = -1


class Line:
    """Its descriptor, its address where the descriptor is no good any more, its stops.

    Stops are repeated by threads. Who sends one has the turn until it is sent, and no descriptor is closed meanwhile:
    its number may be another port's the next moment, which would get the rest of the stop.
    """

    def __init__(self, document: dict[str, Any], descriptor: int, settings: list[Any] | None = None) -> None:
        """Take a line over. ``settings``: of a serial one, as it was before it was given back."""
        self.name, self.address = document["name"], document["address"]
        self.is_escaped = document["is_escaped"]
        self.axes: dict[str, list[dict[str, Any]]] = document["axes"]
        self.descriptor = descriptor
        is_closed = descriptor == GIVEN_BACK or "://" in self.address
        self.settings = settings if is_closed else _settings_of(descriptor)
        self._turn = Lock()
        self._is_retired = False

    def release(self) -> None:
        """Give the descriptor back, when no stop is half sent: the engine opens the line anew."""
        with self._turn:
            if self.descriptor != GIVEN_BACK:
                os.close(self.descriptor)
                self.descriptor = GIVEN_BACK

    def retire(self) -> None:
        """Give the descriptor back for good: another takes its place, and a stop that is late must not open it anew."""
        self._is_retired = True
        self.release()

    def stop_now(self, axes: list[str] | None, moving: list[str], outcomes: dict[str, str]) -> bool:
        """Tell every axis without ever waiting; False where that cannot be: then :meth:`stop` takes its time."""
        stopped = self._chosen(axes, moving)
        # One pause would keep all other lines from their stop.
        waits = any(step.get("pause_s", 0.0) for steps in stopped.values() for step in steps)
        if waits or not self._turn.acquire(blocking=False):
            return False
        try:
            if self.descriptor == GIVEN_BACK or not select.select([], [self.descriptor], [], 0.0)[1]:
                return False
            for steps in stopped.values():
                self._send_all(steps)
        except OSError:
            return False
        finally:
            self._turn.release()
        outcomes.update({axis: _outcome(steps) for axis, steps in stopped.items()})
        return True

    def stop(self, axes: list[str] | None, moving: list[str], outcomes: dict[str, str]) -> None:
        """Tell every axis of the line, or those; ``outcomes`` gets what became of it by axis."""
        for axis, steps in self._chosen(axes, moving).items():
            try:
                with self._turn:
                    self._stop(steps)
                outcomes[axis] = _outcome(steps)
            except OSError as error:
                outcomes[axis] = f"NOT told to stop: {error}"

    def aims(self, moving: list[str]) -> dict[str, dict[str, Any]]:
        """Return by axis, of those that may move, how a servo is sent to where it is."""
        steps = {axis: step for axis in self.axes if axis in moving for step in self.axes[axis]}
        return {axis: step["aim"] for axis, step in steps.items() if "aim" in step}

    def aim(self, moving: list[str], ways: dict[str, list[int]], outcomes: dict[str, str]) -> None:
        """Send the servos that may move to where they are. Nobody else may read the line."""
        stops, why_not = dict[str, ServoStop](), dict[str, str]()
        for axis, aim in self.aims(moving).items():
            if axis in ways:
                stops[axis], why_not[axis] = ServoStop(aim, ways[axis]), "it was not asked"
            else:
                outcomes[axis] = goes_on(WAY_UNKNOWN)
        try:
            self._aim_in_rounds(stops, why_not)
        except OSError as error:
            why_not = dict.fromkeys(stops, str(error))
        outcomes.update({axis: stop.outcome(why_not[axis]) for axis, stop in stops.items()})

    def _aim_in_rounds(self, stops: dict[str, ServoStop], why_not: dict[str, str]) -> None:
        if self.descriptor == GIVEN_BACK:
            raise OSError("the line is lost")
        is_in_doubt = True
        for _ in range(ROUNDS):
            for axis, stop in stops.items():
                if stop.is_seen:
                    continue
                if is_in_doubt:
                    self._wait_for_silence(stop.patience_s)
                try:
                    position = stop.position(self._answer(stop))
                except Untrusted as error:
                    why_not[axis], is_in_doubt = str(error), True
                    continue
                is_in_doubt, stop.is_seen = False, position == stop.aimed
                why_not[axis] = f"it says {pulse_us(position)}"
                if not stop.is_about_there(position):
                    self._write(stop.order(position))
            if all(stop.is_seen for stop in stops.values()):
                return
            CLOCK.sleep(SETTLED_S)

    def _wait_for_silence(self, patience_s: float) -> None:
        """Take what comes until nothing came for as long as an answer takes: it was asked for by somebody else."""
        until_s = CLOCK.monotonic_s() + QUIET_LIMIT_S + patience_s
        while select.select([self.descriptor], [], [], patience_s)[0]:
            if not os.read(self.descriptor, 4096):
                raise OSError("the line is lost")
            if CLOCK.monotonic_s() > until_s:
                raise OSError(f"the line does not fall silent within {QUIET_LIMIT_S:g} s")

    def _answer(self, stop: ServoStop) -> bytes:
        """Ask, and take all that comes until the line is silent behind it."""
        self._write(stop.question)
        answer, left_s = b"", stop.patience_s
        while select.select([self.descriptor], [], [], left_s)[0]:
            data = os.read(self.descriptor, 4096)
            if not data:
                raise OSError("the line is lost")
            answer, left_s = answer + data, TAIL_S
            if len(answer) > 4096:
                break
        return answer.replace(b"\xff\xff", b"\xff") if self.is_escaped else answer

    def _chosen(self, axes: list[str] | None, moving: list[str]) -> dict[str, list[dict[str, Any]]]:
        """Return the steps by axis; a servo that stands is told nothing."""
        return {
            axis: [step for step in steps if "aim" not in step or axis in moving]
            for axis, steps in self.axes.items()
            if axes is None or axis in axes
        }

    def _stop(self, steps: list[dict[str, Any]]) -> None:
        if self._is_retired:
            raise OSError("the line was opened anew meanwhile")
        if self.descriptor != GIVEN_BACK:
            with suppress(OSError):
                self._send_all(steps)
                return
        host, _, port = self.address.partition("://")[2].rstrip("/").rpartition(":")
        if self.address.startswith("socket://"):
            self.descriptor = socket.create_connection((host.strip("[]"), int(port)), LINE_S).detach()
        elif "://" not in self.address:
            self.descriptor = _opened(self.address, self.settings)
        else:
            raise OSError("the line is lost")
        self._send_all(steps)

    def _send_all(self, steps: list[dict[str, Any]]) -> None:
        for step in steps:
            self._write(bytes.fromhex(step["send"]))
            CLOCK.sleep(step.get("pause_s", 0.0))

    def _write(self, data: bytes) -> None:
        if self.is_escaped:
            # Telnet takes a lone 0xFF for the beginning of a command (RFC 854).
            data = data.replace(b"\xff", b"\xff\xff")
        while data:
            if not select.select([], [self.descriptor], [], LINE_S)[1]:
                raise OSError("the line takes no bytes")
            data = data[os.write(self.descriptor, data) :]


def _settings_of(descriptor: int) -> list[Any] | None:
    """Return the settings of a serial line, None of what is none."""
    if sys.platform == "win32":
        return None
    else:
        try:
            return termios.tcgetattr(descriptor)
        except termios.error:
            return None


def _opened(address: str, settings: list[Any] | None) -> int:
    """Open a serial line as it was. Raises: OSError."""
    if sys.platform == "win32":
        return GIVEN_BACK  # no guard is there: Windows hands no open descriptors to another process
    else:
        descriptor = os.open(address, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        if settings is not None:
            termios.tcsetattr(descriptor, termios.TCSANOW, settings)
        return descriptor


def _outcome(steps: list[dict[str, Any]]) -> str:
    if not steps:
        return STOOD
    return SLOWED if any("aim" in step for step in steps) else STOP_SENT
