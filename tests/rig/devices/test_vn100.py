"""Laws of the VN-100's driver: the right output at the right rate, every sample whole, every loss named."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from stream_rig import rate_dps, vn100_rig, vn100_settings

from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, DeviceSilent
from rig.link import faults
from rig.wire import vn100 as wire


def test_who_it_is() -> None:
    assert vn100_rig().vn100().identify() == (
        "VectorNav VN-100T-CR, serial 100011981, firmware 2.1.0.0, no user compensation, no rotation of the frame,"
        " filter on acceleration over 4 samples and rate over 4 samples and temperature over 4 samples (register 85:"
        " 0 4 4 4 0 0 3 3 3 0; the calibration holds with it only), no hard and soft iron in real time"
        " (register 44: 0 1 5), attitude by reference vectors (register 21: 1 0 1.8 0 0 -9.79375)"
    )


ROTATED_90_DEG = (0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
SET_UP = (
    (23, (1.0, 0.0, 0.0, 0.0, 1.1, *wire.NO_COMPENSATION[5:]), "user compensation (register 23: 1 0 0 0 1.1 0 0"),
    (25, (*wire.NO_COMPENSATION[:11], 0.1), "user compensation (register 25: 1 0 0 0 1 0 0 0 1 0 0 0.1)"),
    (84, (2.0, *wire.NO_COMPENSATION[1:]), "user compensation (register 84: 2 0 0 0 1 0 0 0 1 0 0 0)"),
    (26, ROTATED_90_DEG, "frame rotated (register 26: 0 1 0 -1 0 0 0 0 1; the calibration holds with it only)"),
    (
        85,
        (0.0, 200.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0),
        "filter on acceleration over 200 samples (register 85: 0 200 0 0 0 0 3 0 0 0; the calibration holds with it",
    ),
    (85, (0.0, 4.0, 4.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), "no filter (register 85: 0 4 4 4 0 0 0 0 0 0)"),
    (44, (1.0, 3.0, 5.0), "hard and soft iron applied in real time (register 44: 1 3 5)"),
    (44, (1.0, 1.0, 5.0), "no hard and soft iron in real time (register 44: 1 1 5)"),
    (21, (0.234, 0.0, 0.4212, 0.0, 0.0, -9.79375), "reference vectors (register 21: 0.234 0 0.4212 0 0 -9.79375)"),
)
"""A register, what somebody saved in it (of 21 what a real unit told), and what the identity says then."""


@pytest.mark.parametrize(("register", "content", "words"), SET_UP)
def test_what_is_set_in_the_unit_is_named(register: int, content: tuple[float, ...], words: str) -> None:
    rig = vn100_rig()
    assert register in wire.SETUP
    as_delivered = rig.vn100().identify()
    rig.twin.setup[register] = content  # type: ignore[attr-defined]
    set_up = rig.vn100().identify()
    assert words in set_up
    assert words not in as_delivered


def test_a_firmware_without_the_registers_is_identified() -> None:
    rig = vn100_rig()
    rig.twin.setup.clear()  # type: ignore[attr-defined]
    assert (
        rig.vn100()
        .identify()
        .endswith(
            "no user compensation, no rotation of the frame, no filter, no hard and soft iron in real time, attitude by"
            " reference vectors"
        )
    )


def test_a_refusal_that_is_not_of_the_register_is_not_taken_for_its_absence() -> None:
    rig = vn100_rig()
    rig.faults.writes = {7: faults.replace(b"$VNRRG,26*00\r\n")}
    with pytest.raises(DeviceRefused, match="the unit refuses: invalid checksum"):
        rig.vn100().identify()


def test_a_register_without_numbers_is_no_setup() -> None:
    with pytest.raises(DeviceNonsense, match="register 26: 'x,0' are no numbers"):
        wire.setup_words({wire.ROTATION: "x,0"})


def test_a_minute_at_200_hz_is_12000_samples_in_order() -> None:
    rig = vn100_rig()
    imu = rig.vn100(rate_hz=200)
    imu.start()
    started_s = rig.clock.monotonic_s()
    rates_dps = []
    for _ in range(600):
        rig.clock.sleep(0.1)
        block = imu.poll()
        assert block.first == sum(map(len, rates_dps))
        assert (block.gaps, block.refused) == ((), 0)
        rates_dps.append(np.degrees(block.values["imu.gz"]))
    times_s = started_s + np.arange(12001) / 200.0
    np.testing.assert_allclose(np.concatenate(rates_dps), [rate_dps(now_s) for now_s in times_s], atol=4e-5)
    assert imu.units["imu.gz"] == "radps"


def test_level_it_feels_gravity_downwards_along_z() -> None:
    # As the line of a real unit that lies level: $VNYMR,…,-09.701,…
    rig = vn100_rig()
    imu = rig.vn100()
    imu.start()
    rig.clock.sleep(1.0)
    assert imu.poll().values["imu.az"] == pytest.approx(-9.807, abs=0.001)


def test_it_is_quiet_after_stop_and_starts_again_from_zero() -> None:
    rig = vn100_rig()
    imu = rig.vn100()
    imu.start()
    rig.clock.sleep(1.0)
    assert imu.poll().samples == 41
    imu.stop()
    rig.stream.discard_input()
    rig.clock.sleep(5.0)
    assert rig.stream.discard_input() == b""
    imu.start()
    rig.clock.sleep(0.1)
    assert (imu.poll().first, imu.poll().first) == (0, 5)


@pytest.mark.parametrize(("fault", "lost"), [(faults.flip_bit(50, 1), 1), (faults.truncate(60), 1)])
def test_a_damaged_line_is_a_gap_and_no_sample(fault: faults.Fault, lost: int) -> None:
    rig = vn100_rig()
    imu = rig.vn100()
    imu.start()
    rig.faults.reads = {rig.faults.taken + 4: fault}
    samples = refused = 0
    for _ in range(40):
        rig.clock.sleep(0.025)
        block = imu.poll()
        samples, refused = samples + block.samples, refused + block.refused
        assert len(block.gaps) == block.refused
        assert np.all(np.abs(block.values["imu.az"] + 9.807) < 0.001)
    assert refused >= lost
    assert 41 - 2 * refused <= samples <= 41 - lost


def test_a_poll_without_news_is_an_empty_block() -> None:
    rig = vn100_rig()
    imu = rig.vn100()
    imu.start()
    imu.poll()
    assert imu.poll().samples == 0


def test_the_units_own_trouble_is_a_fault() -> None:
    rig = vn100_rig()
    imu = rig.vn100()
    imu.start()
    rig.faults.reads = {rig.faults.taken: faults.prepend(wire.message(b"VNERR,0C"))}
    rig.clock.sleep(0.1)
    with pytest.raises(DeviceFault, match="the baud rate is too low for this output and rate"):
        imu.poll()


def test_what_is_no_sample_any_more_is_refused_line_by_line() -> None:
    rig = vn100_rig()
    imu = rig.vn100()
    imu.start()
    imu.poll()
    rig.faults.reads = {rig.faults.taken + n: faults.replace(b"\x80\x07\xfe" * 20 + b"\n") for n in range(20)}
    for _ in range(20):
        rig.clock.sleep(0.025)
        block = imu.poll()
        assert (block.samples, block.refused, len(block.gaps)) == (0, 1, 1)


def test_a_unit_that_streams_and_does_not_answer_is_silent() -> None:
    rig = vn100_rig()
    rig.twin.receive = lambda data, now_s: None  # type: ignore[method-assign]
    hears_nothing = r"no answer to b'VNASY,0' within 1 s.*a VectorNav sends, and does not hear.*baud_rate \(460800\)"
    with pytest.raises(DeviceSilent, match=hears_nothing):
        rig.vn100().start()


@pytest.mark.parametrize(
    ("sent", "words"),
    [
        (b"", r"the last bytes were b''; nothing was set; check power, cable and baud_rate \(460800\)"),
        (
            b"1,17,3.0,4.0\r\n",
            r"were b'.*1,17,3\.0,4\.0.*no VectorNav sends this: check that no two cables changed places",
        ),
        (b"\x80\x07\xfe\n", "what came is no text: check baud rate and parity"),
    ],
)
def test_what_comes_in_place_of_an_answer_says_what_to_look_at(sent: bytes, words: str) -> None:
    """Two streams on each other's port, as after a change of cables."""
    rig = vn100_rig()
    rig.twin.receive = lambda data, now_s: None  # type: ignore[method-assign]
    rig.faults.reads = {rig.faults.taken + n: faults.replace(sent) for n in range(1000)}
    with pytest.raises(DeviceSilent, match=words):
        rig.vn100().identify()


