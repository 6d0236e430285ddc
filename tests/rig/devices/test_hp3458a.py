import math
import re

import numpy as np
import pytest
from gpib_rig import LEVEL_V, GpibRig, gpib_rig, meter_settings
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from rig.clock import ScaledClock, SystemClock, VirtualClock
from rig.devices.hp3458a import Hp3458aReadout, scanner_resource
from rig.errors import (
    DeviceFault,
    DeviceNonsense,
    DeviceRefused,
    DeviceSilent,
    LinkLost,
    RequestRefused,
    RigError,
    WaitEnded,
)
from rig.link import faults
from rig.link.faults import Fault
from rig.link.memory import MemoryStream
from rig.link.ports import open_stream
from rig.link.prologix import PrologixBus
from rig.twins import hp3458a as meter_twin
from rig.twins.prologix import PrologixTwin
from rig.twins.serving.servers import serve_pty, serve_tcp


class Stop:
    """A wait that lets ``slices`` waits pass and then ends."""

    def __init__(self, rig: GpibRig, slices: int) -> None:
        self.rig = rig
        self.slices = slices

    def __call__(self, duration_s: float) -> None:
        if self.slices == 0:
            raise WaitEnded("stop")
        self.slices -= 1
        self.rig.clock.sleep(duration_s)


def test_a_burst_is_what_the_channel_measured() -> None:
    rig = gpib_rig()
    burst = rig.prepared().read("dmm.y", 4, rig.wait)
    assert list(burst.samples) == pytest.approx([-2.0 + 1e-6 * k for k in (1, 2, 3, 4)], rel=1e-9)
    assert [channel for channel, _ in rig.bench.readings] == ["dmm.y"] * 4
    assert not burst.overload.any()
    assert burst.channel == "dmm.y"


def test_channels_are_named_in_full() -> None:
    assert gpib_rig().readout().channels == ("dmm.x", "dmm.y", "dmm.z")


def test_each_channel_is_measured_behind_its_own_relay() -> None:
    rig = gpib_rig()
    readout = rig.prepared()
    for channel in ("dmm.z", "dmm.x", "dmm.y", "dmm.x"):
        assert readout.read(channel, 2, rig.wait).samples == pytest.approx(LEVEL_V[channel], abs=1e-4)


def test_readings_are_paced_by_the_meter() -> None:
    rig = gpib_rig()
    readout = rig.prepared(nplc=10)
    burst = readout.read("dmm.x", 5, rig.wait)
    times_s = [now_s for _, now_s in rig.bench.readings]
    assert np.diff(times_s) == pytest.approx(0.4, abs=0.002)  # autozero doubles ten cycles of 20 ms
    assert burst.interval_s == pytest.approx(0.4, abs=0.002)
    assert readout.reading_s(nplc=1.0) == pytest.approx(0.04, abs=0.002)
    assert times_s[0] - burst.started_s == pytest.approx(burst.interval_s, abs=0.002)


def test_power_line_cycles_are_set_for_the_burst() -> None:
    rig = gpib_rig()
    readout = rig.prepared(nplc=10)
    readout.read("dmm.x", 2, rig.wait, nplc=1.0)
    readout.read("dmm.x", 2, rig.wait)
    first_s, second_s, third_s, fourth_s = (now_s for _, now_s in rig.bench.readings)
    assert second_s - first_s == pytest.approx(0.04, abs=0.002)
    assert fourth_s - third_s == pytest.approx(0.4, abs=0.002)


def test_a_slow_reading_is_polled_and_never_lost_to_the_adapter_s_time_out() -> None:
    # NPLC 100 with autozero at 50 Hz takes 4 s, the adapter gives up after 3 s without a character.
    rig = gpib_rig()
    burst = rig.prepared(nplc=100).read("dmm.x", 3, rig.wait)
    assert list(burst.samples) == pytest.approx([1.0 + 1e-6 * k for k in (1, 2, 3)], rel=1e-9)
    assert rig.clock.monotonic_s() > 12.0


