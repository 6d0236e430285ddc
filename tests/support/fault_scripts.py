"""Random fault scripts over a small campaign in virtual time, and the oracle that judges what came of each.

A person is there who says continue, looks after trips and resumes with a name and a reason, and gives up at last. The
oracle compares with the run that met no fault: a finished run whose parameters are off and that never said a word is
the one thing that must not happen.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from asking import put
from journals import a_clock
from resumed import resume_on
from small_run import Bench

from procedures.delivery.deliver import sensors_document, solve_run
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.spool import Spool
from procedures.records.progress import Progress, RunObserver, SilentObserver
from procedures.records.states import State
from procedures.run.begin import begin
from procedures.run.ending import Outcome
from rig.assembly.faulty_lines import drivers_of
from rig.assembly.open_rig import Rig, open_rig
from rig.description.fault_plan import FaultPlan
from rig.errors import RigError

MOST_RESUMES = 3
CONTINUES_EVERY, GIVES_UP_AFTER = 25, 125
"""Looks of a person at a run that stands still."""
SUSPICIOUS = ("suspect dwell", "noise", "slip")
"""Causes of a hold that speak of what was measured; lines and homes that were lost do not."""
CLEARLY = 5.0
"""So many times its 95 % limit: a test that says so does not say so by chance."""
AT_REST_S = 1.0
"""After the end of a run nothing moves any more from then on."""

Parameters = Mapping[tuple[str, str], tuple[float, float]]
"""(axis, parameter) to value and standard uncertainty."""


class Person:
    """Somebody's clock, whose seconds cost none: says continue now and then, and stop when it has gone on too long
    without a dwell. Also the run's observer, who passes on what it sees."""

    slice_s = 0.1
    factor = 1.0

    def __init__(self, run_dir: Path, seen: RunObserver) -> None:
        self._spool, self._clock, self._looks, self._seen = Spool(run_dir), a_clock(), 0, seen

    def on_event(self, progress: Progress) -> None:
        self._looks = 0 if progress.event == "dwell" else self._looks
        self._seen.on_event(progress)

    def sleep(self, duration_s: float) -> None:
        self._clock.sleep(duration_s)
        self._looks += 1
        if self._looks % CONTINUES_EVERY == 0:
            kind = "stop" if self._looks % GIVES_UP_AFTER == 0 else "continue"
            put(self._spool, kind, "ann", "seen", self.now_utc().isoformat())

    def monotonic_s(self) -> float:
        return self._clock.monotonic_s()

    def boottime_s(self) -> float:
        return self._clock.boottime_s()

    def now_utc(self) -> datetime:
        return self._clock.now_utc()


@dataclass
class Story:
    """What came of one script."""

    plan: FaultPlan
    run_dir: Path
    happened: list[str] = field(default_factory=list)
    """Each fault as it struck."""
    outcome: Outcome | None = None
    """None where the rig could not even be opened."""
    trips: int = 0
    causes: list[str] = field(default_factory=list)
    """Why the run was held or tripped."""
    parameters: Parameters = field(default_factory=dict)
    findings: list[str] = field(default_factory=list)
    """What the solution itself says against its data."""

    @property
    def is_finished(self) -> bool:
        return self.outcome is not None and self.outcome.state is State.FINISHED

    @property
    def is_flagged(self) -> bool:
        """A person was told that something may be wrong with what was measured."""
        return self.trips > 0 or bool(self.findings) or any(cause in SUSPICIOUS for cause in self.causes)


def tell_of(
    bench: Bench,
    run_dir: Path,
    plan: FaultPlan,
    observer: Callable[[Rig], RunObserver] = lambda rig: SilentObserver(),
    most_resumes: int = MOST_RESUMES,
    stopped_within_deg: float = 0.0,
) -> Story:
    """Run the campaign with the faults of ``plan``; raises AssertionError where something moved that must not.

    ``stopped_within_deg``: how far beyond its limits an axis may be that a damaged command sent there, in a run that
    tripped.
    """
    story = Story(plan, run_dir)
    run_dir.mkdir()
    try:
        rig = open_rig(bench.rig, faults=plan, tell_fault=story.happened.append)
    except RigError:
        return story
    with rig:
        person = Person(run_dir, observer(rig))
        outcome = begin(run_dir, bench.header(run_dir), bench.plan, rig, person, person)
        require_rest(rig, outcome)
        while outcome.state in (State.TRIPPED, State.STOPPED) and story.trips < most_resumes:
            story.trips += 1
            outcome = resume_on(run_dir, rig, "ann", "looked at it", person, person)
            require_rest(rig, outcome)
        story.outcome = outcome
        require_inside_limits(rig, stopped_within_deg if story.trips else 0.0)
    with JournalReader.open(run_dir) as reader:
        reader.verify()
        story.causes = [str(event.detail["cause"]) for event in reader.events("state") if "cause" in event.detail]
    if story.is_finished:
        solved = sensors_document(solve_run(run_dir))
        story.parameters, story.findings = parameters_of(solved), _findings(solved)
    return story


def parameters_of(solved: Mapping[str, Any]) -> Parameters:
    (sensor,) = solved.values()
    return {
        (axis, name): (found["value"], max(found["standard_uncertainty"], found["tp_standard_uncertainty"]))
        for axis, fitted in sensor["axes"].items()
        for name, found in fitted["parameters"].items()
    }