def test_a_setting_that_the_unit_does_not_take_is_refused() -> None:
    rig = vn100_rig()
    rig.faults.writes = {4: faults.replace(b"$VNWRG,6,99*XX\r\n")}
    with pytest.raises(DeviceRefused, match="the unit refuses: invalid parameter"):
        rig.vn100().start()


def test_a_late_answer_does_not_stand_for_another_command() -> None:
    rig = vn100_rig()
    imu = rig.vn100()
    imu.identify()
    rig.faults.reads = {rig.faults.taken: faults.delay(1.2)}
    assert imu.identify().startswith("VectorNav VN-100T-CR, serial 100011981")


def test_a_line_too_slow_for_the_output_is_refused_in_the_file() -> None:
    with pytest.raises(ValidationError, match="output IMU at 200 Hz needs 220000 baud, baud_rate is 115200"):
        vn100_settings(rate_hz=200, baud_rate=115200)
    with pytest.raises(ValidationError, match="no rate of 60 Hz"):
        vn100_settings(rate_hz=60)


def test_a_rate_that_the_unit_took_otherwise_is_found() -> None:
    rig = vn100_rig()
    rig.faults.writes = {5: faults.replace(b"$VNWRG,7,100*XX\r\n")}
    with pytest.raises(DeviceRefused, match="register 7: the unit tells 100, it was set to 40; it does not stream"):
        rig.vn100().start()


FAULTS = (
    faults.drop,
    faults.duplicate(),
    faults.truncate(70),
    faults.flip_bit(-20, 1),
    faults.prepend(b"$VNYMR,+1"),
    faults.split(60, 0.03),
    faults.replace(b"\x00\xff\n"),
)


@settings(max_examples=60)
@given(st.dictionaries(st.integers(0, 40), st.sampled_from(FAULTS), max_size=8))
def test_no_script_of_faults_makes_a_sample_that_was_not_sent(script: dict[int, faults.Fault]) -> None:
    rig = vn100_rig()
    imu = rig.vn100()
    imu.start()
    rig.faults.reads, rig.faults.taken = script, 0
    for _ in range(40):
        rig.clock.sleep(0.025)
        block = imu.poll()
        assert np.all(np.abs(block.values["imu.az"] + 9.807) < 0.001)
        assert len(block.gaps) == block.refused
