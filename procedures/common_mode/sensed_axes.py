"""The axes that are watched together, and how well they are known: learned from the dwells as they come.

What an axis senses is learned by ridge regression about the declared mount. Two scatters are learned: that of readings
within a dwell, and, from successive visits to the same attitude, that between dwells. Of the latter a rotation of all
sensors alike is taken off first: it is how the table seats, and it is kept apart because all sensors share it. Medians
are taken, so that one step does not hide itself by raising the scatter that it is judged by.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.frames import specific_force
from ams.surveillance.between_runs import MEDIAN_OF_CHI_SQUARE_1
from ams.surveillance.common_mode_columns import WatchedAxes
from ams.surveillance.turns import AXES_OF_TABLE, force_changes
from procedures.records.dwells import DwellRecord, read_back_rad
from rig.description.rig_file import Sensor

UNKNOWN_SEATING_RAD = float(np.deg2rad(0.5 / 3600.0))
"""Of one seating of the table, where too few visits to the same attitude have shown it."""
FEWEST_DIFFERENCES = 6
RIDGE = 1e-3
"""What the declared mount counts for beside one dwell."""
LEAST_SLOPE = 0.3

Attitude = tuple[tuple[str, float], ...]


def attitude_of(dwell: DwellRecord) -> Attitude:
    """Return where a dwell was to stand, as a key."""
    return tuple(dwell.targets_deg.items())


def sensed_axes(sensors: Mapping[str, Sensor]) -> tuple[WatchedAxes, tuple[str, ...]]:
    """Return every accelerometer axis as declared, and its channel."""
    rows = [
        (name, str(axis), channel, _declared(getattr(sensor.mount, axis), sensor.nominal_v_per_g(axis)), sensor.rolls)
        for name, sensor in sensors.items()
        for axis, channel in sensor.channels.items()
        if sensor.nominal_v_per_g(axis)
    ]
    axes = WatchedAxes(
        tuple(row[0] for row in rows),
        tuple(row[1] for row in rows),
        tuple(row[2].partition(".")[0] for row in rows),
        np.array([row[3] for row in rows]).reshape(-1, 3),
        np.array([row[4] for row in rows], dtype=bool),
    )
    return axes, tuple(row[2] for row in rows)


def force_at(dwell: DwellRecord, rolls: BoolArray) -> FloatArray:
    """Return f, (A, 3), where the dwell stood by its read-back. ``rolls``: (A,) whether the roll axis turns each."""
    pitch, roll, yaw = read_back_rad([dwell])
    return np.where(rolls[:, None], specific_force(pitch, roll, yaw), specific_force(pitch, 0.0 * roll, yaw))


def slopes_at(dwell: DwellRecord, rolls: BoolArray) -> list[FloatArray]:
    """Return the change of f by each axis of the table that turns any, (A, 3) each per radian, where the dwell stood.

    ``rolls``: (A,) whether the roll axis turns each.
    """
    pitch, roll, yaw = read_back_rad([dwell])
    rolled = force_changes(pitch, roll, yaw) if rolls.any() else {}
    unrolled = {} if rolls.all() else force_changes(pitch, None, yaw)
    return [
        np.where(rolls[:, None], rolled.get(axis, 0.0), unrolled.get(axis, 0.0))
        for axis in AXES_OF_TABLE
        if axis in rolled or axis in unrolled
    ]


class KnownAxes:
    """What the accepted dwells so far say of A axes."""

    def __init__(self, axes: WatchedAxes, channels: tuple[str, ...]) -> None:
        self._axes, self._channels = axes, channels
        count = len(channels)
        self._information = np.tile(RIDGE * np.eye(4), (count, 1, 1))
        self._moments = np.zeros((count, 4))
        self._squares, self._degrees = np.zeros(count), np.zeros(count)
        self._last: dict[tuple[int, int, Attitude], FloatArray] = {}
        self._differences: list[tuple[int, FloatArray, FloatArray]] = []
        """Place in the run, what is left of the axes' differences, and rotations of all alike."""
        self._taken = 0

    @property
    def taken(self) -> int:
        """How many dwells were learned from: a place in the run."""
        return self._taken

    @property
    def axes(self) -> WatchedAxes:
        """The axes as declared, or as the dwells say."""
        start = np.concatenate([np.zeros((len(self._channels), 1)), self._axes.k], axis=1)
        change = np.linalg.solve(self._information, self._moments[..., None])[..., 0]
        k = (start + change)[:, 1:]
        return replace(self._axes, k=k)

    def means(self, dwell: DwellRecord) -> FloatArray:
        """Return (A,) mean readings, NaN where an axis was not read."""
        return self._statistics(dwell)[0]

    def _statistics(self, dwell: DwellRecord) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return (A,) means, sums of squares over the number of samples, and degrees of freedom."""
        means, squares = np.full(len(self._channels), np.nan), np.zeros((2, len(self._channels)))
        found = [dwell.readings.get(channel) for channel in self._channels]
        sizes = {reading.samples.size for reading in found if reading is not None}
        for size in sizes:  # one, as a rule
            indices = [at for at, reading in enumerate(found) if reading is not None and reading.samples.size == size]
            samples = np.stack(
                [reading.samples for reading in found if reading is not None and reading.samples.size == size]
            )
            means[indices] = samples.mean(axis=1)
            squares[0, indices] = ((samples - means[indices, None]) ** 2).sum(axis=1) / size
            squares[1, indices] = size - 1
        return means, squares[0], squares[1]

    def learn(self, dwell: DwellRecord, plateau: int) -> None:
        """Take an accepted dwell in. ``plateau``: dwells of different ones are not compared."""
        self._taken += 1
        means, squares, degrees = self._statistics(dwell)
        is_read = np.isfinite(means)
        basis = np.insert(force_at(dwell, self._axes.is_rolled), 0, 1.0, axis=1)
        left = np.where(is_read, means - np.einsum("ac,ac->a", self._axes.k, basis[:, 1:]), 0.0)
        self._information += is_read[:, None, None] * (basis[:, :, None] * basis[:, None, :])
        self._moments += left[:, None] * basis
        self._squares += squares
        self._degrees += degrees
        key = (dwell.mounting, plateau, attitude_of(dwell))
        if key in self._last:
            self._learn_difference(dwell, means - self._last[key])
        self._last[key] = means

    def forget_attitudes(self) -> None:
        """Learn no difference between what was measured so far and what comes: a step in between is accepted."""
        self._last.clear()

    def scatter(self, until: int) -> tuple[FloatArray, float, float]:
        """Return (A,) variances of a dwell's mean, their degrees of freedom, and the seating of one dwell, rad.

        ``until``: differences of dwells learned later are left out; a step among them is what is being looked for.
        """
        known = self._degrees > 0.0
        within = np.where(known, self._squares / np.where(known, self._degrees, 1.0), 0.0)
        earlier = [(left, turns) for visit, left, turns in self._differences if visit <= until]
        if len(earlier) < FEWEST_DIFFERENCES:
            return within, float(self._degrees[known].min(initial=np.inf)), UNKNOWN_SEATING_RAD
        left = np.stack([visit for visit, _ in earlier])
        seen = np.isfinite(left).sum(axis=0) >= FEWEST_DIFFERENCES
        between = np.zeros(within.size)
        between[seen] = np.nanmedian(0.5 * left[:, seen] ** 2, axis=0) / MEDIAN_OF_CHI_SQUARE_1
        turns = np.concatenate([turned for _, turned in earlier])
        seating = float(np.sqrt(np.median(0.5 * turns**2) / MEDIAN_OF_CHI_SQUARE_1)) if turns.size else 0.0
        return np.maximum(within, between), float(self._degrees[known].min(initial=np.inf)), seating

    def _learn_difference(self, dwell: DwellRecord, difference: FloatArray) -> None:
        slopes = slopes_at(dwell, self._axes.is_rolled)
        size = np.linalg.norm(self._axes.k, axis=1)
        columns = np.stack([np.einsum("ac,ac->a", self._axes.k, slope) / size for slope in slopes], axis=1)
        is_read = np.isfinite(difference)
        if int(is_read.sum()) <= columns.shape[1]:
            return
        angles = difference[is_read] / size[is_read]
        turns, _, rank, _ = np.linalg.lstsq(columns[is_read], angles, rcond=1e-6)
        left = np.full(difference.size, np.nan)
        freedom = is_read.sum() / (is_read.sum() - rank)
        left[is_read] = (angles - columns[is_read] @ turns) * size[is_read] * np.sqrt(freedom)
        steep = np.array([float(np.linalg.norm(slope[is_read], axis=1).max()) > LEAST_SLOPE for slope in slopes])
        self._differences.append((self._taken, left, turns[steep]))


def _declared(direction: str, nominal_per_g: float) -> FloatArray:
    """Return the sensitive axis of a mount such as ``-x``."""
    k = np.zeros(3)
    k["xyz".index(direction[1])] = nominal_per_g if direction[0] == "+" else -nominal_per_g
    return k
