"""The twins' world as a package on the stage feels it: specific force, angular rate, magnetic field, attitude."""

import numpy as np

from rig.description.rig_file import TwinSection, TwinStream
from rig.twins.physics.geometry import Vector
from rig.twins.physics.imu import Motion
from rig.twins.physics.world import World


class StrappedDown:
    """A :class:`rig.twins.physics.imu.MotionSource`. Rates and force include each stream's own bias and noise."""

    def __init__(self, world: World, twin: TwinSection) -> None:
        self._world = world
        self._twin = twin
        self._chance = world.chance

    def motion(self, stream: str, now_s: float) -> Motion:
        truth = self._twin.streams.get(stream, TwinStream())
        rate_dps = self._world.stage_rate_dps(now_s) + np.array(truth.rate_bias_dps)
        yaw, pitch, roll = (self._world.attitude_deg(name, now_s) for name in ("yaw", "pitch", "roll"))
        return Motion(
            force_g=self._noisy(f"{stream}.force", self._world.stage_force_g(now_s), truth.noise_g),
            rate_dps=self._noisy(f"{stream}.rate", rate_dps, truth.noise_dps),
            field_ut=self._noisy(
                f"{stream}.field", self._world.stage_field_ut(np.array(truth.field_ut), now_s), truth.noise_ut
            ),
            attitude_deg=(yaw, pitch, roll),
        )

    def reading(self, channel: str, now_s: float) -> float | None:
        return self._world.read_stream(channel, now_s)

    def _noisy(self, source: str, values: Vector, deviation: float) -> tuple[float, float, float]:
        x, y, z = (
            float(value) + deviation * self._chance.normal(f"stream.{source}.{axis}")
            for axis, value in zip("xyz", values, strict=True)
        )
        return x, y, z
