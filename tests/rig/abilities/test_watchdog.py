"""Laws of watchdogs: a machine stops by itself when its host falls silent, and that is seen before it is relied upon.

Serial time-out of the Maestro: user's guide, pages 39 and 49 (error bit 5, every servo goes home; any valid command
counts; 0.01 s to 655.35 s, 0 is off). Alarm 85h of the AZ: RS-485 communication timeout.
"""

import signal
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from motion_bench import DRIVERS, MotionBench, motion_bench, settings_of, twin_of, world_of
from pydantic import ValidationError
from table_bench import virtual_clock

from rig.abilities.abilities import Watchdog
from rig.clock import Clock, ScaledClock, SystemClock
from rig.errors import DeviceFault, WaitEnded
from rig.link.ports import open_stream
from rig.motion.move import home_and_arrive
from rig.twins.serving.servers import TwinServer, serve_pty, serve_tcp
from rig.wire.maestro import Errors

GUARDED = ("maestro", "oriental-az")
T_S = 5.0


def _bench(driver: str, **changes: object) -> MotionBench:
    bench = motion_bench(driver, watchdog_s=T_S, **changes)
    bench.pitch.arm_watchdog(bench.clock.sleep)
    return bench


def _set_off(bench: MotionBench) -> None:
    """Let pitch move for at least a minute."""
    home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep)
    if hasattr(bench.pitch, "start_rate"):
        bench.pitch.start_rate(2.0)
    else:
        bench.pitch.start_move(170.0)
    bench.clock.sleep(1.0)


def _rate_dps(bench: MotionBench) -> float:
    rate_dps: float = bench.world.axes["pitch"].rate_dps(bench.clock.monotonic_s())
    return rate_dps


def _let_the_twin_notice(bench: MotionBench, duration_s: float) -> None:
    """A line on which nobody asks: only the twin's own events happen."""
    end_s = bench.clock.monotonic_s() + duration_s
    while (event_s := bench.twin.next_event_s()) is not None and event_s < end_s:
        bench.clock.sleep(event_s - bench.clock.monotonic_s())
        bench.twin.transmit(bench.clock.monotonic_s())
    bench.clock.sleep(end_s - bench.clock.monotonic_s())


def test_the_guarded_drivers_are_these() -> None:
    assert tuple(name for name in sorted(DRIVERS) if isinstance(motion_bench(name).pitch, Watchdog)) == GUARDED


@pytest.mark.parametrize("driver", GUARDED)
def test_fault_56_a_silent_host_stops_the_machine_within_its_time_out(driver: str) -> None:
    bench = _bench(driver)
    _set_off(bench)
    assert _rate_dps(bench) != 0.0
    bench.pitch.state()
    _let_the_twin_notice(bench, T_S - 0.1)
    assert _rate_dps(bench) > 0.0
    _let_the_twin_notice(bench, 0.3)
    assert _rate_dps(bench) <= 0.0  # stopped, or a servo on its way to its home
    _let_the_twin_notice(bench, 120.0)
    assert _rate_dps(bench) == 0.0


@pytest.mark.parametrize("driver", GUARDED)
def test_a_host_that_speaks_often_enough_is_left_alone(driver: str) -> None:
    bench = _bench(driver)
    home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep)
    for _ in range(20):
        bench.clock.sleep(0.9 * T_S)
        bench.pitch.feed_watchdog()
    state = bench.pitch.state()
    assert (state.is_homed, state.fault) == (True, "")


@pytest.mark.parametrize("driver", GUARDED)
def test_arming_moves_nothing_and_takes_two_silences(driver: str) -> None:
    bench = motion_bench(driver, watchdog_s=T_S)
    began_s, before_deg = bench.clock.monotonic_s(), bench.true_deg
    found = bench.pitch.arm_watchdog(bench.clock.sleep)
    seen, *more = found.split("; ")
    assert seen == "watchdog of 5 s: 2.5 s of silence passed, 6.25 s were noticed"
    unread = "it is a setting of the controller, which tells it to nobody: proven now, not looked at again"
    assert more == ([unread] if driver == "maestro" else [])
    assert bench.clock.monotonic_s() - began_s == pytest.approx(1.75 * T_S, abs=1.0)
    assert bench.true_deg == before_deg


