"""What the bench infers rests on no position that nobody knows."""

from pathlib import Path
from typing import cast

import pytest
from small_run import bench

from procedures.jog_screen.guard import Guard
from procedures.jog_screen.inferred import InferredAttitude
from procedures.jog_screen.polling import Polling
from rig.assembly.open_rig import open_rig
from rig.motion.move import home_and_arrive

TABLE = 'driver = "indexing-table"\nport = "twin"\nincrement_deg = 1.0\n'
SERVO = (
    'driver = "maestro"\nport = "twin"\narrival_tolerance_deg = 0.2\n'
    "points = [[500.0, -180.0], [2500.0, 180.0]]\npulse_limits_us = [500.0, 2500.0]\n"
)


@pytest.mark.parametrize("is_homed", [True, False])
def test_a_servo_without_a_pulse_gives_no_roll_to_what_is_inferred(tmp_path: Path, *, is_homed: bool) -> None:
    seen: list[float | None] = []

    class Inferred:
        def view(self, _means_v: object, _temperature_degc: object, roll_deg: float | None) -> None:
            seen.append(roll_deg)

    with open_rig(bench(tmp_path, rig=((TABLE, SERVO),)).rig) as rig:
        if is_homed:
            home_and_arrive(rig.axes["roll"], rig.clock, rig.clock.sleep)
        inferred = cast("InferredAttitude", Inferred())
        polling = Polling(rig, cast("Guard", None), rig.clock, inferred, lambda _: None)
        polling.round(rig.clock.sleep)
    assert seen == [pytest.approx(0.0, abs=0.2) if is_homed else None]
