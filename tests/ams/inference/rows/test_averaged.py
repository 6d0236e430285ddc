"""Windows with missing readings: every axis over the same rows, told, and as sure as what is left allows."""

import numpy as np
import pytest
from solved_sets import tp_set

from ams.attitude import flag_codes
from ams.frames import specific_force
from ams.inference.inference import Inference, Package
from ams.inference.rows.angle_stream import Answer, joined
from ams.inference.rows.averaged import AveragedAngles
from ams.inference.watch.watched_axes import WatchedAxes, watched_axes

SET, COLUMNS, RATE_HZ, ROWS = tp_set(), {axis: f"{axis}_v" for axis in "xyz"}, 100.0, 1000
TIME_S = np.arange(ROWS) / RATE_HZ
SHORT = flag_codes.WINDOW_WORDS[flag_codes.WINDOW_SHORT]
NONE_LEFT = flag_codes.WINDOW_WORDS[flag_codes.NOT_FINITE]
Readings = dict[str, np.ndarray]


def volts(pitch_deg: np.ndarray, roll_deg: np.ndarray) -> Readings:
    force = specific_force(np.deg2rad(pitch_deg), np.deg2rad(roll_deg))
    return {
        COLUMNS[axis]: solved_axis.primary["offset_v"] + force @ solved_axis.direction_v_per_g
        for axis, solved_axis in SET.axes.items()
    }


def turning() -> Readings:
    """At one and two degrees a second: straight lines in time, but for a thousandth of a degree in a window."""
    return volts(1.0 * TIME_S - 5.0, 2.0 * TIME_S - 10.0) | {"time_s": TIME_S.copy()}


def averaged(readings: Readings, piece: int = 70, reading_sd_v: float | None = 1e-4) -> Answer:
    inference = Inference(Package(SET, COLUMNS), reading_sd_v=reading_sd_v)
    stream = AveragedAngles(watched_axes(inference), 1.0, None)
    rows = readings["time_s"].size
    found = stream.answer({name: values[:piece] for name, values in readings.items()})
    for at in range(piece, rows, piece):
        found = joined(found, stream.answer({name: values[at : at + piece] for name, values in readings.items()}))
    return joined(found, stream.finish())


@pytest.mark.parametrize("piece", [7, 100, ROWS])
@pytest.mark.parametrize("missing", [["x_v", "y_v", "z_v"], ["y_v"], ["z_v"]])
@pytest.mark.parametrize("gone", [slice(101, 200), slice(150, 200), slice(150, 151)])
def test_a_turning_package_is_told_as_it_stood_at_the_time_that_is_stated(
    gone: slice, missing: list[str], piece: int
) -> None:
    """Of 99 rows of 100 missing pitch was 0.5° off, and of one axis missing roll, without a flag."""
    readings = turning()
    for name in missing:
        readings[name][gone] = np.nan
    found = averaged(readings, piece)
    time_s = found.columns["time_s"]
    assert found.columns["pitch_deg"] == pytest.approx(1.0 * time_s - 5.0, abs=2e-3)
    assert found.columns["roll_deg"] == pytest.approx(2.0 * time_s - 10.0, abs=2e-3)
    assert [flag == SHORT for flag in found.flags] == [window == 1 for window in range(10)]
    assert time_s[1] == pytest.approx(np.delete(TIME_S, gone)[100 : 200 - len(TIME_S[gone])].mean())


def test_a_window_of_which_nothing_is_left_has_no_angle_and_says_so() -> None:
    readings = turning()
    for axis, rows in (("x", slice(200, 250)), ("y", slice(240, 290)), ("z", slice(290, 300))):
        readings[COLUMNS[axis]][rows] = np.nan
    found = averaged(readings)
    assert np.isnan(found.columns["pitch_deg"][2])
    assert found.flags == ("", "", NONE_LEFT, *[""] * 7)
    assert found.columns["time_s"] == pytest.approx(0.495 + np.arange(10))


