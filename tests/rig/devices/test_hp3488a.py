import pytest
from gpib_rig import GpibRig, gpib_rig

from rig.abilities.waiting import wait_until
from rig.devices.hp3488a import Hp3488aScanner
from rig.errors import DeviceFault, DeviceRefused, DeviceSilent
from rig.link.prologix import PrologixBus
from rig.twins.hp3488a import RELAY_S


def scanner_on(rig: GpibRig, *channels: int) -> Hp3488aScanner:
    return Hp3488aScanner("dmm", PrologixBus(rig.stream), 9, channels or (101, 102), 0.02, rig.clock)


def test_preparation_opens_every_relay_and_sees_it_open() -> None:
    rig = gpib_rig()
    rig.scanner.listen(b"CLOSE 101,105", 0.0)
    scanner_on(rig).prepare(rig.wait)
    assert rig.scanner.closed_channels() == frozenset()


def test_selecting_twice_moves_no_relay() -> None:
    rig = gpib_rig()
    scanner = scanner_on(rig)
    scanner.select(101, rig.wait)
    before_s = rig.clock.monotonic_s()
    scanner.select(101, rig.wait)
    assert rig.clock.monotonic_s() == before_s
    assert rig.scanner.closed_channels() == {101}


def test_a_switch_waits_for_the_relays() -> None:
    rig = gpib_rig()
    scanner = scanner_on(rig)
    scanner.select(101, rig.wait)
    before_s = rig.clock.monotonic_s()
    scanner.select(102, rig.wait)
    assert rig.clock.monotonic_s() - before_s >= 2 * max(RELAY_S, 0.02) - 1e-9
    assert rig.scanner.closed_channels() == {102}


def test_a_channel_that_no_card_has_is_refused_by_name() -> None:
    rig = gpib_rig()
    for channel, card in ((201, "00000"), (115, "44470")):
        with pytest.raises(DeviceRefused, match=f"dmm: scanner channel {channel}: card {card} in slot"):
            scanner_on(rig, channel).prepare(rig.wait)


def test_an_error_of_the_scanner_is_told() -> None:
    rig = gpib_rig()
    scanner = scanner_on(rig)
    scanner.select(101, rig.wait)
    rig.scanner.listen(b"CLOSE 999", rig.clock.monotonic_s())
    with pytest.raises(DeviceRefused, match="dmm: scanner: the last command: execution error"):
        scanner.select(102, rig.wait)


def test_a_doubt_starts_again_from_all_relays_open() -> None:
    rig = gpib_rig()
    scanner = scanner_on(rig)
    scanner.select(101, rig.wait)
    rig.scanner.listen(b"CLOSE 102", rig.clock.monotonic_s())  # somebody at the front panel
    scanner.forget()
    scanner.select(101, rig.wait)
    assert rig.scanner.closed_channels() == {101}


def test_a_relay_opened_by_somebody_else_is_a_fault() -> None:
    rig = gpib_rig()
    scanner = scanner_on(rig)
    scanner.select(101, rig.wait)
    rig.scanner.listen(b"OPEN 101", rig.clock.monotonic_s())
    with pytest.raises(DeviceFault, match="scanner channel 101: got open, need closed"):
        scanner.verify(101)


def test_waiting_ends_when_both_clocks_have_had_their_time() -> None:
    rig, link = gpib_rig(), gpib_rig()

    def wait(duration_s: float) -> None:
        rig.clock.sleep(60.0 * duration_s)  # rig time runs scaled
        link.clock.sleep(duration_s)

    with pytest.raises(DeviceSilent, match="still not"):
        wait_until(lambda: False, wait, (rig.clock, link.clock), 2.0, lambda: "still not")
    assert link.clock.monotonic_s() == pytest.approx(2.0, abs=0.11)
    assert rig.clock.monotonic_s() > 100.0
