"""What the manuals say of data-acquisition units, put to driver and twin: docs/devices/scpi-daq.md, by its pages."""

import numpy as np
import pytest
from daq_rig import DaqRig, daq_rig, daq_settings
from pydantic import ValidationError

from rig.devices.scpi_daq import ScpiDaqReadout
from rig.errors import DeviceNonsense, RigError
from rig.link import faults
from rig.link.memory import MemoryStream
from rig.link.messages import StreamMessages
from rig.wire import scpi

MODELS = {"34970A": 101, "34980A": 1001, "DAQ970A": 101}
IMPEDANCE = {"34970A": b"INP:IMP:AUTO", "34980A": b"VOLT:DC:IMP:AUTO", "DAQ970A": b"VOLT:DC:IMP:AUTO"}


def _rig(model: str) -> tuple[DaqRig, int]:
    number = MODELS[model]
    return daq_rig(model, {number: "daq.x", number + 1: "daq.y"}), number


def _said(rig: DaqRig, message: bytes) -> bytes:
    rig.port.receive(message + b"\n", 0.0)
    return rig.port.transmit(10.0)


def _readout(rig: DaqRig, model: str, **changes: object) -> ScpiDaqReadout:
    number = MODELS[model]
    channels = {"x": {"channel": number, "range_v": 10.0}, "y": {"channel": number + 1, "range_v": 100.0}}
    return rig.prepared(**({"model": model, "channels": channels} | changes))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("header", [b"CONF:VOLT:DC 10,", b"MEAS:VOLT:DC? 10,"])
def test_configure_turns_off_what_stands_beside_a_reading(model: str, header: bytes) -> None:
    # UG-K p. 118, 980-UG p. 123: "The MEASure? and CONFigure commands automatically turn off the units, time, channel,
    # and alarm information."
    rig, number = _rig(model)
    _said(rig, b"FORM:READ:UNIT 1;TIME 1;CHAN 1;ALAR 1")
    assert _said(rig, b"FORM:READ:UNIT?;TIME?;CHAN?;ALAR?") == b"1;1;1;1\n"
    _said(rig, header + b"(@%d)" % number)
    assert _said(rig, b"FORM:READ:UNIT?;TIME?;CHAN?;ALAR?") == b"0;0;0;0\n"


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("header", [b"CONF:VOLT:DC 10,", b"MEAS:VOLT:DC? 10,"])
def test_configure_selects_ten_megohm(model: str, header: bytes) -> None:
    # 980-CR VOLT:DC:IMP:AUTO: "The CONFigure and MEASure? commands automatically select AUTO OFF (fixed at 10 MΩ for
    # all ranges)." For the 34970A this is remembered: its twin does so too, since the driver must bear it.
    rig, number = _rig(model)
    where = b"(@%d)" % number
    _said(rig, IMPEDANCE[model] + b" ON," + where)
    assert _said(rig, IMPEDANCE[model] + b"? " + where) == b"1\n"
    _said(rig, header + where)
    assert _said(rig, IMPEDANCE[model] + b"? " + where) == b"0\n"


def test_preset_does_not_change_the_input_resistance() -> None:
    # 980-CR: "An Instrument Preset (SYSTem:PRESet command) … does not change the input resistance setting."; "The
    # instrument selects 10 MΩ … after a Factory Reset ( *RST command)."
    rig, _ = _rig("34980A")
    _said(rig, b"VOLT:DC:IMP:AUTO ON,(@1001)")
    _said(rig, b"SYST:PRES")
    assert _said(rig, b"VOLT:IMP:AUTO? (@1001,1002)") == b"1,0\n"
    _said(rig, b"*RST")
    assert _said(rig, b"VOLT:IMP:AUTO? (@1001)") == b"0\n"


def test_without_a_list_the_one_takes_the_scan_list_and_the_other_its_own_meter() -> None:
    # UG-97 p. 182: "If you omit the ch_list parameter, the command will be applied to the channels in the active scan
    # list." 980-CR: "this command applies to the internal DMM, independent of any channels or a scan list."
    for model, found in (("34970A", b"1\n"), ("34980A", b"0\n")):
        rig, number = _rig(model)
        _said(rig, b"ROUT:SCAN (@%d)" % number)
        _said(rig, IMPEDANCE[model] + b" ON")
        assert _said(rig, IMPEDANCE[model] + b"? (@%d)" % number) == found


