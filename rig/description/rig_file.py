"""``rig.toml`` as one frozen value: what is connected, where, with which limits and standards.

Everything is checked here before any port is opened; nothing here opens one.
"""

from collections.abc import Iterable, Mapping
from datetime import date, datetime
from math import sqrt
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, Field, ValidationInfo, field_validator, model_validator

from rig.description.device_settings import (
    TWIN_PORT,
    AxisSettings,
    EnvironmentSettings,
    FieldSettings,
    NotNegative,
    Positive,
    ReadoutSettings,
    ScannedReadoutSettings,
    StreamSettings,
)
from rig.description.interlocks import Interlocks
from rig.description.mount import SENSOR_AXES as SENSOR_AXES
from rig.description.mount import Mount as Mount
from rig.description.sensor import Sensor as Sensor
from rig.description.signal_chain import Chain
from rig.description.twin_truth import AxisTruth as AxisTruth
from rig.description.twin_truth import AxisTwin as AxisTwin
from rig.description.twin_truth import ReadingTruth
from rig.description.twin_truth import TwinBase as TwinBase
from rig.description.twin_truth import TwinEnvironment as TwinEnvironment
from rig.description.twin_truth import TwinSection as TwinSection
from rig.description.twin_truth import TwinStream as TwinStream
from rig.local_time import local_day
from rig.toml_file import StrictTable, as_tuple

Percent = Annotated[float, Field(ge=0.0, le=100.0)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9 _.+-]{0,63}$")]


class RigSection(StrictTable):
    """``[rig]``: the place."""

    instead: ClassVar[Mapping[str, str]] = {
        "approved_by": "unknown key: approved_by stands at the head of the file, above its first table; move it there"
    }
    name: Annotated[str, Field(min_length=1, max_length=200)]
    gravity_mps2: Annotated[float | None, Field(ge=9.7, le=9.9)] = None
    """None: that of latitude and height, by the formula of WGS 84."""
    gravity_source: str = ""
    gravity_uncertainty_mps2: NotNegative = 0.0
    """Standard; 0 where nobody declares it."""
    latitude_deg: Annotated[float, Field(ge=-90.0, le=90.0)] | None = None
    """Geodetic, north positive: gravity is held against it, and it tells what of the Earth's rotation gyros sense."""
    height_m: Annotated[float, Field(ge=-500.0, le=9000.0)] | None = None
    """Above sea level."""
    heading_deg: Annotated[float, Field(ge=-360.0, le=360.0)] | None = None
    """Where x points when all axes stand at zero, from north through east."""
    resume_after_power_cut: bool = False
    """Whether the queue may resume a run once after a cold start, where something stops every axis."""

    @model_validator(mode="after")
    def _gravity_is_known(self) -> "RigSection":
        if self.gravity_mps2 is not None:
            return self
        if self.latitude_deg is None or self.height_m is None:
            raise ValueError(
                "gravity_mps2 is missing: state it with gravity_uncertainty_mps2 (9.7 to 9.9 m/s²), or state "
                "latitude_deg and height_m, which give it by the formula of WGS 84"
            )
        if self.gravity_source:
            raise ValueError(
                "gravity_source says where gravity_mps2 comes from, which is missing: state gravity_mps2, or remove "
                "gravity_source and let latitude_deg and height_m give it"
            )
        return self


class ConsoleSection(StrictTable):
    """``[console]``: what a browser may do."""

    motion_from_elsewhere: bool = False
    """Whether a browser of another machine may begin motion: continue, resume, arm the queue."""


