"""What past runs of a rig taught about how long the parts of a step really take, and what a plan then takes.

Of every past run and part there are sums: what the files expected, what was measured. A part of a new plan takes the
expected time by the ratio of the two. Ratios differ from run to run and from step to step; both spreads are learned,
and that the parts of one run are slow or quick together: the covariance of their ratios.

p50 and p90 of a plan are ranks among the past runs, each as long as the plan would have been in it. No shape is
assumed: most runs of few dwells take the same time to the second, and a few take a window or a repeated dwell longer.
A past run of another size is spread as much more or less as its steps are fewer or more. Where there are too few runs
for a rank of nine in ten, the p90 is that of a normal spread, by Student's t.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from ams.arrays import FloatArray
from procedures.plan.step_times import AGAIN, MOVE, StepPart
from procedures.statistics import t_limit

REPEATED = 0.05
"""Share of dwells that are measured again on a bad night; of it ``measured again`` is learned."""
FEWEST_RUNS = 3
"""Before so many runs nothing is learned: two say nothing of their spread."""
MOST_RUNS = 30
"""The latest: a rig is not what it was years ago."""
_TWO_SIDED = 0.2
"""A p90 is the upper end of the interval that leaves out a fifth."""
FEWEST_RANKED = 9
"""So many runs have a rank that one new run in ten exceeds: the longest."""


@dataclass(frozen=True, slots=True)
class PartSums:
    """Sums over the steps of one run that have a part of this name; seconds, or their squares."""

    count: int
    expected_s: float
    measured_s: float
    expected_s2: float
    rest_s2: float
    """Of what was measured, less the run's own ratio times what was expected."""

    @property
    def ratio(self) -> float:
        return self.measured_s / self.expected_s


def sums_of(pairs: Sequence[tuple[float, float]]) -> PartSums:
    """Return the sums of (expected, measured) seconds of the steps of one run; some is expected."""
    expected_s, measured_s = (sum(pair[index] for pair in pairs) for index in (0, 1))
    ratio = measured_s / expected_s
    return PartSums(
        count=len(pairs),
        expected_s=expected_s,
        measured_s=measured_s,
        expected_s2=sum(expected**2 for expected, _ in pairs),
        rest_s2=sum((measured - ratio * expected) ** 2 for expected, measured in pairs),
    )


@dataclass(frozen=True, slots=True)
class LearnedPart:
    """How what a part takes relates to what is expected of it."""

    ratio: float
    ratio_variance: float
    """Of one run's ratio about it, the uncertainty of ``ratio`` included."""
    step_variance: float
    """Of one step, as part of the square of what is expected of it."""
    between_variance: float = 0.0
    """Of one run's ratio about it, the scatter of its steps left out."""

    @classmethod
    def of(cls, runs: Sequence[PartSums]) -> "LearnedPart":
        expected_s = sum(run.expected_s for run in runs)
        ratio = sum(run.measured_s for run in runs) / expected_s
        inside = sum(run.expected_s2 * (1.0 - 1.0 / run.count) for run in runs)
        step_variance = sum(run.rest_s2 for run in runs) / inside if inside > 0.0 else 0.0
        of_steps = sum(step_variance * run.expected_s2 / run.expected_s**2 for run in runs) / len(runs)
        if len(runs) < 2:
            return cls(ratio, of_steps, step_variance)
        seen = sum((run.ratio - ratio) ** 2 for run in runs) / (len(runs) - 1)
        between = max(seen - of_steps, 0.0)
        return cls(ratio, between + (between + of_steps) / len(runs), step_variance, between)


@dataclass(frozen=True, slots=True)
class PartTime:
    """What all steps of a plan together take of one part, and what one of them does."""

    count: int
    p50_s: float
    p90_s: float
    each_p50_s: float = 0.0
    each_p90_s: float = 0.0


