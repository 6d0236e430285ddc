"""Settings that all devices of one ability share; a driver adds its own in its file.

The strict tables here are what ``rig.toml`` is validated against.
"""

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, ClassVar, Literal, Protocol, Self, runtime_checkable

from pydantic import Field, field_validator, model_validator

from rig.description.index_table import IndexTable
from rig.errors import RequestRefused
from rig.toml_file import StrictTable, as_in_file, as_tuple

TWIN_PORT = "twin"
COMMANDED = (
    "where it was sent, not where it stands: a motor that slips or stalls reads back as arrived; have a check sensor,"
    " an angle reference or reference visits that would show it"
)
"""What a person should know of a read-back that nothing measures."""

Positive = Annotated[float, Field(gt=0.0)]
WatchdogSeconds = Annotated[float, Field(ge=2.0, le=600.0)]
"""Shorter ones would end a healthy run whose host is busy for a moment; what a device allows, arming it proves."""
NotNegative = Annotated[float, Field(ge=0.0)]


class AxisSettings(StrictTable):
    """One ``[axes.NAME]`` table."""

    names_files: ClassVar[tuple[str, ...]] = ("index_table",)
    home_key: ClassVar[str] = "zero_deg"
    """Which key says where its home is."""
    driver: str
    port: str
    """``twin``, a device by its stable id, ``socket://host:port`` or ``rfc2217://host:port``."""
    identity: str | None = None
    """A part of what it answers to the question who it is, such as its serial number: another device is refused."""
    limits_deg: tuple[float, float]
    speed_dps: Positive
    increment_deg: NotNegative = 0.0
    """Smallest step; 0 where the axis is continuous."""
    uncertainty_arcsec: NotNegative = 0.0
    """Of its index errors: a limit unless the standard says otherwise."""
    index_errors: Literal["unknown", "independent", "smooth"] = "unknown"
    """What these errors look like from index to index: not known, each tooth its own, or a smooth curve."""
    index_zero_deg: float | None = None
    """The machine's angle at which the axis was set to read true."""
    index_zero_uncertainty_arcsec: NotNegative = 0.0
    """Of setting it there; stated as ``uncertainty_arcsec``."""
    direction_uncertainty_arcsec: NotNegative = 0.0
    """Of the direction that it turns about, to either side: squareness, and the seat on it; as ``uncertainty_arcsec``.
    """
    index_table: str | IndexTable | None = None
    """A file of the certificate's errors at angles, relative to the rig file; its rows once it is read."""
    standard: str | None = None
    sign: Literal[1, -1] = 1
    """Table angle = sign × attitude + zero_deg."""
    zero_deg: float = 0.0
    approach_deg: float = 0.0
    arrival_tolerance_deg: Positive = 0.001
    axis: Annotated[int, Field(ge=1, le=99)] = 1
    """Number of the axis on its controller."""
    wrap_turns: Positive | None = None
    """Of an axis that turns on and on: so many revolutions either way its cables bear. None: no cable winds up."""

    @field_validator("limits_deg", mode="before")
    @classmethod
    def _pair(cls, value: object) -> object:
        return as_tuple(value)

    @property
    def line_address(self) -> tuple[int, ...]:
        """What tells the axes of one port apart: the number on the controller, and what a driver needs besides."""
        return (self.axis,)

    @property
    def turning(self) -> Literal["no", "revolves", "sweeps"]:
        """Whether it can turn at a rate that is asked for: on and on, or between its limits."""
        return "no"

    @property
    def position_wraps(self) -> bool:
        """Whether the position that it tells begins again after a turn."""
        return False

    @property
    def is_set_by_hand(self) -> bool:
        """Whether a person moves it, whom the program asks; nobody remembers its zero from one command to the next."""
        return False

    @property
    def stops_without_computer(self) -> bool:
        """Whether the machine ends a rate by itself when nobody speaks to it any more, as its file asks."""
        return False

    @property
    def moves_beside_others(self) -> bool:
        """Whether it answers, and may move, while another axis of the rig is on its way."""
        return True

    @property
    def speed_range_dps(self) -> tuple[float, float]:
        """Slowest and fastest that its commands can hold."""
        return 0.0, math.inf

    def motion_complaints(self) -> Iterator[tuple[str, str]]:
        """Yield the other keys of motion that its commands cannot hold, each with a sentence."""
        yield from ()

    def remarks(self) -> tuple[str, ...]:
        """Return what a person should know of this machine before a run. Raises: DescriptionError."""
        return ()

    def file_complaints(self, folder: Path) -> Iterator[tuple[tuple[str, ...], str]]:  # noqa: ARG002
        """Yield as of a readout, of files that it names and of what they cannot say."""
        yield from ()

    def with_files(self, folder: Path) -> Self:  # noqa: ARG002
        """Return it as a readout, with what the files say that it names."""
        return self

    def miswritten(self) -> Callable[[float], str]:
        """Return what tells why the machine cannot be told of an attitude; it tells nothing where it can.

        Raises: DescriptionError.
        """
        return lambda _attitude_deg: ""

    def refuse_rate(self, name: str, rate_dps: float) -> None:
        """Refuse what the file can tell of a rate before any port is opened. Raises: RequestRefused."""
        raise RequestRefused(
            f"{name}: turn at {rate_dps:g} °/s: the axis only goes to positions; nothing moved; use an axis that"
            f" turns (axes.{name}: top_rate_dps where the driver has it)"
        )

    @model_validator(mode="after")
    def _low_below_high(self) -> "AxisSettings":
        low, high = self.limits_deg
        if not low < high:
            raise ValueError(f"limits_deg: got [{low}, {high}], allowed is [low, high] with low < high")
        return self

    @model_validator(mode="after")
    def _uncertainty_of_a_zero(self) -> "AxisSettings":
        if self.index_zero_uncertainty_arcsec > 0.0 and self.index_zero_deg is None:
            raise ValueError("index_zero_uncertainty_arcsec needs index_zero_deg: where the axis was set to read true")
        return self

    @property
    def home_attitude_deg(self) -> float:
        """Return where a home search ends: at the machine's own zero."""
        return self.attitude_deg(0.0)

    @property
    def moves_to_home(self) -> bool:
        """Whether homing moves it; else its positions are absolute. Raises: DescriptionError."""
        return True

    def table_deg(self, attitude_deg: float) -> float:
        """Return what the machine is told for an attitude."""
        return self.sign * attitude_deg + self.zero_deg

    def attitude_deg(self, table_deg: float) -> float:
        """Return what the machine's own angle is as an attitude."""
        return self.sign * (table_deg - self.zero_deg)


