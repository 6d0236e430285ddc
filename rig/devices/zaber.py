"""Zaber rotary stages (X-RSW, X-RST, X-RSB and alike) by the ASCII protocol: angles and rates.

Every command carries an id and a checksum and is acknowledged; a reply must repeat device, axis and id. Alerts and
info lines are skipped. Positions are whole microsteps: what one turns is a setting of the stage's data sheet.
Not homed is the stage's own warning (WR, WH); since a reply carries its highest warning only, the stage is also asked
straight out (``limit.home.triggered``) before every start, behind a home and wherever another warning stands. A start
is sent once: where its acknowledgement is lost, the stage is asked whether it moves.
"""

from collections.abc import Callable, Mapping, Sequence
from threading import RLock
from typing import Annotated, Literal

from pydantic import Field

from rig.abilities import rates
from rig.abilities.abilities import AxisState, StopStep, TurnLook
from rig.abilities.home_preset import HomePresetSettings, require_preset
from rig.abilities.machine_limits import require_travel
from rig.abilities.starting import start_once
from rig.abilities.targets import check_target, nearest_step, require_home
from rig.clock import Clock
from rig.description.device_settings import Positive
from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, FileContradicted
from rig.link.byte_stream import ByteStream
from rig.link.counts import counts_of
from rig.link.exchange import Exchange, Patience
from rig.wire import zaber as wire
from rig.wire.zaber import Command, Reply

_TURN_TOLERANCE_DEG = 0.001
_RATE_TOLERANCE = 1e-3
_MOST_DATA = 2**31 - 1
"""Data of a command are whole numbers of 32 bits with a sign."""


class ZaberSettings(HomePresetSettings, rates.RevolvingSettings):
    """``driver = "zaber"``. ``axis`` is the device's number on its chain."""

    driver: Literal["zaber"]
    device_axis: Annotated[int, Field(ge=1, le=9)] = 1
    """Number of the axis within the device."""
    microstep_deg: Positive
    """What one microstep turns, from the data sheet."""
    velocity_scale: Positive = 1.6384
    """Data of ``move vel`` and ``maxspeed`` for one microstep a second."""
    baud_rate: Literal[9600, 19200, 38400, 57600, 115200] = 115200
    require_checksum: bool = True
    """Refuse replies without a checksum; the stage sends one where its ``comm.checksum`` is 1."""
    reply_timeout_s: Annotated[float, Field(gt=0.0)] = 0.5

    @property
    def speed_range_dps(self) -> tuple[float, float]:
        unit_dps = self.microstep_deg / self.velocity_scale
        return unit_dps, unit_dps * _MOST_DATA

    @property
    def line_address(self) -> tuple[int, ...]:
        return (self.axis, self.device_axis)


class ZaberChain:
    """The devices of one line: ids run through all of them."""

    def __init__(self, exchange: Exchange, *, require_checksum: bool) -> None:
        self.exchange = exchange
        self._require_checksum = require_checksum
        self._next_id = 0
        self._turn = RLock()

    def ask(self, device: int, axis: int, text: str, *, idempotent: bool = True) -> Reply:
        """Send a command and return its reply. Raises: DeviceRefused where the device rejects it."""
        with self._turn:
            self._next_id = (self._next_id + 1) % wire.IDS
            self.exchange.counts = counts_of(self.exchange.stream, f"device {device}")
            command = Command(device, axis, text, self._next_id)
            reply = self.exchange.ask(
                wire.encode_command(command), lambda line: self._parse(line, command), idempotent=idempotent
            )
        if not reply.is_accepted:
            raise DeviceRefused(
                f"{self.exchange.stream.name}: device {device} rejected {text!r}: {reply.data}, warning"
                f" {reply.warning}; nothing was changed; compare the command with the stage's manual"
            )
        return reply

    def _parse(self, line: bytes, command: Command) -> Reply:
        reply = wire.decode_reply(line)
        if reply is None:
            raise DeviceNonsense("no reply of the protocol, or its checksum is wrong")
        if (reply.device, reply.axis, reply.message_id) != (command.device, command.axis, command.message_id):
            raise DeviceNonsense(f"device {reply.device}, axis {reply.axis}, id {reply.message_id} was not asked")
        if self._require_checksum and not reply.has_checksum:
            raise DeviceNonsense(
                "the reply has no checksum (set the stage's comm.checksum to 1, or require_checksum = false)"
            )
        return reply


