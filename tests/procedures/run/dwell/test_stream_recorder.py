"""Streams recorded while time passes: nothing lost unseen, and when each sample was taken.

The twin's own beat is the truth: sample k is taken k / rate behind the start.
"""

import numpy as np
import pytest
from stream_rig import StreamRig, csv_rig, rate_dps, vn100_rig

from procedures.run.dwell.alignment import align, timing
from procedures.run.dwell.stream_readout import StreamedReadout
from procedures.run.dwell.stream_recorder import Gap, Recorder, Recording, recording
from rig.clock import ScaledClock
from rig.errors import DeviceSilent
from rig.link.faults import drop, replace
from rig.link.ports import open_stream
from rig.twins.csv_imu import CsvImuTwin
from rig.twins.physics.imu import Motion
from rig.twins.serving.servers import serve_tcp
from rig.wire.csv_rows import RowShape


def _recorded(rig: StreamRig, seconds: float, **settings: object) -> Recording:
    stream = rig.csv(**settings)
    with recording({"imu": stream}, rig.clock, rig.clock.sleep, is_timed=True) as recorder:
        recorder.start()
        recorder.wait(seconds)
        return recorder.stop()["imu"]


def test_every_sample_is_kept_with_the_device_s_own_time() -> None:
    recorded = _recorded(csv_rig(), 20.0)
    assert recorded.samples in (1999, 2000, 2001)
    np.testing.assert_allclose(np.diff(recorded.device_s), 0.01, atol=1e-9)
    assert (recorded.gaps, recorded.refused) == ((), 0)
    rates = [rate_dps(at_s) for at_s in recorded.device_s]
    np.testing.assert_allclose(recorded.values["imu.gz"], rates, atol=0.5 / 14.375 + 1e-9)  # whole counts


def test_samples_are_placed_in_rig_time_within_the_stated_uncertainty() -> None:
    rig = csv_rig()
    rig.clock.sleep(123.456)
    rig.stream.discard_input()  # it talks from the moment it is switched on: here
    recorded = _recorded(rig, 20.0)
    found = align(recorded)
    assert found.offset_s == pytest.approx(123.456, abs=3.0 * found.offset_uncertainty_s)
    assert found.offset_uncertainty_s < 2e-4
    assert abs(found.drift) <= 3.0 * found.drift_uncertainty + 1e-12


def test_offset_and_drift_cover_the_truth_in_nineteen_of_twenty_recordings() -> None:
    """Polls at random, each sample late by a random time: the intervals are those of the stamps of least delay."""
    rng = np.random.default_rng(7)
    held = {"offset": 0, "drift": 0}
    away_s, stated_s = [], []
    trials = 400
    for _ in range(trials):
        device_s = np.arange(3000) * 0.01
        drift, offset_s = rng.normal(0.0, 50e-6), 17.0
        middle_s = float(device_s.mean())
        true_s = device_s + offset_s + drift * (device_s - middle_s)
        polled = np.sort(rng.choice(3000, 1200, replace=False))
        late_s = rng.uniform(0.0, 0.004, polled.size)
        recorded = Recording("imu", 100.0, {}, device_s, polled, true_s[polled] + late_s, (), 0)
        found = align(recorded)
        away_s.append(found.offset_s - offset_s)
        stated_s.append(found.offset_uncertainty_s)
        held["offset"] += abs(found.offset_s - offset_s) <= 2.0 * found.offset_uncertainty_s
        held["drift"] += abs(found.drift - drift) <= 2.0 * found.drift_uncertainty
    assert held["offset"] / trials > 0.93
    assert abs(np.mean(away_s)) < 0.25 * np.mean(stated_s), (
        "as much too early as too late: the least of them is late too"
    )
    assert 0.90 < held["drift"] / trials <= 1.0


def test_fault_67_one_sample_lost_in_a_thousand_is_named() -> None:
    rig = csv_rig()
    rig.faults.reads = {rig.faults.taken + 700: drop}
    recorded = _recorded(rig, 12.0)
    assert [(gap.missing, gap.why) for gap in recorded.gaps] == [(1, "the count goes on by 2")]
    found = timing(recorded, align(recorded))
    assert (found.missing, found.doubled, found.doubtful) == (1, 0, 0)
    assert found.first_gap == f"before sample {recorded.gaps[0].at}: the count goes on by 2"
    np.testing.assert_allclose(recorded.device_s[-1] - recorded.device_s[0], 0.01 * recorded.samples, atol=1e-9)


