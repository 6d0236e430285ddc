"""Readings filtered and averaged before they become angles: the delay is off, what is not settled is told."""

import numpy as np
import pytest
from solved_sets import tp_set

from ams.attitude.filters import LowPass, LowPassStream, delay_s, settling_samples
from ams.errors import OutsideValidity
from ams.frames import specific_force
from ams.inference.inference import Inference, Package
from ams.inference.rows.angle_stream import Answer
from ams.inference.rows.averaged import AveragedAngles
from ams.inference.rows.low_passed import LowPassedAngles, LowPassWish

SET, COLUMNS, RATE_HZ = tp_set(), {axis: f"{axis}_v" for axis in "xyz"}, 100.0
WISH = LowPassWish(2.0)


def angles() -> Inference:
    return Inference(Package(SET, COLUMNS), reading_sd_v=1e-4)


def volts(pitch_deg: np.ndarray, roll_deg: np.ndarray) -> dict[str, np.ndarray]:
    force = specific_force(np.deg2rad(pitch_deg), np.deg2rad(roll_deg))
    return {
        COLUMNS[axis]: solved_axis.primary["offset_v"] + force @ solved_axis.direction_v_per_g
        for axis, solved_axis in SET.axes.items()
    }


def fed(stream: LowPassedAngles | AveragedAngles, readings: dict[str, np.ndarray], piece: int) -> list[Answer]:
    rows = next(iter(readings.values())).size
    pieces = [{name: own[at : at + piece] for name, own in readings.items()} for at in range(0, rows, piece)]
    return [*(stream.answer(piece) for piece in pieces), stream.finish()]


def column(found: list[Answer], name: str) -> np.ndarray:
    return np.concatenate([entry.columns[name] for entry in found])


def flags(found: list[Answer]) -> list[str]:
    return [flag for entry in found for flag in entry.flags]


@pytest.mark.parametrize("piece", [7, 100, 1000])
def test_a_slow_turn_is_told_at_its_own_time_and_a_fast_shake_is_gone(piece: int) -> None:
    """The set's own outputs of a ramp with 20 Hz on top, against the ramp."""
    time_s = np.arange(1000) / RATE_HZ
    ramp, roll = 2.0 * time_s - 10.0, np.full(time_s.size, 5.0)
    readings = volts(ramp, roll)
    readings["x_v"] = readings["x_v"] + 0.05 * np.sin(2 * np.pi * 20.0 * time_s)
    found = fed(LowPassedAngles(angles(), WISH, RATE_HZ), readings, piece)
    pitch, text = column(found, "pitch_deg"), flags(found)
    assert pitch.size == time_s.size
    settled = np.array([flag == "" for flag in text])
    assert settled[300:-60].all()
    assert np.abs(pitch - ramp)[settled].max() < 0.02  # 0.05 V are 1.1° of shaking
    late = round(delay_s(LowPass(2.0, RATE_HZ)) * RATE_HZ)
    assert text[0] == "filter not settled"
    assert set(text[-late:]) == {"reading missing or not a number; filter not settled"}


def test_rows_have_the_answer_of_the_whole_filter_whatever_the_pieces() -> None:
    """Row n has what the filter says at n + delay, settled so many samples after the start; the last rows have none."""
    chance = np.random.default_rng(6)
    readings = volts(10.0 * chance.normal(size=400), 10.0 * chance.normal(size=400))
    settings = LowPass(2.0, RATE_HZ)
    late, whole = round(delay_s(settings) * RATE_HZ), np.full((400, 3), np.nan)
    whole[:-late] = LowPassStream(settings).feed(np.stack(list(readings.values()), axis=-1))[late:]
    rows = np.arange(400)
    is_transient = (rows + late <= settling_samples(settings)) | (rows >= 400 - late)
    wanted = angles().answer({name: whole[:, index] for index, name in enumerate(readings)})
    for piece in (1, 33, 400):
        found = fed(LowPassedAngles(angles(), WISH, RATE_HZ), readings, piece)
        assert column(found, "pitch_deg") == pytest.approx(wanted.columns["pitch_deg"], abs=1e-9, nan_ok=True)
        unsettled = np.array(["filter not settled" in flag for flag in flags(found)])
        assert np.array_equal(unsettled, is_transient)


