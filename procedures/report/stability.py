"""Did rig and sensors stand still: temperature, reference attitude and check set, from the dwells."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np

from ams.arrays import FloatArray
from ams.finding_kinds import FINDING_KINDS, KINDS
from ams.findings import Finding
from ams.units import signed_in_words
from procedures.common_mode.check_sets import CheckSetPair, check_set_pairs, visits_before
from procedures.common_mode.visit_watch import Judged
from procedures.numbers import attitude
from procedures.records.dwells import ChannelReading, DwellRecord, Event
from procedures.report.view import CheckComparison, ReferenceTrace, TemperatureTrace
from procedures.run.judgement.restart_step import RestartComparison, compare, strongest
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

    One trace an attitude where there are several; nothing with fewer than two visits.
    """
    hours = run_times_s(dwells) / 3600.0
    groups: dict[str, list[int]] = {}
    for index, dwell in enumerate(dwells):
        if dwell.accepted and dwell.purpose == "reference":
            groups.setdefault(attitude(dwell.targets_deg), []).append(index)
    return tuple(
        ReferenceTrace(
            f"{label}, {where}" if len(groups) > 1 else label,
            hours[indices],
            _change([dwells[index] for index in indices], channel),
            sensitivity,
            dwells[indices[0]].readings[channel].unit,
        )
        for channel, (label, sensitivity) in labels.items()
        for where, indices in groups.items()
        if len(indices) > 1 and all(channel in dwells[index].readings for index in indices)
    )


def check_comparisons(
    dwells: Sequence[DwellRecord], labels: Labels, events: Sequence[Event] = (), judged_visits: Sequence[Judged] = ()
) -> tuple[CheckComparison, ...]:
    """Compare the check set of every later epoch with the first that counts, attitude by attitude, and judge it.

    ``judged_visits``: what check sets show over all sensors, as the verdict tells it.
    """
    found = []
    for pair in check_set_pairs(dwells, events):
        cause = _cause(
            finding
            for visit in judged_visits
            if visit.until[0] == pair.epoch and visit.step in pair.after
            for finding in visit.findings
        )
        judged = groupby(compare(pair.before, pair.after, visits_before(dwells, pair)), key=lambda step: step.channel)
        strongest_of = {channel: strongest(members) for channel, members in judged}
        first, later = (_by_attitude(members.values()) for members in (pair.before, pair.after))
        for channel, label in labels.items():
            comparison = _compare(pair.epoch, first, later, channel, label)
            if comparison is not None:
                found.append(replace(_judged(comparison, strongest_of.get(channel), pair), cause=cause))
    return tuple(found)


def restart_steps(checks: Sequence[CheckComparison]) -> tuple[str, ...]:
    """Return what a check set after a restart found changed beyond its limit: of each epoch the channel that the run
    itself named when it tripped.

    Where all sensors together show whose doing it is, that comes first, and no channel is blamed for it.
    """
    found = []
    for epoch, members in groupby(checks, key=lambda check: check.epoch):
        of_epoch = list(members)
        stepped, cause = [check for check in of_epoch if check.is_step], of_epoch[0].cause
        if not stepped and not cause:
            continue
        said = _steps_in_words(stepped) if stepped else "all channels together, none of them beyond its own limit"
        found.append(f"restart {epoch - 1}: {f'{cause}: ' if cause else ''}{said}")
    return tuple(found)


def _steps_in_words(stepped: Sequence[CheckComparison]) -> str:
    worst = max(stepped, key=lambda step: step.departure)
    size = signed_in_words(worst.departed_by, worst.unit, 3)
    changed, others = f"changed by {size} at {worst.departed_at}", len(stepped) - 1
    if worst.cause:
        channels = f"{len(stepped)} channels changed beyond their limits" if others else "one channel beyond its limit"
        return f"{channels}; {worst.label} {changed}"
    more = f", and {others} other channel{'s' if others > 1 else ''}" if others else ""
    return f"{worst.label} {changed}{more}"


def _cause(findings: Iterable[Finding]) -> str:
    """Return whose doing the change of a check set is where it is none of a sensor; empty where nothing says so.

    Of several the kind is told that stands first in the table of kinds: a turn of the table before the meter.
    """
    together = [finding for finding in findings if finding.is_significant and KINDS[finding.kind].together]
    foremost = min(together, key=lambda finding: FINDING_KINDS.index(finding.kind), default=None)
    if foremost is None:
        return ""
    same = ", or what would look the same" if foremost.details.get("confounded_with") else ""
    return f"{KINDS[foremost.kind].together}{same}"


def _judged(comparison: CheckComparison, step: RestartComparison | None, pair: CheckSetPair) -> CheckComparison:
    """Return a comparison with what departs most of it, as the run judged; None: a channel that is not judged."""
    if step is None:
        return comparison
    return replace(
        comparison,
        is_step=step.is_step and pair.is_alike,
        departure=step.departure,
        departed_by=step.change_v,
        departed_at=attitude(pair.after[step.step].targets_deg),
    )


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
