"""Did rig and sensors stand still: temperature, reference attitude and check set, from the dwells."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby

import numpy as np

from ams.arrays import FloatArray
from procedures.numbers import attitude
from procedures.records.dwells import ChannelReading, DwellRecord
from procedures.report.view import CheckComparison, ReferenceTrace, TemperatureTrace
from procedures.solution.observations import run_times_s

Labels = Mapping[str, tuple[str, float]]
"""Channel to its name on the page and its sensitivity, V/g; 0 where its readings are no volts of gravity."""


def temperature_traces(dwells: Sequence[DwellRecord]) -> tuple[TemperatureTrace, ...]:
    """Return one trace an environment, all dwells in the order in which they were measured."""
    hours = run_times_s(dwells) / 3600.0
    names = sorted({name for dwell in dwells for name in dwell.temperature_degc})
    traces = []
    for name in names:
        degc = np.array([dwell.temperature_degc.get(name, np.nan) for dwell in dwells])
        known = np.isfinite(degc)
        if known.any():
            traces.append(TemperatureTrace(name, hours[known], degc[known]))
    return tuple(traces)


def reference_traces(dwells: Sequence[DwellRecord], labels: Labels) -> tuple[ReferenceTrace, ...]:
    """Return every channel at the reference attitude, as the change from its first visit.

    Nothing with fewer than two.
    """
    hours = run_times_s(dwells) / 3600.0
    places = [place for place, dwell in enumerate(dwells) if dwell.accepted and dwell.purpose == "reference"]
    if len(places) < 2:
        return ()
    visits = [dwells[place] for place in places]
    return tuple(
        ReferenceTrace(label, hours[places], _change(visits, channel), sensitivity, visits[0].readings[channel].unit)
        for channel, (label, sensitivity) in labels.items()
        if all(channel in visit.readings for visit in visits)
    )


def check_comparisons(dwells: Sequence[DwellRecord], labels: Labels) -> tuple[CheckComparison, ...]:
    """Compare the check set of every later epoch with the first one's, attitude by attitude."""
    checks = sorted(
        (dwell for dwell in dwells if dwell.accepted and dwell.purpose == "check"), key=lambda dwell: dwell.epoch
    )
    epochs = {epoch: _by_attitude(members) for epoch, members in groupby(checks, key=lambda dwell: dwell.epoch)}
    if len(epochs) < 2:
        return ()
    (_, first), *later = epochs.items()
    compared = (
        _compare(epoch, first, members, channel, label) for epoch, members in later for channel, label in labels.items()
    )
    return tuple(comparison for comparison in compared if comparison is not None)


def _change(visits: Sequence[DwellRecord], channel: str) -> FloatArray:
    means = np.array([visit.readings[channel].mean for visit in visits])
    return np.asarray(means - means[0])


def _by_attitude(dwells: Iterable[DwellRecord]) -> dict[str, DwellRecord]:
    return {attitude(dwell.targets_deg): dwell for dwell in dwells}


def _compare(
    epoch: int,
    first: Mapping[str, DwellRecord],
    later: Mapping[str, DwellRecord],
    channel: str,
    label: tuple[str, float],
) -> CheckComparison | None:
    pairs = {
        where: (first[where].readings[channel], later[where].readings[channel])
        for where in later
        if where in first and channel in first[where].readings and channel in later[where].readings
    }
    if not pairs:
        return None
    changes = {where: after.mean - before.mean for where, (before, after) in pairs.items()}
    worst = max(changes, key=lambda where: abs(changes[where]))
    variance = np.mean([_variance(before) + _variance(after) for before, after in pairs.values()])
    return CheckComparison(
        epoch=epoch,
        label=label[0],
        attitudes=len(pairs),
        mean_change=float(np.mean(list(changes.values()))),
        largest_change=changes[worst],
        largest_at=worst,
        scatter=float(np.sqrt(variance)),
        sensitivity_v_per_g=label[1],
        unit=first[worst].readings[channel].unit,
    )


def _variance(reading: ChannelReading) -> float:
    """Return the variance of the mean, from the scatter of the samples; 0 where one sample tells nothing."""
    size = reading.samples.size
    return reading.standard_deviation**2 / size if size > 1 else 0.0
