"""``calrig jog`` with two servos of one Maestro on a port whose line alters what they are told."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from command import call
from struck_jogs import JogBench, bench_with
from turning_rig import SERVO_FOR_PITCH

from rig.link.faults import Part
from rig.wire.maestro import SET_TARGET

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
