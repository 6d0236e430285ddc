"""Newport ESP300, ESP301 and ESP302 motion controllers: axes that go to any angle.

Commands are silent, so every one is followed by reading the error queue. The controller has no word for "homed": an
axis counts as homed once this driver saw its home search begin and end without an error, until its motor is off, the
time stamps of the queue step back (power was lost) or the search is started again; ``homed_before`` takes over a home
that was found earlier. A motor that was on and is off without a loss of power was switched off by somebody, which is a
fault until the axis is homed. Replies do not repeat the question: after any doubt the line must fall silent and then
tell the controller's version, which no number can be taken for; and a position at rest is believed when two agree.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from threading import RLock
from typing import Annotated, Literal, TypeVar

from pydantic import Field

from rig.abilities.abilities import AxisState, StopStep
from rig.abilities.home_preset import HomePresetSettings, require_preset
from rig.abilities.machine_limits import require_travel
from rig.abilities.starting import TAKEN_UP_S, see_taken_up, start_once
from rig.abilities.targets import check_target, require_home
from rig.description.device_settings import Positive
from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, DeviceSilent, FileContradicted, RequestRefused
from rig.link.byte_stream import ByteStream
from rig.link.exchange import Exchange, Patience
from rig.wire import esp301 as wire
from rig.wire.esp301 import Command, ErrorRecord

_SPEED_TOLERANCE, _RESOLUTION_TOLERANCE = 1e-3, 1e-4
_LOOKS = 3
_TO_ZERO_COUNT = 0
"""The home search that only goes to the zero of the counter: there, it has nothing to do."""
_CLOCK_SLACK_S, _CLOCK_DRIFT = 5.0, 1e-3
"""How far the controller's clock may be from ours and still have run all the time."""
SWITCHED_OFF = "the motor was switched off, not by calrig"
Reply = TypeVar("Reply")


class Esp301Settings(HomePresetSettings):
    """``driver = "esp301"``."""

    driver: Literal["esp301"]
    axis: Annotated[int, Field(ge=1, le=3)] = 1
    baud_rate: Literal[9600, 19200, 38400, 57600, 115200, 921600] = 921600
    """921600 is the ESP301's, 19200 with ``rts_cts`` the ESP300's."""
    rts_cts: bool = False
    home_mode: Annotated[int, Field(ge=0, le=6)] = 1
    """Parameter of the home search ``OR``."""
    homed_before: bool = False
    """The operator vouches that the axis was homed since power came on."""
    resolution_deg: Positive | None = None
    """Of one encoder count (SU): "degrees" (SN) is a label only, which proves no scale."""
    reply_timeout_s: Annotated[float, Field(gt=0.0)] = 1.0

    @property
    def speed_range_dps(self) -> tuple[float, float]:
        return wire.slowest_dps(_SPEED_TOLERANCE), math.inf


