"""``calrig jog`` with two servos of one Maestro on a port whose line alters what they are told."""

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from command import call
from struck_jogs import JogBench, bench_with
from turning_rig import SERVO_FOR_PITCH

from rig.link.faults import Part
from rig.wire.maestro import SET_TARGET, set_target

SERVO_FOR_ROLL = (
    SERVO_FOR_PITCH[0].replace("axis = 1", "axis = 2"),
    SERVO_FOR_PITCH[1].replace("axis = 0", "axis = 2"),
)


@pytest.fixture
def servos(tmp_path: Path) -> Iterator[JogBench]:
    with bench_with(tmp_path, "maestro", "pitch", [SERVO_FOR_PITCH, SERVO_FOR_ROLL]) as bench:
        yield bench


class _Altered:
    """Faults of a line on which targets to pitch become something else."""

    def __init__(self, becomes: bytes) -> None:
        self._becomes = becomes

    def on_write(self, data: bytes) -> tuple[Part, ...]:
        return (Part(data.replace(bytes([SET_TARGET, 0]), self._becomes)),)

    def on_read(self, data: bytes) -> tuple[Part, ...]:
        return (Part(data),)


def test_a_servo_without_pulses_that_hears_another_ones_order_is_told_of(
    servos: JogBench, capsys: pytest.CaptureFixture[str]
) -> None:
    servos.bring("--home")
    servos.line.faults = _Altered(bytes([SET_TARGET, 2]))
    outcome = call(capsys, "jog", "--rig", servos.rig_file, "--axis", "pitch", "--to", "-40")
    assert outcome.status == 1
    words = " ".join(outcome.err.split())
    assert "roll: moves, though nothing told it to: where it stood was not known, and it is at -40" in words
    assert servos.here_deg == pytest.approx(0.0, abs=0.05)


def test_a_stop_from_another_terminal_sends_no_target_to_servos_that_stand(servos: JogBench) -> None:
    """As it was measured: each was sent its place, which the line altered; one went beyond its limits, status 0."""
    servos.bring("--home")
    servos.bring("--to", 24)
    servos.line.faults = _Altered(bytes([SET_TARGET, 2]))
    servos.line.heard.clear()
    assert servos.jog("--stop") == 0
    heard = b"".join(data for _, data in servos.line.heard)
    assert heard
    assert SET_TARGET not in heard
    assert servos.here_deg == pytest.approx(24.0, abs=0.1)


def test_a_stop_tells_a_servo_that_stands_outside_its_limits_as_that(
    servos: JogBench, capsys: pytest.CaptureFixture[str]
) -> None:
    """It has no home, and needs none: its pulse says where it is."""
    host, _, port = servos.simulated.addresses["axes.pitch"].removeprefix("socket://").rpartition(":")
    request = set_target(0, 8000)
    with socket.create_connection((host, int(port)), timeout=10.0) as other:
        other.sendall(bytes([request.command, *request.data]))
    servos.clock.sleep(1.0)
    assert servos.here_deg > 45.0
    outcome = call(capsys, "jog", "--rig", servos.rig_file, "--stop")
    assert outcome.status == 1
    words = " ".join((outcome.out + outcome.err).split())
    assert "pitch: stands outside its limits: at 46°, allowed -44 to 44° (axes.pitch: limits_deg)" in words
    assert "roll: no pulse is sent" in words, "the others are told of as well"
