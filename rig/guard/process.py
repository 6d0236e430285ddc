"""The stop guard, a process of its own: started as a file, with the standard library and one codec.

It holds the lines of an engine (the same open descriptors), the bytes that stop every axis, and one end of a channel.
It sends the stops when the engine is gone without a goodbye, or gives the rig back before the end of its run is on
record, and, while anything may move, when the engine is frozen
(SIGSTOP), gives no sign of life, or the machine was suspended; then it ends the engine, since an engine that thaws
would go on with a motion that is over. While every axis stands an engine may stall as long as it likes.

Whoever asks through its socket has the axes stopped at once; the engine is told, and ends what it was doing.

A servo has no stop but to be sent to where it is, and that has to be asked. Two that read one line take each other's
answers, so while the engine lives the guard only tells servos to go at their lowest speed, and the engine stops them;
when it is dead, or has given the lines back, the guard asks, and sends no servo anywhere by an answer that it does not
trust (:mod:`rig.guard.servo_stop`), nor one that stood.
"""

import json
import os
import select
import signal
import socket
import subprocess
import sys
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

if not __package__:  # started as a file, without the folders of this environment
    sys.path[:0] = [str(Path(__file__).parents[2])]

from rig.abilities.longest_reading import LONGEST_READING_S
from rig.clock import SystemClock
from rig.guard.ask import FORMAT, KEYS, SUFFIX
from rig.guard.line import GIVEN_BACK, LINE_S, QUIET_LIMIT_S, Line
from rig.guard.outcomes import ENGINE_LIVES, UNASKED, goes_on
from rig.guard.priority import go_first, step_back
from rig.guard.process_state import state_of
from rig.threads import BegunThread, at_once

assert sys.platform != "win32", "Windows hands no open descriptors to another process"
CLOCK = SystemClock()
LOOK_S, IDLE_S = 0.05, 0.5
MOST_PER_LOOK_S = 0.25
"""Of a silence, between two looks of ours: when this process got no processor either it could hear nothing."""
SUSPENDED_S = 1.0
TIMES, AGAIN_S = 3, 0.15
"""Stops are told again: the first may run into what the engine was just writing."""
AIMS = 6
"""Questions to servos of one line that :meth:`Guard.aim_servos` waits for."""
MOST_DESCRIPTORS = 4096
"""More than an engine's lines are."""
ENDED_S = 2.0
"""So long a process may take to be gone when it was killed."""
DEFECT = "it had every axis stopped before, since it met a defect or had no memory left"
GONE = "the engine ended without a word"
UNENDED = "the engine gave the axes back before the end of its run was on record"
"""It cannot go on as it is, as one without memory or open files; it may still say so on its screen."""


