"""Twin of a Pololu Maestro: pulses that follow speed and acceleration limits, errors that send every servo home.

Positions are quarter-microseconds of pulse, 0 is no pulse. The Micro answers Get Moving State with 0 even while a
servo moves, as its makers warn.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from rig.twins.physics.ramp import Path, Ramp
from rig.twins.physics.world import World
from rig.wire import maestro as wire
from rig.wire.maestro import Errors, Request
from rig.wire.maestro_reader import MaestroReader, MiniSsc
from rig.wire.pulses import PulseCalibration

_CHANNELS = {"micro": 6, "mini": 12}
_NEUTRAL_SSC, _RANGE_SSC = 127, 4 * 476.25
_ACCELERATION_UNITS = 8


@dataclass(frozen=True, slots=True)
class ChannelSettings:
    """Of the controller's own memory, in quarter-microseconds."""

    low: int = 4 * 992
    high: int = 4 * 2000
    home: int = 6000
    """Where an error sends the servo; 0 switches its pulses off."""


class PulsePath:
    """The table angle that a pulse's path makes: a :class:`rig.twins.physics.ramp.Path`."""

    def __init__(self, pulses: Ramp, calibration: PulseCalibration) -> None:
        self._pulses = pulses
        self._calibration = calibration

    @property
    def arrival_s(self) -> float:
        return self._pulses.arrival_s

    def at(self, now_s: float) -> float:
        return self._calibration.angle_deg(self._pulses.at(now_s) / wire.QUARTERS_PER_US)

    def speed_at(self, now_s: float) -> float:
        pulse_us = self._pulses.at(now_s) / wire.QUARTERS_PER_US
        return self._calibration.deg_per_us(pulse_us) * self._pulses.speed_at(now_s) / wire.QUARTERS_PER_US


class ServoChannel:
    """One output: its pulse over time. ``servo``: the world's body and what its pulses really mean."""

    def __init__(
        self, settings: ChannelSettings, unit_s: float, world: World, servo: tuple[str, PulseCalibration] | None
    ) -> None:
        self.settings = settings
        self.speed = self.acceleration = 0
        self._unit_s = unit_s
        self._world = world
        self._servo = servo
        self._pulses: Ramp | None = None
        self._target = 0

    def position(self, now_s: float) -> int:
        return 0 if self._pulses is None else round(self._pulses.at(now_s))

    def is_moving(self, now_s: float) -> bool:
        return self._pulses is not None and now_s < self._pulses.arrival_s

    def aim(self, target: int, now_s: float) -> None:
        """Set a new target, brought inside the channel's own limits; 0 switches the pulses off."""
        if target == 0:
            if self._pulses is not None:
                position = self._pulses.at(now_s)
                self._follow(Ramp(position, position, now_s, math.inf))
            self._pulses = None
            return
        self._target = target
        aimed = min(max(target, self.settings.low), self.settings.high)
        here = self._pulses
        self._pulses = Ramp(
            aimed if here is None else here.at(now_s),
            aimed,
            now_s,
            self.speed / self._unit_s if self.speed else math.inf,
            speed=0.0 if here is None else here.speed_at(now_s),
            acceleration=self.acceleration / self._unit_s / (_ACCELERATION_UNITS * self._unit_s)
            if self.acceleration
            else math.inf,
        )
        self._follow(self._pulses)

    def limit_speed(self, speed: int, now_s: float) -> None:
        """Limit how fast the output changes (page 57), also of one that is on its way."""
        self.speed = speed
        if self._pulses is not None and self.is_moving(now_s):
            self.aim(self._target, now_s)

    def limit_acceleration(self, acceleration: int, now_s: float) -> None:
        """Limit how fast the speed changes (page 57), also of one that is on its way, which no page says or denies."""
        self.acceleration = acceleration
        if self._pulses is not None and self.is_moving(now_s):
            self.aim(self._target, now_s)

    def _follow(self, pulses: Ramp) -> None:
        if self._servo is not None:
            name, calibration = self._servo
            path: Path = PulsePath(pulses, calibration)
            self._world.follow(name, path)


