"""A result says where the order of its points hides what comes back with every replication."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from ams.calibration.calibrate import calibrate
from ams.calibration.together.in_step_hidden import SAME_ORDER, hidden_in_words, row_correlation
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

FloatArray = NDArray[np.float64]
PITCH_DEG, ROLL_DEG = np.arange(-75.0, 76.0, 25.0), np.arange(-180.0, 180.0, 45.0)
REPLICATIONS, DWELL_S = 4, 30.0


def _measured(by_chance: bool, wave_v: float = 0.0, jitter_deg: float = 0.0) -> Observations:
    """A three-axis package, roll by roll, pitch there and back; a wave of one period a replication on all outputs.

    ``jitter_deg``: standard deviation of what the axes stand and are read otherwise each time.
    """
    chance = np.random.default_rng(4)
    grid = [
        (pitch, roll) for row, roll in enumerate(ROLL_DEG) for pitch in (PITCH_DEG if row % 2 == 0 else PITCH_DEG[::-1])
    ]
    there_and_back = [*grid[::2], *grid[1::2][::-1]]
    points = {attitude: number for number, attitude in enumerate(there_and_back)}
    rows = []
    for replication in range(REPLICATIONS):
        order = [*there_and_back]
        if by_chance:
            chance.shuffle(order)
        rows += [(replication, points[at], *np.radians(at)) for at in order]
    replication, point, pitch, roll = np.array(rows).T
    pitch, roll = (angle + np.deg2rad(jitter_deg) * chance.normal(size=len(rows)) for angle in (pitch, roll))
    phase = 2.0 * np.pi * (np.arange(len(rows)) % len(grid)) / len(grid)
    force = {"x": -np.sin(pitch), "y": np.cos(pitch) * np.sin(roll), "z": np.cos(pitch) * np.cos(roll)}
    outputs = {
        axis: 2.5 * f + wave_v * np.cos(phase) + 2e-5 * chance.normal(size=len(rows)) for axis, f in force.items()
    }
    return Observations(
        replication=replication.astype(int),
        point=point.astype(int),
        pitch_rad=pitch,
        roll_rad=roll,
        time_s=DWELL_S * np.arange(len(rows)),
        outputs=outputs,
    )


def _hidden(rows: Observations) -> list[str]:
    request = CalibrationRequest(nominal_axes={axis: axis for axis in "xyz"})
    return [remark for remark in calibrate(rows, request).remarks if remark.startswith(SAME_ORDER)]


def test_an_order_that_repeats_says_how_much_of_what_comes_back_it_hides() -> None:
    """The figure, by a fit: what the linear sensor takes of the worst wave of one, two and three periods."""
    rows = _measured(by_chance=False)
    (said,) = _hidden(rows)
    first = rows.replication == 0
    pitch, roll = rows.pitch_rad[first], rows.roll_rad[first]
    terms = np.stack([np.ones_like(pitch), np.sin(pitch), np.cos(pitch) * np.sin(roll), np.cos(pitch) * np.cos(roll)])
    at = 2.0 * np.pi * np.arange(pitch.size) / pitch.size
    largest = 0.0
    for periods in (1, 2, 3):
        for phase in np.linspace(0.0, np.pi, 181):
            wave = np.cos(periods * at + phase)
            left = wave - terms.T @ np.linalg.lstsq(terms.T, wave, rcond=None)[0]
            largest = max(largest, float(np.sqrt(1.0 - left @ left / (wave @ wave))))
    assert float(said.partition("correlation up to ")[2][:4]) == pytest.approx(largest, abs=0.006)


@pytest.mark.parametrize("jitter_deg", [1e-6, 5e-3, 0.02, 0.05])
def test_an_order_repeats_whatever_angles_are_read_otherwise(jitter_deg: float) -> None:
    (exact,), (said,) = _hidden(_measured(by_chance=False)), _hidden(_measured(by_chance=False, jitter_deg=jitter_deg))
    assert said == exact
    assert _hidden(_measured(by_chance=True, jitter_deg=jitter_deg)) == []


@pytest.mark.parametrize("jitter_deg", [5e-3, 0.02, 0.05])
@pytest.mark.parametrize("off_deg", [0.0, 0.2])
def test_rows_are_those_of_the_design_whatever_angles_are_read_otherwise(off_deg: float, jitter_deg: float) -> None:
    """``off_deg``: of one dwell in the middle of a row. The encoder of the roll begins anew at half a turn."""
    chance = np.random.default_rng(3)
    pitch, roll = np.deg2rad([(a, r) for a in PITCH_DEG for r in ROLL_DEG]).T
    terms = np.stack(
        [np.ones_like(pitch), np.sin(pitch), np.cos(pitch) * np.sin(roll), np.cos(pitch) * np.cos(roll)], axis=1
    )
    read = [angle + np.deg2rad(jitter_deg) * chance.normal(size=angle.size) for angle in (pitch, roll)]
    read[0][20] += np.deg2rad(off_deg)
    read[1] = (read[1] + np.pi) % (2.0 * np.pi) - np.pi
    assert row_correlation(terms, *read) == row_correlation(terms, pitch, roll)
    assert row_correlation(terms, pitch, roll)[1] == ROLL_DEG.size


def _taken(terms: FloatArray, course: FloatArray) -> float:
    """Return what a fit by (K, P) terms takes of a course, as a correlation."""
    left = course - terms @ np.linalg.lstsq(terms, course, rcond=None)[0]
    return float(np.sqrt(1.0 - left @ left / (course @ course)))


@pytest.mark.parametrize("is_raster", [True, False])
def test_what_comes_back_with_every_row_is_told_by_the_worst_of_its_phases(is_raster: bool) -> None:
    """Each row begins at −180° of roll, or at the end of the one before; the figure by fits of single courses."""
    rolls, pitches = np.deg2rad(ROLL_DEG), np.deg2rad(PITCH_DEG)
    rows = [(a, r) for row, a in enumerate(pitches) for r in (rolls if is_raster or row % 2 == 0 else rolls[::-1])]
    pitch, roll = np.array(rows).T
    terms = np.stack(
        [np.ones_like(pitch), np.sin(pitch), np.cos(pitch) * np.sin(roll), np.cos(pitch) * np.cos(roll)], axis=1
    )
    place = np.tile(np.arange(rolls.size), pitches.size)
    waves = [np.cos(2.0 * np.pi * place / rolls.size + phase) for phase in np.linspace(0.0, np.pi, 181)]
    found, dwells = row_correlation(terms, pitch, roll)
    assert dwells == rolls.size
    assert found == pytest.approx(max(_taken(terms, course) for course in (*waves, place - place.mean())), abs=1e-3)
    assert found > (0.9 if is_raster else 0.5)
    said = hidden_in_words(terms, pitch, roll)
    assert f"with every row of {rolls.size} dwells" in said
    assert f"correlation up to {found:.2f}" in said


def test_an_order_without_rows_hides_none() -> None:
    chance = np.random.default_rng(2)
    pitch, roll = chance.permutation(np.repeat(PITCH_DEG, 8)), chance.permutation(np.tile(ROLL_DEG, 7))
    terms = np.stack([np.ones_like(pitch), np.sin(np.deg2rad(pitch)), np.cos(np.deg2rad(roll))], axis=1)
    assert row_correlation(terms, np.deg2rad(pitch), np.deg2rad(roll)) == (0.0, 0)


def test_another_order_in_every_replication_and_rows_without_times_say_nothing_of_it() -> None:
    assert _hidden(_measured(by_chance=True)) == []
    assert _hidden(replace(_measured(by_chance=False), time_s=None)) == []
