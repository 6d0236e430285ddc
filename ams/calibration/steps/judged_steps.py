"""Whether something changed in the middle of a run, for good or for a while, and whose doing it is.

All outputs of a package that were seen at the same rows are looked at together: the likeliest slip of the table and the
likeliest turn of the package on its mount, the likeliest step of the meter's gain and offset over all of them, and the
likeliest step of each by itself; each as one that stayed, and as one that came back. What is plain
enough to be convicted is named by the diagnosis that the engine makes of two visits
(:mod:`ams.surveillance.common_mode`), every attitude that was measured in it and outside being visited twice; it is
then taken out, and the search goes on.

A drift has a likeliest step, too. A change is told as one only where nothing else that the same pattern does, from
one part of a replication to the next, is of any size beside it, and where neither the recorded temperature nor, of two
or three replications, a level of each explains it as well. One that a drift explains as well is told where no drift is;
else the drift says that it may be that.

A turn on the mount is a change only where the diagnosis tells a turn of all outputs: of one axis it is that sensor's,
which drifts in coning and azimuth. What is none is set aside, with the drifts that it was looked at beside, and the
search goes on for the others.

An output whose even drift is plain beside the likeliest change keeps it beside all changes: the search is made again
with a slope in time of that output in the same model, and the diagnosis of two visits is told how well it is known. So
does one whose likeliest change is of its offset and no step, and so do all of them where a step of the meter's offset
is likeliest: a change of the gain or a turn, smaller than what drifts, is found beside it.
"""

from collections.abc import Iterator, Sequence
from typing import Final

from ams.analysis.diagnostics.axis.axis_tests import MOST_TESTS
from ams.analysis.diagnostics.beliefs import LEVEL, SLIP, STEP, BeliefTest
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.steps.step_scan import Change
from ams.calibration.steps import step_words
from ams.calibration.steps.proved_turns import ShownTurn, beside_proved
from ams.calibration.steps.step_findings import findings_of_change
from ams.calibration.steps.step_or_drift import likelier
from ams.calibration.steps.step_search import StepSearch
from ams.calibration.steps.steps_of_output import NO_STEPS, StepsOfOutput, UndecidedStep
from ams.finding_kinds import FindingKind
from ams.findings import Finding
from ams.inputs.known_of_run import ProvedChange

FindingOf = tuple[Finding, int | None]
"""A finding, and the output that it is of; None: all of them."""
_MOST: Final = 4
"""Changes looked for."""


def judge_steps(
    seen: Sequence[tuple[Evidence, int]], family: int, changes: Sequence[ProvedChange] = ()
) -> list[StepsOfOutput]:
    """Return what changed between two dwells, for good or for a while, by the outputs of a package.

    They were seen at the same rows.

    ``family``: axes of the run. ``changes``: of table or meter, proved by others; what they do is taken out first, a
    turn that is plain in the dwells as these tell it (:mod:`ams.calibration.steps.proved_turns`).
    """
    scattering = [index for index, (evidence, at) in enumerate(seen) if evidence.precision_variance[at] > 0.0]
    found = [NO_STEPS] * len(seen)
    if not scattering:
        return found
    level = LEVEL / family / MOST_TESTS
    search, shown = beside_proved(StepSearch(tuple(seen[index] for index in scattering)), tuple(changes), level)
    if not search.course.is_judged:
        for index in scattering:
            found[index] = StepsOfOutput(during=search.taken)
        return found
    for index, steps in zip(scattering, _found(search, level, shown), strict=True):
        found[index] = steps
    return found


