"""Facts of chambers that speak lines of text, put to driver and twin: docs/devices/ascii-chambers.md."""

import pytest
from gpib_rig import virtual_clock
from pydantic import ValidationError

from rig.devices.ascii_chamber import AsciiChamber, AsciiChamberSettings
from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, DeviceSilent, RequestRefused
from rig.link import faults
from rig.link.faults import FaultScript
from rig.link.memory import MemoryStream
from rig.twins.ascii_chamber import AsciiChamberTwin
from rig.wire.chamber_text import MODELS, chamber_words

END = {"thermotron-8800": b"\r", "thermotron-3800": b"\r", "espec-p300": b"\r\n", "espec-scp220": b"\r\n"}


class Room:
    """An environment that is at once where it is held."""

    def __init__(self) -> None:
        self.degc = 25.0
        self.held_degc = 25.0

    def read_temperature_degc(self, environment: str, now_s: float) -> float:
        return self.degc

    def setpoint_degc(self, environment: str) -> float:
        return self.held_degc

    def hold(self, environment: str, setpoint_degc: float, now_s: float) -> None:
        self.degc = self.held_degc = setpoint_degc


class Bench:
    """A chamber of one model, its room, and the line between."""

    def __init__(self, model: str, *, fahrenheit: bool = False, **changes: object) -> None:
        self.room, self.clock, self.faults = Room(), virtual_clock(), FaultScript()
        address = 3 if "address" in changes else None
        self.twin = AsciiChamberTwin(
            "air",
            self.room,
            model=model,
            is_fahrenheit=fahrenheit,
            address=address,
        )
        table: dict[str, object] = {"driver": "ascii-chamber", "port": "twin", "model": model}
        if model != "thermotron-8800":
            table["values"] = "degf" if fahrenheit else "degc"
        self.stream = MemoryStream(self.twin, self.clock, "chamber", self.faults)
        self.air = AsciiChamber("air", AsciiChamberSettings.model_validate(table | changes), self.stream)
        self._end = END[model]

    def said(self, command: bytes) -> bytes:
        self.twin.receive(command + self._end, 0.0)
        return self.twin.transmit(0.0)


@pytest.mark.parametrize("model", MODELS)
def test_a_chamber_goes_where_it_is_told_and_runs(model: str) -> None:
    bench = Bench(model)
    assert bench.air.temperature_degc() == 25.0
    bench.air.hold(-20.5)
    assert bench.room.held_degc == -20.5
    assert bench.twin.mode == "CONSTANT"
    assert bench.air.setpoint_degc() == bench.air.temperature_degc() == -20.5


def test_an_8800_answers_every_write() -> None:
    # T-ICD, AUXE: "8800 response: 0". A driver that does not read it takes it for the next temperature: 0.0.
    bench = Bench("thermotron-8800")
    assert bench.said(b"SETP1,30.0") == b"0\r\n"
    bench.air.hold(30.0)
    assert bench.air.temperature_degc() == 30.0
    assert bench.stream.discard_input() == b""


def test_a_3800_takes_a_set_point_at_the_next_start_only() -> None:
    # T-38: "After setpoint is set to a new value, the "run()" command must be called to tell the oven to run to the new
    # temperature."; nothing is read behind a write, and at least 1 s is waited.
    bench = Bench("thermotron-3800")
    bench.said(b"RUNM")
    assert bench.said(b"SETP1,40.0") == b""
    assert bench.said(b"SETP1?") == b"25.0\r\n"
    bench.said(b"RUNM")
    assert bench.said(b"SETP1?") == b"40.0\r\n"
    began_s = bench.clock.monotonic_s()
    bench.air.hold(50.0)
    assert bench.room.held_degc == 50.0
    assert bench.clock.monotonic_s() - began_s >= 2.0  # a rest behind SETP and one behind RUNM


def test_mode_bits_of_a_3800() -> None:
    # T-38: 1 program, 2 edit from stop, 4 view, 8 edit from hold, 16 manual.
    bench = Bench("thermotron-3800")
    assert bench.said(b"MODE?") == b"0\r\n"
    bench.said(b"RUNM")
    assert bench.said(b"MODE?") == b"16\r\n"
    bench.twin.mode = "RUN"
    assert bench.said(b"MODE?") == b"1\r\n"
    parse = chamber_words("thermotron-3800").parse_activity
    text = {b"0": "stopped", b"1": "program", b"2": "stopped", b"8": "program", b"16": "holding", b"17": "program"}
    assert {bits: parse(bits) for bits in text} == text


def test_stop_codes_of_an_8800() -> None:
    # T-88: 1 running, 5 STOP by computer.
    bench = Bench("thermotron-8800")
    assert bench.said(b"SCOD?") == b"5\r\n"
    bench.said(b"RUNM")
    assert bench.said(b"SCOD?") == b"1\r\n"


