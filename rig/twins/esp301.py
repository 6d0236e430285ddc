"""Twin of a Newport ESP301: silent commands, an error queue of ten, motors that are off until told.

It knows the commands that position an axis; every other is error 6, as on the controller.
"""

from collections import deque
from collections.abc import Callable, Mapping

from rig.twins.physics.servo_axis import ServoAxis
from rig.twins.physics.world import World
from rig.wire import esp301 as wire
from rig.wire.esp301 import Command, ErrorRecord

NO_HARDWARE_SIGNAL = "0H, 0H"
"""``PH``: two hexadecimal words."""
_LONGEST_LINE = 256
_TEXTS = {
    0: "NO ERROR DETECTED",
    wire.COMMAND_UNKNOWN: "COMMAND DOES NOT EXIST",
    wire.OUT_OF_RANGE: "PARAMETER OUT OF RANGE",
    wire.AXIS_OUT_OF_RANGE: "AXIS NUMBER OUT OF RANGE",
    wire.AXIS_MISSING: "AXIS NUMBER MISSING",
    wire.PARAMETER_MISSING: "COMMAND PARAMETER MISSING",
}
_AXIS_TEXTS = {
    wire.SOFTWARE_LIMITS[0]: "POSITIVE SOFTWARE LIMIT DETECTED",
    wire.SOFTWARE_LIMITS[1]: "NEGATIVE SOFTWARE LIMIT DETECTED",
    wire.MOTOR_OFF: "MOTOR NOT ENABLED",
    wire.HOMING_ABORTED: "HOMING ABORTED",
}
STAGE, TOP_RATE_DPS, RESOLUTION_DEG = "TS50DC.5, SN1263", 80.0, 0.001
"""What every stage here is: its name as the manual prints one, and what its memory says."""
_SEARCH_MODES = range(7)
_UNITS = range(11)


class Esp301Axis:
    """One axis: its motor, its software limits, its servo. Commands return the error they make, 0 for none."""

    def __init__(self, number: int, servo: ServoAxis, travel_deg: tuple[float, float]) -> None:
        self.servo = servo
        self.low_deg, self.high_deg = travel_deg
        self.unit = wire.DEGREES
        self.is_on = False
        self.resolution_deg = RESOLUTION_DEG
        self.preset_deg = 0.0
        """``SH``: what the counter becomes where a search ends."""
        self._home_deg = 0.0
        """Where ``DH`` put the zero."""
        self._number = number

    def answer(self, command: Command, now_s: float) -> str | None:
        """Answer a question about this axis; None where it is no question."""
        is_question = command.value == "?" or (command.letters in ("TP", "DP", "MD", "TV", "PH") and not command.value)
        answers: Mapping[str, Callable[[], str]] = {
            "TP": lambda: f"{self.position_deg(now_s):.{wire.DECIMALS}f}",
            "DP": lambda: f"{self.position_deg(now_s):.{wire.DECIMALS}f}",
            "TV": lambda: f"{self.servo.rate_dps(now_s):.{wire.DECIMALS}f}",
            "VU": lambda: f"{TOP_RATE_DPS:.{wire.DECIMALS}f}",
            "SU": lambda: f"{self.resolution_deg:.11f}",
            "ID": lambda: STAGE,
            "QM": lambda: "1",
            "ZH": lambda: "24H",
            "PH": lambda: NO_HARDWARE_SIGNAL,
            "MD": lambda: str(int(not self.servo.is_moving(now_s))),
            "MO": lambda: str(int(self.is_on)),
            "VA": lambda: f"{self.servo.speed_dps:.{wire.DECIMALS}f}",
            "AC": lambda: f"{self.servo.acceleration_dps2:.{wire.DECIMALS}f}",
            "SL": lambda: f"{self.low_deg:.{wire.DECIMALS}f}",
            "SR": lambda: f"{self.high_deg:.{wire.DECIMALS}f}",
            "SN": lambda: str(self.unit),
            "SH": lambda: f"{self.preset_deg:.{wire.DECIMALS}f}",
        }
        return answers[command.letters]() if is_question and command.letters in answers else None

    def position_deg(self, now_s: float) -> float:
        return self.servo.position_deg(now_s) - self._home_deg

    def define_home(self, now_s: float) -> int:
        self._home_deg = self.servo.position_deg(now_s)
        return 0

    def switch(self, letters: str, now_s: float) -> int:
        """Obey ``MO``, ``MF`` or ``ST``; return the error code."""
        was_homing = self.servo.is_moving(now_s) and not self.servo.is_homed(now_s)
        if letters == "MO":
            self.is_on = True
            return 0
        self.is_on = self.is_on and letters == "ST"
        self.servo.stop(now_s)
        return self.error(wire.HOMING_ABORTED) if was_homing else 0

    def set(self, letters: str, value: float, now_s: float) -> int | None:
        """Obey a command with a number: return its error code; None where there is no such command."""
        match letters:
            case "PA":
                return self._move(value, now_s)
            case "PR":
                return self._move(self.position_deg(now_s) + value, now_s)
            case "OR":
                return self._home(value, now_s)
            case "VA" | "AC":
                return self._pace(letters, value)
            case "SL":
                self.low_deg = value
            case "SR":
                self.high_deg = value
            case "SH":
                self.preset_deg = value
            case "SN":
                if value not in _UNITS:
                    return wire.OUT_OF_RANGE
                self.unit = int(value)
                return 0
            case _:
                return None
        return 0

    def error(self, code: int) -> int:
        return 100 * self._number + code

    def power_cycle(self, now_s: float) -> None:
        self.servo.power_cycle(now_s)
        self.is_on = False

    def _move(self, target_deg: float, now_s: float) -> int:
        if not self.is_on:
            return self.error(wire.MOTOR_OFF)
        if not self.low_deg <= target_deg <= self.high_deg:
            return self.error(wire.SOFTWARE_LIMITS[target_deg < self.low_deg])
        self.servo.move(target_deg + self._home_deg, now_s)
        return 0

    def _home(self, mode: float, now_s: float) -> int:
        if mode not in _SEARCH_MODES:
            return wire.OUT_OF_RANGE
        if not self.is_on:
            return self.error(wire.MOTOR_OFF)
        self._home_deg = 0.0
        self.servo.home(now_s, self.preset_deg)
        return 0

    def _pace(self, letters: str, value: float) -> int:
        if not value > 0.0:
            return wire.OUT_OF_RANGE
        if letters == "VA":
            self.servo.speed_dps = value
        else:
            self.servo.acceleration_dps2 = value
        return 0


