"""What accelerometers and gyros cannot test of themselves, told once: what is assumed of their use, and dead outputs.

Three outputs have a length that has to be g. One or two have an angle for every number that they give: a row cannot be
flagged, so the rows together are looked at.
"""

from collections.abc import Mapping
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.inference.angle_stream import AngleStream, Answer
from ams.inference.inference import Package
from ams.inference.rates import GyroAngles

LEAST_ROWS: Final = 20
"""Fewer say nothing of an output that does not change."""
_NEAR_SD: Final = 5.0
SD_OF_A_READING: Final = (
    "standard deviations count the noise of one reading, as the calibration saw it: how much less an average or a "
    "filtered output has depends on how the noise goes on from sample to sample; --reading-sd-v states its own"
)


def assumed_gravity(package: Package) -> str:
    """Say by which g the angles are told, and that nothing here tests it or the outputs."""
    site, names = package.site_gravity_mps2, ", ".join(package.columns)
    g_mps2 = package.coefficients.gravity_mps2 if site is None else site
    said = "that of the calibration; --gravity-mps2 states another" if site is None else "as stated"
    axes = "one axis" if len(package.columns) == 1 else "two axes"
    return (
        f"{package.coefficients.sensor}: {axes} ({names}): g is taken as {g_mps2:.5f} m/s², {said}; nothing in the "
        "rows tests it, nor the outputs: what three axes would flag stays unseen"
    )


def assumed_of_gyros(angles: GyroAngles) -> tuple[str, ...]:
    """Say what is taken for granted of gyros alone, in no standard deviation and in no flag."""
    motion, name = angles.motion, angles.package.coefficients.sensor
    said = []
    if motion.start_deg is None or motion.start_sd_deg is None:
        pitch, yaw, roll = motion.stated_start_deg
        sd = "exactly" if motion.start_sd_deg is None else f"within {motion.start_sd_deg:g}° (standard deviation)"
        options = "--start-deg and --start-sd-deg state it" if motion.start_deg is None else "--start-sd-deg states it"
        said.append(
            f"{name}: the start is taken as pitch {pitch:g}°, yaw {yaw:g}°, roll {roll:g}°, known {sd}; {options}"
        )
    if motion.earth is None and not motion.rest_s:
        said.append(
            f"{name}: the Earth's turn, up to 15° an hour, is left in the angles and is in no standard deviation; "
            "--latitude-deg and --heading-deg take it off"
        )
    if motion.interpolation != "cubic":
        said.append(f"{name}: --interpolation {motion.interpolation}: what it makes wrong is in no standard deviation")
    return tuple(said)


def remarks_on_rest(angles: GyroAngles) -> tuple[str, ...]:
    """Say what the rest at the beginning told of the zeros, and where it was none."""
    zero, package = angles.zero, angles.package
    if zero is None:
        return ()
    name = package.coefficients.sensor
    inverse = np.linalg.inv(package.k_v_per_rad_s)
    moved = np.rad2deg(inverse @ (zero.mean_v - package.at_rest_v))
    by_axis = ", ".join(f"{axis} {dps:+.2g}" for axis, dps in zip(package.columns, moved, strict=True))
    said = f"{name}: at rest the outputs lie {by_axis} °/s from the zeros of the calibration; they are taken as zeros"
    if zero.is_still:
        return (said,)
    widest = np.rad2deg(np.abs(inverse) @ zero.scatter_v).max()
    return (
        said,
        f"{name}: it did not rest: over the time of --rest-s the outputs moved by {widest:.2g} °/s, more than their "
        "noise explains; the standard deviations grow by that; give --rest-s a stretch over which nothing turns, or "
        "leave it out",
    )


class WatchedOutputs:
    """Angles from outputs, with an eye on outputs that do not change from the first row to the last."""

    def __init__(self, angles: AngleStream, package: Package, reading_sd_v: float | None) -> None:
        self._angles, self._columns = angles, tuple(package.columns.values())
        sensors = package.sensors({"temperature_degc": np.zeros(1)}, reading_sd_v)
        self._offset_v = np.array([sensor.offset_v for sensor in sensors])
        self._sd_v = np.array([sensor.reading_sd_v for sensor in sensors])
        self._rows = 0
        self._least, self._most = np.full(len(sensors), np.inf), np.full(len(sensors), -np.inf)

    @property
    def needed(self) -> tuple[str, ...]:
        return self._angles.needed

    @property
    def optional(self) -> tuple[str, ...]:
        return self._angles.optional

    @property
    def answers(self) -> tuple[str, ...]:
        return self._angles.answers

    @property
    def answers_at_once(self) -> bool:
        return self._angles.answers_at_once

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        """Return the angles of further rows."""
        outputs = np.stack([readings[column] for column in self._columns])
        finite = outputs[:, np.isfinite(outputs).all(axis=0)]
        if finite.shape[1]:
            self._rows += finite.shape[1]
            self._least = np.minimum(self._least, finite.min(axis=1))
            self._most = np.maximum(self._most, finite.max(axis=1))
        return self._angles.answer(readings)

    def finish(self) -> Answer:
        """Return the angles that are still due."""
        return self._angles.finish()

    def doubts(self) -> tuple[str, ...]:
        """Name the outputs that never changed, or lay at their offset in every row."""
        if self._rows < LEAST_ROWS:
            return ()
        near = _NEAR_SD * self._sd_v
        is_at_offset = (self._least > self._offset_v - near) & (self._most < self._offset_v + near)
        is_constant = self._least == self._most
        words = {
            column: "is the same number" if constant else "lies at its offset"
            for column, constant, at_offset in zip(self._columns, is_constant, is_at_offset, strict=True)
            if constant or at_offset
        }
        return tuple(
            f"{column} {what} in all {self._rows} rows: a dead axis, a broken wire or an input that reads nothing "
            "looks like that, and so does a package that never moved; look before the angles are used"
            for column, what in words.items()
        )
