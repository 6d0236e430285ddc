"""Real processes, their stop guard between them: an order that its line holds back is stopped, and told to be in doubt.

The line lets what follows overtake it, as some gateways do, and delivers it when no process is alive.
"""

import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from guarded_engine import CLOCK, until
from recording_proxy import RecordingProxy
from small_run import PROCEDURE, RIG
from unattended_run import events

from rig.assembly.simulate import SimulatedRig, serve_rig, write_rig
from rig.description.read import read_rig
from rig.link.faults import Part

BEGIN_S, TURNS_S = 90.0, 10.0
COMMAND = [sys.executable, "-m", "procedures.cli.start"]


class _HoldsAnOrder:
    """Holds the first order to move the roll axis back."""

    def __init__(self, machine: tuple[str, int]) -> None:
        self._machine = machine
        self.held = b""

    def on_write(self, data: bytes) -> tuple[Part, ...]:
        if self.held or b"2 MOVE" not in data:
            return (Part(data),)
        self.held = data
        return ()

    def on_read(self, data: bytes) -> tuple[Part, ...]:
        return (Part(data),)

    def deliver(self) -> None:
        """Who holds it is on the machine's line, whoever else is."""
        with socket.create_connection(self._machine) as line:
            line.sendall(self.held)
            line.recv(64)


@contextmanager
def _held(folder: Path) -> Iterator[tuple[SimulatedRig, _HoldsAnOrder, Path]]:
    """Serve the small rig with such a line to its table; yields also the file of the rig."""
    original = folder / "twins.toml"
    original.write_text(RIG, encoding="utf-8")
    with serve_rig(read_rig(original), CLOCK) as simulated:
        host, _, port = simulated.addresses["axes.pitch"].removeprefix("socket://").rpartition(":")
        line, hold = RecordingProxy((host, int(port))), _HoldsAnOrder((host, int(port)))
        line.faults = hold
        addresses = {**simulated.addresses, "axes.pitch": line.address, "axes.roll": line.address}
        try:
            write_rig(original, addresses, "real", folder / "rig.toml")
            yield simulated, hold, folder / "rig.toml"
        finally:
            line.close()


def _roll_deg(simulated: SimulatedRig) -> float:
    return simulated.world.attitude_deg("roll", CLOCK.monotonic_s())


def _calrig(*words: object) -> "subprocess.CompletedProcess[str]":
    return subprocess.run([*COMMAND, *map(str, words)], capture_output=True, text=True, timeout=BEGIN_S, check=False)


def _ended(words: list[object], hold: _HoldsAnOrder, stop: list[object]) -> tuple[int, str]:
    """Run a command until its order is held and it was stopped from another process; its status and what it said."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    with subprocess.Popen([*COMMAND, *map(str, words)], text=True, **pipes) as process:  # type: ignore[call-overload]
        try:
            assert until(lambda: bool(hold.held), BEGIN_S)
            assert _calrig(*stop).returncode == 0
            said, _ = process.communicate(timeout=BEGIN_S)
        finally:
            process.kill()
    return process.returncode, said


def test_fault_30_a_jog_that_is_stopped_names_the_order_that_nobody_answered(tmp_path: Path) -> None:
    with _held(tmp_path) as (simulated, hold, rig_file):
        assert _calrig("jog", "--rig", rig_file, "--axis", "roll", "--home").returncode == 0
        words = ["jog", "--rig", rig_file, "--axis", "roll", "--to", 90]
        status, said = _ended(words, hold, ["jog", "--rig", rig_file, "--stop"])
        assert _roll_deg(simulated) == 0.0
        hold.deliver()
        assert until(lambda: _roll_deg(simulated) > 45.0, TURNS_S), "nothing came late"
    assert status == 1
    assert "roll: the order to move to 90° of " in said
    assert "was neither acknowledged nor seen to be taken up, and may still come; no stop ends that for certain" in said


def test_fault_30_a_run_that_is_aborted_names_the_order_that_nobody_answered(tmp_path: Path) -> None:
    (tmp_path / "procedure.toml").write_text(PROCEDURE, encoding="utf-8")
    runs = tmp_path / "runs"
    with _held(tmp_path) as (simulated, hold, rig_file):
        words = ["run", tmp_path / "procedure.toml", "--rig", rig_file, "--out", runs]
        status, said = _ended(words, hold, ["abort", "--out", runs, "--operator", "ann"])
        stood_deg = _roll_deg(simulated)
        hold.deliver()
        assert until(lambda: abs(_roll_deg(simulated) - stood_deg) > 10.0, TURNS_S), "nothing came late"
    (run_dir,) = (path for path in runs.iterdir() if path.is_dir())
    assert status == 3, said
    (doubt,) = events(run_dir, "safe")[-1].detail["in_doubt"]  # type: ignore[misc]
    assert doubt.startswith("roll: the order to move to ")
    state = events(run_dir, "state")[-1].detail
    assert (state["to"], state["by"], state["cause"]) == ("tripped", "ann", "order in doubt")
    assert doubt in _calrig("handover", run_dir).stdout
    assert doubt in (run_dir / "why.txt").read_text(encoding="utf-8")
