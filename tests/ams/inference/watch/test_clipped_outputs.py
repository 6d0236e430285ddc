"""An output at its rail is taken as missing and told; one that comes to the same number rightly is not.

A rail cuts what the sensor and its noise give, before or after it is read in steps. Motions and noise are made here.
"""

from collections.abc import Callable, Mapping

import numpy as np
import pytest

from ams.arrays import FloatArray
from ams.attitude import flag_codes
from ams.inference.rows.angle_stream import Answer
from ams.inference.watch.clipped_outputs import NO_RAILS, Rails
from ams.inference.watch.frozen_outputs import FrozenOutputs

SD_V, ROWS = 2e-5, 600
ADC_24_V, ADC_16_V = 20.0 / 2**24, 20.0 / 2**16
Motion = Callable[[np.ndarray, np.random.Generator], np.ndarray]


def _any_attitude(row: np.ndarray, chance: np.random.Generator, most_deg: float = 80.0) -> np.ndarray:
    return 2.5 * np.sin(np.radians(chance.uniform(-most_deg, most_deg, row.size)))


MOVED: dict[str, Motion] = {
    "any attitude": _any_attitude,
    "swept": lambda row, _: 1.77 * np.sin(row / 9.6),
    "swept fast": lambda row, _: 1.77 * np.sin(row / 1.16),
    "whole periods": lambda row, _: 1.77 * np.sin(2.0 * np.pi * row / 60.0),
}
CLEAN: dict[str, Motion] = MOVED | {
    "whole short periods": lambda row, _: 1.77 * np.sin(2.0 * np.pi * row / 20.0),
    "ramp": lambda row, _: 2.5 * np.sin(np.radians(100.0 * row / row.size - 50.0)),
    "slow ramp": lambda row, _: 0.3 + 1e-6 * row,
    "ramp to a stop": lambda row, _: np.minimum(3.75 * row / row.size - 1.5, 0.9),
    "rest": lambda row, _: np.full(row.size, 0.7),
    "between two stops": lambda row, _: np.where(row // 50 % 2, 1.2, -0.9),
    "between two stops, fast": lambda row, _: np.where(row // 10 % 2, 1.2, -0.9),
    "steps": lambda row, _: 2.5 * np.sin(np.radians(160.0 * (row // 12) / (row.size / 12.0) - 80.0)),
    "grid": lambda row, _: 2.5 * np.sin(np.radians(10.0 * (row % 17) - 80.0)),
}


class Seen:
    """Answers with the readings that it was given."""

    optional, answers_at_once = (), True

    def __init__(self, columns: tuple[str, ...]) -> None:
        self.needed = self.answers = columns

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        return Answer(dict(readings), np.zeros(readings["x_v"].size, dtype=np.uint32))

    def finish(self) -> Answer:
        return self.answer({name: np.empty(0) for name in self.needed})


def _read(motion: Motion, chance: np.random.Generator, step: float, sd: float = SD_V, rows: int = ROWS) -> np.ndarray:
    read = motion(np.arange(rows), chance) + sd * chance.standard_normal(rows)
    return np.asarray(step * np.rint(read / step))


def _beside(chance: np.random.Generator, rows: int = ROWS) -> np.ndarray:
    return 0.3 * np.sin(np.arange(rows) / 17.0) + SD_V * chance.standard_normal(rows)


def _answered(
    readings: Mapping[str, np.ndarray], sd: float = SD_V, pieces: int = 1, rails: Rails = NO_RAILS
) -> tuple[FrozenOutputs, np.ndarray]:
    """Return what looked after the outputs, and which rows it says are clipped: the missing ones."""
    columns = tuple(readings)
    stream = FrozenOutputs(Seen(columns), dict.fromkeys(columns, sd), untested=columns, rails=rails)
    parts = np.array_split(np.arange(readings["x_v"].size), pieces)
    found = [stream.answer({name: values[part] for name, values in readings.items()}) for part in parts]
    stream.finish()
    codes = np.concatenate([answer.codes for answer in found])
    is_missing = np.concatenate([np.isnan(np.stack(list(answer.columns.values()))).any(axis=0) for answer in found])
    is_clipped = (codes & np.uint64(flag_codes.CLIPPED)) != 0
    assert np.array_equal(is_missing, codes != 0)
    return stream, np.asarray(is_clipped)


def _clipped(read: np.ndarray, rows: int, side: float) -> np.ndarray:
    """Return readings of which so many are at a rail."""
    return np.asarray(side * np.minimum(side * read, np.sort(side * read)[-rows]))


@pytest.mark.parametrize("motion", MOVED)
@pytest.mark.parametrize("step", [1e-7, 1e-6, ADC_24_V])
@pytest.mark.parametrize("rows", [12, 20, 200])
@pytest.mark.parametrize("axes", ["x", "xy"])
def test_rows_at_a_rail_are_taken_as_missing_and_no_others(motion: str, step: float, rows: int, axes: str) -> None:
    for seed, side in ((1, 1.0), (2, -1.0), (3, 1.0)):
        chance = np.random.default_rng(seed)
        read = _clipped(_read(MOVED[motion], chance, step), rows, side)
        stream, is_clipped = _answered({"x_v": read} | ({"y_v": _beside(chance)} if axes == "xy" else {}))
        assert np.array_equal(is_clipped, side * read == (side * read).max())
        assert np.count_nonzero(is_clipped) >= rows
        (said,) = stream.doubts()
        assert f"in {np.count_nonzero(is_clipped)} rows, its {'highest' if side > 0.0 else 'lowest'} number" in said
        assert said.endswith("they are taken as missing")


@pytest.mark.parametrize("motion", ["swept fast", "any attitude"])
def test_both_rails_are_told(motion: str) -> None:
    chance = np.random.default_rng(4)
    read = np.clip(_read(MOVED[motion], chance, 1e-6), -1.5, 1.5)
    stream, is_clipped = _answered({"x_v": read, "y_v": _beside(chance)})
    assert np.array_equal(is_clipped, np.abs(read) == 1.5)
    assert stream.clipped.rails() == {"x_v": [1.5, -1.5]}
    assert len(stream.doubts()) == 2


@pytest.mark.parametrize("motion", MOVED)
@pytest.mark.parametrize("rows", [1, 2, 3])
def test_so_few_rows_at_an_end_prove_nothing(motion: str, rows: int) -> None:
    chance = np.random.default_rng(5)
    stream, is_clipped = _answered({"x_v": _clipped(_read(MOVED[motion], chance, 1e-6), rows, 1.0)})
    assert not is_clipped.any()
    assert not stream.doubts()


@pytest.mark.parametrize("motion", MOVED)
def test_five_rows_at_a_rail_are_flagged_or_named(motion: str) -> None:
    for seed in range(4):
        chance, sd = np.random.default_rng(seed), 2e-4
        read = _clipped(_read(MOVED[motion], chance, 1e-6, sd), 5, 1.0)
        stream, is_clipped = _answered({"x_v": read}, sd)
        assert is_clipped[read == read.max()].all() or not is_clipped.any()
        (said,) = stream.doubts()
        assert f"in {np.count_nonzero(read == read.max())} rows, its highest number" in said


@pytest.mark.parametrize("motion", CLEAN)
@pytest.mark.parametrize("sd", [0.0, 0.1 * SD_V, SD_V])
def test_no_clean_output_is_clipped(motion: str, sd: float) -> None:
    """At all steps from far finer to far wider than the noise, which is stated too large in most: 1 638 files.

    One that rests at its end alone, with no noise that shows, is named: no row tells it from a clipped one.
    """
    for step in (1e-9, 1e-7, 1e-6, ADC_24_V, 1e-5, 1e-4, ADC_16_V):
        for seed in range(6):
            chance = np.random.default_rng(seed)
            read = {"x_v": _read(CLEAN[motion], chance, step, sd, 240)}
            read |= {"y_v": _beside(chance, 240)} if seed % 2 else {}
            stream, is_clipped = _answered(read, pieces=7 if seed % 3 == 0 else 1)
            assert not is_clipped.any()
            is_named = any(" number, " in doubt for doubt in stream.doubts())
            assert not is_named or motion == "ramp to a stop"


def test_an_attitude_without_noise_that_all_outputs_come_back_to_is_no_rail() -> None:
    """Both read the same in the same attitude; of one alone the same numbers are a rail."""
    chance = np.random.default_rng(7)
    read = {name: _any_attitude(np.arange(ROWS), chance, 55.0) for name in ("x_v", "y_v")}
    for name, values in read.items():
        values[::10] = 2.1 if name == "x_v" else 0.4
    assert not _answered(read)[1].any()
    assert np.count_nonzero(_answered({"x_v": read["x_v"]})[1]) == ROWS / 10


@pytest.mark.parametrize("step", [1e-4, ADC_16_V])
def test_what_a_coarse_meter_cannot_tell_is_named_and_not_flagged(step: float) -> None:
    chance = np.random.default_rng(8)
    read = np.minimum(_read(MOVED["any attitude"], chance, step), step * np.rint(1.5 / step))
    stream, is_clipped = _answered({"x_v": read})
    assert not is_clipped.any()
    (said,) = stream.doubts()
    assert f"in {np.count_nonzero(read == read.max())} rows, its highest number" in said
    assert "these rows do not tell which and have no flag" in said


def test_a_stream_says_how_many_rows_it_answered_before_and_a_second_reading_flags_them() -> None:
    chance = np.random.default_rng(9)
    read = {"x_v": np.minimum(_read(MOVED["swept"], chance, 1e-6), 1.5), "y_v": _beside(chance)}
    at_rail = read["x_v"] == 1.5
    stream, is_clipped = _answered(read, pieces=ROWS)
    before = np.count_nonzero(at_rail & ~is_clipped)
    assert 0 < before < 60
    assert is_clipped[np.flatnonzero(at_rail)[before] :][at_rail[np.flatnonzero(at_rail)[before] :]].all()
    assert f"{before} of them were answered before that was known and have no flag" in stream.doubts()[0]
    assert stream.clipped.has_unflagged()
    again, is_clipped = _answered(read, pieces=ROWS, rails=stream.clipped.rails())
    assert np.array_equal(is_clipped, at_rail)
    assert not again.clipped.has_unflagged()


def test_a_higher_number_disproves_a_rail() -> None:
    chance = np.random.default_rng(10)
    read = np.minimum(_read(MOVED["swept"], chance, 1e-6), 1.5)
    read[-1] = 1.6
    stream, _ = _answered({"x_v": read}, pieces=10)
    assert stream.clipped.rails() == {}


def test_missing_readings_are_no_end() -> None:
    chance = np.random.default_rng(11)
    read = _clipped(_read(MOVED["swept"], chance, 1e-6), 100, 1.0)
    at_rail = read == read.max()
    read[::7] = np.nan
    _, is_clipped = _answered_with_gaps(read)
    assert np.array_equal(is_clipped, at_rail & np.isfinite(read))


def _answered_with_gaps(read: np.ndarray) -> tuple[FrozenOutputs, np.ndarray]:
    stream = FrozenOutputs(Seen(("x_v",)), {"x_v": SD_V}, untested=("x_v",))
    stream.answer({"x_v": np.full(5, np.nan)})
    codes = stream.answer({"x_v": read}).codes
    return stream, (codes & np.uint64(flag_codes.CLIPPED)) != 0
