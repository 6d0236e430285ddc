"""What a line can do to a command: the value, the sign, the axis, twice, never, late; by every driver's own codec.

One strike goes into one command of a bench in virtual time. Checksums are made right again: the worst line is one
whose damage nobody can see.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Protocol

import numpy as np
from motion_bench import MotionBench, motion_bench
from pymodbus.framer import FramerRTU

from rig.clock import VirtualClock
from rig.errors import RigError
from rig.link.faults import Fault, LinkFaults, Part, delay, drop, duplicate
from rig.motion.expectation import HOME_DEG
from rig.motion.move import home_and_arrive, move_and_arrive, stop_all
from rig.motion.supervisor import SupervisedAxis, Supervisor
from rig.wire import maestro, oriental_az, zaber

KINDS = ("value", "sign", "axis", "doubled", "swallowed", "late")
ANOTHER_VERB = "verb"
"""A kind that only the Zaber stage knows: a home or a move becomes a rate of up to :data:`FASTEST_DPS`."""
FAMILIES = ("indexing-table", "esp301", "maestro", "oriental-az", "zaber")
TURNING = ("oriental-az", "zaber")
LATE_S = 0.4
"""Later than this and the machine is asked whether it started before it hears of it: told again, it is one motion."""
LIMITS_DEG = (-90.0, 90.0)
SPEED_DPS = 20.0
FASTEST_DPS = 120.0
"""Of a home or a move that becomes a rate."""
REACTION_S = 0.6
"""From what the line did to the stop: a look, its confirmation, the others' turn."""
DEAF_S = 2.0
"""The same where an axis answers that was not asked: first the driver's own patience for the right answer runs out."""
MARGIN_DEG = 1.0
MICROSTEP_DEG, VELOCITY_SCALE = 0.000234375, 1.6384
"""Of the stage of the bench."""
DECELERATION_DPS2 = {"oriental-az": 20.0}
"""Of machines that take long to stop: their own setting, by which they also gather the speed they should not have."""


def turned_digit(text: bytes, chance: np.random.Generator) -> bytes:
    """One digit of the number turned over, so that it is another number."""
    indices = [index for index, byte in enumerate(text) if chr(byte).isdigit()]
    index = int(chance.choice(indices))
    other = (text[index] - 48 + int(chance.integers(1, 10))) % 10 + 48
    return text[:index] + bytes([other]) + text[index + 1 :]


def signed(text: bytes) -> bytes:
    return text.replace(b"-", b"+") if b"-" in text else b"-" + text.lstrip(b"+")


def other_axis(number: int) -> int:
    return 2 if number == 1 else 1


def _table(data: bytes, kind: str, chance: np.random.Generator) -> bytes | None:
    found = re.fullmatch(rb"(\d+) (MOVE|HOME)( [+-]?[\d.]+)?\r\n", data)
    if found is None:
        return None
    return _text(found, kind, chance, lambda axis, verb, value: axis + b" " + verb + value)


def _esp301(data: bytes, kind: str, chance: np.random.Generator) -> bytes | None:
    found = re.search(rb"(\d)(PA|OR) ?([+-]?[\d.]+)", data)
    if found is None:
        return None
    head, tail = data[: found.start()], data[found.end() :]
    is_value = found[2] == b"PA"
    if kind in ("value", "sign") and not is_value:
        return None
    changed = found[3]
    changed = turned_digit(changed, chance) if kind == "value" else signed(changed) if kind == "sign" else changed
    axis = b"%d" % other_axis(int(found[1])) if kind == "axis" else found[1]
    return head + axis + found[2] + changed + tail


def _text(
    found: "re.Match[bytes]", kind: str, chance: np.random.Generator, made: Callable[[bytes, bytes, bytes], bytes]
) -> bytes | None:
    axis, verb, value = found[1], found[2], found[3] or b""
    if kind in ("value", "sign"):
        if not value:
            return None
        number = value.strip()
        value = b" " + (turned_digit(number, chance) if kind == "value" else signed(number))
    if kind == "axis":
        axis = b"%d" % other_axis(int(axis))
    return made(axis, verb, value) + b"\r\n"


def _zaber(data: bytes, kind: str, chance: np.random.Generator) -> bytes | None:
    command = zaber.decode_command(data.rstrip(b"\r\n"))
    if command is None or not re.match(r"(move|home)", command.text):
        return None
    if kind == "axis":
        return zaber.encode_command(replace(command, device=other_axis(command.device)))
    verb, _, number = command.text.rpartition(" ")
    if kind == ANOTHER_VERB:
        velocity = round(float(chance.uniform(-FASTEST_DPS, FASTEST_DPS)) / MICROSTEP_DEG * VELOCITY_SCALE)
        return zaber.encode_command(replace(command, text=f"move vel {velocity}"))
    if kind in ("value", "sign"):
        if not verb:
            return None
        changed = turned_digit(number.encode(), chance) if kind == "value" else signed(number.encode())
        return zaber.encode_command(replace(command, text=f"{verb} {changed.decode()}"))
    return data


