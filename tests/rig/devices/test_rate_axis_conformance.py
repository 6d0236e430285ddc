"""What every axis that turns promises, by every driver and on every line: in memory, over TCP and over a pty."""

from collections.abc import Iterator
from typing import Any

import pytest
from motion_bench import DRIVERS, motion_bench, settings_of, twin_of, world_of
from table_bench import virtual_clock

from rig.clock import Clock, ScaledClock, SystemClock
from rig.errors import RequestRefused
from rig.link.memory import MemoryStream
from rig.link.ports import open_stream
from rig.motion.move import home_and_arrive
from rig.testing import LINES
from rig.testing.axes import keep_rate_promises
from rig.twins.serving.servers import serve_pty, serve_tcp

TURNING = ("oriental-az", "rate-table", "zaber")
FACTOR = 60.0


def test_every_axis_that_turns_is_held_to_these_laws() -> None:
    assert tuple(name for name in sorted(DRIVERS) if hasattr(motion_bench(name).pitch, "start_rate")) == TURNING


@pytest.fixture(params=LINES)
def line(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(params=TURNING)
def turning(request: pytest.FixtureRequest, line: str) -> Iterator[tuple[Any, Clock]]:
    axes = settings_of(request.param)
    twin = twin_of(request.param, axes, world_of(axes))
    if line == "memory":
        clock: Clock = virtual_clock()
        yield DRIVERS[request.param].connect(axes, MemoryStream(twin, clock, "memory"))["pitch"], clock
        return
    clock = ScaledClock(FACTOR)
    with (serve_tcp if line == "tcp" else serve_pty)(twin, clock) as server:
        stream = open_stream(server.address, clock=SystemClock())
        yield DRIVERS[request.param].connect(axes, stream)["pitch"], clock
        stream.close()


def test_a_rate_axis_keeps_its_promises(turning: tuple[Any, Clock]) -> None:
    axis, clock = turning
    with pytest.raises(RequestRefused, match="not homed"):
        axis.start_rate(10.0)
    home_and_arrive(axis, clock, clock.sleep)
    keep_rate_promises(axis, clock)
