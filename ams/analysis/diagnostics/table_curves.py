"""Whether the index errors of a table stay within their declared limit, as all axes of a package see them at once.

Every index of an axis has one error E, seen by each output as its slope ∂v/∂angle. All outputs of a package together
have the points' means y = X c + Σ ∂v/∂angle·E + e, X every sensor's own and e its precision. The curve is free inside
the limit, |E| ≤ L at every index: what the best such curve leaves beyond the best curve of any size,

    D = min over |E| ≤ L of χ²  −  min over all E of χ²,

is the evidence against the limit, whatever the shape of the curve (once a turn, twice, eight harmonics, teeth). Under
the limit D is a chi-square of as many degrees of freedom as indices stand at their bound, or less (the conditional test
of Wollan and Dykstra 1986 for inequalities).

What the sensors do by themselves must not be blamed on the table. A cosine of pitch is K₂ of one axis and K_ip of the
others; so D is made beside the sensors' own terms of low order as well, where that curve is not seen at all. Without
the terms D counts only where two outputs or more see the same curve and, beside it, no sensor asks for terms.

A term of higher order of one sensor is a curve as well: K f_x² f_y of y is sin α cos α of pitch, which the others do
not see, and a free curve takes half of it. So two explanations are compared: a curve of any size, seen by all; and a
curve within the limit, with one output that has all terms up to fourth order of its own. Where the second has the less
χ² + p ln n, p parameters of n points (Schwarz 1978), D is that of the other outputs, without the one. The one keeps the
D of all: table or sensor, it does not tell which.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.inputs.indices import standing_at
from ams.inputs.table_uncertainty import TableUncertainty
from ams.statistics.distributions import f_tail
from ams.units import RAD_PER_ARCSEC

_SUSPICIOUS = 0.2
"""Points that a linear sensor on an exact table explains as well as this say nothing against a limit."""
_TERMS_NEEDED_P = 0.01
"""The chance below which terms of low order are needed beside errors of the indices."""
_ROUNDING = 1e-9
"""Of the largest eigenvalue or diagonal: less is rounding."""
_SEEN = 1e-3
"""Of all columns together: a direction with less of them is not seen."""
_LIKELY = 3.0
"""Limits, and standard uncertainties of droop and squareness: how large an error is believed before the points are
looked at, so that what they hardly see stays small."""
_STEPS = 4
"""Of the search for bounds that hold, for each bound, at the most."""
_EXPLAINED = 0.001
"""The chance below which errors within the limit do not explain what is left."""


@dataclass(frozen=True)
class SeenPoints:
    """The means of the points of one output, volts."""

    linear: FloatArray
    """(K, 4 or more) a linear sensor, and what is not known of the drift between replications that lack points."""
    terms: FloatArray
    """(K, t) of second and third order."""
    higher: FloatArray
    """(K, h) all of third and fourth order."""
    mean: FloatArray
    """(K,) less any fit by ``linear``."""
    weight: FloatArray
    """(K,) one over the standard deviation of a mean by precision."""
    slopes: Mapping[str, FloatArray]
    """Axis of the table to (K,) volts per radian."""
    precision_dof: float
    of_axes: FloatArray
    """(K, w) what one standard uncertainty of each error of droop and squareness does, the same errors for all outputs.
    """


@dataclass(frozen=True)
class Indices:
    """Of one axis of the table."""

    limit_rad: float
    """As declared."""
    columns: FloatArray
    """(K, t) one where a point stands at the index, less that of the index set to read true."""
    bound_rad: FloatArray
    """(t,)"""


@dataclass(frozen=True)
class TableLimit:
    """What the points say against the declared limit."""

    p_value: float
    largest_rad: Mapping[str, float]
    """Axis of the table to the largest error over its indices that the points ask for, the least that explains them."""
    limit_rad: Mapping[str, float]
    columns: Mapping[str, FloatArray]
    """Axis of the table to ``Indices.columns``."""
    outputs: int = 1
    """Of the package, all of which have this one test."""
    is_of_single_output: bool = False
    """Whether the points of all outputs speak against the limit only for one that departs by terms of its own."""
    departing: int | None = None
    """Which output of the package that is."""
    p_value_of_all: float = 1.0
    """With it."""
    is_explained: bool = True
    """Whether errors of the indices of any size explain the points; nothing is said of the limit where they do not."""
    is_departing: bool = False
    """Whether this is what it says to that output itself."""

    def of_output(self, index: int | None) -> "TableLimit":
        """Return what it says to an output of the package: table or sensor to the one that departs, as far as it tells.

        Where few outputs see an axis of the table, a curve of the table beyond its limit passes for that output's own
        terms: to say of neither would be to say nothing.
        """
        if index is None or index != self.departing:
            return self
        return replace(self, p_value=self.p_value_of_all, is_of_single_output=False, is_departing=True)

    def effects(self, slopes: Mapping[str, FloatArray], known: FloatArray) -> FloatArray:
        """Return (K, c) orthonormal columns of what any index errors do to an output, beside the ``known`` ones."""
        joined = np.hstack([slopes[name][:, None] * columns for name, columns in self.columns.items()])
        q, _ = np.linalg.qr(known)
        left = joined - q @ (q.T @ joined)
        vectors, lengths, _ = np.linalg.svd(left, full_matrices=False)
        return np.asarray(vectors[:, lengths > _SEEN * np.linalg.norm(joined)])


def indices_of(table: TableUncertainty, axis: str, shown_rad: FloatArray) -> Indices | None:
    """Return the indices that (K,) points stand at; None where the axis is taken as exact."""
    declared, limit = table.declared(axis), table.limit_rad(axis)
    zero_rad = declared.zero_rad if declared.known is None else None
    columns, mean_rad = standing_at(shown_rad if zero_rad is None else np.append(shown_rad, zero_rad))
    bound = np.full(mean_rad.size, limit)
    if declared.known is not None:
        spread = np.sqrt(np.sum(table.index_errors(axis, mean_rad).scaled_rad ** 2, axis=1))
        bound, limit = float(np.sqrt(3.0)) * spread, float(np.sqrt(3.0) * spread.max())
    elif zero_rad is not None:
        columns = columns[:-1] - columns[-1]
        if declared.zero_standard_uncertainty_rad > 0.0:
            columns = np.column_stack([columns, np.ones(shown_rad.size)])
            bound = np.append(bound, float(np.sqrt(3.0)) * declared.zero_standard_uncertainty_rad)
    does_something = (bound > 0.0) & columns.any(axis=0)
    if not does_something.any():
        return None
    return Indices(limit, columns[:, does_something], bound[does_something])


@dataclass(frozen=True)
class _Normal:
    """Least squares for E beside what every sensor has of its own."""

    matrix: FloatArray
    right: FloatArray
    square: float
    rows: int
    unshared: int

    def unbounded(self) -> tuple[FloatArray, float, int]:
        values, vectors = np.linalg.eigh(self.matrix)
        seen = values > _ROUNDING * values[-1]
        along = vectors[:, seen].T @ self.right
        curve = vectors[:, seen] @ (along / values[seen])
        return curve, self.square - float(along @ (along / values[seen])), int(seen.sum())

    def at(self, curve: FloatArray) -> float:
        return self.square - 2.0 * float(self.right @ curve) + float(curve @ self.matrix @ curve)

    def plus(self, other: "_Normal") -> "_Normal":
        return _Normal(
            self.matrix + other.matrix,
            self.right + other.right,
            self.square + other.square,
            self.rows + other.rows,
            self.unshared + other.unshared,
        )


@dataclass(frozen=True)
class _Output:
    """Of one output: linear, with terms of its own of low order, and with those of higher order as well."""

    plain: _Normal
    beside: _Normal
    higher: _Normal
    precision_dof: float

    @classmethod
    def of(cls, output: SeenPoints, indices: Mapping[str, Indices]) -> "_Output":
        with_terms = np.hstack([output.linear, output.terms])
        with_higher = np.hstack([with_terms, output.higher])
        plain, beside, higher = (_normal(output, indices, basis) for basis in (output.linear, with_terms, with_higher))
        return cls(plain, beside, higher, output.precision_dof)


def beyond_limit(outputs: Sequence[SeenPoints], indices: Mapping[str, Indices]) -> TableLimit:
    """Test the limit; a p-value of one where the points do not even ask for index errors."""
    nothing = TableLimit(
        1.0,
        dict.fromkeys(indices, 0.0),
        {name: index.limit_rad for name, index in indices.items()},
        {name: index.columns for name, index in indices.items()},
        max(len(outputs), 1),
    )
    if not outputs or not indices:
        return nothing
    of_axes = np.full(outputs[0].of_axes.shape[1], _LIKELY * RAD_PER_ARCSEC)
    bound = np.concatenate([*[index.bound_rad for index in indices.values()], of_axes])
    seen = [_Output.of(output, indices) for output in outputs]
    p_value, normal = _of_outputs(seen, bound)
    if normal is None:
        return nothing
    alone = _departing_alone(seen, bound)
    of_others = 0.0 if alone is None else _of_outputs([*seen[:alone], *seen[alone + 1 :]], bound)[0]
    found = np.linalg.solve(normal.matrix + np.diag((_LIKELY * bound) ** -2.0), normal.right)
    edges = np.cumsum([index.bound_rad.size for index in indices.values()])
    largest = {
        name: float(np.abs(index.columns @ curve).max())
        for (name, index), curve in zip(indices.items(), np.split(found, edges)[:-1], strict=True)
    }
    is_of_single_output = p_value < _TERMS_NEEDED_P <= of_others
    return replace(
        nothing,
        p_value=max(p_value, of_others),
        largest_rad=largest,
        is_of_single_output=is_of_single_output,
        departing=alone,
        p_value_of_all=p_value,
        is_explained=_is_explained(seen),
    )


def _of_outputs(outputs: Sequence[_Output], bound: FloatArray) -> tuple[float, _Normal | None]:
    """Return the p-value of the limit by some outputs, and the least squares that it is of.

    None where a linear sensor on an exact table does.
    """
    dof = float(sum(output.precision_dof for output in outputs))
    plain, beside = _sum(output.plain for output in outputs), _sum(output.beside for output in outputs)
    left = plain.rows - plain.unshared
    if left <= 0 or not f_tail(plain.square / left, left, dof) < _SUSPICIOUS:
        return 1.0, None
    judged = [(_tested(beside, bound, dof), beside)]
    if len(outputs) > 1 and not _asks_for_terms(outputs):
        judged.append((_tested(plain, bound, dof), plain))
    p_value, normal = min(judged, key=lambda pair: pair[0])
    return min(1.0, len(judged) * p_value), normal


def _asks_for_terms(outputs: Sequence[_Output]) -> bool:
    """Tell whether the sensors ask for terms of their own beside a curve of any size."""
    dof = float(sum(output.precision_dof for output in outputs))
    plain, beside = _sum(output.plain for output in outputs), _sum(output.beside for output in outputs)
    _, without, rank = plain.unbounded()
    _, with_terms, rank_beside = beside.unbounded()
    left = beside.rows - beside.unshared - rank_beside
    added = (beside.unshared + rank_beside) - (plain.unshared + rank)
    if left <= 0 or added <= 0:
        return True
    return bool(f_tail((without - with_terms) / added, added, dof) < _TERMS_NEEDED_P)


def _departing_alone(outputs: Sequence[_Output], bound: FloatArray) -> int | None:
    """Return which of several outputs departs by terms of its own; None where a curve that all see explains better."""
    if len(outputs) < 2:
        return None
    forms = [[output.plain for output in outputs], [output.beside for output in outputs]]
    of_the_table = min(_of_any_curve(_sum(form)) for form in forms)
    of_sensor = [
        min(_of_curve_within(_sum([*form[:index], output.higher, *form[index + 1 :]]), bound) for form in forms)
        for index, output in enumerate(outputs)
    ]
    best = int(np.argmin(of_sensor))
    return best if of_sensor[best] < of_the_table else None


def _of_any_curve(normal: _Normal) -> float:
    """Return χ² + p ln n of a curve of any size."""
    _, least, rank = normal.unbounded()
    return least + (normal.unshared + rank) * float(np.log(normal.rows))


def _of_curve_within(normal: _Normal, bound: FloatArray) -> float:
    """Return χ² + p ln n of a curve within the limit, which is known so far and counts as no parameter."""
    curve, _ = _bounded(normal.matrix, normal.right, bound)
    return normal.at(curve) + normal.unshared * float(np.log(normal.rows))


def _is_explained(outputs: Sequence[_Output]) -> bool:
    """Return whether a curve of any size, with terms of the sensors' own, explains the points."""
    normal, dof = _sum(output.beside for output in outputs), float(sum(output.precision_dof for output in outputs))
    return not _leaves_more(normal, dof)