def test_autozero_outlives_a_reset_of_the_34970a_and_ends_below_one_cycle() -> None:
    # UG-97 p. 105: "The autozero setting is stored in non-volatile memory, and does not change when power has been off,
    # after a Factory Reset (*RST command) …"; "Autozero is automatically turned off when you select an integration time
    # less than 1 PLC."
    rig, _ = _rig("34970A")
    _said(rig, b"ZERO:AUTO OFF,(@101)")
    _said(rig, b"*RST")
    assert _said(rig, b"ZERO:AUTO? (@101)") == b"0\n"
    _said(rig, b"ZERO:AUTO ON,(@101)")
    _said(rig, b"VOLT:DC:NPLC 0.2,(@101)")
    assert _said(rig, b"ZERO:AUTO? (@101)") == b"0\n"


def test_reset_and_preset_empty_the_memory_and_configure_does_on_a_34980a() -> None:
    # UG-K p. 122: "The instrument clears all readings in memory after a Factory Reset (*RST command) or Instrument
    # Preset". 980-CR: "clears all readings from memory … when any measurement parameters are changed (CONFigure …".
    for model, commands in (("34970A", (b"*RST", b"SYST:PRES")), ("34980A", (b"*RST", b"CONF:VOLT:DC 1,(@1002)"))):
        for command in commands:
            rig, number = _rig(model)
            _said(rig, b"CONF:VOLT:DC 10,(@%d);:INIT" % number)
            assert _said(rig, b"DATA:POIN?") == b"+1\n"
            _said(rig, command)
            assert _said(rig, b"DATA:POIN?") == b"+0\n"


def test_a_list_is_scanned_upward_and_what_a_card_lacks_is_skipped_inside_a_range() -> None:
    # UG-97 p. 182: ascending by channel whatever the order; "the instrument will skip the illegal channels and will not
    # generate an error" inside a range, an error at its end.
    rig, _ = _rig("34970A")
    _said(rig, b"ROUT:SCAN (@103,101,102)")
    assert _said(rig, b"ROUT:SCAN?") == b"#214(@101,102,103)\n"
    assert _said(rig, b"ROUT:SCAN (@119:130);:SYST:ERR?") == b'-222,"Data out of range"\n'
    assert _said(rig, b"ROUT:SCAN?") == b"#214(@101,102,103)\n"


def test_read_and_measure_answer_at_once_and_leave_the_memory_empty() -> None:
    # UG-K p. 122: "Readings are not stored in the instrument's internal memory when using the READ? command."
    rig, _ = _rig("34970A")
    assert float(_said(rig, b"MEAS:VOLT:DC? 10,0.003,(@101)")) == pytest.approx(1.0, abs=1e-4)
    assert _said(rig, b"DATA:POIN?") == b"+0\n"


def test_readings_are_taken_out_of_memory_oldest_first() -> None:
    # 980-CR DATA:REM?: so many readings leave the memory, the oldest first.
    rig, _ = _rig("34970A")
    _said(rig, b"CONF:VOLT:DC 10,(@101);:TRIG:COUN 3;:INIT")
    assert _said(rig, b"DATA:REM? 2") == b"+1.00000100E+00,+1.00000200E+00\n"
    assert _said(rig, b"DATA:POIN?") == b"+1\n"


def test_a_daq970a_is_who_its_guide_says_and_configure_sets_its_delay_to_automatic() -> None:
    # DAQ-PG p. 149: the identity. DAQ-PG p. 205: "The CONFigure and MEASure? commands set the channel delay to
    # automatic."
    rig, _ = _rig("DAQ970A")
    identity = b"Keysight Technologies,DAQ970A,MY12345678,A.02.04-00.16-11.29-00.02-02-01\n"
    assert _said(rig, b"*IDN?") == identity
    _said(rig, b"ROUT:CHAN:DEL 2,(@101)")
    assert _said(rig, b"ROUT:CHAN:DEL? (@101)") == b"+2.00000000E+00\n"
    _said(rig, b"CONF:VOLT:DC 10,(@101)")
    assert _said(rig, b"ROUT:CHAN:DEL? (@101)") == b"+0.00000000E+00\n"


