"""The twin of a board that streams raw counts as lines of text: it talks from the moment it is switched on."""

from collections.abc import Callable, Mapping, Sequence

from rig.twins.physics.imu import MotionSource
from rig.twins.physics.metronome import Metronome
from rig.wire.csv_rows import RowShape, format_row

QUANTITIES = ("ax", "ay", "az", "gx", "gy", "gz", "mx", "my", "mz")
"""Column names that stand for specific force (g), rate (°/s) and field (µT) along the package axes."""

Counts = Callable[[str, float], float]
"""Column and physical value to the board's counts."""


class CsvImuTwin:
    """A :class:`rig.twins.twin.Twin` that sends ``columns`` at ``rate_hz``.

    ``count`` and ``time`` map such a column to where it starts again (None: never) and, for time, to its units per
    second. Columns with other names carry 0.
    """

    def __init__(
        self,
        stream: str,
        source: MotionSource,
        shape: RowShape,
        columns: Sequence[str],
        rate_hz: float,
        counts: Counts,
        *,
        count: Mapping[str, float | None] | None = None,
        time: Mapping[str, tuple[float | None, float]] | None = None,
        banner: bytes = b"",
        reading: Callable[[str, float], float | None] = lambda _column, _at_s: None,
    ) -> None:
        """Make a board.

        ``banner``: what it says when it starts, such as a header line. ``reading``: what a declared sensor puts into a
        column, in the channel's unit; None where the column carries what the package feels.
        """
        self._stream = stream
        self._source = source
        self._shape = shape
        self._columns = tuple(columns)
        self._rate_hz = rate_hz
        self._counts = counts
        self._count = dict(count or {})
        self._time = dict(time or {})
        self._due = banner
        self._reading = reading
        self._beat = Metronome()

    def receive(self, data: bytes, now_s: float) -> None:
        """Do nothing: the board does not listen."""

    def transmit(self, now_s: float) -> bytes:
        if not self._beat.is_running:
            self._beat.start(now_s, self._rate_hz)
        self._due += b"".join(self._line(number, at_s) for number, at_s in self._beat.due(now_s))
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return self._beat.next_s()

    def _line(self, number: int, at_s: float) -> bytes:
        read = {column: self._reading(column, at_s) for column in self._columns}
        sensed = {column: value for column, value in read.items() if value is not None}
        if any(column in QUANTITIES and column not in sensed for column in self._columns):
            motion = self._source.motion(self._stream, at_s)
            values = (*motion.force_g, *motion.rate_dps, *motion.field_ut)
            sensed = dict(zip(QUANTITIES, values, strict=True)) | sensed
        return format_row([self._field(column, number, sensed) for column in self._columns], self._shape)

    def _field(self, column: str, number: int, sensed: Mapping[str, float]) -> bytes:
        if column in self._count:
            return b"%d" % _wrapped(number, self._count[column])
        if column in self._time:
            wraps_at, units_per_s = self._time[column]
            return b"%d" % _wrapped(round(number / self._rate_hz * units_per_s), wraps_at)
        return b"%d" % round(self._counts(column, sensed.get(column, 0.0)))


def _wrapped(number: int, modulus: float | None) -> int:
    return number if modulus is None else number % int(modulus)
