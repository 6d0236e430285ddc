"""The process dies, the devices do not: twins behind TCP ports go on with what they were told when the engine was
killed, and a resume finds them as they are, moving or at rest, with readings half sent."""

import os
import shutil
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from device_sets import SHORTER, device_set
from killing import Aim, Target, require_kept, run_child
from small_run import Bench

from procedures.journal.status.status import status
from procedures.kinds.planner import make_plan
from procedures.kinds.read import read_procedure
from procedures.records.dwells import DwellRecord
from procedures.records.states import State
from procedures.run.resume import resume
from rig.assembly.simulate import SimulatedRig, serve_rig, write_rig
from rig.clock import ScaledClock, SystemClock

pytestmark = pytest.mark.timeout(600)
FACTOR = 200.0
DEVICES = ("table-3458a", "esp301-daq", "zaber-daq")
LOOK_S, LONGEST_S = 0.002, 10.0


@dataclass
class Served:
    """The campaign on devices that live in this process, behind ports."""

    bench: Bench
    rig: SimulatedRig
    whole_s: float

    def is_moving(self) -> bool:
        now_s = SystemClock().monotonic_s() * FACTOR
        return any(body.rate_dps(now_s) != 0.0 for body in self.rig.world.axes.values())

    def while_moving(self, delay_s: float) -> Aim:
        """SIGKILL as soon as, after the delay, an axis is on its way."""

        def aim(child: int) -> None:
            clock = SystemClock()
            clock.sleep(delay_s)
            limit_s = clock.monotonic_s() + LONGEST_S
            while not self.is_moving() and clock.monotonic_s() < limit_s:
                clock.sleep(LOOK_S)
            os.kill(child, signal.SIGKILL)

        return aim


@contextmanager
def serve(bench: Bench) -> Iterator[Served]:
    folder = bench.folder / "served"
    folder.mkdir()
    with serve_rig(bench.rig, ScaledClock(FACTOR)) as rig:
        described = write_rig(bench.folder / "rig.toml", rig.addresses, FACTOR, folder / "rig.toml")
        shutil.copy(bench.folder / "procedure.toml", folder)
        plan = make_plan(described, read_procedure(folder / "procedure.toml"))
        served = Served(Bench(folder, described, plan), rig, 0.0)
        began_s = SystemClock().monotonic_s()
        assert served.bench.run(folder / "whole").state is State.FINISHED
        served.whole_s = SystemClock().monotonic_s() - began_s
        yield served


def _kill_over_ports(folder: Path, devices: str, kills: int, seed: int) -> None:
    """One run, killed as often as told while an axis moves, then left to finish."""
    chance, run_dir = np.random.default_rng(seed), folder / "run"
    in_memory = Target.of(device_set(devices, folder, SHORTER), folder)
    with serve(in_memory.bench) as served:
        aim = served.while_moving(chance.uniform(0.3, 0.7) * served.whole_s)
        ended = run_child(lambda seen: served.bench.run(run_dir, observer=seen), None, aim)
        dwells: list[DwellRecord] = []
        killed = int(ended.was_killed)
        while status(run_dir).state is not State.FINISHED:
            dwells = require_kept(run_dir, ended.acknowledged, dwells)
            aim = served.while_moving(chance.uniform(0.0, 0.6) * served.whole_s) if killed < kills else _spared
            ended = run_child(lambda seen: resume(run_dir, "tester", "after the kill", seen), None, aim)
            killed += ended.was_killed
    in_memory.require_the_clean_result(run_dir)


def _spared(child: int) -> None:
    return None


@pytest.mark.parametrize("devices", DEVICES[::2])
@pytest.mark.thorough
def test_fault_01_devices_that_outlive_the_process_are_found_as_they_are(tmp_path: Path, devices: str) -> None:
    _kill_over_ports(tmp_path, devices, kills=2, seed=1)


@pytest.mark.soak
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("devices", DEVICES)
def test_fault_01_devices_that_outlive_fifty_kills_are_found_as_they_are(tmp_path: Path, devices: str) -> None:
    for number in range(5):
        (tmp_path / str(number)).mkdir()
        _kill_over_ports(tmp_path / str(number), devices, kills=10, seed=number)
