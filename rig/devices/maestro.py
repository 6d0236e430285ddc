"""Servos on a Pololu Maestro (Micro or Mini): angles as pulse widths, by a calibration of each servo.

The controller reports the pulse it sends, not where the servo stands: accuracy comes from a reference sensor. Any
error bit sends every servo to its home, so the bits are read around each move and with each state; after one the
positions are lost until the axis is homed again. Arrival is the pulse that reads back as its target. Get Moving State
is never asked: on the Micro it may say 0 while a servo moves.

Replies do not repeat their question, so every question here has an answer of a length of its own: error bits two
bytes, the script's state one, and a position two and as many times the script's state as its axis has a place on the
line. After a doubt the script's state must come alone before anything is believed. A move sends its target once. Where
the line damages it and there is no CRC, its own limits keep the servo inside, and the read-back never becomes the
target. The form with device number and CRC is the safer one.

Source: Pololu Maestro user's guide, pages 27, 32, 39, 42, 43, 52 to 58.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from threading import RLock
from typing import TypeVar

from rig.abilities import rates
from rig.abilities.abilities import AxisState, ServoAim, StopStep, TurnLook, Wait
from rig.abilities.targets import check_target, nearest_step, require_home
from rig.abilities.watchdog import prove
from rig.clock import Clock
from rig.devices.maestro_settings import MaestroSettings, refuse_speed, speed_units
from rig.errors import DeviceFault, DeviceNonsense
from rig.link.byte_stream import ByteStream
from rig.link.exchange import Exchange, Patience
from rig.wire import maestro as wire
from rig.wire.maestro import Errors, MaestroCodec, Request
from rig.wire.pulses import PulseCalibration

_STOPPED = 1
_CREEPS_S = 0.1
"""In it the slowest servo goes on by ten steps of its pulse, and one that just began under the least acceleration by
six."""
Reply = TypeVar("Reply")


class MaestroController:
    """What the servos of one controller share: its line and its error register."""

    def __init__(self, exchange: Exchange, codec: MaestroCodec) -> None:
        self.errors = Errors(0)
        """Every bit seen since the line was opened."""
        self.failures = 0
        """Times that bits were seen."""
        self.proof = ""
        """What was seen when its serial time-out was tried; empty before."""
        self._exchange = exchange
        self.codec = codec
        self._turn = RLock()

    def tell(self, *requests: Request) -> None:
        """Send once, in one piece; then look at the error bits. Raises: DeviceFault."""
        with self._turn:
            failures = self.failures
            self.poll_errors()
            if self.failures == failures:
                self._exchange.tell(b"".join(self.codec.encode(request) for request in requests))
                self.poll_errors()
        if self.failures != failures:
            raise DeviceFault(
                f"{self._exchange.stream.name}: the controller reports {wire.error_words(self.errors)}: every servo"
                " went to its home and positions are lost; look for the cause, then home every axis"
            )

    def write_in_doubt(self, slow: bytes) -> None:
        self._exchange.write_in_doubt(slow)

    def poll_errors(self) -> Errors:
        """Read, and thereby clear, the error register."""
        bits = Errors(self._ask([Request(wire.GET_ERRORS)], 2, wire.decode_word, wire.ALL_ERRORS))
        if bits:
            self.errors |= bits
            self.failures += 1
        return bits

    def prove_timeout(self, name: str, timeout_s: float, wait: Wait) -> str:
        """Be silent until its serial time-out sends every servo home, once a connection. Raises: DeviceFault."""
        if not self.proof:
            self.poll_errors()
            remedy = "set the serial time-out in the controller's settings (Maestro Control Center)"
            clock = self._exchange.stream.clock
            self.proof = prove(name, timeout_s, lambda: Errors.TIMEOUT in self.poll_errors(), wait, clock, remedy)
        return self.proof

    def position(self, channel: int, marks: int) -> int:
        """Return quarter-microseconds; 0 is no pulse.

        ``marks``: times the script's state is asked behind it, at least 1.
        """
        requests = [wire.get_position(channel), *[Request(wire.GET_SCRIPT_STATUS)] * marks]
        return self._ask(requests, 2 + marks, _decode_marked, wire.HIGHEST_NUMBER)

    def is_script_running(self) -> bool:
        return self._ask([Request(wire.GET_SCRIPT_STATUS)], 1, wire.decode_word, _STOPPED) != _STOPPED

    def let_pass(self, duration_s: float) -> None:
        self._exchange.stream.clock.sleep(duration_s)

    def resynchronise(self) -> None:
        """Bring the line to a known state after a doubt.

        Silence, then an answer of one byte, which no late answer of two can be, then silence.
        """
        self._exchange.wait_for_quiet()
        question = self.codec.encode(Request(wire.GET_SCRIPT_STATUS))
        self._exchange.stream.write(question)
        reply = self._exchange.read_bytes(1, self._exchange.patience.timeout_s, question)
        if reply[0] > _STOPPED:
            raise DeviceNonsense(
                f"{self._exchange.stream.name}: the state of the script is {reply[0]}, allowed 0 and 1: no Maestro"
                " answers here; nothing was taken from it; check the baud rate and that this is the right device"
            )
        self._exchange.wait_for_quiet()

    def _ask(self, requests: Sequence[Request], length: int, decode: Callable[[bytes], int], highest: int) -> int:
        def parse(reply: bytes) -> int:
            value = decode(reply)
            if value > highest:
                raise DeviceNonsense(f"{value} is more than {highest}")
            return value

        question = b"".join(self.codec.encode(request) for request in requests)
        with self._turn:
            return self._exchange.ask(question, parse, idempotent=True, length=length)


class MaestroAxis:
    """Drive one servo, as an axis that can sweep and has a watchdog.

    It is an :class:`rig.abilities.abilities.Axis`, a :class:`rig.abilities.abilities.SweepAxis` and a
    :class:`rig.abilities.abilities.Watchdog`.
    """

    def __init__(self, name: str, settings: MaestroSettings, controller: MaestroController, index: int) -> None:
        """Make the axis; ``index`` is its number among the axes of the controller, from 1."""
        self.name = name
        self.limits_deg = settings.limits_deg
        self.increment_deg = settings.increment_deg
        self.speed_dps = settings.speed_dps
        self.approach_deg = settings.approach_deg
        self.watchdog_s = settings.watchdog_s
        self._settings = settings
        self._controller = controller
        self._index = index
        self._calibration = PulseCalibration(settings.points)
        step_deg = 1.0 / (self._calibration.smallest_us_per_deg * wire.QUARTERS_PER_US)
        self.arrival_tolerance_deg = max(settings.arrival_tolerance_deg, step_deg)
        self._speed = math.floor(speed_units(settings, self._calibration))
        self.top_rate_dps = settings.speed_dps
        self._target: int | None = None
        self._way: tuple[int, int] | None = None
        """Of the last order; None where it was not known where the servo was."""
        self._seen: int | None = None
        """Its last position; None before the first."""
        self._trusted_failures: int | None = None
        """The controller's failures when the servo was homed; None before."""

    def identify(self) -> str:
        """Return that the controller answers, and whether a script runs: it has no words of its own."""
        script = "running" if self._controller.is_script_running() else "stopped"
        return f"Maestro ({self._settings.model}), channel {self._settings.axis}, script {script}"

    def check_target(self, target_deg: float) -> None:
        check_target(self.name, self._settings, target_deg)

    def check_rate(self, rate_dps: float) -> None:
        refuse_speed(self.name, self._settings, rate_dps)

    def start_move(self, target_deg: float) -> None:
        self._start(target_deg, self._speed)

    def start_sweep(self, target_deg: float, rate_dps: float) -> None:
        """Start to move at a rate; the controller takes the whole units of speed below it."""
        self.check_rate(rate_dps)
        self._start(target_deg, math.floor(speed_units(self._settings, self._calibration, abs(rate_dps)) + 1e-6))

    def turn_look(self, clock: Clock) -> TurnLook:
        return rates.look(lambda: self._attitude_deg(self._ask_position()), clock)

    def _start(self, target_deg: float, speed: int) -> None:
        self.check_target(target_deg)
        state = self.state()
        if state.fault:
            raise DeviceFault(f"{self.name}: {state.fault}; nothing was sent; home the axis")
        require_home(self.name, f"move to {target_deg:g}°", is_homed=state.is_homed)
        self._aim(target_deg, speed)

    def home(self) -> None:
        """Go to ``home_deg``, error bits cleared. A servo without pulses jumps there at its own speed."""
        self.check_target(self._settings.home_deg)
        if self._controller.is_script_running():
            raise DeviceFault(
                f"{self.name}: a script runs on the controller and may move servos; nothing was sent; stop it"
            )
        self._controller.poll_errors()
        self._trusted_failures = self._controller.failures
        self._aim(self._settings.home_deg, self._speed)

    def state(self) -> AxisState:
        self._controller.poll_errors()
        position = self._ask_position()
        failed = self._trusted_failures is not None and self._trusted_failures != self._controller.failures
        return AxisState(
            position_deg=self._attitude_deg(position),
            is_moving=self._target is not None and not failed and position not in (0, self._target),
            is_homed=self._trusted_failures is not None and not failed and position != 0,
            is_seated=True,
            fault=f"the controller reported {wire.error_words(self._controller.errors)} and sent the servos home"
            if failed
            else "",
            unknown="" if position else "no pulse is sent, position not known",
            is_led=True,
        )

    def stop(self) -> None:
        """Make the pulse that is sent now the target, without a limit of acceleration. It is asked twice.

        Under a limit of acceleration it would run on, ramp down and come back. The limit is lifted behind the target,
        so that a servo without a limit of speed does not jump to where it was going, and the target is sent again, for
        no page says that a limit that is lifted counts before the next target. A servo that stands is sent nowhere: one
        on its target, or, where this connection sent it nowhere, on one place now and a tenth of a second later.
        On a line in doubt, which may never be quiet, it is slowed before it is asked.
        A digit of one answer that the line turned over moves no servo: that answer is off its way, or the other one is
        of the target. A servo that really left its way says so both times, and is stopped where it is.
        """
        self._controller.write_in_doubt(self.stop_steps()[0].send)
        looks = self._two_looks()
        if looks and self._target is None and looks[0] == looks[1]:
            self._controller.let_pass(_CREEPS_S)
            before, looks = looks[0], self._two_looks()
            if before in looks:
                return
        if not looks:
            return
        lowest, highest = wire.within_way(self._way or looks, self._settings.pulse_limit_quarters)
        self._target = ([position for position in looks if lowest <= position <= highest] or looks)[-1]
        channel = self._settings.axis
        aim = wire.set_target(channel, self._target)
        self._controller.tell(aim, wire.set_acceleration(channel, 0), aim)

    def _two_looks(self) -> list[int]:
        """Return where it is, asked twice; nothing where an answer says that it is on its target, or has no pulse."""
        looks = list[int]()
        for _ in range(2):
            position = self._ask_position()
            if position in (0, self._target):
                return []
            looks.append(position)
        return looks

    def stop_steps(self) -> Sequence[StopStep]:
        """Return its lowest speed without a ramp to it, and how it is asked where it is.

        A servo has no stop but to be sent where it is.
        """
        codec, channel, patience_s = self._controller.codec, self._settings.axis, self._settings.reply_timeout_s
        aim = ServoAim(channel, codec.device, codec.has_crc, self._settings.pulse_limit_quarters, patience_s)
        slow = wire.set_speed(channel, wire.LOWEST_SPEED), wire.set_acceleration(channel, 0)
        return (StopStep(b"".join(map(codec.encode, slow)), aim=aim),)

    def stop_way(self, target_deg: float) -> tuple[int, int] | None:
        return None if self._seen in (None, 0) else (self._seen, self._steps(target_deg))

    def home_mark(self) -> Mapping[str, float]:
        return {"pulse": float(self._ask_position())}

    def resume_home(self, mark: Mapping[str, float], away_s: float) -> str:  # noqa: ARG002 pulses tell no time
        """Trust the position that was left where nothing happened to the servo; else return why not.

        That is so where the very pulse is sent that was left, without an error since.
        """
        failures = self._controller.failures
        self._controller.poll_errors()
        position = self._ask_position()
        if self._controller.failures != failures:
            return f"the controller reports {wire.error_words(self._controller.errors)}; home it"
        if position != mark["pulse"]:
            return (
                f"its pulse is {position / wire.QUARTERS_PER_US:g} µs and was left at"
                f" {mark['pulse'] / wire.QUARTERS_PER_US:g} µs; home it"
            )
        self._target, self._trusted_failures = position, failures
        return ""

    def arm_watchdog(self, wait: Wait) -> str:
        """See once that the controller's time-out acts: its settings cannot be written by its serial line."""
        assert self.watchdog_s is not None
        seen = self._controller.prove_timeout(self.name, self.watchdog_s, wait)
        return f"{seen}; it is a setting of the controller, which tells it to nobody: proven now, not looked at again"

    def feed_watchdog(self) -> None:
        self._controller.poll_errors()

    def disarm_watchdog(self) -> None:
        """Do nothing: the controller cannot be told; the servos go to their homes."""

    def _aim(self, target_deg: float, speed: int) -> None:
        """Aim with speed and acceleration every time: a controller that lost power forgot them."""
        channel = self._settings.axis
        target = self._steps(target_deg)
        self._way, self._target = self.stop_way(target_deg), target
        self._controller.tell(
            wire.set_speed(channel, speed),
            wire.set_acceleration(channel, self._settings.acceleration),
            wire.set_target(channel, target),
        )

    def _ask_position(self) -> int:
        self._seen = self._controller.position(self._settings.axis, self._index)
        return self._seen

    def _steps(self, target_deg: float) -> int:
        limits = self._quarters(self.limits_deg[0]), self._quarters(self.limits_deg[1])
        return nearest_step(self._quarters(target_deg), limits)

    def _quarters(self, attitude_deg: float) -> float:
        return self._calibration.pulse_us(self._settings.table_deg(attitude_deg)) * wire.QUARTERS_PER_US

    def _attitude_deg(self, position: int) -> float:
        table_deg = self._calibration.angle_deg(position / wire.QUARTERS_PER_US)
        return self._settings.attitude_deg(table_deg)


def connect(axes: Mapping[str, MaestroSettings], stream: ByteStream) -> dict[str, MaestroAxis]:
    """Return the servos of one controller, which share its line. Raises: LinkLost."""
    first = next(iter(axes.values()))
    exchange = Exchange(
        stream,
        patience=Patience(timeout_s=first.reply_timeout_s),
        resynchronise=lambda: controller.resynchronise(),
    )
    controller = MaestroController(exchange, MaestroCodec(first.addressed_device, first.crc))
    return {
        name: MaestroAxis(name, settings, controller, index)
        for index, (name, settings) in enumerate(axes.items(), start=1)
    }


def _decode_marked(reply: bytes) -> int:
    """Return a position with the script's state behind it, once or more."""
    marks = set(reply[2:])
    if len(marks) != 1 or max(marks) > _STOPPED:
        found = " and ".join(map(str, sorted(marks))) or "none"
        raise DeviceNonsense(f"the marks behind the position are {found}, allowed is one of 0 and 1")
    return wire.decode_word(reply[:2])