def _findings(solved: Mapping[str, Any]) -> list[str]:
    """Replication tests that are significant far beyond chance: the report shows them in red."""
    (sensor,) = solved.values()
    return [
        f"{axis}: {name}"
        for axis, fitted in sensor["axes"].items()
        for name, (t, f_95) in _tests(fitted["replication"]).items()
        if t > CLEARLY * f_95
    ]


def _tests(replication: Mapping[str, Any] | None) -> dict[str, tuple[float, float]]:
    if replication is None:
        return {}
    found = replication["tp"]
    drift = {name: (test["t"], test["f_95"]) for name, test in found["drift"].items()}
    return {"lack of fit": (found["t_bias"], found["f_bias_95"]), **drift}


def worst_deviation(story: Story, clean: Parameters) -> float:
    """Of any parameter from the clean run's, in the clean run's standard uncertainties."""
    return max(abs(story.parameters[key][0] - value) / uncertainty for key, (value, uncertainty) in clean.items())


def require_rest(rig: Rig, outcome: Outcome) -> None:
    """None after the deadline, whatever is still on its way on the lines."""
    world: Any = rig.chance
    rig.clock.sleep(AT_REST_S)
    before = {name: body.table_deg(rig.clock.monotonic_s()) for name, body in world.axes.items()}
    rig.clock.sleep(100.0)
    for name, body in world.axes.items():
        is_named = name in outcome.reason and "still" in outcome.reason
        assert is_named or body.table_deg(rig.clock.monotonic_s()) == before[name], f"{name} moves after the end"


def require_inside_limits(rig: Rig, within_deg: float = 0.0) -> None:
    world: Any = rig.chance
    for name, body in world.axes.items():
        low_deg, high_deg = rig.description.axes[name].limits_deg
        reached = body.reached_deg
        allowed_deg = within_deg + rig.axes[name].arrival_tolerance_deg
        assert reached[0] >= low_deg - allowed_deg, f"{name} was sent to {reached}"
        assert reached[1] <= high_deg + allowed_deg, f"{name} was sent to {reached}"


BYTES: Mapping[str, Mapping[str, object]] = {
    "drop": {},
    "delay": {"delay_s": (0.05, 8.0)},
    "freeze": {"delay_s": (0.05, 8.0)},
    "duplicate": {"delay_s": (0.0, 2.0)},
    "truncate": {"keep": (0, 6)},
    "split": {"keep": (1, 6), "delay_s": (0.01, 2.0)},
    "garble": {},
    "stale": {"text": ("1 OK\r\n", "+1.234567E+00\r\n", "\x00\xff", "@01 0 OK IDLE -- 0\r\n")},
    "echo": {},
    "previous": {},
}
"""Kinds that change bytes and can be noticed, with what each needs: a range, or choices."""
LINES: Mapping[str, Mapping[str, object]] = {
    "hang-up": {"away_s": (0.5, 60.0)},
    "rename": {"away_s": (0.5, 60.0)},
    "power-cycle": {"away_s": (0.0, 20.0)},
}
MOTION: Mapping[str, Mapping[str, object]] = {
    "stall": {"for_s": (0.5, 40.0)},
    "lag": {"lag_s": (0.1, 3.0)},
    "slip": {"slip_deg": (-3.0, 3.0), "seen": (True,)},
}
_QUESTIONS = frozenset({"drop", "delay", "freeze", "duplicate", "truncate", "split", "garble"})


def random_script(bench: Bench, seed: int, duration_s: float) -> FaultPlan:
    """One to three rules over the lines of a rig."""
    chance, drivers = np.random.default_rng(seed), drivers_of(bench.rig)
    rules = {f"f{number}": _rule(chance, drivers, duration_s) for number in range(int(chance.integers(1, 4)))}
    return FaultPlan.model_validate({"seed": seed, "fault": rules})


def _rule(chance: np.random.Generator, drivers: Mapping[str, str], duration_s: float) -> dict[str, object]:
    table = (BYTES, BYTES, BYTES, LINES, MOTION)[int(chance.integers(5))]
    kind = _choice_of(chance, sorted(table))
    lines = [line for line in drivers if table is not MOTION or line.startswith("axes.")]
    rule: dict[str, object] = {"kind": kind, "line": _choice_of(chance, lines)}
    rule |= {key: _drawn(chance, wanted) for key, wanted in table[kind].items()}
    if table is not BYTES:
        return rule | {"at_s": float(chance.uniform(0.0, duration_s))}
    if kind in _QUESTIONS and chance.uniform() < 0.3:
        rule["on"] = "question"
    when = int(chance.integers(3))
    if when == 0:
        return rule | {"nth": tuple(int(n) for n in chance.integers(1, 400, int(chance.integers(1, 5))))}
    if when == 1:
        return rule | {"at_s": float(chance.uniform(0.0, duration_s))}
    return rule | {"probability": float(chance.uniform(0.001, 0.01))}


def _drawn(chance: np.random.Generator, wanted: object) -> object:
    assert isinstance(wanted, tuple)
    if len(wanted) == 2 and isinstance(wanted[0], int) and not isinstance(wanted[0], bool):
        return int(chance.integers(wanted[0], wanted[1] + 1))
    if len(wanted) == 2 and isinstance(wanted[0], float):
        return float(chance.uniform(*wanted))
    return _choice_of(chance, wanted)


def _choice_of(chance: np.random.Generator, choices: Sequence[Any]) -> Any:
    return choices[int(chance.integers(len(choices)))]
