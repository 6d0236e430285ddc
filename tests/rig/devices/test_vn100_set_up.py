"""What is set in a VN-100 changes what it measures: a reset in mid-run, or another program, changes it unseen.

The manual: "Upon a reset all registers will be reloaded with the values saved in non-volatile memory" (UM001 p. 54).
Compensation is C (x − b) (p. 81); a rotation of the frame acts on all outputs (p. 19).
"""

import numpy as np
import pytest
from stream_rig import StreamRig, vn100_rig

from procedures.run.dwell.stream_readout import StreamedReadout
from rig.devices.vn100 import Vn100
from rig.errors import DeviceFault
from rig.twins.physics.imu import Motion
from rig.twins.vn100 import Vn100Twin
from rig.wire import vn100 as wire

UPSIDE_DOWN = (1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0)
LEVEL_MPS2 = -9.80665
SECONDS = 2.0


def _twin(rig: StreamRig) -> Vn100Twin:
    assert isinstance(rig.twin, Vn100Twin)
    return rig.twin


def _told(rig: StreamRig, payload: str) -> None:
    """Have another program send a command; what it is answered is nobody's."""
    _twin(rig).receive(wire.message(payload.encode("ascii")), rig.clock.monotonic_s())


def _rotated_and_not_saved() -> tuple[StreamRig, Vn100]:
    """A unit that streams IMU at 40 Hz whenever power comes, upside down until then."""
    rig = vn100_rig()
    _twin(rig).registers[wire.OUTPUT] = 19
    _told(rig, "VNWNV")
    _told(rig, f"VNWRG,26,{','.join(map(str, UPSIDE_DOWN))}")
    rig.stream.discard_input()
    unit = rig.vn100(baud_rate=115200)
    assert "frame rotated (register 26" in unit.identify()
    return rig, unit


def _mean_az(unit: Vn100, rig: StreamRig) -> float:
    rig.clock.sleep(SECONDS)
    return float(np.mean(unit.poll().values["imu.az"]))


def test_a_reset_within_a_recording_voids_it() -> None:
    rig, unit = _rotated_and_not_saved()
    unit.start()
    assert _mean_az(unit, rig) == pytest.approx(-LEVEL_MPS2, abs=1e-3)
    _told(rig, "VNRST")
    assert _mean_az(unit, rig) == pytest.approx(LEVEL_MPS2, abs=1e-3), "the unit streams on, and nothing else tells"
    with pytest.raises(DeviceFault, match=r"register 26 holds 1,0,0,0,1,0,0,0,1, it held 1,0,0,0,-1,.* is void"):
        unit.stop()


@pytest.mark.parametrize("event", ["reset", "power"])
def test_a_reset_between_two_recordings_lets_none_begin(event: str) -> None:
    rig, unit = _rotated_and_not_saved()
    unit.start()
    rig.clock.sleep(SECONDS)
    unit.stop()
    if event == "reset":
        _told(rig, "VNRST")
    else:
        _twin(rig).power_cycle(rig.clock.monotonic_s())
    with pytest.raises(DeviceFault, match="nothing was recorded"):
        unit.start()


def test_a_dwell_over_a_reset_is_no_reading() -> None:
    rig, unit = _rotated_and_not_saved()
    readout = StreamedReadout(unit, rig.clock)
    assert readout.read("imu.az", 40, rig.clock.sleep).samples == pytest.approx(-LEVEL_MPS2, abs=1e-3)

    waits = 0

    def reset_in_it(duration_s: float) -> None:
        nonlocal waits
        waits += 1
        if waits == 2:
            _told(rig, "VNRST")
        rig.clock.sleep(duration_s)

    with pytest.raises(DeviceFault, match="register 26"):
        readout.read("imu.az", 400, reset_in_it)


@pytest.mark.parametrize(
    ("register", "content"),
    [
        (23, "1,0,0,0,1,0,0,0,1,0.1,0,0"),
        (25, "1.01,0,0,0,1,0,0,0,1,0,0,0"),
        (84, "1,0,0,0,1,0,0,0,1,0,0,0.01"),
        (85, "0,200,0,0,0,0,3,0,0,0"),
        (44, "1,3,5"),
        (21, "0.2,0,0.4,0,0,-9.79"),
    ],
)
def test_every_register_that_changes_measurements_is_held_to_what_it_was(register: int, content: str) -> None:
    rig = vn100_rig()
    unit = rig.vn100()
    unit.identify()
    unit.start()
    rig.clock.sleep(SECONDS)
    _told(rig, f"VNWRG,{register},{content}")
    with pytest.raises(DeviceFault, match=f"register {register} holds {content}"):
        unit.stop()


def test_another_output_or_rate_voids_a_recording() -> None:
    for payload, found in (("VNWRG,6,14", "register 6 holds 14, it held 19"), ("VNWRG,7,20", "register 7 holds 20")):
        rig = vn100_rig()
        unit = rig.vn100()
        unit.start()
        _told(rig, payload)
        with pytest.raises(DeviceFault, match=found):
            unit.stop()


def test_what_stays_is_recorded_as_before() -> None:
    rig, unit = _rotated_and_not_saved()
    for _ in range(3):
        unit.start()
        assert _mean_az(unit, rig) == pytest.approx(-LEVEL_MPS2, abs=1e-3)
        unit.stop()


class Still:
    """Feels 1 g downwards in a field of 40 µT."""

    def motion(self, stream: str, now_s: float) -> Motion:
        return Motion(field_ut=(40.0, 0.0, 0.0), force_g=(0.0, 0.0, -1.0))


def test_the_twin_compensates_and_rotates_as_the_manual_says() -> None:
    twin = Vn100Twin("imu", Still())
    _write = "VNWRG,23,2,0,0,0,1,0,0,0,1,0.1,0,0"
    for payload in ("VNASY,0", _write, "VNWRG,26,0,1,0,-1,0,0,0,0,1"):
        twin.receive(wire.message(payload.encode("ascii")), 0.0)
    twin.transmit(0.0)
    twin.receive(b"$VNRRG,54*72\r\n", 0.0)
    fields = [float(part) for part in wire.parse_message(twin.transmit(0.0))[2:]]
    assert fields[:3] == pytest.approx([0.0, -0.4, 0.0], abs=1e-4), "rotated, and not compensated"
    twin.receive(wire.message(b"VNWRG,6,10"), 0.0)
    twin.receive(wire.message(b"VNASY,1"), 0.0)
    twin.transmit(0.0)
    line = twin.transmit(1.0).splitlines(keepends=True)[0]
    assert [float(part) for part in wire.parse_message(line)[1:]] == pytest.approx([-0.2, -0.4, 0.0], abs=1e-4)
