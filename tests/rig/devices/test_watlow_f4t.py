"""Laws of the F4T's driver: the word order is verified, the set point and the mode are read back."""

from collections.abc import Sequence

import pytest
from table_bench import example_rig, virtual_clock

from rig.clock import VirtualClock
from rig.devices.watlow_f4t import WatlowF4T, WatlowF4TSettings, connect
from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, DeviceSilent, RequestRefused
from rig.link.faults import FaultScript, delay, drop, stall
from rig.link.memory import MemoryStream
from rig.twins.modbus_slave import ModbusSlave
from rig.twins.physics.world import World
from rig.twins.watlow_f4t import AUTO, MANUAL, OFF, WatlowF4TTwin


class Scene:
    """A chamber of the example rig with its twin; ``twin`` and ``settings`` say what each side believes."""

    def __init__(
        self, twin: dict[str, object] | None = None, kind: type[WatlowF4TTwin] = WatlowF4TTwin, **settings: object
    ) -> None:
        self.world, self.clock = World(example_rig()), virtual_clock()
        self.faults = FaultScript()
        self.registers = kind("air", self.world, **(twin or {}))  # type: ignore[arg-type]
        fields: dict[str, object] = {"driver": "watlow-f4t", "port": "twin", "limits_degc": (-1000.0, 1000.0)}
        self.settings = WatlowF4TSettings.model_validate(fields | settings)
        self.slave = ModbusSlave(self.registers, framing=self.settings.transport)
        stream = MemoryStream(self.slave, self.clock, "chamber", self.faults)
        self.chamber: WatlowF4T = connect("air", self.settings, stream)


@pytest.fixture(params=["tcp", "rtu"])
def scene(request: pytest.FixtureRequest) -> Scene:
    return Scene(transport=request.param)


def test_it_tells_who_and_what_it_allows(scene: Scene) -> None:
    assert scene.chamber.identify() == "Watlow F4T at unit 1, loop 1, set points from -70 to 180 degC, low-first"


def test_a_set_point_is_held_and_reached(scene: Scene) -> None:
    scene.chamber.hold(-20.5)
    assert scene.chamber.setpoint_degc() == scene.world.setpoint_degc("air") == -20.5
    scene.clock.sleep(10_000.0)
    assert scene.chamber.temperature_degc() == pytest.approx(-20.5, abs=0.11)


def test_a_set_point_outside_the_chambers_own_limits_is_refused(scene: Scene) -> None:
    with pytest.raises(RequestRefused, match="the chamber allows -70 to 180 °C"):
        scene.chamber.hold(180.1)
    with pytest.raises(RequestRefused, match="limits_degc"):
        scene.chamber.hold(float("nan"))
    assert scene.world.setpoint_degc("air") == 20.0


@pytest.mark.parametrize(("expected", "true"), [("low-first", "high-first"), ("high-first", "low-first")])
def test_fault_34_the_wrong_word_order_is_refused_and_the_right_one_named(expected: str, true: str) -> None:
    """Detected: a register of known value, read in all word orders.
    Response: refused before anything is believed; the right order is named.
    """
    scene = Scene({"word_order": true}, word_order=expected)
    for ask in (scene.chamber.identify, scene.chamber.temperature_degc, lambda: scene.chamber.hold(20.0)):
        with pytest.raises(DeviceNonsense, match=rf"set word_order = '{true}' \(environment\.air\)"):
            ask()
    assert scene.world.setpoint_degc("air") == 20.0
    assert Scene({"word_order": true}, word_order=true).chamber.setpoint_degc() == 20.0


def test_numbers_in_fahrenheit_are_a_setting() -> None:
    scene = Scene({"fahrenheit": True}, values="degf")
    scene.chamber.hold(60.0)
    assert scene.world.setpoint_degc("air") == pytest.approx(60.0, abs=1e-5)
    assert scene.chamber.setpoint_degc() == pytest.approx(60.0, abs=1e-5)


def test_a_loop_that_is_off_is_switched_on_and_one_in_manual_is_left_alone() -> None:
    scene = Scene({"mode": OFF})
    scene.chamber.hold(40.0)
    assert scene.registers.mode == AUTO
    scene = Scene({"mode": MANUAL})
    with pytest.raises(DeviceRefused, match="in mode manual, need automatic or off; nothing was changed"):
        scene.chamber.hold(40.0)
    assert scene.world.setpoint_degc("air") == 20.0


