"""Packages that roll turns and packages on a sting, watched together: matrices turn gravity, one after another."""

from collections.abc import Mapping

import numpy as np
import pytest
from physics_scenes.rotations import ARCSEC, LEVEL_FORCE, pitch_matrix, roll_matrix, turn_matrix, turned, yaw_matrix

from ams.surveillance.common_mode import CommonMode, judge_visits
from ams.surveillance.common_mode_columns import Visits, WatchedAxes

STOOD_DEG = {
    "pitch": np.array([5.0, 30.0, -40.0]),
    "yaw": np.array([0.0, 20.0, -25.0]),
    "roll": np.array([0.0, 60.0, -50.0]),
}
NOISE_V = 1e-5
"""0.8″."""


def _judged(
    rolls: tuple[bool, ...],
    chance: np.random.Generator,
    slips_arcsec: Mapping[str, float],
    on_mount_arcsec: Mapping[int, tuple[float, float, float]] | None = None,
) -> CommonMode:
    """Judge three-axis packages at three attitudes, seen twice; ``on_mount_arcsec``: how packages turned by themselves.

    ``rolls``: whether roll turns each package.
    """
    directions = 2.5 * (np.eye(3) + 0.005 * chance.standard_normal((len(rolls), 3, 3)))

    def read(slip: Mapping[str, float], mounts: Mapping[int, tuple[float, float, float]]) -> np.ndarray:
        pitch, yaw, roll = (np.deg2rad(STOOD_DEG[axis]) + slip.get(axis, 0.0) * ARCSEC for axis in STOOD_DEG)
        on_sting = turned(yaw_matrix(yaw), turned(pitch_matrix(pitch), LEVEL_FORCE))
        packages = []
        for index, is_rolled in enumerate(rolls):
            force = turned(roll_matrix(roll), on_sting) if is_rolled else on_sting
            force = turned(turn_matrix(ARCSEC * np.array(mounts.get(index, (0.0, 0.0, 0.0)))), force)
            packages.append(force @ directions[index].T)
        clean = np.concatenate(packages, axis=1)
        return clean + NOISE_V * chance.standard_normal(clean.shape)

    before, after = read({}, {}), read(slips_arcsec, on_mount_arcsec or {})
    sensors = tuple(f"S{index}" for index in range(len(rolls)) for _ in "xyz")
    axes = WatchedAxes(
        sensors, tuple("xyz" * len(rolls)), ("dmm",) * len(sensors), np.concatenate(directions), np.repeat(rolls, 3)
    )
    pitch, yaw, roll = (np.deg2rad(STOOD_DEG[axis]) for axis in STOOD_DEG)
    variance = np.full(before.shape, 2.0 * NOISE_V**2)
    return judge_visits(axes, Visits(pitch, roll, after - before, after, variance, 100.0, yaw_rad=yaw), 0.001)


@pytest.mark.parametrize("rolls", [(True, True, False), (True, False), (False, False), (False,)])
@pytest.mark.parametrize("size_arcsec", [-72.0, 15.0])
@pytest.mark.parametrize("axis", ["pitch", "yaw", "roll"])
def test_a_slip_is_told_with_axis_and_size_by_those_that_it_turns(
    rolls: tuple[bool, ...], axis: str, size_arcsec: float
) -> None:
    found = _judged(rolls, np.random.default_rng(1), {axis: size_arcsec})
    if axis == "roll" and not any(rolls):
        assert not found.stated
        assert not found.sensor_changes
        return
    (stated,) = found.stated
    assert (stated.kind, stated.parts) == ("table-rotation", (axis,))
    size = found.estimates[axis]
    assert (
        abs(np.rad2deg(size.value) * 3600.0 - size_arcsec) < 4.0 * np.rad2deg(size.standard_uncertainty) * 3600.0 + 0.3
    )
    assert not found.sensor_changes
    assert set(found.agreeing) == {f"S{at}" for at, is_rolled in enumerate(rolls) if is_rolled or axis != "roll"}


def test_one_on_the_sting_that_turned_by_itself_is_loose_on_its_mount() -> None:
    found = _judged((True, True, False), np.random.default_rng(2), {}, {2: (40.0, -25.0, 15.0)})
    assert not found.stated
    (odd,) = found.sensor_changes
    assert (odd.sensor, odd.attribution.culprit) == ("S2", "mount")


def test_a_lone_one_on_the_sting_that_turned_as_no_axis_turns_it_is_on_its_mount_or_the_fixture() -> None:
    found = _judged((False,), np.random.default_rng(3), {}, {0: (40.0, -25.0, 15.0)})
    assert [cause.name for cause in found.stated] == ["fixture"]


@pytest.mark.parametrize("rolls", [(True, True, False), (False, False), (False,)])
def test_what_stands_as_it_did_is_told_of_in_one_of_a_thousand(rolls: tuple[bool, ...]) -> None:
    """At 0.001 a test, of a few tests: more than five of 300 by chance once in a thousand times."""
    told = [_judged(rolls, np.random.default_rng([4, seed]), {}) for seed in range(300)]
    assert sum(bool(found.stated or found.sensor_changes) for found in told) <= 5