class ZaberAxis:
    """One stage: a :class:`rig.abilities.abilities.Axis` and a :class:`rig.abilities.abilities.RateAxis`."""

    def __init__(self, name: str, settings: ZaberSettings, chain: ZaberChain) -> None:
        self.name = name
        self.limits_deg = settings.limits_deg
        self.increment_deg = settings.increment_deg
        self.speed_dps = settings.speed_dps
        self.approach_deg = settings.approach_deg
        self.arrival_tolerance_deg = max(settings.arrival_tolerance_deg, settings.microstep_deg)
        self.top_rate_dps = settings.top_rate_dps or 0.0
        self._settings = settings
        self._chain = chain
        self._is_prepared = False
        self._is_referenced = False
        """The stage said so itself, at rest, and no look since told otherwise."""

    def identify(self) -> str:
        """Return who the stage says it is. Raises: DeviceSilent, DeviceNonsense, LinkLost."""
        names = ("deviceid", "system.serial", "version")
        self._require_scale_and_zero()
        device_id, serial, version = (self._chain.ask(self._settings.axis, 0, f"get {name}").data for name in names)
        axis = f", axis {self._settings.device_axis}" if self._settings.device_axis > 1 else ""
        return f"Zaber device {device_id}, serial {serial}, firmware {version}, number {self._settings.axis}{axis}"

    def check_target(self, target_deg: float) -> None:
        check_target(self.name, self._settings, target_deg)

    def check_rate(self, rate_dps: float) -> None:
        rates.check_rate(self.name, rate_dps, self.top_rate_dps)

    def start_move(self, target_deg: float) -> None:
        self.check_target(target_deg)
        self._require_home(f"move to {target_deg:g}°")
        self._prepare()
        target = nearest_step(self._step(target_deg), (self._step(self.limits_deg[0]), self._step(self.limits_deg[1])))
        self._start(f"move abs {target}", lambda: self._position() == target)

    def start_rate(self, rate_dps: float) -> None:
        self.check_rate(rate_dps)
        self._require_home(f"turn at {rate_dps:g} °/s")
        self._require_scale_and_zero()
        self._start(f"move vel {self._velocity(self._settings.sign * rate_dps)}", lambda: False)

    def home(self) -> None:
        """As of every axis. Flags that stay until they are acknowledged, such as FS behind a stall, are: a home is what
        the manual asks for behind them, and what is still wrong raises them again.
        """
        if not _is_harmless(self._ask("get pos").warning):
            self._ask("warnings clear")
        self._is_prepared = False  # a stage that lost power forgot its speed, too
        self._prepare()
        self._is_referenced = False
        self._start("home", lambda: False)

    def turn_look(self, clock: Clock) -> TurnLook:
        return rates.look(lambda: self._attitude_deg(self._position()), clock)

    def state(self) -> AxisState:
        reply = self._ask("get pos")
        return AxisState(
            position_deg=self._attitude_deg(self._whole(reply)),
            is_moving=reply.is_busy,
            is_homed=self._is_homed(reply),
            is_seated=True,
            fault="" if _is_harmless(reply.warning) else f"the stage warns {reply.warning}",
        )

    def stop(self) -> None:
        self._chain.exchange.write_in_doubt(self._stop_unasked)
        self._ask("stop")

    def stop_steps(self) -> Sequence[StopStep]:
        """Return the stop, without an id: whoever sends it waits for no reply."""
        return (StopStep(self._stop_unasked),)

    @property
    def _stop_unasked(self) -> bytes:
        return wire.encode_command(Command(self._settings.axis, self._settings.device_axis, "stop"))

    def _prepare(self) -> None:
        """Compare the stage's scale and zero with the file's, and once its travel, and see the file's speed taken.

        Raises: RequestRefused, DeviceFault, DeviceRefused.
        """
        self._require_scale_and_zero()
        if self._is_prepared:
            return
        low, high = (self._whole(self._ask(f"get limit.{end}")) for end in ("min", "max"))
        require_travel(self.name, self.limits_deg, (self._attitude_deg(low), self._attitude_deg(high)))
        speed = self._velocity(self.speed_dps)
        self._ask(f"set maxspeed {speed}")
        read_back = self._whole(self._ask("get maxspeed"))
        if abs(read_back - speed) > max(1.0, _RATE_TOLERANCE * speed):
            raise DeviceFault(
                f"{self.name}: speed {self.speed_dps:g} °/s was sent as {speed}, but reads back {read_back}"
                f" (axes.{self.name}: speed_dps); nothing moved; ask for a speed that the stage has"
            )
        self._is_prepared = True

    def _require_scale_and_zero(self) -> None:
        """Compare both with the file. Raises: FileContradicted."""
        self._require_scale()
        try:
            preset = self._whole(self._ask("get limit.home.preset"))
        except DeviceRefused:
            return  # it has no home sensor
        microstep_deg = self._settings.microstep_deg
        require_preset(self.name, self._settings, preset * microstep_deg, "limit.home.preset", microstep_deg)

    def _require_scale(self) -> None:
        """``limit.cycle.dist`` is the one number on the device that proves degrees per microstep.

        0, or no such setting, is a device that does not turn on and on: it proves nothing. Raises: DeviceRefused.
        """
        try:
            turn = self._whole(self._ask("get limit.cycle.dist"))
        except DeviceRefused:
            return
        turn_deg = turn * self._settings.microstep_deg
        if turn and abs(turn_deg - 360.0) > _TURN_TOLERANCE_DEG:
            raise FileContradicted(
                f"{self.name}: the stage has {turn} microsteps a turn, which are {turn_deg:g}° with microstep_deg ="
                f" {self._settings.microstep_deg:g} (axes.{self.name}: microstep_deg); nothing moved; another stage is"
                " connected, or its resolution was changed: correct the file or the stage"
            )

    def _is_homed(self, reply: Reply) -> bool:
        """Return whether the stage has a reference.

        A fault hides WR behind it, so its absence is no proof: then the stage is asked, as it is until it has said so
        at rest. One without that setting (it has no home sensor) is believed by its warnings.
        """
        if reply.warning in wire.UNREFERENCED:
            self._is_referenced = False
            return False
        if self._is_referenced and not _may_hide_others(reply.warning):
            return True
        try:
            is_homed = self._whole(self._ask("get limit.home.triggered")) != 0
        except DeviceRefused:
            is_homed = not _may_hide_others(reply.warning)
        self._is_referenced = is_homed and not reply.is_busy
        return is_homed

    def _require_home(self, task: str) -> None:
        self._is_referenced = False
        require_home(self.name, task, is_homed=self.state().is_homed)

    def _start(self, text: str, is_there: Callable[[], bool]) -> None:
        start_once(lambda: self._ask(text, idempotent=False), lambda: self.state().is_moving or is_there())

    def _ask(self, text: str, *, idempotent: bool = True) -> Reply:
        return self._chain.ask(self._settings.axis, self._settings.device_axis, text, idempotent=idempotent)

    def _position(self) -> int:
        return self._whole(self._ask("get pos"))

    def _whole(self, reply: Reply) -> int:
        value = wire.decode_integer(reply.data)
        if value is None:
            raise DeviceNonsense(
                f"{self.name}: a whole number was expected, got {reply.data!r}; nothing was taken from it;"
                " check that this is a stage with one axis"
            )
        return value

    def _velocity(self, rate_dps: float) -> int:
        return round(rate_dps / self._settings.microstep_deg * self._settings.velocity_scale)

    def _step(self, attitude_deg: float) -> float:
        return self._settings.table_deg(attitude_deg) / self._settings.microstep_deg

    def _attitude_deg(self, microsteps: int) -> float:
        return self._settings.attitude_deg(microsteps * self._settings.microstep_deg)


def connect(axes: Mapping[str, ZaberSettings], stream: ByteStream) -> dict[str, ZaberAxis]:
    """Return the stages of one chain, which share its line."""
    first = next(iter(axes.values()))
    exchange = Exchange(
        stream,
        terminator=wire.TERMINATOR,
        patience=Patience(timeout_s=first.reply_timeout_s),
        is_aside=wire.is_aside,
    )
    chain = ZaberChain(exchange, require_checksum=first.require_checksum)
    return {name: ZaberAxis(name, settings, chain) for name, settings in axes.items()}


def _is_harmless(warning: str) -> bool:
    """Return whether a warning is none, not referenced, or a note (N…) such as an interrupted move."""
    return warning in wire.UNREFERENCED or not _may_hide_others(warning)


def _may_hide_others(warning: str) -> bool:
    """Return whether a warning may rank above WR: all but none and notes (N…)."""
    return warning != wire.NO_WARNING and not warning.startswith("N")
