"""An output that no sensor gives and no meter reads is a missing reading: what the other rows say is not touched."""

import warnings

import numpy as np
import pytest
from solved_sets import tp_set

from ams.arrays import FloatArray
from ams.attitude import flag_codes
from ams.inference.inference import Inference, Package
from ams.inference.rows.angle_stream import Answer
from ams.inference.rows.averaged import AveragedAngles
from ams.inference.rows.possible_rows import possible_readings
from ams.inference.watch.faulty_axis import Cause
from ams.inference.watch.frozen_outputs import FrozenOutputs
from ams.inference.watch.watched_axes import WatchedAxes, answered_at_once
from ams.sets.apply import apply

ROWS, AT, SD_V = 60, 20, 3e-5
COLUMNS = {axis: f"{axis}_v" for axis in "xyz"}
WILD = [9.9e37, -9.9e37, 9.91e37, 1e6, -60.0]
WORDS = "overload: taken as missing"


def _read(z_gain: float) -> dict[str, FloatArray]:
    pitch, roll, chance = np.linspace(-30.0, 30.0, ROWS), np.linspace(-100.0, 100.0, ROWS), np.random.default_rng(1)
    outputs = apply(tp_set(), np.deg2rad(pitch), np.deg2rad(roll))
    read = {f"{axis}_v": outputs[axis] + SD_V * chance.standard_normal(ROWS) for axis in "xyz"}
    return {**read, "z_v": z_gain * read["z_v"]}


def _inference() -> Inference:
    return Inference(Package(tp_set(), COLUMNS), reading_sd_v=SD_V)


def _without(values: FloatArray) -> FloatArray:
    return np.delete(values, AT)


def _assert_the_others_are_as_without(found: Answer, without: Answer) -> None:
    for name, values in found.columns.items():
        assert np.isnan(values[AT])
        np.testing.assert_array_equal(_without(values), without.columns[name])
    flags = list(found.flags)
    assert WORDS in flags.pop(AT)
    assert flags == list(without.flags)


@pytest.mark.parametrize("wild_v", WILD)
@pytest.mark.parametrize("z_gain", [1.0, 0.98])
@pytest.mark.parametrize("axis", "xz")
def test_a_row_with_one_changes_no_other_row(wild_v: float, z_gain: float, axis: str) -> None:
    """With z 2 % low every row is wrong, and told to be, with that cell as without."""
    read = _read(z_gain)
    wild = {**read, f"{axis}_v": np.where(np.arange(ROWS) == AT, wild_v, read[f"{axis}_v"])}
    cut = {name: _without(values) for name, values in read.items()}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        _assert_the_others_are_as_without(answered_at_once(_inference(), wild), answered_at_once(_inference(), cut))
    assert all(answered_at_once(_inference(), cut).flags) == (z_gain != 1.0)


@pytest.mark.parametrize("wild_v", WILD)
def test_an_average_leaves_it_out_and_says_so(wild_v: float) -> None:
    package = Package(tp_set(), COLUMNS)
    stream = FrozenOutputs(AveragedAngles(_inference(), 10.0, 1.0), {}, packages=[package])
    rested = {name: np.full(ROWS, values[0]) for name, values in _read(1.0).items()}
    found = stream.answer({**rested, "x_v": np.where(np.arange(ROWS) == AT, wild_v, rested["x_v"])})
    assert np.ptp(found.columns["pitch_deg"]) < 1e-9
    assert [WORDS in flag for flag in found.flags] == [False, False, True, False, False, False]
    (doubt,) = stream.doubts()
    assert doubt.startswith(f"x_v: 1 row has an output that none gives: taken as missing; {wild_v:g} is the code") or (
        doubt.startswith(f"x_v: 1 row has an output that none gives: taken as missing; got {wild_v:g} V, allowed -50")
    )


def test_the_largest_output_of_a_sensor_and_what_is_no_number_are_left_alone() -> None:
    read = {**_read(1.0), "x_v": np.where(np.arange(ROWS) == AT, np.nan, 15.0)}
    assert possible_readings(read, [Package(tp_set(), COLUMNS)]) is read
    assert not np.any(_inference().answer(read).codes.astype(np.uint64) & np.uint64(flag_codes.OVERLOAD))


@pytest.mark.parametrize("spikes", [1, 2])
def test_an_axis_stands_at_no_value_of_one_row(spikes: int) -> None:
    """A spike that a sensor could give, in few rows: these are flagged, and no axis is said to stand anywhere."""
    read = _read(1.0)
    read["z_v"][AT : AT + spikes] = 7.0 + np.arange(spikes)
    watched = WatchedAxes(_inference())
    found = watched.answer(read)
    watched.finish()
    assert np.flatnonzero(found.codes).tolist() == list(range(AT, AT + spikes))
    (judgement,) = watched.judged().judgements
    assert judgement.cause is Cause.UNEXPLAINED
