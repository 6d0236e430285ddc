"""The stop guard, a process of its own: started as a file, with the standard library and one codec.

It holds the lines of an engine (the same open descriptors), the bytes that stop every axis, and one end of a channel.
It sends the stops when the engine is gone without a goodbye, or gives the rig back before the end of its run is on
record, and, while anything may move, when the engine is frozen
(SIGSTOP), gives no sign of life, or the machine was suspended; then it ends the engine, since an engine that thaws
would go on with a motion that is over. While every axis stands an engine may stall as long as it likes.

Whoever asks through its socket has the axes stopped at once; the engine is told, and ends what it was doing.
"""

import json
import os
import select
import signal
import socket
import subprocess
import sys
import termios
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any

if not __package__:  # started as a file, without the folders of this environment
    sys.path[:0] = [str(Path(__file__).parents[2])]

from rig.clock import SystemClock
from rig.guard.ask import FORMAT, KEYS, SUFFIX
from rig.guard.priority import go_first, step_back
from rig.guard.process_state import state_of
from rig.wire.maestro import HIGHEST_NUMBER, MaestroCodec, decode_word, set_target

assert sys.platform != "win32", "Windows hands no open descriptors to another process"
CLOCK = SystemClock()
LOOK_S, IDLE_S = 0.05, 0.5
HUNG_S = 120.0
"""Without a look at a moving axis: the longest reading of a channel between two looks is shorter."""
SUSPENDED_S = 1.0
TIMES, AGAIN_S = 3, 0.15
"""Stops are told again: the first may run into what the engine was just writing."""
ANSWER_S, LINE_S = 0.3, 2.0
GIVEN_BACK = -1
GONE = "the engine ended without a word"
UNENDED = "the engine gave the axes back before the end of its run was on record"
"""It cannot go on as it is, as one without memory or open files; it may still say so on its screen."""


