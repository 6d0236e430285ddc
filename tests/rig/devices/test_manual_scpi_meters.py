"""What the manuals say of single meters, put to driver and twin: docs/devices/scpi-meters.md, by its pages."""

import numpy as np
import pytest
from meter_rig import MODELS, meter_rig, meter_settings, on_a_bus
from pydantic import ValidationError

from rig.devices.scpi_meter import PRESETS, ScpiMeter
from rig.errors import DeviceNonsense, DeviceRefused, DeviceSilent, RequestRefused, RigError, WaitEnded
from rig.link import faults
from rig.link.messages import StreamMessages
from rig.wire import scpi

IMPEDANCE = {"34401A": b"INP:IMP:AUTO", "34461A": b"VOLT:DC:IMP:AUTO"}
KEITHLEYS = ("keithley-2000", "keithley-2002")


@pytest.mark.parametrize("model", IMPEDANCE)
@pytest.mark.parametrize("command", [b"CONF:VOLT:DC 10", b"*RST"])
def test_preset_and_configure_start_the_function_anew_at_ten_megohm(model: str, command: bytes) -> None:
    # 401-UG p. 118: "Preset and configure the multimeter for dc voltage measurements with the specified range and
    # resolution." 1412 p. 100: "*RST Conditions: INP:IMP:AUTO OFF". For CONF of the 34401A remembered.
    rig = meter_rig(model)
    rig.said(IMPEDANCE[model] + b" ON;:VOLT:DC:NPLC 1")
    assert rig.said(IMPEDANCE[model] + b"?") == b"1\n"
    rig.said(command)
    assert rig.said(IMPEDANCE[model] + b"?;:VOLT:DC:NPLC?") == b"0;+1.00000000E+01\n"


@pytest.mark.parametrize("model", IMPEDANCE)
def test_the_driver_measures_with_a_high_impedance_all_the_same(model: str) -> None:
    # A meter at 10 megohm on a source of 2.5 kilohm reads 249.9 ppm low: impedance is sent behind CONF and asked for
    # again before a burst.
    rig = meter_rig(model)
    meter = rig.prepared()
    assert rig.unit.is_high_impedance
    meter.read("dmm.x", 2, rig.wait, nplc=10.0)
    assert rig.unit.is_high_impedance
    rig.said(IMPEDANCE[model] + b" OFF")
    with pytest.raises(DeviceRefused, match=r"IMP:AUTO\? reads back 0, it was set to 1; no reading is taken"):
        meter.read("dmm.x", 2, rig.wait, nplc=10.0)
    assert np.isfinite(meter.read("dmm.x", 2, rig.wait).samples).all()  # and is set up again for the next


@pytest.mark.parametrize("model", KEITHLEYS)
def test_a_keithley_has_no_command_for_its_impedance(model: str) -> None:
    # "no command; always > 10 GOhm": one that is sent gives error -113.
    rig = meter_rig(model)
    rig.said(b"INP:IMP:AUTO ON")
    assert rig.said(b"SYST:ERR?") == b'-113,"Undefined header"\n'
    with pytest.raises(ValidationError, match="no command for its input impedance"):
        meter_settings(model, high_impedance=False)
    rig.prepared()


@pytest.mark.parametrize("model", KEITHLEYS)
def test_a_keithley_wakes_measuring_and_refuses_read_until_it_is_told_to_stop(model: str) -> None:
    # Power-on: continuous initiation ON in the factory set-up; then READ? and INIT are refused with -213.
    rig = meter_rig(model)
    assert rig.said(b"READ?") == b""
    assert rig.said(b"SYST:ERR?") == b'-213,"Init ignored"\n'
    assert rig.prepared().read("dmm.x", 1, rig.wait).samples.size == 1


def test_a_reading_with_its_unit_is_refused_as_a_number() -> None:
    # K2000 p. 5-28: with UNIT the reading is written +1.23456789E+00VDC, the unit without a space.
    rig = meter_rig("keithley-2000")
    meter = rig.prepared()
    rig.unit.elements = "READ,UNIT"
    with pytest.raises(RigError, match="FORM:ELEM"):
        meter.read("dmm.x", 1, rig.wait)
    rig.said(b"INIT:CONT OFF;:FORM:ELEM READ,UNIT")
    assert rig.said(b"READ?") == b"+1.00000000E+00VDC\n"
    with pytest.raises(DeviceNonsense):
        scpi.parse_readings(b"+1.00000000E+00VDC")


