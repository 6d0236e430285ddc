"""A rate beside times: refused where they tell another, kept where times are coarse, jitter, double or lack rows."""

import numpy as np
import pytest
from solved_sets import gyro_set

from ams.errors import OutsideValidity
from ams.frames import body_rates_rad_s
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.rates import GyroAngles, Motion
from ams.inference.rows.angle_stream import Answer
from ams.inference.rows.stated_rate import StatedRate

ROWS, HZ = 3000, 100.0
COLUMNS = {axis: f"{axis}_v" for axis in "xyz"}
CHANCE = np.random.default_rng(17)
TIME_S = np.arange(ROWS) / HZ
IS_THERE = CHANCE.random(ROWS) > 0.3
HALF = CHANCE.random(ROWS) > 0.6


class Counted:
    """A stream that answers nothing and counts its rows."""

    needed, optional, answers, answers_at_once = ("x_v",), (), ("flag",), True

    def __init__(self) -> None:
        self.rows = 0

    def answer(self, readings: dict[str, np.ndarray]) -> Answer:
        self.rows += readings["x_v"].size
        return Answer({}, np.zeros(readings["x_v"].size, dtype=np.uint32))

    def finish(self) -> Answer:
        return Answer({}, np.empty(0, dtype=np.uint32))


def rows_before_refusal(time_s: np.ndarray, rate_hz: float, piece: int = 7) -> int | None:
    """Return how many rows were handed on before the refusal; None where there was none."""
    inner = Counted()
    held = StatedRate(inner, rate_hz)
    try:
        for block in np.array_split(time_s, max(time_s.size // piece, 1)):
            held.answer({"x_v": block, "time_s": block})
        held.finish()
    except OutsideValidity:
        return inner.rows
    return None


def at_arrival(time_s: np.ndarray, most_intervals: float) -> np.ndarray:
    """Return times that come late by up to so many intervals, in order."""
    return np.maximum.accumulate(time_s + CHANCE.uniform(0.0, most_intervals, time_s.size) / HZ)


@pytest.mark.parametrize(
    ("time_s", "rate_hz"),
    [
        (TIME_S, HZ),
        (TIME_S * 1.001, HZ),  # a clock that runs fast by 1000 ppm
        (np.round(np.arange(ROWS) / 128.0, 3), 128.0),
        (np.floor(np.arange(ROWS) / 128.0 * 100.0) / 100.0, 128.0),  # coarser than the interval
        (np.floor(np.arange(ROWS) / 1000.0 * 1000.0) / 1000.0, 1000.0),
        (at_arrival(TIME_S, 0.3), HZ),
        (at_arrival(TIME_S, 2.0), HZ),
        (np.floor(np.arange(ROWS) / 10.0) * 0.1, HZ),  # ten rows at once
        (TIME_S[IS_THERE], HZ),
        (TIME_S[HALF], HZ),
        (np.delete(TIME_S, slice(500, 900)), HZ),
        (np.repeat(TIME_S, 2), HZ),
        (np.where(CHANCE.random(ROWS) < 0.1, np.nan, TIME_S), HZ),
        (np.concatenate([TIME_S[:1000], TIME_S[:1000]]), HZ),  # the clock starts again
        (np.full(ROWS, np.nan), HZ),
        (TIME_S[:2], HZ),
    ],
    ids=["same", "1000 ppm", "ms at 128 Hz", "10 ms at 128 Hz", "ms at 1 kHz", "late by 0.3", "late by 2", "bursts",
         "a third lost", "half lost", "a gap", "doubled", "cells without", "clock anew", "no time", "two rows"],
)  # fmt: skip
def test_a_rate_that_the_times_keep_is_taken(time_s: np.ndarray, rate_hz: float) -> None:
    assert rows_before_refusal(time_s, rate_hz) is None


@pytest.mark.parametrize("piece", [1, 7, ROWS])
@pytest.mark.parametrize("rate_hz", [1.0, 25.0, 50.0, 66.0, 90.0, 98.0, 99.5, 100.5, 102.0, 110.0, 150.0, 190.0, 200.0,
                                     300.0, 1000.0])  # fmt: skip
def test_a_rate_that_the_times_contradict_is_refused_as_soon_as_it_shows(rate_hz: float, piece: int) -> None:
    """So few rows are handed on that what they turn is not wrong by more than a few intervals."""
    handed_on = rows_before_refusal(TIME_S, rate_hz, piece)
    assert handed_on is not None
    relative = abs(rate_hz / HZ - 1.0)
    assert handed_on <= max(21, 2.6 / (relative - 0.002) + 1) + 7 or handed_on == 0


@pytest.mark.parametrize("time_s", [TIME_S[IS_THERE], np.round(TIME_S, 3), at_arrival(TIME_S, 0.3)])
@pytest.mark.parametrize("rate_hz", [50.0, 98.0, 102.0, 200.0])
def test_losses_and_jitter_hide_no_wrong_rate(time_s: np.ndarray, rate_hz: float) -> None:
    assert rows_before_refusal(time_s, rate_hz) is not None


@pytest.mark.parametrize("factor", [1e3, 1e-3])
def test_times_in_another_unit_are_refused(factor: float) -> None:
    assert rows_before_refusal(TIME_S * factor, HZ) is not None


def test_the_refusal_names_both_rates_and_what_to_do() -> None:
    held = StatedRate(Counted(), 98.0)
    with pytest.raises(OutsideValidity, match=r"98 Hz is stated .*time_s tells 100 Hz .*leave the stated rate out"):
        held.answer({"x_v": TIME_S, "time_s": TIME_S})


def test_angles_by_a_rate_that_is_taken_hold_the_truth() -> None:
    """A harmonic motion of 10° whose times are 1000 ppm off: the angle is wrong by no more than that."""
    omega = 2 * np.pi * np.array([0.125, 0.0625, 0.25])
    phase = TIME_S[:, None] * omega
    euler = np.deg2rad(10.0) * np.sin(phase)
    rates = np.rad2deg(body_rates_rad_s(euler, np.deg2rad(10.0) * omega * np.cos(phase)))
    readings = {f"{a}_v": n.primary["offset_v"] + rates @ n.direction for a, n in gyro_set().axes.items()}
    found = StatedRate(GyroAngles(GyroPackage(gyro_set(), COLUMNS, 1e-6), Motion(HZ)), HZ)
    parts = [found.answer({**readings, "time_s": 1.001 * TIME_S}), found.finish()]
    pitch_deg = np.concatenate([part.columns["pitch_deg"] for part in parts])
    assert np.abs(pitch_deg - np.rad2deg(euler[:, 0])).max() < 0.02