class Esp301Twin:
    """A :class:`rig.twins.twin.Twin`. ``axes``: numbers to the names of the world's bodies."""

    def __init__(
        self,
        axes: Mapping[int, str],
        world: World,
        *,
        travel_deg: tuple[float, float] = (-360.0, 360.0),
        version: str = "ESP301 Version 3.01",
    ) -> None:
        self.axes = {
            number: Esp301Axis(number, ServoAxis(world.axes[name], world), travel_deg) for number, name in axes.items()
        }
        self.errors: deque[ErrorRecord] = deque(maxlen=wire.QUEUE_LENGTH)
        self.version = version
        self._on_from_s = 0.0
        self._received = b""
        self._due = b""

    def receive(self, data: bytes, now_s: float) -> None:
        *lines, rest = (self._received + data).replace(b"\n", b"").split(wire.TERMINATOR)
        self._received = rest[-_LONGEST_LINE:]
        for line in lines:
            for command in wire.decode_commands(line):
                if command is None:
                    code = wire.COMMAND_UNKNOWN
                elif command.axis is None:
                    code = self._of_controller(command, now_s)
                elif command.axis in self.axes:
                    code = self._of_axis(self.axes[command.axis], command, now_s)
                else:
                    code = wire.AXIS_OUT_OF_RANGE
                if code:
                    self.report(code, now_s)

    def transmit(self, now_s: float) -> bytes:  # noqa: ARG002 it answers at once
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return None

    def power_cycle(self, now_s: float) -> None:
        """Lose power and get it back: motors off, homes and errors forgotten, time counted anew."""
        self.errors.clear()
        self._on_from_s = now_s
        for axis in self.axes.values():
            axis.power_cycle(now_s)

    def report(self, code: int, now_s: float) -> None:
        """Put an error into the queue; where it is full, the oldest goes."""
        known = _AXIS_TEXTS.get(code % 100, "ERROR")
        text = f"AXIS-{code // 100} {known}" if code >= 100 else _TEXTS[code]
        self.errors.append(ErrorRecord(code, self._stamp(now_s), text))

    def _stamp(self, now_s: float) -> int:
        return int((now_s - self._on_from_s) / wire.CYCLE_S)

    def _of_controller(self, command: Command, now_s: float) -> int:
        match command.letters:
            case "TE":
                self._due += wire.encode_reply(str(self._next_error(now_s).code))
            case "TB":
                self._due += wire.encode_error(self._next_error(now_s))
            case "VE":
                self._due += wire.encode_reply(self.version)
            case "TS":
                self._due += wire.encode_reply(self._status(now_s))
            case "PH":
                self._due += wire.encode_reply(NO_HARDWARE_SIGNAL)
            case "AB" | "ST":
                for axis in self.axes.values():
                    axis.servo.stop(now_s)
            case _:
                return wire.AXIS_MISSING
        return 0

    def _status(self, now_s: float) -> str:
        """Return one character: bit 6 always, bit 4 power on any axis, bits 0 to 2 axes that move."""
        moving = sum(1 << number - 1 for number, axis in self.axes.items() if axis.servo.is_moving(now_s))
        return chr(1 << 6 | (1 << 4 if any(axis.is_on for axis in self.axes.values()) else 0) | moving)

    def _next_error(self, now_s: float) -> ErrorRecord:
        return self.errors.popleft() if self.errors else ErrorRecord(0, self._stamp(now_s), _TEXTS[0])

    def _of_axis(self, axis: Esp301Axis, command: Command, now_s: float) -> int:
        answer = axis.answer(command, now_s)
        if answer is not None:
            self._due += wire.encode_reply(answer)
            return 0
        if command.letters in ("MO", "MF", "ST"):
            return axis.switch(command.letters, now_s)
        if command.letters == "DH" and not command.value.strip("0."):
            return axis.define_home(now_s)
        value = wire.decode_number(command.value.encode("ascii", errors="replace"))
        code = axis.set(command.letters, 0.0 if value is None else value, now_s) if value is not None else None
        if code is not None:
            return code
        is_known = command.letters in ("PA", "PR", "OR", "VA", "AC", "SL", "SR", "SN", "SH")
        if not is_known:
            return wire.COMMAND_UNKNOWN
        return wire.OUT_OF_RANGE if command.value else wire.PARAMETER_MISSING
