"""The 3458A alone: set up, read back, triggered, fetched.

A burst is armed once (``TARM SGL``) and the meter paces it; each reading is waited for in rig time, looked for by
serial poll where it is long, then fetched. What the meter was told is read back before it is triggered and once more
behind the burst: a hand at its panel, another program or the mains can change it in between.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from rig.abilities.abilities import Wait
from rig.abilities.read_back import LONGEST_ERROR_LIST, READ_BACK_TOLERANCE
from rig.abilities.selected_inputs import Inputs, SelectedInputs
from rig.abilities.waiting import wait_until
from rig.clock import Clock
from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused
from rig.link.gpib import GpibBus
from rig.wire import hp3458a as wire
from rig.wire.hp3458a import Event, Status

Reply = TypeVar("Reply")

INTEGRATIONS_PER_READING = 2.0
"""Autozero measures an internal zero with every reading."""
OVERHEAD_S = 0.001
POLL_ABOVE_S = 1.0
"""A reading longer than this is fetched only once the meter says that it is there: the adapter gives up after 3 s."""
DATA_LIMIT_S = 3.0
"""How much later than expected a reading may come."""
READY_LIMIT_S = 10.0
AUTOCALIBRATION_S, AUTOCALIBRATION_LIMIT_S = 150.0, 150.0
"""ACAL DCV takes 165 s by the manual: first look, and how much later it may end."""

CONFIGURATION = (
    b"QFORMAT NORM;INBUF ON;OFORMAT ASCII;MEM OFF;MATH OFF;RATIO OFF;AZERO ON;FIXEDZ OFF;TRIG AUTO;TARM HOLD"
)
"""FIXEDZ OFF is more than 10 gigohm up to 10 V.

