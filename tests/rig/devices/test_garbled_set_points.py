"""A set point that a chamber hears otherwise than it was sent: read back, put right once, or the chamber made harmless.

A line of text has no check sum: one digit of ``SETP1,20.0`` turned over is ``SETP1,80.0``, and is acknowledged.
"""

from collections.abc import Callable, Sequence

import pytest
from gpib_rig import virtual_clock
from still_room import StillRoom

from rig.devices import watlow_f4, watlow_f4t
from rig.devices.ascii_chamber import AsciiChamber, AsciiChamberSettings
from rig.devices.watlow_f4 import WatlowF4, WatlowF4Settings
from rig.devices.watlow_f4t import WatlowF4T, WatlowF4TSettings
from rig.errors import ChamberFault, DeviceRefused, DeviceSilent
from rig.link.faults import FaultScript, drop
from rig.link.memory import MemoryStream
from rig.twins.ascii_chamber import AsciiChamberTwin
from rig.twins.modbus_slave import ModbusSlave
from rig.twins.watlow_f4 import WatlowF4Twin
from rig.twins.watlow_f4t import AUTO, OFF, WatlowF4TTwin
from rig.wire.chamber_text import MODELS

LIMITS = {"port": "twin", "limits_degc": (10.0, 40.0)}
EVER = 99
TEXT = [model for model in MODELS if model != "thermotron-3800"]
"""Those that are set before they are started."""


class Room(StillRoom):
    """What a chamber heard: ``garbles`` set points more are heard as 80 °C, a digit turned over on the line."""

    def __init__(self) -> None:
        super().__init__()
        self.garbles = 0
        self.heard: list[float] = []

    def hold(self, environment: str, setpoint_degc: float, now_s: float) -> None:
        super().hold(environment, setpoint_degc, now_s)
        self.heard.append(setpoint_degc)

    def as_heard(self, setpoint_degc: float) -> float:
        self.garbles -= 1
        return 80.0 if self.garbles >= 0 else setpoint_degc


class Line:
    """Twin and driver of a text chamber; the twin hears what the line made of a set point."""

    def __init__(self, model: str) -> None:
        self.room, self.clock, self.faults = Room(), virtual_clock(), FaultScript()
        self.twin = AsciiChamberTwin("air", self.room, model=model)
        table = LIMITS | {"driver": "ascii-chamber", "model": model, "pause_s": 0.01}
        table |= {} if model == "thermotron-8800" else {"values": "degc"}
        settings = AsciiChamberSettings.model_validate(table)
        self.air = AsciiChamber("air", settings, MemoryStream(self, self.clock, "chamber", self.faults))

    def receive(self, data: bytes, now_s: float) -> None:
        for sent in (b"SETP1,", b"TEMP, S"):
            if data.startswith(sent):
                degc = self.room.as_heard(float(data.removeprefix(sent)))
                # An Espec repeats the command that it heard, which is not what was sent: the line damages that as well.
                self.twin.receive(data.replace(b"%.1f" % float(data.removeprefix(sent)), b"%.1f" % degc), now_s)
                return
        self.twin.receive(data, now_s)

    def transmit(self, now_s: float) -> bytes:
        return self.twin.transmit(now_s).replace(b"OK:TEMP, S80.0", b"OK:TEMP, S20.0")

    def next_event_s(self) -> float | None:
        return None

    @property
    def is_at_work(self) -> bool:
        return self.twin.mode == "CONSTANT"


class Registers(WatlowF4TTwin):
    """An F4T that hears what the line made of a set point."""

    def _take(self, setpoint_degc: float, now_s: float) -> None:
        room = self._world
        assert isinstance(room, Room)
        super()._take(room.as_heard(setpoint_degc), now_s)


class F4T:
    """Twin and driver; its loop in the mode that somebody left it in."""

    def __init__(self, mode: int, transport: str = "tcp") -> None:
        self.room, self.clock, self.faults = Room(), virtual_clock(), FaultScript()
        self.twin = Registers("air", self.room, mode=mode)
        settings = WatlowF4TSettings.model_validate(LIMITS | {"driver": "watlow-f4t", "transport": transport})
        stream = MemoryStream(ModbusSlave(self.twin, framing=settings.transport), self.clock, "chamber", self.faults)
        self.air: WatlowF4T = watlow_f4t.connect("air", settings, stream)

    @property
    def is_at_work(self) -> bool:
        return self.twin.mode == AUTO