def test_decibels_are_never_taken_for_volts() -> None:
    rig = meter_rig("keithley-2000")
    meter = rig.prepared()
    rig.unit.unit = "DB"
    with pytest.raises(DeviceRefused, match=r"UNIT:VOLT:DC\? says DB, need V"):
        meter.read("dmm.x", 1, rig.wait)


@pytest.mark.parametrize(
    ("model", "reply"),
    [
        ("34401A", b"+9.90000000E+37\n"),  # 401-UG p. 61
        ("34461A", b"+9.90000000E+37\n"),
        ("keithley-2000", b"+9.9E37\n"),  # K2000 p. 5-28: "An overflow reading reads as +9.9e37 with no units."
        ("keithley-2002", b"+9.9E37\n"),  # K2002 p. 3-81: "An overflow reading reads as +9.9E37."
    ],
)
def test_the_overload_mark_is_no_reading(model: str, reply: bytes) -> None:
    rig = meter_rig(model)
    meter = rig.prepared()
    rig.level_v[0] = 500.0
    assert rig.said(b"READ?") == reply
    burst = meter.read("dmm.x", 3, rig.wait)
    assert np.isnan(burst.samples).all()
    assert burst.overload.all()
    rig.level_v[0] = -500.0
    assert meter.read("dmm.x", 1, rig.wait).overload.all()


@pytest.mark.parametrize("line", [b"+9.9E37", b"+9.9e37", b"-9.9E+37", b"+9.90000000E+37"])
def test_every_way_to_write_the_overload_mark_is_known(line: bytes) -> None:
    assert abs(scpi.parse_readings(line)[0]) > scpi.LARGEST_READING


def test_replies_are_those_of_the_manuals() -> None:
    # 401-UG p. 159: SD.DDDDDDDDESDD; TV p. 221: +1.04530000E+01,+1.04570000E+01; 401-UG p. 58: FRON or REAR.
    hp = meter_rig("34401A")
    hp.level_v[0] = 10.453
    assert hp.said(b"CONF:VOLT:DC 100;:READ?") == b"+1.04530000E+01\n"
    assert hp.said(b"SAMP:COUN 2;:READ?") == b"+1.04530000E+01,+1.04530000E+01\n"
    assert hp.said(b"ROUT:TERM?") == b"FRON\n"
    assert hp.said(b"SYST:ERR?") == b'+0,"No error"\n'
    keithley = meter_rig("keithley-2000")
    assert keithley.said(b"*IDN?") == b"KEITHLEY INSTRUMENTS INC.,MODEL 2000,1234567,A08 /A02\n"
    assert keithley.said(b"SYST:ERR?") == b'0,"No error"\n'


def test_an_error_is_read_by_its_number_however_its_text_is_printed() -> None:
    # K2000 p. 5-63 prints "0, No error" and "350, Queue Overflow"; 8846: +0,"No error".
    assert scpi.parse_error(b"0, No error") == (0, "No error")
    assert scpi.parse_error(b"350, Queue Overflow") == (350, "Queue Overflow")
    assert scpi.parse_error(b'+0,"No error"') == (0, "No error")
    for line in (b"0", b"0,", b"1,2", b'0,"No error', b"+1.0E+00,+1.0E+00"):
        with pytest.raises(DeviceNonsense):
            scpi.parse_error(line)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("carried", ["line", "bus"])
def test_a_burst_reads_what_is_there_and_lasts_as_long_as_it_says(model: str, carried: str) -> None:
    rig = meter_rig(model)
    rig.level_v[0] = -2.5
    meter = rig.meter(terminals="front") if carried == "line" else on_a_bus(rig)
    meter.prepare()
    began_s = rig.clock.monotonic_s()
    burst = meter.read("dmm.x", 4, rig.wait, nplc=10.0)
    np.testing.assert_array_equal(burst.samples, -2.5)
    assert 3.0 * burst.interval_s <= rig.clock.monotonic_s() - began_s <= 8.0 * burst.interval_s
    assert burst.interval_s == pytest.approx(0.41, abs=0.01)  # 10 PLC at 50 Hz, autozero: 0.4 s


def test_long_integration_outlives_the_adapter_s_own_time_out() -> None:
    # 100 PLC with autozero takes 4 s; a Prologix gives up reading after 3 s: READ? is sent, waited for, then read.
    rig = meter_rig("34401A")
    meter = on_a_bus(rig, nplc=100.0)
    meter.prepare()
    assert meter.read("dmm.x", 2, rig.wait).samples.size == 2


