"""Whether the dwells of every replication scatter alike: a night has quiet hours and others.

The absolute residuals about points and replications, over the root of their leverage, are compared between replications
by their means (Levene 1960). Beyond two and a half standard deviations of all dwells together they count as that much:
long tails, and single dwells that are wrong, are no difference between replications. How loud one is its median tells.
Two replications are as far from their mean as each other and say nothing, and few points say little.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import UNEVEN, UNTOLD, BeliefTest
from ams.analysis.diagnostics.residuals import GridResiduals
from ams.arrays import BoolArray, FloatArray
from ams.findings import Said
from ams.inputs.step_of_readings import step_of
from ams.rounding import significant
from ams.solve.layout import Layout
from ams.statistics.distributions import SD_PER_MEDIAN_DEVIATION, f_tail, median

_LEAST_REPLICATIONS: Final = 3
"""Of two nobody tells which one is louder than usual."""
_LEAST_DWELLS: Final = 40
"""Of a replication, beside its parameters: of fewer, replications seem to differ too often."""
_DRAWN_IN: Final = 2.5
"""Standard deviations, as the median deviation of all dwells tells them."""
_LEAST_PART: Final = 1e-4
"""Of a variance that is seen."""
_OF_A_STEP: Final = 0.5
"""Of a meter, which a dwell scatters by at least: with less noise most dwells of a point read the same."""
_LOUD: Final = 1e-3
"""Chance of as much in any replication, where all scatter alike."""


@dataclass(frozen=True)
class UnevenNoise:
    """Of one output."""

    p_value: float
    grid: GridResiduals
    away: FloatArray
    """(n,) mean absolute residual of each replication, drawn in."""
    uncertainty: FloatArray
    """(n,) of that, where all scatter alike."""
    dof: int
    """Of all dwells."""
    least_sd: float
    """Of a dwell, by the step of its readings."""

    @cached_property
    def is_loud(self) -> BoolArray:
        """(n,) whether a replication by itself scatters plainly more than the usual one.

        What is loud is in the mean of every point, and so in what all others leave: those that are left are asked again
        about their own means, until no further one is loud.
        """
        is_quiet, away, uncertainty = np.ones(self.away.size, dtype=bool), self.away, self.uncertainty
        while np.count_nonzero(is_quiet) >= _LEAST_REPLICATIONS and uncertainty.min() > 0.0:
            usual = float(np.sort(away[is_quiet])[(np.count_nonzero(is_quiet) - 1) // 2])  # of two, the quieter
            above = np.maximum(away - usual, 0.0) / uncertainty
            further = is_quiet & (f_tail(above**2, 1.0, float(self.dof)) < 2.0 * _LOUD / away.size)
            if not further.any():
                break
            is_quiet = is_quiet & ~further
            away, uncertainty = self._away_beside(is_quiet)
        return ~is_quiet

    def _away_beside(self, is_quiet: BoolArray) -> tuple[FloatArray, FloatArray]:
        """Return (n,) mean absolute residuals about the means of the quiet, drawn in, and how uncertain they are."""
        seen, judged = self._about(is_quiet), self._judged
        typical = max(SD_PER_MEDIAN_DEVIATION * median(seen[is_quiet][judged[is_quiet]]), self.least_sd)
        count = judged.sum(axis=1)
        drawn_in = np.minimum(seen, _DRAWN_IN * typical) * judged
        means = drawn_in.sum(axis=1) / count
        within = np.einsum("nk,nk->n", drawn_in, drawn_in) - count * means**2
        variance = max(float(within[is_quiet].sum()), 0.0) / float((count[is_quiet] - 1).sum())
        return means, np.sqrt(variance / count)

    @property
    def _judged(self) -> BoolArray:
        """(n, K) whether others say anything about a dwell."""
        return self.grid.judged.reshape(self.grid.replications, self.grid.points)

    def _about(self, is_quiet: BoolArray) -> FloatArray:
        """Return (n, K) how far every dwell is from the mean of the quiet, over the root of what its fit leaves."""
        grid = self.grid
        residuals = grid.residuals[:, 0].reshape(grid.replications, grid.points)
        beside = np.sqrt(np.maximum(1.0 - np.einsum("kp,kp->k", grid.q, grid.q), _LEAST_PART))
        return np.asarray(np.abs(residuals - residuals[is_quiet].mean(axis=0)) / beside)

    @cached_property
    def scatter(self) -> FloatArray:
        """(n,) standard deviation of a dwell of each replication, in the output's unit.

        Those that are not loud scatter about their own means by 1 − 1/m of their squares, m being how many they are; a
        loud one about these by its own square and 1/m of theirs.
        """
        is_loud = self.is_loud
        is_quiet = ~is_loud if np.count_nonzero(~is_loud) > 1 else np.ones_like(is_loud)
        quiet = int(np.count_nonzero(is_quiet))
        rows = zip(self._about(is_quiet), self._judged, strict=True)
        squares = (SD_PER_MEDIAN_DEVIATION * np.array([median(row[of_row]) for row, of_row in rows])) ** 2
        usual = float(np.median(squares[is_quiet])) / (1.0 - 1.0 / quiet)
        alone = np.maximum(squares - usual / quiet, _LEAST_PART * squares)
        return np.asarray(np.sqrt(np.where(is_quiet, squares / (1.0 - 1.0 / quiet), alone)))

    @cached_property
    def excess(self) -> FloatArray:
        """(n,) by how much loud replications scatter more than the usual one; 1 for the others."""
        usual = float(np.median(self.scatter[~self.is_loud])) if not self.is_loud.all() else 0.0
        ratio = self.scatter / usual if usual > 0.0 else np.ones_like(self.scatter)
        return np.where(self.is_loud & (ratio > 1.0), ratio, 1.0)


def uneven_noise(grid: GridResiduals, readings: FloatArray) -> UnevenNoise | None:
    """Return how the replications of one output scatter; None where too few of them or of their dwells tell it.

    ``readings`` (N,) show by their step what the median does not: where most dwells of a point read the same.
    """
    found = _scattering(grid, 0.0)
    if found is None or found.p_value > UNTOLD or not (step := step_of(readings)):
        return found
    return found if grid.typical_sd >= _OF_A_STEP * step else _scattering(grid, _OF_A_STEP * step)


def _scattering(grid: GridResiduals, least_sd: float) -> UnevenNoise | None:
    replications, points = grid.replications, grid.points
    if replications < _LEAST_REPLICATIONS or points - int(grid.q.shape[1]) < _LEAST_DWELLS:
        return None
    count = grid.judged.reshape(replications, points).sum(axis=1)
    if int(count.min()) < _LEAST_DWELLS:
        return None
    total, typical = int(count.sum()), max(grid.typical_sd, least_sd)
    away = np.minimum(grid.away, _DRAWN_IN * typical)
    means = away.reshape(replications, points).sum(axis=1) / count
    within = float(away @ away) - float(count @ means**2)
    variance = within / (total - replications)
    if not variance > _LEAST_PART * typical**2:
        return None
    between = float(count @ (means - float(count @ means) / total) ** 2) / (replications - 1)
    p_value = float(f_tail(between / variance, float(replications - 1), float(total - replications)))
    return UnevenNoise(p_value, grid, means, np.sqrt(variance / count), total - replications, least_sd)


def uneven_test(found: UnevenNoise | None, layout: Layout) -> tuple[BeliefTest, ...]:
    """Return the test of one output; nothing where it cannot be made."""
    if found is None:
        return ()
    if found.p_value > UNTOLD:
        return (BeliefTest(UNEVEN, "uneven-noise", found.p_value),)
    labels = zip(layout.replication_labels, found.excess.tolist(), strict=True)
    loud = tuple(str(label) for label, excess in labels if excess > 1.0)
    return (BeliefTest(UNEVEN, "uneven-noise", found.p_value, float(found.excess.max()), replications=loud),)


def uneven_words(test: BeliefTest) -> Said:
    """Return what is said of it where it is significant."""
    if not test.replications:
        return Said(
            "the dwells of some replications scatter plainly more than those of others: the noise changed while the "
            "run measured; each replication counts alike, and the stated uncertainties hold it"
        )
    which, is_single = " and ".join(test.replications), len(test.replications) == 1
    times = significant(test.size)
    scatter = f"replication {which} scatters {times}" if is_single else f"replications {which} scatter up to {times}"
    return Said(
        f"{scatter} times as much as the others: the noise was larger then; each replication counts alike, and the "
        "stated uncertainties hold it",
        "find what shook the rig or disturbed the channel, and measure again for a smaller uncertainty",
    )
