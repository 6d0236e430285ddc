"""``[sensors.SERIAL]``: a package under calibration, and what its data sheet says of its use."""

from typing import Literal

from pydantic import Field, field_validator, model_validator

from rig.description.device_settings import NotNegative
from rig.description.mount import Mount
from rig.toml_file import StrictTable, as_in_file, as_tuple

PACKAGES = {"single-axis package": 1, "two-axis package": 2, "three-axis package": 3}
NominalVolts = float | dict[Literal["x", "y", "z"], float]
_SENSED_UNITS = {"acceleration": "g", "rate": "dps", "field": "ut"}
_NOMINAL_KEYS = {measured: f"nominal_sensitivity_v_per_{unit}" for measured, unit in _SENSED_UNITS.items()}
STAGES = (("pitch", "yaw"), ("pitch", "yaw", "roll"))
"""Of a gimbal: what its sting carries, and its model."""


class SensorTemperature(StrictTable):
    """The sensor's own temperature channel and its conversion: T = offset + slope × volts."""

    channel: str
    offset_degc: float
    slope_degc_per_v: float


class Sensor(StrictTable):
    """``[sensors.SERIAL]``: one package under calibration."""

    model: Literal["single-axis package", "two-axis package", "three-axis package"]
    measures: Literal["acceleration", "rate", "field"] = "acceleration"
    channels: dict[Literal["x", "y", "z"], str] = Field(min_length=1)
    """Axis to ``readout.channel`` or ``stream.channel``."""
    nominal_sensitivity_v_per_g: NominalVolts = 0.0
    """Of accelerometers read in volts, one for all axes or one for each; its sign declares the polarity."""
    nominal_sensitivity_v_per_dps: NominalVolts = 0.0
    """Of gyros, the same."""
    nominal_sensitivity_v_per_ut: NominalVolts = 0.0
    """Of magnetometers, the same."""
    mount: Mount = Mount()
    stage: tuple[Literal["pitch", "yaw", "roll"], ...] | None = None
    """The axes of a gimbal that carry it, from outside in; None: all. Pitch and yaw carry CR's sting package."""
    temperature: SensorTemperature | None = None
    use_temperature_degc: tuple[float, float] | None = None
    """Where the sensor will be used; None: where it was calibrated."""
    largest_offset_tc_v_per_degc: NotNegative = 0.0
    """Limit of its data sheet on what a degree does to the offset where no temperature is modelled."""
    largest_sensitivity_tc_per_degc: NotNegative = 0.0
    largest_offset_shift_v: NotNegative = 0.0
    """Limit on what an axis' offset shifts by, of its data sheet or of its own history: while it is calibrated, as far
    as the readings leave that open, and until the next time."""
    largest_sensitivity_shift: NotNegative = 0.0
    """The same of the sensitivity, as a part of it."""
    largest_nonlinearity_v: NotNegative = 0.0
    """Limit of its data sheet on how far an output is from its equation at any attitude: linearity beyond the terms of
    a set, threshold, dead band, hysteresis."""
    largest_g_sensitivity_dps_per_g: NotNegative = 0.0
    """Limit of its data sheet on what one g along any direction does to the zero of a gyro."""
    check_sensor: bool = False
    """A permanent check sensor: calibrated with every run, never released."""

    @field_validator("use_temperature_degc", "stage", mode="before")
    @classmethod
    def _range_as_tuple(cls, value: object) -> object:
        return as_tuple(value)

    @model_validator(mode="after")
    def _as_many_channels_as_the_model_has(self) -> "Sensor":
        if len(self.channels) != PACKAGES[self.model]:
            raise ValueError(
                f"a {self.model} has {PACKAGES[self.model]} channels, got {', '.join(self.channels)}; correct channels "
                "or model"
            )
        declared: NominalVolts = getattr(self, self.nominal_key)
        if isinstance(declared, dict) and set(declared) != set(self.channels):
            raise ValueError(
                f"{self.nominal_key} names {', '.join(declared) or 'no axis'}; needed is one number for all axes, or "
                f"one for each of {', '.join(self.channels)}"
            )
        for key in _NOMINAL_KEYS.values():
            if key != self.nominal_key and getattr(self, key) != 0.0:
                raise ValueError(
                    f"{key} has no meaning for a sensor that measures {self.measures}; remove it, or declare "
                    f"{self.nominal_key}"
                )
        if self.measures != "rate" and self.largest_g_sensitivity_dps_per_g > 0.0:
            raise ValueError(
                "largest_g_sensitivity_dps_per_g is what gravity does to a gyro: it has no meaning for a sensor that "
                f"measures {self.measures}; remove it"
            )
        return self

    @model_validator(mode="after")
    def _stage_is_a_rotation(self) -> "Sensor":
        if self.stage is not None and self.stage not in STAGES:
            raise ValueError(
                f"stage names the axes that carry the sensor, from outside in: got {as_in_file(self.stage)}, allowed "
                'are ["pitch", "yaw"] (the sting) and ["pitch", "yaw", "roll"] (the model)'
            )
        return self

    @property
    def rolls(self) -> bool:
        """Whether roll carries it."""
        return self.stage is None or "roll" in self.stage

    @model_validator(mode="after")
    def _use_has_a_range(self) -> "Sensor":
        used = self.use_temperature_degc
        if used is not None and not used[0] < used[1]:
            raise ValueError(
                f"use_temperature_degc needs a lower and a higher temperature, got {used[0]:g} and {used[1]:g}"
            )
        if used is None and (self.largest_offset_tc_v_per_degc or self.largest_sensitivity_tc_per_degc):
            raise ValueError(
                "largest_offset_tc_v_per_degc and largest_sensitivity_tc_per_degc belong to use_temperature_degc = "
                "[low, high], which is missing"
            )
        return self

    @property
    def nominal_key(self) -> str:
        """The key that declares its sensitivity in volts."""
        return _NOMINAL_KEYS[self.measures]

    def nominal_v(self, axis: str) -> float:
        """Return what is declared for an axis of the package, in volts per unit of what it senses; 0: nothing is."""
        declared: NominalVolts = getattr(self, self.nominal_key)
        if not isinstance(declared, dict):
            return declared
        return next((value for name, value in declared.items() if name == axis), 0.0)

    def nominal_v_per_g(self, axis: str) -> float:
        """Return the same of an accelerometer; 0 of any other sensor."""
        return self.nominal_v(axis) if self.measures == "acceleration" else 0.0

    @property
    def sensed_unit(self) -> str:
        """Unit of what it senses, as it is written in a key."""
        return _SENSED_UNITS[self.measures]

    @property
    def is_sensitivity_declared(self) -> bool:
        """Whether any axis of an accelerometer has a nominal sensitivity."""
        return any(self.nominal_v_per_g(axis) != 0.0 for axis in self.channels)