class Standard(StrictTable):
    """``[standards.NAME]``: a certificate that uncertainty is taken from."""

    instead: ClassVar[Mapping[str, str]] = {
        "correction_file": "a standard states an uncertainty, and corrections stand where they are used; remove it. "
        'Errors that a table\'s certificate lists at angles are corrected by axes.NAME.index_table = "errors.csv"; a '
        "resistor's value is load_resistor_ohm of its [chain], a sensor's own temperature is sensors.NAME.temperature "
        "(offset_degc, slope_degc_per_v); readings of other instruments must come corrected"
    }
    serial: str
    certificate: str
    due: date
    kind: Literal["limit", "standard", "expanded"] = "limit"
    k: Positive = 2.0
    """Coverage factor, used where ``kind = "expanded"``."""
    uncertainty_arcsec: NotNegative | None = None
    uncertainty_v: NotNegative | None = None
    uncertainty_degc: NotNegative | None = None
    uncertainty_ohm: NotNegative | None = None

    @field_validator("k")
    @classmethod
    def _covers_a_standard_uncertainty(cls, value: float, info: ValidationInfo) -> float:
        """Refuse a factor that makes u larger than U; a run that was stored with one stays one."""
        if info.mode != "json" and info.data.get("kind") == "expanded" and value < 1.0:
            raise ValueError(
                "allowed is 1 or more: an expanded uncertainty is k times the standard one, which would be larger "
                "than what the certificate states; give the certificate's k (2 for about 95 %)"
            )
        return value

    @property
    def divisor(self) -> float:
        """Return what its uncertainties are divided by to be standard uncertainties; of a limit √3 (rectangular)."""
        return {"limit": sqrt(3.0), "standard": 1.0, "expanded": self.k}[self.kind]


class AttitudeReference(StrictTable):
    """``[attitude_reference]``: a sensor of known uncertainty that tells the attitude better than the axes do."""

    channels: dict[Literal["pitch", "yaw", "roll"], str] = Field(min_length=1)
    """Axis to a channel of a stream or of a readout, in degrees."""
    uncertainty_deg: Positive
    """Standard uncertainty of an attitude that it tells."""
    samples: Annotated[int, Field(ge=2, le=100_000)] = 10
    closes_loop: bool = False
    """Correct the axes until the reference says that the attitude is reached."""
    tolerance_deg: Positive = 0.1
    corrections: Annotated[int, Field(ge=1, le=20)] = 5
    """At most so many a dwell."""
    standard: str | None = None


class LevelReading(StrictTable):
    """A reading of the base's level."""

    about_pitch_arcsec: float
    about_roll_arcsec: float
    taken: str = ""
    """A day, or a day and a time, as ISO 8601 writes them."""

    @property
    def day(self) -> date | None:
        """The day on the calendar at the wall; None where none is given, or where a stored run has other words."""
        try:
            taken = datetime.fromisoformat(self.taken)
        except ValueError:
            return None
        return taken.date() if taken.tzinfo is None else local_day(taken)

    @field_validator("taken", mode="before")
    @classmethod
    def _is_a_day(cls, value: object, info: ValidationInfo) -> object:
        """Take TOML's own days and times as well, as ``due`` of a standard does."""
        if isinstance(value, date):  # a datetime is one
            return value.isoformat()
        if value == "" or info.mode == "json":  # a run that was stored with any words stays one
            return value
        try:
            if isinstance(value, str) and datetime.fromisoformat(value):
                return value
        except ValueError:
            pass
        raise ValueError("allowed is a day, with or without a time: 2026-03-01 or 2026-03-01T08:30:00Z")


class Level(StrictTable):
    """``[level]``: the base before and after."""

    instrument: str = ""
    standard: str | None = None
    uncertainty_arcsec: NotNegative = 0.0
    """Of the instrument: a limit, unless its standard says otherwise."""
    before: LevelReading | None = None
    after: LevelReading | None = None

    @model_validator(mode="after")
    def _before_is_earlier(self, info: ValidationInfo) -> "Level":
        """Refuse the two readings interchanged; a run that was stored with such days stays one."""
        if info.mode == "json" or self.before is None or self.after is None:
            return self
        before, after = self.before.day, self.after.day
        if before is not None and after is not None and after < before:
            raise ValueError(
                f"after was taken on {after}, earlier than before ({before}); correct a day, or exchange the readings"
            )
        return self


class Motion(StrictTable):
    """``[motion]``: how the axes may move."""

    together: bool = False
    """All at the same time: whatever way each takes, they and what they carry cannot meet anything."""


