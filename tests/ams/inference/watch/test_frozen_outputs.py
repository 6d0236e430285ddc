"""An output that hangs is taken as missing and told; a coarse meter at rest, which repeats itself rightly, is not."""

from collections.abc import Callable, Mapping

import numpy as np
import pytest

from ams.arrays import FloatArray
from ams.attitude import flag_codes
from ams.inference.rows.angle_stream import Answer
from ams.inference.watch.frozen_outputs import FrozenOutputs
from ams.inference.watch.seen_output import LEAST_REPEATS

SD = 1e-5
ROWS = 2000
COLUMNS = ("x_v", "y_v", "z_v")


class Seen:
    """Answers with the readings that it was given."""

    needed, optional, answers, answers_at_once = COLUMNS, (), (*COLUMNS, "flag"), True

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        return Answer(dict(readings), np.zeros(readings["x_v"].size, dtype=np.uint32))

    def finish(self) -> Answer:
        return self.answer({name: np.empty(0) for name in COLUMNS})


def _readings(step: float, seed: int = 1, sd: float = SD) -> dict[str, FloatArray]:
    """Return outputs of a package that moves, then rests, read in steps."""
    chance, time = np.random.default_rng(seed), np.arange(ROWS)
    swing = np.where(time < ROWS // 2, np.sin(time / 50.0), np.sin(ROWS / 100.0))
    return {name: step * np.rint((swing + sd * chance.standard_normal(ROWS)) / step) for name in COLUMNS}


def _frozen(readings: Mapping[str, FloatArray], pieces: int) -> np.ndarray:
    stream = FrozenOutputs(Seen(), dict.fromkeys(COLUMNS, SD))
    parts = np.array_split(np.arange(ROWS), pieces)
    found = [stream.answer({name: values[part] for name, values in readings.items()}) for part in parts]
    stream.finish()
    codes = np.concatenate([answer.codes for answer in found])
    is_missing = np.concatenate([np.isnan(np.stack(list(answer.columns.values()))).any(axis=0) for answer in found])
    assert np.array_equal(is_missing, codes == flag_codes.FROZEN)
    return np.asarray(is_missing)


@pytest.mark.parametrize("step", [1e-9, 2e-6])
@pytest.mark.parametrize("begins", [0, 300, 1500])
def test_an_output_that_hangs_is_taken_as_missing(step: float, begins: int) -> None:
    readings = _readings(step)
    readings["y_v"][begins : begins + 400] = readings["y_v"][begins]
    is_frozen = _frozen(readings, 1)
    assert is_frozen[begins + 1 : begins + 400].all()
    assert is_frozen.sum() <= 400


def test_in_a_stream_it_is_known_after_some_repeats() -> None:
    readings = _readings(1e-9)
    readings["y_v"][1500:1900] = readings["y_v"][1500]
    is_frozen = _frozen(readings, ROWS // 10)
    assert is_frozen[1500 + LEAST_REPEATS + 10 : 1900].all()
    assert not is_frozen[:1500].any()


@pytest.mark.parametrize("step", [1e-9, 2e-6, 1e-5, 2e-5, 1e-4, 1e-3])
@pytest.mark.parametrize("pieces", [1, 20, 200])
def test_an_output_that_repeats_by_its_step_is_not(step: float, pieces: int) -> None:
    """The package rests in the second half: at a step of ten standard deviations it repeats one number for long."""
    for seed in range(5):
        assert not _frozen(_readings(step, seed), pieces).any()


def test_a_package_at_rest_without_noise_is_not() -> None:
    readings = {name: np.full(ROWS, 0.5) for name in COLUMNS}
    assert not _frozen(readings, 1).any()


MOTIONS: dict[str, tuple[int, Callable[[np.ndarray], np.ndarray]]] = {
    "slow ramp": (1200, lambda row: 2.5 * np.sin(np.radians(0.003 * row - 30.0))),
    "ramp": (1200, lambda row: 2.5 * np.sin(np.radians(0.01 * row - 30.0))),
    "fast ramp": (1200, lambda row: 2.5 * np.sin(np.radians(0.05 * row - 30.0))),
    "short sweep": (600, lambda row: 2.5 * np.sin(np.radians(35.0 * np.sin(row / 600.0 * 14.5)))),
    "long sweep": (60_000, lambda row: 2.5 * np.sin(np.radians(35.0 * np.sin(row / 60_000.0 * 14.5)))),
}


def _alone(values: FloatArray, sd: float) -> np.ndarray:
    """Return where an output without others is taken as missing."""
    stream = FrozenOutputs(Seen(), {"x_v": sd})
    answer = stream.answer(dict.fromkeys(COLUMNS, values))
    return np.isnan(answer.columns["x_v"])


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("decimals", [5, 7, 9])
def test_one_output_that_hangs_while_the_package_moves_is_taken_as_missing(motion: str, decimals: int) -> None:
    """Between neighbours lies what the package moved: that is no step of the meter."""
    rows, moved = MOTIONS[motion]
    for seed in range(3):
        chance, sd = np.random.default_rng(seed), 4e-5
        values = np.round(moved(np.arange(rows)) + sd * chance.standard_normal(rows), decimals)
        begin, end = rows // 3, rows // 3 + rows // 5
        values[begin:end] = values[begin]
        is_frozen = _alone(values, sd)
        assert is_frozen[begin + 1 : end].all()
        assert is_frozen.sum() <= end - begin


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("step", [1e-4, 10.0 / 65536.0, 20.0 / 65536.0, 1e-3])
@pytest.mark.parametrize("decimals", [5, 7, 12])
def test_one_coarse_output_at_rest_after_a_motion_is_not(motion: str, step: float, decimals: int) -> None:
    """However its readings are rounded when they are written: all are multiples of a step that is wider than noise."""
    rows, moved = MOTIONS[motion]
    for seed in range(3):
        chance, sd = np.random.default_rng(seed), 2e-5
        at = moved(np.minimum(np.arange(rows), rows // 2)) + sd * chance.standard_normal(rows)
        assert not _alone(np.round(step * np.rint(at / step), decimals), sd).any()


@pytest.mark.parametrize("pieces", [1, 14])
def test_an_output_that_hangs_after_a_rest_about_zero_is_taken_as_missing(pieces: int) -> None:
    """Seven decimals of small numbers are three digits: what hangs far from zero is no less finely written."""
    values = np.round(2e-5 * np.random.default_rng(3).standard_normal(1400), 7)
    values[1000:] = 0.8
    stream = FrozenOutputs(Seen(), {"x_v": 2e-5})
    parts = [stream.answer(dict.fromkeys(COLUMNS, part)) for part in np.split(values, pieces)]
    is_frozen = np.isnan(np.concatenate([part.columns["x_v"] for part in parts]))
    assert is_frozen[1000 + LEAST_REPEATS :].all()
    assert not is_frozen[:1001].any()


def test_a_few_digits_of_any_number_are_wider_far_from_zero() -> None:
    """Six digits end far below 1 µV about zero and at 10 µV above 1 V: there the noise does not show at rest."""
    chance = np.random.default_rng(4)
    at = np.concatenate([np.zeros(1000), np.full(400, 1.23457)])
    values = np.array([float(f"{value:.6g}") for value in at + 2e-6 * chance.standard_normal(1400)])
    stream = FrozenOutputs(Seen(), {"x_v": 2e-6})
    assert np.isfinite(stream.answer(dict.fromkeys(COLUMNS, values)).columns["x_v"]).all()