@pytest.mark.parametrize(("code", "words"), [(6, "busy"), (5, "still busy"), (3, "illegal value")])
@pytest.mark.parametrize("transport", ["tcp", "rtu"])
def test_a_controller_that_is_busy_is_not_one_without_the_register(transport: str, code: int, words: str) -> None:
    # Exception 2 alone says "illegal data address" (MODBUS Application Protocol V1.1b3, section 7); 6 is "busy".
    running = Scene({"profile": 149}, transport=transport)
    running.slave.refusals = {16568: code}
    with pytest.raises(DeviceRefused, match=rf"exception {code} \(.*{words}\) .*register 16568"):
        running.chamber.hold(40.0)
    in_fahrenheit = Scene({"fahrenheit": True}, transport=transport, values="degc")
    in_fahrenheit.slave.refusals = {6730: code, 14080: code}
    with pytest.raises(DeviceRefused, match=rf"exception {code} \(.*{words}\)"):
        in_fahrenheit.chamber.hold(40.0)
    assert running.world.setpoint_degc("air") == in_fahrenheit.world.setpoint_degc("air") == 20.0


def test_a_controller_that_is_busy_for_a_moment_is_asked_again() -> None:
    scene = Scene({"profile": 149}, kind=BusyTwice)
    assert isinstance(scene.registers, BusyTwice)
    scene.registers.slave = scene.slave
    scene.slave.refusals = {16568: 6}
    with pytest.raises(DeviceRefused, match="a profile runs"):
        scene.chamber.hold(40.0)


BY_HAND = [
    ({"mode": OFF}, r"loop 1 is in mode off \(register 2814\)"),
    ({"mode": MANUAL}, r"loop 1 is in mode manual \(register 2814\)"),
    ({"setpoint_degc": 21.0}, r"the set point is 21 °C \(register 2782\)"),
    ({"mode": OFF, "setpoint_degc": 21.0}, r"mode off \(register 2814\) and the set point is 21 °C \(register 2782\)"),
]


@pytest.mark.parametrize(("by_hand", "found"), BY_HAND)
def test_what_somebody_sets_while_we_hold_is_a_fault_and_stays(
    scene: Scene, by_hand: dict[str, float], found: str
) -> None:
    scene.chamber.hold(40.0)
    scene.chamber.temperature_degc()
    scene.registers.set_at_panel(scene.clock.monotonic_s(), **by_hand)  # type: ignore[arg-type]
    mode, setpoint_degc = scene.registers.mode, scene.chamber.setpoint_degc()
    for work in (scene.chamber.temperature_degc, lambda: scene.chamber.hold(30.0), lambda: scene.chamber.hold(40.0)):
        with pytest.raises(DeviceFault, match=rf"calrig set it to 40 °C, and now .*{found}: somebody set it since"):
            work()
    assert (scene.registers.mode, scene.chamber.setpoint_degc()) == (mode, setpoint_degc)


def test_a_set_point_that_a_person_asks_for_by_hand_is_written_over_what_somebody_set() -> None:
    scene = Scene()
    scene.chamber.hold(40.0)
    scene.registers.set_at_panel(scene.clock.monotonic_s(), mode=OFF)
    scene.chamber.setpoint_memory.overrule()
    scene.chamber.hold(30.0)
    assert (scene.registers.mode, scene.world.setpoint_degc("air")) == (AUTO, 30.0)
    scene.registers.set_at_panel(scene.clock.monotonic_s(), mode=OFF)
    with pytest.raises(DeviceFault, match="mode off"):  # asked for once, not for ever
        scene.chamber.hold(30.0)


def test_a_set_point_whose_acknowledgement_was_lost_is_still_ours() -> None:
    scene = Scene()
    scene.chamber.hold(40.0)
    written = scene.faults.taken
    # Unit, profile, mode, set point, mode, set point; then the write, asked three times.
    scene.faults.reads = dict.fromkeys(range(written + 6, written + 9), drop)
    with pytest.raises(DeviceSilent):
        scene.chamber.hold(30.0)
    assert scene.world.setpoint_degc("air") == 30.0
    scene.chamber.temperature_degc()
    scene.chamber.hold(35.0)
    assert scene.world.setpoint_degc("air") == 35.0