class Line:
    """A line of the engine's: its descriptor, its address where the descriptor is no good any more, its stops."""

    def __init__(self, document: dict[str, Any], descriptor: int) -> None:
        self.name, self.address = document["name"], document["address"]
        self.is_escaped = document["is_escaped"]
        self.axes = document["axes"]
        self.descriptor = descriptor
        self.settings: list[Any] | None = None
        if "://" not in self.address:
            with suppress(termios.error):
                self.settings = termios.tcgetattr(descriptor)

    def release(self) -> None:
        """Give the descriptor back: the engine opens the line anew."""
        if self.descriptor != GIVEN_BACK:
            os.close(self.descriptor)
            self.descriptor = GIVEN_BACK

    def stop_now(self, axes: list[str] | None, outcomes: dict[str, str]) -> bool:
        """Tell every axis without ever waiting; False where that cannot be: then :meth:`stop` takes its time."""
        stopped = {axis: steps for axis, steps in self.axes.items() if axes is None or axis in axes}
        # One pause or one question would keep all other lines from their stop.
        waits = any("aim" in step or step.get("pause_s", 0.0) for steps in stopped.values() for step in steps)
        if waits or self.descriptor == GIVEN_BACK or not select.select([], [self.descriptor], [], 0.0)[1]:
            return False
        try:
            for steps in stopped.values():
                self._send_all(steps)
        except OSError:
            return False
        outcomes.update(dict.fromkeys(stopped, "told to stop"))
        return True

    def stop(self, axes: list[str] | None, outcomes: dict[str, str]) -> None:
        """Tell every axis of the line, or those; ``outcomes`` gets what became of it by axis."""
        for axis, steps in self.axes.items():
            if axes is None or axis in axes:
                try:
                    self._stop(steps)
                    outcomes[axis] = "told to stop"
                except OSError as error:
                    outcomes[axis] = f"NOT told to stop: {error}"

    def _stop(self, steps: list[dict[str, Any]]) -> None:
        if self.descriptor != GIVEN_BACK:
            with suppress(OSError):
                self._send_all(steps)
                return
        host, _, port = self.address.partition("://")[2].rstrip("/").rpartition(":")
        if self.address.startswith("socket://"):
            self.descriptor = socket.create_connection((host.strip("[]"), int(port)), LINE_S).detach()
        elif "://" not in self.address:
            self.descriptor = os.open(self.address, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            if self.settings is not None:
                termios.tcsetattr(self.descriptor, termios.TCSANOW, self.settings)
        else:
            raise OSError("the line is lost")
        self._send_all(steps)

    def _send_all(self, steps: list[dict[str, Any]]) -> None:
        for step in steps:
            data = bytes.fromhex(step["send"])
            if "aim" in step:
                data = self._aimed(data, step["aim"])
            self._write(data)
            CLOCK.sleep(step.get("pause_s", 0.0))

    def _aimed(self, question: bytes, aim: dict[str, Any]) -> bytes:
        """Return the order that makes a servo's present position its target."""
        for _ in range(TIMES):
            # An answer that the engine had asked for would be taken for the position.
            while select.select([self.descriptor], [], [], 0.0)[0] and os.read(self.descriptor, 4096):
                pass
            self._write(question)
            answer, until_s = b"", CLOCK.monotonic_s() + ANSWER_S
            while len(answer) < 2 and (left_s := until_s - CLOCK.monotonic_s()) > 0.0:
                if select.select([self.descriptor], [], [], left_s)[0]:
                    answer += os.read(self.descriptor, 2 - len(answer))
            position = decode_word(answer)
            if len(answer) == 2 and 0 < position <= HIGHEST_NUMBER:
                return MaestroCodec(aim["device"], aim["has_crc"]).encode(set_target(aim["channel"], position))
        raise OSError("the controller does not say where the servo is")

    def _write(self, data: bytes) -> None:
        if self.is_escaped:
            # Telnet takes a lone 0xFF for the beginning of a command (RFC 854).
            data = data.replace(b"\xff", b"\xff\xff")
        while data:
            if not select.select([], [self.descriptor], [], LINE_S)[1]:
                raise OSError("the line takes no bytes")
            data = data[os.write(self.descriptor, data) :]


class Guard:
    """The process."""

    def __init__(self, channel: socket.socket, start: dict[str, Any]) -> None:
        self.channel = channel
        self.engine = os.getppid()
        self.start = start
        self.lines: list[Line] = []
        self.moving: list[str] = []
        self.record: str = start["record"]
        self.seen_s = CLOCK.monotonic_s()
        self.asleep_s = asleep_s()
        self.pending = b""
        self.descriptors: list[int] = []
        self.listener: socket.socket | None = None
        self.callers: dict[socket.socket, float] = {}
        """Who has not said what they want, and until when they are listened to."""
        self.registered = ""

    def listen(self) -> None:
        """Where the system has names for sockets that vanish with their owner.

        Raises: OSError where whoever asks for a stop would not find it.
        """
        has_names = sys.platform.startswith("linux")
        if not has_names or self.start["folder"] is None:
            return
        name = f"calrig-stop-guard-{self.engine}-{os.getpid()}"
        rig = {"socket": name, "pid": str(self.engine), **self.start["rig"]}
        self.listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.listener.bind(f"\0{name}")
        self.listener.listen(8)
        self.registered = os.path.join(self.start["folder"], f"{name}{SUFFIX}")
        partial = f"{self.registered}.partial"
        try:
            with open(partial, "w", encoding="utf-8") as file:
                file.writelines(" ".join(rig.get(key, "").splitlines()) + "\n" for key in KEYS)
            os.replace(partial, self.registered)
        except OSError:
            with suppress(OSError):
                os.unlink(partial)
            raise

    def run(self) -> None:
        while True:
            ends = [self.channel, *self.callers] + ([self.listener] if self.listener else [])
            ready, _, _ = select.select(ends, [], [], LOOK_S if self.moving else IDLE_S)
            for caller in [end for end in ready if end in self.callers]:
                self.serve(caller)
            if self.listener in ready:
                self.accept()
            if self.channel in ready and not self.hear():
                return
            if why := self.why_stop():
                self.stop_for_good(why)
                return

    def hear(self) -> bool:
        """Take what the engine says; False after a goodbye. An end without one, or before a run's, is a death."""
        try:
            data, descriptors, _, _ = socket.recv_fds(self.channel, 65536, 64)
        except OSError:
            data, descriptors = b"", []
        self.descriptors += descriptors
        if not data:
            self.stop_for_good(GONE)
            return False
        self.seen_s = CLOCK.monotonic_s()
        *lines, self.pending = (self.pending + data).split(b"\n")
        for line in lines:
            message = json.loads(line)
            if message.get("goodbye") is False:
                self.stop_for_good(UNENDED)
                return False
            if "goodbye" in message:
                for _ in range(TIMES if self.moving else 0):
                    self.stop_axes()
                    CLOCK.sleep(AGAIN_S)
                return False
            if "lines" in message:
                self.take(message["lines"])
            if "released" in message:
                for held in self.lines:
                    held.release()
            self.moving = message.get("moving", self.moving)
        with suppress(OSError):
            self.channel.send(b"{}\n", socket.MSG_DONTWAIT)
        return True

    def take(self, lines: list[dict[str, Any]]) -> None:
        """Hold the lines as they are open now; those before are given back."""
        for line in self.lines:
            line.release()
        taken, self.descriptors = self.descriptors[: len(lines)], self.descriptors[len(lines) :]
        self.lines = [Line(document, descriptor) for document, descriptor in zip(lines, taken, strict=True)]

    def why_stop(self) -> str:
        if os.getppid() != self.engine:
            return GONE
        slept_s = asleep_s() - self.asleep_s
        # Also while nothing moves: a sleep of before must not stop the next motion.
        self.asleep_s += slept_s
        if not self.moving:
            return ""
        if slept_s > SUSPENDED_S:
            return f"the computer was suspended for {slept_s:.0f} s"
        if state_of(self.engine) == "T":
            return "the engine was frozen (SIGSTOP)"
        if CLOCK.monotonic_s() - self.seen_s > HUNG_S:
            return f"the engine gave no sign of life for {HUNG_S:g} s"
        return ""

    def stop_axes(self, axes: list[str] | None = None) -> dict[str, str]:
        """Lines that take the bytes at once first: under load a thread begins when it is its turn.

        Each of the others in a thread of its own: one that takes no bytes keeps no other from its stop.
        """
        outcomes: dict[str, str] = {}
        left = [line for line in self.lines if not line.stop_now(axes, outcomes)]
        threads = [threading.Thread(target=line.stop, args=(axes, outcomes), daemon=True) for line in left]
        for thread in threads:
            thread.start()
        until_s = CLOCK.monotonic_s() + 2.0 * LINE_S
        for thread in threads:
            thread.join(max(until_s - CLOCK.monotonic_s(), 0.0))
        silent = [axis for line in self.lines for axis in line.axes if axes is None or axis in axes]
        return {axis: outcomes.get(axis, "NOT told to stop: its line takes no bytes") for axis in silent}

    def stop_for_good(self, why: str) -> None:
        moving, stopped_utc = self.moving, CLOCK.now_utc().isoformat(timespec="seconds")
        outcomes = self.stop_axes()
        # An engine that thaws would go on with a plan whose axes were stopped behind its back.
        if why != UNENDED and os.getppid() == self.engine:
            with suppress(OSError):
                os.kill(self.engine, signal.SIGKILL)
            why = why if why == GONE else f"{why}; it was ended"
        for _ in range(TIMES - 1):
            CLOCK.sleep(AGAIN_S)
            outcomes = self.stop_axes()
        document = {
            "format": FORMAT,
            "stopped_utc": stopped_utc,
            "why": why,
            "pid": self.engine,
            "moving": moving,
            "axes": outcomes,
        }
        self.ring(document)
        if moving or why == UNENDED:
            self.write_record(document)

    def ring(self, document: dict[str, Any]) -> None:
        """Have people told, in a process that outlives this one and before a disk is asked, which may be the cause."""
        if self.start["ring"]:
            step_back()
            with suppress(OSError):
                subprocess.Popen(  # noqa: S603  the engine's own command
                    [*self.start["ring"], json.dumps(document)],
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                    start_new_session=True,
                )

    def write_record(self, document: dict[str, Any]) -> None:
        partial = f"{self.record}.partial"
        with suppress(OSError):
            os.makedirs(os.path.dirname(self.record), exist_ok=True)
            with open(partial, "w", encoding="utf-8") as file:
                json.dump(document, file)
                file.flush()
                os.fsync(file.fileno())
            os.replace(partial, self.record)

    def accept(self) -> None:
        """Listen to another caller, who mostly has asked already: a stop waits for no thread to begin."""
        assert self.listener is not None
        caller, _ = self.listener.accept()
        now_s = CLOCK.monotonic_s()
        for silent in [caller for caller, until_s in self.callers.items() if until_s < now_s]:
            del self.callers[silent]
            silent.close()
        self.callers[caller] = now_s + LINE_S
        if select.select([caller], [], [], 0.0)[0]:
            self.serve(caller)

    def serve(self, caller: socket.socket) -> None:
        """One who asks for a stop: all axes or some, at once; the engine hears who. Nonsense is not answered."""
        del self.callers[caller]
        try:
            by, names, _ = caller.recv(4096, socket.MSG_DONTWAIT).decode().split("\n")
        except (OSError, ValueError):
            caller.close()
            return
        axes = names.split("\t") if names else None
        outcomes = self.stop_axes(axes)
        with suppress(OSError):  # at once: it is about to hear the answers to these stops
            self.channel.send(json.dumps({"stop": by[:200]}).encode() + b"\n", socket.MSG_DONTWAIT)
        threading.Thread(target=self.answer, args=(caller, axes, outcomes), daemon=True).start()

    def answer(self, caller: socket.socket, axes: list[str] | None, outcomes: dict[str, str]) -> None:
        """Say what became of it to who asked, then send the stops once more."""
        with caller, suppress(OSError):
            caller.settimeout(LINE_S)
            caller.sendall("".join(f"{axis}\t{outcome}\n" for axis, outcome in outcomes.items()).encode())
            caller.shutdown(socket.SHUT_WR)
            for _ in range(TIMES - 1):
                CLOCK.sleep(AGAIN_S)
                self.stop_axes(axes)

    def close(self) -> None:
        if self.registered:
            with suppress(OSError):
                os.unlink(self.registered)


def asleep_s() -> float:
    """Return how long the machine was suspended since it was switched on."""
    return CLOCK.boottime_s() - CLOCK.monotonic_s()


def main() -> None:
    """Guard until the engine says goodbye, or until the axes had to be stopped."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGTSTP, signal.SIGPIPE):
        signal.signal(number, signal.SIG_IGN)  # what ends the engine must not end its guard
    go_first()
    guard = Guard(socket.socket(fileno=int(sys.argv[1])), json.loads(sys.argv[2]))
    try:
        unlisted = ""
        try:
            guard.listen()
        except OSError as error:
            unlisted = f"{guard.start['folder']}: {error.strerror or error}"
        guard.channel.sendall(json.dumps({"ready": True, "unlisted": unlisted}).encode() + b"\n")
        guard.run()
    finally:
        guard.close()


if __name__ == "__main__":
    main()
