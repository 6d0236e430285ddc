"""What past runs of a rig taught about how long the parts of a step really take, and what a plan then takes.

Of every past run and part there are sums: what the files expected, what was measured. A part of a new plan takes the
expected time by the ratio of the two. Ratios differ from run to run and from step to step; both spreads are learned,
and that the parts of one run are slow or quick together: the covariance of their ratios. How far the p90 lies above the
p50 follows from them, by Student's t for as few runs as there are.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

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
    expected_s, measured_s = (sum(pair[place] for pair in pairs) for place in (0, 1))
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
        return cls(ratio, between + (between + of_steps) / len(runs), step_variance)


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
    """Of one rig. ``parts``: by name; empty where there were too few runs. ``ratios``: of each run, by part."""

    runs: int = 0
    parts: Mapping[str, LearnedPart] = ()  # type: ignore[assignment]
    ratios: Sequence[Mapping[str, float]] = ()

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
        sums: dict[str, list[float]] = {}
        for part in parts:
            one = sums.setdefault(part.name, [0.0, 0.0, 0.0])
            one[0] += 1
            one[1] += part.expected_s
            one[2] += part.expected_s**2
        taken_s = sum(one[1] for name, one in sums.items())
        sums[AGAIN] = [1, REPEATED * taken_s, (REPEATED * taken_s) ** 2]
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
        variance_s2 += self._together_s2({name: one[1] for name, one in sums.items()})
        return p50_s, p50_s + student * sqrt(max(variance_s2, 0.0)), found

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
                [(run[name] - self.parts[name].ratio) * part_s if name in run else 0.0 for run in self.ratios]
                for name, part_s in expected_s.items()
                if name in self.parts
            ]
        )
        if len(apart_s) < 2:
            return 0.0
        covariance_s2 = np.cov(apart_s)
        return float(covariance_s2.sum() - np.trace(covariance_s2)) * (1.0 + 1.0 / self.runs)


def learned_from(runs: Sequence[Mapping[str, PartSums]]) -> LearnedTimes:
    """Return what runs of one rig taught, the latest first."""
    latest = runs[:MOST_RUNS]
    if len(latest) < FEWEST_RUNS:
        return LearnedTimes()
    names = dict.fromkeys(name for run in latest for name in run)
    found = {name: [run[name] for run in latest if name in run and run[name].expected_s > 0.0] for name in names}
    ratios = [{name: sums.ratio for name, sums in run.items() if sums.expected_s > 0.0} for run in latest]
    return LearnedTimes(len(latest), {name: LearnedPart.of(sums) for name, sums in found.items() if sums}, ratios)


def _figures(part: LearnedPart) -> tuple[float, float, float]:
    return part.ratio, part.ratio_variance, part.step_variance
