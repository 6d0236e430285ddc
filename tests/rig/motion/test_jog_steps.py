"""Laws of steps: only what the axis can do, never none."""

from pathlib import Path

import pytest
from table_bench import example_rig, rig_file, table_bench
from turning_rig import SERVO_FOR_PITCH, STAGE_FOR_ROLL

from rig.assembly.open_rig import open_rig
from rig.description.read import read_rig
from rig.motion.jog_steps import nearest_step_deg, steps_deg


def test_an_indexing_table_steps_by_its_teeth() -> None:
    bench, settings = table_bench(), example_rig().axes["pitch"]
    assert steps_deg(bench.pitch, settings) == (1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 90.0)


def test_teeth_that_fit_no_round_step_are_steps_themselves() -> None:
    bench = table_bench(increment_deg=0.7, limits_deg=(-6.3, 6.3))
    assert steps_deg(bench.pitch, example_rig().axes["pitch"].model_copy(update={"increment_deg": 0.7})) == (0.7,)


def test_a_stage_steps_by_what_it_resolves_and_tells_from_standing_still(tmp_path: Path) -> None:
    with open_rig(read_rig(rig_file(tmp_path, STAGE_FOR_ROLL, SERVO_FOR_PITCH))) as rig:
        settings = rig.description.axes
        assert steps_deg(rig.axes["roll"], settings["roll"])[0] == 0.005  # arrives within 0.001 deg
        fine = settings["roll"].model_copy(update={"microstep_deg": 1e-5})
        rig.axes["roll"].arrival_tolerance_deg = 2e-5
        assert steps_deg(rig.axes["roll"], fine)[0] == 0.0001
        servo = steps_deg(rig.axes["pitch"], settings["pitch"])
        assert (servo[0], servo[-1]) == (0.05, 45.0)  # a quarter µs is 0.0225 deg; 88 deg between the limits


@pytest.mark.parametrize(("wanted", "found"), [(1.0, 1.0), (3.0, 2.0), (0.1, 1.0), (500.0, 5.0)])
def test_a_step_is_taken_over_to_another_axis_as_near_as_it_can(wanted: float, found: float) -> None:
    assert nearest_step_deg((1.0, 2.0, 5.0), wanted) == found
