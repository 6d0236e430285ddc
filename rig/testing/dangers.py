"""Laws of an axis in danger: calrig dies while it moves, an answer is lost, its power fails, its speed is another.

They run on twins in memory, where both ends of the line are at hand (:mod:`rig.testing.axis_bench`).
"""

from collections.abc import Callable
from contextlib import suppress

from rig.abilities.abilities import Stoppable, StopStep
from rig.description.rig_file import RigDescription
from rig.errors import MotionBreach, RigError
from rig.motion.move import home_and_arrive, move_and_arrive, stop_all
from rig.testing.axis_bench import AxisBench
from rig.testing.law import expect, expect_near

REST_S = 5.0
NOISE = b"\x15~ 4711 ~\r\n"
WAKES_AT = 1.4
"""Times the speed of the rig file: below what the supervisor takes for a runaway."""
TOO_FAST = 1.1


def keep_axis_safe(
    description: RigDescription, name: str, ends_deg: tuple[float, float], close_deg: float, *, sets_speed: bool = True
) -> None:
    """Hold an axis to the laws of danger; ``ends_deg``: two places where it may stop, far from each other.

    ``sets_speed``: False for a machine that has no command for its speed. Raises: AssertionError.
    """
    with AxisBench(description, name) as bench:
        keep_stop_steps(bench, ends_deg, close_deg)
        keep_stop_heard(bench, ends_deg)
        keep_starts_single(bench, ends_deg)
        keep_home_honest(bench, ends_deg[0], close_deg)
    if sets_speed:
        with AxisBench(description, name, wakes_at=WAKES_AT) as bench:
            keep_speed(bench, ends_deg)


def keep_stop_steps(bench: AxisBench, ends_deg: tuple[float, float], close_deg: float) -> None:
    """Send the bytes of ``stop_steps`` without the driver, as the stop guard does when calrig is dead.

    At rest they move nothing; while it moves they bring it to rest; sent twice they do no harm.
    """
    name = bench.name
    expect(isinstance(bench.axis, Stoppable), f"{name}: no stop_steps: nothing stops it when calrig dies")
    assert isinstance(bench.axis, Stoppable)
    steps = tuple(bench.axis.stop_steps())
    if not steps:
        return  # its machine has no stop, which `calrig check` tells
    from_deg, to_deg = ends_deg
    home_and_arrive(bench.axis, bench.clock, bench.clock.sleep)
    move_and_arrive(bench.axis, from_deg, bench.clock, bench.clock.sleep)
    off_deg, rested_deg = from_deg - bench.true_deg, bench.true_deg
    others_deg = {other: axis.state().position_deg for other, axis in bench.rig.axes.items() if other != name}
    for _ in range(2):
        bench.send(steps)
    bench.clock.sleep(REST_S)
    expect_near(bench.true_deg, rested_deg, 1e-9, f"{name}: stop_steps sent at rest moved it")
    for other, before_deg in others_deg.items():
        after_deg = bench.rig.axes[other].state().position_deg
        expect_near(after_deg, before_deg, close_deg, f"{other}: stop_steps of {name} moved it")
    bench.axis.start_move(to_deg)
    _half_way(bench, from_deg, to_deg)
    stopped_deg = _stopped_by(bench, steps, "moves")
    tolerance_deg = max(bench.axis.arrival_tolerance_deg, close_deg)
    expect(abs(stopped_deg + off_deg - to_deg) > tolerance_deg, f"{name}: stop_steps let it arrive")
    bench.reconnect()
    state = bench.axis.state()
    expect(not state.is_moving, f"{name}: behind its stop_steps it says that it moves")
    if state.is_homed:
        what = f"{name}: behind its stop_steps it says that it is homed, and where it is not"
        expect_near(state.position_deg, stopped_deg + off_deg, close_deg, what)
    if bench.settings.turning == "revolves":
        home_and_arrive(bench.axis, bench.clock, bench.clock.sleep)
        bench.start_rate()
        bench.clock.sleep(2.0)
        _stopped_by(bench, steps, "turns at a rate")


def keep_stop_heard(bench: AxisBench, ends_deg: tuple[float, float]) -> None:
    """Stop it over a line that was opened anew and never falls quiet: the stop is written before anything is heard.

    What a machine is slowed by, and stopped by what it answers, is not held to it, nor is a person.
    """
    assert isinstance(bench.axis, Stoppable)
    steps = bench.axis.stop_steps()
    if not steps or any(step.aim is not None for step in steps):
        return
    from_deg, to_deg = ends_deg
    home_and_arrive(bench.axis, bench.clock, bench.clock.sleep)
    move_and_arrive(bench.axis, from_deg, bench.clock, bench.clock.sleep)
    bench.axis.start_move(to_deg)
    if bench.axis.state().awaits_operator:
        stop_all({bench.name: bench.axis}, bench.clock)
        return
    _half_way(bench, from_deg, to_deg)
    bench.reconnect()
    bench.line.says = NOISE
    with suppress(RigError):  # that nobody knows whether it stands is an answer
        bench.axis.stop()
    bench.clock.sleep(REST_S)
    bench.line.says = b""
    rested_deg = bench.true_deg
    tolerance_deg = max(bench.axis.arrival_tolerance_deg, 0.5)
    sentence = f"{bench.name}: its stop was not sent over a line that does not fall quiet: it goes on"
    expect(abs(rested_deg - to_deg) > tolerance_deg, sentence)
    bench.clock.sleep(REST_S)
    expect(bench.true_deg == rested_deg, sentence)


