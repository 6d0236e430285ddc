"""What ``[dwell.adaptive]`` asked for and what was read, in the words of a remark."""

from math import sqrt

import numpy as np

from ams.units import RAD_PER_ARCSEC
from procedures.description.dwell_settings import AdaptiveDwell
from procedures.plan.adaptive import RULE
from procedures.records.dwells import ChannelReading
from procedures.solution.request import SensorRows


def adaptive_in_words(item: SensorRows) -> str | None:
    """Return the rule and what was chosen for each axis of a sensor; None where ``[dwell]`` said how many readings."""
    limits = item.plan.dwell.adaptive
    if limits is None:
        return None
    axes = "; ".join(_axis(item, limits, axis, channel) for axis, channel in item.channels.items())
    return (
        f"adaptive dwells: read until the mean is known to {limits.noise_arcsec:g}″ (standard deviation), "
        f"{limits.least_samples} to {limits.most_samples} readings ([dwell.adaptive]): {axes}; {RULE}"
    )


def _axis(item: SensorRows, limits: AdaptiveDwell, axis: str, channel: str) -> str:
    readings = [dwell.readings[channel] for dwell in item.dwells if channel in dwell.readings]
    if not readings:
        return f"{axis} not read"
    counts = [reading.samples.size for reading in readings]
    span = f"{min(counts)}" if min(counts) == max(counts) else f"{min(counts)} to {max(counts)}"
    cycles = "" if limits.nplc is None else f" at {_nplc(item, limits.nplc, readings[-1]):g} NPLC"
    mean_v = sqrt(float(np.mean([reading.standard_deviation**2 / reading.samples.size for reading in readings])))
    mean_arcsec = mean_v / abs(item.sensor.nominal_v_per_g(axis)) / RAD_PER_ARCSEC
    capped = sum(count == limits.most_samples for count in counts)
    at_limit = f", {capped} of {len(counts)} dwells at the limit" if capped else ""
    return f"{axis} {span} readings{cycles}, means known to {mean_arcsec:.2g}″{at_limit}"


def _nplc(item: SensorRows, choices: tuple[float, ...], reading: ChannelReading) -> float:
    """Tell the integration of a burst by how long its readings took."""
    settings = item.rig.readouts[reading.channel.partition(".")[0]]
    return min(choices, key=lambda nplc: abs(settings.reading_s(nplc) - reading.interval_s))
