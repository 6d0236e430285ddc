"""Laws of the chamber's driver: the scale is read, the setpoint read back, nonsense refused."""

import pytest
from table_bench import example_rig, virtual_clock

from rig.clock import VirtualClock
from rig.devices.watlow_f4 import WatlowF4, WatlowF4Settings, connect
from rig.errors import DeviceFault, DeviceNonsense, RequestRefused
from rig.link.faults import FaultScript, delay
from rig.link.memory import MemoryStream
from rig.twins.physics.world import World
from rig.twins.watlow_f4 import WatlowF4Twin


def _chamber(
    decimals: int = 1, faults: FaultScript | None = None, limits_degc: tuple[float, float] = (-100.0, 150.0)
) -> tuple[WatlowF4, World, VirtualClock]:
    world, clock = World(example_rig()), virtual_clock()
    twin = WatlowF4Twin("air", world, decimals=decimals)
    settings = WatlowF4Settings(driver="watlow-f4", port="twin", limits_degc=limits_degc)
    return connect("air", settings, MemoryStream(twin, clock, "chamber", faults)), world, clock


@pytest.mark.parametrize("decimals", [0, 1])
def test_the_scale_is_read_from_the_chamber(decimals: int) -> None:
    chamber, _, _ = _chamber(decimals)
    assert chamber.temperature_degc() == pytest.approx(20.0, abs=0.1)
    assert chamber.setpoint_degc() == 20.0
    assert chamber.identify() == f"Watlow F4 at unit 1, steps of {10.0**-decimals:g} degC"


def test_a_setpoint_below_zero_is_held_and_reached() -> None:
    chamber, world, clock = _chamber()
    chamber.hold(-20.5)
    assert chamber.setpoint_degc() == world.setpoint_degc("air") == -20.5
    clock.sleep(10_000.0)
    assert chamber.temperature_degc() == pytest.approx(-20.5, abs=0.11)


def test_a_setpoint_between_two_steps_is_refused_not_rounded() -> None:
    chamber, world, _ = _chamber(0)
    with pytest.raises(RequestRefused, match="multiples of 1 °C"):
        chamber.hold(20.5)
    assert world.setpoint_degc("air") == 20.0


def test_a_setpoint_that_the_chamber_does_not_take_is_told() -> None:
    chamber, _, _ = _chamber(limits_degc=(-100.0, 600.0))
    with pytest.raises(RequestRefused, match="the chamber allows -70 to 180 °C"):
        chamber.hold(500.0)


class DeafRoom:
    """Acknowledges every setpoint and keeps its own."""

    def read_temperature_degc(self, environment: str, now_s: float) -> float:
        return 20.0

    def setpoint_degc(self, environment: str) -> float:
        return 20.0

    def hold(self, environment: str, setpoint_degc: float, now_s: float) -> None:
        return None


def test_a_setpoint_that_does_not_read_back_is_a_fault() -> None:
    settings = WatlowF4Settings(driver="watlow-f4", port="twin")
    stream = MemoryStream(WatlowF4Twin("air", DeafRoom()), virtual_clock(), "chamber")
    with pytest.raises(DeviceFault, match="set point 25 °C was written twice and reads back 20 °C"):
        connect("air", settings, stream).hold(25.0)


def test_an_implausible_temperature_is_a_fault() -> None:
    chamber, world, clock = _chamber()
    chamber.identify()
    world.hold("air", 250.0, 0.0)
    clock.sleep(1e5)
    with pytest.raises(DeviceFault, match="process value 250 °C is not plausible"):
        chamber.temperature_degc()


def test_a_late_reply_is_not_taken_for_the_setpoint() -> None:
    script = FaultScript()
    chamber, world, clock = _chamber(faults=script)
    world.hold("air", 60.0, clock.monotonic_s())
    chamber.identify()
    script.reads = {script.taken: delay(1.5)}
    assert chamber.temperature_degc() < 25.0
    assert chamber.setpoint_degc() == 60.0


def test_a_setpoint_beyond_the_limits_of_the_rig_file_is_never_sent() -> None:
    chamber, world, _ = _chamber(limits_degc=(10.0, 40.0))
    for degc in (41.0, 9.0, float("nan")):
        with pytest.raises(RequestRefused, match=f"air: setpoint {degc:g} °C, allowed 10 to 40 °C"):
            chamber.hold(degc)
    assert world.setpoint_degc("air") == 20.0


def test_a_set_point_that_somebody_wrote_while_we_hold_is_a_fault_and_stays() -> None:
    chamber, world, clock = _chamber()
    chamber.hold(40.0)
    chamber.temperature_degc()
    world.hold("air", 85.0, clock.monotonic_s())
    found = r"calrig set it to 40 °C, and now the set point is 85 °C \(register 300\): somebody set it since"
    for work in (chamber.temperature_degc, lambda: chamber.hold(30.0)):
        with pytest.raises(DeviceFault, match=found):
            work()
    assert world.setpoint_degc("air") == 85.0


class Freezing:
    """At 0 °C, wherever it is sent."""

    def read_temperature_degc(self, environment: str, now_s: float) -> float:
        return 0.0

    def setpoint_degc(self, environment: str) -> float:
        return 0.0

    def hold(self, environment: str, setpoint_degc: float, now_s: float) -> None:
        return None


@pytest.mark.parametrize(("sensor", "words"), [(4, "input 1 is off"), (7, "input 1 is of no known sensor")])
def test_an_input_without_a_temperature_is_refused_and_its_zero_is_no_temperature(sensor: int, words: str) -> None:
    # Communications guide p. 17: "A read command sent to an inactive parameter returns 0x0000." 600: 4 is off.
    twin, settings = WatlowF4Twin("air", Freezing()), WatlowF4Settings(driver="watlow-f4", port="twin")
    chamber = connect("air", settings, MemoryStream(twin, virtual_clock(), "chamber"))
    assert chamber.temperature_degc() == 0.0  # a sensor that is on, at 0 °C
    twin.sensor = sensor
    with pytest.raises(DeviceFault, match=words):
        chamber.temperature_degc()
    anew = connect("air", settings, MemoryStream(twin, virtual_clock(), "chamber"))
    for ask in (anew.identify, anew.temperature_degc, lambda: anew.hold(0.0)):
        with pytest.raises(DeviceNonsense, match=words):
            ask()
