from contextlib import suppress

import pytest
from gpib_rig import gpib_rig, virtual_clock
from recording_adapter import RecordingAdapter

from rig.errors import DeviceNonsense, DeviceRefused, DeviceSilent
from rig.link import faults
from rig.link.faults import FaultScript
from rig.link.memory import MemoryStream
from rig.link.prologix import PrologixBus
from rig.twins.prologix import RANGES, PrologixTwin
from rig.wire import hp3458a, hp3488a

FOREIGN = {"mode": 0, "auto": 1, "eoi": 0, "eos": 0, "eot_enable": 1, "eot_char": 0, "read_tmo_ms": 50, "addr": 7}
"""What another program may have left in the adapter."""


def identity(bus: PrologixBus, address: int = 22) -> str:
    return bus.ask(address, b"ID?", hp3458a.parse_identity, idempotent=True)


def test_saving_is_switched_off_before_anything_else() -> None:
    listener = RecordingAdapter(PrologixTwin({}))
    PrologixBus(MemoryStream(listener, virtual_clock(), "memory"))
    lines = [line for line in listener.heard.split(b"\n") if line]
    assert lines[:3] == [b"++ver", b"++ver real", b"++savecfg 0"]
    assert listener.twin.eeprom_writes == 0


def test_every_setting_of_somebody_else_is_replaced() -> None:
    twin = PrologixTwin({}, saved=FOREIGN)
    PrologixBus(MemoryStream(twin, virtual_clock(), "memory"))
    # STACK and the manual: controller, no read after write, EOI and nothing behind, no mark, the longest time-out.
    need = {
        "mode": 1,
        "auto": 0,
        "eoi": 1,
        "eos": 3,
        "eot_enable": 0,
        "eot_char": 10,
        "read_tmo_ms": 3000,
        "savecfg": 0,
    }
    assert {name: twin.settings[name] for name in need} == need
    assert set(need) | {"addr"} == set(RANGES)


def test_a_setting_that_does_not_hold_is_refused() -> None:
    class Stubborn(PrologixTwin):
        def _setting(self, name: str, argument: str) -> None:
            super()._setting(name, "50" if name == "read_tmo_ms" and argument else argument)

    with pytest.raises(DeviceRefused, match=r"memory: adapter setting \+\+read_tmo_ms: got 50, need 3000"):
        PrologixBus(MemoryStream(Stubborn({}), virtual_clock(), "memory"))


def test_what_is_no_adapter_is_refused() -> None:
    class Modem(PrologixTwin):
        def _reply(self, text: str) -> None:
            super()._reply("ERROR")

    with pytest.raises(DeviceNonsense, match="names itself with the word GPIB"):
        PrologixBus(MemoryStream(Modem({}), virtual_clock(), "memory"))


def test_a_dead_port_is_silent_within_its_time() -> None:
    class Dead(PrologixTwin):
        def receive(self, data: bytes, now_s: float) -> None:
            return None

    clock = virtual_clock()
    with pytest.raises(DeviceSilent, match=r"memory: no complete reply to .*\+\+ver.* within 3.5 s"):
        PrologixBus(MemoryStream(Dead({}), clock, "memory"))
    assert clock.monotonic_s() < 15.0


def test_an_adapter_that_falls_silent_is_told_by_the_question_that_it_owes_an_answer() -> None:
    """After a doubt its version is asked for: what it is called is known by then, and is no question."""

    class Failing(PrologixTwin):
        is_dead = False

        def receive(self, data: bytes, now_s: float) -> None:
            if not self.is_dead:
                super().receive(data, now_s)

    twin = Failing({})
    bus = PrologixBus(MemoryStream(twin, virtual_clock(), "memory"))
    twin.is_dead = True
    for _ in range(2):  # the first leaves the line in doubt, the second has to bring it to a known state
        with pytest.raises(DeviceSilent, match=r"no complete reply to b'(ID\?|\+\+ver).*: got b'' within"):
            identity(bus)


def test_a_question_and_its_fetch_leave_in_one_send_and_the_address_once() -> None:
    rig = gpib_rig()
    listener = RecordingAdapter(rig.adapter)
    bus = PrologixBus(MemoryStream(listener, rig.clock, "memory"))
    bus.send(22, b"END ALWAYS")
    listener.heard = b""
    identity(bus)
    assert listener.heard == b"ID?\n++read eoi\n"
    bus.ask(9, b"ID?", hp3488a.parse_identity, idempotent=True)
    assert listener.heard.endswith(b"++addr 9\nID?\n++read eoi\n")


def test_special_characters_reach_the_instrument_whole() -> None:
    heard: list[bytes] = []

    class Deaf:
        def listen(self, message: bytes, now_s: float) -> float:
            heard.append(message)
            return now_s

    rig = gpib_rig()
    rig.adapter.instruments[5] = Deaf()  # type: ignore[assignment]
    rig.adapter.instruments[5].advance = lambda now_s: None  # type: ignore[method-assign]
    PrologixBus(rig.stream).send(5, b'DISP "A+B\r\n\x1b++addr 3"')
    assert heard == [b'DISP "A+B\r\n\x1b++addr 3"']


def test_a_missing_instrument_is_silent_and_the_bus_goes_on() -> None:
    rig = gpib_rig()
    bus = PrologixBus(rig.stream)
    bus.send(22, b"END ALWAYS")
    with pytest.raises(DeviceSilent, match="check power, address"):
        bus.ask(12, b"ID?", hp3458a.parse_identity, idempotent=False)
    assert identity(bus) == "HP3458A"


