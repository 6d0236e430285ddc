"""``[dwell]``: how one dwell is taken and judged."""

from typing import Annotated, Self

from pydantic import Field, field_validator, model_validator

from rig.description.device_settings import NotNegative, Positive
from rig.toml_file import StrictTable, as_tuple

Cycles = Annotated[float, Field(gt=0.0, le=1000.0)]
"""Power-line cycles of one reading."""
Samples = Annotated[int, Field(ge=2, le=100_000)]


class Settle(StrictTable):
    """Window statistics on one channel decide when the package is at rest."""

    window_s: Positive = 1.5
    windows: Annotated[int, Field(ge=2, le=20)] = 2
    min_s: NotNegative = 2.0
    max_s: Positive = 60.0

    @model_validator(mode="after")
    def _time_enough(self) -> Self:
        if self.max_s < max(self.min_s, self.window_s * self.windows):
            raise ValueError(
                f"max_s = {self.max_s} is shorter than min_s or than {self.windows} windows of {self.window_s} s; "
                "no dwell could settle in time: raise max_s, or lower what exceeds it"
            )
        return self


class AdaptiveDwell(StrictTable):
    """``[dwell.adaptive]``: readings and integration of each sensor channel by the noise that it shows."""

    noise_arcsec: Positive
    """Standard deviation, of the mean of a dwell, that is small enough: turned to volts by the nominal sensitivity."""
    least_samples: Samples
    most_samples: Samples
    nplc: Annotated[tuple[Cycles, ...], Field(min_length=2, max_length=10)] | None = None
    """Integrations to choose from, once, before the first dwell; by default that of ``[dwell]``."""

    @field_validator("nplc", mode="before")
    @classmethod
    def _lists_are_tuples(cls, value: object) -> object:
        return as_tuple(value)

    @model_validator(mode="after")
    def _bounds_in_order(self) -> Self:
        if self.least_samples > self.most_samples:
            raise ValueError(
                f"least_samples = {self.least_samples} exceeds most_samples = {self.most_samples}; correct one of them"
            )
        if self.nplc is not None and len(set(self.nplc)) < len(self.nplc):
            raise ValueError("nplc names an integration twice; give each once")
        return self


class DwellSettings(StrictTable):
    """``[dwell]``: how one dwell is taken and judged."""

    settle: Settle = Settle()
    settle_nplc: Annotated[float, Field(gt=0.0, le=100.0)] = 1.0
    nplc: Cycles | None = None
    """Integration of the readings that are kept, power-line cycles; by default the readout's own."""
    samples: Samples = 20
    max_noise_factor: Annotated[float, Field(gt=1.0)] = 3.0
    retries: Annotated[int, Field(ge=0, le=20)] = 2
    adaptive: AdaptiveDwell | None = None
    """None: ``samples`` of every channel in every dwell; else ``samples`` until the noise of a channel is known."""

    @model_validator(mode="after")
    def _begins_within_the_limits(self) -> Self:
        limits = self.adaptive
        if limits is None:
            return self
        if not limits.least_samples <= self.samples <= limits.most_samples:
            raise ValueError(
                f"samples = {self.samples}, with which adaptive dwells begin, lies outside least_samples = "
                f"{limits.least_samples} to most_samples = {limits.most_samples}; give samples between them"
            )
        if limits.nplc is not None and self.nplc is not None:
            raise ValueError("nplc stands in [dwell] and in [dwell.adaptive]; give it in one of them")
        return self
