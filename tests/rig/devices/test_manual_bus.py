"""What manuals and published firmware say of GPIB adapters and the 3458A: docs/devices/prologix.md, hp3458a.md."""

import pytest
from gpib_rig import gpib_rig, meter_settings, virtual_clock
from recording_adapter import RecordingAdapter

from rig.errors import DeviceNonsense, DeviceRefused
from rig.link.memory import MemoryStream
from rig.link.prologix import PrologixBus
from rig.twins.hp3458a import Hp3458aTwin
from rig.twins.prologix import PrologixTwin
from rig.wire import hp3458a as meter
from rig.wire import prologix as wire


def _opened(twin: PrologixTwin) -> tuple[PrologixBus, RecordingAdapter]:
    listener = RecordingAdapter(twin)
    return PrologixBus(MemoryStream(listener, virtual_clock(), "memory")), listener


@pytest.mark.parametrize(
    "name", ["AR488 GPIB controller, ver. 0.53.04, 13/04/2025", "GPIB of the bench", wire.PROLOGIX]
)
def test_a_clone_is_known_by_its_real_version_and_its_eeprom_is_left_alone(name: str) -> None:
    # A-M p. 77: "Instead, issuing the ++savecfg command saves a snapshot of the complete and current configuration."
    # A-M p. 86: "Issuing the command with the parameter 'real' will always display the default AR488 version string."
    twin = PrologixTwin({}, clone_named=name)
    _, listener = _opened(twin)
    assert not [line for line in listener.lines if line.startswith(b"++savecfg")]
    assert twin.eeprom_writes == 0


def test_savecfg_of_a_clone_writes_whatever_its_argument() -> None:
    twin = PrologixTwin({}, clone_named="AR488 GPIB controller, ver. 0.53.04, 13/04/2025")
    for line in (b"++savecfg 0\n", b"++savecfg 1\n", b"++savecfg\n"):
        twin.receive(line, 0.0)
    assert twin.eeprom_writes == 3
    assert twin.transmit(0.0) == b""


def test_a_genuine_adapter_is_spared_its_eeprom_too() -> None:
    # P-107: `++savecfg 0`: automatic saving off, nothing else; after power-up it is 1 and every change is saved.
    twin = PrologixTwin({})
    _, listener = _opened(twin)
    assert b"++savecfg 0" in listener.lines
    assert twin.eeprom_writes == 0


def test_messages_end_by_eoi_alone() -> None:
    # QRG p. 6: "the multimeter processes the cr immediately, but does not process the lf until the command completes
    # execution": with INBUF OFF the bus is held from the lf on. `++eos` 3: none.
    twin = PrologixTwin({})
    _opened(twin)
    assert twin.settings["eos"] == 3


@pytest.mark.parametrize("left", ["reading", "auto"])
def test_a_meter_left_talking_is_silenced(left: str) -> None:
    # hp3458a.md: "A meter left talking (END OFF, free running) makes `++read eoi` endless; cure: `++clr`, then `++ifc`,
    # then `++rst` (5 s on a Prologix), then `END ALWAYS`." UG p. 176: power-on value of END: OFF.
    talker = Hp3458aTwin(lambda _now_s: 1.0)
    twin = PrologixTwin({22: talker}, saved={"auto": int(left == "auto"), "addr": 22, "read_tmo_ms": 3000})
    twin.receive(b"++read eoi\n" if left == "reading" else b"TRIG AUTO\n", 0.0)
    bus, listener = _opened(twin)
    assert b"++ifc" in listener.lines
    bus.send(22, b"END ALWAYS")
    assert bus.ask(22, b"ID?", meter.parse_identity, idempotent=True) == "HP3458A"


class DeafAdapter:
    """Sends without end and takes nothing: nothing on the line can stop it."""

    heard = b""

    def receive(self, data: bytes, now_s: float) -> None:
        self.heard += data
        self._now_s = now_s

    def transmit(self, now_s: float) -> bytes:
        self._now_s = now_s
        return b"+1.00000000E+00\r\n"

    def next_event_s(self) -> float:
        return self._now_s + 0.05


def test_what_cannot_be_silenced_is_told_with_all_that_was_tried_in_a_safe_order() -> None:
    adapter = DeafAdapter()
    with pytest.raises(
        DeviceNonsense, match=r"talks without end.*\+\+auto 0, \+\+ifc, \+\+clr, \+\+rst.*switch it off"
    ):
        PrologixBus(MemoryStream(adapter, virtual_clock(), "memory"))
    tried = [line for line in adapter.heard.split(b"\n") if line in (b"++auto 0", b"++ifc", b"++clr", b"++rst")]
    assert tried == [b"++auto 0", b"++ifc", b"++clr", b"++rst"]


@pytest.mark.parametrize("length", [13, 14, 15, 16, 18, 19])
def test_a_reading_has_fifteen_characters_or_about(length: int) -> None:
    # UG p. 149: "ASCII-- 15bytes per reading"; logs show 16. "Take 14 to 18 characters, parse as a number."
    line = b" 1." + b"0" * (length - 7) + b"E+00"
    assert len(line) == length
    if 14 <= length <= 18:
        assert meter.parse_reading(line) == (1.0, length)
    else:
        with pytest.raises(DeviceNonsense, match="14 to 18"):
            meter.parse_reading(line)


