"""Laws of the data-acquisition driver: told, read back, named, and no error left behind."""

import numpy as np
import pytest
from daq_rig import DaqRig, daq_rig, daq_settings
from pydantic import ValidationError

from rig.devices.scpi_daq import ScpiDaqReadout
from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, LinkLost, RequestRefused, RigError, WaitEnded
from rig.link import faults
from rig.link.faults import FaultScript
from rig.link.memory import MemoryStream
from rig.link.messages import GpibMessages, StreamMessages
from rig.link.prologix import PrologixBus
from rig.twins.prologix import PrologixTwin


def test_a_burst_is_one_channel_in_the_order_taken() -> None:
    rig = daq_rig()
    burst = rig.prepared().read("daq.y", 5, rig.wait)
    assert burst.channel == "daq.y"
    np.testing.assert_allclose(burst.samples, -2.0 + 1e-6 * np.arange(1, 6), rtol=1e-8)
    assert not burst.overload.any()
    assert [channel for channel, _ in rig.bench.readings] == ["daq.y"] * 5


def test_a_burst_takes_its_time() -> None:
    rig = daq_rig()
    readout = rig.prepared()
    before_s = rig.clock.monotonic_s()
    readout.read("daq.x", 20, rig.wait, nplc=10.0)
    assert rig.clock.monotonic_s() - before_s == pytest.approx(20 * readout.reading_s(10.0), rel=0.05)
    gaps_s = np.diff([now_s for _, now_s in rig.bench.readings])
    assert gaps_s == pytest.approx(2 * 10 / 50 + 0.02 + 0.003)  # autozero, relay, overhead of the twin


def test_each_channel_may_have_its_own_integration() -> None:
    rig = daq_rig()
    slow = {"x": {"channel": 101, "range_v": 10.0, "nplc": 20.0}, "y": {"channel": 102, "range_v": 1.0}}
    readout = rig.prepared(channels=slow)
    assert readout.read("daq.x", 1, rig.wait).interval_s > 0.8
    assert readout.read("daq.y", 1, rig.wait).interval_s < 0.1
    assert rig.unit.obey("VOLT:DC:NPLC?", "(@101)", 0.0) == b"+2.00000000E+01"
    assert rig.unit.obey("VOLT:DC:RANG?", "(@102)", 0.0) == b"+1.00000000E+00"


@pytest.mark.parametrize("level_v", [12.1, -12.1])
def test_an_overload_is_flagged_and_no_number(level_v: float) -> None:
    rig = daq_rig()
    rig.bench.level_v["daq.x"] = level_v
    burst = rig.prepared().read("daq.x", 3, rig.wait)
    assert np.isnan(burst.samples).all()
    assert burst.overload.all()


def test_who_it_is() -> None:
    assert daq_rig().prepared().identify() == "HEWLETT-PACKARD 34970A 0 13-2-2, 34901A in slot 1, 34901A in slot 2"
    rig = daq_rig("34980A", {1001: "daq.x"})
    readout = rig.readout(model="34980A", channels={"x": {"channel": 1001, "range_v": 10.0}})
    readout.prepare()
    assert "34980A" in readout.identify()
    assert "34921A in slot 1" in readout.identify()
    assert readout.read("daq.x", 2, rig.wait).samples == pytest.approx(1.0, abs=1e-5)


def test_another_model_is_refused_before_anything_is_set() -> None:
    with pytest.raises(DeviceNonsense, match=r"says model '34980A', need 34970A or 34972A"):
        daq_rig("34980A", {1001: "daq.x"}).prepared()


def test_an_empty_slot_is_told() -> None:
    rig = daq_rig()
    del rig.unit.cards[2]
    with pytest.raises(DeviceRefused, match=r"slot 2 is empty.*readouts\.daq: channels"):
        rig.prepared()


def test_errors_of_earlier_use_are_cleared() -> None:
    rig = daq_rig()
    rig.port.receive(b"NONSENSE 1\n", 0.0)
    rig.prepared()
    assert not rig.port.errors


def test_a_unit_that_speaks_of_itself_is_not_measured_with() -> None:
    rig = daq_rig()
    rig.port.errors.append((740, "Cal checksum failed, secure state"))
    with pytest.raises(DeviceFault, match=r"before anything was set: \+740 Cal checksum failed"):
        rig.prepared()


