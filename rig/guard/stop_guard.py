"""The engine's side of its stop guard: start it before the first motion, show it signs of life, hear it.

The guard is a process (:mod:`rig.guard.process`), so that nothing that happens to this one keeps it from the stop.
"""

import json
import select
import socket
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from threading import RLock
from typing import Any

from rig.abilities.abilities import StopStep
from rig.clock import Clock
from rig.errors import GuardLost, RigError, WaitEnded
from rig.guard.outcomes import SLOWED, STOOD, STOP_SENT
from rig.guard.process_state import state_of
from rig.system_parts import module_here

IS_POSSIBLE = hasattr(socket, "send_fds") and module_here("termios") is not None
"""A guard holds the engine's own lines, open, which Windows does not hand from process to process."""
RECORD = "stop-guard.json"
"""In the folder of a run: what its guard did."""
PROCESS = Path(__file__).with_name("process.py")
READY_S = 20.0
RELEASE_S = 2.0
BEAT_S = 0.1
FROZEN_S = 0.5
"""A guard that has not answered a beat for so long is looked at: one that was stopped (SIGSTOP) is as good as gone."""
DEAF_S = 6.0
"""So is one that does not answer for so long, whatever keeps it. No sooner: a line that takes no bytes keeps it for
four seconds at a stop, and to end it then would be to end the stop of the others.
"""


@dataclass(frozen=True, slots=True)
class GuardedLine:
    """A line on which axes are."""

    name: str
    address: str
    descriptor: int | None
    """None where it is closed: the guard opens it by its address when it has to."""
    is_escaped: bool
    """Whether 0xFF is doubled on it (telnet, RFC 2217)."""
    orders: Mapping[str, Sequence[StopStep]] = field(default_factory=dict)
    """How each axis on it is stopped."""

    def document(self) -> dict[str, Any]:
        axes = {axis: [step.document() for step in steps] for axis, steps in self.orders.items()}
        about = {"name": self.name, "address": self.address, "is_escaped": self.is_escaped, "axes": axes}
        return {**about, "is_given_back": True} if self.descriptor is None else about


STOP_NOW = b'{"stop": "a defect"}\n'
"""Made beforehand: who asks for it may have no memory left."""
AT_START_S = 5.0
"""The silence after which the guard acts between an order to move and the first look, which says how long it may be."""