def test_a_stop_ends_a_reading_and_the_next_burst_is_whole() -> None:
    rig = meter_rig("34401A")
    meter = rig.prepared(nplc=100.0)

    def stopped(_duration_s: float) -> None:
        raise WaitEnded("stop")

    with pytest.raises(WaitEnded):
        meter.read("dmm.x", 2, stopped)
    rig.level_v[0] = 3.0
    np.testing.assert_array_equal(meter.read("dmm.x", 2, rig.wait).samples, 3.0)


@pytest.mark.parametrize(("fault", "error"), [(faults.drop, DeviceSilent), (faults.truncate(9), DeviceSilent),
                                              (faults.replace(b"+1.0453\n"), DeviceNonsense)])  # fmt: skip
def test_a_reading_that_was_lost_or_cut_drops_the_burst(fault: faults.Fault, error: type[RigError]) -> None:
    rig = meter_rig("34401A")
    meter = rig.prepared()
    rig.faults.reads = {
        rig.faults.taken + 9: fault
    }  # eight settings are asked for again, then comes the second reading
    with pytest.raises(error, match="READ"):
        meter.read("dmm.x", 3, rig.wait)
    rig.level_v[0] = 2.0
    np.testing.assert_array_equal(meter.read("dmm.x", 2, rig.wait).samples, 2.0)


def test_what_somebody_else_sets_meanwhile_costs_one_burst_and_no_more() -> None:
    several = meter_rig("34401A")
    meter = several.prepared()
    several.said(b"SAMP:COUN 2")
    with pytest.raises(DeviceNonsense, match="one READ"):
        meter.read("dmm.x", 1, several.wait)
    assert meter.read("dmm.x", 1, several.wait).samples.size == 1
    running = meter_rig("keithley-2000")
    meter = running.prepared()
    running.said(b"INIT:CONT ON")
    with pytest.raises(DeviceSilent):
        meter.read("dmm.x", 1, running.wait)
    assert meter.read("dmm.x", 1, running.wait).samples.size == 1


def test_inputs_at_the_other_side_and_another_model_are_refused() -> None:
    rig = meter_rig("34401A")
    rig.unit.is_front = False
    assert "rear inputs" in rig.meter().identify()
    with pytest.raises(DeviceRefused, match=r"the rear inputs are selected, need those at the front"):
        rig.meter(terminals="front").identify()
    # TV p. 156: SYST:IDEN gives an identity that is not the model.
    other = meter_rig("34461A")
    other.model = "34401A"
    with pytest.raises(DeviceNonsense, match=r"\*IDN\? says model '34461A', need 34401A"):
        other.prepared()


@pytest.mark.parametrize("declared", ["rear", None])
@pytest.mark.parametrize("model", MODELS)
def test_inputs_that_are_changed_at_the_panel_are_not_measured(model: str, declared: str | None) -> None:
    # 8846 p. 61: the question returns the state of the switch, which a hand turns at any time.
    rig = meter_rig(model)
    rig.unit.is_front = False
    meter = rig.meter(terminals=declared)
    meter.prepare()
    assert meter.read("dmm.x", 1, rig.wait).samples.size == 1
    rig.unit.is_front = True

    def measured(_duration_s: float) -> None:
        raise AssertionError("a reading was taken at the front")

    sentence = "the front inputs are selected, need those at the rear"
    with pytest.raises(DeviceRefused, match=f"{sentence} .*terminals.*no reading is taken"):
        meter.read("dmm.x", 1, measured)
    with pytest.raises(DeviceRefused, match=f"{sentence} .*terminals"):
        meter.prepare()  # as a retry does: what was selected first holds
    rig.unit.is_front = False

    def turned(duration_s: float) -> None:
        rig.wait(duration_s)
        rig.unit.is_front = True

    with pytest.raises(DeviceRefused, match=f"{sentence} .*terminals.*the burst is dropped"):
        meter.read("dmm.x", 2, turned)
    rig.unit.is_front = False
    assert meter.read("dmm.x", 1, rig.wait).samples.size == 1


def test_a_meter_behind_its_local_key_is_taken_back_with_the_next_set_up() -> None:
    # 34401A on RS-232: SYST:REM before other commands, else error 550 (remembered: docs/devices/scpi-meters.md).
    rig = meter_rig("34401A")
    line = StreamMessages(rig.stream)
    meter = ScpiMeter("dmm", meter_settings("34401A"), line, rig.clock, needs_remote=True)
    rig.unit.is_local = True
    meter.prepare()
    assert meter.read("dmm.x", 1, rig.wait).samples == pytest.approx(1.0)
    rig.unit.is_local = True
    with pytest.raises(DeviceSilent):
        meter.read("dmm.x", 1, rig.wait)
    assert meter.read("dmm.x", 1, rig.wait).samples == pytest.approx(1.0)


