"""What every axis that turns promises, by every driver and on every line: in memory, over TCP and over a pty."""

from collections.abc import Iterator
from typing import Any

import pytest
from motion_bench import DRIVERS, motion_bench, settings_of, twin_of, world_of
from ported_rig import LINES
from table_bench import virtual_clock

from rig.clock import Clock, ScaledClock, SystemClock
from rig.devices.rates import measured_rate
from rig.errors import RequestRefused
from rig.link.memory import MemoryStream
from rig.link.ports import open_stream
from rig.motion.move import home_and_arrive, stop_all
from rig.twins.servers import serve_pty, serve_tcp

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
    for wrong_dps in (0.0, float("nan"), float("inf"), 1.01 * axis.top_rate_dps, -1.01 * axis.top_rate_dps):
        for refused in (axis.check_rate, axis.start_rate):
            with pytest.raises(RequestRefused, match=r"pitch: turn at .*nothing moved"):
                refused(wrong_dps)
    for rate_dps in (25.0, -40.0):  # the second from within the first: both senses, no stop between
        axis.start_rate(rate_dps)
        clock.sleep(4.0)  # a change of 65 deg/s at 20 deg/s² takes 3.25 s
        assert axis.state().is_moving
        first = axis.turn_look(clock)
        clock.sleep(15.0)
        measured = measured_rate(first, axis.turn_look(clock))
        assert abs(measured.rate_dps - rate_dps) <= 3.0 * measured.uncertainty_dps + 0.01
        assert abs(measured.turned_deg) > 360.0  # the angle goes on beyond a revolution
        assert first.uncertainty_s >= 0.0
    stop_all({"pitch": axis}, clock)
    rested_deg = axis.turn_look(clock).angle_deg
    clock.sleep(5.0)
    assert axis.turn_look(clock).angle_deg == rested_deg
    assert not axis.state().is_moving