def test_an_error_behind_a_scan_drops_the_burst() -> None:
    rig = daq_rig()
    readout = rig.prepared()

    def wait(duration_s: float) -> None:
        rig.clock.sleep(duration_s)
        rig.port.errors.append((-310, "System error"))

    with pytest.raises(DeviceRefused, match=r"-310 System error; the burst is dropped"):
        readout.read("daq.x", 2, wait)


def test_a_unit_that_forgot_everything_is_not_read_as_if_it_had_not() -> None:
    rig = daq_rig()
    readout = rig.prepared()
    readout.read("daq.x", 2, rig.wait)
    rig.unit.obey("*RST", "", rig.clock.monotonic_s())  # its power failed between two dwells
    with pytest.raises(RigError):
        readout.read("daq.x", 2, rig.wait)
    assert readout.read("daq.x", 2, rig.wait).samples == pytest.approx(1.0, abs=1e-4)


def test_a_reading_of_another_channel_is_a_fault() -> None:
    rig = daq_rig()
    readout = rig.prepared()

    def wait(duration_s: float) -> None:
        rig.unit.obey("ROUT:SCAN", "(@102)", rig.clock.monotonic_s())  # somebody else
        rig.unit.obey("INIT", "", rig.clock.monotonic_s())
        rig.clock.sleep(duration_s)

    with pytest.raises(DeviceFault, match=r"channel 101 was scanned, but readings name 102"):
        readout.read("daq.x", 2, wait)


def test_a_stop_leaves_the_unit_at_rest() -> None:
    rig = daq_rig()
    readout = rig.prepared()

    def stopped(duration_s: float) -> None:
        raise WaitEnded("stop")

    with pytest.raises(WaitEnded):
        readout.read("daq.x", 50, stopped)
    taken = len(rig.bench.readings)
    assert taken < 10  # a line of its own must be quiet before ABOR goes out
    rig.clock.sleep(1000.0)
    rig.unit.advance(rig.clock.monotonic_s())
    assert len(rig.bench.readings) == taken
    assert readout.read("daq.x", 2, rig.wait).samples == pytest.approx(1.0, abs=1e-4)


def test_what_the_unit_does_not_offer_is_refused_before_it_is_told() -> None:
    rig = daq_rig()
    readout = rig.prepared()
    for channel, samples, nplc, text in (
        ("daq.w", 1, None, r"no channel 'daq\.w'"),
        ("daq.x", 0, None, "got 0 readings"),
        ("daq.x", 1, 3.0, "got 3 power-line cycles"),
    ):
        with pytest.raises(RequestRefused, match=text):
            readout.read(channel, samples, rig.wait, nplc)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"nplc": 5.0}, "no such integration time"),
        ({"channels": {"x": {"channel": 101, "range_v": 5.0}}}, "no such range"),
        ({"channels": {"x": {"channel": 1001, "range_v": 10.0}}}, "a 34970A has no channel 1001"),
        ({"model": "34980A"}, "a 34980A has no channel 101"),
        ({"channels": {name: {"channel": 101, "range_v": 1.0} for name in "xy"}}, "more than one name"),
    ],
)
def test_settings_that_no_unit_can_follow(changes: dict[str, object], text: str) -> None:
    with pytest.raises(ValidationError, match=text):
        daq_settings(**changes)


FAULTS = {
    "late": faults.delay(4.0),
    "lost": faults.drop,
    "doubled": faults.duplicate(),
    "doubled later": faults.duplicate(0.3),
    "cut": faults.truncate(3),
    "stale before": faults.prepend(b"+1.00000000E+00\n"),
    "split": faults.split(2, 0.05),
    "a flipped digit": lambda data: faults.flip_bit(-min(3, len(data)), 0)(data),
}


@pytest.mark.parametrize("fault", FAULTS.values(), ids=list(FAULTS))
@pytest.mark.parametrize("index", range(48))
def test_a_line_that_fails_never_makes_a_wrong_reading(fault: faults.Fault, index: int) -> None:
    rig = daq_rig()
    readout = rig.prepared()
    script = FaultScript(reads={index: fault})
    rig.faults.reads, rig.faults.taken = script.reads, 0
    for channel, level_v in (("daq.x", 1.0), ("daq.y", -2.0)):
        try:
            burst = readout.read(channel, 2, rig.wait)
        except RigError:
            continue
        # A flipped digit of a reading has no checksum on this line: at most one reading is off, never the channel.
        off = np.abs(burst.samples - level_v) > 1e-4
        assert off.sum() <= (fault is FAULTS["a flipped digit"])