def test_espec_answers_repeat_a_write_and_say_why_not() -> None:
    # PR3J and notes: TEMP, S25.0 -> OK:TEMP, S25.0; ECC: NA: and a text; four numbers to TEMP?.
    bench = Bench("espec-p300")
    assert bench.said(b"TEMP, S25.0") == b"OK:TEMP, S25.0\r\n"
    assert bench.said(b"TEMP?") == b"25.0,25.0,180.0,-70.0\r\n"
    assert bench.said(b"CONSTANT SET?,TEMP") == b"25.0,ON\r\n"
    assert bench.said(b"TEMP, S900.0") == b"NA:DATA OUT OF RANGE\r\n"
    assert bench.said(b"NONE?") == b"NA:CMD ERR\r\n"
    # ECC: MON? has an empty second field on a chamber without humidity.
    assert bench.said(b"MON?") == b"25.0,,STANDBY,0\r\n"


def test_a_set_point_does_not_start_an_espec_and_the_driver_does() -> None:
    # ECC: TEMP, S25.0 is the "set point of the constant mode; does not start the chamber"; MODE,CONSTANT does.
    bench = Bench("espec-p300")
    bench.said(b"TEMP, S30.0")
    assert bench.said(b"MODE?") == b"STANDBY\r\n"
    bench.air.hold(31.0)
    assert bench.said(b"MODE?") == b"CONSTANT\r\n"


def test_on_rs485_an_espec_answers_to_its_address_alone() -> None:
    # ECC: RS-485: "1,TEMP?" CR LF, address and comma in front.
    bench = Bench("espec-p300", address=3)
    assert bench.said(b"TEMP?") == b""
    assert bench.said(b"3,MODE?") == b"STANDBY\r\n"
    bench.air.hold(15.0)
    assert bench.room.held_degc == 15.0


@pytest.mark.parametrize("model", ["thermotron-3800", "espec-p300"])
def test_no_set_point_is_written_while_a_program_runs(model: str) -> None:
    bench = Bench(model)
    bench.twin.mode = "RUN"
    with pytest.raises(DeviceRefused, match="a program runs or is held"):
        bench.air.hold(40.0)
    assert bench.room.held_degc == 25.0


@pytest.mark.parametrize("model", MODELS)
def test_a_chamber_that_stops_by_itself_while_we_hold_is_a_fault(model: str) -> None:
    # T-88: 2 stop key, 7 process alarm, 9 power fail, 10 Therm-Alarm.
    bench = Bench(model)
    bench.air.hold(40.0)
    bench.twin.mode = "STANDBY"
    with pytest.raises(DeviceFault, match=r"the chamber has stopped.* since the set point was written"):
        bench.air.temperature_degc()


@pytest.mark.parametrize("model", MODELS)
def test_a_set_point_that_somebody_wrote_while_we_hold_is_a_fault_and_stays(model: str) -> None:
    # An Espec's TEMP? has the set point in force beside the temperature; of a Thermotron SETPn? is asked.
    bench = Bench(model)
    bench.air.hold(40.0)
    assert bench.air.temperature_degc() == 40.0
    bench.room.held_degc = 85.0
    for work in (bench.air.temperature_degc, lambda: bench.air.hold(30.0)):
        with pytest.raises(DeviceFault, match="calrig set it to 40 °C, and now the set point is 85 °C: somebody set"):
            work()
    assert bench.room.held_degc == 85.0


@pytest.mark.parametrize("model", MODELS)
def test_a_chamber_that_was_stopped_while_we_held_is_not_started_again(model: str) -> None:
    bench = Bench(model)
    bench.air.hold(40.0)
    bench.twin.mode = "STANDBY"
    with pytest.raises(DeviceFault, match="calrig set it to 40 °C, and now it stands: somebody set"):
        bench.air.hold(30.0)
    assert (bench.twin.mode, bench.room.held_degc) == ("STANDBY", 40.0)


def test_fahrenheit_on_the_wire_is_told_by_an_8800() -> None:
    # T-ICD, CCHRn?: "Send process variable units character": 77 is 25 degC.
    bench = Bench("thermotron-8800", fahrenheit=True)
    assert bench.said(b"PVAR1?") == b"77.0\r\n"
    assert bench.air.temperature_degc() == pytest.approx(25.0)
    bench.air.hold(30.0)
    assert bench.room.held_degc == pytest.approx(30.0)
    with pytest.raises(DeviceNonsense, match=r"set to °F, the rig file says 'degc'"):
        Bench("thermotron-8800", fahrenheit=True, values="degc").air.identify()


def test_a_unit_that_changes_meanwhile_is_a_fault() -> None:
    bench = Bench("thermotron-8800")
    bench.air.hold(30.0)
    bench.twin.is_fahrenheit = True
    for work in (bench.air.temperature_degc, lambda: bench.air.hold(31.0)):
        with pytest.raises(DeviceFault, match="the unit was °C and is °F"):
            work()
    assert bench.room.held_degc == 30.0