@pytest.mark.parametrize("driver", GUARDED)
def test_the_silences_that_are_told_are_those_that_were(driver: str) -> None:
    """A computer with other work wakes late: 0.4 s of each wait are not in what the proof asked for."""
    bench = motion_bench(driver, watchdog_s=T_S)
    found = bench.pitch.arm_watchdog(lambda duration_s: bench.clock.sleep(duration_s + 0.4))
    assert found.split("; ")[0] == "watchdog of 5 s: 2.9 s of silence passed, 6.65 s were noticed"


@pytest.mark.parametrize("driver", GUARDED)
def test_a_computer_that_is_silent_for_too_long_does_not_blame_the_machine(driver: str) -> None:
    bench = motion_bench(driver, watchdog_s=T_S)
    late = r"pitch: this computer was silent for 7\.5 s where 2\.5 s were meant, .* nothing is proven"
    with pytest.raises(DeviceFault, match=late):
        bench.pitch.arm_watchdog(lambda duration_s: bench.clock.sleep(duration_s + 5.0))


def test_an_az_whose_time_out_is_gone_turns_no_more_until_it_is_armed_anew() -> None:
    bench = _bench("oriental-az")
    home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep)
    bench.twin.power_cycle(bench.clock.monotonic_s())
    for work in (bench.pitch.feed_watchdog, lambda: bench.pitch.start_rate(5.0)):
        with pytest.raises(DeviceFault, match="pitch: its watchdog is gone: register 0x138a reads 0 ms, 5000 ms were"):
            work()
    assert _rate_dps(bench) == 0.0
    bench.pitch.arm_watchdog(bench.clock.sleep)
    bench.pitch.feed_watchdog()


def test_a_controller_without_a_time_out_is_not_relied_upon() -> None:
    bench = motion_bench("maestro", watchdog_s=T_S)
    bench.twin._timeout_s = None  # as it is delivered
    with pytest.raises(DeviceFault, match=r"pitch: the machine did not notice a silence of 6\.25 s.*Control Center"):
        bench.pitch.arm_watchdog(bench.clock.sleep)


def test_a_time_out_that_is_far_shorter_than_declared_is_told() -> None:
    bench = motion_bench("maestro", watchdog_s=T_S)
    bench.twin._timeout_s = 1.0
    with pytest.raises(DeviceFault, match=r"stopped by itself after 2\.5 s of silence, its watchdog should allow 5 s"):
        bench.pitch.arm_watchdog(bench.clock.sleep)


def test_a_register_that_is_another_one_is_found_out() -> None:
    bench = motion_bench("oriental-az", watchdog_s=T_S, watchdog_register=0x5C)  # a position of the direct data
    with pytest.raises(DeviceFault, match=r"did not notice a silence of 6\.25 s.*watchdog_register"):
        bench.pitch.arm_watchdog(bench.clock.sleep)


def test_a_proof_that_is_broken_off_leaves_no_watchdog_behind() -> None:
    bench = motion_bench("oriental-az", watchdog_s=T_S)

    def wait(duration_s: float) -> None:
        bench.clock.sleep(0.1)
        raise WaitEnded(f"abort, {duration_s:g} s early")

    with pytest.raises(WaitEnded):
        bench.pitch.arm_watchdog(wait)
    _let_the_twin_notice(bench, 3600.0)
    assert bench.pitch.state().fault == ""


def test_the_servos_of_one_controller_are_silent_once_and_all_lost_until_homed() -> None:
    bench = _bench("maestro")
    began_s = bench.clock.monotonic_s()
    assert bench.axes["roll"].arm_watchdog(bench.clock.sleep).startswith("watchdog of 5 s")
    assert bench.clock.monotonic_s() == began_s
    assert not any(axis.state().is_homed for axis in bench.axes.values())
    assert home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep) == pytest.approx(0.0, abs=0.05)


def test_an_az_is_told_that_its_host_leaves_and_stays_calm() -> None:
    bench = _bench("oriental-az")
    bench.pitch.disarm_watchdog()
    _let_the_twin_notice(bench, 3600.0)
    assert bench.pitch.state().fault == ""