def test_a_lost_line_is_told_as_such() -> None:
    rig = daq_rig()
    readout = rig.prepared()
    rig.faults.reads, rig.faults.taken = {3: faults.hang_up}, 0
    with pytest.raises(LinkLost):
        readout.read("daq.x", 2, rig.wait)


def _on_a_bus(rig: DaqRig) -> ScpiDaqReadout:
    adapter = PrologixTwin({9: rig.port})
    bus = PrologixBus(MemoryStream(adapter, rig.clock, "adapter"))
    return ScpiDaqReadout("daq", daq_settings(), GpibMessages(bus, 9), rig.clock)


def test_the_same_unit_on_a_gpib_bus() -> None:
    rig = daq_rig()
    readout = _on_a_bus(rig)
    readout.prepare()
    burst = readout.read("daq.z", 30, rig.wait, nplc=10.0)
    np.testing.assert_allclose(burst.samples, 3.0 + 1e-6 * np.arange(1, 31), rtol=1e-8)


class Misheard:
    """A line on which one message arrives as another."""

    def __init__(self, message: bytes, instead: bytes) -> None:
        self._message, self._instead = message + b"\n", instead + b"\n"

    def on_write(self, data: bytes) -> tuple[faults.Part, ...]:
        return (faults.Part(self._instead if data == self._message else data),)

    def on_read(self, data: bytes) -> tuple[faults.Part, ...]:
        return (faults.Part(data),)


@pytest.mark.parametrize(
    ("message", "instead", "text"),
    [
        (b"CONF:VOLT:DC 10,(@101)", b"CONF:VOLT:DC 100,(@101)", r"RANG\? \(@101\) reads back 100, it was set to 10"),
        (b"SENS:VOLT:DC:NPLC 20,(@101)", b"SENS:VOLT:DC:NPLC 2,(@101)", "reads back 2, it was set to 20"),
        (b"TRIG:COUN 2", b"TRIG:COUN 1", "reads back 1, it was set to 2"),
        (b"ROUT:SCAN (@101)", b"ROUT:SCAN (@102)", r"the scan list holds 102, it was set to 101 alone"),
        (b"FORM:READ:CHAN 1", b"FORM:READ:CHAN 0", "reads back 0, it was set to 1"),
    ],
)
def test_what_the_unit_took_otherwise_is_found_before_a_reading(message: bytes, instead: bytes, text: str) -> None:
    rig = daq_rig()
    line = StreamMessages(MemoryStream(rig.port, rig.clock, "memory", Misheard(message, instead)))
    readout = ScpiDaqReadout("daq", daq_settings(), line, rig.clock)
    with pytest.raises(RigError, match=text):
        readout.read("daq.x", 2, rig.wait, nplc=20.0)
    assert not rig.bench.readings


@pytest.mark.parametrize("kept", [b"CALC:SCAL:GAIN 10,(@101);STAT ON,(@101)", b"VOLT:DC:RANG:AUTO ON,(@101)"])
def test_what_configure_leaves_on_is_switched_off(kept: bytes) -> None:
    rig, configure = daq_rig(), b"CONF:VOLT:DC 10,(@101)"
    line = StreamMessages(MemoryStream(rig.port, rig.clock, "memory", Misheard(configure, configure + b";:" + kept)))
    readout = ScpiDaqReadout("daq", daq_settings(), line, rig.clock)
    assert readout.read("daq.x", 2, rig.wait).samples == pytest.approx(1.0, abs=1e-4)


def test_more_readings_than_asked_for_drop_the_burst() -> None:
    rig = daq_rig()
    readout = rig.prepared()

    def wait(duration_s: float) -> None:
        now_s = rig.clock.monotonic_s()
        for header, parameters in (("ABOR", ""), ("TRIG:COUN", "3"), ("INIT", "")):
            rig.unit.obey(header, parameters, now_s)
        rig.clock.sleep(2.0 * duration_s)

    with pytest.raises(DeviceFault, match="got 3 readings, asked for 2; the burst is dropped"):
        readout.read("daq.x", 2, wait)


def test_readings_without_their_channel_are_a_setting() -> None:
    rig = daq_rig()
    assert rig.prepared(channel_echo=False).read("daq.y", 3, rig.wait).samples == pytest.approx(-2.0, abs=1e-4)