def _oriental(data: bytes, kind: str, chance: np.random.Generator) -> bytes | None:
    address = int.from_bytes(data[2:4], "big")
    is_home = address == oriental_az.INPUTS and value_at(data, 7) & oriental_az.ZHOME
    if data[1] != 0x10 or not (address == oriental_az.DIRECT_DATA or is_home):
        return None
    frame = bytearray(data[:-2])
    if kind == "axis":
        frame[0] = other_axis(frame[0])
    elif kind in ("value", "sign"):
        if is_home:
            return None
        words = [int.from_bytes(data[index : index + 2], "big") for index in range(7, len(data) - 2, 2)]
        operation = oriental_az.decode(words)
        name = "position" if operation.kind == oriental_az.ABSOLUTE else "speed_hz"
        value: int = getattr(operation, name)
        changed = -value if kind == "sign" else int(turned_digit(str(value).encode(), chance))
        words = list(oriental_az.encode(replace(operation, **{name: changed})))
        frame[7:] = b"".join(word.to_bytes(2, "big") for word in words)
    head = bytes(frame)
    return head + FramerRTU.compute_CRC(head).to_bytes(2, "big")


def value_at(data: bytes, index: int) -> int:
    return int.from_bytes(data[index : index + 4], "big")


def _maestro(data: bytes, kind: str, chance: np.random.Generator) -> bytes | None:
    if len(data) < 4 or data[-4] != maestro.SET_TARGET:
        return None
    channel, target = data[-3], maestro.value_of(data[-2], data[-1])
    middle = 6000
    if kind == "axis":
        channel = other_axis(channel)
    elif kind == "value":
        target = int(turned_digit(str(target).encode(), chance))
    elif kind == "sign":
        target = 2 * middle - target
    return data[:-4] + bytes([maestro.SET_TARGET, channel, *maestro.number(min(max(target, 0), 0x3FFF))])


ALTERED = {
    "indexing-table": _table,
    "esp301": _esp301,
    "maestro": _maestro,
    "oriental-az": _oriental,
    "zaber": _zaber,
}


@dataclass
class StruckLine:
    """The faults of a line on which the n-th command that moves something is struck."""

    driver: str
    kind: str
    number: int
    chance: np.random.Generator
    seen: int = 0
    struck: str = ""

    def on_write(self, data: bytes) -> tuple[Part, ...]:
        altered = ALTERED[self.driver](data, self.kind, self.chance)
        if altered is None or self.struck:
            return (Part(data),)
        self.seen += 1
        if self.seen <= self.number:
            return (Part(data),)
        self.struck = f"{self.kind}: {data!r} became {altered!r}"
        faults: dict[str, Fault] = {"doubled": duplicate(0.2), "swallowed": drop, "late": delay(LATE_S)}
        return faults[self.kind](data) if self.kind in faults else (Part(altered),)

    def on_read(self, data: bytes) -> tuple[Part, ...]:
        return (Part(data),)


class SampledClock(VirtualClock):
    """Virtual time in which somebody looks at every body, every 50 ms."""

    def __init__(self) -> None:
        super().__init__(datetime(2024, 3, 1, tzinfo=UTC))
        self.look: Callable[[float], None] = lambda _now_s: None

    def sleep(self, duration_s: float) -> None:
        left_s = duration_s
        while left_s > 0.0:
            slice_s = min(left_s, 0.05)
            super().sleep(slice_s)
            left_s -= slice_s
            self.look(self.monotonic_s())


@dataclass
class Story:
    """What a strike led to."""

    struck: str = ""
    error: str = ""
    outside_deg: float = 0.0
    """Farthest outside the corridor of what was asked for."""
    strayed_deg: float = 0.0
    """Farthest that the axis which nobody asked to move was from where it stood."""
    moved_after_deg: float = 0.0
    """How far anything moved a second after the command had ended, and later."""
    rest_deg: float = 0.0
    """Where the body stands when the command has ended."""
    corridor_deg: tuple[float, float] = (0.0, 0.0)
    allowed_deg: float = 0.0
    target_deg: float | None = None
    """Where the body must stand when the command has ended without an error."""


class Struck(LinkFaults, Protocol):
    """A line on which something is struck once."""

    kind: str
    struck: str
    """What became what; empty where nothing was struck."""


StrikeOn = Callable[[str, str, np.random.Generator], Struck]


def a_command(driver: str, kind: str, chance: np.random.Generator) -> Struck:
    """Strike the first command that moves something."""
    return StruckLine(driver, kind, 0, chance)


