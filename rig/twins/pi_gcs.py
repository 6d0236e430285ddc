"""Twin of a GCS 2.0 controller with rotary stages: silent commands, one error kept, single bytes between the lines.

It comes up with servos off and without a reference. Source: docs/devices/pi-gcs.md; the forms of ``*IDN?`` and of the
unit are remembered there, and the error of a refused ``POS`` or ``FRF`` is an assumption.
"""

from collections.abc import Mapping

from rig.twins.physics.servo_axis import ServoAxis
from rig.twins.physics.world import World
from rig.wire import pi_gcs as wire

IDENTITY = b"(c)2013 Physik Instrumente(PI) Karlsruhe, C-863.11,0115500620,1.2.1.0"
TRAVEL_DEG, TOP_SPEED_DPS = (-100_000.0, 100_000.0), 720.0
SYNTAX, INVALID_AXIS = 1, 15
_READY = b"\xb1"
_LONGEST_LINE = 256


class PiStage:
    """One axis with its stage."""

    def __init__(self, servo: ServoAxis) -> None:
        self.servo = servo
        self.has_servo = False
        self.unit = "DEG"
        self.zero_deg = 0.0
        """Where ``DFH`` put the zero; referencing and a restart put it back."""
        self.preset_deg = 0.0
        """By how much the place that ``POS`` called an angle is another one; referencing puts it back."""
        self.finds_reference = True
        """``RON``: false, it is told its position by ``POS`` and refuses a reference move."""

    def power_cycle(self, now_s: float) -> None:
        self.zero_deg = self.preset_deg = 0.0
        self.finds_reference = True
        self.has_servo = False
        self.servo.power_cycle(now_s)


class PiGcsTwin:
    """A :class:`rig.twins.twin.Twin`. ``bodies``: place in its list, from 1, to a name there and the world's axis."""

    def __init__(self, bodies: Mapping[int, tuple[str, str]], world: World) -> None:
        self.stages = {name: PiStage(ServoAxis(world.axes[body], world)) for name, body in bodies.values()}
        self._index_of = {name: index for index, (name, _) in bodies.items()}
        self.error = wire.NO_ERROR
        self._received = self._due = b""

    def receive(self, data: bytes, now_s: float) -> None:
        for byte in (data[index : index + 1] for index in range(len(data))):
            if byte == b"\n":
                line, self._received = self._received, b""
                self._take(line.decode("latin-1").strip(), now_s)
            elif byte[0] < 32 and byte != b"\r":
                if byte == wire.MOVING:
                    moving = (s.servo.is_moving(now_s) << (self._index_of[name] - 1) for name, s in self.stages.items())
                    self._due += b"%X\n" % sum(moving)
                elif byte == b"\x07":
                    self._due += _READY + b"\n"
                elif byte == wire.STOP:
                    self._stop_all(now_s)
            else:
                self._received = (self._received + byte)[-_LONGEST_LINE:]

    def transmit(self, now_s: float) -> bytes:  # noqa: ARG002 it answers at once
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return None

    def power_cycle(self, now_s: float) -> None:
        for stage in self.stages.values():
            stage.power_cycle(now_s)

    def _stop_all(self, now_s: float) -> None:
        for stage in self.stages.values():
            stage.servo.stop(now_s)
        self.error = wire.STOPPED

    def _take(self, line: str, now_s: float) -> None:
        match line.split():
            case []:
                return
            case ["*IDN?"]:
                self._due += IDENTITY + b"\n"
            case ["ERR?"]:
                self._due += b"%d\n" % self.error
                self.error = wire.NO_ERROR
            case ["SAI?"] | ["SAI?", "ALL"]:
                self._due += " \n".join(self.stages).encode("ascii") + b"\n"
            case ["STP"]:
                self._stop_all(now_s)
            case [word, *axes] if word.endswith("?"):
                self._query(word, axes, now_s)
            case [word, axis, *values]:
                self.error = self._obey(word, axis, values, now_s) or self.error
            case _:
                self.error = wire.UNKNOWN_COMMAND

    def _query(self, word: str, axes: list[str], now_s: float) -> None:
        parameter = axes.pop() if word == "SPA?" and len(axes) == 2 else ""
        chosen = axes or list(self.stages)
        if not set(chosen) <= self.stages.keys():
            self.error = INVALID_AXIS
            return
        values = [self._value(word, self.stages[name], parameter, now_s) for name in chosen]
        if None in values:
            self.error = wire.UNKNOWN_COMMAND
            return
        where = f" {parameter}" if parameter else ""
        lines = " \n".join(f"{name}{where}={value}" for name, value in zip(chosen, values, strict=True))
        self._due += lines.encode("ascii") + b"\n"

    def _value(self, word: str, stage: PiStage, parameter: str, now_s: float) -> str | None:
        servo = stage.servo
        table = {
            "POS?": wire.format_number(servo.position_deg(now_s) - stage.preset_deg - stage.zero_deg),
            "DFH?": wire.format_number(stage.zero_deg),
            "VEL?": wire.format_number(servo.speed_dps),
            "TMN?": wire.format_number(TRAVEL_DEG[0]),
            "TMX?": wire.format_number(TRAVEL_DEG[1]),
            "SVO?": f"{stage.has_servo:d}",
            "RON?": f"{stage.finds_reference:d}",
            "FRF?": f"{servo.is_homed(now_s):d}",
            "ONT?": f"{stage.has_servo and not servo.is_moving(now_s):d}",
        }
        if word == "SPA?":
            return stage.unit if parameter.lower() in (f"0x{wire.UNIT:x}", str(wire.UNIT)) else None
        return table.get(word)

    def _obey(self, word: str, axis: str, values: list[str], now_s: float) -> int:
        """Obey a command of one axis; return its error, 0 for none."""
        stage = self.stages.get(axis)
        if stage is None:
            return INVALID_AXIS
        try:
            number = float(values[0]) if values else 0.0
        except ValueError:
            return SYNTAX
        match word:
            case "SVO":
                stage.has_servo = bool(number)
                if not stage.has_servo:
                    stage.servo.stop(now_s)
            case "VEL":
                if not 0.0 < number <= TOP_SPEED_DPS:
                    return wire.VELOCITY
                stage.servo.speed_dps = number
            case "FRF" | "FNL" | "FPL":
                if not (stage.has_servo and stage.finds_reference):
                    return wire.NOT_REFERENCED
                stage.zero_deg = stage.preset_deg = 0.0
                stage.servo.home(now_s)
            case "DFH":
                stage.zero_deg = stage.servo.position_deg(now_s) - stage.preset_deg
            case "RON":
                stage.finds_reference = bool(number)
            case "POS":
                if stage.finds_reference:
                    return wire.NOT_REFERENCED
                stage.preset_deg = stage.servo.position_deg(now_s) - stage.zero_deg - number
            case "MOV":
                if not (stage.has_servo and stage.servo.is_homed(now_s)):
                    return wire.NOT_REFERENCED
                if not TRAVEL_DEG[0] <= number <= TRAVEL_DEG[1]:
                    return wire.OUT_OF_LIMITS
                stage.servo.move(number + stage.zero_deg + stage.preset_deg, now_s)
                return wire.NO_ERROR
            case _:
                return wire.UNKNOWN_COMMAND
        return wire.NO_ERROR
