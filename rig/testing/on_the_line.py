"""Laws of what an axis has sent, seen on its line: the stop that somebody else sends, and a start that is sent once."""

from collections.abc import Callable
from contextlib import ExitStack
from datetime import UTC, datetime
from pathlib import Path

from rig.clock import Clock, VirtualClock
from rig.description.read import read_rig
from rig.devices.abilities import Axis, Stoppable
from rig.drivers.open import open_axes
from rig.drivers.twin_lines import axis_lines, twin_lines
from rig.errors import RigError
from rig.lines.open_lines import Lines
from rig.link.byte_stream import ByteStream
from rig.motion.move import home_and_arrive
from rig.testing.law import expect
from rig.twins.world import World

UNDER_WAY_S = 1.0
REST_S = 30.0
FAST = 1.25
"""No axis goes faster than this much of its speed."""


class WatchedLine:
    """A line that can fall deaf: what comes is lost, as behind a cable that was pulled."""

    def __init__(self, inner: ByteStream) -> None:
        self.name, self.clock = inner.name, inner.clock
        self.is_deaf = False
        self._inner = inner

    def write(self, data: bytes) -> None:
        self._inner.write(data)

    def read(self, deadline_s: float) -> bytes:
        while data := self._inner.read(deadline_s):
            if not self.is_deaf:
                return data
        return b""

    def discard_input(self) -> bytes:
        taken = self._inner.discard_input()
        return b"" if self.is_deaf else taken

    def close(self) -> None:
        self._inner.close()


def keep_promises_on_the_line(path: Path, name: str) -> None:
    """Hold the axis ``name`` of the rig file, on its twin in memory, to what must be true of its bytes.

    Its ``stop_steps``, sent by somebody else while it moves, end the move, and are harmless at rest and sent twice; a
    start whose acknowledgement is lost is not sent again; it goes no faster than its ``speed_dps``.

    Raises: AssertionError. Steps that aim a servo are left out: they need the guard's own question.
    """
    description = read_rig(path)
    names = next(line for line in axis_lines(description.axes) if name in line)
    world, clock = World(description), VirtualClock(datetime(2024, 1, 1, tzinfo=UTC))
    twins = {key: line.twin for line in twin_lines(description, world) for key in line.keys}
    watched: list[WatchedLine] = []

    def source(_key: str, open_line: Callable[[], ByteStream]) -> ByteStream:
        watched.append(WatchedLine(open_line()))
        return watched[-1]

    with ExitStack() as opened:
        lines = Lines(clock, twins, source, opened)
        axis = open_axes({one: description.axes[one] for one in names}, lines)[name]
        home_and_arrive(axis, clock, clock.sleep)
        target_deg = _far_deg(axis)
        _keep_speed(axis, clock, target_deg)
        _keep_stop_steps(axis, clock, watched[-1], target_deg)
        home_and_arrive(axis, clock, clock.sleep)
        _keep_one_start(axis, world, watched[-1], target_deg)


def _far_deg(axis: Axis) -> float:
    """Return a target that takes long enough, on the increment of the axis."""
    here_deg, (low_deg, high_deg) = axis.state().position_deg, axis.limits_deg
    far_deg = high_deg if high_deg - here_deg > here_deg - low_deg else low_deg
    reach_deg = 0.9 * (far_deg - here_deg)
    return here_deg + (round(reach_deg / axis.increment_deg) * axis.increment_deg if axis.increment_deg else reach_deg)


def _keep_speed(axis: Axis, clock: Clock, target_deg: float) -> None:
    before_deg = axis.state().position_deg
    axis.start_move(target_deg)
    began_s = clock.monotonic_s()
    clock.sleep(UNDER_WAY_S)
    state = axis.state()
    took_s = clock.monotonic_s() - began_s
    went_dps = abs(state.position_deg - before_deg) / took_s
    allowed_dps = FAST * axis.speed_dps
    expect(
        went_dps <= allowed_dps,
        f"{axis.name}: it goes at {went_dps:.3g} deg/s, speed_dps is {axis.speed_dps:g}: is the machine told?",
    )


def _keep_stop_steps(axis: Axis, clock: Clock, line: WatchedLine, target_deg: float) -> None:
    """While it moves, and once more at rest."""
    steps = axis.stop_steps() if isinstance(axis, Stoppable) else ()
    if any(step.aim is not None for step in steps):
        axis.stop()
        clock.sleep(REST_S)
        return
    expect(bool(steps), f"{axis.name}: no stop_steps: nobody stops it when the program that moves it dies")
    expect(axis.state().is_moving, f"{axis.name}: {target_deg:g} deg is reached too soon to see a stop")
    for why in ("they do not end a move", "sent again at rest, they move it"):
        before_deg = axis.state().position_deg
        for step in steps:
            line.write(step.send)
            clock.sleep(step.pause_s)
        clock.sleep(REST_S)
        line.discard_input()
        state = axis.state()
        expect(not state.is_moving, f"{axis.name}: its stop_steps: {why}")
        on_deg = (state.position_deg - before_deg) * (1.0 if target_deg > before_deg else -1.0)
        expect(on_deg >= -axis.arrival_tolerance_deg, f"{axis.name}: its stop_steps: they send it back")
        is_short = abs(state.position_deg - target_deg) > axis.arrival_tolerance_deg
        expect(is_short, f"{axis.name}: its stop_steps: they let it arrive")
        if why.startswith("sent again"):
            expect(state.position_deg == before_deg, f"{axis.name}: its stop_steps: {why}")


def _keep_one_start(axis: Axis, world: World, line: WatchedLine, target_deg: float) -> None:
    """Lose every answer from the moment at which the twin begins to move."""
    starts = 0
    follow, rotate = world.follow, world.rotate

    def counted(begin: Callable[..., float]) -> Callable[..., float]:
        def started(*what: object, **more: object) -> float:
            nonlocal starts
            starts += 1
            line.is_deaf = True
            return begin(*what, **more)

        return started

    world.follow, world.rotate = counted(follow), counted(rotate)  # type: ignore[method-assign]
    try:
        axis.start_move(target_deg)
    except RigError:
        pass  # it cannot know; what counts is what it sent
    finally:
        world.follow, world.rotate = follow, rotate  # type: ignore[method-assign]
        line.is_deaf = False
    expect(starts == 1, f"{axis.name}: a start whose acknowledgement was lost was sent {starts} times, need 1")