def test_relays_and_status_are_answered() -> None:
    # ROUT:CLOS? answers 0 or 1 a channel; SCPI-99: *STB? has bit 2 set while the error queue holds something.
    rig, _ = _rig("34970A")
    _said(rig, b"ROUT:CLOS (@101)")
    assert _said(rig, b"ROUT:CLOS? (@101,102)") == b"1,0\n"
    assert _said(rig, b"*STB?") == b"+0\n"
    _said(rig, b"BEEP")
    assert _said(rig, b"*STB?") == b"+4\n"


@pytest.mark.parametrize("model", MODELS)
def test_each_burst_has_its_channel_and_its_impedance(model: str) -> None:
    rig, number = _rig(model)
    readout = _readout(rig, model)
    for channel, level_v in (("daq.x", 1.0), ("daq.y", -2.0), ("daq.x", 1.0)):
        np.testing.assert_allclose(readout.read(channel, 3, rig.wait).samples, level_v, atol=1e-4)
    assert _said(rig, IMPEDANCE[model] + b"? (@%d)" % number) == b"1\n"
    assert _said(rig, b"FORM:READ:UNIT?;TIME?;CHAN?;ALAR?") == b"0;0;1;0\n"


@pytest.mark.parametrize("model", MODELS)
def test_ten_megohm_may_be_chosen(model: str) -> None:
    rig, number = _rig(model)
    _readout(rig, model, high_impedance=False).read("daq.x", 1, rig.wait)
    assert _said(rig, IMPEDANCE[model] + b"? (@%d)" % number) == b"0\n"


OF_THE_CHANNEL = {
    b'FUNC "RES",(@101)': r"SENS:FUNC\? \(@101\) reads back RES, it was set to VOLT",
    b"VOLT:DC:RANG 100,(@101)": r"RANG\? \(@101\) reads back 100, it was set to 10",
    b"VOLT:DC:RANG:AUTO ON,(@101)": r"RANG:AUTO\? \(@101\) reads back 1, it was set to 0",
    b"VOLT:DC:NPLC 2,(@101)": r"NPLC\? \(@101\) reads back 2, it was set to 1",
    b"ZERO:AUTO OFF,(@101)": r"ZERO:AUTO\? \(@101\) reads back 0, it was set to 1",
    b"INP:IMP:AUTO OFF,(@101)": r"INP:IMP:AUTO\? \(@101\) reads back 0, it was set to 1",
    b"CALC:SCAL:GAIN 10,(@101);STAT ON,(@101)": r"CALC:SCAL:STAT\? \(@101\) reads back 1, it was set to 0",
    b"ROUT:CHAN:DEL 0,(@101)": r"ROUT:CHAN:DEL\? \(@101\) reads back 0, it was set to 0\.02",
}
OF_THE_UNIT = {
    b"TRIG:COUN 3": r"TRIG:COUN\? reads back 3, it was set to 2",
    b"TRIG:SOUR BUS": r"TRIG:SOUR\? reads back BUS, it was set to IMM",
    b"ROUT:SCAN (@102)": r"the scan list holds 102, it was set to 101 alone",
    b"FORM:READ:CHAN 0": r"FORM:READ:CHAN\? reads back 0, it was set to 1",
    b"FORM:READ:UNIT 1": r"FORM:READ:UNIT\? reads back 1, it was set to 0",
    b"FORM:READ:TIME 1": r"FORM:READ:TIME\? reads back 1, it was set to 0",
    b"FORM:READ:ALAR 1": r"FORM:READ:ALAR\? reads back 1, it was set to 0",
}