def _stopped_by(bench: AxisBench, steps: tuple[StopStep, ...], what_it_does: str) -> float:
    """Send the steps twice and see the machine itself rest; return where."""
    for _ in range(2):
        bench.send(steps)
    bench.clock.sleep(REST_S)
    stopped_deg = bench.true_deg
    bench.clock.sleep(REST_S)
    sentence = f"{bench.name}: stop_steps sent while it {what_it_does} do not bring it to rest: it goes on"
    expect(bench.true_deg == stopped_deg, sentence)
    return stopped_deg


def keep_starts_single(bench: AxisBench, ends_deg: tuple[float, float]) -> None:
    """Lose each answer of a start in turn: whatever the driver then does, the machine starts once."""

    def move() -> None:
        here_deg = bench.axis.state().position_deg
        bench.axis.start_move(max(ends_deg, key=lambda end_deg: abs(end_deg - here_deg)))

    _keep_start_single(bench, "a move", move)
    _keep_start_single(bench, "a home search", bench.axis.home)
    if bench.settings.turning == "revolves":
        _keep_start_single(bench, "a rate", bench.start_rate)


def _keep_start_single(bench: AxisBench, what: str, start: Callable[[], None]) -> None:
    once = _starts(bench, start, None)
    for lost in range(bench.line.heard):
        count = _starts(bench, start, lost)
        expect(count <= once, f"{bench.name}: {what} was started {count} times where one answer was lost, need {once}")


def _starts(bench: AxisBench, start: Callable[[], None], lost: int | None) -> int:
    """Start from rest while answer number ``lost`` is lost; return how often the machine started."""
    if not bench.axis.state().is_homed:
        home_and_arrive(bench.axis, bench.clock, bench.clock.sleep)
    bench.line.heard, bench.line.loses, before = 0, lost, bench.starts
    with suppress(RigError):  # that nothing is known is an answer
        start()
    heard, started = bench.line.heard, bench.starts - before
    bench.line.loses = None
    bench.clock.sleep(REST_S)
    stop_all({bench.name: bench.axis}, bench.clock)
    bench.line.heard = heard
    return started


def keep_home_honest(bench: AxisBench, away_deg: float, close_deg: float) -> None:
    """Cut the power of a homed axis away from its home: the next session is told the truth, or that there is no home.

    A twin without ``power_cycle`` cannot be asked.
    """
    cut_power = bench.cut_power
    if cut_power is None:
        return
    home_and_arrive(bench.axis, bench.clock, bench.clock.sleep)
    reached_deg = move_and_arrive(bench.axis, away_deg, bench.clock, bench.clock.sleep)
    cut_power(bench.clock.monotonic_s())
    bench.reconnect()
    state = bench.axis.state()
    if state.is_homed:
        what = f"{bench.name}: its power failed at {reached_deg:g}°, and it says that it is homed"
        expect_near(state.position_deg, reached_deg, close_deg, what)


def keep_speed(bench: AxisBench, ends_deg: tuple[float, float]) -> None:
    """Move a machine that woke at another speed: it goes at that of the rig file."""
    from_deg, to_deg = ends_deg
    sentence = f"{bench.name}: it does not go at speed_dps = {bench.settings.speed_dps:g}, which was not sent or not"
    sentence += " taken (keep_promises(…, sets_speed=False) where the machine has no command for it)"
    try:
        home_and_arrive(bench.axis, bench.clock, bench.clock.sleep)
        move_and_arrive(bench.axis, from_deg, bench.clock, bench.clock.sleep)
        bench.axis.start_move(to_deg)
        _half_way(bench, from_deg, to_deg)
    except MotionBreach as breach:
        raise AssertionError(f"{sentence}: {breach}") from breach
    rate_dps = abs(bench.body.rate_dps(bench.clock.monotonic_s()))
    expect(rate_dps <= TOO_FAST * bench.settings.speed_dps, f"{sentence}: it goes at {rate_dps:g}")
    stop_all({bench.name: bench.axis}, bench.clock)


def _half_way(bench: AxisBench, from_deg: float, to_deg: float) -> None:
    """Let it go, no farther than half of its way."""
    bench.clock.sleep(min(2.0, 0.3 * abs(to_deg - from_deg) / bench.settings.speed_dps))