@pytest.mark.parametrize("model", ["thermotron-3800", "espec-p300", "espec-scp220"])
def test_where_it_cannot_be_asked_the_file_states_the_unit(model: str) -> None:
    # T-38: "Default unit is Celsius, unless changed by the user"; no unit query in T-38 nor in ECC.
    with pytest.raises(ValidationError, match="cannot be asked for its unit; look at its panel"):
        AsciiChamberSettings.model_validate({"driver": "ascii-chamber", "port": "twin", "model": model})
    bench = Bench(model, fahrenheit=True)
    assert bench.air.temperature_degc() == pytest.approx(25.0)


def test_limits_of_the_file_and_of_the_chamber_are_kept() -> None:
    bench = Bench("espec-p300", limits_degc=[-100.0, 300.0])
    for wrong_degc, why in ((181.0, "the chamber allows -70 to 180 °C"), (301.0, "allowed -100 to 300 °C")):
        with pytest.raises(RequestRefused, match=why):
            bench.air.hold(wrong_degc)
    with pytest.raises(RequestRefused, match=r"takes tenths of a °C; .* the nearest is 20.1"):
        bench.air.hold(20.06)
    assert bench.room.held_degc == 25.0
    assert bench.twin.mode == "STANDBY"


def test_what_it_does_not_take_is_said_in_its_own_words() -> None:
    refusing = Bench("espec-p300")
    refusing.faults.reads = {3: faults.replace(b"NA:PROTECT ON\r\n")}  # mode, limits, set point, then the write
    with pytest.raises(DeviceRefused, match=r"the chamber refuses TEMP, S30\.0: NA:PROTECT ON"):
        refusing.air.hold(30.0)
    other = Bench("thermotron-8800", limits_degc=[-100.0, 300.0])
    with pytest.raises(DeviceRefused, match=r"refuses SETP1,250.0: it answers 1"):
        other.air.hold(250.0)


def test_a_set_point_that_reads_back_otherwise_is_a_fault() -> None:
    bench = Bench("espec-p300")
    # Mode, limits, set point, write, then the read-back; write, read-back.
    bench.faults.reads = dict.fromkeys((4, 6), faults.replace(b"29.0,ON\r\n"))
    with pytest.raises(DeviceFault, match="set point 30 °C was written twice and reads back 29 °C; it was not started"):
        bench.air.hold(30.0)


def test_a_late_answer_is_nobodys() -> None:
    bench = Bench("thermotron-8800")
    bench.air.identify()
    bench.faults.reads = {bench.faults.taken + 1: faults.delay(3.2)}  # the temperature, later than it is waited for
    assert bench.air.temperature_degc() == 25.0
    bench.air.hold(35.0)
    assert bench.air.setpoint_degc() == 35.0


def test_an_implausible_temperature_is_a_fault_and_silence_is_named() -> None:
    bench = Bench("espec-p300")
    bench.room.degc = 300.0
    with pytest.raises(DeviceFault, match="not plausible"):
        bench.air.temperature_degc()
    silent = Bench("espec-p300", reply_end="cr")
    silent.twin = AsciiChamberTwin("air", silent.room, model="thermotron-3800")
    deaf = AsciiChamber("air", AsciiChamberSettings.model_validate(
        {"driver": "ascii-chamber", "port": "twin", "model": "espec-p300", "values": "degc"}
    ), MemoryStream(silent.twin, silent.clock, "chamber"))  # fmt: skip
    with pytest.raises(DeviceSilent, match="nothing came at all"):
        deaf.identify()


def test_an_acknowledgement_may_leave_out_the_blanks_of_the_command() -> None:
    # The page of the RS-485 protocol writes blanks freely ("OK : address, setting command"); the value is compared.
    check = chamber_words("espec-p300").check_acknowledged
    assert check is not None
    assert check(b"TEMP, S25.0", b"OK:TEMP,S25.0") == check(b"TEMP, S25.0", b"OK: TEMP, S25.0") == ""
    for other in (b"OK:TEMP,S26.0", b"OK:TEMP,H25.0", b"OK:"):
        with pytest.raises(DeviceNonsense):
            check(b"TEMP, S25.0", other)


@pytest.mark.parametrize("shape", [b"OK:3,%s", b"OK : 3,%s", b"OK:%s"])
def test_on_rs_485_an_acknowledgement_may_name_the_address(shape: bytes) -> None:
    # Communication Function RS-485, 4013304025610, p. 8: "When the setting command is correctly processed
    # "OK : address, setting command""; of a sister series of the same maker.
    check = chamber_words("espec-p300").check_acknowledged
    assert check is not None
    assert check(b"TEMP, S30.0", shape % b"TEMP, S30.0") == ""
    with pytest.raises(DeviceNonsense):
        check(b"TEMP, S30.0", shape % b"TEMP, S31.0")
    bench = Bench("espec-p300", address=3)
    bench.air.hold(30.0)
    assert bench.room.held_degc == 30.0
    assert bench.twin.mode == "CONSTANT"