@runtime_checkable
class PulseDriven(Protocol):
    """Settings of an axis that is sent pulses, such as a servo: which pulse stands for an attitude."""

    @property
    def pulse_limits_us(self) -> tuple[float, float]:
        """Shortest and longest pulse that the machine is sent."""

    def pulse_us(self, attitude_deg: float) -> float:
        """Return the pulse at an attitude, which may lie outside the limits."""

    def pulse_attitude_deg(self, pulse_us: float) -> float:
        """Return the attitude at a pulse."""


class ReadoutSettings(StrictTable):
    """One ``[readouts.NAME]`` table."""

    driver: str
    standard: str | None = None
    identity: str | None = None
    """As of an axis."""

    def channel_names(self) -> tuple[str, ...]:
        """Return the names of the channels this readout offers."""
        raise NotImplementedError

    def reading_s(self, nplc: float | None = None) -> float:
        """Return the expected seconds for one reading; ``nplc`` None: the description's."""
        raise NotImplementedError

    @property
    def reads_beside_others(self) -> bool:
        """Whether a burst only waits through the wait it is given, so that other readouts can read meanwhile."""
        return False

    def most_samples(self) -> int | None:
        """Return how many readings a burst may have; None where the device sets no bound below a procedure's own."""
        return None

    def channel_units(self) -> dict[str, str]:
        """Return the unit of each channel as it is written in a key; volts of a meter that says nothing else."""
        return dict.fromkeys(self.channel_names(), "v")

    def attitude_axes(self) -> dict[str, str]:
        """Return the axis whose attitude a channel tells, by channel; none where they tell something else."""
        return {}

    def file_complaints(self, folder: Path) -> Iterator[tuple[tuple[str, ...], str]]:  # noqa: ARG002
        """Yield key and sentence of what is wrong with files that it names, relative to the rig file's ``folder``."""
        yield from ()

    def with_files(self, folder: Path) -> Self:  # noqa: ARG002
        """Return it with what the files say that it names, in place of their paths: they are read once a run.

        Paths are relative to the rig file's ``folder``. Raises: DescriptionError.
        """
        return self

    def input_ohm(self, channel: str) -> float | None:  # noqa: ARG002 for those that have channels of their own
        """Return what the input of ``channel`` loads its source with; None where that is nothing that counts."""
        return None

    def range_of_channel_v(self, channel: str) -> float | None:  # noqa: ARG002 for those that know theirs
        """Return the range that ``channel`` reads on, volts; None where it is not known, or no volts are read.

        What a certificate states of the meter is over it the uncertainty of the gain. Where it is not known, a result
        says that the gain is in no uncertainty; to be wrong here is to state a wrong one.
        """
        return None

    @property
    def integrates_nplc(self) -> float | None:
        """Return over how many power-line cycles a reading integrates by the file; None where nothing is chosen."""
        return None