def _leaves_more(normal: _Normal, dof: float) -> bool:
    """Return whether a curve of any size leaves more than chance does."""
    _, least, rank = normal.unbounded()
    left = normal.rows - normal.unshared - rank
    return left > 0 and bool(f_tail(least / left, left, dof) < _EXPLAINED)


def _tested(normal: _Normal, bound: FloatArray, dof: float) -> float:
    _, least, rank = normal.unbounded()
    left = normal.rows - normal.unshared - rank
    if left <= 0:
        return 1.0
    curve, at_bound = _bounded(normal.matrix, normal.right, bound)
    within = normal.at(curve)
    active = min(int(at_bound.sum()), rank)
    if active == 0 or not within > least:
        return 1.0
    if _leaves_more(normal, dof):
        return 1.0
    return float(f_tail((within - least) / active, active, dof))


def _sum(normals: Iterable[_Normal]) -> _Normal:
    """Return the least squares of several outputs that see the same E."""
    return reduce(_Normal.plus, normals)


def _normal(output: SeenPoints, indices: Mapping[str, Indices], basis: FloatArray) -> _Normal:
    weight = output.weight[:, None]
    q, r = np.linalg.qr(weight * basis)
    q = q[:, np.abs(np.diag(r)) > _ROUNDING * np.abs(np.diag(r)).max()]
    of_indices = [output.slopes[name][:, None] * seen.columns for name, seen in indices.items()]
    # In arc seconds: beside a radian of an index one standard uncertainty would be as good as nothing.
    columns = weight * np.hstack([*of_indices, output.of_axes / RAD_PER_ARCSEC])
    columns = columns - q @ (q.T @ columns)
    y = output.weight * output.mean
    y = y - q @ (q.T @ y)
    return _Normal(columns.T @ columns, columns.T @ y, float(y @ y), y.size, q.shape[1])


