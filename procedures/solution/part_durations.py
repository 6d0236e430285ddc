"""How long the parts of a run's steps took, by its journal: each beside what the files expected of it.

Only what went on undisturbed teaches: a step whose attempt was rejected, void or moved again, or that did not follow
the step before it in the plan, is left out of its parts; what it took too long is ``measured again``. Time in which a
run was held, paused or interrupted lies between the steps and is never counted.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from procedures.plan.learned_times import PartSums, again_of, sums_of
from procedures.plan.step_times import AGAIN, BEGIN, END, MOVE, RAMP, SETTLE, SOAK, StepPart, step_parts
from procedures.records.dwells import DwellRecord, Event
from procedures.records.progress import MADE_AGAIN
from procedures.records.states import State
from procedures.solution.expected_readings import planned_readings
from procedures.solution.record import RunRecord

Key = tuple[int, int, int]
_DISTURBING = ("void", MADE_AGAIN)


@dataclass
class _Step:
    """One step as the journal tells it."""

    began_s: float
    is_disturbed: bool
    """It did not begin where the step before it in the plan ended."""
    ended_s: float = 0.0
    dwell: DwellRecord | None = None


@dataclass
class _Taken:
    """What is known so far: pairs of expected and measured seconds by part."""

    expected: Mapping[int | None, list[StepPart]]
    pairs: dict[str, list[tuple[float, float]]] = field(default_factory=dict)
    again_s: list[float] = field(default_factory=list)

    def add(self, name: str, expected_s: float, measured_s: float) -> None:
        if expected_s > 0.0:
            self.pairs.setdefault(name, []).append((expected_s, max(measured_s, 0.0)))

    def spread(self, parts: list[StepPart], measured_s: float) -> None:
        """Share what was measured of several parts as they were expected."""
        whole_s = sum(part.expected_s for part in parts)
        for part in parts:
            self.add(part.name, part.expected_s, measured_s * part.expected_s / whole_s if whole_s else 0.0)


def part_durations(record: RunRecord) -> dict[str, PartSums]:
    """Return the sums of every part of a run; empty where nothing of it went on undisturbed."""
    plan = record.plan
    expected: dict[int | None, list[StepPart]] = {}
    readings = planned_readings(record.rig, plan.dwell, plan.solve, plan.sensors)
    for part in step_parts(record.rig, plan.steps, plan.dwell, plan.channels, readings):
        expected.setdefault(part.step, []).append(part)
    taken = _Taken(expected)
    for number, step in _steps(record):
        _take(taken, expected.get(number, []), step)
    _take_ends(taken, record)
    found = {name: sums_of(pairs) for name, pairs in taken.pairs.items() if pairs}
    if not found:
        return {}
    return found | {AGAIN: again_of(found.values(), taken.again_s)}


def _take(taken: _Taken, parts: list[StepPart], step: _Step) -> None:
    took_s = step.ended_s - step.began_s
    if step.is_disturbed:
        taken.again_s.append(max(took_s - sum(part.expected_s for part in parts), 0.0))
        return
    dwell = step.dwell
    if dwell is None:
        hold_s = sum(part.expected_s for part in parts if part.name == SOAK)
        ramps = [part for part in parts if part.name == RAMP and part.expected_s > 0.0]
        taken.spread(ramps, took_s - hold_s)
        taken.add(SOAK, hold_s, hold_s if ramps else took_s)
        return
    ways = [part for part in parts if part.name.startswith(MOVE)]
    settles = [part for part in parts if part.name == SETTLE]
    others = [part for part in parts if part not in ways and part not in settles]
    settled_s = dwell.settle_s if settles else 0.0
    moved_s = dwell.started_s - step.began_s if ways else 0.0
    taken.spread(ways, moved_s)
    taken.spread(settles, settled_s)
    taken.spread(others, took_s - moved_s - settled_s)


def _steps(record: RunRecord) -> Iterator[tuple[int, _Step]]:
    """Yield number and times of every step that was ended, in the order in which they were."""
    dwells: dict[Key, DwellRecord] = {(dwell.step, dwell.attempt, dwell.epoch): dwell for dwell in record.dwells}
    follows = {here.step: there.step for here, there in zip(record.plan.steps, record.plan.steps[1:], strict=False)}
    last: int | None = None
    first = record.plan.steps[0].step if record.plan.steps else 0
    step: _Step | None = None
    for event in record.events:
        if event.kind == "intent":
            number = int(str(event.detail["step"]))
            in_order = number == (first if last is None else follows.get(last))
            step = _Step(event.monotonic_s, not in_order or int(str(event.detail.get("attempt", 1))) > 1)
        elif step is not None and event.kind in _DISTURBING:
            step.is_disturbed = True
        elif step is not None and event.kind in ("dwell", "soaked"):
            last, step.ended_s = int(str(event.detail["step"])), event.monotonic_s
            if event.kind == "dwell":
                key = last, int(str(event.detail["attempt"])), int(str(event.detail["epoch"]))
                step.dwell = dwells.get(key)
                step.is_disturbed |= step.dwell is None or not step.dwell.accepted
            yield last, step
            step = None
        elif event.kind == "opened":
            step = None


def _take_ends(taken: _Taken, record: RunRecord) -> None:
    """Take what came before the first step and behind the last, where the run was one piece."""
    intents = [event for event in record.events if event.kind == "intent"]
    ends = [event for event in record.events if event.kind in ("dwell", "soaked")]
    is_whole = record.state == State.FINISHED and all(dwell.epoch == 1 for dwell in record.dwells)
    if not is_whole or not intents or not ends:
        return
    by_name = {part.name: part for part in taken.expected.get(None, [])}
    began, ended = _moment(record.events[0], intents[0]), _moment(ends[-1], record.events[-1])
    for name, took_s in ((BEGIN, began), (END, ended)):
        if name in by_name:
            taken.add(name, by_name[name].expected_s, took_s)


def _moment(before: Event, behind: Event) -> float:
    return behind.monotonic_s - before.monotonic_s
