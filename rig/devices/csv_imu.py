"""A sensor board that streams numbers as lines of text: columns, counts and units are settings, since no standard is.

Raw counts become units by ``counts_per_unit``; presets are those of the sensors of the reports. A count or a time
column makes gaps known; a board without either hides bytes that were lost whole. Boards restart when the port is
opened, so the first line, and any header, is dropped.

Source: SCA3000-D01 1333 counts/g and ITG-3200 14.375 LSB/(°/s) as their public drivers have them. MicroMag3 31.24
counts/µT at period select 2048 is not confirmed (it agrees with the PNI manual's range of ±1100 µT in 16 bits), so
``counts_per_unit`` may be given beside a preset.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from rig.abilities.abilities import StreamBlock, StreamGap
from rig.abilities.stream_reader import RowReader, Wrapping, count_gaps, refusal_gaps, time_gaps
from rig.clock import Clock
from rig.description.device_settings import Positive, StreamSettings
from rig.link.byte_stream import ByteStream
from rig.toml_file import StrictTable
from rig.wire.csv_rows import Checksum, RowShape, parse_rows
from rig.wire.stream_lines import Floats, Rows

UNUSED = "-"
PERIOD_SELECT = 2048
"""Of the MicroMag3's counts per unit; the counts are proportional to it."""


@dataclass(frozen=True, slots=True)
class Preset:
    counts_per_unit: float
    unit: str


PRESETS: Mapping[str, Preset] = {
    "SCA3000": Preset(1333.0, "g"),
    "ITG-3200": Preset(14.375, "dps"),
    "MicroMag3": Preset(31.24, "ut"),
}


class CsvChannel(StrictTable):
    """One ``channels`` entry: how the counts of a column become a quantity."""

    preset: Literal["SCA3000", "ITG-3200", "MicroMag3"] | None = None
    counts_per_unit: float | None = None
    """Signed; instead of the preset's."""
    zero_counts: float = 0.0
    unit: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,15}$")] | None = None
    """As in a key: ``g``, ``dps``, ``ut``, ``v``."""
    period_select: Literal[32, 64, 128, 256, 512, 1024, 2048, 4096] | None = None
    """MicroMag3 only: what the board sets; 2048 where not given."""

    @model_validator(mode="after")
    def _has_a_scale_and_a_unit(self) -> "CsvChannel":
        if self.preset is None and (self.counts_per_unit is None or self.unit is None):
            raise ValueError("give a preset, or counts_per_unit and unit")
        if self.preset is not None and self.unit not in (None, PRESETS[self.preset].unit):
            raise ValueError(f"the unit of {self.preset} is {PRESETS[self.preset].unit}, got {self.unit}")
        if self.period_select is not None and self.preset != "MicroMag3":
            raise ValueError("period_select belongs to the preset MicroMag3")
        if self.counts_per_unit == 0.0:
            raise ValueError("counts_per_unit must not be 0")
        return self

    @property
    def scale(self) -> float:
        """Units per count."""
        if self.counts_per_unit is not None:
            return 1.0 / self.counts_per_unit
        assert self.preset is not None
        period = 1.0 if self.period_select is None else self.period_select / PERIOD_SELECT
        return 1.0 / (PRESETS[self.preset].counts_per_unit * period)

    @property
    def unit_name(self) -> str:
        return self.unit or (PRESETS[self.preset].unit if self.preset else "")


class CsvColumn(StrictTable):
    """``count``: a column that tells the order."""

    column: str
    wraps_at: Positive | None = None
    """It starts again at 0 behind this minus one; None: never."""


class CsvTime(CsvColumn):
    """``time``: a column that tells the order and when."""

    unit_s: Positive = 1.0
    """Seconds of one unit."""


