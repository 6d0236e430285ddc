"""Whether terms of second and third order change with temperature: no model has that, and no parameter would show it.

The recorded temperature about its mean times each term of low order, (T − T̄) h, beside the effect of every point, the
linear sensor of every replication, and what offset and sensitivities do with T, T² and a lag. One F test of all terms
together. Where a term scatters from replication to replication by more than dwells do, without regard to temperature,
each term is referred to its own scatter instead: what a visit does by chance is no change with temperature.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import TERMS_OVER_TEMPERATURE, BeliefTest, TermChange
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.low_order import OF_GYROS, PPM, TERMS
from ams.analysis.diagnostics.over_time import temperature as by_temperature
from ams.analysis.diagnostics.point_means import independent
from ams.analysis.diagnostics.residuals import GridResiduals, grid_residuals
from ams.analysis.diagnostics.tested_terms import terms_at_points, tested_base
from ams.analysis.diagnostics.time_order import LEAST_DOF
from ams.arrays import FloatArray
from ams.models.accelerometer import LINEAR_COLUMNS
from ams.models.gyro import Gyro, GyroWithTerms
from ams.statistics.distributions import f_tail

_UNSTEADY: Final = 0.05
"""The chance below which terms scatter from replication to replication by more than dwells do."""
_STILL_NEEDED: Final = 0.002
"""The chance below which a further term is told beside those that are told already."""
_TESTED: Final = {name: unit for name, _, _, unit in TERMS if name not in ("K0'", "K1'")}
"""To the units of their coefficients. K₀′ and K₁′ are nearly collinear with K₃ and K₂: what they do passes for that."""


def of_terms_over_temperature(evidence: Evidence, output: int, lag: BeliefTest | None) -> list[BeliefTest]:
    """Return the test of one output; nothing where no temperature coefficients are estimated, or where nothing tells.

    ``lag``: the test of a lag behind the record, whose effect on offset and sensitivity is known beside the terms.
    """
    if not by_temperature.is_estimated(evidence, output):
        return []
    lag_h = None if lag is None or not np.isfinite(lag.uncertainty) else lag.uncertainty
    found = _tested(evidence, output, lag_h)
    return [] if found is None else [found]


def _tested(evidence: Evidence, output: int, lag_h: float | None) -> BeliefTest | None:
    changes = _changes_of(evidence, output, lag_h)
    if changes is None:
        return None
    return _of_each_term(changes) if changes.are_unsteady else _of_all_terms(changes)


@dataclass(frozen=True)
class _Changes:
    """Changes of terms with temperature, beside all that is known, and what they are held against."""

    units: Mapping[str, str]
    """Names of the terms to the units of their coefficients."""
    turned: FloatArray
    """(n, c) what a change of each term would add."""
    left: FloatArray
    """(n,) readings beside what is known."""
    size_v: float
    """Root mean square of what all changes together take up in a reading."""
    square_v2: float
    rank: int
    dwells: "_Scatter"
    visits: "_Scatter"
    """Of all terms from replication to replication, beside their change with temperature."""
    by_term: Sequence["_Scatter"]
    """Of each, likewise."""

    @property
    def are_unsteady(self) -> bool:
        """Whether terms scatter from replication to replication by more than dwells do."""
        each = (len(self.units) * scatter.p_value_of(self.dwells) for scatter in self.by_term)
        return min(self.visits.p_value_of(self.dwells), *each) < _UNSTEADY


def _changes_of(evidence: Evidence, output: int, lag_h: float | None) -> _Changes | None:
    """Return the changes of the terms that a model has; None where nothing is left to tell them."""
    rise, found = by_temperature.departure_degc(evidence), _terms(evidence, output)
    if rise is None or found is None or evidence.sums is None:
        return None
    units, terms = found
    point, along = evidence.layout.point, evidence.sensed[:, output]
    linear = evidence.basis[:, :LINEAR_COLUMNS]
    known = [rise[:, None] * linear[point], np.column_stack([rise**2, rise**2 * along])]
    lagging = None if lag_h is None else by_temperature.lag_columns(evidence, output, lag_h)
    if lagging is not None:
        known.append(lagging)
    given, columns = evidence.on_grid(np.hstack(known)), evidence.on_grid(rise[:, None] * terms[point])
    beside = _grid(evidence, output, linear).beside(given)
    rest = _grid(evidence, output, independent(np.hstack([linear, terms]))).beside(np.hstack([given, columns]))
    turned, left = beside.projected(columns), beside.residuals[:, 0]
    square, rank = by_temperature.explained(turned, left)
    if rank == 0 or rest.dof < LEAST_DOF or not rest.squares[0] > 0.0:
        return None
    by_term = [_between_visits(evidence, beside, terms[:, index], turned[:, index]) for index in range(len(units))]
    visits_dof = beside.dof - rank - rest.dof
    visits = max(float(beside.squares[0] - rest.squares[0]) - square, 0.0) / max(visits_dof, 1)
    return _Changes(
        units, turned, left, float(np.sqrt(square / evidence.layout.rows)), square, rank,
        dwells=_Scatter(float(rest.squares[0]) / rest.dof, float(rest.dof)),
        visits=_Scatter(visits, float(visits_dof)), by_term=by_term,
    )  # fmt: skip


def _of_all_terms(changes: _Changes) -> BeliefTest:
    """Return the test of all terms together against the scatter of dwells."""
    dwells = changes.dwells
    p_value = float(f_tail(changes.square_v2 / changes.rank / dwells.variance, float(changes.rank), dwells.dof))
    return _test(p_value, changes.size_v, _needed(changes.units, changes.turned, changes.left, dwells))


def _of_each_term(changes: _Changes) -> BeliefTest:
    """Return the test of the plainest term, each against its scatter from replication to replication."""
    columns = [changes.turned[:, index : index + 1] for index in range(len(changes.units))]
    squares = [by_temperature.explained(column, changes.left)[0] for column in columns]
    alone = [
        (scatter.p_value_of_column(square), index)
        for index, (scatter, square) in enumerate(zip(changes.by_term, squares, strict=True))
    ]
    p_value, index = min(alone)
    name = tuple(changes.units)[index]
    plainest = _needed({name: changes.units[name]}, columns[index], changes.left, changes.by_term[index])
    return _test(min(1.0, len(changes.units) * p_value), changes.size_v, plainest)


def _test(p_value: float, size: float, changes: tuple[TermChange, ...]) -> BeliefTest:
    test = BeliefTest(TERMS_OVER_TEMPERATURE, "temperature-curvature", p_value, size, is_held=False)
    return test._replace(changes=changes)


@dataclass(frozen=True)
class _Scatter:
    """A variance with its degrees of freedom; none: nothing tells it."""

    variance: float
    dof: float

    def p_value_of(self, dwells: "_Scatter") -> float:
        """Return the chance of so much scatter where there is that of the dwells alone."""
        return float(f_tail(self.variance / dwells.variance, self.dof, dwells.dof)) if self.dof > 0.0 else 1.0

    def p_value_of_column(self, square: float) -> float:
        """Return the chance of so large a square of one column."""
        return float(f_tail(square / max(self.variance, 1e-300), 1.0, self.dof)) if self.dof > 0.0 else 1.0


def _between_visits(evidence: Evidence, beside: GridResiduals, term: FloatArray, turned: FloatArray) -> _Scatter:
    """Return how one (K,) term scatters from replication to replication beside its change with temperature."""
    layout, e = evidence.layout, beside.residuals[:, 0]
    visits = np.equal.outer(layout.replication, np.arange(layout.replications)) * term[layout.point][:, None]
    each = np.column_stack([turned, beside.projected(evidence.on_grid(visits))])
    square, rank = by_temperature.explained(each, e)
    with_temperature, alone = by_temperature.explained(turned[:, None], e)
    dof = rank - alone
    return _Scatter(max(square - with_temperature, 0.0) / max(dof, 1), float(dof))


def _terms(evidence: Evidence, output: int) -> tuple[Mapping[str, str], FloatArray] | None:
    """Return names to units and the (K, c) terms at the points; None where the model has no such terms beside it."""
    base = tested_base(evidence.models[output])
    if base is None:
        return None
    is_gyro = isinstance(base, Gyro | GyroWithTerms)
    every = terms_at_points(evidence, output, base)
    units = {name: PPM for name in _TESTED if name in OF_GYROS} if is_gyro else _TESTED
    return units, every[:, [index for index, (name, *_) in enumerate(TERMS) if name in units]]


def _grid(evidence: Evidence, output: int, basis: FloatArray) -> GridResiduals:
    layout = evidence.layout
    left = evidence.left[:, output : output + 1]
    return grid_residuals(basis, left, evidence.dwell, layout.replications, layout.points)


def _needed(units: Mapping[str, str], columns: FloatArray, e: FloatArray, scatter: _Scatter) -> tuple[TermChange, ...]:
    """Return the terms that explain most, one after the other as long as another is needed, each beside the others."""
    names, length = tuple(units), np.linalg.norm(columns, axis=0)
    open_terms = [index for index in range(len(names)) if length[index] > 1e-9 * length.max()]
    taken: list[int] = []
    before = 0.0
    while open_terms:
        squares = [by_temperature.explained(columns[:, [*taken, index]], e)[0] for index in open_terms]
        best = int(np.argmax(squares))
        if taken and not scatter.p_value_of_column(squares[best] - before) <= _STILL_NEEDED:
            break
        before = squares[best]
        taken.append(open_terms.pop(best))
    chosen = columns[:, taken]
    coefficients = np.linalg.lstsq(chosen, e, rcond=None)[0]
    uncertainties = np.sqrt(scatter.variance * np.diag(np.linalg.pinv(chosen.T @ chosen)))
    return tuple(
        TermChange(names[index], units[names[index]], float(coefficient), float(uncertainty))
        for index, coefficient, uncertainty in zip(taken, coefficients, uncertainties, strict=True)
    )
