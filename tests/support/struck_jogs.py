"""``calrig jog`` against machines on TCP whose line strikes one command or one reply of the job."""

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from command_strikes import KINDS, LIMITS_DEG, StrikeOn, a_command
from recording_proxy import RecordingProxy
from reply_strikes import KINDS_OF, a_reply
from turning_rig import DRIVE_FOR_ROLL, SERVO_FOR_PITCH, STAGE_FOR_ROLL, served

from procedures.cli.main import run_command
from rig.assembly.simulate import SimulatedRig
from rig.clock import ScaledClock

FACTOR = 3.0
SPEED_DPS = 20.0
REACTION_S = 2.6
"""Rig seconds from what the line did to the stop: a look, its confirmation; and the bench's processors, which three
other things may keep for half a second of theirs."""
MARGIN_DEG, CLOSE_DEG, AT_REST_DEG = 1.5, 0.1, 0.05
REACH_DEG = 30.0
LOOK_S = 0.05
_QUICK_TABLE = ("speed_dps = 5.0\nuncertainty", "speed_dps = 20.0\nuncertainty")
BENCHES = {
    "zaber": ("roll", [STAGE_FOR_ROLL]),
    "oriental-az": ("roll", [DRIVE_FOR_ROLL]),
    "maestro": ("pitch", [SERVO_FOR_PITCH]),
    "indexing-table": ("pitch", [_QUICK_TABLE]),
}
JOBS = [
    (driver, job)
    for driver in BENCHES
    for job in ("to", "home", "rate")
    if job != "rate" or driver in ("zaber", "oriental-az")
]
STRIKES: list[tuple[str, str, StrikeOn, str]] = [
    (driver, job, on, kind)
    for driver, job in JOBS
    for on, kinds in ((a_command, KINDS), (a_reply, KINDS_OF[driver]))
    for kind in kinds
]


@dataclass
class JogBench:
    """One machine, its line, and the rig file by which the command reaches it."""

    driver: str
    axis: str
    simulated: SimulatedRig
    line: RecordingProxy
    rig_file: Path
    clock: ScaledClock

    @property
    def here_deg(self) -> float:
        return self.simulated.world.axes[self.axis].table_deg(self.clock.monotonic_s())

    def jog(self, *options: object) -> int:
        words = ["jog", "--rig", self.rig_file, "--axis", self.axis, *options]
        return int(run_command([str(word) for word in words]))

    def bring(self, *options: object) -> None:
        """Jog on a line that does not strike; a bench whose time runs faster than a busy machine may need it again."""
        assert any(self.jog(*options) == 0 for _ in range(3)), options

    def until_at_rest(self, limit_s: float = 30.0) -> None:
        ends_s, last_deg = self.clock.monotonic_s() + limit_s, None
        while last_deg != (last_deg := self.here_deg):
            assert self.clock.monotonic_s() < ends_s, "it turns on and on"
            self.clock.sleep(1.0)


@dataclass(frozen=True)
class JogStory:
    """What a strike led to; angles as in :class:`command_strikes.Story`."""

    struck: str
    status: int
    outside_deg: float
    allowed_deg: float
    moved_after_deg: float
    from_target_deg: float
    """How far from the target it rests; 0 for a rate."""


@contextmanager
def jog_bench(folder: Path, driver: str) -> Iterator[JogBench]:
    axis, changes = BENCHES[driver]
    with bench_with(folder, driver, axis, changes) as bench:
        yield bench


@contextmanager
def bench_with(
    folder: Path, driver: str, axis: str, changes: Sequence[tuple[str, str]], factor: float = FACTOR
) -> Iterator[JogBench]:
    """``changes``: of the example rig."""
    clock = ScaledClock(factor)
    with served(folder, clock, *changes) as (simulated, rig_file):
        address = simulated.addresses[f"axes.{axis}"]
        host, _, port = address.removeprefix("socket://").rpartition(":")
        line = RecordingProxy((host, int(port)), clock)
        text = rig_file.read_text(encoding="utf-8")
        rig_file.write_text(text.replace(address, line.address), encoding="utf-8")
        try:
            yield JogBench(driver, axis, simulated, line, rig_file, clock)
        finally:
            line.close()


def strike_jog(bench: JogBench, job: str, on: StrikeOn, kind: str, seed: int) -> JogStory:
    """Bring the axis to a place, then let one command or reply of a job go wrong."""
    chance = np.random.default_rng(seed)
    start_deg, target_deg = (float(round(angle)) for angle in chance.uniform(-REACH_DEG, REACH_DEG, 2))
    bench.bring("--home")
    bench.bring("--to", start_deg)
    rate_dps = 10.0 if chance.integers(2) else -10.0
    target_deg = {"home": 0.0, "rate": start_deg + 2.0 * rate_dps}.get(job, target_deg)
    options = {"to": ("--to", target_deg), "home": ("--home",), "rate": ("--rate", rate_dps, "--for", 2.0)}[job]
    low_deg, high_deg = sorted((start_deg, target_deg))
    if job == "home":
        low_deg, high_deg = LIMITS_DEG
    bench.line.faults = struck = on(bench.driver, kind, chance)
    try:
        with _farthest(bench, low_deg, high_deg) as outside_deg:
            status = bench.jog(*options)
            bench.clock.sleep(1.0)
            at_end_deg = bench.here_deg
            bench.clock.sleep(3.0)
            moved_deg = abs(bench.here_deg - at_end_deg)
            from_target_deg = 0.0 if job == "rate" else abs(bench.here_deg - target_deg)
            farthest_deg = outside_deg()
    finally:
        bench.line.faults = None
    bench.until_at_rest()
    allowed_deg = MARGIN_DEG + REACTION_S * SPEED_DPS
    return JogStory(struck.struck, status, farthest_deg, allowed_deg, moved_deg, from_target_deg)


@contextmanager
def _farthest(bench: JogBench, low_deg: float, high_deg: float) -> Iterator[Callable[[], float]]:
    """Look all the time; the farthest outside the corridor so far."""
    seen, is_over = [0.0], threading.Event()

    def look() -> None:
        while not is_over.is_set():
            here_deg = bench.here_deg
            seen[0] = max(seen[0], low_deg - here_deg, here_deg - high_deg)
            bench.clock.sleep(LOOK_S)

    thread = threading.Thread(target=look, daemon=True)
    thread.start()
    try:
        yield lambda: seen[0]
    finally:
        is_over.set()
        thread.join()
