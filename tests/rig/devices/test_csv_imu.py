"""Laws of the text stream's driver: counts become units, count and time show what is missing."""

import numpy as np
import pytest
from pydantic import ValidationError
from stream_rig import csv_rig, csv_settings, rate_dps

from rig.errors import DeviceNonsense
from rig.link import faults


def test_counts_become_units_by_the_presets() -> None:
    rig = csv_rig()
    imu = rig.csv()
    imu.start()
    rig.clock.sleep(10.0)
    block = imu.poll()
    assert imu.units == {"imu.ax": "g", "imu.ay": "g", "imu.az": "g", "imu.gz": "dps", "imu.mx": "ut"}
    np.testing.assert_allclose(block.values["imu.az"], -1.0, atol=0.5 / 1333)
    np.testing.assert_allclose(block.values["imu.mx"], 20.0, atol=0.5 / 31.24)
    np.testing.assert_allclose(
        block.values["imu.gz"], [rate_dps(now_s) for now_s in block.device_s], atol=0.5 / 14.375 + 0.02
    )


def test_device_time_goes_on_through_its_wraps() -> None:
    rig = csv_rig()
    imu = rig.csv()
    imu.start()
    times_s = []
    for _ in range(150):
        rig.clock.sleep(1.0)
        block = imu.poll()
        assert block.gaps == ()
        times_s.append(block.device_s)
    np.testing.assert_allclose(np.diff(np.concatenate(times_s)), 0.01, atol=1e-9)  # 65.536 s wraps twice


def test_the_first_line_may_be_half_and_a_header_may_come() -> None:
    rig = csv_rig(banner=b"33,-1330,14\r\nn,t,ax,ay,az,gz,mx,x\r\n")
    imu = rig.csv()
    imu.start()  # what waits is dropped, and the rest of a line that has begun
    rig.clock.sleep(1.0)
    block = imu.poll()
    assert block.samples >= 98
    assert block.refused == 0


@pytest.mark.parametrize(("keep", "missing"), [(0, 1), (10, None)])
def test_bytes_that_were_lost_show_in_the_count(keep: int, missing: int | None) -> None:
    rig = csv_rig()
    imu = rig.csv()
    imu.start()
    rig.faults.reads = {rig.faults.taken + 30: faults.truncate(keep)}
    gaps, samples = [], 0
    for _ in range(100):
        rig.clock.sleep(0.01)
        block = imu.poll()
        gaps += block.gaps
        samples += block.samples
    assert len(gaps) == 1
    assert gaps[0].missing == 1 if missing else gaps[0].missing in (1, 2)


def test_without_a_count_the_time_shows_it() -> None:
    rig = csv_rig()
    columns = ["-", *csv_settings().columns[1:]]
    imu = rig.csv(columns=columns, count=None)
    imu.start()
    rig.faults.reads = {rig.faults.taken + 30 + n: faults.drop for n in range(5)}
    gaps = []
    for _ in range(100):
        rig.clock.sleep(0.01)
        gaps += imu.poll().gaps
    assert [(gap.missing, "device time goes on by" in gap.why) for gap in gaps] == [(5, True)]


def test_other_columns_than_the_board_sends_are_told() -> None:
    rig = csv_rig()
    imu = rig.csv(columns=["n", "t", "ax"], channels={"ax": {"preset": "SCA3000"}})
    imu.start()
    rig.clock.sleep(1.0)
    with pytest.raises(DeviceNonsense, match=r"none of its lines is a sample.*check baud rate and columns"):
        imu.poll()


def test_noise_without_a_line_feed_is_told_and_does_not_grow() -> None:
    rig = csv_rig()
    imu = rig.csv()
    imu.start()
    rig.faults.reads = {rig.faults.taken: faults.replace(b"\x00\xf8" * 3000)}
    rig.clock.sleep(0.1)
    with pytest.raises(DeviceNonsense, match="no line feed in 6000 bytes"):
        imu.poll()
    rig.clock.sleep(1.0)
    assert imu.poll().samples > 90


def test_the_period_select_scales_the_magnetometer() -> None:
    # PNI MicroMag manual: counts are proportional to the period select.
    entry = csv_settings(
        columns=["mx"],
        count=None,
        time=None,
        channels={"mx": {"preset": "MicroMag3", "period_select": 4096}},
    ).channels["mx"]
    assert 1.0 / entry.scale == pytest.approx(62.48)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"columns": ["n", "t", "ax"]}, "column 'ay' must stand once"),
        ({"channels": {"ax": {"preset": "SCA3000"}}}, "must stand once in columns and once"),
        ({"channels": {"ax": {"counts_per_unit": 2.0}}}, "give a preset, or counts_per_unit and unit"),
        ({"channels": {"ax": {"preset": "SCA3000", "unit": "mps2"}}}, "the unit of SCA3000 is g"),
        ({"channels": {"ax": {"preset": "SCA3000", "period_select": 2048}}}, "belongs to the preset MicroMag3"),
        ({"prefix": "$*"}, "prefix"),
    ],
)
def test_settings_that_do_not_agree(changes: dict[str, object], text: str) -> None:
    with pytest.raises(ValidationError, match=text):
        csv_settings(**changes)


def test_zero_counts_and_the_sign_of_the_scale_are_applied() -> None:
    rig = csv_rig()
    channels = csv_settings().model_dump()["channels"]
    channels["az"] = {"counts_per_unit": -1333.0, "unit": "g", "zero_counts": 133.3}
    imu = rig.csv(channels=channels)
    imu.start()
    rig.clock.sleep(1.0)
    # The board sends −1333 for −1 g: (−1333 − 133.3) / −1333 = 1.1.
    np.testing.assert_allclose(imu.poll().values["imu.az"], 1.1, atol=1e-9)