@pytest.mark.parametrize("then", ["daq.x", "daq.y"])
@pytest.mark.parametrize(("somebody", "text"), (OF_THE_CHANNEL | OF_THE_UNIT).items())
def test_what_somebody_changes_between_two_bursts_is_told_before_the_next(
    somebody: bytes, text: str, then: str
) -> None:
    rig = daq_rig()
    readout = rig.prepared()
    for _ in range(2):
        np.testing.assert_allclose(readout.read("daq.x", 2, rig.wait).samples, 1.0, atol=1e-4)
    rig.port.receive(somebody + b"\n", rig.clock.monotonic_s())
    taken = len(rig.bench.readings)
    with pytest.raises(RigError, match=text + "; no reading is taken; check that nobody else uses the unit"):
        readout.read(then, 2, rig.wait)
    assert len(rig.bench.readings) == taken
    assert not rig.port.errors
    np.testing.assert_allclose(readout.read("daq.x", 2, rig.wait).samples, 1.0, atol=1e-4)


@pytest.mark.parametrize(("somebody", "text"), OF_THE_CHANNEL.items())
def test_what_somebody_changes_during_a_burst_drops_it(somebody: bytes, text: str) -> None:
    rig = daq_rig()
    readout = rig.prepared()

    def wait(duration_s: float) -> None:
        rig.port.receive(somebody + b"\n", rig.clock.monotonic_s())
        rig.clock.sleep(duration_s)

    with pytest.raises(RigError, match=text + "; the burst is dropped; check that nobody else uses the unit"):
        readout.read("daq.x", 2, wait)


@pytest.mark.parametrize(
    ("somebody", "shown"),
    [(b'FUNC "RES",(@101)', 2500.0), (b"CALC:SCAL:GAIN 10,(@101);OFFS 1,(@101);STAT ON,(@101)", 11.0)],
)
def test_a_channel_of_another_function_or_with_scaling_shows_other_numbers(somebody: bytes, shown: float) -> None:
    # 972-CR CALC:SCAL:STAT: "Scaled Reading = (Gain x Measurement) + Offset".
    rig, number = _rig("34970A")
    _said(rig, b"CONF:VOLT:DC 10,(@%d)" % number)
    _said(rig, somebody)
    assert float(_said(rig, b"READ?")) == pytest.approx(shown, abs=1e-4)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("command", [b"CONF:VOLT:DC 10,(@%d)", b'FUNC "VOLT:AC",(@%d)', b"*RST"])
def test_scaling_ends_with_the_configuration_it_was_for(model: str, command: bytes) -> None:
    # 972-CR CALC:SCAL:STAT: "If you change the measurement configuration, scaling is turned off on that channel"; "The
    # CONFigure and MEASure? commands automatically disable scaling on the specified channels."; *RST; not SYST:PRES.
    rig, number = _rig(model)
    where = b"(@%d)" % number
    _said(rig, b"CALC:SCAL:STAT ON," + where)
    for harmless in (b"SYST:PRES", b"ROUT:SCAN " + where):
        _said(rig, harmless)
        assert _said(rig, b"CALC:SCAL:STAT? " + where) == b"1\n"
    _said(rig, command % number if b"%" in command else command)
    assert _said(rig, b"CALC:SCAL:STAT? " + where) == b"0\n"


def test_a_range_by_name_ends_autorange() -> None:
    # 980-CR VOLT:DC:RANG: "Selecting a discrete range will disable autoranging on the specified channels".
    rig, _ = _rig("34970A")
    _said(rig, b"CONF:VOLT:DC (@101)")
    assert _said(rig, b"VOLT:DC:RANG:AUTO? (@101)") == b"1\n"
    assert float(_said(rig, b"READ?;:VOLT:DC:RANG? (@101)").split(b";")[1]) == 1.0
    _said(rig, b"VOLT:DC:RANG 100,(@101)")
    assert _said(rig, b"VOLT:DC:RANG:AUTO? (@101);:VOLT:DC:RANG? (@101)") == b"0;+1.00000000E+02\n"


def test_the_short_is_read_on_each_range_of_the_channels() -> None:
    rig = daq_rig()
    channels = {"x": {"channel": 101, "range_v": 10.0}, "y": {"channel": 102, "range_v": 100.0}}
    readout = rig.prepared(channels=channels, checks={"short_channel": 110, "short_limit_v": 1.0, "samples": 2})
    ranges: list[bytes] = []

    def wait(duration_s: float) -> None:
        ranges.append(rig.unit.obey("VOLT:DC:RANG?", "(@110)", rig.clock.monotonic_s()) or b"")
        rig.clock.sleep(duration_s)

    readout.check_itself(wait)
    assert sorted({float(range_v) for range_v in ranges}) == [10.0, 100.0]