def strike(driver: str, task: str, kind: str, seed: int, on: StrikeOn = a_command) -> Story:
    """Let one command or reply of a task go wrong. ``task``: ``move``, ``home`` or ``rate``."""
    chance = np.random.default_rng(seed)
    changes: dict[str, object] = {"limits_deg": LIMITS_DEG, "speed_dps": SPEED_DPS}
    if driver == "indexing-table":
        changes["increment_deg"] = 1.0
    bench, clock = _sampled(motion_bench(driver, **changes))
    supervisor = Supervisor(clock)
    pitch, roll = (supervisor.supervise(bench.axes[name]) for name in ("pitch", "roll"))
    for axis in (pitch, roll):
        home_and_arrive(axis, clock, clock.sleep)
    start_deg = float(chance.integers(-60, 61))
    move_and_arrive(roll, float(chance.integers(20, 60)), clock, clock.sleep)
    move_and_arrive(pitch, start_deg, clock, clock.sleep)
    target_deg = float(chance.integers(-80, 81))
    line = on(driver, kind, chance)
    bench.stream._faults = line
    return _narrated(bench, clock, line, driver, pitch, roll, task, start_deg, target_deg, chance)


def _narrated(
    bench: MotionBench,
    clock: SampledClock,
    line: Struck,
    driver: str,
    pitch: SupervisedAxis,
    roll: SupervisedAxis,
    task: str,
    start_deg: float,
    target_deg: float,
    chance: np.random.Generator,
) -> Story:
    bodies = {name: bench.world.axes[name] for name in ("pitch", "roll")}
    roll_deg = bodies["roll"].table_deg(clock.monotonic_s())
    rate_dps = float(chance.uniform(2.0, SPEED_DPS)) * (1.0 if start_deg < target_deg else -1.0)
    low_deg, high_deg = sorted((start_deg, target_deg))
    seconds = abs(target_deg - start_deg) / abs(rate_dps)
    if task == "home":
        low_deg, high_deg = start_deg - HOME_DEG, start_deg + HOME_DEG
    story = Story(corridor_deg=(low_deg, high_deg), target_deg={"move": target_deg, "home": 0.0}.get(task))
    fastest_dps = SPEED_DPS if task != "rate" else 9.9 * abs(rate_dps)
    if line.kind == ANOTHER_VERB:
        fastest_dps = FASTEST_DPS
    story.allowed_deg = MARGIN_DEG + (DEAF_S if line.kind == "axis" else REACTION_S) * fastest_dps
    if deceleration_dps2 := DECELERATION_DPS2.get(driver):
        reached_dps = SPEED_DPS if task != "rate" else 1.5 * abs(rate_dps) + REACTION_S * deceleration_dps2
        story.allowed_deg += min(reached_dps, fastest_dps) ** 2 / (2.0 * deceleration_dps2)

    def look(now_s: float) -> None:
        here_deg = bodies["pitch"].table_deg(now_s)
        story.outside_deg = max(story.outside_deg, low_deg - here_deg, here_deg - high_deg)
        story.strayed_deg = max(story.strayed_deg, abs(bodies["roll"].table_deg(now_s) - roll_deg))

    clock.look = look
    try:
        if task == "move":
            move_and_arrive(pitch, target_deg, clock, clock.sleep)
        elif task == "home":
            home_and_arrive(pitch, clock, clock.sleep)
        else:
            _turn(pitch, rate_dps, seconds, clock)
    except RigError as error:
        story.error = f"{type(error).__name__}: {error}"
        stop_all({"pitch": pitch, "roll": roll}, clock)
    story.struck = line.struck
    clock.sleep(1.0)
    story.rest_deg = bodies["pitch"].table_deg(clock.monotonic_s())
    before = [body.table_deg(clock.monotonic_s()) for body in bodies.values()]
    clock.sleep(10.0)
    after = [body.table_deg(clock.monotonic_s()) for body in bodies.values()]
    story.moved_after_deg = max(abs(b - a) for a, b in zip(before, after, strict=True))
    return story


def _turn(axis: SupervisedAxis, rate_dps: float, seconds: float, clock: SampledClock) -> None:
    begun_s = clock.monotonic_s()
    try:
        axis.start_rate(rate_dps)  # type: ignore[attr-defined]
        while (left_s := begun_s + seconds - clock.monotonic_s()) > 0.0:
            clock.sleep(min(0.2, left_s))
            axis.turn_look(clock)  # type: ignore[attr-defined]
    finally:
        stop_all({axis.name: axis}, clock)


def _sampled(bench: MotionBench) -> tuple[MotionBench, SampledClock]:
    clock = SampledClock()
    bench.stream.clock = clock
    bench.clock = clock
    return bench, clock