@dataclass(frozen=True)
class LearnedTimes:
    """Of one rig. ``parts``: by name; empty where there were too few runs. ``past``: the runs themselves."""

    runs: int = 0
    parts: Mapping[str, LearnedPart] = ()  # type: ignore[assignment]
    past: Sequence[Mapping[str, PartSums]] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "parts", dict(self.parts))

    @property
    def is_known(self) -> bool:
        return bool(self.parts)

    def of(self, name: str) -> LearnedPart | None:
        """Return what is known of a part; of a move of a size that was never made, what its axis' other moves say."""
        if name in self.parts or not name.startswith(MOVE):
            return self.parts.get(name)
        for kin in (name.rsplit(" up to ", 1)[0].rsplit(" over ", 1)[0], MOVE):
            found = [part for other, part in self.parts.items() if other.startswith(f"{kin} ")]
            if found:
                return LearnedPart(*(sum(figures) / len(found) for figures in zip(*map(_figures, found), strict=True)))
        return None

    def durations(self, parts: Iterable[StepPart]) -> tuple[float, float, dict[str, PartTime]]:
        """Return p50 and p90 of a plan, seconds, and of each part over all its steps.

        A part that no past run had takes what the files expect.
        """
        sums = _planned(parts)
        student = t_limit(max(self.runs - 1, 1), _TWO_SIDED)
        found: dict[str, PartTime] = {}
        p50_s = variance_s2 = 0.0
        for name, (count, expected_s, expected_s2) in sums.items():
            learned = self.of(name) or LearnedPart(0.0 if name == AGAIN else 1.0, 0.0, 0.0)
            part_s = learned.ratio * expected_s
            part_s2 = learned.ratio_variance * expected_s**2 + learned.step_variance * expected_s2
            p50_s, variance_s2 = p50_s + part_s, variance_s2 + part_s2
            each_s, each_deviation = part_s / count, sqrt(learned.ratio_variance + learned.step_variance)
            found[name] = PartTime(
                int(count),
                part_s,
                part_s + student * sqrt(part_s2),
                each_s,
                each_s + student * each_deviation * expected_s / count,
            )
        together_s2 = self._together_s2({name: part_sums[1] for name, part_sums in sums.items()})
        late_s = p50_s + student * sqrt(max(variance_s2 + together_s2, 0.0))
        if not self.past:
            return p50_s, late_s, found
        would_take_s = p50_s + self._apart_s(
            {name: (part_sums[1], part_sums[2]) for name, part_sums in sums.items()}, together_s2
        )
        # The longest of n runs is exceeded by one new run in n + 1, whatever their spread: rank i is i / (n + 1).
        ranked_s = np.quantile(would_take_s, (0.5, 0.9), method="weibull")
        is_ranked = self.runs >= FEWEST_RANKED
        return float(ranked_s[0]), float(ranked_s[1] if is_ranked else max(late_s, ranked_s[0])), found

    def _apart_s(self, plan: Mapping[str, tuple[float, float]], together_s2: float) -> FloatArray:
        """Return how far a plan would have been from its mean in each past run, s: (runs,).

        ``plan``: by part the sum of what is expected and of its squares. A part that a run did not have stands at its
        mean there.
        """
        known = {name: sums for name, sums in plan.items() if name in self.parts}
        shared_s2 = max(together_s2, 0.0)
        plan_s2 = shared_s2 + sum(
            self.parts[name].between_variance * expected_s**2 + self.parts[name].step_variance * expected_s2
            for name, (expected_s, expected_s2) in known.items()
        )
        apart_s = np.zeros(len(self.past))
        for index, run in enumerate(self.past):
            run_s2 = shared_s2
            for name, (expected_s, expected_s2) in known.items():
                part, sums = self.parts[name], run.get(name)
                share = expected_s2 / max(expected_s, 1e-300) ** 2
                if sums is not None:
                    apart_s[index] += (sums.ratio - part.ratio) * expected_s
                    share = sums.expected_s2 / sums.expected_s**2
                run_s2 += (part.between_variance + part.step_variance * share) * expected_s**2
            apart_s[index] *= sqrt(plan_s2 / run_s2) if run_s2 > 0.0 else 1.0
        return apart_s

    def _together_s2(self, expected_s: Mapping[str, float]) -> float:
        """Return what it adds to the variance of a plan that the parts of a run are slow or quick together, s².

        Twice the sum of their covariances over the past runs: the variance of the plan as each of them would have taken
        it, less that of its parts. Below zero where parts make up for each other. A part that a run did not have stands
        at its mean there.
        """
        if self.runs < FEWEST_RUNS:
            return 0.0
        apart_s = np.array(
            [
                [(run[name].ratio - self.parts[name].ratio) * part_s if name in run else 0.0 for run in self.past]
                for name, part_s in expected_s.items()
                if name in self.parts
            ]
        )
        if len(apart_s) < 2:
            return 0.0
        covariance_s2 = np.cov(apart_s)
        return float(covariance_s2.sum() - np.trace(covariance_s2)) * (1.0 + 1.0 / self.runs)


def _planned(parts: Iterable[StepPart]) -> dict[str, list[float]]:
    """Return of every part of a plan how often it comes, what is expected of it, and the sum of the squares of that."""
    sums: dict[str, list[float]] = {}
    for part in parts:
        part_sums = sums.setdefault(part.name, [0.0, 0.0, 0.0])
        part_sums[0] += 1
        part_sums[1] += part.expected_s
        part_sums[2] += part.expected_s**2
    taken_s, taken_s2 = (sum(part_sums[index] for part_sums in sums.values()) for index in (1, 2))
    sums[AGAIN] = [1, REPEATED * taken_s, REPEATED**2 * taken_s2]
    return sums


def again_of(undisturbed: Iterable[PartSums], again_s: Sequence[float]) -> PartSums:
    """Return the sums of ``measured again``: any step of a run may be, and few are.

    ``again_s``: what each step that was took too long.
    """
    taken = list(undisturbed)
    expected_s, expected_s2 = (
        REPEATED * sum(attempt.expected_s for attempt in taken),
        sum(attempt.expected_s2 for attempt in taken),
    )
    ratio, count = sum(again_s) / expected_s, sum(attempt.count for attempt in taken)
    rest_s2 = sum(seconds**2 for seconds in again_s) + ratio**2 * REPEATED**2 * expected_s2
    return PartSums(count + len(again_s), expected_s, sum(again_s), REPEATED**2 * expected_s2, rest_s2)


def learned_from(runs: Sequence[Mapping[str, PartSums]]) -> LearnedTimes:
    """Return what runs of one rig taught, the latest first."""
    latest = runs[:MOST_RUNS]
    if len(latest) < FEWEST_RUNS:
        return LearnedTimes()
    names = dict.fromkeys(name for run in latest for name in run)
    found = {name: [run[name] for run in latest if name in run and run[name].expected_s > 0.0] for name in names}
    past = [{name: sums for name, sums in run.items() if sums.expected_s > 0.0} for run in latest]
    return LearnedTimes(len(latest), {name: LearnedPart.of(sums) for name, sums in found.items() if sums}, past)


def _figures(part: LearnedPart) -> tuple[float, float, float, float]:
    return part.ratio, part.ratio_variance, part.step_variance, part.between_variance