def test_the_alarm_that_a_dead_host_left_is_reset_by_the_next_and_no_other_is() -> None:
    bench = _bench("oriental-az")
    _let_the_twin_notice(bench, 60.0)
    assert bench.pitch.state().fault == "alarm 0x85 (its host fell silent; home resets it)"
    bench.pitch.arm_watchdog(bench.clock.sleep)
    assert bench.pitch.state().fault == ""
    _let_the_twin_notice(bench, 60.0)
    bench.pitch._is_armed = False  # the next command is another connection
    assert home_and_arrive(bench.pitch, bench.clock, bench.clock.sleep) == 0.0
    _let_the_twin_notice(bench, 3600.0)  # by hand, from command to command, nobody feeds it
    assert bench.pitch.state().fault == ""
    bench.twin.units[1].alarm = 0x30
    with pytest.raises(DeviceFault, match="arm the watchdog: alarm 0x30"):
        bench.pitch.arm_watchdog(bench.clock.sleep)


def test_the_az_is_told_by_these_bytes() -> None:
    bench = motion_bench("oriental-az", watchdog_s=T_S)
    heard: list[bytes] = []
    receive = bench.twin.receive

    def listen(data: bytes, now_s: float) -> None:
        heard.append(data)
        receive(data, now_s)

    bench.twin.receive = listen
    bench.pitch.arm_watchdog(bench.clock.sleep)
    assert bytes.fromhex("01 10 13 8A 00 02 04 00 00 13 88") in [frame[:-2] for frame in heard]  # 5000 ms


@pytest.mark.parametrize(("driver", "wrong"), [("maestro", 1.0), ("maestro", 601.0), ("oriental-az", 10.5)])
def test_a_time_out_that_no_run_could_keep_is_refused(driver: str, wrong: float) -> None:
    with pytest.raises(ValidationError, match="watchdog_s"):
        settings_of(driver, watchdog_s=wrong)


@pytest.mark.parametrize("serve", [serve_tcp, serve_pty], ids=["tcp", "pty"])
@pytest.mark.parametrize("driver", GUARDED)
def test_a_watchdog_is_proven_over_real_lines(driver: str, serve: Callable[[Any, Clock], TwinServer]) -> None:
    """Real ports and threads. The twin's time is virtual: it passes in the host's waits, however late those are."""
    axes, clock = settings_of(driver, watchdog_s=T_S), virtual_clock()
    with serve(twin_of(driver, axes, world_of(axes)), clock) as server:
        stream = open_stream(server.address, clock=SystemClock())
        connected: Mapping[str, Any] = DRIVERS[driver].connect(axes, stream)
        assert "were noticed" in connected["pitch"].arm_watchdog(clock.sleep)
        stream.close()


@pytest.mark.parametrize("driver", GUARDED)
def test_fault_56_a_host_killed_while_an_axis_turns_leaves_it_at_rest(driver: str) -> None:
    """A real process on a real port, killed with SIGKILL; the twin's own time says when the axis stands."""
    watchdog_s = 10.0
    axes, clock = settings_of(driver, watchdog_s=watchdog_s), ScaledClock(10.0)
    world = world_of(axes)
    host = Path(__file__).parents[2] / "support" / "silent_host.py"
    with serve_tcp(twin_of(driver, axes, world), clock) as server:
        command = [sys.executable, str(host), driver, server.address, str(watchdog_s), "10"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == "moving\n"
            clock.sleep(1.0)
            body = world.axes["pitch"]
            assert body.rate_dps(clock.monotonic_s()) > 0.0
            process.send_signal(signal.SIGKILL)
            process.wait()
            killed_s = clock.monotonic_s()
        while body.rate_dps(clock.monotonic_s()) > 0.0 and clock.monotonic_s() < killed_s + 3.0 * watchdog_s:
            clock.sleep(0.2)
        took_s = clock.monotonic_s() - killed_s
    assert body.rate_dps(clock.monotonic_s()) <= 0.0
    assert took_s <= watchdog_s + 5.0  # the half second that a busy machine may be late


def test_the_serial_time_out_is_bit_5() -> None:
    assert Errors.TIMEOUT == 1 << 5  # guide, page 39
