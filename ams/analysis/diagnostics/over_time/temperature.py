"""What the recorded temperature has to do with what is left.

Not modelled: the outputs against the record, from replication to replication and from point to point. Over plateaus:
a sensor that follows the chamber with a time constant leaves T_lag − T, positive after cooling and negative after
heating, fading through the replication; one that bends leaves T². Both from physics: Ṫ = (T_chamber − T)/τ.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.residuals import GridResiduals
from ams.analysis.diagnostics.time_order import LEAST_DOF
from ams.arrays import FloatArray
from ams.models.drifting import SECONDS_PER_HOUR
from ams.models.thermal import TEMPERATURE_NAMES, WithTemperature
from ams.remembered import remembered
from ams.solve.layout import Layout
from ams.solve.recorded_temperature import SMALLEST_CHANGE_DEGC, swing_degc
from ams.statistics.distributions import f_tail

LAGS_H: Final = (0.1, 0.3, 1.0)
"""Time constants tried: a package, a package in its housing, a package on a heavy sting."""
SMALLEST_SWING_DEGC: Final = 1.0
"""°C: below it a chamber was not changed on purpose."""
LEAST_PLOTS: Final = 4
"""Replications that tell what temperature does to them from what they do by chance."""
_SURE = 0.05
"""The chance below which a bend is more than what else the replications do."""


@dataclass(frozen=True)
class Joint:
    """Several columns tested together, one output."""

    p_value: float
    size: float
    """Root mean square of what they explain, in the output's unit."""
    detail: float = float("nan")


NONE = Joint(float("nan"), float("nan"))


def varies(evidence: Evidence) -> bool:
    """Return whether a temperature was recorded that is not one number."""
    temperature = evidence.rows.temperature_degc
    return temperature is not None and swing_degc(temperature) > SMALLEST_CHANGE_DEGC


def departure_degc(evidence: Evidence) -> FloatArray | None:
    """Return (N,) the recorded temperature about its mean; None where it is one number or none is recorded."""
    temperature = evidence.rows.temperature_degc
    return None if temperature is None else _about_mean(temperature)


@remembered(16)
def _about_mean(temperature_degc: FloatArray) -> FloatArray | None:
    """Return None where it is one number."""
    changes = swing_degc(temperature_degc) > SMALLEST_CHANGE_DEGC
    return np.asarray(temperature_degc - temperature_degc.mean()) if changes else None


def departure_of_points(evidence: Evidence) -> FloatArray | None:
    """Return (K,) the mean temperature of every point about that of all; None where they are one number."""
    temperature = evidence.rows.temperature_degc
    return None if temperature is None else _departure_of_points(evidence.layout, temperature)


@remembered(16)
def _departure_of_points(layout: Layout, temperature_degc: FloatArray) -> FloatArray | None:
    column = layout.mean_by_point(temperature_degc)
    return column - column.mean() if np.ptp(column) > SMALLEST_CHANGE_DEGC else None


def has_plateaus(evidence: Evidence) -> bool:
    """Return whether the temperature was changed on purpose, as far as a span tells."""
    temperature = evidence.rows.temperature_degc
    return temperature is not None and swing_degc(temperature) >= SMALLEST_SWING_DEGC


def is_estimated(evidence: Evidence, output: int) -> bool:
    """Return whether the coefficients of an output are estimated over plateaus."""
    model = evidence.models[output]
    return isinstance(model, WithTemperature) and model.known is None and has_plateaus(evidence)


def lagged_degc(evidence: Evidence, time_constant_h: float) -> FloatArray | None:
    """Return (N,) temperature of a body that follows the record, less the record; None without times."""
    temperature, time = evidence.rows.temperature_degc, evidence.rows.time_s
    if temperature is None or time is None or not np.ptp(time) > 0.0:
        return None
    order = evidence.time_order
    kept = np.exp(-np.diff(time[order]) / (SECONDS_PER_HOUR * time_constant_h))
    steps = np.diff(temperature[order])
    apart = np.zeros(order.size)
    for index in range(1, order.size):
        apart[index] = (apart[index - 1] - steps[index - 1]) * kept[index - 1]
    found = np.empty(order.size)
    found[order] = apart
    return found


def lag(evidence: Evidence, output: int) -> Joint:
    """Test the time constants one by one, Bonferroni over them; ``detail`` is the one that explains most, hours."""
    grid, best, most = _beside_the_record(evidence, output), NONE, 0.0
    for time_constant_h in LAGS_H:
        columns = lag_columns(evidence, output, time_constant_h)
        if columns is None or grid.dof < LEAST_DOF:
            return NONE
        square, rank = explained(grid.projected(evidence.on_grid(columns)), grid.residuals[:, 0])
        rest = float(grid.squares[0]) - square
        if rank > 0 and rest > 0.0 and square > most:
            p_value = float(f_tail(square / rank / (rest / (grid.dof - rank)), rank, float(grid.dof - rank)))
            best = Joint(
                min(1.0, len(LAGS_H) * p_value), float(np.sqrt(square / evidence.layout.rows)), time_constant_h
            )
            most = square
    return best


