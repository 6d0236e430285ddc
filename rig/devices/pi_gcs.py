"""Rotary stages on a GCS 2.0 controller of Physik Instrumente (C-863, C-663, C-867, C-884, E-873).

Commands are silent, so ``ERR?`` is asked behind each; it keeps one error only. A stage is homed by its own word
(``FRF?``), and its motor is on (``SVO?``): a motion error switches it off, which is a fault. The unit is the stage's
own parameter and must be degrees: the same command turns a stage by degrees and drives another by millimetres. Its
zero must be that of its reference: another program may have put it elsewhere (``DFH?``), or may be about to, where the
axis is set to be told its position instead of finding it (``RON?``).

Source: docs/devices/pi-gcs.md.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from threading import RLock
from typing import Annotated, Literal, TypeVar

from pydantic import Field

from rig.abilities.abilities import AxisState, StopStep
from rig.abilities.machine_limits import require_travel
from rig.abilities.starting import start_once
from rig.abilities.targets import check_target, require_home
from rig.description.device_settings import AxisSettings
from rig.errors import DeviceFault, DeviceRefused, DeviceSilent, FileContradicted
from rig.link.byte_stream import ByteStream
from rig.link.exchange import Exchange, Patience
from rig.wire import pi_gcs as wire

Reply = TypeVar("Reply")
_SPEED_TOLERANCE = 1e-3
_SLOWEST_DPS = 0.5e-6 / _SPEED_TOLERANCE
"""Slower, and the last of the six digits that are sent is another speed."""
_SAME_ANGLE_DEG = 1e-3
DEGREES = ("DEG", "DEGREE", "DEGREES", "°")


class PiGcsSettings(AxisSettings):
    """``driver = "pi-gcs"``. ``axis`` is its place in the controller's list (``SAI?``), from 1."""

    driver: Literal["pi-gcs"]
    axis_id: Annotated[str, Field(pattern="^[A-Za-z0-9]{1,8}$")] | None = None
    """Its name there, a letter or a word; None: the number."""
    reference: Literal["FRF", "FNL", "FPL", "none"] = "FRF"
    """How it finds its home: by its switch, by an end of travel, or not at all (an absolute encoder)."""
    baud_rate: Literal[9600, 19200, 38400, 57600, 115200, 230400, 460800] = 115200
    states_unit: bool = True
    """The stage tells its unit; false: you have looked that it is degrees."""
    reply_timeout_s: Annotated[float, Field(gt=0.0)] = 1.0

    @property
    def speed_range_dps(self) -> tuple[float, float]:
        return _SLOWEST_DPS, math.inf

    @property
    def moves_to_home(self) -> bool:
        return self.reference != "none"

    @property
    def named(self) -> str:
        return self.axis_id or str(self.axis)


