"""Gyros whose rates lack the Earth's are told so, and neither their scale factor nor a table is blamed for it.

The scene is made of rotations of a table and of the ground alone: latitude, heading and gyros are drawn at random.
"""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ams.analysis.diagnostics.declared.earth_on_gyros import EARTH_ON_RATES
from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.findings import Finding
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

FloatArray = NDArray[np.float64]
_EARTH_DPS = 15.041067 / 3600.0
_COUNT = 6
_RATES_DPS = (5.0, 10.0, 20.0, 40.0)
_STEPS = 72


def _points() -> FloatArray:
    """(24, 3) rates of pitch, yaw and roll: one axis after the other, both senses."""
    return np.concatenate([np.outer([s * w for w in _RATES_DPS for s in (1.0, -1.0)], row) for row in np.eye(3)])


def _ground_dps(rng: np.random.Generator) -> FloatArray:
    """(3,) the Earth's rate along forward, right and down of a table somewhere."""
    latitude, heading = np.deg2rad([rng.uniform(-65.0, 65.0), rng.uniform(0.0, 360.0)])
    north, down = np.cos(latitude), -np.sin(latitude)
    return _EARTH_DPS * np.array([north * np.cos(heading), -north * np.sin(heading), down])


def _seen_dps(rate_dps: FloatArray, ground_dps: FloatArray) -> FloatArray:
    """(3,) mean angular velocity against the stars along the axes of a package that turns whole turns."""
    angles = np.outer(np.arange(_STEPS) * 360.0 / _STEPS, np.sign(rate_dps))  # pitch, yaw, roll
    turned = Rotation.from_euler("YZX", angles, degrees=True).inv()
    return np.array([rate_dps[2], rate_dps[0], rate_dps[1]]) + turned.apply(ground_dps).mean(axis=0)


def _rows(seed: int, earth: float, asymmetry_ppm: float = 0.0) -> Observations:
    rng, points, n = np.random.default_rng(seed), _points(), 4
    ground = earth * _ground_dps(rng)
    seen = np.array([_seen_dps(rate, ground) for rate in points])
    order = np.concatenate([rng.permutation(len(points)) for _ in range(n)])
    outputs = {}
    for index, axis in enumerate("xyz"):
        k = 1.25 * (np.eye(3)[index] + 0.005 * rng.standard_normal(3))
        bent = 0.5e-6 * asymmetry_ppm * 1.25 * np.abs(seen[:, index])
        outputs[axis] = (0.02 * rng.standard_normal() + seen @ k + bent)[order] + 3e-4 * rng.standard_normal(order.size)
    still = np.zeros(order.size)
    return Observations(
        np.repeat(np.arange(n), len(points)),
        order,
        still,
        still,
        outputs,
        yaw_rad=still,
        euler_rate_rad_s=np.deg2rad(points[order]),
        time_s=30.0 * np.arange(order.size),
    )


def _solved(rows: Observations) -> Calibration:
    return calibrate(rows, CalibrationRequest(model="gyro"))


def _told(solved: Calibration) -> list[Finding]:
    return [said for axis in solved.axes.values() for said in axis.findings if said.is_significant]


@pytest.mark.parametrize("seed", range(_COUNT))
def test_rates_that_lack_the_earth_are_told_and_nothing_else_is_blamed(seed: int) -> None:
    told = _told(_solved(_rows(seed, 1.0)))
    named = [said for said in told if said.details.get("test") == EARTH_ON_RATES]
    assert named
    assert all(said.kind == "rate-undeclared" and not said.is_held for said in named)
    assert all(float(str(said.details["size"])) < 1.1 * _EARTH_DPS for said in named)
    assert not {said.kind for said in told} & {"asymmetry", "quadratic", "cubic", "lack-of-fit"}


@pytest.mark.parametrize("seed", range(_COUNT))
def test_rates_that_have_the_earth_are_not_said_to_lack_it(seed: int) -> None:
    assert not [said for said in _told(_solved(_rows(seed, 0.0))) if said.details.get("test") == EARTH_ON_RATES]


@pytest.mark.parametrize("earth", [0.0, 1.0])
def test_an_asymmetry_of_the_scale_factor_stays_one_beside_the_earth(earth: float) -> None:
    for seed in range(_COUNT):
        told = _told(_solved(_rows(seed, earth, asymmetry_ppm=1000.0)))
        assert {"asymmetry"} <= {said.kind for said in told}
        assert any(said.details.get("test") == EARTH_ON_RATES for said in told) == (earth > 0.0)


def test_a_rate_that_is_longer_than_the_earths_is_not_the_earths() -> None:
    named = [said for said in _told(_solved(_rows(1, 5.0))) if said.details.get("test") == EARTH_ON_RATES]
    assert all(float(str(said.details["size"])) < 1.1 * _EARTH_DPS for said in named)
    assert len(named) < 3


def test_few_rates_are_solved_where_what_gravity_does_is_what_terms_do() -> None:
    """Of two rates an axis the points that turn about the vertical are told by terms of the scale factor as well."""
    rows = _rows(0, 0.0)
    rate_dps = np.rad2deg(np.abs(rows.euler_rate_rad_s).max(axis=1))
    kept = np.isin(np.round(rate_dps), [10.0, 40.0])
    few = replace(
        rows,
        replication=rows.replication[kept],
        point=rows.point[kept],
        pitch_rad=rows.pitch_rad[kept],
        roll_rad=rows.roll_rad[kept],
        yaw_rad=rows.yaw_rad[kept],
        time_s=rows.time_s[kept],
        euler_rate_rad_s=rows.euler_rate_rad_s[kept],
        outputs={axis: values[kept] for axis, values in rows.outputs.items()},
    )
    assert _solved(few).verdict == "sound"