class ScannedReadoutSettings(ReadoutSettings):
    """A meter that reads several channels through a scanner."""

    crosstalk_ratio: Annotated[float, Field(gt=0.0, le=0.01)] | None = None
    """The part of the volts of any other channel that a reading may have too much: a limit; None: nobody declares it.
    Of −100 dB it is 1e-5."""

    def range_of_channel_v(self, channel: str) -> float:
        """Return the range as of any readout; a scanner must tell it: so many volts may leak from that channel."""
        raise NotImplementedError


class EnvironmentSettings(StrictTable):
    """One ``[environment.NAME]`` table."""

    driver: str
    port: str
    standard: str | None = None
    identity: str | None = None
    """As of an axis."""
    limits_degc: tuple[float, float] = (-60.0, 150.0)
    """Where a setpoint may be; checked in the plan and in the driver just before it is sent."""

    @field_validator("limits_degc", mode="before")
    @classmethod
    def _degc_pair(cls, value: object) -> object:
        return as_tuple(value)

    def refuse_beyond_limits(self, name: str, setpoint_degc: float) -> None:
        """Refuse a setpoint beyond the limits. Raises: RequestRefused."""
        low, high = self.limits_degc
        if not low <= setpoint_degc <= high:
            raise RequestRefused(
                f"{name}: setpoint {setpoint_degc:g} °C, allowed {low:g} to {high:g} °C"
                f" (environment.{name}: limits_degc); nothing was changed; ask for one inside"
            )


class StreamSettings(StrictTable):
    """One ``[streams.NAME]`` table."""

    driver: str
    port: str
    standard: str | None = None
    identity: str | None = None
    """As of an axis."""

    def channel_names(self) -> tuple[str, ...]:
        """Return the names of the channels this stream offers."""
        raise NotImplementedError

    def channel_units(self) -> dict[str, str]:
        """Return the unit of each channel as it is written in a key, such as ``g`` or ``dps``."""
        raise NotImplementedError

    def channel_counts(self) -> dict[str, float]:
        """Return what one count of a channel is declared to be, in its unit; none of those that send no counts."""
        return {}

    def samples_hz(self) -> float:
        """Return the samples a second."""
        raise NotImplementedError


class FieldSettings(StrictTable):
    """One ``[field.NAME]`` table: a coil or a magnet whose field is known."""

    driver: str
    port: str
    standard: str | None = None
    limits_ut: tuple[float, float]
    """What may be applied along ``direction``."""
    direction: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Of a positive field in level axes: north, east, down; its length does not matter."""
    uncertainty_ut: NotNegative = 0.0
    """Standard uncertainty of a level."""
    direction_uncertainty_deg: Annotated[float, Field(ge=0.0, le=10.0)] = 0.0
    """Standard uncertainty of ``direction``, to either of two sides at right angles."""

    @field_validator("limits_ut", "direction", mode="before")
    @classmethod
    def _lists(cls, value: object) -> object:
        return as_tuple(value)

    @model_validator(mode="after")
    def _sound(self) -> "FieldSettings":
        if not self.limits_ut[0] < self.limits_ut[1]:
            raise ValueError(f"limits_ut must be [low, high] with low < high, got {as_in_file(self.limits_ut)}")
        if not any(self.direction):
            raise ValueError("direction must not be [0, 0, 0]")
        return self
