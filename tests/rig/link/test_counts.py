"""Laws of the counts: every line and every device on it has its own, and a silent one does not hide behind others."""

import pytest
from motion_bench import DRIVERS, settings_of, twin_of, world_of
from table_bench import virtual_clock

from rig.errors import DeviceSilent
from rig.link.counts import CountedStream
from rig.link.memory import MemoryStream


@pytest.mark.parametrize(
    ("driver", "names"), [("oriental-az", ("unit 1", "unit 2")), ("zaber", ("device 1", "device 2"))]
)
def test_fault_35_a_mute_device_keeps_no_other_from_answering_and_is_counted_alone(
    driver: str, names: tuple[str, str]
) -> None:
    axes = settings_of(driver)
    world = world_of(axes)
    twin, clock = twin_of(driver, axes, world), virtual_clock()
    line = CountedStream(MemoryStream(twin, clock, "line"))
    made = DRIVERS[driver].connect(axes, line)
    for axis in made.values():
        axis.identify()
    del (twin.units if driver == "oriental-az" else twin.stages)[2]
    if driver == "oriental-az":
        del twin.slaves[2]
    for _ in range(3):
        assert made["pitch"].state().fault == ""
        with pytest.raises(DeviceSilent):
            made["roll"].state()
    counts = line.by_slave("axes.pitch")
    assert set(counts) == {f"axes.pitch, {name}" for name in names}
    first, second = (counts[f"axes.pitch, {name}"] for name in names)
    assert (first.errors, second.errors) == (0, 9)  # three questions, each asked three times
    assert first.questions >= 3


@pytest.mark.parametrize("driver", ["oriental-az", "zaber", "esp301"])
def test_a_device_alone_on_its_line_is_the_line(driver: str) -> None:
    axes = settings_of(driver)
    line = CountedStream(MemoryStream(twin_of(driver, axes, world_of(axes)), virtual_clock(), "line"))
    DRIVERS[driver].connect({"pitch": axes["pitch"]}, line)["pitch"].identify()
    ((name, counts),) = line.by_slave("axes.pitch").items()
    assert name == "axes.pitch"
    assert counts.questions >= 1
