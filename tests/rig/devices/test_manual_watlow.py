"""Facts of the Watlow controllers by their pages, put to driver and twin: docs/devices/watlow-f4.md, watlow-f4t.md."""

import pytest
from table_bench import example_rig, virtual_clock

from rig.devices.watlow_f4 import WatlowF4, WatlowF4Settings
from rig.devices.watlow_f4 import connect as connect_f4
from rig.devices.watlow_f4t import WatlowF4T, WatlowF4TSettings
from rig.devices.watlow_f4t import connect as connect_f4t
from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, RequestRefused, RigError
from rig.link.memory import MemoryStream
from rig.twins.modbus_slave import ModbusSlave
from rig.twins.physics.world import World
from rig.twins.watlow_f4 import WatlowF4Twin
from rig.twins.watlow_f4t import WatlowF4TTwin


class Room:
    """An environment that is at once where it is held."""

    def __init__(self, degc: float = 25.0) -> None:
        self.degc = degc

    def read_temperature_degc(self, environment: str, now_s: float) -> float:
        return self.degc

    def setpoint_degc(self, environment: str) -> float:
        return self.degc

    def hold(self, environment: str, setpoint_degc: float, now_s: float) -> None:
        self.degc = setpoint_degc


def _f4(twin: WatlowF4Twin, **settings: object) -> WatlowF4:
    described = WatlowF4Settings.model_validate({"driver": "watlow-f4", "port": "twin"} | settings)
    return connect_f4("air", described, MemoryStream(twin, virtual_clock(), "chamber"))


def _f4t(transport: str, expected: dict[str, object], **settings: object) -> WatlowF4T:
    fields = {"driver": "watlow-f4t", "port": "twin", "transport": transport}
    described = WatlowF4TSettings.model_validate(fields | settings)
    twin = WatlowF4TTwin("air", World(example_rig()), **expected)  # type: ignore[arg-type]
    slave = ModbusSlave(twin, framing=described.transport)
    return connect_f4t("air", described, MemoryStream(slave, virtual_clock(), "chamber"))


# The frames of docs/devices/watlow-f4.md, section "Frames".
FRAMES = {
    "model": ("01 03 00 00 00 01 84 0A", "01 03 02 14 96 37 2A"),
    "input 1": ("01 03 00 64 00 01 C5 D5", "01 03 02 00 FA 38 07"),
    "decimals": ("01 03 02 5E 00 01 E4 60", "01 03 02 00 01 79 84"),
    "kind": ("01 03 02 60 00 01 85 AC", "01 03 02 00 00 B8 44"),
    "unit": ("01 03 03 85 00 01 95 A7", "01 03 02 00 01 79 84"),
    "no profile": ("01 03 00 C8 00 01 05 F4", "01 03 02 00 00 B8 44"),
    "set point 25": ("01 06 01 2C 00 FA C9 BC", "01 06 01 2C 00 FA C9 BC"),
    "terminate": ("01 06 04 C1 00 01 18 C6", "01 06 04 C1 00 01 18 C6"),
    "no such register": ("01 03 7F FF 00 01 AD EE", "01 83 02 C0 F1"),
}


@pytest.mark.parametrize(("question", "answered"), FRAMES.values(), ids=list(FRAMES))
def test_frames_of_the_f4(question: str, answered: str) -> None:
    twin = WatlowF4Twin("air", Room())
    twin.receive(bytes.fromhex(question), 0.0)
    assert twin.transmit(0.0) == bytes.fromhex(answered)


def test_frames_of_an_f4_in_fahrenheit() -> None:
    # "901 = 0, 606 = 1: raw 770 is 77.0 °F = 25.0 °C. Writing raw 250 there means 25.0 °F = −3.9 °C." (computed)
    room = Room()
    twin = WatlowF4Twin("air", room, fahrenheit=True)
    for answer, answered in (
        ("01 03 00 64 00 01 C5 D5", "01 03 02 03 02 39 75"),
        ("01 03 03 85 00 01 95 A7", "01 03 02 00 00 B8 44"),
        ("01 06 01 2C 00 FA C9 BC", "01 06 01 2C 00 FA C9 BC"),
    ):
        twin.receive(bytes.fromhex(answer), 0.0)
        assert twin.transmit(0.0) == bytes.fromhex(answered)
    assert room.degc == pytest.approx(-3.9, abs=0.02)


@pytest.mark.parametrize("decimals", [0, 1, 2, 3])
@pytest.mark.parametrize("fahrenheit", [False, True])
def test_the_f4_is_read_and_set_in_its_own_unit_and_decimals(decimals: int, fahrenheit: bool) -> None:
    # "Value = raw / 10ⁿ, n = register 606"; 901: 0 °F, 1 °C.
    room, limits_degc = Room(-5.0), {2: (-70.0, 100.0), 3: (-12.0, 0.0)}.get(decimals, (-70.0, 180.0))
    chamber = _f4(WatlowF4Twin("air", room, decimals=decimals, fahrenheit=fahrenheit, limits_degc=limits_degc))
    assert chamber.temperature_degc() == pytest.approx(room.degc, abs=1e-9)
    chamber.hold(-10.0)
    assert room.degc == pytest.approx(-10.0, abs=1e-9)
    assert chamber.setpoint_degc() == pytest.approx(-10.0, abs=1e-9)
    assert ("degF" in chamber.identify()) is fahrenheit