def test_only_what_a_model_offers_is_accepted() -> None:
    assert PRESETS["34401A"].nplc == (0.02, 0.2, 1.0, 10.0, 100.0)  # 401-UG p. 58
    for changes, found in (
        ({"nplc": 2.0}, "allowed: 0.02, 0.2, 1, 10, 100"),
        ({"channels": {"x": {"range_v": 20.0}}}, "no range of 20 V"),
        ({"channels": {"x": {"range_v": 10.0}, "y": {"range_v": 10.0}}}, "at most 1 item"),
    ):
        with pytest.raises(ValidationError, match=found):
            meter_settings("34401A", **changes)
    rig = meter_rig("34401A")
    with pytest.raises(RequestRefused, match="power-line cycles"):
        rig.prepared().read("dmm.x", 1, rig.wait, nplc=3.0)


def test_ten_megohm_is_in_the_budget_where_it_loads() -> None:
    assert meter_settings("34401A").input_ohm("x") is None
    assert meter_settings("34401A", high_impedance=False).input_ohm("x") == 10.0e6
    assert meter_settings("34401A", channels={"x": {"range_v": 100.0}}).input_ohm("x") == 10.0e6
    assert meter_settings("keithley-2002", channels={"x": {"range_v": 200.0}}).input_ohm("x") == 10.0e6


@pytest.mark.parametrize("model", MODELS)
def test_a_press_of_null_or_rel_at_the_panel_is_no_plain_reading(model: str) -> None:
    # K2000 p. 5-43: "When Reference is enabled (see :REFerence:STATe), the result will be the algebraic difference
    # between the input signal and the reference value". NULL of a Truevolt and CALC:STAT of a 34401A the same.
    rig = meter_rig(model)
    meter = rig.prepared()
    (before_v,) = meter.read("dmm.x", 1, rig.wait).samples
    rig.unit.null_v = 0.25
    with pytest.raises(DeviceRefused, match=r"STAT\? says 1, need 0: a reading is no plain number of volts"):
        meter.read("dmm.x", 1, rig.wait)
    rig.unit.null_v = None
    assert meter.read("dmm.x", 1, rig.wait).samples == pytest.approx([before_v], abs=1e-3)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize(
    ("pressed", "said"),
    [(b'FUNC "RES"', r"FUNC\? says RES, need VOLT(:DC)?"), (b"VOLT:DC:RANG:AUTO ON", r"RANG:AUTO\? says 1, need 0")],
)
def test_another_function_at_the_panel_is_never_read_as_volts(model: str, pressed: bytes, said: str) -> None:
    # K2000 manual, ":RANGe commands": one command for each function; that of volts answers while ohms are measured.
    rig = meter_rig(model)
    meter = rig.prepared()
    meter.read("dmm.x", 1, rig.wait)
    rig.said(pressed)
    with pytest.raises(DeviceRefused, match=said + ": a reading is no plain number of volts; no reading is taken"):
        meter.read("dmm.x", 1, rig.wait)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize(
    ("key", "state", "said"),
    [
        ("FUNC", "RES", r"FUNC\? says RES, need .*: a reading is no plain number of volts; the burst"),
        ("VOLT:DC:RANG:AUTO", "ON", r"RANG:AUTO\? says 1, need 0: a reading is no plain number of volts; the burst"),
        ("VOLT:DC:RANG", "1000", r"RANG\? reads back 1000, it was set to [12]0; the burst"),
        ("VOLT:DC:NPLC", "0.02", r"NPLC\? reads back 0.02, it was set to .*; the burst"),
    ],
)
def test_what_changes_within_a_burst_drops_it(model: str, key: str, state: str, said: str) -> None:
    rig = meter_rig(model)
    meter = rig.prepared()

    def press(seconds: float) -> None:
        rig.wait(seconds)
        rig.unit.obey(key, state, 0.0)

    with pytest.raises(DeviceRefused, match=said):
        meter.read("dmm.x", 1, press)


@pytest.mark.parametrize("model", KEITHLEYS)
def test_a_reference_is_subtracted_and_a_reset_ends_it(model: str) -> None:
    rig = meter_rig(model)
    rig.said(b"VOLT:DC:REF:STAT ON")
    assert rig.said(b"VOLT:REF:STAT?;:CALC:STAT?") == b"1;0\n"
    rig.said(b"*RST")
    assert rig.said(b"VOLT:DC:REF:STAT?") == b"0\n"
