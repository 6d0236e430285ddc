"""Twin of rotary Zaber stages on one chain: the ASCII protocol with ids, checksums, alerts and warnings.

It comes up without a reference (WR). Commands it does not know it rejects by name; a line with a wrong checksum it
does not answer.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from rig.twins.physics.servo_axis import ServoAxis
from rig.twins.physics.world import World
from rig.wire import zaber as wire
from rig.wire.zaber import Command, Reply

_LONGEST_LINE = 256
_TRAVEL_DEG = 100_000.0
BAD_COMMAND, BAD_DATA, BAD_AXIS = "BADCOMMAND", "BADDATA", "BADAXIS"


@dataclass(frozen=True, slots=True)
class Stage:
    """What a data sheet says."""

    microstep_deg: float
    velocity_scale: float = 1.6384
    device_id: int = 50952
    serial: int = 12345
    firmware: str = "7.38"


class ZaberStage:
    """One device with one axis."""

    def __init__(self, servo: ServoAxis, stage: Stage) -> None:
        self.servo = servo
        self._stage = stage
        self._is_interrupted = False
        self.latched: set[str] = set()
        """Flags that stay until ``warnings clear``, such as FS behind a stall."""
        reach = round(_TRAVEL_DEG / stage.microstep_deg)
        self.settings = {
            "deviceid": stage.device_id,
            "system.serial": stage.serial,
            "version.build": 1,
            "device.hw.modified": 0,
            "system.axiscount": 1,
            "comm.command.packets.max": 1,
            "comm.word.size.max": 50,
            "get.settings.max": 8,
            "comm.checksum": 1,
            "comm.alert": 0,
            "limit.min": -reach,
            "limit.max": reach,
            "limit.home.preset": 0,
            "limit.cycle.dist": round(360.0 / stage.microstep_deg),
            "maxspeed": self._data(servo.speed_dps),
        }

    def status(self, now_s: float) -> tuple[bool, str]:
        """Return whether it is busy, and the warning of the highest priority."""
        return self.servo.is_moving(now_s), next(iter(self._warnings(now_s)), wire.NO_WARNING)

    def act(self, text: str, now_s: float) -> tuple[bool, str]:
        """Act on a command; return whether it was accepted, and the reply's data."""
        words = text.split()
        match words:
            case []:
                return True, "0"
            case ["get", name]:
                return self._get(name, now_s)
            case ["set", name, value]:
                return self._set(name, value)
            case ["home"] | ["move", "home"]:
                self._is_interrupted = False
                self.servo.home(now_s, self.settings["limit.home.preset"] * self._stage.microstep_deg)
            case ["stop"] | ["estop"]:
                self._is_interrupted = self.servo.is_moving(now_s)
                self.servo.stop(now_s)
            case ["move", ("abs" | "rel" | "vel") as kind, value]:
                return self._move(kind, value, now_s)
            case ["warnings"] | ["warnings", "clear"]:
                warnings = self._warnings(now_s)
                if len(words) == 2:
                    self._is_interrupted = False
                    self.latched.clear()
                return True, " ".join([f"{len(warnings):02d}", *warnings])
            case ["tools", "echo", *echoed]:
                return True, " ".join(echoed) or "0"
            case _:
                return False, BAD_COMMAND
        return True, "0"

    def power_cycle(self, now_s: float) -> None:
        self.servo.power_cycle(now_s)

    def _warnings(self, now_s: float) -> list[str]:
        flags = [*sorted(self.latched), *([] if self.servo.is_homed(now_s) else ["WR"])]
        return [*flags, wire.INTERRUPTED] if self._is_interrupted else flags

    def _get(self, name: str, now_s: float) -> tuple[bool, str]:
        if name in ("pos", "encoder.pos"):
            return True, str(round(self.servo.position_deg(now_s) / self._stage.microstep_deg))
        if name == "limit.home.triggered":
            return True, str(int(self.servo.is_homed(now_s)))
        if name == "version":
            return True, self._stage.firmware
        return (True, str(self.settings[name])) if name in self.settings else (False, BAD_COMMAND)

    def _set(self, name: str, value: str) -> tuple[bool, str]:
        number = wire.decode_integer(value)
        if name not in self.settings or number is None:
            return False, BAD_COMMAND if name not in self.settings else BAD_DATA
        if name == "maxspeed":
            if number < 1:
                return False, BAD_DATA
            self.servo.speed_dps = number / self._stage.velocity_scale * self._stage.microstep_deg
        self.settings[name] = number
        return True, "0"

    def _move(self, kind: str, value: str, now_s: float) -> tuple[bool, str]:
        number = wire.decode_integer(value)
        if number is None:
            return False, BAD_DATA
        if kind == "vel":
            if abs(number) > self._data(10_000.0):
                return False, BAD_DATA
            self._is_interrupted = self.servo.is_moving(now_s)
            if number:
                self.servo.spin(number / self._stage.velocity_scale * self._stage.microstep_deg, now_s)
            else:
                self.servo.stop(now_s)
            return True, "0"
        if kind == "rel":
            number += round(self.servo.position_deg(now_s) / self._stage.microstep_deg)
        if not self.settings["limit.min"] <= number <= self.settings["limit.max"]:
            return False, BAD_DATA
        self._is_interrupted = self.servo.is_moving(now_s)
        self.servo.move(number * self._stage.microstep_deg, now_s)
        return True, "0"

    def _data(self, rate_dps: float) -> int:
        return round(rate_dps / self._stage.microstep_deg * self._stage.velocity_scale)


class ZaberTwin:
    """A :class:`rig.twins.twin.Twin`. ``stages``: device and axis to the world's bodies and what each stage is."""

    def __init__(self, stages: Mapping[tuple[int, ...], tuple[str, Stage]], world: World) -> None:
        self.axes = {
            axis_number: ZaberStage(ServoAxis(world.axes[name], world), stage)
            for axis_number, (name, stage) in stages.items()
        }
        self.stages: dict[int, ZaberStage] = {}
        """The first axis of every device: it answers for the whole."""
        for (device, _), stage in self.axes.items():
            self.stages.setdefault(device, stage)
            stage.settings["system.axiscount"] = sum(device == other for other, _ in self.axes)
        self._received = b""
        self._due = b""

    def receive(self, data: bytes, now_s: float) -> None:
        *lines, rest = (self._received + data).replace(b"\r", b"\n").split(b"\n")
        self._received = rest[-_LONGEST_LINE:]
        for line in lines:
            command = wire.decode_command(line)
            if command is not None:
                for number, stage in self.stages.items():
                    if command.device in (0, number):
                        self._due += wire.encode_reply(self._reply(number, stage, command, now_s))

    def transmit(self, now_s: float) -> bytes:  # noqa: ARG002 it answers at once
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return None

    def power_cycle(self, now_s: float) -> None:
        for stage in self.axes.values():
            stage.power_cycle(now_s)

    def say(self, line: bytes) -> None:
        """Say an alert or info line of its own accord, without terminator."""
        self._due += line + wire.TERMINATOR

    def _reply(self, number: int, stage: ZaberStage, command: Command, now_s: float) -> Reply:
        if command.axis and (number, command.axis) not in self.axes:
            accepted, data = False, BAD_AXIS
        else:
            stage = self.axes.get((number, command.axis), stage)
            accepted, data = stage.act(command.text, now_s)
        is_busy, warning = stage.status(now_s)
        has_checksum = bool(stage.settings["comm.checksum"])
        return Reply(number, command.axis, accepted, is_busy, warning, data, command.message_id, has_checksum)
