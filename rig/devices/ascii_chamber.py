"""Chambers that speak lines of text, by preset: Thermotron 8800 and 3800, Espec P-300 and SCP-220.

The unit on the wire is asked for where a chamber tells it, with every temperature and before every set point, and
stated in the rig file where it cannot be asked: there is no default. A program would follow its own set points, so
none is written while one runs, and a chamber that stops by itself while we hold is a fault.

Source: docs/devices/ascii-chambers.md.
"""

from collections.abc import Callable, Iterator
from typing import Annotated, Literal, TypeVar

from pydantic import Field, model_validator

from rig.abilities.chamber_alarms import alarm_clause
from rig.abilities.setpoint_memory import DRIFTS, Otherwise, SetpointMemory, settle, write_and_read_back
from rig.description.device_settings import EnvironmentSettings, NotNegative
from rig.errors import ChamberFault, DeviceNonsense, DeviceRefused, RequestRefused
from rig.link.byte_stream import ByteStream
from rig.link.exchange import Exchange, Patience
from rig.wire.chamber_text import (
    DECIMALS,
    STOP_CODE,
    ChamberWords,
    Look,
    chamber_words,
    format_temperature,
    parse_is_fahrenheit,
    parse_stop_reason,
    parse_text,
)
from rig.wire.temperatures import degc_of, of_degc

PLAUSIBLE_DEGC = (-100.0, 250.0)
"""A temperature outside is a wrong unit or a broken probe."""
PATIENCE = Patience(timeout_s=3.0, quiet_s=0.5)
Reply = TypeVar("Reply")


class AsciiChamberSettings(EnvironmentSettings):
    """``driver = "ascii-chamber"``."""

    driver: Literal["ascii-chamber"]
    model: Literal["thermotron-8800", "thermotron-3800", "espec-p300", "espec-scp220"]
    values: Literal["degc", "degf"] | None = None
    """The unit on the wire; None: as an 8800 says. The others cannot be asked."""
    channel: Annotated[int, Field(ge=1, le=48)] = 1
    """Of a Thermotron."""
    address: Annotated[int, Field(ge=1, le=16)] | None = None
    """Of an Espec on RS-485; None: RS-232 or TCP, where none is written."""
    baud_rate: Literal[1200, 2400, 4800, 9600, 19200, 38400] = 9600
    reply_end: Literal["lf", "cr"] = "lf"
    """What a reply ends with; ``lf`` with or without CR before it."""
    pause_s: NotNegative | None = None
    """Rest behind a write; None: what the model needs."""

    @model_validator(mode="after")
    def _fits_the_model(self) -> "AsciiChamberSettings":
        words = chamber_words(self.model)
        if words.unit is None and self.values is None:
            raise ValueError(
                f'values: a {self.model} cannot be asked for its unit; look at its panel and write "degc" or "degf"'
            )
        if self.model.startswith("espec") and self.channel != 1:
            raise ValueError(f"channel: an {self.model} has one; leave it out")
        if self.model.startswith("thermotron") and self.address is not None:
            raise ValueError(f"address: a {self.model} has none on the wire; leave it out")
        return self


