"""Laws of what a streaming package feels. Independent answers: rotations by scipy, rates by hand."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from table_bench import example_rig

from rig.description.rig_file import TwinSection, TwinStream
from rig.twins.physics.strapped_down import StrappedDown
from rig.twins.physics.world import World

QUIET = TwinStream(noise_g=0.0, noise_dps=0.0, noise_ut=0.0, field_ut=(20.0, 3.0, 40.0))


def _package(truth: TwinStream = QUIET) -> tuple[World, StrappedDown]:
    description = example_rig()
    world = World(description)
    return world, StrappedDown(world, TwinSection(seed=3, streams={"imu": truth}))


@pytest.mark.parametrize(
    ("pitch_deg", "roll_deg", "force_g"),
    [
        (0.0, 0.0, (0.0, 0.0, -1.0)),
        (90.0, 0.0, (1.0, 0.0, 0.0)),  # +pitch gives +1 on x
        (0.0, 90.0, (0.0, -1.0, 0.0)),  # roll +90° gives −1 on y
    ],
)
def test_it_feels_what_the_convention_says(pitch_deg: float, roll_deg: float, force_g: tuple[float, ...]) -> None:
    world, package = _package()
    world.rotate("pitch", pitch_deg, 0.0)
    world.rotate("roll", roll_deg, 0.0)
    assert package.motion("imu", 1e4).force_g == pytest.approx(force_g, abs=2e-5)  # teeth are off by an arc second


def test_the_field_turns_with_the_package() -> None:
    world, package = _package()
    world.rotate("pitch", 30.0, 0.0)
    world.rotate("roll", -40.0, 0.0)
    # Intrinsic yaw, pitch, roll takes package components to level ones.
    to_level = Rotation.from_euler("ZYX", [0.0, 30.0, -40.0], degrees=True)
    expected = to_level.inv().apply([20.0, 3.0, 40.0])
    np.testing.assert_allclose(package.motion("imu", 1e4).field_ut, expected, atol=2e-3)


def test_rates_are_those_of_the_axes_that_turn() -> None:
    world, package = _package()
    world.rotate("roll", 60.0, 0.0)
    world.rotate("pitch", 100.0, 1000.0)  # 5 °/s, for 20 s, about the axis that lies outside the roll
    roll = np.radians(60.0)
    expected = (0.0, 5.0 * np.cos(roll), -5.0 * np.sin(roll))
    np.testing.assert_allclose(package.motion("imu", 1010.0).rate_dps, expected, atol=1e-3)
    np.testing.assert_allclose(package.motion("imu", 5000.0).rate_dps, 0.0, atol=1e-6)


def test_bias_and_noise_are_as_told() -> None:
    truth = TwinStream(rate_bias_dps=(0.5, 0.0, -0.25), noise_g=0.001, noise_dps=0.02, noise_ut=0.1)
    _, package = _package(truth)
    motions = [package.motion("imu", 1.0) for _ in range(4000)]
    rates = np.array([motion.rate_dps for motion in motions])
    np.testing.assert_allclose(rates.mean(axis=0), (0.5, 0.0, -0.25), atol=5 * 0.02 / np.sqrt(4000))
    np.testing.assert_allclose(rates.std(axis=0), 0.02, rtol=0.06)
    np.testing.assert_allclose(np.std([motion.force_g for motion in motions], axis=0), 0.001, rtol=0.06)
