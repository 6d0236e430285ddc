"""A package that yaws is asked the same of its readings as one that only pitches and rolls."""

from dataclasses import replace

import numpy as np
import pytest
from physics_scenes import campaigns
from solved_campaigns import columns_of, rows_of

from ams.calibration.calibrate import calibrate
from ams.calibration_result import AxisCalibration
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

SMALL = {"pitch_count": 7, "roll_count": 6, "replications": 4}
YAWED = CalibrationRequest(model="pitch-yaw-roll-model")
NOISE_G = 8e-6
"""1.65″."""


def _told(axis: AxisCalibration) -> list[Finding]:
    return [finding for finding in axis.findings if finding.is_significant]


@pytest.mark.parametrize(
    ("scene", "size", "test"),
    [("carry-over", 30.0, "force along z at the dwell before"), ("k3", 60.0, "K3"), ("after-effect", 20.0, "memory")],
)
def test_without_yaw_both_models_tell_the_same_of_the_same_readings(scene: str, size: float, test: str) -> None:
    """Terms keep the sign that they have along the acceleration, whichever way the model counts gravity."""
    drawn, said = campaigns(scene, size, np.random.default_rng(21), 3, **SMALL), 0
    for index in range(drawn.campaigns):
        outputs = {axis: columns_of(drawn, axis)[:, index] for axis in "xyz"}
        rows = replace(rows_of(drawn), outputs=outputs)
        level = replace(rows, yaw_rad=np.zeros(rows.rows))
        for one, other in zip(
            calibrate(rows, CalibrationRequest(extended="no")).axes.values(),
            calibrate(level, YAWED).axes.values(),
            strict=True,
        ):
            sizes = [
                {
                    f.details["test"]: f.details["size"]
                    for f in _told(axis)
                    if str(f.details.get("test")).startswith(test)
                }
                for axis in (one, other)
            ]
            assert sizes[0].keys() == sizes[1].keys()
            said += len(sizes[0])
            for name, found in sizes[0].items():
                assert float(sizes[1][name] or 0.0) == pytest.approx(float(found or 0.0), rel=0.01)
    assert said > 0


def test_a_channel_that_keeps_some_of_the_one_before_is_told_of_a_yawed_package() -> None:
    """x keeps 40 ppm of z at the dwell before. Three matrices turn gravity: pitch, yaw, then roll."""
    points = [
        (p, y, r) for p in (-60.0, -30.0, 0.0, 30.0, 60.0) for y in (0.0, 30.0) for r in (-120.0, -30.0, 60.0, 150.0)
    ]
    chance, replications = np.random.default_rng(22), 5
    pitch, yaw, roll = np.tile(np.deg2rad(points), (replications, 1)).T
    gravity = np.array(
        [_roll(r) @ _yaw(y) @ _pitch(p) @ [0.0, 0.0, 1.0] for p, y, r in zip(pitch, yaw, roll, strict=True)]
    )
    read = 0.002 + 2.5 * gravity + 2.5 * NOISE_G * chance.standard_normal(gravity.shape)
    starts = np.arange(len(read)) % len(points) == 0
    before = np.where(starts[:, None], gravity, np.roll(gravity, 1, axis=0))
    read[:, 0] += 40e-6 * 2.5 * (before - gravity)[:, 2]
    rows = Observations(
        np.repeat(np.arange(1, replications + 1), len(points)), np.tile(np.arange(1, len(points) + 1), replications),
        pitch, roll, dict(zip("xyz", read.T, strict=True)), yaw_rad=yaw,
    )  # fmt: skip
    solved = calibrate(rows, YAWED)
    (told,) = [f for f in _told(solved.axes["x"]) if f.details.get("test") == "force along z at the dwell before"]
    size, u = (float(told.details[name] or 0.0) for name in ("size", "standard_uncertainty"))
    assert abs(size) == pytest.approx(1e-4, abs=4.0 * u)
    assert solved.verdict == "not usable"


def _pitch(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])


def _yaw(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def _roll(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])
