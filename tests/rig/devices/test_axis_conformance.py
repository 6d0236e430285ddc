"""What every axis promises, by every driver and on every line: in memory, over TCP and over a pseudo-terminal."""

from collections.abc import Iterator, Mapping

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motion_bench import DRIVERS, motion_bench, settings_of, twin_of, world_of
from table_bench import virtual_clock

from rig.abilities.abilities import Axis
from rig.clock import Clock, ScaledClock, SystemClock
from rig.errors import RequestRefused, RigError, WaitEnded
from rig.link import faults
from rig.link.memory import MemoryStream
from rig.link.ports import open_stream
from rig.motion.move import home_and_arrive, move_and_arrive
from rig.testing.axes import keep_axis_promises
from rig.twins.serving.servers import serve_pty, serve_tcp

FACTOR = 50.0
CLOSE_DEG = 0.1
"""No driver here resolves worse: a servo's pulse has steps of a quarter microsecond."""


@pytest.fixture(params=["memory", "tcp", "pty"])
def line(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(params=sorted(DRIVERS))
def bench(request: pytest.FixtureRequest, line: str) -> Iterator[tuple[Mapping[str, Axis], Clock]]:
    driver = DRIVERS[request.param]
    axes = settings_of(request.param)
    twin = twin_of(request.param, axes, world_of(axes))
    if line == "memory":
        clock: Clock = virtual_clock()
        yield driver.connect(axes, MemoryStream(twin, clock, "memory")), clock
        return
    clock = ScaledClock(FACTOR)
    with (serve_tcp if line == "tcp" else serve_pty)(twin, clock) as server:
        stream = open_stream(server.address, clock=SystemClock())
        yield driver.connect(axes, stream), clock
        stream.close()


def test_an_axis_keeps_its_promises(bench: tuple[Mapping[str, Axis], Clock]) -> None:
    axes, clock = bench
    pitch, roll = axes["pitch"], axes["roll"]
    assert pitch.identify() != roll.identify()
    assert not pitch.state().is_homed
    with pytest.raises(RequestRefused, match="not homed"):
        pitch.start_move(10.0)
    home_and_arrive(roll, clock, clock.sleep)
    keep_axis_promises(pitch, clock, target_deg=-30.0, beyond_deg=181.0, close_deg=CLOSE_DEG, others={"roll": roll})


@pytest.mark.parametrize("driver", sorted(DRIVERS))
def test_a_stop_reaches_the_axis_within_a_tenth_of_a_second(driver: str) -> None:
    bench = motion_bench(driver)
    bench.home_all()
    ends_s = bench.clock.monotonic_s() + 4.0

    def wait(duration_s: float) -> None:
        bench.clock.sleep(min(duration_s, 0.1))
        if bench.clock.monotonic_s() > ends_s:
            raise WaitEnded(str(bench.clock.monotonic_s()))

    with pytest.raises(WaitEnded) as ended:
        move_and_arrive(bench.pitch, 170.0, bench.clock, wait)
    assert bench.clock.monotonic_s() <= float(str(ended.value)) + 0.1
    bench.clock.sleep(2.0)
    rested_deg = bench.true_deg
    bench.clock.sleep(60.0)
    assert bench.true_deg == rested_deg
    assert rested_deg < 25.0
    assert not bench.pitch.state().is_moving


@pytest.mark.parametrize("driver", sorted(DRIVERS))
@settings(max_examples=25)
@given(
    low=st.integers(-90, -1),
    high=st.integers(1, 90),
    targets=st.lists(st.one_of(st.floats(-400, 400), st.integers(-200, 200).map(float)), min_size=1, max_size=8),
    sign=st.sampled_from([1, -1]),
    zero_deg=st.integers(-20, 20).map(float),
)
def test_no_request_ever_brings_the_body_outside_the_limits(
    driver: str, low: int, high: int, targets: list[float], sign: int, zero_deg: float
) -> None:
    bench = motion_bench(driver, limits_deg=(float(low), float(high)), sign=sign, zero_deg=zero_deg)
    bench.home_all()
    for target_deg in targets:
        try:
            bench.pitch.start_move(target_deg)
        except RequestRefused:
            continue
        bench.clock.sleep(300.0)
        assert bench.pitch.state().position_deg == pytest.approx(target_deg, abs=CLOSE_DEG)
        assert bench.true_deg == pytest.approx(sign * target_deg + zero_deg, abs=CLOSE_DEG)
    ends_deg = sorted(sign * end + zero_deg for end in (low, high))
    lowest_deg, highest_deg = bench.world.axes["pitch"].reached_deg
    assert min(ends_deg[0], 0.0) - 1e-6 <= lowest_deg
    assert highest_deg <= max(ends_deg[1], 0.0) + 1e-6


FAULTS = st.one_of(
    st.just(faults.drop),
    st.builds(faults.delay, st.floats(0.0, 4.0)),
    st.builds(faults.duplicate, st.floats(0.0, 4.0)),
    st.builds(faults.truncate, st.integers(0, 12)),
    st.builds(faults.split, st.integers(0, 12), st.floats(0.0, 3.0)),
    st.builds(faults.prepend, st.binary(max_size=40)),
)


@pytest.mark.parametrize("driver", sorted(set(DRIVERS) - {"manual"}))
@settings(max_examples=40)
@given(script=st.dictionaries(st.integers(0, 40), FAULTS, max_size=4))
def test_whatever_the_line_does_a_position_is_right_or_there_is_none(
    driver: str, script: dict[int, faults.Fault]
) -> None:
    bench = motion_bench(driver)
    bench.home_all()
    bench.pitch.start_move(30.0)
    bench.clock.sleep(60.0)
    assert bench.pitch.state().position_deg == pytest.approx(30.0, abs=CLOSE_DEG)
    bench.faults.reads = {bench.faults.taken + location: fault for location, fault in script.items()}
    for name, angle_deg in (("pitch", 30.0), ("roll", 0.0)) * 3:
        started_s = bench.clock.monotonic_s()
        try:
            assert bench.axes[name].state().position_deg == pytest.approx(angle_deg, abs=CLOSE_DEG)
        except RigError:
            bench.clock.sleep(1.0)
        assert bench.clock.monotonic_s() - started_s < 60.0


@pytest.mark.parametrize("driver", sorted(DRIVERS))
@settings(max_examples=25)
@given(replies=st.lists(st.binary(max_size=40), min_size=1, max_size=20))
def test_arbitrary_replies_end_in_a_state_or_an_error_of_the_rig(driver: str, replies: list[bytes]) -> None:
    bench = motion_bench(driver)
    bench.faults.reads = {index: faults.replace(replies[index % len(replies)]) for index in range(200)}
    try:
        bench.pitch.home()
        bench.pitch.state()
    except RigError:
        pass
    assert bench.clock.monotonic_s() < 300.0