class Reading(StrictTable):
    """``[reading]``: how the readouts may read."""

    together: bool = False
    """All at the same time: none disturbs what another one reads."""


class Job(StrictTable):
    """``[job]``: what the certificate asks for."""

    number: str = ""
    customer: str = ""
    customer_contact: Annotated[str, Field(min_length=1)] | None = None
    """Address, e-mail or telephone."""
    item: str = ""
    location: Annotated[str, Field(min_length=1)] | None = None
    """Where the work was done, if not at the laboratory's address."""
    received: date | None = None
    remarks: str = ""
    relative_humidity_percent: tuple[Percent, Percent] | None = None
    """Lowest and highest while the item was calibrated, as the laboratory read it."""
    fields: dict[Name, Annotated[str, Field(min_length=1)]] = {}
    """What else the laboratory's work order says, under names of its own."""

    @field_validator("relative_humidity_percent", mode="before")
    @classmethod
    def _humidity_as_tuple(cls, value: object) -> object:
        return as_tuple(value)

    @field_validator("relative_humidity_percent")
    @classmethod
    def _lowest_first(cls, value: tuple[float, float] | None) -> tuple[float, float] | None:
        if value is not None and value[1] < value[0]:
            raise ValueError(f"needs the lowest and then the highest, got {value[0]:g} and {value[1]:g}; exchange them")
        return value


class Laboratory(StrictTable):
    """``[laboratory]``: who calibrates."""

    name: str
    address: str = ""
    country_code: Annotated[str, Field(pattern=r"^[A-Z]{2}$")] | None = None
    """ISO 3166-1, asked for by the Digital Calibration Certificate."""
    accreditation: str = ""
    capability_deg: Positive | None = None
    """The smallest expanded uncertainty the laboratory may state: 95 %, k = 2."""


class Acceptance(StrictTable):
    """``[acceptance]``: what the sensor must meet."""

    pitch_limit_deg: Positive | None = None
    roll_limit_deg: Positive | None = None
    decision_rule: Literal["simple", "guard-band"] = "guard-band"