class Esp301Controller:
    """What the axes of one controller share: the line, its error queue, and whether power was lost."""

    def __init__(self, exchange: Exchange) -> None:
        self.turn = RLock()
        self.losses = 0
        """Times that power was lost since the line was opened."""
        self.doubts = 0
        """Times that a record of the queue may have been lost on the line."""
        self.clock = exchange.stream.clock
        self._exchange = exchange
        self._stamp = 0
        self._errors: dict[int, list[ErrorRecord]] = {}

    def ask_number(self, letters: str, axis: int) -> float:
        return self._ask(wire.ask(letters, axis), wire.decode_number, "a number")

    def ask_flag(self, letters: str, axis: int) -> bool:
        return self._ask(wire.ask(letters, axis), wire.decode_flag, "0 or 1")

    def version(self) -> str:
        return self._ask(wire.ask("VE"), wire.decode_version, "the version of an ESP300, ESP301 or ESP302")

    def command(self, *commands: Command, is_stop: bool = False) -> list[ErrorRecord]:
        """Send once, a stop also before a line in doubt is quiet; return the errors that came of it.

        Older ones are kept for :meth:`take_errors`.
        """
        if is_stop:
            self._exchange.write_in_doubt(wire.encode(*commands))
        with self.turn:
            self._file(self._read_errors())
            self._exchange.tell(wire.encode(*commands))
            return self._read_errors()

    def start(self, axis: int, *commands: Command) -> tuple[bool, list[ErrorRecord]]:
        """Send once, as :meth:`command`, and return whether the axis rests, asked in the same line, and the errors."""
        with self.turn:
            self._file(self._read_errors())
            line = wire.encode(*commands, wire.ask("MD", axis))
            is_done = self._exchange.ask(line, _parser(wire.decode_flag, "0 or 1"), idempotent=False)
            return is_done, self._read_errors()

    def take_errors(self, axis: int) -> list[ErrorRecord]:
        """Return the errors of one axis that came since they were last taken, and not from a command of ours."""
        with self.turn:
            self._file(self._read_errors())
            return self._errors.pop(axis, [])

    def stamp(self) -> int:
        """Return the controller's own clock, in its cycles since power came on."""
        with self.turn:
            self._file(self._read_errors())
            return self._stamp

    def resynchronise(self) -> None:
        """Bring the line to a known state after a doubt.

        Silence, then the version, whatever numbers come before it, then silence again.
        """
        self._exchange.wait_for_quiet()
        self._exchange.stream.write(wire.encode(wire.ask("VE")))
        line = self._exchange.read_line(self._exchange.patience.timeout_s, b"VE?")
        while wire.decode_version(line) is None:
            line = self._line_after(line)
        self._exchange.wait_for_quiet()

    def _line_after(self, line: bytes) -> bytes:
        try:
            return self._exchange.read_line(self._exchange.patience.timeout_s, b"VE?")
        except DeviceSilent:
            raise DeviceNonsense(
                f"{self._exchange.stream.name}: no ESP300, ESP301 or ESP302 answers to VE?: got {line!r}; nothing was"
                " taken from it; check the line settings and that this is the right device"
            ) from None

    def _read_errors(self) -> list[ErrorRecord]:
        """Read the error queue until it is empty."""
        errors: list[ErrorRecord] = []
        for _ in range(wire.QUEUE_LENGTH + 1):
            error = self._next_error()
            if error.is_empty:
                self.losses += error.stamp < self._stamp
                self._stamp = error.stamp
                return errors
            errors.append(error)
        raise DeviceFault(
            f"{self._exchange.stream.name}: the error queue does not end: {errors[-1].text}; nothing was sent;"
            " look at the controller's display"
        )

    def _next_error(self) -> ErrorRecord:
        """Read one record, which takes it out of the queue; where the question was repeated, one may be lost."""
        repeated = self._exchange.counts.repeated
        error = self._ask(wire.ask("TB"), wire.decode_error, "an error record")
        self.doubts += self._exchange.counts.repeated > repeated
        return error

    def _file(self, errors: list[ErrorRecord]) -> None:
        for error in errors:
            self._errors.setdefault(error.axis, []).append(error)

    def _ask(self, question: Command, decode: Callable[[bytes], Reply | None], expected: str) -> Reply:
        with self.turn:
            return self._exchange.ask(wire.encode(question), _parser(decode, expected), idempotent=True)


