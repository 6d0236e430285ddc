"""What every axis promises, on every line: in memory, over TCP and over a pseudo-terminal."""

from collections.abc import Iterator

import pytest
from table_bench import example_rig, virtual_clock

from rig.clock import Clock, ScaledClock, SystemClock
from rig.devices.abilities import Axis
from rig.devices.indexing_table import IndexingTableSettings, connect
from rig.errors import RequestRefused
from rig.link.memory import MemoryStream
from rig.link.ports import open_stream
from rig.motion import home_and_arrive, move_and_arrive, stop_all
from rig.twins.indexing_table import IndexingTableTwin
from rig.twins.servers import serve_pty, serve_tcp
from rig.twins.world import World
from rig.wire.indexing_table import TableCodec
from rig.wire.table_dialect import load_dialect

FACTOR = 200.0


@pytest.fixture(params=["memory", "tcp", "pty"])
def bench(request: pytest.FixtureRequest) -> Iterator[tuple[dict[str, Axis], Clock]]:
    rig = example_rig()
    settings = {name: axis for name, axis in rig.axes.items() if isinstance(axis, IndexingTableSettings)}
    twin = IndexingTableTwin(TableCodec(load_dialect(None, 1.0)), {1: "pitch", 2: "roll"}, World(rig))
    if request.param == "memory":
        clock: Clock = virtual_clock()
        yield dict(connect(settings, MemoryStream(twin, clock, "memory"))), clock
        return
    clock = ScaledClock(FACTOR)
    with (serve_tcp if request.param == "tcp" else serve_pty)(twin, clock) as server:
        stream = open_stream(server.address, clock=SystemClock())
        yield dict(connect(settings, stream)), clock
        stream.close()


def test_an_axis_keeps_its_promises(bench: tuple[dict[str, Axis], Clock]) -> None:
    axes, clock = bench
    pitch, roll = axes["pitch"], axes["roll"]
    assert pitch.identify() != roll.identify()
    assert not pitch.state().is_homed
    with pytest.raises(RequestRefused, match="not homed"):
        pitch.start_move(10.0)
    for axis in axes.values():
        assert home_and_arrive(axis, clock, clock.sleep) == 0.0
    assert move_and_arrive(pitch, -30.0, clock, clock.sleep) == -30.0
    assert (pitch.state().position_deg, roll.state().position_deg) == (-30.0, 0.0)
    pitch.stop()  # harmless at rest
    assert pitch.state().is_seated
    for wrong_deg in (181.0, 0.5, float("nan")):
        with pytest.raises(RequestRefused):
            pitch.check_target(wrong_deg)
    roll.start_move(170.0)
    stop_all(axes, clock)
    state = roll.state()
    assert not state.is_moving
    assert state.position_deg < 170.0