def test_an_f4_in_another_unit_than_the_file_says_is_refused_both_ways() -> None:
    for fahrenheit, values in ((True, "degc"), (False, "degf")):
        room = Room()
        chamber = _f4(WatlowF4Twin("air", room, fahrenheit=fahrenheit), values=values)
        for ask in (chamber.identify, chamber.temperature_degc, lambda expected=chamber: expected.hold(30.0)):  # type: ignore[misc]
            with pytest.raises(DeviceNonsense, match=r"register 901.*environment\.air: values"):
                ask()
        assert room.degc == 25.0


def test_a_unit_that_changes_during_the_run_is_found_before_the_next_temperature() -> None:
    twin = WatlowF4Twin("air", Room())
    chamber = _f4(twin)
    assert chamber.temperature_degc() == 25.0
    twin.is_fahrenheit = True
    with pytest.raises(DeviceFault, match=r"register 901 .* was 1 and reads 0"):
        chamber.temperature_degc()
    with pytest.raises(RigError):
        chamber.hold(20.0)


def test_what_is_no_f4_is_not_read_as_one() -> None:
    # "901 = 0 means °F, 606 = 0 means no decimals, and both could mean "inactive" or "another controller". Take them
    # only after register 0 says F4." WCG p. 17: "A read command sent to an inactive parameter returns 0x0000."
    with pytest.raises(DeviceNonsense, match=r"register 0 .* reads 0, a Series F4 says 5270"):
        _f4(WatlowF4Twin("air", Room(), model=0)).temperature_degc()


@pytest.mark.parametrize("state", [2, 3])
def test_a_profile_that_runs_or_is_held_is_not_given_a_set_point(state: int) -> None:
    # "200: 0, 1 no profile; 2 runs; 3 held"; 300 "a running profile is not changed by it and goes on with its own".
    room = Room()
    twin = WatlowF4Twin("air", room, profile=state)
    chamber = _f4(twin)
    assert chamber.temperature_degc() == 25.0
    with pytest.raises(DeviceRefused, match=r"a profile .*nothing was changed; end it at the front panel"):
        chamber.hold(30.0)
    assert room.degc == 25.0


def test_a_profile_that_starts_after_a_set_point_is_a_fault() -> None:
    twin = WatlowF4Twin("air", Room())
    chamber = _f4(twin)
    chamber.hold(30.0)
    twin.profile = 2
    with pytest.raises(DeviceFault, match="a profile runs"):
        chamber.temperature_degc()


def test_a_set_point_outside_the_controllers_own_limits_is_not_written() -> None:
    # "some Espec chambers use a set point below the range as "loop off"": 602, 603 are read first.
    room = Room()
    with pytest.raises(RequestRefused, match="the chamber allows -20 to 60 °C"):
        _f4(WatlowF4Twin("air", room, limits_degc=(-20.0, 60.0))).hold(-30.0)
    assert room.degc == 25.0


@pytest.mark.parametrize("transport", ["tcp", "rtu"])
@pytest.mark.parametrize("fahrenheit", [False, True])
def test_the_f4t_is_read_in_the_unit_of_its_channel(transport: str, fahrenheit: bool) -> None:
    # "each communications channel has its own unit"; "register 14080 (RTU channel), 6730 (Ethernet channel)".
    chamber = _f4t(transport, {"fahrenheit": fahrenheit})
    assert chamber.temperature_degc() == pytest.approx(20.0, abs=0.1)
    chamber.hold(60.0)
    assert chamber.setpoint_degc() == pytest.approx(60.0, abs=1e-5)
    assert ("degF" in chamber.identify()) is fahrenheit


@pytest.mark.parametrize("transport", ["tcp", "rtu"])
def test_an_f4t_in_another_unit_than_the_file_says_is_refused_both_ways(transport: str) -> None:
    for fahrenheit, values in ((True, "degc"), (False, "degf")):
        with pytest.raises(DeviceNonsense, match=r"environment\.air: values"):
            _f4t(transport, {"fahrenheit": fahrenheit}, values=values).identify()


@pytest.mark.parametrize("transport", ["tcp", "rtu"])
def test_an_f4t_that_does_not_tell_its_unit_needs_it_in_the_file(transport: str) -> None:
    # 14080 and 6730 are in the chamber maker's library only, so a firmware may lack them.
    with pytest.raises(DeviceNonsense, match=r"does not tell .* unit .*values = "):
        _f4t(transport, {"tells_unit": False}).identify()
    text = _f4t(transport, {"tells_unit": False, "fahrenheit": True}, values="degf")
    assert text.temperature_degc() == pytest.approx(20.0, abs=0.1)


@pytest.mark.parametrize("state", [149, 146, 1783])
def test_a_profile_of_an_f4t_is_not_given_a_set_point(state: int) -> None:
    # 16568: "149 runs, 146 held, 1783 waits for its start time".
    with pytest.raises(DeviceRefused, match=r"a profile .*nothing was changed; end it at the front panel"):
        _f4t("tcp", {"profile": state}).hold(30.0)


F4T_FRAMES = {
    "unit of the RTU channel": ("01 03 37 00 00 01 8A 7E", "01 03 02 00 0F F8 40"),
    "unit of the Ethernet channel": ("01 03 1A 4A 00 01 A2 C4", "01 03 02 00 0F F8 40"),
    "mode": ("01 03 0A FE 00 01 E6 22", "01 03 02 00 0A 38 43"),
}


@pytest.mark.parametrize(("question", "answered"), F4T_FRAMES.values(), ids=list(F4T_FRAMES))
def test_frames_of_the_f4t(question: str, answered: str) -> None:
    slave = ModbusSlave(WatlowF4TTwin("air", Room()))
    slave.receive(bytes.fromhex(question), 0.0)
    assert slave.transmit(0.0) == bytes.fromhex(answered)
