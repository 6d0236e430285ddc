"""A twin behind a line on which things go wrong, by the rules of :mod:`rig.description.fault_plan`.

It is a twin itself, so the same faults happen in memory, on a pseudo-terminal and on a TCP port. Bytes are changed by
:mod:`rig.link.faults`; a line that is gone raises LinkLost, which memory passes on and a port turns into a hang-up;
what happens to power and motion is done to the device and to the world.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from pymodbus.framer import FramerRTU

from rig.description.fault_plan import MOTION, FaultRule
from rig.errors import LinkLost
from rig.link import faults
from rig.link.faults import Fault, Part
from rig.link.memory import Way
from rig.twins.twin import Twin

LINE_AND_POWER = frozenset({"hang-up", "rename", "swap", "power-cycle"})


@runtime_checkable
class Powered(Protocol):
    """A twin that forgets something when its power fails."""

    def power_cycle(self, now_s: float) -> None: ...


class Motions(Protocol):
    """What can go wrong with a body: the world."""

    def stall(self, axis: str, for_s: float) -> None: ...

    def slip(self, axis: str, slip_deg: float, now_s: float, *, seen: bool) -> None: ...

    def lag(self, axis: str, lag_s: float) -> None: ...


class _Armed:
    """A rule and how often it has struck."""

    def __init__(self, name: str, rule: FaultRule, starts_s: float) -> None:
        self.name = name
        self.rule = rule
        self.struck = 0
        self.at_s = None if rule.at_s is None else starts_s + rule.at_s
        self.needs_no_piece = rule.kind in LINE_AND_POWER | MOTION and self.at_s is not None

    @property
    def is_spent(self) -> bool:
        most = 1 if self.at_s is not None else self.rule.most
        return most is not None and self.struck >= most

    def strikes(self, number: int, now_s: float, chance: np.random.Generator) -> bool:
        """Return whether the fault strikes at the piece ``number`` (from 1)."""
        rule = self.rule
        if rule.probability is not None:
            return bool(chance.random() < rule.probability) and not self.is_spent
        if self.is_spent:
            return False
        if self.at_s is not None:
            return now_s >= self.at_s
        return number in rule.nth if rule.nth is not None else rule.every is not None and number % rule.every == 0


class FaultyTwin:
    """A :class:`rig.twins.twin.Twin` around ``twin``, which carries the devices ``keys`` (``axes.pitch``).

    ``others`` finds the line that a swap names; ``tell`` is given one sentence for each fault that happens.
    """

    def __init__(
        self,
        twin: Twin,
        keys: Sequence[str],
        rules: Mapping[str, FaultRule],
        chance: np.random.Generator,
        motions: Motions,
        starts_s: float,
        others: Callable[[str], "FaultyTwin"],
        tell: Callable[[str], None],
    ) -> None:
        self.twin = twin
        self.name = " and ".join(keys)
        self._armed = [_Armed(name, rule, starts_s) for name, rule in rules.items()]
        self._chance = chance
        self._motions = motions
        self._starts_s = starts_s
        self._others = others
        self._tell = tell
        self._outbound, self._inbound = Way(), Way()
        self._pieces = {"question": 0, "reply": 0}
        self._question, self._reply = b"", b""
        self._away_until_s = self._dark_until_s = -math.inf

    def receive(self, data: bytes, now_s: float) -> None:
        self._let_time_pass(now_s)
        if now_s < self._dark_until_s:
            return
        self._question = data
        self._outbound.enter(self._befallen("question", data, now_s), now_s)
        self._deliver(now_s)

    def transmit(self, now_s: float) -> bytes:
        self._let_time_pass(now_s)
        self._deliver(now_s)
        data = self.twin.transmit(now_s)
        if now_s < self._dark_until_s:
            return b""
        if data:
            self._inbound.enter(self._befallen("reply", data, now_s), now_s)
            self._reply = data
        return b"".join(self._inbound.leave(now_s))

    def next_event_s(self) -> float | None:
        twin_s = self.twin.next_event_s()
        due_s = [due_s for way in (self._outbound, self._inbound) for due_s, _ in way.parts]
        due_s += [armed.at_s for armed in self._timed() if armed.at_s is not None]
        due_s += [until_s for until_s in (self._away_until_s,) if not math.isinf(until_s)]
        due_s += [] if twin_s is None else [twin_s]
        return min(due_s, default=None)

    def _deliver(self, now_s: float) -> None:
        for data in self._outbound.leave(now_s):
            self.twin.receive(data, now_s)

    def _timed(self) -> list[_Armed]:
        """Return the rules that strike at a moment, whether or not anybody talks."""
        return [armed for armed in self._armed if armed.needs_no_piece and not armed.is_spent]

    def _let_time_pass(self, now_s: float) -> None:
        """Let happen what is due by now. Raises: LinkLost while the line is gone."""
        for armed in self._timed():
            if armed.at_s is not None and now_s >= armed.at_s:
                self._strike(armed, f"at {armed.rule.at_s:g} s", now_s)
        self._require_line(now_s)
        self._away_until_s = -math.inf

    def _require_line(self, now_s: float) -> None:
        if now_s < self._away_until_s:
            raise LinkLost(
                f"twin of {self.name}: the line is gone, as the fault file says; what was sent last is in doubt;"
                " check cable and adapter"
            )

    def _befallen(self, on: str, data: bytes, now_s: float) -> tuple[Part, ...]:
        """Return what really travels of a piece. Raises: LinkLost where the line goes with it."""
        self._pieces[on] += 1
        number = self._pieces[on]
        parts: tuple[Part, ...] = (Part(data),)
        for armed in self._armed:
            if armed.needs_no_piece or armed.rule.on != on or not armed.strikes(number, now_s, self._chance):
                continue
            fault = self._strike(armed, f"{on} {number}", now_s)
            parts = tuple(_later(inner, part) for part in parts for inner in fault(part.data))
        self._require_line(now_s)
        return () if now_s < self._dark_until_s else parts

    def _strike(self, armed: _Armed, where: str, now_s: float) -> Fault:
        """Let a rule happen; returns what it does to the piece that it strikes."""
        armed.struck += 1
        self._tell(f"{now_s - self._starts_s:.3f} s: {self.name}: {armed.name}: {armed.rule.kind}, {where}")
        rule = armed.rule
        if rule.kind in MOTION:
            axis = rule.line.partition(".")[2]
            if rule.kind == "stall":
                self._motions.stall(axis, rule.for_s or 0.0)
            elif rule.kind == "slip":
                self._motions.slip(axis, rule.slip_deg or 0.0, now_s, seen=bool(rule.seen))
            else:
                self._motions.lag(axis, rule.lag_s or 0.0)
        elif rule.kind in LINE_AND_POWER:
            self._cut(rule, now_s if armed.at_s is None else armed.at_s, now_s)
        else:
            return self._change(rule)
        return faults.intact

    def _cut(self, rule: FaultRule, from_s: float, now_s: float) -> None:
        """Cut the line.

        ``from_s``: when it went; it may be noticed later only.
        """
        if rule.kind == "swap":
            other = self._others(rule.other or "")
            self.twin, other.twin = other.twin, self.twin
            return
        self._outbound, self._inbound = Way(), Way()
        until_s = math.inf if rule.away_s is None else from_s + rule.away_s
        if rule.kind != "power-cycle":
            self._away_until_s = until_s
            return
        self._dark_until_s = until_s
        self.twin.transmit(now_s)
        if isinstance(self.twin, Powered):
            self.twin.power_cycle(now_s)

    def _change(self, rule: FaultRule) -> Fault:
        delay_s, keep = rule.delay_s or 0.0, rule.keep or 0
        match rule.kind:
            case "drop":
                return faults.drop
            case "delay":
                return faults.delay(delay_s)
            case "freeze":
                return faults.stall(delay_s)
            case "duplicate":
                return faults.duplicate(delay_s)
            case "truncate":
                return faults.truncate(keep)
            case "split":
                return faults.split(keep, delay_s)
            case "flip-bit":
                return self._flip(rule)
            case "garble":
                return lambda data: (Part(self._chance.bytes(len(data))),)
            case "stale":
                return faults.prepend((rule.text or "").encode("latin-1"))
            case "echo":
                return faults.prepend(self._question)
            case "previous":
                return faults.replace(self._reply) if self._reply else faults.intact
            case _:
                return lambda data: (Part(modbus_exception(data, rule.code or 0)),)

    def _flip(self, rule: FaultRule) -> Fault:
        def flipped(data: bytes) -> tuple[Part, ...]:
            byte_index = int(self._chance.integers(len(data))) if rule.byte is None else rule.byte
            bit = int(self._chance.integers(8)) if rule.bit is None else rule.bit
            return (
                faults.flip_bit(byte_index, bit)(data) if -len(data) <= byte_index < len(data) else faults.intact(data)
            )

        return flipped


def modbus_exception(reply: bytes, code: int) -> bytes:
    """Return the exception frame in place of a reply, by RTU or TCP as the reply itself is framed."""
    is_tcp = len(reply) > 8 and reply[2:4] == b"\0\0" and int.from_bytes(reply[4:6], "big") == len(reply) - 6
    if is_tcp:
        return reply[:4] + b"\0\3" + bytes([reply[6], reply[7] | 0x80, code])
    head = bytes([reply[0], reply[1] | 0x80, code])
    return head + FramerRTU.compute_CRC(head).to_bytes(2, "big")


def _later(part: Part, outer: Part) -> Part:
    """Return a part of a part: delays add up."""
    return Part(part.data, part.delay_s + outer.delay_s, part.stalls or outer.stalls)
