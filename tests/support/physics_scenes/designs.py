"""Where a table stands, in which order, and when: the schedule of a campaign as flat columns in order of time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from physics_scenes.rotations import FloatArray

CHECK_SET_DEG = ((0.0, 0.0), (0.0, 90.0), (0.0, 180.0), (0.0, -90.0), (60.0, 0.0), (-60.0, 0.0))
REFERENCE_DEG = ((0.0, 0.0), (30.0, 60.0))
"""Two attitudes that differ in pitch and in roll: one alone cannot tell a slip from a tilt (MATH 10)."""

ORDERS = ("there-and-back", "serpentine", "raster", "raster-and-back", "random")


@dataclass(frozen=True)
class Setup:
    """What a laboratory chooses before a campaign. Every scene takes these names as keywords."""

    pitch_limit_deg: float = 90.0
    pitch_count: int = 13
    roll_count: int = 12
    """Uniform from −180°; 1 is a campaign without roll, at roll 0."""
    repeat_roll: bool = False
    """Adds the row at +180°, the same index as −180° (the bench's usual D1)."""
    replications: int = 6
    order: str = "there-and-back"
    reference_every: int = 0
    """Dwells between visits to the reference attitudes; 0 is none."""
    check_set: bool = False
    """A set of six attitudes before the first and after the last point."""
    check_before_count: int = 6
    """Attitudes of the first set that were read before the link was lost."""
    sensors: int = 1
    axes: str = "xyz"
    """Axes of each sensor: "x", "xy", "xz", "xyz" …"""
    mounts: tuple[str, ...] = ()
    """How each sensor stands on the plate: "-x-y+z" has its x axis along −x of the plate; none are all "+x+y+z"."""
    noise_arcsec: float = 1.65
    index_limit_arcsec: float = 1.0
    """What the table's certificate declares; nothing is drawn from it but in the scenes of the table."""
    dwell_s: float = 40.0
    speed_dps: float = 5.0
    plateaus_degc: tuple[float, ...] = (20.0,)
    """Chamber temperature of one replication after the other, over again."""
    soak_s: float = 1800.0
    own_thermometer: bool = False
    """What is recorded is the temperature of the first sensor itself, and not that of the chamber."""
    use_rows: int = 50
    use_pitch_limit_deg: float = 60.0

    def pitches_deg(self) -> FloatArray:
        return np.linspace(-self.pitch_limit_deg, self.pitch_limit_deg, self.pitch_count)

    def rolls_deg(self) -> FloatArray:
        if self.roll_count == 1:
            return np.zeros(1)
        rolls = -180.0 + 360.0 / self.roll_count * np.arange(self.roll_count)
        return np.append(rolls, 180.0) if self.repeat_roll else rolls

    def mount_matrices(self) -> FloatArray:
        """(S, 3, 3) from plate axes to each sensor's own: signed permutations without reflection."""
        matrices = np.zeros((self.sensors, 3, 3))
        for sensor, mount in enumerate(self.mounts or ("+x+y+z",) * self.sensors):
            for row in range(3):
                matrices[sensor, row, "xyz".index(mount[2 * row + 1])] = 1.0 if mount[2 * row] == "+" else -1.0
        if not np.allclose(np.linalg.det(matrices), 1.0):
            raise ValueError(f"mounts: {self.mounts} must be one turn without reflection for each of the sensors")
        return matrices

    def points_deg(self) -> FloatArray:
        """(K, 2) pitch and roll of the design, pitch by pitch."""
        pitch, roll = np.meshgrid(self.pitches_deg(), self.rolls_deg(), indexing="ij")
        return np.stack([pitch.ravel(), roll.ravel()], axis=1)


FINE = {"pitch_count": 37, "roll_count": 36}
REPEATED_ROLL = {"repeat_roll": True}
WITHOUT_ROLL = {"roll_count": 1, "axes": "x"}
"""Keywords of the other designs; the default is 13 × 12."""


@dataclass(frozen=True)
class Schedule:
    """D dwells in order of time; every array is (D,)."""

    purpose: np.ndarray
    """"point", "reference", "check-before", "check-after" or "use"."""
    replication: np.ndarray
    """From 0; −1 for what belongs to none."""
    point: np.ndarray
    """Index into the design, or into the reference or check attitudes."""
    pitch_deg: FloatArray
    roll_deg: FloatArray
    """Indicated: what the table was sent to and says."""
    previous_pitch_deg: FloatArray
    previous_roll_deg: FloatArray
    time_s: FloatArray
    chamber_degc: FloatArray

    @property
    def dwells(self) -> int:
        return self.purpose.size

    @property
    def is_point(self) -> np.ndarray:
        return self.purpose == "point"

    def rows(self, purpose: str) -> np.ndarray:
        """Dwells of one purpose, in order of time."""
        return np.flatnonzero(self.purpose == purpose)

    def grid_rows(self) -> np.ndarray:
        """(R, K) dwell of every replication and point, to shape a flat column into the design."""
        rows = self.rows("point")
        sorted_rows = rows[np.lexsort((self.point[rows], self.replication[rows]))]
        return sorted_rows.reshape(int(self.replication.max()) + 1, -1)

    def run_phase(self) -> FloatArray:
        """Time from −½ at the first point to +½ at the last."""
        points = self.time_s[self.is_point]
        return (self.time_s - points[0]) / (points[-1] - points[0]) - 0.5

    def replication_phase(self) -> FloatArray:
        """Time from 0 to 1 inside each replication; 0 outside of all."""
        phase = np.zeros(self.dwells)
        for replication in range(int(self.replication.max()) + 1):
            rows = self.replication == replication
            first, last = self.time_s[rows][[0, -1]]
            phase[rows] = (self.time_s[rows] - first) / max(last - first, 1.0)
        return phase


def visiting_order(order: str, pitches: int, rolls: int, chance: np.random.Generator) -> np.ndarray:
    """Return the points of one replication in the order in which they are visited.

    there-and-back goes out on every second pitch and comes home on those between, so that time is nearly orthogonal
    to pitch; it turns the roll to and fro, as serpentine does. raster is pitch by pitch, each from the first roll;
    raster-and-back does every second replication the same way backwards.
    """
    indices = np.arange(pitches * rolls).reshape(pitches, rolls)
    if order in ("raster", "raster-and-back"):
        return indices.ravel()
    if order == "random":
        return chance.permutation(indices.size)
    if order not in ORDERS:
        raise ValueError(f"order: {order!r} is none of {', '.join(ORDERS)}")
    rows = np.arange(pitches)
    if order == "there-and-back":
        rows = np.concatenate([rows[::2], rows[1::2][::-1]])
    return np.concatenate([indices[row][:: 1 if turn % 2 == 0 else -1] for turn, row in enumerate(rows)])


def schedule_of(setup: Setup, chance: np.random.Generator) -> Schedule:
    """Lay out a campaign: check set, replications with reference visits between, check set."""
    stops: list[tuple[str, int, int, float, float]] = []
    if setup.check_set:
        stops += _visit("check-before", -1, CHECK_SET_DEG[: setup.check_before_count])
    points = setup.points_deg()
    since = 0
    if setup.reference_every:
        stops += _visit("reference", 0, REFERENCE_DEG)
    for replication in range(setup.replications):
        visits = visiting_order(setup.order, setup.pitch_count, setup.rolls_deg().size, chance)
        is_backwards = setup.order == "raster-and-back" and replication % 2 == 1
        for point in visits[::-1] if is_backwards else visits:
            stops.append(("point", replication, int(point), float(points[point, 0]), float(points[point, 1])))
            since += 1
            if since == setup.reference_every:
                stops += _visit("reference", replication, REFERENCE_DEG)
                since = 0
    if setup.check_set:
        stops += _visit("check-after", -1, CHECK_SET_DEG)
    return timed(stops, setup)


def use_schedule(setup: Setup, chance: np.random.Generator) -> Schedule:
    """Draw the attitudes at which a calibrated package is used, at the first plateau's temperature."""
    pitch = chance.uniform(-setup.use_pitch_limit_deg, setup.use_pitch_limit_deg, setup.use_rows)
    roll = chance.uniform(-180.0, 180.0, setup.use_rows) if setup.roll_count > 1 else np.zeros(setup.use_rows)
    return timed(_visit("use", -1, np.stack([pitch, roll], axis=1).tolist()), setup)


def timed(stops: Sequence[tuple[str, int, int, float, float]], setup: Setup) -> Schedule:
    """Give every stop its time: the longer of both turns, the dwell, and a soak where the chamber changes."""
    purpose, replication, point, pitch, roll = map(np.array, zip(*stops, strict=True))
    before = [np.concatenate([[0.0], angle[:-1]]) for angle in (pitch, roll)]
    turn = np.maximum(np.abs(pitch - before[0]), np.abs(roll - before[1]))
    belongs = np.where(purpose == "check-after", setup.replications - 1, np.maximum(replication, 0))
    chamber = np.array(setup.plateaus_degc)[belongs % len(setup.plateaus_degc)]
    soak = np.where(np.diff(chamber, prepend=chamber[0]) != 0.0, setup.soak_s, 0.0)
    time_s = np.cumsum(turn / setup.speed_dps + setup.dwell_s + soak)
    return Schedule(purpose, replication, point, pitch, roll, before[0], before[1], time_s, chamber)


def _visit(
    purpose: str, replication: int, attitudes_deg: Sequence[Sequence[float]]
) -> list[tuple[str, int, int, float, float]]:
    return [(purpose, replication, index, pitch, roll) for index, (pitch, roll) in enumerate(attitudes_deg)]
