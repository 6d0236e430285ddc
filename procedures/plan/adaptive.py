"""How many readings a dwell takes of a channel, and at which integration, where ``[dwell.adaptive]`` leaves it open.

The readings of a dwell are counted before it is read, from the noise of the dwells before it. Its own readings have no
say in it, so no scatter is kept for being small, and the mean of a dwell is as good as its number of readings tells.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from math import ceil, inf, isfinite, sqrt

from ams.units import RAD_PER_ARCSEC
from procedures.description.dwell_settings import AdaptiveDwell, DwellSettings
from procedures.description.procedure_file import ProcedureDescription
from procedures.errors import PlanError
from rig.description.rig_file import RigDescription, Sensor

Readings = Mapping[str, "Reading"]
"""By channel: how those are read that are not read as ``[dwell]`` says."""
RULE = (
    "how many is counted before each dwell, from the noise of the dwells before it; every dwell counts alike in the "
    "solution, whose intervals are made from the spread between replications"
)
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class Reading:
    """How a dwell reads a channel."""

    samples: int
    nplc: float | None
    """None: the readout's own."""

    def dwell(self, plain: DwellSettings) -> DwellSettings:
        """Return ``[dwell]`` with it."""
        return plain.model_copy(update={"samples": self.samples, "nplc": self.nplc})


def noise_wanted_v(limits: AdaptiveDwell, sensors: Mapping[str, Sensor]) -> dict[str, float]:
    """Return, by channel, the standard deviation of a dwell's mean that is small enough; sensor channels only."""
    return {
        channel: limits.noise_arcsec * RAD_PER_ARCSEC * abs(sensor.nominal_v_per_g(str(axis)))
        for sensor in sensors.values()
        for axis, channel in sensor.channels.items()
    }


def samples_of_next(noise_v: float | None, wanted_v: float, dwell: DwellSettings, limits: AdaptiveDwell) -> int:
    """Return how many readings the next dwell takes; ``noise_v``: the scatter of those before, None: not known yet."""
    return dwell.samples if noise_v is None else samples_enough(noise_v, wanted_v, limits)


def samples_enough(noise_v: float, wanted_v: float, limits: AdaptiveDwell) -> int:
    """Return how many readings of the given scatter have a mean that is known as well as wanted, within the limits."""
    if not isfinite(noise_v):
        return limits.most_samples
    needed = ceil((noise_v / wanted_v) ** 2 * (1.0 - _ROUNDING))
    return min(max(needed, limits.least_samples), limits.most_samples)


def best_reading(
    noise_v: Mapping[float, float], reading_s: Callable[[float], float], wanted_v: float, limits: AdaptiveDwell
) -> Reading:
    """Return the integration, and its readings, that is soonest done; where none is enough, the one of least noise.

    ``noise_v``: integration, power-line cycles, to the scatter that readings show.
    """

    def worth(nplc: float) -> tuple[float, float, float]:
        scatter_v = noise_v[nplc] if isfinite(noise_v[nplc]) else inf
        samples = samples_enough(scatter_v, wanted_v, limits)
        missed = max(scatter_v / sqrt(samples) / wanted_v, 1.0 + _ROUNDING)
        return missed, samples * reading_s(nplc), nplc

    nplc = min(noise_v, key=worth)
    return Reading(samples_enough(noise_v[nplc], wanted_v, limits), nplc)


def longest_readings(rig: RigDescription, dwell: DwellSettings, sensors: Mapping[str, Sensor]) -> dict[str, Reading]:
    """Return, by channel, the readings that take longest within the limits; none where nothing is left open."""
    if dwell.adaptive is None:
        return {}
    most, choices = dwell.adaptive.most_samples, dwell.adaptive.nplc or (dwell.nplc,)
    return {
        channel: Reading(most, max(choices, key=rig.readouts[channel.partition(".")[0]].reading_s))
        for sensor in sensors.values()
        for channel in sensor.channels.values()
    }


def adaptive_refusals(
    rig: RigDescription, procedure: ProcedureDescription, sensors: Mapping[str, Sensor], *, is_at_rest: bool
) -> Iterator[PlanError]:
    """Tell what the choice of readings cannot go with."""
    if procedure.dwell.adaptive is None:
        return
    key = ("dwell", "adaptive")
    if not is_at_rest:
        kind = procedure.procedure.kind
        yield procedure.error(key, f"is for the attitudes of grids and tumbles, not for kind {kind!r}; leave it out")
        return
    for serial, sensor in sensors.items():
        for channel in sensor.channels.values():
            if channel.partition(".")[0] not in rig.readouts:
                yield procedure.error(
                    key,
                    f"{channel} of {serial} is a stream, which is recorded beside the others for as long as they all "
                    "are; leave it out",
                )
