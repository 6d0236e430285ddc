"""Whether a run goes on with the devices that it began with: an inertial unit that was set up anew is another one."""

import pytest
from stream_rig import vn100_rig

from procedures.journal.known_devices import other_devices
from rig.wire import vn100 as wire

AS_RECORDED_BEFORE = "VectorNav VN-100T-CR, serial 100011981, firmware 2.1.0.0, no user compensation"
"""What journals say that were written before the other registers were read."""


def test_a_driver_that_tells_more_of_the_same_unit_is_no_other_device() -> None:
    found = vn100_rig().vn100().identify()
    assert other_devices({"imu": AS_RECORDED_BEFORE}, {"imu": found}) == {}
    assert other_devices({"imu": found}, {"imu": found}) == {}


@pytest.mark.parametrize("field", [0, 1])
@pytest.mark.parametrize("register", wire.SETUP)
def test_a_register_that_changes_while_a_run_rests_makes_it_another_device(register: int, field: int) -> None:
    rig = vn100_rig()
    before = {"imu": rig.vn100().identify()}
    content = list(rig.twin.setup[register])  # type: ignore[attr-defined]
    content[field] += 1.0
    rig.twin.setup[register] = tuple(content)  # type: ignore[attr-defined]
    after = {"imu": rig.vn100().identify()}
    for known, found in ((before, after), (after, before)):
        sentence = other_devices(known, found)["imu"]
        assert sentence.startswith("imu: was 'VectorNav")
        assert f"(register {register}: " in sentence
