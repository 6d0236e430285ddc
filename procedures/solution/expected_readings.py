"""What ``[dwell.adaptive]`` is expected to choose, from the noise that is believed beforehand."""

from collections.abc import Mapping
from dataclasses import replace
from math import sqrt

from procedures.description.dwell_settings import DwellSettings
from procedures.description.procedure_file import Solve
from procedures.plan.adaptive import Reading, best_reading, noise_wanted_v, samples_enough
from procedures.solution.beliefs import AxisBelief, beliefs_of
from rig.description.device_settings import ReadoutSettings
from rig.description.rig_file import RigDescription, Sensor

Beliefs = Mapping[tuple[str, str], AxisBelief]
"""Sensor and axis to what is believed of it."""


def expected_readings(
    rig: RigDescription, dwell: DwellSettings, sensors: Mapping[str, Sensor], beliefs: Beliefs
) -> dict[str, Reading]:
    """Return, by channel, what a dwell is expected to read; none without ``[dwell.adaptive]``."""
    if dwell.adaptive is None:
        return {}
    limits, wanted_v = dwell.adaptive, noise_wanted_v(dwell.adaptive, sensors)
    found = {}
    for serial, axis, channel in _axes(sensors):
        settings, belief = _readout(rig, channel), beliefs[serial, axis]
        if limits.nplc is None:
            found[channel] = Reading(samples_enough(belief.reading_v, wanted_v[channel], limits), dwell.nplc)
        else:
            noise_v = {nplc: belief.integrated(_longer(settings, nplc)).reading_v for nplc in limits.nplc}
            found[channel] = best_reading(noise_v, settings.reading_s, wanted_v[channel], limits)
    return found


def planned_readings(
    rig: RigDescription, dwell: DwellSettings, solve: Solve, sensors: Mapping[str, Sensor]
) -> dict[str, Reading]:
    """Return the same as the files alone have it, without what a pilot run showed."""
    if dwell.adaptive is None:
        return {}
    return expected_readings(rig, dwell, sensors, beliefs_of(rig, solve, dwell.samples, 1, sensors))


def read_adaptively(
    rig: RigDescription, dwell: DwellSettings, sensors: Mapping[str, Sensor], beliefs: Beliefs
) -> Beliefs:
    """Return the beliefs with the noise of dwells as they are expected to read, as if it were that of ``samples``."""
    readings = expected_readings(rig, dwell, sensors, beliefs)
    found = dict(beliefs)
    for serial, axis, channel in _axes(sensors) if readings else ():
        reading, belief = readings[channel], beliefs[serial, axis]
        if dwell.nplc is None and reading.nplc is not None:
            belief = belief.integrated(_longer(_readout(rig, channel), reading.nplc))
        found[serial, axis] = replace(belief, reading_v=belief.reading_v * sqrt(dwell.samples / reading.samples))
    return found


def _axes(sensors: Mapping[str, Sensor]) -> list[tuple[str, str, str]]:
    return [
        (serial, str(axis), channel) for serial, sensor in sensors.items() for axis, channel in sensor.channels.items()
    ]


def _readout(rig: RigDescription, channel: str) -> ReadoutSettings:
    return rig.readouts[channel.partition(".")[0]]


def _longer(settings: ReadoutSettings, nplc: float) -> float:
    """Return how many times as long a reading integrates as by the rig file."""
    return 1.0 if settings.integrates_nplc is None else nplc / settings.integrates_nplc