class F4:
    """Twin and driver; it is at work whenever its event output says so, which nobody reads."""

    is_at_work = True

    def __init__(self) -> None:
        self.room, self.clock, self.faults = Room(), virtual_clock(), FaultScript()
        room = self.room

        class Heard(WatlowF4Twin):
            def write(self, address: int, values: Sequence[int], now_s: float) -> int:
                (raw,) = values
                return super().write(address, [round(10.0 * room.as_heard(raw / 10.0))], now_s)

        self.twin = Heard("air", self.room)
        settings = WatlowF4Settings.model_validate(LIMITS | {"driver": "watlow-f4"})
        stream = MemoryStream(self.twin, self.clock, "chamber", self.faults)
        self.air: WatlowF4 = watlow_f4.connect("air", settings, stream)


Bench = Line | F4T | F4
BENCHES: dict[str, Callable[[], Bench]] = {
    **{model: lambda model=model: Line(model) for model in MODELS},  # type: ignore[misc]
    "f4t, off": lambda: F4T(OFF),
    "f4t, automatic": lambda: F4T(AUTO),
    "f4t, rtu": lambda: F4T(AUTO, "rtu"),
    "f4": F4,
}


@pytest.fixture(params=sorted(BENCHES))
def bench(request: pytest.FixtureRequest) -> Bench:
    return BENCHES[request.param]()


def _is_harmless(bench: Bench) -> bool:
    return bench.room.held_degc == 25.0 if isinstance(bench, F4) else not bench.is_at_work


def test_a_digit_that_turned_over_once_is_put_right_and_told(bench: Bench) -> None:
    bench.room.garbles = 1
    bench.air.hold(20.0)
    assert (bench.room.held_degc, bench.is_at_work) == (20.0, True)
    sentence = "air: set point 20 °C was written and reads back 80 °C; written once more"
    assert bench.air.setpoint_memory.take_corrections() == (sentence,)
    assert bench.air.setpoint_memory.take_corrections() == ()
    assert bench.air.temperature_degc() == 25.0


@pytest.mark.parametrize("model", TEXT)
def test_a_chamber_that_stands_is_not_started_before_its_set_point_reads_back(model: str) -> None:
    bench, modes = Line(model), []
    hold = bench.room.hold
    bench.room.hold = lambda *heard: (modes.append(bench.twin.mode), hold(*heard))  # type: ignore[method-assign,func-returns-value,assignment]
    bench.room.garbles = EVER
    with pytest.raises(ChamberFault, match="it was not started, and stands"):
        bench.air.hold(20.0)
    assert (modes, bench.twin.mode) == (["STANDBY", "STANDBY"], "STANDBY")


def test_where_it_stays_wrong_the_chamber_is_made_harmless_and_written_to_no_more(bench: Bench) -> None:
    bench.room.garbles = 2  # the way back of an F4 arrives whole
    found = r"air: set point 20 °C was written twice and reads back 80 °C, beyond 10 to 40 °C \(environment.air: limits"
    with pytest.raises(ChamberFault, match=found):
        bench.air.hold(20.0)
    assert _is_harmless(bench)
    heard = list(bench.room.heard)
    with pytest.raises(ChamberFault, match="calrig writes to it no more: set point 20 °C was written twice"):
        bench.air.hold(20.0)
    assert (bench.air.temperature_degc(), bench.room.heard) == (25.0, heard)
    bench.air.setpoint_memory.overrule()  # a person asks for it by hand
    bench.air.hold(21.0)
    assert (bench.room.held_degc, bench.is_at_work) == (21.0, True)


def test_one_that_was_at_work_is_made_harmless_as_well(bench: Bench) -> None:
    bench.air.hold(25.0)
    bench.room.garbles = 2
    with pytest.raises(ChamberFault, match="set point 20 °C was written twice and reads back 80 °C"):
        bench.air.hold(20.0)
    assert _is_harmless(bench)