def test_a_missing_reading_is_bridged_marked_and_forgotten() -> None:
    readings = volts(np.full(900, 3.0), np.full(900, 4.0))
    readings["y_v"][400] = np.nan
    found = fed(LowPassedAngles(angles(), WISH, RATE_HZ), readings, 50)
    said = flags(found)
    assert "reading missing: bridged by the filter" in said[400]
    assert said[390] != ""  # the delay: the filter's answer of a row is that of a later one
    assert said[700] == ""
    assert column(found, "roll_deg")[700] == pytest.approx(4.0, abs=1e-9)


def test_windows_have_the_mean_of_their_readings_and_the_time_of_their_middle() -> None:
    time_s = np.arange(250) / RATE_HZ
    readings = volts(np.where(time_s < 1.0, 3.0, 6.0), np.zeros(250)) | {"time_s": time_s}
    readings["x_v"][150] = np.nan
    found = fed(AveragedAngles(angles(), 0.5, None), readings, 33)
    assert column(found, "pitch_deg") == pytest.approx([3.0, 3.0, 6.0, 6.0, 6.0], abs=1e-9)
    of_those_left = 1.75  # the first of its fifty is missing
    assert column(found, "time_s") == pytest.approx([0.245, 0.745, 1.245, of_those_left, 2.245])
    assert flags(found) == ["", "", "", "readings missing in the window: mean of those left", ""]


@pytest.mark.parametrize("piece", [1, 33, 900])
def test_windows_of_filtered_samples_say_what_the_filter_says_of_any_of_them(piece: int) -> None:
    """A command that filtered and averaged stopped with a defect, and its flags were those of the first samples."""
    readings = volts(np.full(930, 3.0), np.full(930, 4.0)) | {"time_s": np.arange(930) / RATE_HZ}
    readings["y_v"][520] = np.nan
    alone = fed(LowPassedAngles(angles(), WISH, RATE_HZ), readings, 100)
    found = (
        fed(LowPassedAngles(AveragedAngles(angles(), 1.0, None), WISH, None), readings, piece)
        if piece > 1
        else fed(LowPassedAngles(AveragedAngles(angles(), 1.0, RATE_HZ), WISH, RATE_HZ), readings, piece)
    )
    samples = flags(alone)
    for word in ("filter not settled", "bridged by the filter"):
        by_window = [any(word in flag for flag in samples[at : at + 100]) for at in range(0, 930, 100)]
        assert [word in flag for flag in flags(found)] == by_window
    assert not all("not settled" in flag for flag in flags(found))
    due = sum("not a number" in flag for flag in samples)
    assert due > 0  # the delay: the last samples have no answer of the filter, and the last window lacks them
    assert column(found, "time_s") == pytest.approx([*(0.495 + np.arange(9)), 9.0 + (29 - due) / 200.0])
    assert "readings missing in the window" in flags(found)[-1]
    settled = [not flag for flag in flags(found)]
    assert column(found, "pitch_deg")[settled] == pytest.approx(3.0, abs=1e-6)


def test_averages_of_what_is_integrated_and_settings_of_no_filter_are_refused() -> None:
    with pytest.raises(OutsideValidity, match="averages: belong to accelerometers at rest"):
        AveragedAngles(LowPassedAngles(angles(), WISH, RATE_HZ), 1.0, None)
    with pytest.raises(OutsideValidity, match="give the sampling rate, or a column time_s"):
        LowPassedAngles(angles(), WISH, None).answer(volts(np.zeros(3), np.zeros(3)))
