"""CR's two packages beside its gyros: agreement is told, and what corrupts either of them is flagged."""

import numpy as np
import pytest
from cr_outputs import TABLE_3_MODEL, TABLE_3_STING, TABLE_4, accelerometer_v, gyro_v
from solved_sets import gyro_set, package_set

from ams.errors import OutsideValidity
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.monitored import MonitoredAngles
from ams.inference.gyros.rates import GyroAngles, Motion
from ams.inference.inference import Inference, Package

RATE_HZ, ROWS = 50.0, 150
STING, MODEL, GYROS = package_set("sting"), package_set("model"), gyro_set()
COLUMNS = {part: {axis: f"{part}_{axis}_v" for axis in "xyz"} for part in ("sting", "model", "gyro")}
TIME_S = np.arange(ROWS) / RATE_HZ
OMEGA = 2 * np.pi * np.array([0.125, 0.0625, 0.25])
EULER_DEG = np.array([20.0, 0.0, 0.0]) + 10.0 * np.sin(TIME_S[:, None] * OMEGA)
DISAGREE = "accelerometers and gyros disagree"


def scene() -> dict[str, np.ndarray]:
    """Return what all nine sensors read in CR's harmonic motion about 20 degrees of pitch."""
    rates = 10.0 * OMEGA * np.cos(TIME_S[:, None] * OMEGA)
    moments = list(zip(EULER_DEG.tolist(), rates.tolist(), strict=True))
    readings = {}
    for axis in "xyz":
        for part, truths in (("sting", TABLE_3_STING), ("model", TABLE_3_MODEL)):
            readings[f"{part}_{axis}_v"] = np.array([accelerometer_v(axis, truths[axis], e, part) for e, _ in moments])
        readings[f"gyro_{axis}_v"] = np.array([gyro_v(axis, TABLE_4[axis], e, r) for e, r in moments])
    return readings


def monitor(limit_deg: float = 0.05) -> MonitoredAngles:
    packages = Inference(Package(STING, COLUMNS["sting"]), Package(MODEL, COLUMNS["model"]), 1e-5)
    gyros = GyroAngles(GyroPackage(GYROS, COLUMNS["gyro"], 1e-5), Motion(RATE_HZ, start_deg=(20.0, 0.0, 0.0)))
    return MonitoredAngles(packages, gyros, limit_deg)


def run(readings: dict[str, np.ndarray], piece: int = 40) -> tuple[np.ndarray, np.ndarray, list[str]]:
    stream = monitor()
    found = [
        stream.answer({name: own[at : at + piece] for name, own in readings.items()}) for at in range(0, ROWS, piece)
    ]
    found.append(stream.finish())
    flags = [flag for entry in found for flag in entry.flags]
    pitch, difference = (
        np.concatenate([entry.columns[name] for entry in found]) for name in ("pitch_deg", "gyro_difference_deg")
    )
    return pitch, difference, flags


def test_both_agree_on_a_motion_and_every_row_is_answered_once() -> None:
    pitch, difference, flags = run(scene())
    assert pitch == pytest.approx(EULER_DEG[:, 0], abs=1e-6)
    assert np.nanmax(difference) < 1e-3
    assert set(flags) == {""}


def test_a_gyro_that_jumps_is_told_from_there_on() -> None:
    readings = scene()
    readings["gyro_y_v"][60:] += 0.5  # 0.4 degrees a second
    _, difference, flags = run(readings)
    assert not any(DISAGREE in flag for flag in flags[:60])
    assert all(DISAGREE in flag for flag in flags[80:])
    assert difference[-1] == pytest.approx(0.5 / TABLE_4["y"][1] * (ROWS - 60) / RATE_HZ, rel=0.1)


def test_a_package_that_jumps_is_told_by_the_gyros_too_and_a_missing_row_is_not_compared() -> None:
    readings = scene()
    readings["model_y_v"][100:] += 0.01
    readings["sting_x_v"][30] = np.nan
    _, _, flags = run(readings)
    assert flags[30].endswith("not compared with the gyros")
    assert not any(DISAGREE in flag for flag in flags[:100])
    assert all(DISAGREE in flag for flag in flags[100:])


def test_a_limit_below_nothing_is_refused() -> None:
    with pytest.raises(OutsideValidity, match="agreement: got a limit of -1°"):
        monitor(-1.0)


@pytest.mark.parametrize(("off_deg", "is_told"), [(0.8, False), (0.97, False), (1.03, True), (1.3, True), (1.9, True)])
def test_a_row_is_told_from_the_limit_on_that_was_given(off_deg: float, is_told: bool) -> None:
    """Gyros that were started off by so much stay off by it; what both are uncertain by is below 0.01°."""
    packages = Inference(Package(STING, COLUMNS["sting"]), Package(MODEL, COLUMNS["model"]), 1e-5)
    motion = Motion(RATE_HZ, start_deg=(20.0 + off_deg, 0.0, 0.0))
    stream = MonitoredAngles(packages, GyroAngles(GyroPackage(GYROS, COLUMNS["gyro"], 1e-5), motion), 1.0)
    answered = (stream.answer({name: own[:20] for name, own in scene().items()}), stream.finish())
    flags = [flag for found in answered for flag in found.flags]
    assert len(flags) == 20
    assert [DISAGREE in flag for flag in flags] == [is_told] * 20
