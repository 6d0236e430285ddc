"""The twins' world as a package on the stage feels it: specific force, angular rate, magnetic field, attitude."""

import math

import numpy as np

from rig.description import TwinSection, TwinStream
from rig.twins.chance import Chance
from rig.twins.geometry import Matrix, Vector, about_x, about_y, about_z
from rig.twins.imu import Motion
from rig.twins.world import World

_HALF_STEP_S = 5e-4
"""Rates are differences of the stage's own attitude over twice this."""


class StrappedDown:
    """A :class:`rig.twins.imu.MotionSource`. Rates and force include each stream's own bias and noise."""

    def __init__(self, world: World, twin: TwinSection) -> None:
        self._world = world
        self._twin = twin
        self._chance = Chance(twin.seed)

    def motion(self, stream: str, now_s: float) -> Motion:
        truth = self._twin.streams.get(stream, TwinStream())
        stage = self._stage(now_s)
        rate_dps = np.degrees(self._rate_radps(now_s)) + np.array(truth.rate_bias_dps)
        return Motion(
            force_g=self._noisy(f"{stream}.force", self._world.stage_force_g(now_s), truth.noise_g),
            rate_dps=self._noisy(f"{stream}.rate", rate_dps, truth.noise_dps),
            field_ut=self._noisy(f"{stream}.field", stage @ np.array(truth.field_ut), truth.noise_ut),
            attitude_deg=self._attitude_deg(now_s),
        )

    def _angles_rad(self, now_s: float) -> dict[str, float]:
        return {name: body.attitude_rad(now_s) for name, body in self._world.axes.items()}

    def _stage(self, now_s: float) -> Matrix:
        """From level axes into package axes: pitch, yaw, roll from outside in."""
        angles = self._angles_rad(now_s)
        stage: Matrix = (
            about_x(angles.get("roll", 0.0)) @ about_z(angles.get("yaw", 0.0)) @ about_y(angles.get("pitch", 0.0))
        )
        return stage

    def _rate_radps(self, now_s: float) -> Vector:
        """ω in package axes from dR/dt = −[ω×] R."""
        before, after = self._stage(now_s - _HALF_STEP_S), self._stage(now_s + _HALF_STEP_S)
        cross = -(after - before) / (2.0 * _HALF_STEP_S) @ self._stage(now_s).T
        return np.array([cross[2, 1] - cross[1, 2], cross[0, 2] - cross[2, 0], cross[1, 0] - cross[0, 1]]) / 2.0

    def _attitude_deg(self, now_s: float) -> tuple[float, float, float]:
        angles = self._angles_rad(now_s)
        yaw, pitch, roll = (math.degrees(angles.get(name, 0.0)) for name in ("yaw", "pitch", "roll"))
        return yaw, pitch, roll

    def _noisy(self, source: str, values: Vector, deviation: float) -> tuple[float, float, float]:
        x, y, z = (
            float(value) + deviation * self._chance.normal(f"stream.{source}.{axis}")
            for axis, value in zip("xyz", values, strict=True)
        )
        return x, y, z