def test_after_a_late_answer_the_next_question_gets_its_own() -> None:
    rig = gpib_rig()
    bus = PrologixBus(rig.stream)
    bus.send(22, b"END ALWAYS")
    rig.faults.reads = {rig.faults.taken: faults.stall(5.0)}
    with pytest.raises(DeviceSilent):
        bus.ask(22, b"NPLC?", hp3458a.parse_number, idempotent=False)
    assert bus.ask(22, b"NDIG?", hp3458a.parse_number, idempotent=False) == 7.0
    assert bus.counts.silent == 1
    assert bus.counts.stale_bytes >= len(b"10\r\n")


def test_a_doubled_answer_does_not_shift_the_next() -> None:
    rig = gpib_rig()
    bus = PrologixBus(rig.stream)
    bus.send(22, b"END ALWAYS")
    rig.faults.reads = {rig.faults.taken: faults.duplicate()}
    with pytest.raises(DeviceNonsense, match="more than one reply"):
        bus.ask(22, b"NPLC?", hp3458a.parse_number, idempotent=False)
    assert bus.ask(22, b"NDIG?", hp3458a.parse_number, idempotent=False) == 7.0


def test_a_question_that_may_be_repeated_survives_a_lost_answer() -> None:
    rig = gpib_rig()
    bus = PrologixBus(rig.stream)
    bus.send(22, b"END ALWAYS")
    rig.faults.reads = {rig.faults.taken: faults.drop}
    assert bus.ask(22, b"NPLC?", hp3458a.parse_number, idempotent=True) == 10.0
    assert bus.counts.repeated == 1


def test_a_lost_address_is_sent_again_after_the_failure() -> None:
    rig = gpib_rig()
    bus = PrologixBus(rig.stream)
    bus.send(22, b"END ALWAYS")
    rig.faults.writes = {rig.faults.written: faults.drop}
    bus.send(9, b"DON")  # lost, and with it the change of address
    with pytest.raises(DeviceNonsense):
        bus.ask(9, b"ID?", hp3488a.parse_identity, idempotent=True)
    assert bus.ask(9, b"ID?", hp3488a.parse_identity, idempotent=True) == "HP3488A"


def test_a_lost_address_is_sent_again_even_where_nothing_is_repeated() -> None:
    rig = gpib_rig()
    bus = PrologixBus(rig.stream)
    bus.send(22, b"END ALWAYS")
    rig.faults.writes = {rig.faults.written: faults.drop}
    bus.send(9, b"DON")
    with pytest.raises(DeviceNonsense):
        bus.ask(9, b"ID?", hp3488a.parse_identity, idempotent=False)
    assert bus.ask(9, b"ID?", hp3488a.parse_identity, idempotent=False) == "HP3488A"


@pytest.mark.parametrize("clone", [None, "AR488 GPIB controller, ver. 0.53.04, 13/04/2025"])
@pytest.mark.parametrize("saved", [FOREIGN, {"addr": 9}, {"eot_enable": 1}, {"auto": 1, "eos": 0, "addr": 22}])
def test_an_adapter_that_restarts_while_its_port_stays_open_is_set_again(
    saved: dict[str, int], clone: str | None
) -> None:
    # P-107, A-M: at power-up the saved settings are loaded, which are anybody's, and a Prologix saves every change.
    meter = gpib_rig().meter
    twin = PrologixTwin({22: meter}, clone_named=clone)
    script = FaultScript()
    bus = PrologixBus(MemoryStream(twin, virtual_clock(), "memory", script))
    bus.send(22, b"END ALWAYS;TARM HOLD")
    need = dict(twin.settings)
    twin.settings |= {"savecfg": 1, **saved}
    script.reads = {script.taken: faults.drop}  # what was on its way is lost
    for _ in range(2):
        with suppress(DeviceSilent, DeviceNonsense):
            identity(bus)
    assert identity(bus) == "HP3458A"
    assert twin.settings == need
    assert twin.eeprom_writes == 0


def test_a_doubled_sentinel_is_drained_before_the_next_question() -> None:
    rig = gpib_rig()
    bus = PrologixBus(rig.stream)
    bus.send(22, b"END ALWAYS")
    first = rig.faults.taken
    rig.faults.reads = {first: faults.stall(5.0), first + 1: faults.duplicate(0.05), first + 2: faults.delay(0.08)}
    with pytest.raises(DeviceSilent):
        bus.ask(22, b"NPLC?", hp3458a.parse_number, idempotent=False)
    rig.clock.sleep(2.0)
    assert bus.ask(22, b"NDIG?", hp3458a.parse_number, idempotent=False) == 7.0


def test_a_status_byte_is_fetched_without_talking() -> None:
    rig = gpib_rig()
    bus = PrologixBus(rig.stream)
    assert bus.serial_poll(22) & 16
    assert bus.serial_poll(9) & 16


def test_stale_bytes_of_four_kilobytes_are_drained_at_the_start() -> None:
    rig = gpib_rig()
    script = FaultScript(reads={0: faults.prepend(b" 1.000000000E+00\r\n" * 230)})
    rig.adapter.receive(b"++ver\n", 0.0)
    bus = PrologixBus(MemoryStream(rig.adapter, rig.clock, "memory", script))
    assert bus.serial_poll(22) & 16, "its questions and answers belong together again"
    assert bus.counts.stale_bytes > 4096
