"""Which rows share an error of their own in every parameter: those of one replication, or of one visit of a plateau.

A chamber that is brought to a temperature leaves the package as it happens to settle that time: everything measured in
one visit shares it, and ten replications inside one visit say no more about it than one does. Where visits hold several
replications they, and not the replications, are therefore what the covariance counts: the whole plots of a split-plot
design (Montgomery, Design and Analysis of Experiments, chapter 14). Parameters that are only seen across the groups
(temperature coefficients, a drift with time) use up contrasts between them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.observations import Observations
from ams.remembered import remembered
from ams.solve.layout import Layout
from ams.solve.recorded_temperature import swing_degc

SMALLEST_GAP_DEGC = 2.0
"""Between two plateaus; also the largest spread inside one is held against it."""
_MOSTLY = 0.5


@dataclass(frozen=True)
class WholePlots:
    """Groups of rows, numbered from 0."""

    index: IntArray
    """(N,) group of each row."""
    count: int
    absorbed: int
    """Contrasts between the groups that one parameter's shared terms use up."""
    is_replications: bool

    @property
    def dof(self) -> int:
        """Degrees of freedom that are left between the groups; 0 or less: they say nothing about their spread."""
        return self.count - 1 - self.absorbed

    @property
    def name(self) -> str:
        return "replications" if self.is_replications else "whole plots"

    @cached_property
    def membership(self) -> FloatArray:
        """(N, groups) one where the row is of the group."""
        return np.eye(self.count)[self.index]

    def of_replication(self, layout: Layout) -> FloatArray:
        """Return (n, groups) one where the replication is of the group."""
        first = np.unique(layout.replication, return_index=True)[1]
        return self.membership[first]


@dataclass(frozen=True)
class Visits:
    """Stays at temperature plateaus, in the order of time."""

    index: IntArray
    """(N,) visit of each row, numbered in the order of time."""
    plateau_degc: tuple[float, ...]
    """Mean temperature of the plateau of each visit; the same number where a plateau was visited again."""


def visits_of(observations: Observations) -> Visits | None:
    """Return the visits of plateaus; None where the temperature was not held at two or more well apart."""
    temperature = observations.temperature_degc
    if temperature is None or observations.rows == 0 or swing_degc(temperature) < SMALLEST_GAP_DEGC:
        return None
    return _visits(temperature, observations.time_s)


@remembered(8)
def _visits(temperature: FloatArray, time_s: FloatArray | None) -> Visits | None:
    ordered = np.sort(temperature)
    edges = np.flatnonzero(np.diff(ordered) >= SMALLEST_GAP_DEGC)
    groups = np.split(ordered, edges + 1)
    if len(groups) < 2 or max(float(np.ptp(group)) for group in groups) >= SMALLEST_GAP_DEGC:
        return None
    plateau = np.searchsorted(0.5 * (ordered[edges] + ordered[edges + 1]), temperature)
    means = [float(group.mean()) for group in groups]
    in_time = np.arange(temperature.size) if time_s is None else np.argsort(time_s)
    changes = np.concatenate([[0], np.diff(plateau[in_time]) != 0])
    number = np.empty(temperature.size, dtype=np.int64)
    number[in_time] = np.cumsum(changes)
    starts = in_time[np.flatnonzero(np.concatenate([[True], changes[1:] > 0]))]
    return Visits(number, tuple(means[plateau_number] for plateau_number in plateau[starts]))


def whole_plots(layout: Layout, visits: Visits | None, shared: Sequence[FloatArray]) -> WholePlots:
    """Return the groups, with the (N,) regressors of parameters that are only seen across replications."""
    index, count, is_replications = layout.replication, layout.replications, True
    if visits is not None and _hold_replications(layout, visits):
        index, count, is_replications = visits.index, len(visits.plateau_degc), False
    absorbed = sum(_varies_between(regressor, index) for regressor in shared)
    return WholePlots(index, count, absorbed, is_replications)


def visit_warnings(layout: Layout, visits: Visits) -> tuple[str, ...]:
    """Return warnings of what the order of the visits cannot tell."""
    warnings = []
    different = len(set(visits.plateau_degc))
    if len(visits.plateau_degc) == different:
        sides = "" if different > 2 else ", one between them"
        warnings.append(
            "every temperature plateau was visited once only: what a visit does to the package cannot be told from "
            f"temperature; visit plateaus more than once{sides} and from both sides"
        )
    elif different == 2:
        warnings.append(
            "between two temperature plateaus the warmer is reached by warming and the colder by cooling, always: "
            "hysteresis passes for temperature; add a plateau between them, reached by warming and by cooling"
        )
    elif len(_one_sided(visits.plateau_degc)) == different:
        warnings.append(
            "every temperature plateau was reached from one side only: hysteresis passes for temperature; "
            "visit plateaus from both sides"
        )
    if layout.replications == 1:
        warnings.append(
            "all temperature plateaus stand in one replication: the visits' own error is not in the uncertainties; "
            "number every visit as a replication of its own"
        )
    return tuple(warnings)


def _one_sided(plateau_degc: Sequence[float]) -> set[float]:
    """Return the plateaus that were reached from one side only, or were where the run began."""
    sides: dict[float, set[bool]] = {degc: set() for degc in plateau_degc}
    for before, after in pairwise(plateau_degc):
        sides[after].add(after > before)
    return {degc for degc, seen in sides.items() if len(seen) < 2}


def _hold_replications(layout: Layout, visits: Visits) -> bool:
    """Return whether each replication lies inside one visit, and there are fewer visits than replications."""
    pairs = np.unique(layout.replication * len(visits.plateau_degc) + visits.index)
    return pairs.size == layout.replications > len(visits.plateau_degc)


def _varies_between(regressor: FloatArray, index: IntArray) -> bool:
    """Return whether a regressor varies mostly from group to group, not inside them."""
    means = np.bincount(index, weights=regressor) / np.bincount(index)
    return bool(np.var(means[index]) > _MOSTLY * np.var(regressor))