def test_one_that_cannot_be_made_harmless_is_told_with_where_it_is_heading() -> None:
    bench = F4()
    bench.room.held_degc = 60.0  # somebody left it beyond the limits: no way back
    bench.room.garbles = EVER
    with pytest.raises(ChamberFault, match=r"air: the chamber is heading for 80 °C: set point .* stop it at its panel"):
        bench.air.hold(20.0)
    deaf = Line("espec-p300")
    deaf.air.hold(25.0)
    deaf.room.garbles = EVER
    deaf.twin._espec = _refusing(deaf.twin, b"MODE,STANDBY")  # type: ignore[method-assign,assignment]
    with pytest.raises(ChamberFault, match=r"heading for 80 °C: .*refuses MODE,STANDBY: NA:PROTECT ON"):
        deaf.air.hold(20.0)


def _refusing(twin: AsciiChamberTwin, command: bytes) -> Callable[[bytes, float], bytes]:
    answered = twin._espec
    return lambda line, now_s: b"NA:PROTECT ON" if line == command else answered(line, now_s)


def test_one_whose_line_falls_silent_before_the_read_back_is_put_right_at_the_next_look() -> None:
    """Nobody knows what was heard: whatever is found then may be ours, and an old one means that nothing arrived."""
    for garbles, held_degc in ((1, 20.0), (0, 20.0)):
        bench = F4T(AUTO)
        bench.air.hold(25.0)
        bench.room.garbles = garbles
        asked = bench.faults.taken
        # Unit, profile, mode, set point, mode, set point, the write; then the read-back, asked three times.
        bench.faults.reads = dict.fromkeys(range(asked + 7, asked + 10), drop)
        with pytest.raises(DeviceSilent):
            bench.air.hold(20.0)
        assert bench.room.held_degc == (80.0 if garbles else 20.0)
        bench.air.temperature_degc()
        assert (bench.room.held_degc, bench.twin.mode) == (held_degc, AUTO)


def test_a_set_point_that_was_refused_is_not_written_again_at_the_next_look() -> None:
    bench = Line("espec-p300")
    answered = bench.twin._espec
    bench.twin._espec = _refusing(bench.twin, b"TEMP, S30.0")  # type: ignore[method-assign,assignment]
    with pytest.raises(DeviceRefused, match="PROTECT ON"):
        bench.air.hold(30.0)
    bench.twin._espec = answered  # type: ignore[method-assign,assignment]
    assert (bench.air.temperature_degc(), bench.room.heard) == (25.0, [])


class TakesAtStart(AsciiChamberTwin):
    """An 8800 that takes a set point when it starts, as a 3800 does, or while it runs."""

    waiting: bytes | None = None

    def _thermotron_write(self, line: bytes, now_s: float) -> bool:
        if line.startswith(b"SETP") and self.mode == "STANDBY":
            self.waiting = line
            return True
        if line == b"RUNM" and self.waiting is not None:
            super()._thermotron_write(self.waiting, now_s)
        return super()._thermotron_write(line, now_s)


def test_an_8800_that_takes_a_set_point_at_its_start_is_started_at_an_allowed_one() -> None:
    bench = Line("thermotron-8800")
    bench.twin = TakesAtStart("air", bench.room, model="thermotron-8800")
    bench.air.hold(20.0)
    assert (bench.room.held_degc, bench.twin.mode) == (20.0, "CONSTANT")
    hot = Line("thermotron-8800")
    hot.twin = TakesAtStart("air", hot.room, model="thermotron-8800")
    hot.room.held_degc = 80.0  # as somebody left it: it is not started there
    with pytest.raises(ChamberFault, match=r"reads back 80 °C, beyond 10 to 40 °C .*; it was not started, and stands"):
        hot.air.hold(20.0)
    assert hot.twin.mode == "STANDBY"


def test_what_a_person_set_stays_and_is_told_with_where_it_is_heading(bench: Bench) -> None:
    bench.air.hold(20.0)
    bench.room.held_degc = 80.0
    heading = (
        r"somebody set it since.*; nothing was written over it: the chamber is heading for 80 °C, beyond 10 to 40 °C"
    )
    with pytest.raises(ChamberFault, match=heading):
        bench.air.temperature_degc()
    assert (bench.room.held_degc, bench.is_at_work) == (80.0, True)
