"""What is said of packages whose rows contradict themselves: which axis is at fault and how, and in which rows."""

from typing import Final

from ams.inference.inference import Package
from ams.inference.rows.angle_stream import AngleStream
from ams.inference.watch.faulty_axis import Cause, Explanation, Judgement
from ams.inference.watch.watched_axes import Stretch, WatchedAxes, watch_of

MOST_STRETCHES: Final = 3
"""That are told one by one."""


def doubts_of(angles: AngleStream, *, is_flagged_throughout: bool) -> tuple[str, ...]:
    """Say what the rows tell of each package whose axes are watched; nothing where nothing is wrong.

    ``is_flagged_throughout`` is whether the rows were answered again with what all of them prove; else those answered
    before it was known are named.
    """
    watched = watch_of(angles)
    if watched is None:
        return ()
    names = ("",) if len(watched.packages) == 1 else ("sting", "model")
    proven = watched.proven()
    said, of_stretches = [], [stretch.judged for stretch in proven]
    for name, package, judgement in zip(names, watched.packages, watched.judged().judgements, strict=True):
        how = f"{judgement.rows} rows evenly spaced over all were judged together"
        # What is told of the stretches says more than that one cause does not explain all rows.
        if judgement.cause is not Cause.UNEXPLAINED or not proven or watched.judged() in of_stretches:
            said.append(in_words(name, package, judgement, how))
    for stretch in proven[:MOST_STRETCHES]:
        if stretch.judged.is_turned:
            said.append(_turned(watched, stretch))
            continue
        if stretch.judged == watched.judged():
            continue
        where = f"rows {stretch.first + 1} to {stretch.end} disagree more often than chance has it"
        found = [
            in_words(name, package, judgement, f"{where}; {judgement.rows} of them were judged together")
            for name, package, judgement in zip(names, watched.packages, stretch.judged.judgements, strict=True)
        ]
        said += found if any(found) else [f"{watched.packages[0].coefficients.sensor}: {where}: {_APART}"]
    if len(proven) > MOST_STRETCHES:
        said.append(f"{watched.packages[0].coefficients.sensor}: {len(proven) - MOST_STRETCHES} more such stretches")
    if not is_flagged_throughout:
        said += [_untold(watched, stretch) for stretch in proven if stretch.is_proven]
    return tuple(text for text in said if text)


_FLAGGED: Final = "; angles of rows that agree are wrong by it as well and are flagged for it"
_UNFLAGGED: Final = "; angles of rows without a flag may be wrong by it as well"
"""Redundancy tells a row only where the fault changes the length of what is sensed."""
_APART: Final = "two packages contradict each other, each of which agrees with itself; no axis can be named"


def _turned(watched: WatchedAxes, stretch: Stretch) -> str:
    """Say how the model package sits against the sting package."""
    assert stretch.judged.turn is not None
    sting, model = (package.coefficients.sensor for package in watched.packages)
    where = "all rows" if stretch.end - stretch.first == watched.rows else f"rows {stretch.first + 1} to {stretch.end}"
    return (
        f"{model}, model package: {where} together hold it turned against {sting}, the sting package, by "
        f"{stretch.judged.turn.in_words} of its axes (k = 2), each package agreeing with itself: its mount, or the "
        f"sting package's, is not as calibrated{_FLAGGED}"
    )


def _untold(watched: WatchedAxes, stretch: Stretch) -> str:
    """Say which rows of a stretch were answered before it was proven; empty where none was."""
    since = min(
        (first for first, end in watched.flagged_rows if end > stretch.first and first < stretch.end), default=None
    )
    until = stretch.end if since is None else since
    if until <= stretch.first:
        return ""
    return (
        f"{watched.packages[0].coefficients.sensor}: rows {stretch.first + 1} to {until} were answered before that was "
        "proven: those of them that agree are not flagged and are as wrong; a file of the same rows is flagged "
        "throughout"
    )


def in_words(package_name: str, package: Package, judgement: Judgement, how: str) -> str:
    """Say what the rows of a package tell of its axes; empty where nothing is wrong."""
    if judgement.cause is Cause.NOTHING:
        return ""
    sensor = package.coefficients.sensor + (f", {package_name} package" if package_name else "")
    head = f"{sensor}: {how}: "
    axes = tuple(package.columns)
    others = _FLAGGED if judgement.is_proven else _UNFLAGGED
    if judgement.cause is Cause.AXIS:
        fault = judgement.possible[0]
        return (
            f"{head}{axes[fault.axis or 0]} is the faulty axis: {_fault(fault, judgement.rows)}; no other axis "
            f"explains them, nor an error of all alike{'' if 0 < fault.standing < judgement.rows else others}"
        )
    if judgement.cause is Cause.ALIKE:
        return (
            f"{head}all outputs are wrong alike and no axis by itself: {_changed(judgement.possible[0])}; look at "
            f"supply, meter and local gravity (--gravity-mps2){others}"
        )
    if judgement.cause is Cause.SEVERAL:
        said = [axes[fault.axis] if fault.axis is not None else "all outputs alike" for fault in judgement.possible]
        return (
            f"{head}the faulty axis cannot be named: {' or '.join(said)}, which these attitudes do not part; rows of "
            f"other attitudes do{others}"
        )
    if judgement.cause is Cause.UNMOVED:
        return (
            f"{head}the faulty axis cannot be named: all outputs stand still; rows of other attitudes are needed"
            f"{others}"
        )
    return (
        f"{head}the faulty axis cannot be named: no single one explains them, nor an error of all alike: more than "
        "one is wrong, two are interchanged, the fault came and went, the package was accelerated, or readings scatter "
        "more than is stated (--reading-sd-v)"
    )


def _fault(fault: Explanation, rows: int) -> str:
    if not fault.standing:
        return _changed(fault)
    at = " and ".join(f"{value:.6g} V" for value in fault.stands_at_v)
    if fault.standing == rows:
        return f"it stands at {at} while the others move"
    return f"it stands at {at} where the rows disagree, and agrees elsewhere"


def _changed(fault: Explanation) -> str:
    """Say what differs from the calibration, gain and offset, with twice their standard deviations."""
    said = []
    if abs(fault.gain - 1.0) > 2.0 * fault.gain_sd:
        said.append(f"{fault.gain:.6g} ± {2.0 * fault.gain_sd:.1g} times what the calibration says")
    if abs(fault.offset_v) > 2.0 * fault.offset_sd_v or not said:
        said.append(f"an offset of {1e3 * fault.offset_v:+.4g} ± {2e3 * fault.offset_sd_v:.1g} mV")
    return f"{' and '.join(said)} (k = 2)"