class MaestroTwin:
    """A :class:`rig.twins.twin.Twin`. ``servos``: channels to the world's bodies and their true calibrations."""

    def __init__(
        self,
        servos: Mapping[int, tuple[str, PulseCalibration]],
        world: World,
        *,
        model: str = "micro",
        device: int = wire.DEFAULT_DEVICE,
        has_crc: bool = False,
        period_ms: int = 20,
        settings: ChannelSettings | None = None,
        detects_baud: bool = False,
        timeout_s: float | None = None,
    ) -> None:
        """Make the controller; ``timeout_s``: its serial time-out; a new controller has none."""
        count = max([_CHANNELS[model], *(channel + 1 for channel in servos)])
        unit_s = wire.unit_s(period_ms)
        self.channels = [
            ServoChannel(settings or ChannelSettings(), unit_s, world, servos.get(channel)) for channel in range(count)
        ]
        self.is_script_running = False
        self._model = model
        self._errors = Errors(0)
        self._reader = MaestroReader(device=device, has_crc=has_crc, is_mini=model == "mini")
        self._detects_baud = self._waits_for_start = detects_baud
        self._timeout_s = timeout_s
        self._heard_s = math.inf
        """When the last valid command came; infinite where none is waited for."""
        self._due = b""

    def receive(self, data: bytes, now_s: float) -> None:
        self._look(now_s)
        if self._waits_for_start:
            _, start, rest = data.partition(bytes([wire.START]))
            self._waits_for_start = not start
            data = start + rest  # it is the first byte of a command as well
        for heard in self._reader.take(data):
            if isinstance(heard, Errors):
                self.fail(heard, now_s)
            elif isinstance(heard, MiniSsc):
                self._aim(heard.servo, round(6000 + (heard.target - _NEUTRAL_SSC) * _RANGE_SSC / 127.0), now_s)
            else:
                self._obey(heard, now_s)

    def transmit(self, now_s: float) -> bytes:
        self._look(now_s)
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        gives_up_s = self._gives_up_s
        return None if math.isinf(gives_up_s) else gives_up_s

    @property
    def _gives_up_s(self) -> float:
        """When the silence of its host is an error."""
        return math.inf if self._timeout_s is None else self._heard_s + self._timeout_s

    def _look(self, now_s: float) -> None:
        if now_s >= (silent_s := self._gives_up_s):
            self._heard_s = math.inf
            self.fail(Errors.TIMEOUT, silent_s)

    def power_cycle(self, now_s: float) -> None:
        """Lose power and get it back: no pulses, no limits of speed, no errors."""
        self._errors = Errors(0)
        self._waits_for_start = self._detects_baud
        for channel in self.channels:
            channel.speed = channel.acceleration = 0
            channel.aim(0, now_s)

    def fail(self, errors: Errors, now_s: float) -> None:
        """Raise error bits: every servo goes to its home."""
        self._errors |= errors
        self._go_home(now_s)

    def _obey(self, request: Request, now_s: float) -> None:
        self._heard_s = now_s
        data = request.data
        match request.command:
            case wire.SET_TARGET:
                self._aim(data[0], wire.value_of(data[1], data[2]), now_s)
            case wire.SET_MULTIPLE_TARGETS:
                for index in range(data[0]):
                    self._aim(data[1] + index, wire.value_of(*data[2 + 2 * index : 4 + 2 * index]), now_s)
            case wire.SET_SPEED | wire.SET_ACCELERATION:
                self._limit(request.command, data, now_s)
            case wire.GET_POSITION:
                channel = self._channel(data[0], now_s)
                self._due += b"" if channel is None else wire.encode_word(channel.position(now_s))
            case wire.GET_MOVING_STATE:
                moves = self._model == "mini" and any(channel.is_moving(now_s) for channel in self.channels)
                self._due += bytes([moves])
            case wire.GET_ERRORS:
                self._due += wire.encode_word(self._errors)
                self._errors = Errors(0)
            case wire.GO_HOME:
                self._go_home(now_s)
            case wire.GET_SCRIPT_STATUS:
                self._due += bytes([not self.is_script_running])
            case wire.STOP_SCRIPT | wire.RESTART_SCRIPT | wire.RESTART_SCRIPT_WITH:
                self.is_script_running = request.command != wire.STOP_SCRIPT

    def _aim(self, channel: int, target: int, now_s: float) -> None:
        output = self._channel(channel, now_s)
        if output is not None:
            output.aim(target, now_s)

    def _limit(self, command: int, data: tuple[int, ...], now_s: float) -> None:
        output = self._channel(data[0], now_s)
        if output is None:
            return
        if command == wire.SET_SPEED:
            output.limit_speed(wire.value_of(data[1], data[2]), now_s)
        else:
            output.limit_acceleration(wire.value_of(data[1], data[2]), now_s)

    def _channel(self, number: int, now_s: float) -> ServoChannel | None:
        """Return a channel; None, and a protocol error, where there is none of that number."""
        if number < len(self.channels):
            return self.channels[number]
        self.fail(Errors.PROTOCOL, now_s)
        return None

    def _go_home(self, now_s: float) -> None:
        for channel in self.channels:
            channel.aim(channel.settings.home, now_s)