class Guard:
    """The process."""

    def __init__(self, channel: socket.socket, start: dict[str, Any]) -> None:
        self.channel = channel
        self.engine = os.getppid()
        self.start = start
        self.lines: list[Line] = []
        self.moving: list[str] = []
        self.ways: dict[str, list[int]] = {}
        """From where to where the last order moves a servo, by axis, in quarter-microseconds."""
        self.record: str = start["record"]
        self.silence_s = LONGEST_READING_S  # as the engine says it
        self.has_lines = True
        """False while the engine opens some anew: as long as that takes nobody can look at what moves."""
        self.silent_s = 0.0
        self.awake_s = self.looked_s = CLOCK.monotonic_s()
        self.before = ""
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
            # First: what moves is known before somebody has it stopped.
            if self.channel in ready and not self.hear():
                return
            for caller in [end for end in ready if end in self.callers]:
                self.serve(caller)
            if self.listener in ready:
                self.accept()
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
        self.silent_s = 0.0
        *lines, self.pending = (self.pending + data).split(b"\n")
        answer: dict[str, int] = {}
        for line in lines:
            message = json.loads(line)
            if message.get("goodbye") is False:
                self.stop_for_good(UNENDED)
                return False
            if "goodbye" in message:
                for _ in range(TIMES if self.moving else 0):
                    self.stop_axes()
                    CLOCK.sleep(AGAIN_S)
                self.aim_servos({})
                return False
            if "lines" in message:
                self.take(message["lines"])
                self.has_lines = not any(line.descriptor == GIVEN_BACK for line in self.lines)
                self.looked_s = CLOCK.monotonic_s()
            if "released" in message:
                self.has_lines = False
                for held in self.lines:
                    held.release()
            if "holding" in message:
                answer = {"given_back": message["holding"]}
            if "stop" in message:
                self.before = DEFECT
                for _ in range(TIMES):
                    self.stop_axes()
                    CLOCK.sleep(AGAIN_S)
            self.looked_s = CLOCK.monotonic_s() if "looked" in message else self.looked_s
            self.moving = message.get("moving", self.moving)
            self.ways = message.get("ways", self.ways)
            self.silence_s = message.get("silence_s", self.silence_s)
        with suppress(OSError):
            self.channel.send(json.dumps(answer).encode() + b"\n", socket.MSG_DONTWAIT)
        return True

    def take(self, lines: list[dict[str, Any]]) -> None:
        """Hold the lines as they are open now; those before are given back, and known as they were where none is."""
        before, known = self.lines, {line.address: line.settings for line in self.lines}
        held = []
        for document in lines:
            descriptor = GIVEN_BACK if document.get("is_given_back") else self.descriptors.pop(0)
            held.append(Line(document, descriptor, known.get(document["address"])))
        self.lines = held  # at once, and first: a stop that is being repeated goes on by what is held now
        for line in before:
            line.retire()

    def why_stop(self) -> str:
        if os.getppid() != self.engine:
            return GONE
        slept_s = asleep_s() - self.asleep_s
        # Also while nothing moves: a sleep of before must not stop the next motion.
        self.asleep_s += slept_s
        now_s = CLOCK.monotonic_s()
        self.silent_s += min(now_s - self.awake_s, MOST_PER_LOOK_S)
        self.awake_s = now_s
        if not self.moving:
            return ""
        if slept_s > SUSPENDED_S:
            return f"the computer was suspended for {slept_s:.0f} s"
        if state_of(self.engine) == "T":
            return "the engine was frozen (SIGSTOP)"
        if self.silent_s > self.silence_s and not select.select([self.channel], [], [], 0.0)[0]:
            return f"the engine gave no sign of life for {self.silence_s:g} s"
        if self.has_lines and now_s - self.looked_s > LONGEST_READING_S:
            return f"the engine did not look at what moves for {LONGEST_READING_S:g} s"
        return ""

    def stop_axes(self, axes: list[str] | None = None) -> dict[str, str]:
        """Lines that take the bytes at once first: under load a thread begins when it is its turn.

        Each of the others in a thread of its own: one that takes no bytes keeps no other from its stop.
        """
        outcomes: dict[str, str] = {}
        left = [line for line in self.lines if not line.stop_now(axes, self.moving, outcomes)]
        stops = [partial(line.stop, axes, self.moving, outcomes) for line in left]
        at_once(stops, 2.0 * LINE_S, "the stop of a line")
        silent = [axis for line in self.lines for axis in line.axes if axes is None or axis in axes]
        return {axis: outcomes.get(axis, "NOT told to stop: its line takes no bytes") for axis in silent}

    def aim_servos(self, outcomes: dict[str, str]) -> None:
        """Send the servos that may move to where they are; only when no engine reads the lines any more."""
        aimed = [line for line in self.lines if line.aims(self.moving)]
        ways = {axis: way for axis, way in self.ways.items() if axis in self.moving}
        patience_s = max((aim["patience_s"] for line in aimed for aim in line.aims(self.moving).values()), default=0.0)
        limit_s = QUIET_LIMIT_S + AIMS * (patience_s + LINE_S)
        servos = [axis for line in aimed for axis in line.aims(self.moving)]
        outcomes.update(dict.fromkeys(servos, goes_on(UNASKED)))
        at_once([partial(line.aim, self.moving, ways, outcomes) for line in aimed], limit_s, "the aim of a line")

    def is_engine_ended(self) -> bool:
        """Return whether the process is gone that was killed."""
        until_s = CLOCK.monotonic_s() + ENDED_S
        while os.getppid() == self.engine and CLOCK.monotonic_s() < until_s:
            CLOCK.sleep(LOOK_S / 10.0)
        return os.getppid() != self.engine

    def stop_for_good(self, why: str) -> None:
        moving, stopped_utc = self.moving, CLOCK.now_utc().isoformat(timespec="seconds")
        outcomes = self.stop_axes()
        # An engine that thaws would go on with a plan whose axes were stopped behind its back.
        if why != UNENDED and os.getppid() == self.engine:
            with suppress(OSError):
                os.kill(self.engine, signal.SIGKILL)
            why = why if why == GONE else f"{why}; it was ended"
        why = f"{why}; {self.before}" if self.before else why
        for _ in range(TIMES - 1):
            CLOCK.sleep(AGAIN_S)
            outcomes = self.stop_axes()
        if why == UNENDED or self.is_engine_ended():
            self.aim_servos(outcomes)
        else:
            servos = [axis for line in self.lines for axis in line.aims(moving)]
            outcomes.update(dict.fromkeys(servos, goes_on(ENGINE_LIVES)))
        document = {
            "format": FORMAT,
            "stopped_utc": stopped_utc,
            "why": why,
            "pid": self.engine,
            "moving": moving,
            "axes": outcomes,
        }
        has_rung = self.ring(document)
        if moving or why.startswith(UNENDED):
            self.write_record(document)
        if not has_rung and os.getppid() != self.engine:  # an engine that lives would wait for it, and tells people
            self.ring_as_this_process(document)

    def ring(self, document: dict[str, Any]) -> bool:
        """Have people told, in a process that outlives this one and before a disk is asked, which may be the cause.

        Return False where the system has no room for another process.
        """
        if self.start["ring"]:
            step_back()
            try:
                subprocess.Popen(  # noqa: S603  the engine's own command
                    [*self.start["ring"], json.dumps(document)],
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                    start_new_session=True,
                )
            except OSError:
                return False
        return True

    def ring_as_this_process(self, document: dict[str, Any]) -> None:
        """Become the process that tells people: nothing else is left to do here, and the lines are given back."""
        self.close()
        os.closerange(3, MOST_DESCRIPTORS)
        with suppress(OSError):
            os.execv(self.start["ring"][0], [*self.start["ring"], json.dumps(document)])  # noqa: S606  as above

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
            message = {"stop": by[:200], "told": outcomes}
            self.channel.send(json.dumps(message).encode() + b"\n", socket.MSG_DONTWAIT)
        answer = BegunThread(partial(self.answer, caller, axes, outcomes), "an answer")
        if not answer.offer() and answer.claim():
            answer.do_here()

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
