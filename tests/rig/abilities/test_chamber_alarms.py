"""Alarms that chambers tell: by which question, and in which words. Sources: docs/devices of each."""

import pytest
from gpib_rig import virtual_clock
from still_room import StillRoom

from rig.abilities.chamber_alarms import TellsAlarms, alarm_clause
from rig.devices.ascii_chamber import AsciiChamber, AsciiChamberSettings
from rig.devices.watlow_f4 import WatlowF4
from rig.devices.watlow_f4t import WatlowF4TSettings, connect
from rig.errors import ChamberFault, DeviceNonsense
from rig.link import faults
from rig.link.faults import FaultScript
from rig.link.memory import MemoryStream
from rig.twins.ascii_chamber import AsciiChamberTwin
from rig.twins.modbus_slave import ModbusSlave
from rig.twins.watlow_f4t import WatlowF4TTwin
from rig.wire.chamber_text import chamber_words


class TextBench:
    """A chamber that speaks lines of text, and its twin."""

    def __init__(self, model: str) -> None:
        self.twin, self.faults = AsciiChamberTwin("air", StillRoom(), model=model), FaultScript()
        values = {} if model == "thermotron-8800" else {"values": "degc"}
        table = {"driver": "ascii-chamber", "port": "twin", "model": model, "pause_s": 0.01} | values
        stream = MemoryStream(self.twin, virtual_clock(), "chamber", self.faults)
        self.air = AsciiChamber("air", AsciiChamberSettings.model_validate(table), stream)


def test_an_espec_tells_how_many_and_their_codes() -> None:
    # ECC: ALARM? -> n,code,code...; none: 0.
    parse = chamber_words("espec-p300").parse_alarms
    assert parse(b"0") == ()
    assert parse(b"2,3,12") == ("alarm 3 (ALARM?)", "alarm 12 (ALARM?)")
    for damaged in (b"2,3", b"", b"0,1", b"x", b"1,"):
        with pytest.raises(DeviceNonsense, match="ALARM"):
            parse(damaged)
    bench = TextBench("espec-p300")
    assert bench.air.alarms() == ()
    bench.twin.alarms = (3,)
    assert alarm_clause(bench.air) == "; the chamber tells alarm 3 (ALARM?)"


def test_an_8800_tells_a_sum_of_deviations() -> None:
    # T-ICD: ALRM2? -> 1: sum of 1 low deviation, 2 high deviation, 16 low process, 32 high process.
    parse = chamber_words("thermotron-8800").parse_alarms
    assert parse(b"0") == ()
    assert parse(b"1") == ("an alarm: low deviation (ALRM reads 1)",)
    assert parse(b"34") == ("an alarm: high deviation, high process (ALRM reads 34)",)
    bench = TextBench("thermotron-8800")
    bench.twin.alarms = (32,)
    assert bench.air.alarms() == ("an alarm: high process (ALRM reads 32)",)


@pytest.mark.parametrize(
    ("code", "words"), [(7, "process alarm, SCOD 7"), (2, "stop key, SCOD 2"), (77, "has stopped since")]
)
def test_an_8800_that_stopped_says_why(code: int, words: str) -> None:
    # T-88: 2 stop key, 7 process alarm.
    bench = TextBench("thermotron-8800")
    bench.air.hold(30.0)
    bench.twin.mode, bench.twin.stop_code, bench.twin.alarms = "STANDBY", code, (32,)
    with pytest.raises(ChamberFault, match=words) as raised:
        bench.air.temperature_degc()
    assert "; the chamber tells an alarm: high process (ALRM reads 32); look at its panel" in str(raised.value)


def test_of_a_3800_no_question_is_known_and_none_is_asked() -> None:
    bench = TextBench("thermotron-3800")
    asked = bench.faults.written
    assert bench.air.alarms() == ()
    assert bench.faults.written == asked


@pytest.mark.parametrize("transport", ["tcp", "rtu"])
def test_an_f4t_is_asked_alarm_by_alarm_as_far_as_it_has_them(transport: str) -> None:
    # ECC: 1356 + 100 (n - 1); 88, 61, 12 are no alarm.
    twin = WatlowF4TTwin("air", StillRoom())
    settings = WatlowF4TSettings.model_validate({"driver": "watlow-f4t", "port": "twin", "transport": transport})
    slave = ModbusSlave(twin, framing=settings.transport)
    air = connect("air", settings, MemoryStream(slave, virtual_clock(), "chamber"))
    assert air.alarms() == ()
    twin.alarms = [88, 6, 12, 61]
    assert air.alarms() == ("alarm 2 (register 1456 reads 6)",)
    slave.refusals = {1356: 2}
    assert air.alarms() == ()


@pytest.mark.parametrize(
    ("status", "expected"),
    [
        (138, ()),
        (32, ("that it has failed (register 90 reads 32)",)),
        (7, ("an unknown status (register 90 reads 7)",)),
        (None, ()),
    ],
)
def test_an_f4t_that_calls_itself_failed_is_told(status: int | None, expected: tuple[str, ...]) -> None:
    # F4T user's guide p. 225: Device Status "OK (138) Fail (32)", unsigned 16-bit, register 90.
    twin = WatlowF4TTwin("air", StillRoom())
    settings = WatlowF4TSettings.model_validate({"driver": "watlow-f4t", "port": "twin", "transport": "tcp"})
    slave = ModbusSlave(twin, framing=settings.transport)
    air = connect("air", settings, MemoryStream(slave, virtual_clock(), "chamber"))
    twin.status = status
    assert air.alarms() == expected


def test_who_cannot_be_asked_has_no_clause() -> None:
    assert not issubclass(WatlowF4, TellsAlarms)
    assert alarm_clause(object()) == ""
    bench = TextBench("espec-p300")
    bench.faults.reads = dict.fromkeys(range(9), faults.replace(b"NA:CMD ERR\r\n"))
    assert alarm_clause(bench.air) == ""
