"""All calibrations of packages of one kind, in columns: what charts, scatter and mix-ups are worked out from.

A characteristic (:mod:`ams.surveillance.characteristics`) is looked at as a small angle: an offset or a sensitivity
divided by
the sensitivity, an angle between axes as it is. So one scale serves all, and what counts is what an angle measured with
the package would be off by. Rows stand by sensor, then by time.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from itertools import pairwise

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.surveillance.characteristics import Characteristics, PackageNumbers, characteristics_of, rotations_rad

SECONDS_PER_YEAR = 365.25 * 86400.0


@dataclass(frozen=True)
class PointLabel:
    """Which calibration a row is."""

    sha256: str
    sensor: str
    run_id: str | None
    created_utc: datetime
    rig: str
    is_check: bool
    gravity_mps2: float


@dataclass(frozen=True)
class Population:
    """N calibrations of packages with the same axes, by sensor, then by time."""

    labels: Sequence[PointLabel]
    numbers: PackageNumbers
    shared_rad: FloatArray | None = None
    """(N, p) what of the coordinates is no sensor's but the meter's (:mod:`ams.surveillance.shared_changes`); None for
    nothing."""

    @cached_property
    def characteristics(self) -> Characteristics:
        return characteristics_of(self._at_latest_gravity())

    @cached_property
    def coordinates(self) -> FloatArray:
        """(N, p) characteristics as small angles, radians, without what is the meter's.

        Sensitivities and offsets are against the first of the sensor's calibrations.
        """
        angles = self.characteristics.value / self.first_scale
        return angles if self.shared_rad is None else angles - self.shared_rad

    @cached_property
    def first_scale(self) -> FloatArray:
        """(N, p) what a change is divided by to become a small angle, of the sensor's first calibration."""
        return np.asarray(self.characteristics.scale[self.starts[self.sensor_index]])

    @cached_property
    def scatter_rad(self) -> FloatArray:
        """(N, p) the standard uncertainty that is drawn anew in every run, as a small angle."""
        return self.characteristics.scatter / self.characteristics.scale

    @cached_property
    def sensor_index(self) -> IntArray:
        """(N,) 0 for the rows of the first sensor, 1 for those of the second, and so on."""
        names = [label.sensor for label in self.labels]
        changes = [0, *(int(now != before) for before, now in pairwise(names))]
        return np.cumsum(changes, dtype=np.int64)

    @cached_property
    def starts(self) -> IntArray:
        """(sensors,) first row of every sensor."""
        return np.flatnonzero(np.diff(self.sensor_index, prepend=-1))

    @cached_property
    def years(self) -> FloatArray:
        """(N,) since 1970."""
        return np.array([label.created_utc.timestamp() for label in self.labels]) / SECONDS_PER_YEAR

    @property
    def kinds(self) -> tuple[str, ...]:
        """(p) what each characteristic is: ``offset_v``, ``sensitivity_v_per_g``, ``angle_deg``."""
        return tuple(name.partition(".")[0] for name in self.characteristics.names)

    def rows_of(self, sensor: str) -> slice:
        """Return the rows of one sensor, empty where it has none."""
        rows = [index for index, label in enumerate(self.labels) if label.sensor == sensor]
        return slice(rows[0], rows[-1] + 1) if rows else slice(0, 0)

    def rotation_deg(self, rows: slice) -> FloatArray:
        """Return (n, 3) how the package sat on the table, turned against its first calibration there.

        Of a check sensor that is its first one as such. A rotation from another mount with a tilt behind it is no sum
        of both by its axes: what tilts after it mixes into the others.
        """
        directions = self.numbers.directions[rows]
        mounted = [label.is_check for label in self.labels[rows]]
        return np.degrees(rotations_rad(directions, directions[mounted.index(True) if any(mounted) else 0]))

    def _at_latest_gravity(self) -> PackageNumbers:
        """Return the numbers per the g of each sensor's latest calibration.

        A sensor that was calibrated at two sites has one sensitivity.
        """
        if self.numbers.unit != "g":
            return self.numbers
        gravity = np.array([label.gravity_mps2 for label in self.labels])
        last = np.append(self.starts[1:], len(self.labels)) - 1
        ratio = gravity[last[self.sensor_index]] / gravity
        if np.all(ratio == 1.0):
            return self.numbers
        scale = np.stack([np.ones_like(ratio), ratio, ratio, ratio], axis=-1)[:, None, :]
        spread = scale[..., :, None] * scale[..., None, :]
        numbers = self.numbers
        return replace(
            numbers,
            primary=numbers.primary * scale,
            covariance=numbers.covariance * spread,
            scatter=numbers.scatter * spread,
        )
