"""``calrig jog --stop`` over real ports with one of them dead: all axes that can be reached are stopped."""

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from command import call
from turning_rig import STAGE_FOR_ROLL, served

from rig.assembly.simulate import SimulatedRig
from rig.clock import SystemClock
from rig.description.read import read_rig

CLOCK = SystemClock()


@pytest.fixture
def left_turning(tmp_path: Path) -> Iterator[tuple[SimulatedRig, Path]]:
    """Roll turns by bytes of another program, as a dead process leaves it; nobody guards it."""
    with served(tmp_path, CLOCK, STAGE_FOR_ROLL) as (simulated, rig_file):
        host, port = read_rig(rig_file).axes["roll"].port.removeprefix("socket://").rsplit(":", 1)
        with socket.create_connection((host, int(port)), timeout=10.0) as other:
            other.sendall(b"/1 1 move vel 16384\n")
            other.recv(100)
        assert simulated.world.axes["roll"].rate_dps(CLOCK.monotonic_s()) > 0.0
        yield simulated, rig_file


@pytest.mark.parametrize("dead", ["readouts.dmm", "environment.air", "axes.pitch"])
def test_a_device_whose_port_is_dead_keeps_no_axis_of_another_line_from_its_stop(
    left_turning: tuple[SimulatedRig, Path], capsys: pytest.CaptureFixture[str], dead: str
) -> None:
    simulated, rig_file = left_turning
    with socket.create_server(("127.0.0.1", 0)) as gone:
        unused = f"socket://127.0.0.1:{gone.getsockname()[1]}"
    address = simulated.addresses[dead].removeprefix("prologix+").partition("#")[0]
    text = rig_file.read_text(encoding="utf-8")
    assert address in text
    rig_file.write_text(text.replace(address, unused), encoding="utf-8")
    outcome = call(capsys, "jog", "--rig", rig_file, "--stop")
    assert simulated.world.axes["roll"].rate_dps(CLOCK.monotonic_s()) == 0.0
    assert "roll: stands still at +" in outcome.out + outcome.err
    assert outcome.status == (1 if dead == "axes.pitch" else 0)
    assert ("axes.pitch at socket://" in outcome.err) == (dead == "axes.pitch")