class StopGuard:
    """Guard one open rig over real ports, over all its reconnections.

    ``rig``: what others find it by; ``folder``: where
    they look; ``record``: the file in which it writes what it did. The process begins with the first motion.
    """

    def __init__(self, record: Path, rig: Mapping[str, str], folder: Path | None, clock: Clock) -> None:
        self._record = record
        self._rig = dict(rig)
        self._folder = folder
        self._clock = clock
        self._lines: tuple[GuardedLine, ...] = ()
        self._channel: socket.socket | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._pending = b""
        self._moving: list[str] = []
        self._ways: dict[str, tuple[int, int]] = {}
        self._silence_s = AT_START_S
        self._ring: tuple[str, ...] = ()
        self._owes_end = False
        self._holding = self._given_back = 0
        """Counts what the guard was told to hold, and how far it has given back what it was not."""
        self._beaten_s = self._looked_s = self._heard_s = self._resumed_s = 0.0
        self._trouble: RigError | None = None
        self._turn = RLock()

    @property
    def pid(self) -> int | None:
        """Of the guard; None before the first motion."""
        return None if self._process is None else self._process.pid

    def belongs_to(self, run_dir: Path, ring: Sequence[str] = ()) -> Callable[[], None]:
        """From the next motion on it is a run's: what it does is told in the run's folder.

        ``ring``: the command that tells people of an end without a goodbye; it gets what the guard knows as its last
        word. Return what is called when the end of the run is on record: a goodbye before that is none.
        """

        def end_is_on_record() -> None:
            self._owes_end = False

        self._owes_end = True
        self._record = run_dir.resolve() / RECORD
        self._rig["run"] = str(run_dir.resolve())
        self._ring = tuple(ring)
        return end_is_on_record

    def hold(self, lines: Sequence[GuardedLine]) -> None:
        """Hold the lines as they are open now. Waits until those that are closed are given back, to be opened anew."""
        with self._turn:
            self._lines = tuple(lines)
            if self._channel is not None:
                self._hear()
                self._send_lines()
                if any(line.descriptor is None for line in lines):
                    self._let_release()

    def release(self) -> None:
        """Give the lines back before they are opened anew; the guard would open them itself. Waits until it has."""
        with self._turn:
            self._lines = ()
            if self._channel is not None:
                self._hear()
                self._holding += 1
                self._send({"released": True, "holding": self._holding})
                self._let_release()

    def _let_release(self) -> None:
        """Wait until the guard says so; answers to beats and stops of somebody else come between, and are heard."""
        until_s = self._clock.monotonic_s() + RELEASE_S
        while self._channel is not None and self._given_back < self._holding:
            left_s = max(until_s - self._clock.monotonic_s(), 0.0)
            if not select.select([self._channel], [], [], left_s)[0]:
                return
            self._hear()

    def expect_motion(self, moving: Sequence[str], ways: Mapping[str, tuple[int, int]]) -> None:
        """Before anything is told to move: a guard must be there, and know the ways of :class:`AimedStop`."""
        with self._turn:
            self.begin()
            if self._ways != ways:
                self._ways, self._moving = dict(ways), []
            self.beat(moving, AT_START_S)

    def begin(self) -> None:
        """Begin now, where a start may not wait for it: with the first motion otherwise."""
        with self._turn:
            if self._channel is None and self._trouble is None:
                self._begin()

    def beat(self, moving: Sequence[str], silence_s: float) -> None:
        """Give a sign of life at a look, and say what moves now, and after how long a silence it is to be stopped."""
        with self._turn:
            now_s = self._clock.monotonic_s()
            if list(moving) != self._moving or silence_s != self._silence_s:
                self._moving, self._silence_s, self._looked_s = list(moving), silence_s, now_s
                news = {"moving": self._moving, "ways": self._ways, "silence_s": silence_s, "looked": True}
                self._say(news, now_s)
            elif now_s - self._looked_s >= BEAT_S:
                self._looked_s = now_s
                self._say({"looked": True}, now_s)

    def sign_of_life(self) -> None:
        """Say that the engine is at work while something moves: it waits, or converses with another device."""
        if self._moving:
            with self._turn:
                now_s = self._clock.monotonic_s()
                if now_s - self._beaten_s >= BEAT_S:
                    self._say({}, now_s)

    def stop_now(self) -> bool:
        """Have every axis stopped by a few bytes that are there already; False where nobody hears them.

        For the way out of a defect. It takes no turn, since whoever has it may be the one that failed.
        """
        channel = self._channel
        if channel is None:
            return False
        try:
            channel.sendall(STOP_NOW)
        except OSError:
            return False
        return True

    def _say(self, message: Mapping[str, object], now_s: float) -> None:
        if self._channel is None:
            return
        self._send(message)
        if now_s - self._beaten_s >= DEAF_S / 2.0:
            self._resumed_s = now_s
        self._beaten_s = now_s
        self._hear()

    def take_trouble(self) -> RigError | None:
        """Why nothing may move on, once: the guard is gone (GuardLost), or had axes stopped for somebody (WaitEnded).

        It is kept until whoever moves something asks, since others must finish their stops.
        """
        with self._turn:
            trouble, self._trouble = self._trouble, None
            return trouble

    def why_stop(self) -> str:
        """Return why nothing may move on, as far as is known now; empty where nothing is. It waits for nobody.

        For a thread beside the one that moves the axes, which may wait for a device; the trouble stays to be taken.
        """
        if self._turn.acquire(blocking=False):
            try:
                self._hear()
            finally:
                self._turn.release()
        trouble = self._trouble
        return "" if trouble is None else str(trouble)

    def close(self) -> None:
        """Say goodbye; where something is not known to stand, the guard stops it on its way out.

        That of a run whose end is not on record is no goodbye: the guard does all that it does after a death, except
        that it ends nobody.
        """
        with self._turn:
            if self._channel is None or self._process is None:
                return
            self._send({"goodbye": not self._owes_end})
            if self._channel is not None:
                self._channel.close()
                self._channel = None
            try:
                self._process.wait(READY_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()

    def _begin(self) -> None:
        folder = None if self._folder is None else str(self._folder)
        start = {"record": str(self._record), "rig": self._rig, "folder": folder, "ring": self._ring}
        ours, theirs = socket.socketpair()
        with theirs:
            # Without environment and site-packages nothing that is installed beside can delay or break it; in a session
            # of its own Ctrl-C and a terminal that closes reach the engine alone.
            self._process = subprocess.Popen(  # noqa: S603  our own file, by the interpreter that runs this
                [sys.executable, "-I", "-S", str(PROCESS), str(theirs.fileno()), json.dumps(start)],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
        self._channel, self._pending, self._moving = ours, b"", []
        self._silence_s = AT_START_S
        self._heard_s = self._clock.monotonic_s()
        if not select.select([ours], [], [], READY_S)[0]:
            self._lose("did not begin")
            return
        self._hear()
        self._send_lines()

    def _send_lines(self) -> None:
        self._holding += 1
        message = {"lines": [line.document() for line in self._lines], "holding": self._holding}
        self._send(message, [line.descriptor for line in self._lines if line.descriptor is not None])

    def _send(self, message: Mapping[str, object], descriptors: Sequence[int] = ()) -> None:
        if self._channel is None:
            return
        data = json.dumps(message).encode() + b"\n"
        try:
            if not select.select([], [self._channel], [], READY_S)[1]:
                self._lose("does not listen any more")
            elif descriptors and sys.platform != "win32":
                socket.send_fds(self._channel, [data], list(descriptors))
            else:
                self._channel.sendall(data)
        except OSError:
            self._lose("is gone")

    def _hear(self) -> None:
        now_s = self._clock.monotonic_s()
        while self._channel is not None and select.select([self._channel], [], [], 0.0)[0]:
            try:
                data = self._channel.recv(65536)
            except OSError:
                data = b""
            if not data:
                self._lose("is gone")
                return
            self._heard_s = now_s
            *lines, self._pending = (self._pending + data).split(b"\n")
            for message in map(json.loads, lines):
                if message.get("unlisted"):
                    self._refuse_unlisted(message["unlisted"])
                    return
                self._given_back = message.get("given_back", self._given_back)
                if (by := message.get("stop")) is not None:
                    self._trouble = WaitEnded(_stop_words(message["told"]), by or "somebody without a name")
        silent_s = now_s - self._heard_s
        # It answers beats alone: before the first beat after a pause of ours its silence says nothing.
        if self._channel is None or silent_s <= FROZEN_S or now_s - self._beaten_s >= DEAF_S / 2.0:
            return
        if self._process is not None and state_of(self._process.pid) == "T":
            self._lose("was frozen (SIGSTOP)")
        elif now_s - max(self._heard_s, self._resumed_s) > DEAF_S:
            self._lose(f"has not answered for {DEAF_S:g} s")

    def _refuse_unlisted(self, why: str) -> None:
        """Nothing may move by one that no stop from elsewhere would find."""
        if self._process is not None:
            # Before its channel closes: that would be the death of its engine, which it ends.
            self._process.kill()
            self._process.wait()
        self._lose("is not needed")
        self._trouble = GuardLost(
            f"the stop guard could not say where it is ({why}): calrig abort and calrig jog --stop would not find it;"
            " nothing was moved; make room there, then try again"
        )

    def _lose(self, what: str) -> None:
        """Nothing may move without one; the motion after the next begins with a new guard."""
        if self._channel is not None:
            self._channel.close()
            self._channel = None
        if self._process is not None:
            # A frozen one would hold its copies of the lines, and so keep everybody from ports that open but once.
            self._process.kill()
            self._process.wait()
        self._trouble = GuardLost(
            f"the stop guard (process {self.pid}) {what}: nobody would stop the axes if this program died; they were"
            " told to stop; find out what ended it, or what keeps this computer so busy"
        )


def _stop_words(outcomes: Mapping[str, str]) -> str:
    """Return what the guard sent, as a reason: that the axes stand is for who looks at them to say."""
    words = "the stop guard told the axes to stop at once"
    if slowed := [axis for axis, outcome in sorted(outcomes.items()) if outcome == SLOWED]:
        words += f", and {' and '.join(slowed)} to go at the lowest speed until this program stopped it"
    missed = [
        f"{axis}: {outcome}" for axis, outcome in sorted(outcomes.items()) if outcome not in (STOP_SENT, STOOD, SLOWED)
    ]
    return f"{words} ({'; '.join(missed)})" if missed else words