def test_fault_67_a_count_that_wraps_at_two_to_the_sixteenth_is_no_gap() -> None:
    """Detected: the device's own counter, undone at its wraps, and its stamps against the host's.
    Response: gaps and doubles are listed by dwell; more than the limit voids it.
    """
    twin = CsvImuTwin(
        "imu", _Still(), RowShape(2), ["n", "ax"], 1000.0, lambda _column, value: 1333.0 * value,
        count={"n": 65536.0},
    )  # fmt: skip
    rig = StreamRig(twin)
    settings = {
        "rate_hz": 1000.0, "columns": ["n", "ax"], "count": {"column": "n", "wraps_at": 65536.0}, "time": None,
        "channels": {"ax": {"preset": "SCA3000"}},
    }  # fmt: skip
    stream = rig.csv(**settings)
    stream.start()
    found = []
    for _ in range(7):
        rig.clock.sleep(10.0)
        found.append(stream.poll())
    assert sum(block.samples for block in found) > 65536 + 1000
    assert [block.gaps for block in found] == [()] * 7


class _Still:
    def motion(self, stream: str, now_s: float) -> Motion:
        return Motion()


def test_a_part_keeps_the_gaps_between_its_samples_and_no_others() -> None:
    values = np.arange(10.0)
    gaps = (Gap(2, 1, "a"), Gap(5, None, "b"), Gap(7, 0, "c"))
    whole = Recording("imu", 1.0, {"imu.x": values}, values, np.array([3, 9]), np.array([3.5, 9.5]), gaps, 0)
    part = whole.part(2, 5)
    assert part.values["imu.x"].tolist() == [2.0, 3.0, 4.0, 5.0, 6.0]
    assert part.gaps == (Gap(3, None, "b"),)  # the gap before its first sample lies outside
    assert part.last_of_poll.tolist() == [1]


def test_a_stream_without_time_stamps_is_counted() -> None:
    rig = vn100_rig()
    stream = rig.vn100()
    with recording({"imu": stream}, rig.clock, rig.clock.sleep) as recorder:
        recorder.start()
        recorder.wait(5.0)
        recorded = recorder.stop()["imu"]
    np.testing.assert_allclose(np.diff(recorded.device_s), 1.0 / 40.0)


def test_a_stream_that_falls_silent_is_told() -> None:
    rig = csv_rig()
    stream = rig.csv()
    rig.faults.reads = {rig.faults.taken + index: drop for index in range(100, 100_000)}
    with recording({"imu": stream}, rig.clock, rig.clock.sleep) as recorder:
        recorder.start()
        with pytest.raises(DeviceSilent, match=r"streams\.imu: no sample for 5\.05 s"):
            recorder.wait(60.0)


def test_a_stream_whose_lines_are_another_device_s_is_told_by_what_comes() -> None:
    """Fewer than the lines that a board may say first: what sends here is slow."""
    rig, foreign = csv_rig(), replace(b"$VNYPR,+010.071,+000.278,-002.026*60\r\n")
    rig.faults.reads = {rig.faults.taken + index: foreign if index < 20 else drop for index in range(100_000)}
    with recording({"imu": rig.csv()}, rig.clock, rig.clock.sleep) as recorder:
        recorder.start()
        with pytest.raises(DeviceSilent, match=r"no sample for 5\.05 s, but \d+ lines that are none; .* no two cables"):
            recorder.wait(60.0)


def test_so_many_samples_on_demand() -> None:
    rig = csv_rig()
    burst = StreamedReadout(rig.csv(), rig.clock).read("imu.ax", 25, rig.clock.sleep)
    assert burst.samples.shape == (25,)
    assert burst.interval_s == 0.01
    assert not burst.overload.any()


def test_in_real_time_a_thread_empties_the_line() -> None:
    clock = ScaledClock(20.0)
    source = csv_rig()
    with serve_tcp(source.twin, clock) as server:
        from stream_rig import csv_settings

        from rig.clock import SystemClock
        from rig.devices.csv_imu import connect

        line = open_stream(server.address, clock=SystemClock())
        stream = connect("imu", csv_settings(), line, clock)
        recorder = Recorder({"imu": stream}, clock, clock.sleep)
        try:
            recorder.start()
            recorder.wait(10.0)
            recorded = recorder.stop()["imu"]
        finally:
            recorder.close()
            line.close()
    assert recorded.samples > 800
    assert recorded.gaps == ()
    assert recorded.last_of_poll.size > 20  # many polls, though nobody waited in slices