def test_a_reading_may_come_without_its_plus_sign() -> None:
    # 980-UG p. 123 prints `2.61950000E+01 C,…`; `R?` on UG-97 p. 236 has a sign on both: a parser must take both.
    assert scpi.parse_readings(b"2.61950000E+01,-1.00000000E+00") == (26.195, -1.0)
    assert scpi.parse_named_readings(b"2.61950000E+01,101") == ((26.195, 101),)
    with pytest.raises(DeviceNonsense):
        scpi.parse_readings(b"+2.61950000E+01,1.00000000E+00")  # one answer has one form: here a sign was lost


class PiecewiseLine:
    """A line whose answers come in pieces: so many characters, so many seconds each."""

    def __init__(self, characters: int, piece_s: float) -> None:
        self._characters, self._piece_s = characters, piece_s

    def on_write(self, data: bytes) -> tuple[faults.Part, ...]:
        return (faults.Part(data),)

    def on_read(self, data: bytes) -> tuple[faults.Part, ...]:
        pieces = [data[start : start + self._characters] for start in range(0, len(data), self._characters)]
        return tuple(faults.Part(piece, self._piece_s * number) for number, piece in enumerate(pieces, start=1))


def test_a_long_burst_comes_in_parts() -> None:
    # 3 300 × 20 = 66 000 characters (computed, docs/devices/scpi-daq.md): more than one answer may be.
    rig = daq_rig()
    line = StreamMessages(MemoryStream(rig.port, rig.clock, "memory", PiecewiseLine(4096, 0.001)))
    readout = ScpiDaqReadout("daq", daq_settings(nplc=0.02, autozero=False, relay_settle_s=0.0), line, rig.clock)
    readout.prepare()
    burst = readout.read("daq.x", 5000, rig.wait)
    np.testing.assert_allclose(burst.samples, 1.0 + 1e-6 * np.arange(1, 5001), rtol=1e-8)


def test_an_answer_has_the_time_that_its_length_needs() -> None:
    # 9 600 baud: a thousand readings with their channel are 20 s (computed).
    rig = daq_rig()
    line = StreamMessages(MemoryStream(rig.port, rig.clock, "memory", PiecewiseLine(96, 0.1)))
    readout = ScpiDaqReadout("daq", daq_settings(nplc=0.02, autozero=False), line, rig.clock)
    readout.prepare()
    assert readout.read("daq.x", 900, rig.wait).samples.size == 900


@pytest.mark.parametrize(
    ("model", "number"), [("34970A", 200), ("34970A", 141), ("34970A", 399), ("34980A", 1081), ("34980A", 8000)]
)
def test_a_channel_that_no_card_has_is_refused_with_the_file(model: str, number: int) -> None:
    with pytest.raises(ValidationError, match=f"no channel {number}"):
        daq_settings(model=model, channels={"x": {"channel": number, "range_v": 10.0}})


def test_a_channel_that_the_card_in_the_slot_lacks_is_told_by_identify() -> None:
    rig = daq_rig()
    readout = rig.readout(channels={"x": {"channel": 133, "range_v": 10.0}})
    with pytest.raises(RigError, match=r"34901A in slot 1 measures volts on channels 1 to 20, .* channel 133"):
        readout.prepare()


def test_a_channel_that_the_declared_card_lacks_is_refused_with_the_file_and_another_card_before_the_run() -> None:
    # 34970A user's guide: the 34902A has 16 channels, the 34901A 20 for volts.
    channels = {"x": {"channel": 117, "range_v": 10.0}}
    with pytest.raises(ValueError, match=r"channel 117: the 34902A in slot 1 \(cards\) .* \(allowed: 101 to 116\)"):
        daq_settings(channels=channels, cards={"1": "34902A"})
    assert daq_settings(channels=channels, cards={"1": "34901A"})
    rig = daq_rig()
    readout = rig.readout(cards={"1": "34902A"})
    with pytest.raises(RigError, match=r"slot 1 has a 34901A, the rig file says 34902A .*nothing was switched"):
        readout.prepare()
