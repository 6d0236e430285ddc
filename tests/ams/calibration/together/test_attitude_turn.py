"""A package that turns with its attitude is named as that; terms of the sensors and errors of the table never are."""

from collections.abc import Callable
from typing import Final

import numpy as np
import pytest
from numpy.typing import NDArray
from physics_scenes.rotations import ARCSEC

from ams.analysis.diagnostics.low_order import term_columns
from ams.calibration.calibrate import calibrate
from ams.calibration.output.believed import evidence_of
from ams.calibration.solving.columns import solve_columns
from ams.calibration.together.attitude_turn import judge_attitude_turn
from ams.calibration.together.attitude_turn_found import AttitudeTurn
from ams.findings import Finding
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.models.extended import ExtendedPitchRoll, centring_of
from ams.observations import Observations

FloatArray = NDArray[np.float64]
Scene = Callable[[np.random.Generator, float, FloatArray, FloatArray], tuple[FloatArray, FloatArray | float]]
"""From a size, pitch and roll to what acts on the package, (N, 3) g, and what each output reads more, (N, 3) g."""
SHARE: Final = 3.0 * 0.05 / 3.0 / 38.0
GRID: Final = np.deg2rad([(pitch, roll) for pitch in range(-75, 76, 25) for roll in range(-180, 180, 45)])
REPLICATIONS: Final = 4
NOISE_G: Final = 8e-6


def _direction(rng: np.random.Generator) -> FloatArray:
    drawn = rng.normal(size=3)
    return np.asarray(drawn / np.linalg.norm(drawn))


def _still(_rng: np.random.Generator, _size: float, pitch: FloatArray, roll: FloatArray) -> tuple[FloatArray, float]:
    return np.asarray(specific_force(pitch, roll)), 0.0


def _off_its_centre(
    rng: np.random.Generator, size: float, pitch: FloatArray, roll: FloatArray
) -> tuple[FloatArray, float]:
    """A mount that yields to r × f."""
    force = specific_force(pitch, roll)
    return force + size * ARCSEC * np.cross(np.cross(_direction(rng), force), force), 0.0


def _sagging(rng: np.random.Generator, size: float, pitch: FloatArray, roll: FloatArray) -> tuple[FloatArray, float]:
    """An arm that bends by cos(R + φ)."""
    return np.asarray(specific_force(pitch + size * ARCSEC * np.cos(roll + rng.uniform(0.0, 2.0 * np.pi)), roll)), 0.0


def _pulled_by_pitch(
    rng: np.random.Generator, size: float, pitch: FloatArray, roll: FloatArray
) -> tuple[FloatArray, float]:
    force = specific_force(pitch, roll)
    return force + np.cross(size * ARCSEC * _direction(rng), force) * (2.0 * pitch / np.pi)[:, None], 0.0


def _pulled_either_way(
    rng: np.random.Generator, size: float, pitch: FloatArray, roll: FloatArray
) -> tuple[FloatArray, float]:
    """A cable that pulls by |R|, about y and z: about x it is a curve of index errors."""
    about, force = _direction(rng) * [0.0, 1.0, 1.0], specific_force(pitch, roll)
    turn = size * ARCSEC * about / np.linalg.norm(about)
    return force + np.cross(turn, force) * (np.abs(roll) / np.pi)[:, None], 0.0


