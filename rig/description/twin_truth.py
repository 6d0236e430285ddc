"""``[twin]``: what the twins' devices, sensors and surroundings really are."""

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from rig.description.device_settings import NotNegative, Positive
from rig.toml_file import StrictTable, as_tuple


class ReadingTruth(StrictTable):
    """``reading = { … }`` of a channel that a stream sends: everything in the unit of the channel."""

    at_zero: float = 0.0
    """Where nothing is sensed."""
    per_unit: float
    """For one g, one °/s or one µT, whichever the sensor measures."""
    noise: NotNegative = 0.0


class AxisTruth(StrictTable):
    """``[twin.truth.SENSOR.AXIS]``: what the twin's sensor really is."""

    offset_v: float = 0.0
    sensitivity_v_per_g: float = 0.0
    sensitivity_v_per_dps: float = 0.0
    sensitivity_v_per_ut: float = 0.0
    """One of the three, as the sensor measures; none of them beside ``reading``."""
    reading: ReadingTruth | None = None
    coning_deg: Annotated[float, Field(ge=0.0, le=90.0)] = 0.0
    azimuth_deg: Annotated[float, Field(ge=-180.0, le=180.0)] = 0.0
    noise_v: NotNegative = 0.0
    offset_tc_v_per_degc: float = 0.0
    sensitivity_tc_per_degc: float = 0.0
    offset_tc2_v_per_degc2: float = 0.0
    sensitivity_tc2_per_degc2: float = 0.0
    reference_temperature_degc: float = 20.0
    offset_drift_v_per_replication: float = 0.0
    sensitivity_drift_per_replication: float = 0.0
    q_v_per_g2: tuple[float, float, float, float, float] | None = None
    """[xx, xy, xz, yy, yz] of the traceless Q of a soft mount; zz = −xx − yy."""

    @field_validator("q_v_per_g2", mode="before")
    @classmethod
    def _five(cls, value: object) -> object:
        return as_tuple(value)

    @model_validator(mode="after")
    def _sensitivity_given_once(self) -> "AxisTruth":
        names = ("sensitivity_v_per_g", "sensitivity_v_per_dps", "sensitivity_v_per_ut")
        given = {name for name in names if getattr(self, name)}
        sources = [*sorted(given), *(["reading"] if self.reading is not None else [])]
        if len(sources) != 1:
            raise ValueError(f"give one sensitivity other than 0, or reading; got {', '.join(sources) or 'neither'}")
        if self.reading is None and "offset_v" not in self.model_fields_set:
            raise ValueError("offset_v is missing")
        return self

    @property
    def at_zero(self) -> float:
        """What the channel carries where nothing is sensed, in its unit."""
        return self.offset_v if self.reading is None else self.reading.at_zero

    @property
    def per_unit(self) -> float:
        """For one g, °/s or µT, in the channel's unit."""
        if self.reading is not None:
            return self.reading.per_unit
        return self.sensitivity_v_per_g or self.sensitivity_v_per_dps or self.sensitivity_v_per_ut

    @property
    def noise(self) -> float:
        """Standard deviation of one reading, in the channel's unit."""
        return self.noise_v if self.reading is None else self.reading.noise


