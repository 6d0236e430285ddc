"""The Earth turns under a gyro: 15° an hour, of which a gyro at rest reads its share and an attitude loses as much.

Gyros tell the turn against the stars. The reference frame of an attitude (x forward at zero angles, y right, z down)
stands on the Earth and turns with it at a rate that is constant in the frame itself; so the attitude against the Earth
is the one against the stars, turned back by what the frame has turned since the start. That is exact.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.attitude.quaternion import from_turn, multiply
from ams.errors import ObservationsError

EARTH_RATE_RAD_S: Final = 7.292115e-5
"""Sidereal. Source: WGS 84."""


@dataclass(frozen=True)
class EarthRate:
    """Where on the Earth, and how the reference frame stands there."""

    latitude_deg: float
    """North positive."""
    heading_deg: float
    """Of the frame's x axis, from north through east."""

    def __post_init__(self) -> None:
        if not (abs(self.latitude_deg) <= 90.0 and abs(self.heading_deg) <= 360.0):
            raise ObservationsError(
                f"Earth rate: got latitude {self.latitude_deg:g}° and heading {self.heading_deg:g}°, allowed within "
                "±90° and ±360°; nothing was computed"
            )

    @property
    def rate_rad_s(self) -> FloatArray:
        """(3,) of the reference frame against the stars, along its own axes."""
        latitude, heading = np.deg2rad([self.latitude_deg, self.heading_deg])
        north, down = np.cos(latitude), -np.sin(latitude)
        return EARTH_RATE_RAD_S * np.array([north * np.cos(heading), -north * np.sin(heading), down])

    def against_earth(self, quaternion: FloatArray, time_s: FloatArray) -> FloatArray:
        """Return the (4, n) attitudes against the Earth of those against the stars, times from the start."""
        back = from_turn(-time_s[:, None] * self.rate_rad_s)
        return np.asarray(multiply(back, quaternion.T).T)
