"""A wrong index of a table of which nothing is declared is not put down to the sensor, nor told as contained."""

import numpy as np

from ams.calibration.calibrate import Calibration, calibrate
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

POINTS = np.array([(p, r) for p in range(-60, 61, 15) for r in range(-180, 180, 45)], dtype=float)
REPLICATIONS = 4
SENSITIVE = np.array([[2.5, 0.01, -0.02], [0.02, 2.48, 0.01], [-0.01, 0.02, 2.52]])


def _read(angles_deg: np.ndarray, noise_v: np.ndarray) -> np.ndarray:
    pitch, roll = np.deg2rad(angles_deg).T
    return 0.002 + specific_force(pitch, roll) @ SENSITIVE.T + noise_v


def _solved(read: np.ndarray) -> Calibration:
    pitch, roll = np.tile(np.deg2rad(POINTS), (REPLICATIONS, 1)).T
    return calibrate(
        Observations(
            np.repeat(np.arange(1, REPLICATIONS + 1), len(POINTS)),
            np.tile(np.arange(1, len(POINTS) + 1), REPLICATIONS),
            pitch, roll, dict(zip("xyz", read.T, strict=True)),
        ),
        CalibrationRequest(),
    )  # fmt: skip


def test_a_wrong_index_is_neither_contained_nor_the_sensors_alone() -> None:
    """Roll stands 20″ off at 45° in every replication; the sensor is linear."""
    stood = np.tile(POINTS, (REPLICATIONS, 1))
    stood[stood[:, 1] == 45.0, 1] += 20.0 / 3600.0
    solved = _solved(_read(stood, np.random.default_rng(3).normal(0.0, 1.8e-5, (len(stood), 3))))
    found = [finding for axis in solved.axes.values() for finding in axis.findings if finding.is_significant]
    lacks = [finding.text for finding in found if finding.kind == "lack-of-fit"]
    assert lacks
    assert all("at roll index 45°" in text and "an index of the table that is wrong" in text for text in lacks)
    assert "contained" not in "".join(lacks)
    terms = [finding.text for finding in found if finding.kind in ("quadratic", "cubic", "cross-coupling", "asymmetry")]
    assert all("or indices of the table are wrong" in text for text in terms)


def test_a_meter_too_coarse_to_scatter_tells_nothing_of_its_gain() -> None:
    """Steps of 300 µV under a noise of 18 µV: in some campaigns no reading of an axis differs between replications."""
    stood = np.tile(POINTS, (REPLICATIONS, 1))
    for seed in range(12):
        noise = np.random.default_rng(seed).normal(0.0, 4e-6, (len(stood), 3))
        noise[:, 0] = 0.0
        read = np.round(_read(stood, noise) / 3e-4) * 3e-4
        kinds = {f.kind for axis in _solved(read).axes.values() for f in axis.findings if f.is_significant}
        assert "meter-gain" not in kinds