def test_a_loop_that_is_off_neither_heats_nor_cools() -> None:
    scene = Scene()
    scene.chamber.hold(80.0)
    scene.clock.sleep(60.0)
    scene.registers.set_at_panel(scene.clock.monotonic_s(), mode=OFF)
    before_degc = scene.world.read_temperature_degc("air", scene.clock.monotonic_s())
    scene.clock.sleep(1e4)
    assert scene.world.read_temperature_degc("air", scene.clock.monotonic_s()) == pytest.approx(before_degc, abs=0.1)


def test_a_firmware_without_the_register_of_profiles_is_set_all_the_same(scene: Scene) -> None:
    scene.slave.refusals = {16568: 2}
    scene.chamber.hold(40.0)
    assert scene.world.setpoint_degc("air") == 40.0


def test_another_loop_is_other_registers() -> None:
    scene = Scene({"loop": 2}, loop=2)
    scene.chamber.hold(33.0)
    assert scene.world.setpoint_degc("air") == 33.0
    with pytest.raises(DeviceRefused, match="illegal register address"):
        Scene({"loop": 2}, loop=1).chamber.identify()


def test_an_implausible_temperature_is_a_fault(scene: Scene) -> None:
    scene.chamber.identify()
    scene.world.hold("air", 400.0, 0.0)
    scene.clock.sleep(1e5)
    with pytest.raises(DeviceFault, match=r"process value 400\S* °C is not plausible"):
        scene.chamber.temperature_degc()


@pytest.mark.parametrize("fault", [delay(1.5), stall(1.3), stall(2.4)])
@pytest.mark.parametrize("transport", ["tcp", "rtu"])
def test_a_late_reply_is_not_taken_for_the_set_point(transport: str, fault: object) -> None:
    scene = Scene(transport=transport)
    scene.world.hold("air", 60.0, scene.clock.monotonic_s())
    scene.chamber.identify()
    scene.faults.reads = {scene.faults.taken: fault}  # type: ignore[dict-item]
    assert scene.chamber.temperature_degc() < 25.0
    assert scene.chamber.setpoint_degc() == 60.0


def test_the_clock_is_the_lines(scene: Scene) -> None:
    assert isinstance(scene.clock, VirtualClock)
    before_s = scene.clock.monotonic_s()
    scene.chamber.temperature_degc()
    assert scene.clock.monotonic_s() - before_s < 2.0


class BusyTwice(WatlowF4TTwin):
    """Is no longer busy when it is asked for the third time."""

    slave: ModbusSlave
    asked = 0

    def read(self, address: int, count: int, now_s: float) -> Sequence[int] | None:
        self.asked += address == 16568
        if self.asked == 3:
            self.slave.refusals = {}
        return super().read(address, count, now_s)


class Unmoved(WatlowF4TTwin):
    """Acknowledges every write and does nothing."""

    def write(self, address: int, values: Sequence[int], now_s: float) -> int:
        return 0


class KeepsItsMode(WatlowF4TTwin):
    """Takes set points, and acknowledges a mode that it does not take."""

    def write(self, address: int, values: Sequence[int], now_s: float) -> int:
        return 0 if len(values) == 1 else super().write(address, values, now_s)


def test_what_was_acknowledged_and_not_done_is_a_fault() -> None:
    with pytest.raises(DeviceFault, match="set point 40 °C was written twice and reads back 20 °C, and calrig could"):
        Scene(kind=Unmoved).chamber.hold(40.0)
    with pytest.raises(DeviceFault, match="automatic control was acknowledged, but the mode reads off"):
        Scene({"mode": OFF}, kind=KeepsItsMode).chamber.hold(40.0)


def test_by_rtu_a_reply_that_comes_when_all_is_given_up_is_not_the_set_point() -> None:
    scene = Scene(transport="rtu")
    scene.world.hold("air", 60.0, scene.clock.monotonic_s())
    scene.chamber.identify()
    first = scene.faults.taken
    # The process value is answered after 3.8 s; what is asked meanwhile is lost.
    scene.faults.reads = {first: stall(3.8)} | dict.fromkeys(range(first + 1, first + 4), drop)
    with pytest.raises(DeviceSilent):
        scene.chamber.temperature_degc()
    assert scene.chamber.setpoint_degc() == 60.0