def _beside_the_record(evidence: Evidence, output: int) -> GridResiduals:
    """Return the residuals of an output, without what it does at once with a temperature that no term is modelled for:
    a body that follows a slow change has nearly the form of the change itself.
    """
    grid, rise = evidence.grid.of(output), departure_degc(evidence)
    if rise is None or TEMPERATURE_NAMES[0] in evidence.models[output].primary_names:
        return grid
    return grid.beside(evidence.on_grid(np.column_stack([rise, rise * evidence.sensed[:, output]])))


def lag_columns(evidence: Evidence, output: int, time_constant_h: float) -> FloatArray | None:
    """Return (N, 2) what a lag does to the offset and to the sensitivity; None without times."""
    apart = lagged_degc(evidence, time_constant_h)
    return None if apart is None else np.column_stack([apart, apart * evidence.sensed[:, output]])


@dataclass(frozen=True)
class BetweenReplications:
    """What offset and sensitivity do from replication to replication, in the light of temperature."""

    curvature: Joint
    unexplained: float
    """p-value of what drift is left when temperature, its square and a lag are taken out."""


def between_replications(evidence: Evidence, output: int, lag_h: float | None, *, curved: bool) -> BetweenReplications:
    """Test the square of temperature beside its first power; and what is left beside all of that.

    The square counts as named where it explains more than what else the replications do: a chance error of each visit
    is not curvature.
    """
    temperature, layout = evidence.rows.temperature_degc, evidence.layout
    variance, dof = float(evidence.precision_variance[output]), evidence.grid.dof
    if temperature is None or evidence.sums is None or dof < LEAST_DOF or not variance > 0.0:
        return BetweenReplications(NONE, float("nan"))
    along = evidence.sensed[:, output]

    def pair(column: FloatArray) -> FloatArray:
        return evidence.layout.about_points(np.column_stack([column, column * along]))

    rise = temperature - temperature.mean()
    given = [pair(rise)]
    apart = None if lag_h is None else lagged_degc(evidence, lag_h)
    if apart is not None:
        given.append(pair(apart))
    e = evidence.departures[:, output]
    linear, rank = explained(np.hstack(given), e)
    bent, bent_rank = explained(np.hstack([*given, pair(rise**2)]), e) if curved else (linear, rank)
    every = [pair((layout.replication == r).astype(float)) for r in range(layout.replications - 1)]
    whole, whole_rank = explained(np.hstack([*given, pair(rise**2), *every] if curved else [*given, *every]), e)
    rest_rank = whole_rank - bent_rank
    rest = max(whole - bent, 0.0) / max(rest_rank, 1)
    unexplained = float(f_tail(rest / variance, rest_rank, float(dof))) if rest_rank > 0 else 1.0
    added = bent_rank - rank
    if not curved or added == 0 or layout.replications < LEAST_PLOTS:
        return BetweenReplications(NONE, unexplained)
    p_value = more_than_visits((bent - linear) / added, added, (rest, rest_rank), (variance, dof))
    size = float(np.sqrt(max(bent - linear, 0.0) / layout.rows))
    return BetweenReplications(Joint(p_value, size), unexplained)


def more_than_visits(square: float, rank: int, rest: tuple[float, int], precision: tuple[float, int]) -> float:
    """Return the chance of a mean square of ``rank`` columns; 1 where it is no more than what else replications do.

    ``rest``: mean square of that, and its rank; ``precision``: variance of a dwell, and its degrees of freedom.
    """
    other, other_rank = rest
    if other_rank > 0 and not float(f_tail(square / max(other, 1e-300), float(rank), float(other_rank))) < _SURE:
        return 1.0
    return float(f_tail(square / precision[0], float(rank), float(precision[1])))


def explained(columns: FloatArray, e: FloatArray) -> tuple[float, int]:
    """Return the sum of squares of e along the columns, and their rank."""
    length = np.linalg.norm(columns, axis=0)
    used = columns[:, length > 1e-9 * max(float(length.max()), 1e-300)]
    if used.shape[1] == 0:
        return 0.0, 0
    unit = used / np.linalg.norm(used, axis=0)
    values, vectors = np.linalg.eigh(np.asarray(unit.T @ unit))
    kept = values > 1e-9
    along = vectors[:, kept].T @ ((used / np.linalg.norm(used, axis=0)).T @ e)
    return float(np.sum(along**2 / values[kept])), int(kept.sum())