INBUF ON frees the bus during a burst, so that the meter can be polled and cleared."""
CONFIRMED: Mapping[bytes, float] = {
    **{b"OFORMAT?": 1, b"AZERO?": 1, b"FIXEDZ?": 0, b"RATIO?": 0},
    **{b"TRIG?": Event.AUTO, b"TARM?": Event.HOLD},
}
"""Read back before and behind every burst: hands at its panel and other controllers can change them at any time."""
WAYS_OUT: Mapping[bytes, str] = {
    b"NPLC?": "choose a value that the meter offers (nplc: whole cycles from 1, tens above 10)",
    b"FUNC?": "choose a range that the meter offers (range_v of the channel), or see who else sets the meter",
}
NOT_READ, DROPPED = "no reading is taken", "the burst is dropped"
ANOTHER_SETTING = "see who else sets the meter, or whether the line damages what is sent"


@dataclass(frozen=True, slots=True)
class Setup:
    """What may differ from one burst to the next."""

    range_v: float
    nplc: float
    samples: int


class Hp3458aMeter:
    """The meter at ``address``. ``clock`` is the rig's; the bus has its own for time-outs."""

    def __init__(
        self,
        name: str,
        bus: GpibBus,
        address: int,
        line_frequency_hz: int,
        clock: Clock,
        terminals: Inputs | None = None,
    ) -> None:
        """``terminals``: the inputs that must be selected; None: those that are at the first look."""
        self.name = name
        self._bus = bus
        self._address = address
        self._line_frequency_hz = line_frequency_hz
        self._clock = clock
        self._is_configured = False
        self._setup: Setup | None = None
        self._power_on_sign = Status(0)
        self._inputs = SelectedInputs(name, terminals)

    def identify(self) -> str:
        self._bus.send(self._address, b"END ALWAYS")
        who = self._ask(b"ID?", wire.parse_identity)
        master, slave = self._ask(b"REV?", wire.parse_pair)
        option, adjusted = (self._ask(query, wire.parse_number) for query in (b"OPT?", b"CALNUM?"))
        terminals = self._selected()
        self._inputs.require_declared(terminals)
        return (
            f"{who}, revision {master:g},{slave:g}, option {option:g}, adjusted {adjusted:g} times, {terminals} inputs"
        )

    def prepare(self) -> None:
        """Clear, reset, identify, configure, read back."""
        self.forget()
        self._bus.clear(self._address)
        self._bus.send(self._address, b"END ALWAYS")
        self._bus.send(self._address, b"RESET;TARM HOLD;END ALWAYS;CSB")
        wait_until(
            lambda: bool(self._bus.serial_poll(self._address) & Status.READY),
            self._clock.sleep,
            (self._clock, self._bus.clock),
            READY_LIMIT_S,
            lambda: f"{self.name}: meter: not ready {READY_LIMIT_S:g} s after RESET; look at its display",
        )
        self._ask(b"ID?", wire.parse_identity)
        self._clear_earlier_errors()
        self._inputs.require(self._selected(), NOT_READ)
        self._configure()
        # Where CSB does not clear the sign, it says nothing about what happens from here on.
        self._power_on_sign = Status.POWER_ON & ~Status(self._bus.serial_poll(self._address))

    def set_up(self, setup: Setup) -> None:
        """Send what one burst needs, and read it and the configuration back.

        A burst equal to the one before needs nothing sent: what then reads back differently, another hand has set,
        and it is refused. Raises: DeviceRefused.
        """
        if self._is_configured:
            self._quieten()
            self._confirm_configuration(NOT_READ)
        else:
            self._configure()
        is_new = setup != self._setup
        if is_new:
            self._setup = None
            command = f"DCV {setup.range_v:g};NPLC {setup.nplc:g};NRDGS {setup.samples},AUTO"
            self._bus.send(self._address, command.encode("ascii"))
        self._confirm_setup(setup, WAYS_OUT if is_new else {}, NOT_READ)
        self._setup = setup

    def burst(self, setup: Setup, wait: Wait) -> tuple[NDArray[np.float64], float]:
        """Read one burst: all readings, volts, shape (samples,), and when it was triggered, rig seconds.

        Raises: DeviceSilent, DeviceNonsense, and what ``wait`` raises.
        """
        reading_s = self.reading_s(setup.nplc)
        self._bus.send(self._address, b"TARM SGL")
        started_s = self._clock.monotonic_s()
        self._await_reading(started_s + reading_s, reading_s, wait)
        # What comes before the first reading is fetched is an answer of before, once more: drained, and no reading.
        unasked_before = self._bus.unasked_bytes()
        readings = [self._bus.read(self._address, wire.parse_reading)]
        for k in range(2, setup.samples + 1):
            self._await_reading(started_s + k * reading_s, reading_s, wait)
            readings.append(self._bus.read(self._address, wire.parse_reading))
        # All have one length, so a cut one shows.
        lengths = {length for _, length in readings}
        if len(lengths) > 1:
            found = " and ".join(map(str, sorted(lengths)))
            raise DeviceNonsense(
                f"{self.name}: meter: readings of {found} characters in one burst, one length is allowed;"
                " the burst is dropped; check the line for lost bytes"
            )
        # Readings carry no number: bytes too many mean that one may have been taken twice, another not at all.
        unasked = self._bus.unasked_bytes() - unasked_before
        if unasked:
            raise DeviceNonsense(
                f"{self.name}: meter: {unasked} bytes nobody asked for came with the readings, none is allowed;"
                " the burst is dropped, its readings may be shifted; check the line for doubled bytes"
            )
        return np.array([value_v for value_v, _ in readings]), started_s

    def reading_s(self, nplc: float) -> float:
        return INTEGRATIONS_PER_READING * nplc / self._line_frequency_hz + OVERHEAD_S

    def require_undisturbed(self, setup: Setup, wait: Wait) -> None:
        """Refuse a meter that met an error, lost power, has readings left or anything set otherwise than before.

        What is asked before a burst is asked again. Raises: DeviceRefused, DeviceFault, DeviceSilent, and what
        ``wait`` raises.
        """
        status = self._status_at_rest(self.reading_s(setup.nplc) + DATA_LIMIT_S, wait)
        if status & Status.ERROR:
            self._require_no_error()
        if status & self._power_on_sign:
            raise DeviceFault(
                f"{self.name}: meter: it was switched off and on since it was set up; the burst is dropped;"
                " let it warm up again, then prepare it anew"
            )
        if status & Status.DATA:
            raise DeviceRefused(
                f"{self.name}: meter: it has readings left after the {setup.samples} that it was set to; the burst is"
                f" dropped; {ANOTHER_SETTING}"
            )
        self._quieten()
        self._confirm_configuration(DROPPED)
        self._confirm_setup(setup, {}, DROPPED)
        self._require_no_error()

    def temperature_degc(self) -> float:
        return self._ask(b"TEMP?", wire.parse_number)

    def autocalibrate(self, wait: Wait) -> None:
        """Let it calibrate its DC volts to its own standards; its inputs must be open.

        Raises: DeviceFault where it reports an error, DeviceSilent, and what ``wait`` raises.
        """
        self.forget()
        self._bus.send(self._address, b"ACAL DCV")
        wait(AUTOCALIBRATION_S)
        wait_until(
            lambda: bool(self._bus.serial_poll(self._address) & Status.READY),
            wait,
            (self._clock, self._bus.clock),
            AUTOCALIBRATION_LIMIT_S,
            lambda: (
                f"{self.name}: meter: ACAL DCV did not end within {AUTOCALIBRATION_S + AUTOCALIBRATION_LIMIT_S:g} s;"
                " nothing is measured; look at its display"
            ),
        )
        if errors := self._errors():
            words = ", ".join(text for _, text in errors)
            raise DeviceFault(
                f"{self.name}: meter: ACAL DCV: {words}; nothing is measured; open its inputs and try again by hand"
            )

    def clear(self) -> None:
        """End whatever it does."""
        self.forget()
        self._bus.clear(self._address)

    def forget(self) -> None:
        """Forget the meter's settings: the next burst sends them all."""
        self._is_configured = False
        self._setup = None

    def _await_reading(self, due_s: float, reading_s: float, wait: Wait) -> None:
        """Let the next reading be taken, in rig time."""
        ahead_s = due_s - self._clock.monotonic_s()
        if ahead_s > 0.0:
            wait(ahead_s)
        if reading_s > POLL_ABOVE_S:
            self._await_data(reading_s, wait)

    def _await_data(self, reading_s: float, wait: Wait) -> None:
        limit_s = reading_s + DATA_LIMIT_S
        wait_until(
            lambda: bool(self._bus.serial_poll(self._address) & Status.DATA),
            wait,
            (self._clock, self._bus.clock),
            limit_s,
            lambda: (
                f"{self.name}: meter: no reading within {limit_s:g} s of its time; the burst is dropped;"
                " check that the meter is in remote and not waiting for an external trigger"
            ),
        )

    def _status_at_rest(self, limit_s: float, wait: Wait) -> Status:
        """Return the status once the meter measures no more, or has one more reading."""
        status = Status(0)

        def is_at_rest() -> bool:
            nonlocal status
            status = Status(self._bus.serial_poll(self._address))
            return bool(status & (Status.READY | Status.DATA))

        wait_until(
            is_at_rest,
            wait,
            (self._clock, self._bus.clock),
            limit_s,
            lambda: (
                f"{self.name}: meter: still busy {limit_s:g} s after the last reading; the burst is dropped;"
                f" {ANOTHER_SETTING}"
            ),
        )
        return status

    def _configure(self) -> None:
        """Set up everything that no burst changes, read it back, and leave no error behind."""
        self._bus.send(self._address, b"END ALWAYS")
        self._bus.send(self._address, CONFIGURATION)
        self._bus.send(self._address, b"LFREQ %d" % self._line_frequency_hz)
        self._confirm_configuration(NOT_READ)
        self._require_no_error("configuration: ", "it is not set up")
        self._is_configured = True

    def _selected(self) -> Inputs:
        return self._ask(b"TERM?", wire.parse_terminals)

    def _quieten(self) -> None:
        """Let it answer what it is asked, whoever had it before.

        One that lost its power or was reset runs free without EOI: nothing that it sends would end.
        """
        self._bus.send(self._address, b"END ALWAYS;TARM HOLD")

    def _confirm_configuration(self, outcome: str) -> None:
        self._inputs.require(self._selected(), outcome)
        for query, need in {**CONFIRMED, b"LFREQ?": self._line_frequency_hz}.items():
            self._require_number(query, need, outcome)
        self._require(b"MATH?", self._ask(b"MATH?", wire.parse_operations), 0, outcome)

    def _confirm_setup(self, setup: Setup, ways_out: Mapping[bytes, str], outcome: str) -> None:
        function, range_v = self._ask(b"FUNC?", wire.parse_pair)
        self._require(b"FUNC?", function, wire.DC_VOLTS, outcome)
        self._require(b"FUNC?", range_v, setup.range_v, outcome, ways_out.get(b"FUNC?", ANOTHER_SETTING))
        self._require_number(b"ARANGE?", 0, outcome)
        for got, need in zip(self._ask(b"NRDGS?", wire.parse_pair), (setup.samples, Event.AUTO), strict=True):
            self._require(b"NRDGS?", got, need, outcome)
        self._require_number(b"NPLC?", setup.nplc, outcome, ways_out.get(b"NPLC?", ANOTHER_SETTING))

    def _require_number(self, query: bytes, need: float, outcome: str, way_out: str = ANOTHER_SETTING) -> None:
        self._require(query, self._ask(query, wire.parse_number), need, outcome, way_out)

    def _require(self, query: bytes, got: float, need: float, outcome: str, way_out: str = ANOTHER_SETTING) -> None:
        if abs(got - need) > READ_BACK_TOLERANCE * abs(need):
            raise DeviceRefused(
                f"{self.name}: meter: {query.decode('ascii')} reads back {got:g}, it was set to {need:g}; {outcome};"
                f" {way_out}"
            )

    def _require_no_error(self, doing: str = "", outcome: str = DROPPED) -> None:
        if errors := self._errors():
            words = ", ".join(text for _, text in errors)
            raise DeviceRefused(f"{self.name}: meter: {doing}{words}; {outcome}; look at its display")

    def _clear_earlier_errors(self) -> None:
        """Empty the meter's registers; refused only where what they held speaks of the meter itself."""
        harmful = [text for number, text in self._errors() if wire.is_harmful(number)]
        if harmful:
            raise DeviceFault(f"{self.name}: meter: {', '.join(harmful)}; nothing is measured; have it looked at")

    def _errors(self) -> list[tuple[int, str]]:
        """Ask for errors until there is none; asking clears the one that is told."""
        errors: list[tuple[int, str]] = []
        while (error := self._bus.ask(self._address, b"ERRSTR?", wire.parse_error, idempotent=False))[0]:
            errors.append(error)
            if len(errors) > LONGEST_ERROR_LIST:
                raise DeviceNonsense(f"{self.name}: meter: more than {LONGEST_ERROR_LIST} errors; power it off and on")
        return errors

    def _ask(self, query: bytes, parse: Callable[[bytes], Reply]) -> Reply:
        return self._bus.ask(self._address, query, parse, idempotent=True)