class Esp301Axis:
    """One axis: a :class:`rig.abilities.abilities.Axis`."""

    def __init__(self, name: str, settings: Esp301Settings, controller: Esp301Controller) -> None:
        self.name = name
        self.limits_deg = settings.limits_deg
        self.increment_deg = settings.increment_deg
        self.speed_dps = settings.speed_dps
        self.approach_deg = settings.approach_deg
        self.arrival_tolerance_deg = settings.arrival_tolerance_deg
        self._settings = settings
        self._controller = controller
        self._home: Literal["none", "searching", "found"] = "found" if settings.homed_before else "none"
        self._trust = (0, 0)
        """Losses and doubts of the controller when the home was found or its search was started."""
        self._fault = ""
        self._is_on = False
        """Its motor was on at the last look."""
        self._is_paced = False
        self._travel_deg: tuple[float, float] | None = None

    def identify(self) -> str:
        """Return the controller's version and its own limits, which may be wider than the file's."""
        version = self._controller.version()
        low_deg, high_deg = self._verified()
        scale = "" if self._settings.resolution_deg is None else f", {self._settings.resolution_deg:g} deg a count"
        return f"{version}, axis {self._settings.axis}, own limits {low_deg:g} to {high_deg:g} deg{scale}"

    def check_target(self, target_deg: float) -> None:
        check_target(self.name, self._settings, target_deg)

    def start_move(self, target_deg: float) -> None:
        self.check_target(target_deg)
        state = self.state()
        if state.fault:
            raise DeviceFault(f"{self.name}: move to {target_deg:g}°: {state.fault}; nothing moved")
        require_home(self.name, f"move to {target_deg:g}°", is_homed=state.is_homed)
        self._require_degrees_and_zero()
        self._pace()
        self._command(wire.set_value("PA", self._settings.axis, self._settings.table_deg(target_deg)))

    def home(self) -> None:
        """Switch the motor on and start the home search. Errors that were kept are forgotten."""
        self._verified()
        self._require_zero()
        self._pace()
        self._controller.take_errors(self._settings.axis)
        self._fault, self._home = "", "none"
        self._trust = (self._controller.losses, self._controller.doubts)
        self._search_home()
        self._home = "searching"

    def state(self) -> AxisState:
        self._verified()
        number = self._settings.axis
        is_done = self._controller.ask_flag("MD", number)
        if is_done and self._home == "searching":  # its word alone ends a search, and may be damaged on the line
            is_done = self._controller.ask_flag("MD", number)
        position_deg, is_still = self._position_deg() if is_done else (self._controller.ask_number("TP", number), False)
        is_moving = not is_still
        is_on = self._controller.ask_flag("MO", number)
        errors = self._controller.take_errors(number)
        losses, doubts = self._controller.losses, self._controller.doubts
        if errors:
            self._fault = "; ".join(f"error {error.code} {error.text}" for error in errors)
        if losses != self._trust[0]:
            self._is_paced, self._travel_deg = False, None
        elif self._is_on and not is_on and not self._fault:
            self._fault = SWITCHED_OFF
        self._is_on = is_on
        if not is_on or losses != self._trust[0]:
            self._home, self._trust = "none", (losses, doubts)
        if self._home == "searching" and (errors or doubts != self._trust[1]):
            self._home = "none"
        if self._home == "searching" and not is_moving:
            self._home = "found"
        return AxisState(
            position_deg=self._settings.attitude_deg(position_deg),
            is_moving=is_moving,
            is_homed=self._home == "found",
            is_seated=True,
            fault=self._fault,
        )

    def stop(self) -> None:
        """Brake. Stopping a home search leaves no home."""
        if self._home == "searching":
            self._home = "none"
        self._controller.command(Command("ST", self._settings.axis), is_stop=True)

    def stop_steps(self) -> Sequence[StopStep]:
        return (StopStep(wire.encode(Command("ST", self._settings.axis))),)

    def home_mark(self) -> Mapping[str, float]:
        return {"stamp": float(self._controller.stamp())}

    def resume_home(self, mark: Mapping[str, float], away_s: float) -> str:
        """Trust the home that was left where power was never lost; else return why not.

        The motor is still on and the controller's clock ran on as long as ours.
        """
        ran_s = (self._controller.stamp() - mark["stamp"]) * wire.CYCLE_S
        if not self._controller.ask_flag("MO", self._settings.axis):
            return "the motor is off; home it"
        if abs(ran_s - away_s) > _CLOCK_SLACK_S + _CLOCK_DRIFT * away_s:
            cause = "it lost power" if ran_s < away_s else "it is another controller, or this computer's clock was set"
            return f"the controller's clock ran {ran_s:.0f} s in {away_s:.0f} s: {cause}; home it"
        self._home, self._trust = "found", (self._controller.losses, self._controller.doubts)
        return ""

    def _position_deg(self) -> tuple[float, bool]:
        """Return the table angle of an axis that says it rests, and whether two answers agreed; asked until they do."""
        position_deg = self._controller.ask_number("TP", self._settings.axis)
        for _ in range(_LOOKS):
            before_deg, position_deg = position_deg, self._controller.ask_number("TP", self._settings.axis)
            if abs(position_deg - before_deg) <= self.arrival_tolerance_deg:
                return position_deg, True
        return position_deg, False

    def _verified(self) -> tuple[float, float]:
        """Return the controller's limits, table degrees, compared with the file when first asked, with all else.

        Raises: RequestRefused, FileContradicted.
        """
        if self._travel_deg is None:
            number, controller = self._settings.axis, self._controller
            self._require_degrees_and_zero()
            travel_deg = controller.ask_number("SL", number), controller.ask_number("SR", number)
            low_deg, high_deg = (self._settings.attitude_deg(table_deg) for table_deg in travel_deg)
            require_travel(self.name, self.limits_deg, (low_deg, high_deg))
            self._travel_deg = travel_deg
        return self._travel_deg

    def _require_degrees_and_zero(self) -> None:
        """Compare both with the file's, as before every start. Raises: RequestRefused, FileContradicted."""
        unit = self._controller.ask_number("SN", self._settings.axis)
        if unit != wire.DEGREES:
            raise RequestRefused(
                f"{self.name}: the controller counts this axis in unit {unit:g} (SN), allowed {wire.DEGREES}"
                " (degrees); nothing moved; set its unit to degrees, or correct the axis' number"
            )
        self._require_resolution(self._settings.axis)
        self._require_zero()

    def _require_zero(self) -> None:
        require_preset(self.name, self._settings, self._controller.ask_number("SH", self._settings.axis), "SH", 0.0)

    def _require_resolution(self, number: int) -> None:
        need_deg = self._settings.resolution_deg
        if need_deg is None:
            return
        read_deg = self._controller.ask_number("SU", number)
        if abs(read_deg - need_deg) > _RESOLUTION_TOLERANCE * need_deg:
            raise FileContradicted(
                f"{self.name}: the controller reckons with (SU) {read_deg:g}° a count, the rig file says"
                f" {need_deg:g} (axes.{self.name}: resolution_deg); nothing moved; another stage is"
                " connected, or its scale was changed: correct one of them"
            )

    def _pace(self) -> None:
        """Tell the controller the file's speed and see it taken. Raises: DeviceRefused, DeviceFault."""
        if self._is_paced:
            return
        self._command(wire.set_value("VA", self._settings.axis, self.speed_dps))
        read_dps = self._controller.ask_number("VA", self._settings.axis)
        if abs(read_dps - self.speed_dps) > _SPEED_TOLERANCE * self.speed_dps:
            raise DeviceFault(
                f"{self.name}: speed {self.speed_dps:g} °/s was sent, but reads back {read_dps:g} °/s"
                f" (axes.{self.name}: speed_dps); nothing moved; ask for a speed that the axis has"
            )
        self._is_paced = True

    def _search_home(self) -> None:
        """Switch the motor on, start the search and see it begin: a search that was lost on the line is no home.

        Raises: DeviceFault, DeviceRefused, DeviceSilent, DeviceNonsense.
        """
        number, controller = self._settings.axis, self._controller
        search = Command("MO", number), Command("OR", number, str(self._settings.home_mode))
        if self._settings.home_mode == _TO_ZERO_COUNT and controller.ask_number("TP", number) == 0.0:
            self._command(*search)  # it is there: nothing will be seen
            return
        began = False

        def start() -> None:
            nonlocal began
            is_done, errors = controller.start(number, *search)
            self._require_no_errors(errors, search)
            began = not is_done

        def is_searching() -> bool:
            return began or not controller.ask_flag("MD", number)

        start_once(start, is_searching)
        unseen = (
            f"{self.name}: home: the search was sent, but the axis does not begin one within {TAKEN_UP_S:g} s; nothing"
            " moved, and there is no home; look at the line and the controller, then home it again"
        )
        see_taken_up(is_searching, controller.clock, unseen)

    def _command(self, *commands: Command) -> None:
        self._require_no_errors(self._controller.command(*commands), commands)

    def _require_no_errors(self, errors: Sequence[ErrorRecord], commands: Sequence[Command]) -> None:
        if errors:
            complaints = "; ".join(f"error {error.code} {error.text}" for error in errors)
            raise DeviceRefused(
                f"{self.name}: the controller refused {wire.encode(*commands).decode('ascii').strip()!r}: {complaints};"
                " look at its error list and at the axis"
            )


def _parser(decode: Callable[[bytes], Reply | None], expected: str) -> Callable[[bytes], Reply]:
    def parse(line: bytes) -> Reply:
        reply = decode(line)
        if reply is None:
            raise DeviceNonsense(f"{expected} was expected")
        return reply

    return parse


def connect(axes: Mapping[str, Esp301Settings], stream: ByteStream) -> dict[str, Esp301Axis]:
    """Return the axes of one controller, which share its line."""
    patience = Patience(timeout_s=next(iter(axes.values())).reply_timeout_s)
    exchange = Exchange(
        stream,
        terminator=wire.REPLY_TERMINATOR,
        patience=patience,
        resynchronise=lambda: controller.resynchronise(),
    )
    controller = Esp301Controller(exchange)
    return {name: Esp301Axis(name, settings, controller) for name, settings in axes.items()}