def _found(search: StepSearch, level: float, shown: Sequence[ShownTurn]) -> list[StepsOfOutput]:
    first = search.changes
    findings: list[FindingOf] = [(finding, None) for turn in shown for finding in turn.findings_with_visits]
    changed: list[Change] = [turn.change for turn in shown]
    undecided: tuple[StepSearch, Change] | None = None
    while len(changed) < _MOST + len(shown) and (found := search.plainest(level)) is not None:
        best, seen = found
        if best.is_on_mount:
            turn = _turn_on_mount(search, level)
            if turn is None:
                search = search.with_mount_held()
                continue
            search, best, named = turn
        else:
            drifting = search.drifting_beside(best, level)
            is_gain = best.what == "sensitivity"
            gaining = frozenset[int]() if drifting or is_gain else search.gaining_beside(best, level)
            judged = "drift" if drifting or gaining else likelier(seen, best)
            if judged == "either" and undecided is None:
                undecided = seen, best
            if judged != "step":
                beside = search.beside_drift_of(drifting or search.passing_for(best, "offset"))
                if judged == "drift" and not drifting:
                    beside = beside.beside_gain_drift_of(gaining or search.passing_for(best, "sensitivity"))
                if beside is search:
                    break
                search = beside
                continue
            named = list(findings_of_change(seen, best))
        findings += named
        changed.append(best)
        search = search.without(best)
    outputs = {_whose(change) for change in changed}
    left = [change for change in search.changes if _whose(change) not in outputs]
    of_changed = [change for change in (*first, *changed) if _whose(change) in outputs]
    chances = [(change, search.chance(change) / search.share(change)) for change in (*left, *of_changed)]
    if undecided is not None and _whose(undecided[1]) in outputs:
        undecided = None
    return [
        StepsOfOutput(
            tuple(_tests(search, index, chances)),
            frozenset(filter(None, (_test_of(search, index, change) for change in changed))),
            tuple(finding for finding, whose in findings if whose in (None, index)),
            search.taken,
            search.drifting_of(index),
            None if undecided is None else _undecided_of(index, *undecided),
        )
        for index in range(len(search.seen))
    ]


def _turn_on_mount(search: StepSearch, level: float) -> tuple[StepSearch, Change, list[FindingOf]] | None:
    """Return the likeliest change as a turn of the package, what it was found beside and what is told of it.

    None where it is none: where the package turned all the time, the diagnosis of two visits says that not all outputs
    turned together, or it is likelier another change beside what they drift by.
    """
    found = search.plainest(level)
    if found is None or not found[0].is_on_mount:
        return None
    best, seen = found
    if drifting := search.drifting_beside(best, level):
        return _turn_on_mount(search.beside_drift_of(drifting), level)
    named = list(findings_of_change(seen, best)) if likelier(seen, best) == "step" else []
    is_turn = any(finding.kind == "table-rotation" and "cause" in finding.details for finding, _ in named)
    return (search, best, named) if is_turn else None


def _undecided_of(index: int, search: StepSearch, change: Change) -> UndecidedStep | None:
    """Return what is said of one output of a change that a drift explains as well; None where it is not of that one."""
    test = _test_of(search, index, change)
    if test is None:
        return None
    found = (finding for finding, whose in findings_of_change(search, change) if whose in (None, index))
    words = step_words.what_changed(change, search.course, search.evidence.rows)
    return UndecidedStep(test, words, tuple(finding.adding("a drift explains it as well") for finding in found))


def _whose(change: Change) -> tuple[int | None, bool]:
    return change.output, change.is_of_meter


def _test_of(search: StepSearch, index: int, change: Change) -> str | None:
    """Return the name of the test of an output that a change belongs to; None where it is no change of it."""
    if change.is_of_table:
        return SLIP
    return STEP if change.output == index or (change.is_of_meter and index in search.on_table) else None


def _tests(search: StepSearch, index: int, chances: Sequence[tuple[Change, float]]) -> Iterator[BeliefTest]:
    """Yield both tests of an output: of what is told as it was found, of the others beside it.

    ``chances``: of changes, for each of the outputs that share them.
    """
    of_test = [(_test_of(search, index, change), chance) for change, chance in chances]
    tests: tuple[tuple[str, FindingKind, int], ...] = (
        (SLIP, "table-rotation", len(search.on_table)),
        (STEP, "sensor-change", 1),
    )
    for name, kind, axes in tests:
        mine = [chance * axes for test, chance in of_test if test == name]
        if mine:
            yield BeliefTest(name, kind, min(1.0, *mine), axes=axes)