class RigDescription(StrictTable):
    """The whole file. Built by :func:`read_rig`, which knows the installed drivers."""

    rig: RigSection
    axes: dict[Name, AxisSettings] = Field(min_length=1)
    readouts: dict[Name, ReadoutSettings] = {}
    environment: dict[Name, EnvironmentSettings] = {}
    streams: dict[Name, StreamSettings] = {}
    field: dict[Name, FieldSettings] = {}
    attitude_reference: AttitudeReference | None = None
    sensors: dict[Name, Sensor] = Field(min_length=1)
    standards: dict[Name, Standard] = {}
    level: Level = Level()
    chain: dict[str, Chain] = {}
    job: Job = Job()
    laboratory: Laboratory | None = None
    acceptance: Acceptance = Acceptance()
    console: ConsoleSection = ConsoleSection()
    interlocks: Interlocks = Interlocks()
    motion: Motion = Motion()
    reading: Reading = Reading()
    approved_by: str | None = None
    twin: TwinSection | None = None

    @model_validator(mode="after")
    def _a_stage_needs_a_gimbal(self) -> "RigDescription":
        missing = [name for name in ("pitch", "yaw", "roll") if name not in self.axes]
        for name, sensor in self.sensors.items():
            if sensor.stage is not None and missing:
                raise ValueError(
                    f"sensors.{name}.stage: needs a gimbal with the axes pitch, yaw and roll; the rig has no "
                    f"{' and no '.join(missing)}; remove stage, or add the axis"
                )
        return self

    @property
    def uses_twins(self) -> bool:
        """True where at least one device is a twin in this process."""
        return any(_is_twin(device) for device in self._devices())

    @property
    def is_simulated(self) -> bool:
        """True where what is measured is a twin, in this process or behind ports."""
        return self.uses_twins or (self.twin is not None and self.twin.control is not None)

    def moving_together(self) -> tuple[str, ...]:
        """Return the axes that may be on their way at the same time; none where it is not declared."""
        able = tuple(name for name, axis in self.axes.items() if axis.moves_beside_others)
        return able if self.motion.together else ()

    def reading_together(self) -> tuple[str, ...]:
        """Return the readouts that may read at the same time; none where it is not declared."""
        able = tuple(name for name, readout in self.readouts.items() if readout.reads_beside_others)
        return able if self.reading.together else ()

    def scanners_behind(self, sensor: Sensor) -> dict[str, ScannedReadoutSettings]:
        """Return the readouts that read outputs of a sensor through a scanner beside other channels, by name."""
        names = dict.fromkeys(channel.partition(".")[0] for channel in sensor.channels.values())
        scanned = {name: self.readouts[name] for name in names if name in self.readouts}
        return {
            name: readout
            for name, readout in scanned.items()
            if isinstance(readout, ScannedReadoutSettings) and len(readout.channel_names()) > 1
        }

    def channel_units(self) -> dict[str, str]:
        """Return the unit of every channel of readouts and streams, by full name."""
        return {
            f"{name}.{channel}": unit
            for name, device in (self.readouts | self.streams).items()
            for channel, unit in device.channel_units().items()
        }

    def channel_counts(self) -> dict[str, float]:
        """Return what one count is declared to be of every channel of a stream that sends counts, by full name."""
        return {
            f"{name}.{channel}": count
            for name, stream in self.streams.items()
            for channel, count in stream.channel_counts().items()
        }

    def all_on_twins(self) -> "RigDescription":
        """Return the same rig with every device replaced by its twin, in virtual time: what ``--rehearse`` runs on."""
        twin = (self.twin or TwinSection()).model_copy(update={"time": "virtual", "control": None})
        return self.model_copy(
            update={
                "axes": {name: _on_twin(axis) for name, axis in self.axes.items()},
                "readouts": {name: _on_twin(readout) for name, readout in self.readouts.items()},
                "environment": {name: _on_twin(chamber) for name, chamber in self.environment.items()},
                "streams": {name: _on_twin(stream) for name, stream in self.streams.items()},
                "field": {name: _on_twin(coil) for name, coil in self.field.items()},
                "twin": twin.model_copy(update={"truth": _truth_or_nominal(self.sensors, twin.truth)}),
            }
        )

    def _devices(self) -> Iterable[BaseModel]:
        yield from self.axes.values()
        yield from self.readouts.values()
        yield from self.environment.values()
        yield from self.streams.values()
        yield from self.field.values()


def _is_twin(device: BaseModel) -> bool:
    return TWIN_PORT in (getattr(device, "port", None), getattr(device, "resource", None))


def _on_twin(device: BaseModel) -> BaseModel:
    fields = type(device).model_fields
    addresses = [name for name in ("port", "resource", "scanner_resource") if name in fields]
    return device.model_copy(update=dict.fromkeys(addresses, TWIN_PORT))


def _truth_or_nominal(sensors: dict[str, Sensor], truth: dict[str, dict[Any, AxisTruth]]) -> dict[str, Any]:
    """Return the truth that a rehearsal needs.

    It is the file's, or the nominal sensor with a small misalignment and noise.
    """
    return {
        serial: {axis: truth.get(serial, {}).get(axis) or _nominal(sensor, axis) for axis in sensor.channels}
        for serial, sensor in sensors.items()
    }


def _nominal(sensor: Sensor, axis: str) -> AxisTruth:
    """Return the truth of an axis of a nominal sensor.

    Where nothing is declared, that is one of the channel's units for one of what is measured.
    """
    sensitivity_v_per_g = sensor.nominal_v_per_g(axis)
    if sensitivity_v_per_g == 0.0:
        return AxisTruth(reading=ReadingTruth(per_unit=1.0, noise=0.01), coning_deg=0.3, azimuth_deg=40.0)
    return AxisTruth(
        offset_v=0.002 * abs(sensitivity_v_per_g),
        sensitivity_v_per_g=sensitivity_v_per_g,
        coning_deg=0.3,
        azimuth_deg=40.0,
        noise_v=8e-6 * abs(sensitivity_v_per_g),
    )
