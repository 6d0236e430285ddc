"""The control address: how an engine in another process tells the twins which step it is measuring.

JSON lines: ``{"announce": [step, phase, attempt, replications]}`` is answered by ``{"ok": true}`` once the twins know,
anything else by ``{"ok": false, "error": …}``. It carries nothing but this, and only twins have one.
"""

import json
import math
from typing import Protocol

from rig.errors import DeviceNonsense, DeviceSilent
from rig.link.byte_stream import ByteStream

_LONGEST_LINE = 4096
_TIMEOUT_S = 5.0


class Announced(Protocol):
    """Whoever wants to know: the world."""

    def announce(self, step: int, phase: str, attempt: int, replications: float) -> None: ...


class ControlTwin:
    """The twins' side: a :class:`rig.twins.twin.Twin` that passes announcements on."""

    def __init__(self, chance: Announced) -> None:
        self._chance = chance
        self._received = b""
        self._due = b""

    def receive(self, data: bytes, now_s: float) -> None:  # noqa: ARG002 an announcement has no time
        *lines, rest = (self._received + data).split(b"\n")
        self._received = rest[-_LONGEST_LINE:]
        for line in lines:
            self._due += json.dumps(self._obey(line)).encode() + b"\n"

    def transmit(self, now_s: float) -> bytes:  # noqa: ARG002 it answers at once
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return None

    def _obey(self, line: bytes) -> dict[str, object]:
        announced = _announcement(line)
        if announced is None:
            return {"ok": False, "error": 'expected {"announce": [step, phase, attempt, replications]}'}
        self._chance.announce(*announced)
        return {"ok": True}


class RemoteChance:
    """The engine's side: announces to twins behind ``stream`` and returns when they know.

    A :class:`rig.abilities.abilities.TwinChance`.
    """

    def __init__(self, stream: ByteStream) -> None:
        self._stream = stream

    def announce(self, step: int, phase: str, attempt: int, replications: float) -> None:
        self._stream.write(json.dumps({"announce": [step, phase, attempt, replications]}).encode() + b"\n")
        deadline_s = self._stream.clock.monotonic_s() + _TIMEOUT_S
        reply = b""
        while not reply.endswith(b"\n"):
            more = self._stream.read(deadline_s)
            if not more:
                raise DeviceSilent(
                    f"{self._stream.name}: the twins did not acknowledge step {step} within {_TIMEOUT_S:g} s;"
                    " nothing was measured; see whether `calrig simulate` still runs"
                )
            reply += more
        if reply != b'{"ok": true}\n':
            raise DeviceNonsense(
                f"{self._stream.name}: the twins answered {reply[:80]!r} to step {step}; nothing was measured;"
                " check that twin.control is the address that `calrig simulate` printed"
            )


def _announcement(line: bytes) -> tuple[int, str, int, float] | None:
    try:
        message = json.loads(line)
    except ValueError:
        return None
    values = message.get("announce") if isinstance(message, dict) and len(message) == 1 else None
    if not isinstance(values, list) or len(values) != 4:
        return None
    step, phase, attempt, replications = values
    whole = all(isinstance(number, int) and not isinstance(number, bool) for number in (step, attempt))
    real = isinstance(replications, int | float) and not isinstance(replications, bool) and math.isfinite(replications)
    return (step, phase, attempt, float(replications)) if whole and isinstance(phase, str) and real else None