def _terms(most: int) -> Scene:
    """Return sensors of which each has so many terms of low order, of ``size`` down to a tenth of it, µg."""

    def scene(
        rng: np.random.Generator, size: float, pitch: FloatArray, roll: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        force, more = specific_force(pitch, roll), []
        for axis in "xyz":
            terms = np.zeros(8)
            chosen = rng.choice(8, most, replace=False)
            terms[chosen] = rng.uniform(0.1 * size, size, most) * rng.choice([-1.0, 1.0], most)
            more.append(1e-6 * term_columns(force, axis) @ terms)
        return force, np.stack(more, axis=1)

    return scene


def _indices_off(
    rng: np.random.Generator, size: float, pitch: FloatArray, roll: FloatArray
) -> tuple[FloatArray, float]:
    off = []
    for angle in (pitch, roll):
        _, index = np.unique(angle.round(6), return_inverse=True)
        off.append(angle + size * ARCSEC * rng.uniform(-1.0, 1.0, index.max() + 1)[index])
    return np.asarray(specific_force(*off)), 0.0


def _campaigns(scene: Scene, size: float, count: int, seed: int) -> tuple[Observations, dict[str, FloatArray]]:
    """Return the rows, each replication in an order of its own, and (N, count) outputs of every axis."""
    rng = np.random.default_rng(seed)
    points = np.concatenate([rng.permutation(len(GRID)) for _ in range(REPLICATIONS)])
    pitch, roll = GRID[points].T
    read = np.empty((3, points.size, count))
    for campaign in range(count):
        sensitivity = 2.5 * (np.eye(3) + 0.005 * rng.normal(size=(3, 3)))
        force, more = scene(rng, size, pitch, roll)
        noise = NOISE_G * rng.normal(size=force.shape)
        read[:, :, campaign] = (0.003 + force @ sensitivity.T + 2.5 * (more + noise)).T
    rows = Observations(
        np.repeat(np.arange(REPLICATIONS), len(GRID)), points, pitch, roll, {}, time_s=30.0 * np.arange(points.size)
    )
    return rows, dict(zip("xyz", read, strict=True))


def _turns(
    scene: Scene, size: float, count: int, seed: int, level: float = SHARE, axes: str = "xyz"
) -> list[AttitudeTurn | None]:
    rows, read = _campaigns(scene, size, count, seed)
    evidence = {}
    for axis in axes:
        centring = centring_of(rows, len(GRID), axis)
        assert centring is not None
        models = [ExtendedPitchRoll(axis, centring)] * count
        evidence[axis] = evidence_of(solve_columns(rows, read[axis], models, None, None, (), None), rows)
    return [judge_attitude_turn([(evidence[axis], index) for axis in axes], level) for index in range(count)]


def _told(scene: Scene, size: float, seed: int) -> list[Finding]:
    rows, read = _campaigns(scene, size, 1, seed)
    outputs = {axis: columns[:, 0] for axis, columns in read.items()}
    seen = Observations(rows.replication, rows.point, rows.pitch_rad, rows.roll_rad, outputs, time_s=rows.time_s)
    found = calibrate(seen, CalibrationRequest())
    return [finding for axis in found.axes.values() for finding in axis.findings if finding.is_significant]


COURSES: Final = [
    (_off_its_centre, "force"),
    (_sagging, "arm"),
    (_pulled_by_pitch, "pitch"),
    (_pulled_either_way, "roll either way"),
]


@pytest.mark.parametrize(("scene", "course"), COURSES)
def test_a_package_that_turns_with_its_attitude_is_told_and_no_sensor_is_blamed(scene: Scene, course: str) -> None:
    """K₂, K_ip and K_io of every sensor were told of perfect ones, and the result was usable."""
    for seed in range(2):
        told = _told(scene, 15.0, seed)
        assert {finding.kind for finding in told} == {"table-rotation"}
        assert len(told) == 3
        assert told[0].details["goes_with"] == course
        assert not any(finding.is_held for finding in told)


@pytest.mark.parametrize(("scene", "course"), COURSES)
def test_each_way_is_told_from_the_others_where_it_is_large(scene: Scene, course: str) -> None:
    told = [turn.course for turn in _turns(scene, 30.0, 20, 3) if turn is not None]
    assert len(told) >= 18
    assert told.count(course) >= 18  # type: ignore[arg-type]


def test_its_size_is_within_its_uncertainty() -> None:
    """By cos(R + φ): √½ of the size about the pitch axis, half of whose square is a fixed turn of the package."""
    turns = [turn for turn in _turns(_sagging, 10.0, 40, 4) if turn is not None]
    assert len(turns) >= 38
    away = np.array([(turn.size_rad - 5.0 * ARCSEC) / turn.standard_uncertainty_rad for turn in turns])
    assert abs(away.mean()) < 0.7
    assert 0.6 < away.std() < 1.4


@pytest.mark.parametrize("most", [1, 2, 8])
@pytest.mark.parametrize("size", [15.0, 50.0])
def test_terms_of_sensors_at_random_are_not_named_a_turn(most: int, size: float) -> None:
    assert sum(turn is not None for turn in _turns(_terms(most), size, 150, 5)) <= 4


@pytest.mark.parametrize("size", [1.0, 10.0])
def test_errors_of_the_indices_are_not_named_a_turn(size: float) -> None:
    assert not any(_turns(_indices_off, size, 100, 6))


def test_where_nothing_is_wrong_it_is_told_no_more_often_than_the_level() -> None:
    level, runs = 0.05, 300
    assert sum(turn is not None for turn in _turns(_still, 0.0, runs, 7, level)) <= level * runs


def test_a_package_of_one_axis_is_not_asked() -> None:
    assert not any(_turns(_off_its_centre, 30.0, 5, 8, axes="x"))