def test_a_reading_far_later_than_expected_is_waited_for_outside_the_adapter(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = gpib_rig()
    readout = rig.prepared(nplc=100)
    readout.read("dmm.x", 1, rig.wait)
    monkeypatch.setattr(meter_twin, "OVERHEAD_S", 6.0)  # 10 s a reading instead of 4: more than the adapter's 3 s late
    assert readout.read("dmm.x", 1, rig.wait).samples[0] == pytest.approx(1.000002, rel=1e-9)


def test_overload_is_not_a_number_and_flagged() -> None:
    rig = gpib_rig()
    rig.bench.level_v["dmm.x"] = 12.5
    burst = rig.prepared().read("dmm.x", 2, rig.wait)
    assert np.isnan(burst.samples).all()
    assert burst.overload.all()


def test_relays_break_before_they_make() -> None:
    rig = gpib_rig()
    readout = rig.prepared()
    worst = 0
    listen = rig.scanner.listen

    def watched(message: bytes, now_s: float) -> float:
        nonlocal worst
        until_s = listen(message, now_s)
        worst = max(worst, len(rig.scanner.closed_channels()))
        return until_s

    rig.scanner.listen = watched  # type: ignore[method-assign]
    for channel in ("dmm.x", "dmm.y", "dmm.z", "dmm.x"):
        readout.read(channel, 1, rig.wait)
    assert worst == 1


def test_an_open_relay_behind_our_back_voids_the_burst() -> None:
    rig = gpib_rig()
    readout = rig.prepared()
    readout.read("dmm.x", 1, rig.wait)

    def wait(duration_s: float) -> None:
        rig.scanner.listen(b"OPEN 101", rig.clock.monotonic_s())
        rig.clock.sleep(duration_s)

    with pytest.raises(DeviceFault, match="scanner channel 101: got open, need closed"):
        readout.read("dmm.x", 3, wait)
    assert readout.read("dmm.x", 1, rig.wait).samples[0] == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("command", [b"CLOSE 102", b"CLOSE 107"])
@pytest.mark.parametrize("when", ["before", "within"])
def test_two_closed_relays_are_no_reading(command: bytes, when: str) -> None:
    rig = gpib_rig()
    readout = rig.prepared()
    readout.read("dmm.x", 1, rig.wait)
    taken = len(rig.bench.readings)

    def wait(duration_s: float) -> None:
        rig.wait(duration_s)
        if rig.bench.readings[taken:]:  # once the first reading is there
            rig.scanner.listen(command, rig.clock.monotonic_s())

    if when == "before":
        rig.scanner.listen(command, rig.clock.monotonic_s())
    with pytest.raises(DeviceFault, match="need open beside 101: the meter is on both and reads a mixture"):
        readout.read("dmm.x", 3, rig.wait if when == "before" else wait)
    assert readout.read("dmm.x", 1, rig.wait).samples[0] == pytest.approx(1.0, abs=1e-4)


def test_a_relay_that_sticks_is_seen_before_the_next_is_closed() -> None:
    rig = gpib_rig()
    readout = rig.prepared()
    readout.read("dmm.x", 1, rig.wait)
    rig.scanner._closed = _Sticky(rig.scanner._closed)
    with pytest.raises(DeviceFault, match="scanner channel 101: got closed, need open"):
        readout.read("dmm.y", 1, rig.wait)
    assert rig.scanner.closed_channels() == {101}


class _Sticky(set[int]):
    def discard(self, element: int) -> None:
        return None


@pytest.mark.parametrize("slices", range(4))
def test_a_stop_leaves_the_meter_cleared_and_the_next_burst_whole(slices: int) -> None:
    rig = gpib_rig()
    readout = rig.prepared(nplc=100)
    with pytest.raises(WaitEnded):
        readout.read("dmm.x", 3, Stop(rig, slices))
    assert rig.meter.next_talk_s() is None
    assert rig.meter.serial_poll(rig.clock.monotonic_s()) & 16
    taken = len(rig.bench.readings)
    burst = readout.read("dmm.y", 3, rig.wait)
    assert list(burst.samples) == pytest.approx([-2.0 + 1e-6 * (taken + k) for k in (1, 2, 3)], rel=1e-9)


def test_a_meter_that_lost_its_power_voids_the_burst() -> None:
    rig = gpib_rig()
    readout = rig.prepared(nplc=1)
    readout.read("dmm.x", 2, rig.wait)
    rig.meter.power_cycle()
    with pytest.raises(RigError):
        readout.read("dmm.x", 2, rig.wait)
    readout.prepare()
    assert readout.read("dmm.x", 2, rig.wait).samples == pytest.approx(1.0, abs=1e-4)


def test_a_loss_of_power_between_bursts_is_told_by_its_sign() -> None:
    rig = gpib_rig()
    readout = rig.prepared(nplc=1)
    readout.read("dmm.x", 2, rig.wait)
    rig.meter.power_cycle()
    rig.meter.listen(b"END ALWAYS;INBUF ON;TARM HOLD;NRDGS 2;NPLC 1;DCV 10", rig.clock.monotonic_s())
    with pytest.raises(DeviceFault, match="dmm: meter: it was switched off and on"):
        readout.read("dmm.x", 2, rig.wait)


def test_the_meter_s_own_errors_void_the_burst() -> None:
    rig = gpib_rig()
    readout = rig.prepared()
    readout.read("dmm.x", 1, rig.wait)
    rig.meter.listen(b"NONSENSE", rig.clock.monotonic_s())
    with pytest.raises(DeviceRefused, match="SYNTAX ERROR; the burst is dropped"):
        readout.read("dmm.x", 1, rig.wait)


def test_what_the_meter_does_not_take_is_refused_with_both_values() -> None:
    rig = gpib_rig()
    readout = rig.prepared()
    with pytest.raises(DeviceRefused, match=r"NPLC\? reads back 20, it was set to 12"):
        readout.read("dmm.x", 1, rig.wait, nplc=12.0)


def test_a_range_that_the_line_altered_is_told_as_the_range() -> None:
    rig = gpib_rig()
    readout, listen = rig.prepared(), rig.meter.listen
    rig.meter.listen = lambda data, now_s: listen(data.replace(b"DCV 10", b"DCV 1"), now_s)  # type: ignore[method-assign]
    with pytest.raises(DeviceRefused, match=r"FUNC\? reads back 1, it was set to 10; .*\(range_v of the channel\)"):
        readout.read("dmm.x", 1, rig.wait)


@pytest.mark.parametrize(
    ("command", "found"),
    [
        (b"NPLC 1", r"NPLC\? reads back 1, it was set to 10"),
        (b"AZERO OFF", r"AZERO\? reads back 0, it was set to 1"),
        (b"AZERO ONCE", r"AZERO\? reads back 2, it was set to 1"),
        (b"FIXEDZ ON", r"FIXEDZ\? reads back 1, it was set to 0"),
        (b"DCV 100", r"FUNC\? reads back 100, it was set to 10"),
        (b"DCV 1", r"FUNC\? reads back 1, it was set to 10"),
        (b"ARANGE ON", r"ARANGE\? reads back 1, it was set to 0"),
        (b"OHM 1E3", r"FUNC\? reads back 4, it was set to 1"),
        (b"ACV 10", r"FUNC\? reads back 2, it was set to 1"),
        (b"NRDGS 5,AUTO", r"NRDGS\? reads back 5, it was set to 4"),
        (b"MATH NULL", r"MATH\? reads back 7, it was set to 0"),
        (b"MATH OFF,SCALE", r"MATH\? reads back 11, it was set to 0"),
        (b"RATIO ON", r"RATIO\? reads back 1, it was set to 0"),
        (b"TRIG EXT", r"TRIG\? reads back 2, it was set to 1"),
        (b"TRIG SYN", r"TRIG\? reads back 5, it was set to 1"),
        (b"RESET", r"FUNC\? reads back 1000, it was set to 10"),  # runs free, without EOI
        (b"LFREQ 60", r"LFREQ\? reads back 60, it was set to 50"),
        (b"PRESET NORM;TARM HOLD", r"TRIG\? reads back 5, it was set to 1"),
    ],
)
def test_what_another_hand_sets_between_two_equal_bursts_is_noticed(command: bytes, found: str) -> None:
    rig = gpib_rig()
    readout = rig.prepared(nplc=10)
    readout.read("dmm.x", 4, rig.wait)
    rig.meter.listen(command, rig.clock.monotonic_s())
    taken = len(rig.bench.readings)
    with pytest.raises(DeviceRefused, match=found + "; no reading is taken; see who else sets the meter"):
        readout.read("dmm.x", 4, rig.wait)
    assert len(rig.bench.readings) == taken
    burst = readout.read("dmm.x", 4, rig.wait)  # all sent anew
    assert burst.samples == pytest.approx(1.0, abs=1e-4)
    assert burst.interval_s == pytest.approx(0.4, abs=0.002)


@pytest.mark.parametrize(
    ("command", "found"),
    [
        (b"NPLC 1", r"NPLC\? reads back 1, it was set to 10"),
        (b"AZERO OFF", r"AZERO\? reads back 0, it was set to 1"),
        (b"FIXEDZ ON", r"FIXEDZ\? reads back 1, it was set to 0"),
        (b"DCV 100", r"FUNC\? reads back 100, it was set to 10"),
        (b"ARANGE ON", r"FUNC\? reads back 1, it was set to 10"),  # and the range follows the next reading
        (b"OHM 1E3", r"FUNC\? reads back 4, it was set to 1"),
        (b"MATH NULL", r"MATH\? reads back 7, it was set to 0"),
        (b"RATIO ON", r"RATIO\? reads back 1, it was set to 0"),
        (b"TRIG SYN", r"TRIG\? reads back 5, it was set to 1"),
        (b"LFREQ 60", r"LFREQ\? reads back 60, it was set to 50"),
        (b"NONSENSE", "SYNTAX ERROR"),
    ],
)
def test_what_another_hand_sets_within_a_burst_voids_it(command: bytes, found: str) -> None:
    rig = gpib_rig()
    readout = rig.prepared(nplc=10)
    readout.read("dmm.x", 4, rig.wait)
    taken, hands = len(rig.bench.readings), [command]

    def wait(duration_s: float) -> None:
        rig.wait(duration_s)
        if hands and len(rig.bench.readings) == taken + 3:  # one reading is left
            rig.meter.listen(hands.pop(), rig.clock.monotonic_s())

    with pytest.raises(DeviceRefused, match=found + "; the burst is dropped"):
        readout.read("dmm.x", 4, wait)
    assert not hands
    burst = readout.read("dmm.x", 4, rig.wait)  # all sent anew
    assert burst.samples == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("declared", ["rear", None])
def test_inputs_that_are_changed_at_the_panel_are_not_measured(declared: str | None) -> None:
    # Keithley 2002 manual p. H-21, "for HP3458A compatibility": TERM? returns the INPUTS switch, 1 front, 2 rear.
    rig = gpib_rig()
    rig.meter.is_front = False
    readout = rig.prepared(terminals=declared)
    assert "rear inputs" in readout.identify()
    readout.read("dmm.x", 1, rig.wait)
    rig.meter.is_front = True
    taken = len(rig.bench.readings)
    sentence = r"dmm: the front inputs are selected, need those at the rear \(readouts\.dmm: terminals"
    with pytest.raises(DeviceRefused, match=f"{sentence}.*no reading is taken; press the key at the meter"):
        readout.read("dmm.x", 1, rig.wait)
    with pytest.raises(DeviceRefused, match=f"{sentence}.*no reading is taken; press the key at the meter"):
        readout.prepare()  # as a retry does: what was selected first holds
    assert len(rig.bench.readings) == taken
    rig.meter.is_front = False

    def turned(duration_s: float) -> None:
        rig.wait(duration_s)
        rig.meter.is_front = bool(rig.bench.readings[taken:])  # once the first reading is there

    with pytest.raises(DeviceRefused, match=f"{sentence}.*the burst is dropped; press the key at the meter"):
        readout.read("dmm.x", 2, turned)
    rig.meter.is_front = False
    assert readout.read("dmm.x", 1, rig.wait).samples[0] == pytest.approx(1.0, abs=1e-4)


def test_inputs_other_than_those_of_the_file_are_refused_before_anything_is_set() -> None:
    rig = gpib_rig()
    with pytest.raises(
        DeviceRefused, match=r"need those at the rear \(readouts\.dmm: terminals\); nothing was measured"
    ):
        rig.readout(terminals="rear").identify()


@pytest.mark.parametrize("more", [b"NRDGS 5,AUTO", b"NRDGS 5000,AUTO"])
def test_readings_left_after_a_burst_void_it(more: bytes) -> None:
    rig = gpib_rig()
    readout, listen = rig.prepared(), rig.meter.listen

    def disturbed(message: bytes, now_s: float) -> float:
        return listen(message.replace(b"TARM SGL", more + b";TARM SGL"), now_s)

    rig.meter.listen = disturbed  # type: ignore[method-assign]
    with pytest.raises(DeviceRefused, match="readings left after the 4 that it was set to; the burst is dropped"):
        readout.read("dmm.x", 4, rig.wait)
    rig.meter.listen = listen  # type: ignore[method-assign]
    assert readout.read("dmm.x", 4, rig.wait).samples == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("late_s", [0.0, 0.05, 0.1])
@pytest.mark.parametrize(("nplc", "samples"), [(0.1, 50), (1.0, 20), (10.0, 10)])
def test_a_meter_that_keeps_one_reading_alone_gives_a_whole_burst_or_none(
    nplc: float, samples: int, late_s: float
) -> None:
    # Not known of a 3458A with MEM OFF (docs/devices/hp3458a.md): its twin keeps them all.
    rig = gpib_rig(lambda now_s: 1.0 + 1e-3 * now_s)
    readout, advance = rig.prepared(nplc=nplc), rig.meter.advance

    def overwritten(now_s: float) -> None:
        advance(now_s)
        while len(rig.meter._ready) > 1:
            rig.meter._ready.popleft()

    rig.meter.advance = overwritten  # type: ignore[method-assign]
    try:
        burst = readout.read("dmm.x", samples, lambda duration_s: rig.wait(duration_s + late_s))
    except DeviceSilent:
        assert nplc < 10.0
        return
    assert np.diff(burst.samples) == pytest.approx(1e-3 * burst.interval_s, rel=0.01)
    assert burst.samples.size == samples


def test_a_meter_that_stays_busy_after_its_readings_is_told() -> None:
    rig = gpib_rig()
    readout = rig.prepared()
    rig.meter.serial_poll = lambda _now_s: 0  # type: ignore[method-assign]
    with pytest.raises(DeviceSilent, match=r"still busy 3\.401 s after the last reading; the burst is dropped"):
        readout.read("dmm.x", 4, rig.wait)


def test_errors_left_over_from_earlier_use_are_cleared() -> None:
    rig = gpib_rig()
    rig.meter.listen(b"NONSENSE", 0.0)
    rig.prepared()
    rig.meter.listen(b"ERRSTR?", 0.0)
    assert rig.meter.talk(0.0)[0] == b'0,"NO ERROR"\r\n'


def test_a_broken_meter_is_refused() -> None:
    rig = gpib_rig()
    rig.meter._errors = 512
    with pytest.raises(DeviceFault, match="OUT OF CALIBRATION"):
        rig.prepared()


def test_somebody_else_s_settings_do_not_survive_preparation() -> None:
    rig = gpib_rig()
    rig.meter.listen(b"PRESET NORM;NDIG 3;NPLC 100;NRDGS 7;AZERO OFF;LFREQ 60", 0.0)
    rig.scanner.listen(b"CLOSE 101,102", 0.0)
    burst = rig.prepared().read("dmm.x", 2, rig.wait)
    assert list(burst.samples) == pytest.approx([1.000001, 1.000002], rel=1e-9)
    assert burst.interval_s == pytest.approx(0.4, abs=0.002)
    assert rig.meter._settings["NDIG"] == 7  # RESET, also for what no burst needs


def test_preparation_waits_for_no_time_out() -> None:
    # Without END ALWAYS after RESET every answer would come without EOI and cost the adapter's 3 s.
    rig = gpib_rig()
    readout = rig.readout()
    before_s = rig.clock.monotonic_s()
    readout.prepare()
    assert rig.clock.monotonic_s() - before_s < 1.0


def test_unknown_channels_and_empty_bursts_are_refused_before_anything_is_switched() -> None:
    rig = gpib_rig()
    readout = rig.prepared()
    with pytest.raises(RequestRefused, match=re.escape("dmm: no channel 'x' (allowed: dmm.x, dmm.y, dmm.z)")):
        readout.read("x", 1, rig.wait)
    with pytest.raises(RequestRefused, match="got 0 readings"):
        readout.read("dmm.x", 0, rig.wait)
    assert rig.scanner.closed_channels() == frozenset()


def test_the_identity_names_every_box() -> None:
    text = gpib_rig().readout().identify()
    for box in ("HP3458A, revision 9,2", "HP3488A", "44470 in slot 1"):
        assert box in text


def test_the_meter_tells_its_temperature() -> None:
    assert 20.0 < gpib_rig().prepared().checks()["meter_temperature_degc"] < 50.0


def test_a_scanner_is_on_the_meter_s_adapter_unless_told_otherwise() -> None:
    shared = scanner_resource(meter_settings(resource="prologix+socket://10.0.0.9:1234#23"))
    assert (shared.port, shared.address) == ("socket://10.0.0.9:1234", 9)
    own = scanner_resource(meter_settings(scanner_resource="prologix+/dev/ttyUSB0#10"))
    assert (own.port, own.address) == ("/dev/ttyUSB0", 10)


@pytest.mark.parametrize("range_v", [0.5, 5.0, 12.0, 2000.0])
def test_a_range_that_the_meter_has_not_is_refused_in_the_file(range_v: float) -> None:
    with pytest.raises(ValidationError, match=r"allowed: 0\.1, 1, 10, 100, 1000 V"):
        meter_settings(channels={"x": {"scanner": 1, "range_v": range_v}})


def _first_reading(rig: GpibRig, readout: Hp3458aReadout, samples: int) -> int:
    """Return which reply the first reading of the next burst will be: that behind ``TARM SGL``, as in an equal one."""
    readout.read("dmm.x", samples, rig.wait)
    before, listen, triggered = rig.faults.taken, rig.meter.listen, []

    def watched(message: bytes, now_s: float) -> float:
        if b"TARM SGL" in message:
            triggered.append(rig.faults.taken)
        return listen(message, now_s)

    rig.meter.listen = watched  # type: ignore[method-assign]
    readout.read("dmm.x", samples, rig.wait)
    rig.meter.listen = listen  # type: ignore[method-assign]
    return rig.faults.taken + triggered[0] - before


def test_a_cut_reading_is_not_a_smaller_number() -> None:
    rig = gpib_rig()
    readout = rig.prepared()
    # The second reading; the cut one still ends in CR LF.
    rig.faults.reads = {_first_reading(rig, readout, 3) + 1: faults.replace(b" 1.0000000E+00\r\n")}
    with pytest.raises(DeviceNonsense, match=r"readings of 14 and 16 characters in one burst"):
        readout.read("dmm.x", 3, rig.wait)


def test_a_doubled_reading_voids_the_burst() -> None:
    rig = gpib_rig()
    readout = rig.prepared()
    rig.faults.reads = {_first_reading(rig, readout, 3) + 2: faults.duplicate(0.0)}
    with pytest.raises(DeviceNonsense, match="more than one reply"):
        readout.read("dmm.x", 3, rig.wait)


def test_a_reading_taken_twice_and_one_missed_void_the_burst() -> None:
    rig = gpib_rig()
    readout = rig.prepared()
    first = _first_reading(rig, readout, 4)
    rig.faults.reads = {first: faults.duplicate(0.41), first + 1: faults.delay(0.05)}
    with pytest.raises(DeviceNonsense, match="18 bytes nobody asked for came with the readings"):
        readout.read("dmm.x", 4, rig.wait)


def test_a_lost_line_is_told_and_not_papered_over() -> None:
    rig = gpib_rig()
    readout = rig.prepared()
    rig.faults.writes = {rig.faults.written + 4: faults.hang_up}
    with pytest.raises(LinkLost):
        readout.read("dmm.x", 3, rig.wait)


def line_fault() -> st.SearchStrategy[Fault]:
    return st.one_of(
        st.sampled_from([faults.drop, faults.duplicate(), faults.replace(b"10\r\n")]),
        st.floats(0.0, 9.0).map(faults.stall),
        st.integers(0, 20).map(faults.truncate),
        st.binary(max_size=12).map(faults.prepend),
    )


@settings(max_examples=60, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.dictionaries(st.integers(0, 60), line_fault(), max_size=3),
    st.dictionaries(st.integers(0, 60), st.sampled_from([faults.drop, faults.duplicate()]), max_size=2),
)
def test_whatever_the_line_does_no_reading_is_of_another_channel(
    reads: dict[int, Fault], writes: dict[int, Fault]
) -> None:
    rig = gpib_rig()
    readout = rig.prepared(nplc=1)
    rig.faults.reads = {rig.faults.taken + number: fault for number, fault in reads.items()}
    rig.faults.writes = {rig.faults.written + number: fault for number, fault in writes.items()}
    for channel in ("dmm.x", "dmm.y", "dmm.z"):
        try:
            burst = readout.read(channel, 4, rig.wait)
        except (DeviceSilent, DeviceNonsense, DeviceRefused, DeviceFault):
            continue
        assert burst.samples == pytest.approx(LEVEL_V[channel], abs=1e-3)
        assert (np.diff(burst.samples) > 0.0).all()  # the bench counts: none doubled, none out of order


@pytest.mark.parametrize("serve", [serve_tcp, serve_pty])
def test_the_same_readings_come_over_real_ports(serve: object) -> None:
    in_memory = gpib_rig()
    expected = in_memory.prepared().read("dmm.z", 5, in_memory.wait).samples
    rig, clock = gpib_rig(), ScaledClock(200.0)
    with serve(rig.adapter, clock) as server:  # type: ignore[operator]
        stream = open_stream(server.address, clock=SystemClock())
        try:
            readout = Hp3458aReadout("dmm", meter_settings(), PrologixBus(stream), clock)
            readout.prepare()
            burst = readout.read("dmm.z", 5, clock.sleep)
        finally:
            stream.close()
    assert list(burst.samples) == list(expected)


def test_time_outs_of_the_link_do_not_shrink_with_scaled_time() -> None:
    # 4 s readings at a factor of 1000 last 4 ms; the port still has its seconds.
    rig, clock = gpib_rig(), ScaledClock(1000.0)
    with serve_tcp(rig.adapter, clock) as server:
        stream = open_stream(server.address, clock=SystemClock())
        try:
            readout = Hp3458aReadout("dmm", meter_settings(nplc=100), PrologixBus(stream), clock)
            readout.prepare()
            assert math.isfinite(readout.read("dmm.x", 2, clock.sleep).samples.sum())
        finally:
            stream.close()


def test_a_second_adapter_may_carry_the_scanner() -> None:
    rig = gpib_rig()
    meter_side = MemoryStream(PrologixTwin({22: rig.meter}), rig.clock, "adapter one")
    scanner_side = MemoryStream(PrologixTwin({9: rig.scanner}), rig.clock, "adapter two")
    clock: VirtualClock = rig.clock
    readout = Hp3458aReadout(
        "dmm", meter_settings(), PrologixBus(meter_side), clock, scanner_bus=PrologixBus(scanner_side)
    )
    readout.prepare()
    assert readout.read("dmm.y", 2, rig.wait).samples == pytest.approx(-2.0, abs=1e-4)