class AsciiChamber:
    """A :class:`rig.abilities.abilities.Environment`."""

    def __init__(self, name: str, settings: AsciiChamberSettings, stream: ByteStream) -> None:
        self.name = name
        self._settings = settings
        self._words: ChamberWords = chamber_words(settings.model, settings.channel)
        self._prefix = b"" if settings.address is None else b"%d," % settings.address
        self._clock = stream.clock
        end = b"\n" if settings.reply_end == "lf" else b"\r"
        self._exchange = Exchange(stream, terminator=end, patience=PATIENCE)
        self._pause_s = self._words.pause_s if settings.pause_s is None else settings.pause_s
        self._free_s = self._clock.monotonic_s()
        self._is_fahrenheit: bool | None = None
        self.setpoint_memory = SetpointMemory(name, settings.limits_degc)

    def identify(self) -> str:
        answers = [self._ask(question, parse_text) for question in self._words.identity]
        unit = "degF" if self._unit() else "degC"
        self._ask(self._words.activity, self._words.parse_activity)
        return f"{self._settings.model} {' '.join(answers)}, values in {unit}"

    def temperature_degc(self) -> float:
        is_fahrenheit = self._unit()
        settle(self)
        if self.setpoint_memory.is_set:
            self._require_holding()
        look = self._look()
        self.setpoint_memory.require(lambda: self._set_otherwise(look, is_fahrenheit))
        degc = _degc(look.temperature, is_fahrenheit)
        low_degc, high_degc = PLAUSIBLE_DEGC
        if not low_degc <= degc <= high_degc:
            raise ChamberFault(
                f"{self.name}: the air reads {degc:g} °C, which is not plausible, allowed {low_degc:g} to"
                f" {high_degc:g}; nothing was changed; check the probe and the unit (environment.{self.name}: values)"
            )
        return degc

    def setpoint_degc(self) -> float:
        """Return the set point that the chamber follows, a program's while one runs, where it can be told."""
        is_fahrenheit = self._unit()
        followed = self._look().setpoint if self._activity() == "program" else None
        setpoint = self._ask(self._words.setpoint, self._words.parse_setpoint) if followed is None else followed
        return _degc(setpoint, is_fahrenheit)

    def alarms(self) -> tuple[str, ...]:
        return () if self._words.alarms is None else self._ask(self._words.alarms, self._words.parse_alarms)

    def hold(self, setpoint_degc: float) -> None:
        self._settings.refuse_beyond_limits(self.name, setpoint_degc)
        is_fahrenheit = self._unit()
        activity = self._activity()
        if activity == "program":
            raise DeviceRefused(
                f"{self.name}: a program runs or is held: the chamber would follow it and not a set point; nothing was"
                " changed; end it at the panel"
            )
        look = self._look()
        self.setpoint_memory.require_before_writing(
            lambda: self._set_otherwise(look, is_fahrenheit, has_stopped=activity == "stopped")
        )
        self._refuse_beyond_controller_limits(look, setpoint_degc, is_fahrenheit)
        self._refuse_between_steps(setpoint_degc, is_fahrenheit)
        found_degc = self._setpoint_in_store_degc()
        self.setpoint_memory.begin(setpoint_degc, found_degc)
        if activity == "stopped" and not self._words.starts_always:
            self._start_at(setpoint_degc, found_degc)
        else:
            write_and_read_back(self, setpoint_degc)
        self._require_holding(is_started=True)
        self.setpoint_memory.confirm()

    def _start_at(self, setpoint_degc: float, old_degc: float) -> None:
        """Start a chamber that stands, once its set point reads back; see that it holds that one.

        Whether an 8800 takes a set point while it stands is not known: where the old one stays, and lies inside the
        limits of the rig file, the new one is written again once it runs.
        """
        write_and_read_back(self, setpoint_degc, old_degc if self.setpoint_memory.is_allowed(old_degc) else None)
        self._tell(self._words.start)
        if self.read_otherwise_degc(setpoint_degc) is not None:
            write_and_read_back(self, setpoint_degc)

    def write_setpoint(self, setpoint_degc: float) -> None:
        """Write it; a 3800 is started by that, since it takes a set point at no other time."""
        value = _on_the_wire(setpoint_degc, self._unit())
        self._tell(self._words.write.replace(b"%s", format_temperature(value)))
        if self._words.starts_always:
            self._tell(self._words.start)

    def read_otherwise_degc(self, setpoint_degc: float) -> float | None:
        found_degc = self._setpoint_in_store_degc()
        is_there = abs(found_degc - _degc(_on_the_wire(setpoint_degc, self._unit()), self._unit())) <= 1e-6
        return None if is_there else found_degc

    def make_harmless(self) -> str:
        if self._activity() == "stopped":
            return "it was not started, and stands"
        self._tell(self._words.stop)
        return "calrig stopped it, and it stands" if self._activity() == "stopped" else ""

    def _setpoint_in_store_degc(self) -> float:
        """Return the set point that the chamber follows when it holds."""
        return _degc(self._ask(self._words.setpoint, self._words.parse_setpoint), self._unit())

    def _set_otherwise(self, look: Look, is_fahrenheit: bool, *, has_stopped: bool = False) -> Iterator[Otherwise]:
        """Yield what is not as calrig set it; the set point is asked for where ``look`` has none."""
        if self.setpoint_memory.is_on and has_stopped:
            yield Otherwise("it stands")
        found = look.setpoint
        if found is None or has_stopped:  # what it follows when it holds
            found = self._ask(self._words.setpoint, self._words.parse_setpoint)
        if not self.setpoint_memory.is_as_written(lambda degc: abs(found - _on_the_wire(degc, is_fahrenheit)) <= 1e-9):
            found_degc = _degc(found, is_fahrenheit)
            heading = DRIFTS if has_stopped else self.setpoint_memory.heading(found_degc)
            yield Otherwise(f"the set point is {found_degc:g} °C", heading)

    def _refuse_between_steps(self, setpoint_degc: float, is_fahrenheit: bool) -> None:
        """Refuse a set point of which the chamber has no step. Raises: RequestRefused."""
        exact = of_degc(setpoint_degc, is_fahrenheit=is_fahrenheit)
        value = _on_the_wire(setpoint_degc, is_fahrenheit)
        if abs(value - exact) > 1e-9:
            raise RequestRefused(
                f"{self.name}: setpoint {setpoint_degc:g} °C: the chamber takes tenths of a {_sign(is_fahrenheit)};"
                f" nothing was changed; ask for one of them, the nearest is {_degc(value, is_fahrenheit):.6g} °C"
            )

    def _refuse_beyond_controller_limits(self, look: Look, setpoint_degc: float, is_fahrenheit: bool) -> None:
        if look.lowest is None or look.highest is None:
            return
        low_degc, high_degc = _degc(look.lowest, is_fahrenheit), _degc(look.highest, is_fahrenheit)
        if not low_degc - 1e-9 <= setpoint_degc <= high_degc + 1e-9:
            raise RequestRefused(
                f"{self.name}: setpoint {setpoint_degc:g} °C: the chamber allows {low_degc:g} to {high_degc:g} °C"
                " (its own limits); nothing was changed; ask for one inside"
            )

    def _require_holding(self, *, is_started: bool = False) -> None:
        """Raise unless it holds. One that calrig has not seen at work may stand: ``is_started`` where it may not."""
        activity = self._activity()
        may_stand = not (self.setpoint_memory.is_on or is_started)
        if activity == "program" or (activity == "stopped" and not may_stand):
            is_program = activity == "program"
            what = "a program runs" if is_program else f"the chamber has stopped{self._stop_reason()}"
            heading = "it follows the program" if is_program else DRIFTS
            raise ChamberFault(
                f"{self.name}: {what} since the set point was written; the temperature is not held: {heading}"
                f"{alarm_clause(self)}; look at its panel"
            )

    def _stop_reason(self) -> str:
        has_code = self._words.activity == STOP_CODE
        return self._ask(STOP_CODE, parse_stop_reason) if has_code else ""

    def _unit(self) -> bool:
        """Return whether the wire is in °F, as when we connected. Raises: DeviceNonsense, ChamberFault."""
        stated = None if self._settings.values is None else self._settings.values == "degf"
        answered = stated if self._words.unit is None else self._ask(self._words.unit, parse_is_fahrenheit)
        assert answered is not None, "the settings were checked"
        if stated not in (None, answered):
            raise DeviceNonsense(
                f"{self.name}: the controller is set to {_sign(answered)}, the rig file says"
                f" {self._settings.values!r} (environment.{self.name}: values); nothing was changed; correct the file,"
                " or the unit at the panel"
            )
        if self._is_fahrenheit not in (None, answered):
            raise ChamberFault(
                f"{self.name}: the unit was {_sign(self._is_fahrenheit)} and is"
                f" {_sign(answered)}: somebody set the controller otherwise; nothing was changed; set it"
                " back, or start anew"
            )
        self._is_fahrenheit = answered
        return answered

    def _look(self) -> Look:
        return self._ask(self._words.look, self._words.parse_look)

    def _activity(self) -> str:
        return self._ask(self._words.activity, self._words.parse_activity)

    def _ask(self, question: bytes, parse: Callable[[bytes], Reply]) -> Reply:
        self._rest()
        sent = self._prefix + question + self._words.command_end
        return self._exchange.ask(sent, lambda line: parse(self._whole(question, line)), idempotent=True)

    def _tell(self, command: bytes) -> None:
        """Send a write; an absolute set point and a start may be sent twice. Raises: DeviceRefused."""
        self._rest()
        sent, check = self._prefix + command + self._words.command_end, self._words.check_acknowledged
        refusal = ""
        if check is None:
            self._exchange.tell(sent)
        else:
            refusal = self._exchange.ask(sent, lambda line: check(command, line.rstrip(b"\r")), idempotent=True)
        self._free_s = self._clock.monotonic_s() + self._pause_s
        if refusal:
            raise DeviceRefused(
                f"{self.name}: the chamber refuses {command.decode('ascii')}: {refusal}; nothing was changed by it;"
                " look at its panel"
            )

    def _whole(self, question: bytes, line: bytes) -> bytes:
        line = line.rstrip(b"\r")
        if line.startswith(b"NA:"):
            raise DeviceNonsense(f"{question.decode('ascii')} is not known to this chamber: {parse_text(line)}")
        return line

    def _rest(self) -> None:
        if (left_s := self._free_s - self._clock.monotonic_s()) > 0.0:
            self._clock.sleep(left_s)


def _degc(value: float, is_fahrenheit: bool) -> float:
    return round(degc_of(value, is_fahrenheit=True), 6) if is_fahrenheit else value


def _on_the_wire(degc: float, is_fahrenheit: bool) -> float:
    return round(of_degc(degc, is_fahrenheit=is_fahrenheit), DECIMALS)


def _sign(is_fahrenheit: bool) -> str:
    """Return the unit of the wire as people read it."""
    return "°F" if is_fahrenheit else "°C"