class CsvImuSettings(StreamSettings):
    """``driver = "csv-imu"``."""

    driver: Literal["csv-imu"]
    baud_rate: Annotated[int, Field(ge=1200, le=4_000_000)] = 115200
    rate_hz: Positive
    columns: Annotated[list[str], Field(min_length=1, max_length=64)]
    """Every column of a line in its order; ``-`` for one that is not wanted."""
    channels: dict[str, CsvChannel] = Field(min_length=1)
    """By column."""
    count: CsvColumn | None = None
    time: CsvTime | None = None
    separator: Literal[",", ";", "\t", " "] = ","
    prefix: Annotated[str, Field(max_length=32, pattern=r"^[ -)+-~]*$")] = ""
    checksum: Checksum = "none"
    banner_lines: Annotated[int, Field(ge=0, le=10_000)] = 50
    """So many lines that are no sample may come before the first that is one: boards tell of themselves first."""
    dtr_low: bool = False
    rts_low: bool = False
    """Held low before the port opens; boards with native USB send nothing then. Linux raises DTR for a moment."""

    @model_validator(mode="after")
    def _columns_agree(self) -> "CsvImuSettings":
        wanted = [column for column in self.columns if column != UNUSED]
        declared = [*self.channels, *(extra.column for extra in (self.count, self.time) if extra)]
        for name in (*wanted, *declared):
            if wanted.count(name) != 1 or declared.count(name) != 1:
                raise ValueError(
                    f"column {name!r} must stand once in columns and once in channels, count or time;"
                    f" write {UNUSED!r} in columns for one that is not wanted"
                )
        return self

    def channel_names(self) -> tuple[str, ...]:
        return tuple(self.channels)

    def channel_units(self) -> dict[str, str]:
        return {name: entry.unit_name for name, entry in self.channels.items()}

    def channel_counts(self) -> dict[str, float]:
        return {name: abs(entry.scale) for name, entry in self.channels.items()}

    def samples_hz(self) -> float:
        return self.rate_hz

    def shape(self) -> RowShape:
        """Return how a line is written."""
        return RowShape(len(self.columns), self.separator.encode("ascii"), self.prefix.encode("ascii"), self.checksum)

    def counts(self, column: str, value: float) -> float:
        """Return what the board sends in ``column`` for a value in the channel's unit; 0 where no channel is."""
        entry = self.channels.get(column)
        return 0.0 if entry is None else value / entry.scale + entry.zero_counts


class CsvImu:
    """A :class:`rig.abilities.abilities.Stream`. ``clock`` is the rig's."""

    def __init__(self, name: str, settings: CsvImuSettings, stream: ByteStream, clock: Clock) -> None:
        self.name = name
        self.rate_hz = settings.rate_hz
        self.channels = tuple(f"{name}.{channel}" for channel in settings.channels)
        self.units: Mapping[str, str] = {
            f"{name}.{channel}": entry.unit_name for channel, entry in settings.channels.items()
        }
        self._settings = settings
        self._clock = clock
        self._shape = settings.shape()
        self._reader = RowReader(stream, name, self._parse, settings.banner_lines + 1)
        self._last_count: float | None = None
        self._last_time: float | None = None

    def identify(self) -> str:
        """Return what is known of the board: one of this kind cannot be asked."""
        return f"lines of {len(self._settings.columns)} columns; it cannot be asked who it is"

    def start(self) -> None:
        self._last_count = self._last_time = None
        self._reader.begin()

    def poll(self) -> StreamBlock:
        first = self._reader.rows
        rows = self._reader.take()
        device_s, by_time = self._timed(rows.values)
        return StreamBlock(
            stream=self.name,
            first=first,
            values={
                f"{self.name}.{channel}": self._measured(rows.values, channel) for channel in self._settings.channels
            },
            device_s=device_s,
            polled_s=self._clock.monotonic_s(),
            gaps=self._gaps(rows, by_time),
            refused=len(rows.refused),
        )

    def stop(self) -> None:
        """Do nothing: the board cannot be told to be quiet."""

    def _parse(self, piece: bytes) -> Rows:
        return parse_rows(piece, self._shape)

    def _measured(self, values: Floats, channel: str) -> Floats:
        entry = self._settings.channels[channel]
        measured: Floats = (values[:, self._settings.columns.index(channel)] - entry.zero_counts) * entry.scale
        return measured

    def _timed(self, values: Floats) -> tuple[Floats, tuple[StreamGap, ...]]:
        """Return device time, seconds, and the gaps that it shows."""
        column = self._settings.time
        if column is None or not len(values):
            return np.full(len(values), np.nan), ()
        raw = values[:, self._settings.columns.index(column.column)]
        last = self._last_time
        times = Wrapping(column.wraps_at).unwrapped(raw, last)
        self._last_time = float(times[-1])
        gaps = time_gaps(times * column.unit_s, None if last is None else last * column.unit_s, self.rate_hz)
        return times * column.unit_s, gaps

    def _gaps(self, rows: Rows, by_time: tuple[StreamGap, ...]) -> tuple[StreamGap, ...]:
        """Find the gaps by the count where there is one, else by the time, else by the lines that were refused."""
        column = self._settings.count
        if column is None:
            return by_time if self._settings.time else refusal_gaps(rows.refused)
        if not len(rows.values):
            return ()
        raw = rows.values[:, self._settings.columns.index(column.column)]
        last = self._last_count
        counts = Wrapping(column.wraps_at).unwrapped(raw, last)
        self._last_count = float(counts[-1])
        return count_gaps(counts, last)


def connect(name: str, settings: CsvImuSettings, stream: ByteStream, clock: Clock) -> CsvImu:
    """Return the board behind a stream."""
    return CsvImu(name, settings, stream, clock)