@pytest.mark.parametrize("piece", [7, 100, ROWS])
def test_samples_that_never_came_are_missing_from_their_window(piece: int) -> None:
    """Fifty rows before a gap of seven seconds were averaged with fifty behind it, at a time between."""
    kept = np.r_[0:150, 860:ROWS]
    found = averaged({name: values[kept] for name, values in turning().items()}, piece)
    time_s = found.columns["time_s"]
    assert time_s == pytest.approx([0.495, 1.245, 8.795, 9.495])
    assert found.columns["pitch_deg"] == pytest.approx(1.0 * time_s - 5.0, abs=2e-3)
    assert found.flags == ("", SHORT, SHORT, "")


def test_rows_in_bursts_or_without_a_time_are_not_taken_as_missing() -> None:
    readings = turning()
    readings["time_s"] = np.repeat(TIME_S[::5], 5)
    readings["time_s"][::5] += 1e-9
    inference = Inference(Package(SET, COLUMNS), reading_sd_v=1e-4)
    stream = AveragedAngles(inference, 1.0, RATE_HZ)
    assert [*stream.answer(readings).flags, *stream.finish().flags] == [""] * 10
    readings = turning()
    readings["time_s"][[0, 333, 999]] = np.nan
    assert averaged(readings).flags == ("",) * 10


def test_the_standard_deviation_is_that_of_the_readings_that_are_left() -> None:
    """Noise drawn at random: one in two thousand is beyond 3.5; of two readings left they were beyond ten."""
    chance, sd_v = np.random.default_rng(5), 0.01
    whole = volts(np.full(ROWS, 5.0), np.full(ROWS, 7.0)) | {"time_s": TIME_S}
    for name in COLUMNS.values():
        whole[name] = whole[name] + chance.normal(0.0, sd_v, ROWS)
    left = {name: values.copy() for name, values in whole.items()}
    for first in range(0, ROWS, 100):
        left["y_v"][first + 4 : first + 100] = np.nan
    found, before = averaged(left, reading_sd_v=sd_v / 10.0), averaged(whole, reading_sd_v=sd_v / 10.0)
    for angle, truth_deg in (("pitch", 5.0), ("roll", 7.0)):
        off = np.abs(found.columns[f"{angle}_deg"] - truth_deg) / found.columns[f"{angle}_sd_deg"]
        assert off.max() < 3.5
        assert off.max() > 0.5
        assert (found.columns[f"{angle}_sd_deg"] > 4.0 * before.columns[f"{angle}_sd_deg"]).all()
    assert found.flags == (SHORT,) * 10


def test_the_last_window_counts_as_many_readings_as_it_has() -> None:
    """It is no window with a reading missing, and no more sure than its four readings are."""
    readings = {name: values[:204] for name, values in turning().items()}
    found = averaged(readings)
    assert found.flags == ("", "", "")
    sd_deg = found.columns["pitch_sd_deg"]
    assert sd_deg[2] > 1.5 * sd_deg[1]
    alone = averaged({**readings, "y_v": np.where(np.arange(204) == 202, np.nan, readings["y_v"])})
    assert alone.flags == ("", "", SHORT)
    assert alone.columns["pitch_sd_deg"][2] > sd_deg[2]


def test_axes_are_judged_by_what_windows_have_left() -> None:
    """Windows of two readings scatter seven times as much as whole ones: no axis is wrong for that."""
    chance, sd_v = np.random.default_rng(11), 0.02
    rows = 40 * 100
    time_s = np.arange(rows) / RATE_HZ
    readings = volts(0.5 * time_s - 10.0, 0.5 * time_s) | {"time_s": time_s}
    for name in COLUMNS.values():
        readings[name] = readings[name] + chance.normal(0.0, sd_v, rows)
        readings[name][(np.arange(rows) % 100 >= 2) & (np.arange(rows) >= 1000)] = np.nan
    watched = watched_axes(Inference(Package(SET, COLUMNS), reading_sd_v=sd_v / 10.0))
    assert isinstance(watched, WatchedAxes)
    stream = AveragedAngles(watched, 1.0, None)
    found = joined(stream.answer(readings), stream.finish())
    assert set(found.flags) == {"", SHORT}
    assert watched.proven() == ()
