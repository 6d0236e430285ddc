"""Every published dialect moves its twin: homed where it has a home, to an angle, at rest, stopped where it can."""

import pytest
from table_bench import example_rig, virtual_clock

from rig.devices.indexing_table import IndexingTableSettings, connect
from rig.errors import DeviceRefused
from rig.link.memory import MemoryStream
from rig.twins.indexing_table import IndexingTableTwin
from rig.twins.world import World
from rig.wire.indexing_table import TableCodec
from rig.wire.table_dialect import load_dialect, published_dialects


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
    if dialect.home is None:
        twin.axes[1].home(0.0)  # an absolute machine has its home from the factory
        clock.sleep(60.0)
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
