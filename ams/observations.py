"""Observations: what the solvers are given, whoever measured them.

One row a dwell: which replication, which design point, the attitude of the package (radians) and the mean output
of every sensor axis in its own unit; for gyros also the rates of the angles. Degrees exist only in files: the readers
here convert at the edge.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from ams.arrays import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class Sampled:
    """What the single samples of an output show, of which its rows have the means only."""

    step: float | None
    """What they are whole multiples of, in the unit of the outputs; None where none shows."""
    variance: float
    """Of the samples about the mean of their dwell, by their number: the mean over the dwells; of rounded samples."""
    points: int
    """At how many points of the design they were taken."""


@dataclass(frozen=True)
class Observations:
    """Rows of dwells, all arrays of the same length N.

    A (replication, point) pair stands once; a replication may lack points.
    """

    replication: IntArray
    """(N,) label of the replication."""
    point: IntArray
    """(N,) label of the design point: the same label is the same attitude in every replication."""
    pitch_rad: FloatArray
    roll_rad: FloatArray
    outputs: Mapping[str, FloatArray]
    """(N,) per sensor axis, keyed ``x``, ``y``, ``z`` (or the single axis' name), in its unit: see ``units``."""
    yaw_rad: FloatArray | None = None
    temperature_degc: FloatArray | None = None
    """(N,) the sensor's own temperature, or None where none was measured."""
    time_s: FloatArray | None = None
    """(N,) seconds since the start of the run, or None."""
    euler_rate_rad_s: FloatArray | None = None
    """(N, 3) rates of pitch, yaw and roll, radians per second; None where nothing turned."""
    reference_level: FloatArray | None = None
    """(N,) known value of the quantity in its own unit, for straight lines; None otherwise."""
    level_errors: FloatArray | None = None
    """(N, q) what one standard uncertainty of each of q errors does to ``reference_level``; None: it has none."""
    scanned_v: FloatArray | None = None
    """(N, q) volts on each of the q channels of a scanner that leaks, this sensor's among them; None: none does."""
    gravity_errors_rad: FloatArray | None = None
    """(N, 3, q) along package axes, what one standard uncertainty of each of q errors turns the direction of gravity
    by; None: it is that of the angles."""
    mounting: IntArray | None = None
    """(N,) label of the mounting, the last the highest; None where the package was never moved."""
    step: IntArray | None = None
    """(N,) the run's step of every dwell, as the journal counts; None where there is no run."""
    from_level: FloatArray | None = None
    """(N, 3, 3) mean rotation from level axes into the package's while a row was read; None where nothing needs it."""
    units: Mapping[str, str] = field(default_factory=dict)
    """Unit of the outputs of an axis as it is written in a key, such as ``dps`` or ``counts``; volts where absent."""
    sampled: Mapping[str, Sampled] = field(default_factory=dict)
    """Of the axes whose rows are means of samples that are known; readings tell of themselves where it is absent."""
    source: str = field(default="observations", compare=False)
    """Where they come from, for messages: a file name or a run."""
    run: str = field(default="", compare=False)
    """The run as its commands take it, for what a person is to do; empty of rows that are of none."""

    def unit_of(self, axis: str) -> str:
        """Return the unit of an axis' outputs, as it is written in a key."""
        return self.units.get(axis, "v")

    @property
    def is_of_levels(self) -> bool:
        """Whether known levels, not attitudes, are what the points differ by."""
        return self.reference_level is not None

    @property
    def rows(self) -> int:
        return int(self.replication.size)