class PiGcsAxis:
    """One axis of the controller: a :class:`rig.abilities.abilities.Axis`; axes share ``exchange`` and ``turn``."""

    def __init__(self, name: str, settings: PiGcsSettings, exchange: Exchange, turn: RLock) -> None:
        self.name = name
        self.limits_deg = settings.limits_deg
        self.increment_deg = settings.increment_deg
        self.speed_dps = settings.speed_dps
        self.approach_deg = settings.approach_deg
        self.arrival_tolerance_deg = settings.arrival_tolerance_deg
        self._settings = settings
        self._axis = settings.named
        self._exchange, self._turn = exchange, turn
        self._is_prepared = False
        self._unknown: set[str] = set()
        """Questions that the controller says are no commands of its own."""

    def identify(self) -> str:
        identity = self._ask(b"*IDN?\n", wire.parse_identity)
        self._require_degrees()
        return f"{identity}, axis {self._axis}"

    def check_target(self, target_deg: float) -> None:
        check_target(self.name, self._settings, target_deg)

    def start_move(self, target_deg: float) -> None:
        self.check_target(target_deg)
        require_home(self.name, f"move to {target_deg:g}°", is_homed=self.state().is_homed)
        self._prepare()
        self._require_unmoved_zero()
        table_deg = self._settings.table_deg(target_deg)
        start_once(lambda: self._do("MOV", wire.format_number(table_deg)), lambda: self._is_on_its_way(table_deg))

    def home(self) -> None:
        self._is_prepared = False  # a stage that lost power forgot its speed, too
        self._do("SVO", "1")
        self._prepare()
        if self._settings.reference == "none":
            self._require_unmoved_zero()
        else:
            self._require_search()
            start_once(lambda: self._do(self._settings.reference), self._is_moving)

    def state(self) -> AxisState:
        is_moving = self._is_moving()
        has_servo = self._flag("SVO?")
        return AxisState(
            position_deg=self._settings.attitude_deg(self._number("POS?")),
            is_moving=is_moving,
            is_homed=self._flag("FRF?"),
            is_seated=True,
            fault="the servo is off: a motion error switched it off, or somebody did"
            if self._is_prepared and not has_servo
            else "",
        )

    def stop(self) -> None:
        """Stop every axis of the controller; the error 10 behind it is the sign that it was obeyed."""
        self._exchange.write_in_doubt(wire.STOP)
        with self._turn:
            self._exchange.tell(wire.STOP)
            error = self._error()
        if error not in (wire.STOPPED, wire.NO_ERROR):
            raise self._refusal("#24", error)

    def stop_steps(self) -> Sequence[StopStep]:
        return (StopStep(wire.STOP),)

    def _prepare(self) -> None:
        """See that the stage counts in degrees, and once its travel, and see the file's speed taken.

        Raises: RequestRefused, DeviceRefused, DeviceFault.
        """
        self._require_degrees()
        if self._is_prepared:
            return
        ends_deg = [self._settings.attitude_deg(self._number(query)) for query in ("TMN?", "TMX?")]
        require_travel(self.name, self.limits_deg, (min(ends_deg), max(ends_deg)))
        self._do("VEL", wire.format_number(self.speed_dps))
        read_dps = self._number("VEL?")
        if abs(read_dps - self.speed_dps) > _SPEED_TOLERANCE * self.speed_dps:
            raise DeviceFault(
                f"{self.name}: speed {self.speed_dps:g} °/s was sent, but reads back {read_dps:g}"
                f" (axes.{self.name}: speed_dps); nothing moved; ask for a speed that the stage has"
            )
        self._is_prepared = True

    def _require_degrees(self) -> None:
        if not self._settings.states_unit:
            return
        question = wire.command("SPA?", self._axis, f"0x{wire.UNIT:X}")
        unit = self._ask(question, lambda line: wire.parse_unit(line, self._axis))
        if unit not in DEGREES:
            raise FileContradicted(
                f"{self.name}: the stage counts in {unit}, need degrees (axes.{self.name}: axis, axis_id); nothing"
                " moved; another stage is connected, or its configuration is not that of a rotary stage"
            )

    def _require_unmoved_zero(self) -> None:
        """See that nobody made another angle the zero: every angle would be off by it. Raises: DeviceRefused."""
        has_reference = self._settings.reference != "none"
        offset_deg = self._answered_if_known(lambda: self._number("DFH?"), "DFH?", 0.0)
        if abs(offset_deg) > _SAME_ANGLE_DEG:
            way_out = "home the axis anew, or restart the controller" if has_reference else "restart the controller"
            raise DeviceRefused(
                f"{self.name}: another program put the zero of axis {self._axis} at {offset_deg:g}° (DFH?), need 0:"
                f" every angle is off by it; nothing moved; {way_out}"
            )
        if has_reference:
            self._require_search()

    def _require_search(self) -> None:
        """See that the axis finds its reference and is not told where it is. Raises: DeviceRefused."""
        if not self._answered_if_known(lambda: self._flag("RON?"), "RON?", True):
            raise DeviceRefused(
                f"{self.name}: another program set axis {self._axis} to be told its position (RON? 0), need 1: any"
                " place may have been called any angle since it was homed (POS); nothing moved; send"
                f" RON {self._axis} 1 by the controller's own program, then home the axis anew"
            )

    def _answered_if_known(self, ask: Callable[[], Reply], query: str, otherwise: Reply) -> Reply:
        """Return the answer, ``otherwise`` of a controller without such a command: it is silent, ``ERR?`` says why."""
        if query in self._unknown:
            return otherwise
        with self._turn:
            try:
                return ask()
            except DeviceSilent:
                if self._error() != wire.UNKNOWN_COMMAND:
                    raise
        self._unknown.add(query)
        return otherwise

    def _is_on_its_way(self, table_deg: float) -> bool:
        return self._is_moving() or abs(self._number("POS?") - table_deg) < _SAME_ANGLE_DEG

    def _is_moving(self) -> bool:
        return bool(self._ask(wire.MOVING, wire.parse_moving) >> (self._settings.axis - 1) & 1)

    def _flag(self, query: str) -> bool:
        return self._ask(wire.command(query, self._axis), lambda line: wire.parse_flag(line, self._axis))

    def _number(self, query: str) -> float:
        return self._ask(wire.command(query, self._axis), lambda line: wire.parse_number(line, self._axis))

    def _do(self, word: str, *values: str) -> None:
        """Send a command, which is silent, and ask what became of it. Raises: DeviceRefused."""
        with self._turn:
            self._error()  # what is left from before is not this command's
            self._exchange.tell(wire.command(word, self._axis, *values))
            error = self._error()
        if error != wire.NO_ERROR:
            raise self._refusal(" ".join([word, self._axis, *values]), error)

    def _refusal(self, command: str, error: int) -> DeviceRefused:
        return DeviceRefused(
            f"{self.name}: the controller refused {command}: error {error}, {wire.ERRORS.get(error, 'see its manual')};"
            " look at the stage and its controller"
        )

    def _error(self) -> int:
        """Ask for the last error, which takes it away."""
        return self._ask(b"ERR?\n", wire.parse_error)

    def _ask(self, question: bytes, parse: Callable[[bytes], Reply]) -> Reply:
        with self._turn:
            return self._exchange.ask(question, parse, idempotent=question != b"ERR?\n")


def connect(axes: Mapping[str, PiGcsSettings], stream: ByteStream) -> dict[str, PiGcsAxis]:
    """Return the axes of one controller, which share its line."""
    patience = Patience(timeout_s=next(iter(axes.values())).reply_timeout_s)
    exchange, turn = Exchange(stream, terminator=b"\n", patience=patience), RLock()
    return {name: PiGcsAxis(name, settings, exchange, turn) for name, settings in axes.items()}
