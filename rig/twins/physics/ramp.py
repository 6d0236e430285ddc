"""How a body gets somewhere: paths over time, as motor controllers run them.

A :class:`Ramp` goes from a place and a speed to a place at rest with limited speed and acceleration, by the shortest
time. Units are the caller's (degrees, quarter-microseconds of a servo's pulse): everything here is per second.
"""

import math
from dataclasses import dataclass
from typing import Protocol


class Path(Protocol):
    """Where something is at any time."""

    @property
    def arrival_s(self) -> float:
        """When it comes to rest; infinite where it never does."""

    def at(self, now_s: float) -> float: ...

    def speed_at(self, now_s: float) -> float:
        """Return the signed speed, per second."""


@dataclass(frozen=True, slots=True)
class _Leg:
    """A piece of constant acceleration."""

    start_s: float
    position: float
    speed: float
    acceleration: float
    duration_s: float

    @property
    def end_s(self) -> float:
        return self.start_s + self.duration_s

    def at(self, now_s: float) -> float:
        after_s = now_s - self.start_s
        return self.position + self.speed * after_s + 0.5 * self.acceleration * after_s * after_s

    def speed_at(self, now_s: float) -> float:
        return self.speed + self.acceleration * (now_s - self.start_s)


class Ramp:
    """A :class:`Path` to ``target``, starting at ``start_s`` from ``position`` with ``speed`` (signed).

    ``top_speed`` infinite is a jump; ``acceleration`` infinite starts and stops at once.
    """

    def __init__(
        self,
        position: float,
        target: float,
        start_s: float,
        top_speed: float,
        *,
        speed: float = 0.0,
        acceleration: float = math.inf,
    ) -> None:
        self._target = target
        self._legs: list[_Leg] = []
        self._end_s = start_s
        self._run(position, target, top_speed, speed, acceleration)

    @property
    def arrival_s(self) -> float:
        return self._end_s

    def at(self, now_s: float) -> float:
        leg = self._leg(now_s)
        return self._target if leg is None else leg.at(now_s)

    def speed_at(self, now_s: float) -> float:
        leg = self._leg(now_s)
        return 0.0 if leg is None else leg.speed_at(now_s)

    def _run(self, position: float, target: float, top_speed: float, speed: float, acceleration: float) -> None:
        if math.isinf(acceleration):
            self._cruise(position, target, top_speed)
            return
        braking = 0.5 * speed * abs(speed) / acceleration
        if speed * (target - position) < 0.0 or abs(braking) > abs(target - position):
            position = self._add(position, speed, -math.copysign(acceleration, speed), abs(speed) / acceleration)
            speed = 0.0
        ahead = math.copysign(1.0, target - position)
        start = abs(speed)
        peak = min(max(top_speed, start), math.sqrt(acceleration * abs(target - position) + 0.5 * start * start))
        position = self._add(position, speed, ahead * acceleration, (peak - start) / acceleration)
        to_brake = 0.5 * peak * peak / acceleration
        if peak > 0.0:
            position = self._add(position, ahead * peak, 0.0, max(abs(target - position) - to_brake, 0.0) / peak)
        self._add(position, ahead * peak, -ahead * acceleration, peak / acceleration)

    def _cruise(self, position: float, target: float, top_speed: float) -> None:
        distance = target - position
        if distance and not math.isinf(top_speed):
            self._add(position, math.copysign(top_speed, distance), 0.0, abs(distance) / top_speed)

    def _add(self, position: float, speed: float, acceleration: float, duration_s: float) -> float:
        """Append a leg; returns where it ends."""
        leg = _Leg(self._end_s, position, speed, acceleration, duration_s)
        if duration_s > 0.0:
            self._legs.append(leg)
            self._end_s = leg.end_s
        return leg.at(self._end_s) if duration_s > 0.0 else position

    def _leg(self, now_s: float) -> _Leg | None:
        if not self._legs or now_s >= self._end_s:
            return None
        return next(leg for leg in self._legs if now_s < leg.end_s)


class Spin:
    """A :class:`Path` that goes on for ever at ``rate``, reached from ``speed`` at ``acceleration``."""

    arrival_s = math.inf

    def __init__(
        self, position: float, rate: float, start_s: float, *, speed: float = 0.0, acceleration: float = math.inf
    ) -> None:
        change = 0.0 if math.isinf(acceleration) else (rate - speed) / acceleration
        self._ramp = _Leg(start_s, position, speed, math.copysign(acceleration, change) if change else 0.0, abs(change))
        self._cruise = _Leg(self._ramp.end_s, self._ramp.at(self._ramp.end_s), rate, 0.0, math.inf)

    def at(self, now_s: float) -> float:
        return self._leg(now_s).at(now_s)

    def speed_at(self, now_s: float) -> float:
        return self._leg(now_s).speed_at(now_s)

    def _leg(self, now_s: float) -> _Leg:
        return self._ramp if now_s < self._ramp.end_s else self._cruise


class Runaway:
    """A :class:`Path` that leaves another at ``from_s`` and gets faster and faster, the same way round."""

    arrival_s = math.inf

    def __init__(self, path: Path, from_s: float, acceleration: float) -> None:
        self._path = path
        speed = path.speed_at(from_s)
        self._away = _Leg(from_s, path.at(from_s), speed, math.copysign(acceleration, speed), math.inf)

    def at(self, now_s: float) -> float:
        return self._leg(now_s).at(now_s)

    def speed_at(self, now_s: float) -> float:
        return self._leg(now_s).speed_at(now_s)

    def _leg(self, now_s: float) -> Path | _Leg:
        return self._path if now_s < self._away.start_s else self._away
