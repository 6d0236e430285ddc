"""Which channels a plan measures, and whose they are."""

from collections.abc import Mapping
from dataclasses import dataclass

from rig.description.rig_file import RigDescription, Sensor


@dataclass(frozen=True)
class TemperatureChannel:
    """A sensor's own temperature: T = offset + slope × volts."""

    channel: str
    offset_degc: float
    slope_degc_per_v: float


def sensors_that_measure(rig: RigDescription, *what: str) -> dict[str, Sensor]:
    """Return the packages, by serial, that a procedure of this kind calibrates."""
    return {name: sensor for name, sensor in rig.sensors.items() if sensor.measures in what}


def channels_of(rig: RigDescription, sensors: Mapping[str, Sensor]) -> tuple[str, ...]:
    """Return the channels to read: outputs, then the sensors' own temperatures, then the supplies; each once."""
    outputs = [channel for sensor in sensors.values() for channel in sensor.channels.values()]
    temperatures = [sensor.temperature.channel for sensor in sensors.values() if sensor.temperature]
    supplies = [chain.supply_channel for chain in rig.chain.values() if chain.supply_channel]
    return tuple(dict.fromkeys([*outputs, *temperatures, *supplies]))


def environment_of(rig: RigDescription, sensor: Sensor) -> str | None:
    """Return the environment whose reading stands for the sensor's temperature; None where it has one of its own."""
    source = temperature_source(rig, sensor)
    return source if isinstance(source, str) else None


def temperature_source(rig: RigDescription, sensor: Sensor) -> TemperatureChannel | str | None:
    """Return the sensor's own channel, else the rig's only environment, else None."""
    if sensor.temperature is not None:
        temperature = sensor.temperature
        return TemperatureChannel(temperature.channel, temperature.offset_degc, temperature.slope_degc_per_v)
    return next(iter(rig.environment)) if len(rig.environment) == 1 else None
