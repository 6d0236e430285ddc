"""Two servos on a Maestro at the end of a real line: bytes take their time at 9600 baud, and answers a round trip.

Written from the user's guide (pages 52 to 58), without the codec of the driver.
"""

import os
import select
import threading
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from rig.clock import SystemClock

CLOCK = SystemClock()
BYTE_S = 10.0 / 9600.0
NEUTRAL = 6000
DATA = {0x84: 3, 0x87: 3, 0x89: 3, 0x90: 1, 0xA1: 0, 0xAE: 0}
"""Data bytes by command."""
Damage = Callable[[bytes], bytes]


@dataclass
class Servo:
    """Pulse in quarter-microseconds; ``speed`` in quarters per 10 ms."""

    pulse: float = NEUTRAL
    target: int = NEUTRAL
    speed: int = 20
    seen_s: float = field(default_factory=CLOCK.monotonic_s)

    def look(self) -> float:
        """Go on to now."""
        now_s = CLOCK.monotonic_s()
        by = (now_s - self.seen_s) * 100.0 * self.speed if self.speed else abs(self.target - self.pulse)
        left = self.target - self.pulse
        self.pulse = self.target if abs(left) <= by else self.pulse + (by if left > 0 else -by)
        self.seen_s = now_s
        return self.pulse


@dataclass
class TimedServos:
    """``targets``: what was heard of Set Target, channel, target and the pulse at that moment."""

    path: str
    descriptor: int
    latency_s: float
    damage: Damage
    servos: tuple[Servo, Servo] = field(default_factory=lambda: (Servo(), Servo()))
    targets: list[tuple[int, int, float]] = field(default_factory=list)
    heard: list[tuple[float, int]] = field(default_factory=list)
    """When a command was whole, and which."""
    answered_s: list[float] = field(default_factory=list)
    """When each byte of an answer left."""
    is_damaging: bool = False

    def start(self, channel: int, target: int, *, pulse: int = NEUTRAL, speed: int = 20) -> None:
        """Let a servo be on its way, as an order that nobody needs to see sent."""
        servo = self.servos[channel]
        servo.pulse, servo.seen_s, servo.speed, servo.target = pulse, CLOCK.monotonic_s(), speed, target

    def obey(self, command: int, data: bytes) -> bytes:
        self.heard.append((CLOCK.monotonic_s(), command))
        match command:
            case 0x84:
                target, servo = data[1] | data[2] << 7, self.servos[data[0]]
                self.targets.append((data[0], target, servo.look()))
                servo.target = target
            case 0x87:
                self.servos[data[0]].look()
                self.servos[data[0]].speed = data[1] | data[2] << 7
            case 0x90:
                return int(self.servos[data[0]].look()).to_bytes(2, "little")
            case 0xA1:
                return b"\0\0"
            case 0xAE:
                return b"\1"
        return b""


@contextmanager
def timed_servos(latency_s: float = 0.0, damage: Damage = lambda reply: reply) -> Iterator[TimedServos]:
    """A pseudo-terminal with the servos at its far end."""
    far, near = os.openpty()
    for end in (far, near):
        tty.setraw(end)
    served, is_over = TimedServos(os.ttyname(near), near, latency_s, damage), threading.Event()
    thread = threading.Thread(target=_serve, args=(served, far, is_over))
    thread.start()
    try:
        yield served
    finally:
        is_over.set()
        thread.join()
        os.close(far)


def _serve(served: TimedServos, far: int, is_over: threading.Event) -> None:
    heard, arriving, leaving = b"", list[tuple[float, int]](), list[tuple[float, int]]()
    in_s = out_s = 0.0
    while not is_over.is_set():
        if select.select([far], [], [], 0.001)[0]:
            for byte in os.read(far, 4096):
                in_s = max(in_s, CLOCK.monotonic_s()) + BYTE_S
                arriving.append((in_s, byte))
        while arriving and arriving[0][0] <= CLOCK.monotonic_s():
            at_s, byte = arriving.pop(0)
            heard += bytes([byte])
            if len(heard) > DATA[heard[0]]:
                reply, heard = served.obey(heard[0], heard[1:]), b""
                for answered in served.damage(reply) if served.is_damaging else reply:
                    out_s = max(out_s, at_s + served.latency_s) + BYTE_S
                    leaving.append((out_s, answered))
        while leaving and leaving[0][0] <= CLOCK.monotonic_s():
            served.answered_s.append(CLOCK.monotonic_s())
            os.write(far, bytes([leaving.pop(0)[1]]))
