"""Meters that read angles on demand: inclinometers, tiltmeters, autocollimators. The grammar is a dialect.

A channel tells the attitude of one axis in degrees, whatever the device's unit is. That unit is what its manual leaves,
what it tells with every reading, or what it answers before and behind every burst; where it tells nothing, what the rig
file states. A reading outside the range that the file gives is an overload and no angle.

Source: docs/devices/attitude-references.md.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field

from rig.abilities.abilities import Burst, Wait
from rig.clock import Clock
from rig.description.device_settings import Positive, ReadoutSettings
from rig.errors import DescriptionError, DeviceFault, FileContradicted, RequestRefused
from rig.link.byte_stream import ByteStream
from rig.link.exchange import Exchange, Patience, shown
from rig.toml_file import StrictTable
from rig.wire.angle_dialect import AngleDialect, AngleUnit, NamedAngleDialect, load_angle_dialect, to_deg
from rig.wire.angle_lines import AngleCodec, Question, Reading
from rig.wire.dialect_files import WRITTEN_OUT, dialect_file

MOST_SAMPLES = 100_000
QUIET_S = 0.3
"""Longer than a device that streams leaves between two lines."""
_STREAMED_BYTES, _SHOWN_BYTES = 4, 40
"""Fewer that come unasked are noise of the line."""


class AngleChannel(StrictTable):
    """One ``channels`` entry."""

    about: Literal["pitch", "yaw", "roll"]
    """The axis whose attitude it tells."""
    value: Literal["x", "y"] = "x"
    """Which number of an answer."""
    axis: Annotated[int, Field(ge=1, le=9)] = 1
    """Of the device, where a question names one."""
    sign: Literal[1, -1] = 1
    """Reading = sign × attitude + zero_deg."""
    zero_deg: float = 0.0
    range_deg: Positive | None = None
    """A reading beyond ± this is an overload."""

    def attitude_deg(self, reading_deg: float) -> float:
        return self.sign * (reading_deg - self.zero_deg)

    def reading_deg(self, attitude_deg: float) -> float:
        return self.sign * attitude_deg + self.zero_deg


class AngleMeterSettings(ReadoutSettings):
    """``driver = "angle-meter"``."""

    names_files: ClassVar[tuple[str, ...]] = ("dialect",)
    driver: Literal["angle-meter"]
    resource: str
    """``twin``, a serial device by its stable id, ``socket://host:port``."""
    dialect: NamedAngleDialect
    values: AngleUnit | None = None
    """The unit on the wire; None: as the device tells it, or its manual. Compared where it is told."""
    baud_rate: Annotated[int, Field(ge=300, le=921600)] | None = None
    """None: the dialect's."""
    channels: dict[str, AngleChannel] = Field(min_length=1)

    def channel_names(self) -> tuple[str, ...]:
        return tuple(self.channels)

    def channel_units(self) -> dict[str, str]:
        return dict.fromkeys(self.channels, "deg")

    def attitude_axes(self) -> dict[str, str]:
        return {name: channel.about for name, channel in self.channels.items()}

    def reading_s(self, nplc: float | None = None) -> float:  # noqa: ARG002 it has no integration time to choose
        return load_angle_dialect(self.dialect).reading_s

    def file_complaints(self, folder: Path) -> Iterator[tuple[tuple[str, ...], str]]:
        if isinstance(self.dialect, AngleDialect):
            yield ("dialect",), WRITTEN_OUT
            return
        try:
            dialect = load_angle_dialect(self.with_files(folder).dialect)
        except DescriptionError as error:
            yield ("dialect",), str(error)
            return
        if self.values is None and not dialect.tells_unit:
            yield (
                ("values",),
                f"a device of the dialect {dialect.name} cannot be asked for its unit; look at it and write one of deg,"
                " arcmin, arcsec, rad, mrad, urad, mm_per_m",
            )
        if dialect.unit is not None and self.values not in (None, dialect.unit):
            yield (
                ("values",),
                f"got {self.values}, but the dialect {dialect.name} has {dialect.unit} alone; leave it out",
            )
        for name, channel in self.channels.items():
            if channel.value not in dialect.values:
                known = ", ".join(sorted(dialect.values))
                yield ("channels", name, "value"), f"got {channel.value}, the dialect {dialect.name} reads {known}"

    def with_files(self, folder: Path) -> Self:
        if not isinstance(self.dialect, str) or (file := dialect_file(self.dialect, folder)) is None:
            return self
        return self.model_copy(update={"dialect": load_angle_dialect(str(file))})