def _bounded(matrix: FloatArray, right: FloatArray, bound: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Return the x within ±bound with the least ½xᵀMx − rᵀx, and which stand at their bound.

    By an active set (Stark and Parker 1995): one index is let go at a time, and those that run into their bound stay.
    """
    matrix = matrix + _ROUNDING * np.trace(matrix) / bound.size * np.eye(bound.size)
    x = np.clip(np.linalg.solve(matrix, right), -bound, bound)
    free = np.abs(x) < bound
    tolerance = _ROUNDING * float(np.abs(right).max())
    for _ in range(_STEPS * bound.size):
        x, free = _moved_within(matrix, right, bound, x, free)
        inwards = np.where(free, 0.0, np.sign(x) * (matrix @ x - right))
        if not inwards.max() > tolerance:
            break
        free[np.argmax(inwards)] = True
    return x, ~free


def _moved_within(
    matrix: FloatArray, right: FloatArray, bound: FloatArray, x: FloatArray, free: BoolArray
) -> tuple[FloatArray, BoolArray]:
    """Return the least over what is free, and what is free still: the first to reach its bound stays there."""
    x, free = x.copy(), free.copy()
    while free.any():
        step = np.linalg.solve(matrix[free][:, free], (right - matrix @ x)[free])
        room = np.where(step > 0.0, bound[free] - x[free], bound[free] + x[free])
        with np.errstate(divide="ignore"):
            reach = np.where(step == 0.0, np.inf, room / np.abs(step))
        first = int(np.argmin(reach))
        x[free] += min(1.0, float(reach[first])) * step
        if reach[first] >= 1.0:
            break
        index = np.flatnonzero(free)[first]
        x[index], free[index] = np.copysign(bound[index], step[first]), False
    return x, free