class AxisTwin(StrictTable):
    """``[twin.axes.NAME]``: what the twin's axis really is."""

    index_error_arcsec: NotNegative | None = None
    """Each tooth is off by a fixed amount drawn within ± this; default: the axis' uncertainty_arcsec, or 0 where
    ``index_harmonics`` or ``index_list`` say what the errors are."""
    index_harmonics: tuple[tuple[float, float, float], ...] = ()
    """``[times a turn, amplitude in arcsec, phase in degrees]`` each, adding amplitude × sin(times × angle + phase)."""
    index_list: tuple[tuple[float, float], ...] = ()
    """``[angle_deg, error_arcsec]`` each, rising within a turn; between them the straight line, round the turn."""
    zero_error_arcsec: float = 0.0
    """How far the axis stands beyond where it was set to zero."""
    creep_arcsec: float = 0.0
    """How far the package still is from its rest when the axis has just arrived."""
    creep_s: Positive = 1.0
    rate_error: float = 0.0
    """How much too fast it turns, as part of the rate asked for."""
    runaway_after_s: Positive | None = None
    """So long after it began to turn it goes faster and faster."""

    @field_validator("index_harmonics", "index_list", mode="before")
    @classmethod
    def _rows(cls, value: object) -> object:
        return tuple(as_tuple(row) for row in value) if isinstance(value, list) else value

    @field_validator("index_harmonics")
    @classmethod
    def _whole_turns(cls, rows: tuple[tuple[float, float, float], ...]) -> tuple[tuple[float, float, float], ...]:
        if any(times < 1.0 or times != round(times) for times, _, _ in rows):
            raise ValueError("the times a turn must be 1, 2, 3 …: an index error is the same after a whole turn")
        return rows

    @field_validator("index_list")
    @classmethod
    def _rising(cls, rows: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
        angles = [angle for angle, _ in rows]
        if any(b <= a for a, b in pairwise(angles)) or (angles and angles[-1] - angles[0] >= 360.0):
            raise ValueError("the angles must rise and stay within one turn")
        return rows


class TwinBase(StrictTable):
    """``[twin.base]``: the granite under the twin's table."""

    tilt_about_pitch_arcsec: float = 0.0
    tilt_about_roll_arcsec: float = 0.0
    orthogonality_arcsec: float = 0.0
    droop_arcsec: float = 0.0
    """Sag of the pitch reading at level, as cos α."""
    remount_arcsec: NotNegative = 0.0
    """Standard deviation of the small rotation that each new mounting adds, about each axis."""
    earth: tuple[float, float] | None = None
    """Latitude, and heading of x at zero angles, degrees: where the Earth turns under the table; None: it stands."""

    @field_validator("earth", mode="before")
    @classmethod
    def _position_as_tuple(cls, value: object) -> object:
        return as_tuple(value)


class TwinEnvironment(StrictTable):
    """``[twin.environment.NAME]``: the twin's air."""

    temperature_degc: float = 20.0
    noise_degc: NotNegative = 0.02
    drift_degc_per_replication: float = 0.0


class TwinReadout(StrictTable):
    """``[twin.readouts.NAME]``: what the twin's meter really is, and what stands at the channels of its ``checks``."""

    short_v: float = 0.0
    reference_error_v: float = 0.0
    """What the reference reads beyond ``reference_v``."""
    reference_drift_v_per_h: float = 0.0
    own_temperature_degc: float = 36.4
    own_temperature_drift_degc_per_h: float = 0.0
    error_deg: float = 0.0
    """How far a meter of angles reads beyond the attitude."""
    noise_deg: NotNegative = 0.0
    """Of one reading of a meter of angles."""


class TwinSupply(StrictTable):
    """``[twin.supplies."readout.channel"]``: what a supply that a chain names really gives."""

    error_v: float = 0.0
    drift_v_per_replication: float = 0.0


class TwinStream(StrictTable):
    """``[twin.streams.NAME]``: what a streaming package really feels and adds."""

    field_ut: tuple[float, float, float] = (20.0, 0.0, 40.0)
    """The magnetic field in level axes: north, east, down."""
    rate_bias_dps: tuple[float, float, float] = (0.0, 0.0, 0.0)
    noise_g: NotNegative = 0.0005
    noise_dps: NotNegative = 0.02
    noise_ut: NotNegative = 0.1

    @field_validator("field_ut", "rate_bias_dps", mode="before")
    @classmethod
    def _three(cls, value: object) -> object:
        return as_tuple(value)


class TwinSection(StrictTable):
    """``[twin]``: only where a port says ``twin``, or for the control address that ``simulate`` publishes."""

    seed: Annotated[int, Field(ge=0, le=2**63 - 1)] = 0
    time: Literal["virtual", "real"] | Positive = "virtual"
    control: str | None = None
    """``socket://host:port`` of twins that run in another process."""
    mounting: int = 0
    """Which mounting of the package this is: a new number draws a new remount."""
    truth: dict[str, dict[Literal["x", "y", "z"], AxisTruth]] = {}
    axes: dict[str, AxisTwin] = {}
    base: TwinBase = TwinBase()
    environment: dict[str, TwinEnvironment] = {}
    readouts: dict[str, TwinReadout] = {}
    supplies: dict[str, TwinSupply] = {}
    streams: dict[str, TwinStream] = {}