class AngleMeter:
    """A :class:`rig.abilities.abilities.Readout` in degrees."""

    def __init__(
        self, name: str, settings: AngleMeterSettings, dialect: AngleDialect, stream: ByteStream, clock: Clock
    ) -> None:
        self.name = name
        self.channels = tuple(f"{name}.{channel}" for channel in settings.channels)
        self._by_channel = dict(zip(self.channels, settings.channels.values(), strict=True))
        self._settings, self._dialect, self._clock = settings, dialect, clock
        self._codec = AngleCodec(dialect)
        patience = Patience(timeout_s=dialect.reply_timeout_s, quiet_s=QUIET_S)
        self._exchange = Exchange(
            stream,
            terminator=self._codec.reply_terminator,
            patience=patience,
            resynchronise=None if dialect.quiet is None else self._fall_quiet,
        )

    def identify(self) -> str:
        if self._dialect.identity is None:
            who = f"{self._dialect.name}, not asked who it is"
        else:
            question = self._codec.ask(Question("identity"))
            lines = self._codec.reply_lines("identity")
            who = self._exchange.ask(question, self._codec.parse_identity, idempotent=True, lines=lines)
        units = {self._unit(channel) for channel in self._by_channel.values()}
        return f"{who}, values in {', '.join(sorted(units))}"

    def prepare(self) -> None:
        self._exchange.doubt()
        self.identify()

    def read(self, channel: str, samples: int, wait: Wait, nplc: float | None = None) -> Burst:  # noqa: ARG002
        if channel not in self._by_channel or not 1 <= samples <= MOST_SAMPLES:
            allowed = f"1 to {MOST_SAMPLES} of {', '.join(self.channels)}"
            raise RequestRefused(f"{self.name}: {samples} readings of {channel}: allowed {allowed}; nothing was read")
        wanted = self._by_channel[channel]
        unit = self._unit(wanted)
        started_s = self._clock.monotonic_s()
        values_deg = np.empty(samples)
        for number in range(samples):
            wait(self._dialect.reading_s)
            values_deg[number] = to_deg(self._reading(wanted, unit).values[wanted.value], unit)
        if (after := self._unit(wanted)) != unit:
            raise DeviceFault(
                f"{self.name}: its unit was {unit} before the burst and is {after} behind it; the readings are dropped;"
                " see who else sets it"
            )
        overload = np.abs(values_deg) > (np.inf if wanted.range_deg is None else wanted.range_deg)
        attitude_deg = np.array([wanted.attitude_deg(value) for value in values_deg])
        attitude_deg[overload] = np.nan
        return Burst(channel, attitude_deg, overload, started_s, self._dialect.reading_s, "deg")

    def reading_s(self, nplc: float | None = None) -> float:  # noqa: ARG002
        return self._dialect.reading_s

    def checks(self) -> Mapping[str, float]:
        return {}

    def _unit(self, channel: AngleChannel) -> AngleUnit:
        """Return the unit on the wire, now. Raises: DeviceRefused where it is not the one that the file states."""
        stated = self._settings.values
        reported: AngleUnit | None = self._dialect.unit
        if self._dialect.unit_query is not None:
            question = self._codec.ask(Question("unit", channel.axis))
            reported = self._exchange.ask(
                question, lambda reply: self._codec.parse_unit(reply, channel.axis), idempotent=True
            )
        elif self._dialect.units:
            reported = self._ask_reading(channel).unit
        self._require_stated(reported)
        unit = stated if reported is None else reported
        assert unit is not None  # a file without one was refused
        return unit

    def _reading(self, channel: AngleChannel, unit: AngleUnit) -> Reading:
        reading = self._ask_reading(channel)
        if reading.unit not in (None, unit):
            raise DeviceFault(
                f"{self.name}: a reading is in {reading.unit}, the burst began in {unit}; the readings are dropped; see"
                " who else sets it"
            )
        return reading

    def _ask_reading(self, channel: AngleChannel) -> Reading:
        self._require_quiet()
        return self._exchange.ask(
            self._codec.ask(Question("reading", channel.axis)),
            lambda reply: self._codec.parse_reading(reply, channel.axis),
            idempotent=True,
            lines=self._codec.reply_lines("reading"),
        )

    def _require_quiet(self) -> None:
        """See that what streams from power-on does not, since it was told to be quiet. Raises: DeviceFault.

        The lines of a stream are those of an answer, and what is asked while it streams is not heard.
        """
        if self._dialect.quiet is None or self._exchange.is_in_doubt:
            return
        unasked = self._exchange.take_waiting()
        if len(unasked) >= _STREAMED_BYTES:
            self._exchange.doubt()
            raise DeviceFault(
                f"{self.name}: it streams again, though it was told to be quiet: got {shown(unasked[-_SHOWN_BYTES:])}"
                " unasked; it lost power or was reset, and what was set at it may be lost; the readings are dropped;"
                " look at its supply and its settings"
            )

    def _require_stated(self, found: AngleUnit | None) -> None:
        stated = self._settings.values
        if found is not None and stated not in (None, found):
            raise FileContradicted(
                f"{self.name}: its unit is {found}, need {stated} (readouts.{self.name}: values); nothing is measured;"
                " set it at the device, or correct the file"
            )

    def _fall_quiet(self) -> None:
        """End the stream that it begins by itself, and let the line fall silent. Raises: DeviceNonsense."""
        self._exchange.stream.write(self._codec.ask(Question("quiet")))
        self._exchange.wait_for_quiet()
