"""A result says where the order of its points hides what comes back with every replication."""

from dataclasses import replace

import numpy as np
import pytest

from ams.calibration.calibrate import calibrate
from ams.calibration.together.in_step_hidden import SAME_ORDER
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

PITCH_DEG, ROLL_DEG = np.arange(-75.0, 76.0, 25.0), np.arange(-180.0, 180.0, 45.0)
REPLICATIONS, DWELL_S = 4, 30.0


def _measured(by_chance: bool, wave_v: float = 0.0) -> Observations:
    """A three-axis package, roll by roll, pitch there and back; a wave of one period a replication on all outputs."""
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
    assert float(said.partition("sensitivities by ")[2][:4]) == pytest.approx(largest, abs=0.006)


def test_another_order_in_every_replication_and_rows_without_times_say_nothing_of_it() -> None:
    assert _hidden(_measured(by_chance=True)) == []
    assert _hidden(replace(_measured(by_chance=False), time_s=None)) == []
