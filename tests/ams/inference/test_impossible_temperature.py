"""A temperature that no sensor stands corrects no angle: it is taken as missing, and the row says so."""

import numpy as np
import pytest
from foreign_sets import bending
from solved_sets import gyro_set, tp_set

from ams.arrays import FloatArray
from ams.attitude import flag_codes
from ams.inference.gyros.aided_rates import AidedAngles, Aiding
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.rates import Motion
from ams.inference.inference import Inference, Package
from ams.inference.rows.averaged import AveragedAngles
from ams.inference.watch.frozen_outputs import FrozenOutputs
from ams.sets.apply import apply

WORDS = "temperature that no sensor stands: taken as missing"
PITCH_DEG, ROLL_DEG, WARM_DEGC, ROWS = 10.0, 15.0, 30.0, 40


def read_at_rest(column: str = "{}_v") -> dict[str, FloatArray]:
    outputs = apply(bending(), np.deg2rad(PITCH_DEG), np.deg2rad(ROLL_DEG), WARM_DEGC)
    return {column.format(axis): np.full(ROWS, outputs[axis]) for axis in "xyz"}


def temperatures(read_degc: float, at: int = 7) -> FloatArray:
    return np.where(np.arange(ROWS) == at, read_degc, WARM_DEGC)


@pytest.mark.parametrize("read_degc", [303.15, 850.0, -273.0])
def test_an_average_leaves_it_out_and_says_so(read_degc: float) -> None:
    inference = Inference(Package(bending(), {axis: f"{axis}_v" for axis in "xyz"}), reading_sd_v=1e-5)
    stream = FrozenOutputs(AveragedAngles(inference, 10.0, 1.0), {})
    found = stream.answer({**read_at_rest(), "temperature_degc": temperatures(read_degc)})
    assert found.columns["pitch_deg"] == pytest.approx(PITCH_DEG, abs=1e-8)
    assert [WORDS in flag for flag in found.flags] == [True, False, False, False]
    (doubt,) = stream.doubts()
    assert f"1 row has one that no sensor stands ({read_degc:.4g} °C, allowed −100 to 200 °C" in doubt
    assert ("kelvin" in doubt) == (read_degc == 303.15)


def test_gravity_of_that_row_corrects_no_gyro() -> None:
    """The row is as one without any force."""
    force_v = {axis: f"f{axis}_v" for axis in "xyz"}
    gyro_v = {axis: f"g{axis}_v" for axis in "xyz"}
    gyros = {gyro_v[axis]: np.full(ROWS, numbers.primary["offset_v"]) for axis, numbers in gyro_set().axes.items()}
    readings = {**read_at_rest("f{}_v"), **gyros}

    def answered(temperature_degc: FloatArray):
        aiding = Aiding(0.005, 1e-6)
        angles = AidedAngles(GyroPackage(gyro_set(), gyro_v, 0.02), Package(bending(), force_v), Motion(20.0), aiding)
        return angles.answer({**readings, "temperature_degc": temperature_degc})

    wild, missing = answered(temperatures(850.0)), answered(temperatures(np.nan))
    for name, values in wild.columns.items():
        np.testing.assert_array_equal(values, missing.columns[name])
    assert [row for row, flag in enumerate(wild.flags) if WORDS in flag] == [7]


def test_a_set_that_needs_none_keeps_its_angle_beside_the_flag() -> None:
    inference = Inference(Package(tp_set(), {axis: f"{axis}_v" for axis in "xyz"}), reading_sd_v=1e-5)
    readings = {f"{axis}_v": np.full(2, numbers.primary["offset_v"]) for axis, numbers in tp_set().axes.items()}
    readings = {name: values - (2.5 if name == "z_v" else 0.0) for name, values in readings.items()}
    cold, wild = (inference.answer({**readings, "temperature_degc": np.array([20.0, read])}) for read in (20.0, 850.0))
    assert np.isfinite(wild.columns["pitch_deg"]).all()
    np.testing.assert_array_equal(wild.columns["pitch_deg"], cold.columns["pitch_deg"])
    assert (wild.codes ^ cold.codes).tolist() == [0, flag_codes.IMPOSSIBLE_TEMPERATURE]
