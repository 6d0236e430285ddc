"""``[chain."readout.channel"]``: what stands between a sensor and its meter, and what it does to the reading.

A ratiometric sensor makes so many volts for each volt of its supply; a sensor that makes a current makes volts of it in
a load resistor. Both corrections bring a reading to what it would be at the declared supply and the resistor's declared
temperature, so that coefficients of different nights mean the same.
"""

from typing import Annotated

from pydantic import Field, field_validator, model_validator

from rig.description.device_settings import NotNegative, Positive
from rig.toml_file import StrictTable, as_tuple


class Chain(StrictTable):
    """One table."""

    serial: str = ""
    """What a coefficient set is tied to: used with another chain, it is refused."""
    load_resistor_ohm: Positive | None = None
    load_resistor_tc_per_degc: Annotated[float, Field(ge=-0.01, le=0.01)] = 0.0
    load_resistor_degc: float = 23.0
    """Where it has its value, and where the coefficients hold."""
    load_resistor_at: str | None = None
    """The ``[environment]`` that it stands in; without one it is taken to stay at ``load_resistor_degc``."""
    supply_channel: str | None = None
    supply_band_v: tuple[float, float] | None = None
    supply_nominal_v: float | None = None
    """What readings of a ratiometric sensor are brought to; by default the middle of the band."""
    ratiometric: bool = False
    warm_up_s: NotNegative = 0.0
    warm_up_slope_v_per_h: Positive | None = None
    standard: str | None = None

    @field_validator("supply_band_v", mode="before")
    @classmethod
    def _pair(cls, value: object) -> object:
        return as_tuple(value)

    @model_validator(mode="after")
    def _whole(self) -> "Chain":
        if self.ratiometric and (self.supply_channel is None or not self.reference_supply_v):
            raise ValueError("ratiometric needs supply_channel and supply_nominal_v or supply_band_v, other than 0 V")
        if self.load_resistor_ohm is None and (self.load_resistor_tc_per_degc or self.load_resistor_at):
            raise ValueError("load_resistor_ohm is missing, but its temperature coefficient or its place is given")
        return self

    @property
    def reference_supply_v(self) -> float | None:
        """What readings of a ratiometric sensor are brought to."""
        if self.supply_nominal_v is not None or self.supply_band_v is None:
            return self.supply_nominal_v
        return sum(self.supply_band_v) / 2.0

    @property
    def corrects(self) -> bool:
        """Whether readings are not as they would be by declaration."""
        return self.ratiometric or (self.load_resistor_at is not None and self.load_resistor_tc_per_degc != 0.0)

    def factor(self, supply_v: float | None, resistor_degc: float | None) -> float:
        """Return what a reading has more than it would have by declaration: divide it by this."""
        nominal_v = self.reference_supply_v
        by_supply = supply_v / nominal_v if self.ratiometric and supply_v is not None and nominal_v else 1.0
        warmer_degc = 0.0 if resistor_degc is None else resistor_degc - self.load_resistor_degc
        return by_supply * (1.0 + self.load_resistor_tc_per_degc * warmer_degc)
