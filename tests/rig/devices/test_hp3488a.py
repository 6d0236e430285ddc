import pytest
from gpib_rig import GpibRig, gpib_rig

from rig.abilities.waiting import wait_until
from rig.devices.hp3488a import LOOK_LASTS_S, Hp3488aScanner
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


BESIDE = "scanner channel {}: got closed, need open beside 101: the meter is on both and reads a mixture"


@pytest.mark.parametrize("other", [100, 102, 105, 109])
def test_a_second_relay_is_told_whether_the_rig_uses_it_or_not(other: int) -> None:
    rig = gpib_rig()
    scanner = scanner_on(rig)
    scanner.select(101, rig.wait)
    rig.scanner.listen(b"CLOSE %d" % other, rig.clock.monotonic_s())  # another program, or a hand at the panel
    with pytest.raises(DeviceFault, match=BESIDE.format(other)):
        scanner.verify(101)
    rig.clock.sleep(LOOK_LASTS_S)
    scanner.select(101, rig.wait)  # as a retry does: from all relays open
    assert rig.scanner.closed_channels() == {101}


@pytest.mark.parametrize(
    ("sent", "heard"),
    [(b"CLOSE 101", b"CLOSE 101,105"), (b"CLOSE 101", b"CLOSE 105;CLOSE 101"), (b"CRESET 1", b"CLOSE 105")],
)
def test_a_command_that_the_line_alters_connects_no_second_input_without_a_word(sent: bytes, heard: bytes) -> None:
    rig = gpib_rig()
    scanner, listen = scanner_on(rig), rig.scanner.listen
    rig.scanner.listen = lambda data, now_s: listen(data.replace(sent, heard), now_s)  # type: ignore[method-assign]
    with pytest.raises(DeviceFault, match="scanner channel 105: got closed, need open"):
        scanner.select(101, rig.wait)


def test_a_relay_closed_between_two_bursts_of_one_channel_is_seen_before_the_second_is_believed() -> None:
    rig = gpib_rig()
    scanner = scanner_on(rig)
    scanner.select(101, rig.wait)
    rig.scanner.listen(b"CLOSE 105", rig.clock.monotonic_s())
    scanner.select(101, rig.wait)  # a moment after the last look
    with pytest.raises(DeviceFault, match=BESIDE.format(105)):
        scanner.verify(101)
    scanner.select(101, rig.wait)
    rig.scanner.listen(b"CLOSE 105", rig.clock.monotonic_s())
    rig.clock.sleep(LOOK_LASTS_S)
    with pytest.raises(DeviceFault, match=BESIDE.format(105)):
        scanner.select(101, rig.wait)


def test_cards_that_the_rig_file_does_not_name_are_left_alone() -> None:
    rig = gpib_rig(cards={1: "44470", 2: "44470"})
    rig.scanner.listen(b"CLOSE 103,207", 0.0)
    scanner = scanner_on(rig)
    scanner.select(101, rig.wait)
    scanner.verify(101)
    assert rig.scanner.closed_channels() == {101, 207}


def test_a_card_that_the_rig_file_names_is_the_rig_s_though_no_channel_is_on_it() -> None:
    rig = gpib_rig(cards={1: "44470", 2: "44470"})
    rig.scanner.listen(b"CLOSE 207", 0.0)
    scanner = Hp3488aScanner("dmm", PrologixBus(rig.stream), 9, (101,), 0.02, rig.clock, {2: "44470"})
    scanner.select(101, rig.wait)
    assert rig.scanner.closed_channels() == {101}
    rig.scanner.listen(b"CLOSE 207", rig.clock.monotonic_s())
    with pytest.raises(DeviceFault, match=BESIDE.format(207)):
        scanner.verify(101)


def test_releasing_sees_every_relay_open() -> None:
    rig = gpib_rig()
    scanner = scanner_on(rig)
    scanner.select(101, rig.wait)
    rig.scanner.listen(b"CLOSE 108", rig.clock.monotonic_s())
    with pytest.raises(DeviceFault, match="scanner channel 108: got closed, need open; no reading is taken or kept"):
        scanner.release(rig.wait)


@pytest.mark.parametrize("lacking", [range(7, 10), range(4, 10)], ids=["44477", "44476"])
def test_a_smaller_card_that_calls_itself_44471_is_asked_for_what_it_has(lacking: range) -> None:
    # gpib-utils src/hp3488.h: "44477 and 44476 are reported as 44471 by CTYPE command", with 00 to 06 and 00 to 03.
    rig = gpib_rig(cards={1: "44471"})
    rig.scanner.missing[1] = frozenset(lacking)
    scanner = scanner_on(rig)
    scanner.select(101, rig.wait)
    rig.scanner.listen(b"CLOSE 103", rig.clock.monotonic_s())
    with pytest.raises(DeviceFault, match=BESIDE.format(103)):
        scanner.verify(101)


def test_a_card_that_answers_for_some_channels_as_none_does_is_a_fault() -> None:
    rig = gpib_rig(cards={1: "44471"})
    rig.scanner.missing[1] = frozenset((5,))
    with pytest.raises(DeviceFault, match=r"the 44471 in slot 1 answers for channels 100, .* alone, as no card"):
        scanner_on(rig).prepare(rig.wait)


def test_waiting_ends_when_both_clocks_have_had_their_time() -> None:
    rig, link = gpib_rig(), gpib_rig()

    def wait(duration_s: float) -> None:
        rig.clock.sleep(60.0 * duration_s)  # rig time runs scaled
        link.clock.sleep(duration_s)

    with pytest.raises(DeviceSilent, match="still not"):
        wait_until(lambda: False, wait, (rig.clock, link.clock), 2.0, lambda: "still not")
    assert link.clock.monotonic_s() == pytest.approx(2.0, abs=0.11)
    assert rig.clock.monotonic_s() > 100.0
