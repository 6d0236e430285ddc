"""Every published dialect moves its twin: homed where it has a home, to an angle, at rest, stopped where it can."""

import pytest
from table_bench import example_rig, virtual_clock

from rig.devices.indexing_table import IndexingTableAxis, IndexingTableSettings, connect
from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, RigError
from rig.link.faults import Part
from rig.link.memory import MemoryStream
from rig.motion.move import home_and_arrive, move_and_arrive
from rig.twins.indexing_table import IndexingTableTwin, TableAxis, TableTimes
from rig.twins.physics.world import World
from rig.wire.indexing_table import Home, Move, TableCodec
from rig.wire.table_dialect import load_dialect, published_dialects


class _ToTheOther:
    """The number of the axis becomes the other's on its way."""

    def on_write(self, data: bytes) -> tuple[Part, ...]:
        return (Part(data.replace(b"1HD", b"2HD")),)

    def on_read(self, data: bytes) -> tuple[Part, ...]:
        return (Part(data),)


def test_a_home_that_another_axis_acknowledged_is_no_home() -> None:
    """The McLennan says "OK" and not which axis took it."""
    axis, twin, world, stream = _head("mclennan-pm304")
    twin.axes[2] = TableAxis(world.axes["roll"], world, (-360.0, 360.0), TableTimes())
    stream._faults = _ToTheOther()  # type: ignore[assignment]
    with pytest.raises(DeviceFault, match="home: it was sent, but the axis does not begin"):
        home_and_arrive(axis, stream.clock, stream.clock.sleep)
    assert twin.axes[2].is_moving(stream.clock.monotonic_s())


def _head(name: str) -> tuple[IndexingTableAxis, IndexingTableTwin, World, MemoryStream]:
    """Return a head of this dialect, homed."""
    world, clock, dialect = World(example_rig()), virtual_clock(), load_dialect(name, 1.0)
    twin = IndexingTableTwin(TableCodec(dialect), {1: "pitch"}, world)
    settings = IndexingTableSettings(
        driver="indexing-table",
        port="twin",
        limits_deg=(-180.0, 180.0),
        speed_dps=5.0,
        increment_deg=dialect.increment_deg,
        dialect=name,
    )
    stream = MemoryStream(twin, clock, name)
    axis = connect({"pitch": settings}, stream)["pitch"]
    home_and_arrive(axis, clock, clock.sleep)
    return axis, twin, world, stream


class _Swallows:
    """Commands that turn the head are lost on their way, from now on."""

    def __init__(self, codec: TableCodec) -> None:
        self._codec = codec
        self.swallowed = 0

    def on_write(self, data: bytes) -> tuple[Part, ...]:
        command = self._codec.decode_command(data.removesuffix(self._codec.terminator))
        if isinstance(command, Home | Move):
            self.swallowed += 1
            return ()
        return (Part(data),)

    def on_read(self, data: bytes) -> tuple[Part, ...]:
        return (Part(data),)


@pytest.mark.parametrize("name", [name for name in published_dialects() if load_dialect(name, 1.0).home is not None])
def test_a_home_that_is_lost_on_the_line_is_no_home(name: str) -> None:
    axis, _twin, world, stream = _head(name)
    clock = stream.clock
    move_and_arrive(axis, 36.0, clock, clock.sleep)
    line = stream._faults = _Swallows(TableCodec(load_dialect(name, 1.0)))  # type: ignore[assignment]
    with pytest.raises(RigError):
        home_and_arrive(axis, clock, clock.sleep)
    assert line.swallowed == 1
    assert world.axes["pitch"].table_deg(clock.monotonic_s()) == pytest.approx(36.0)


@pytest.mark.parametrize("name", published_dialects())
def test_a_head_of_this_dialect_is_homed_moved_and_found_at_rest(name: str) -> None:
    world, clock, dialect = World(example_rig()), virtual_clock(), load_dialect(name, 1.0)
    twin = IndexingTableTwin(TableCodec(dialect), {1: "pitch"}, world)
    settings = IndexingTableSettings(
        driver="indexing-table",
        port="twin",
        limits_deg=(-180.0, 180.0),
        speed_dps=5.0,
        increment_deg=dialect.increment_deg,
        dialect=name,
    )
    axis = connect({"pitch": settings}, MemoryStream(twin, clock, name))["pitch"]
    axis.identify()
    axis.home()
    clock.sleep(120.0)
    assert axis.state().is_homed
    target_deg = 90.0
    axis.start_move(target_deg)
    clock.sleep(2.0)
    assert axis.state().is_moving
    clock.sleep(120.0)
    state = axis.state()
    assert (state.is_moving, state.fault) == (False, "")
    assert state.position_deg == pytest.approx(target_deg, abs=dialect.increment_deg / 2)
    if dialect.stop is None:
        with pytest.raises(DeviceRefused, match="has no stop"):
            axis.stop()
        assert any("cannot be stopped" in remark for remark in settings.remarks())
    else:
        axis.stop()
    told = any("where it was sent, not where it stands" in remark for remark in settings.remarks())
    assert told is (name in {"parker-6k", "newmark-nsc-a1"})  # TPC and PX count the pulses of the motor


class _Prefixed:
    """Every reply with "1:" before it, as the MX driver of the PM304 requires and ISIS' emulator sends."""

    def on_write(self, data: bytes) -> tuple[Part, ...]:
        return (Part(data),)

    def on_read(self, data: bytes) -> tuple[Part, ...]:
        return (Part(b"1:" + data),)


def test_a_mclennan_that_puts_its_number_before_each_reply_is_refused_when_it_is_asked_who_it_is() -> None:
    axis, _twin, _world, stream = _head("mclennan-pm304")
    stream._faults = _Prefixed()  # type: ignore[assignment]
    with pytest.raises(
        DeviceNonsense, match=r"1:Mclennan Servo Supplies Ltd\..*not a line of the dialect mclennan-pm304"
    ):
        axis.identify()


def test_the_line_is_that_of_the_dialect() -> None:
    settings = IndexingTableSettings(
        driver="indexing-table",
        port="/dev/ttyS9",
        limits_deg=(-1, 1),
        speed_dps=1,
        increment_deg=1,
        dialect="mclennan-pm304",
    )
    assert (settings.baud_rate, settings.parity, settings.data_bits, settings.stop_bits) == (9600, "E", 7, 1)