@pytest.mark.parametrize("decimals", [8, 9])
def test_a_meter_of_either_length_is_read(decimals: int) -> None:
    # UG p. 149: 15 bytes a reading; 16 in logs of units, as the twin sends where nothing is said.
    assert meter.format_reading(1.00000012, decimals=8) == b" 1.00000012E+00\r\n"
    assert meter.format_reading(-1.23456789e-3, decimals=8) == b"-1.23456789E-03\r\n"
    rig = gpib_rig()
    rig.meter._decimals = decimals
    assert rig.prepared().read("dmm.x", 3, rig.wait).samples == pytest.approx(1.0, abs=1e-5)


def test_power_on_leaves_end_off_and_preset_does_not_touch_it() -> None:
    # UG p. 176; PKG PRESET (docstring): END, EMASK, RQS and QFORMAT are not in the list of commands that it runs.
    twin = Hp3458aTwin(lambda _now_s: 0.0)
    assert _asked(twin, b"END?") == b"0"
    twin.listen(b"END ALWAYS;PRESET NORM\r\n", 0.0)
    assert _asked(twin, b"END?") == b"2"
    assert [_asked(twin, query) for query in (b"NPLC?", b"NDIG?", b"TARM?", b"TRIG?")] == [b"1", b"6", b"1", b"5"]
    twin.listen(b"RESET\r\n", 0.0)
    assert [_asked(twin, query) for query in (b"END?", b"NPLC?", b"NDIG?")] == [b"0", b"10", b"7"]


def _asked(twin: Hp3458aTwin, query: bytes) -> bytes:
    twin.listen(query + b"\r\n", 0.0)
    return twin.talk(0.0)[0].strip()


def test_revision_option_and_number_of_adjustments_are_recorded() -> None:
    # `REV?` two numbers with a comma; `OPT?` 0 or 1; CAL p. 73 `CALNUM?`: "Returns a decimal number indicating the
    # number of times the multimeter has been adjusted." `247` and `2.47E+02` must both be taken.
    rig = gpib_rig()
    found = rig.prepared().identify()
    assert "revision 9,2, option 0, adjusted 247 times" in found


def test_the_input_is_set_to_more_than_ten_gigohm() -> None:
    # UG p. 55: "With FIXEDZ ON the input resistance is fixed at 10MΩ".
    rig = gpib_rig()
    rig.meter.listen(b"FIXEDZ ON\r\n", 0.0)
    rig.prepared()
    assert _asked(rig.meter, b"END ALWAYS;FIXEDZ?") == b"0"


def test_a_meter_that_stays_at_ten_megohm_is_refused() -> None:
    rig = gpib_rig()
    rig.meter._actions["FIXEDZ"] = lambda _words, _now_s: rig.meter._settings.update(FIXEDZ=1)
    with pytest.raises(DeviceRefused, match=r"FIXEDZ\? reads back 1, it was set to 0"):
        rig.prepared()


def test_a_calibration_to_its_own_standards_ages() -> None:
    # By temperature alone a steady room never asks for it.
    rig = gpib_rig()
    checks = {"autocalibrate": True, "autocalibrate_every_h": 24.0}
    readout = rig.prepared(checks=checks)
    readout.check_itself(rig.wait)
    assert not readout.needs_check()
    rig.clock.sleep(25 * 3600.0)
    assert readout.needs_check()


@pytest.mark.parametrize("number", [99, 145, 110 + 4, 600 - 1, 20])
def test_a_channel_that_no_card_of_a_3488a_has_is_refused_with_the_file(number: int) -> None:
    # hp3488a.md: 44470 and 44471 have 00 to 09, 44472 and 44478 also 10 to 13, 44473 to 33; five slots.
    with pytest.raises(ValueError, match="no card of a 3488A has it"):
        gpib_rig().readout(channels={"x": {"scanner": number, "range_v": 10.0}})


@pytest.mark.parametrize(
    ("cards", "numbers", "said"),
    [
        # hp3488a.md: a 44472 has 00 to 03 and 10 to 13, a 44470 and a 44471 have 00 to 09.
        ({}, (105, 112), "no card of a 3488A has all of them"),
        (
            {"1": "44472"},
            (105,),
            r"scanner channel 105: the 44472 in slot 1 \(cards\) has no such channel \(allowed: 100",
        ),
        ({"1": "44470"}, (112,), r"scanner channel 112: the 44470 in slot 1 .*108, 109\)"),
        ({"6": "44470"}, (101,), "'1', '2', '3', '4' or '5'"),
        ({"1": "44478"}, (101,), "'44470', '44471' or '44472'"),
    ],
)
def test_a_channel_that_the_card_of_its_slot_lacks_is_refused_with_the_file(
    cards: dict[str, str], numbers: tuple[int, ...], said: str
) -> None:
    channels = {f"c{number}": {"scanner": number, "range_v": 10.0} for number in numbers}
    with pytest.raises(ValueError, match=said):
        meter_settings(channels=channels, cards=cards)


def test_a_card_that_is_not_the_one_of_the_file_is_refused_before_anything_is_switched() -> None:
    rig = gpib_rig()
    readout = rig.readout(cards={"1": "44471"})
    with pytest.raises(DeviceRefused, match=r"has a 44470, the rig file says 44471 .*nothing was switched"):
        readout.prepare()
    assert not rig.scanner.closed_channels()
