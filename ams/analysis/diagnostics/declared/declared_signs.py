"""Whether the readings fit the signs and the order of the angles that are declared, and the axes one polarity.

A sign of pitch, yaw or roll that is the other way round, two angles that change places and a reversed output are tried
one beside the other: every candidate is a basis of its own at the same points, as many parameters as the declared one.
Where the declared angles leave many times what another candidate leaves, the declared ones are contradicted, whatever
the covariance makes of the lack of fit. Several candidates may fit alike (a sign that only mirrors gravity does): the
one is named that needs the fewest changes, polarities of axes that then are not as declared counted as changes too.
Where nothing tells two of them apart, both are named. Source: MATH 1 for what the signs of the angles do to gravity.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import permutations, product
from typing import Final, NamedTuple

import numpy as np

from ams.analysis.diagnostics.declared.declared_axis import KIND, component_indices
from ams.arrays import FloatArray
from ams.findings import FITS_WITH, Finding
from ams.frames import ANGLES, AXES
from ams.inputs.declared_direction import DeclaredDirection
from ams.models.model import Model
from ams.observations import Observations
from ams.rounding import significant
from ams.solve.layout import Layout
from ams.statistics.distributions import f_tail
from ams.units import ARCSEC_PER_DEG, printed

AS_DECLARED_TO: Final = "as_declared_to_v"
"""Of a finding's details: the standard deviation over the points of what the declared angles leave."""
_PER_GRAVITY: Final = "CR"
"""This convention counts sensitivities per g of gravity: sensors of specific force read against it, all of them. Gyros
of a package read with the rates about its axes, all of them."""
_MANY_TIMES: Final = 16.0
"""What the declared angles leave over what others leave, in squares: four times the standard deviation."""
_CHANCE: Final = 1e-6
"""That as much is left by chance, of all candidates."""
_ROUNDING: Final = 1e-24
"""Of the square of an output: less is left of readings without noise."""
_DETERMINED: Final = 1e-6
"""Of the largest singular value: a candidate whose points leave a direction open explains nothing."""
_MOST_NAMED: Final = 3
"""Readings of the angles that fit alike; of more it is said that there are others."""


class Package(NamedTuple):
    """One package at its points, and what is declared of its axes, in one order."""

    rows: Observations
    """(N)"""
    layout: Layout
    labels: Sequence[str]
    """(m)"""
    models: Sequence[Model]
    """(m) without terms of second order, temperature or time."""
    declared: Sequence[DeclaredDirection]
    """(m)"""


class _Candidate(NamedTuple):
    """A reading of the declared angles: which of them each angle is, and with which sign."""

    order: tuple[int, ...]
    signs: tuple[int, ...]

    @property
    def changes(self) -> int:
        """How many signs are turned round and pairs interchanged."""
        moved = sum(at != where for where, at in enumerate(self.order))
        return self.signs.count(-1) + max(moved - 1, 0)

    def words(self) -> str:
        """Return what is other than declared."""
        reversed_ones = [ANGLES[index] for index, sign in enumerate(self.signs) if sign < 0]
        moved = [ANGLES[index] for index, at in enumerate(self.order) if at != index]
        parts = [f"{' and '.join(moved)} interchanged"] if len(moved) == 2 else []
        if len(moved) == 3:
            parts = [f"{', '.join(ANGLES)} in the order {', '.join(ANGLES[at] for at in self.order)}"]
        if reversed_ones:
            parts.append(f"{' and '.join(reversed_ones)} of the opposite sign")
        return " and ".join(parts)


@dataclass(frozen=True)
class _Fit:
    """What a candidate leaves of the outputs, and how the axes read by it."""

    candidate: _Candidate
    left: FloatArray
    """(m,) share of the squares of every output."""
    size: FloatArray
    """(m,) standard deviation of what is left, of every point."""
    length: FloatArray
    """(m,) of the vector of sensitivities."""
    astray: int
    """How many axes lie along another one than declared."""
    reversed_axes: tuple[str, ...]
    """Those whose polarity is not that of the others, or not as declared."""

    @property
    def changes(self) -> int:
        return self.candidate.changes + self.astray + len(self.reversed_axes)


def fits_other_angles(finding: Finding) -> bool:
    """Return whether a finding says that other signs, or another order, of the angles explain a lack of fit."""
    return finding.kind == KIND and AS_DECLARED_TO in finding.details


def judge_signs(package: Package, *, lacks_fit: bool) -> Mapping[str, Finding]:
    """Return label to the finding that its angles, or its polarity, are not those declared.

    ``lacks_fit``: whether anything is left beyond chance that other angles could explain; else the polarities alone
    are looked at.
    """
    is_per_gravity = package.models[0].convention == _PER_GRAVITY
    if not is_of_attitudes(package) or not (lacks_fit or is_per_gravity):
        return {}
    stated = _fit(package, _AS_DECLARED)
    if stated is None or not (lacks_fit or stated.reversed_axes):
        return {}
    fits = [fit for candidate in _candidates(package.rows) if (fit := _fit(package, candidate)) is not None]
    freedom = len(package.labels) * (package.layout.points - 1 - len(AXES))
    if freedom < 1:
        return {}
    best = min(fits, key=lambda fit: float(fit.left.sum()))
    alike = [fit for fit in fits if not is_plainly_less(best.left.sum(), fit.left.sum(), freedom)]
    fewest = min(fit.changes for fit in alike)
    simplest = [fit for fit in alike if fit.changes == fewest]
    if not any(fit.candidate == _AS_DECLARED for fit in alike):
        return _of_other_angles(package, stated, simplest, _of_unlike_polarities(package, alike, simplest), freedom)
    return {} if stated.astray else _of_polarities(package, stated, simplest)


def is_of_attitudes(package: Package) -> bool:
    """Return whether the models are of three sensitivities at attitudes, and the package was never moved."""
    names = package.models[0].primary_names
    return (
        set(component_indices(names)) == set(AXES)
        and len(names) == 1 + len(AXES)
        and package.models[0].convention in ("TP", _PER_GRAVITY)
        and package.models[0].basis_key is not None
        and len({model.basis_key for model in package.models}) == 1
        and package.rows.mounting is None
    )


_AS_DECLARED: Final = _Candidate((0, 1, 2), (1, 1, 1))


def _candidates(rows: Observations) -> Sequence[_Candidate]:
    turns = [index for index, name in enumerate(ANGLES) if getattr(rows, f"{name}_rad") is not None]
    found = []
    for order in permutations(turns):
        at = list(range(len(ANGLES)))
        for index, source in zip(turns, order, strict=True):
            at[index] = source
        for chosen in product((1, -1), repeat=len(turns)):
            signs = dict(zip(turns, chosen, strict=True))
            found.append(_Candidate(tuple(at), tuple(signs.get(index, 1) for index in range(len(ANGLES)))))
    return found


def _read_as(rows: Observations, candidate: _Candidate) -> Observations:
    """Return the rows with the angles, and their rates, of a candidate."""
    angles = [getattr(rows, f"{name}_rad") for name in ANGLES]
    turned = {
        f"{name}_rad": angles[at] if angles[at] is None else sign * angles[at]
        for name, at, sign in zip(ANGLES, candidate.order, candidate.signs, strict=True)
    }
    rates = rows.euler_rate_rad_s
    if rates is not None:
        rates = rates[:, list(candidate.order)] * np.array(candidate.signs, dtype=float)
    return replace(rows, euler_rate_rad_s=rates, **turned)


def _fit(package: Package, candidate: _Candidate) -> _Fit | None:
    rows, layout, labels, models, declared = package
    basis = layout.mean_by_point(models[0].basis(_read_as(rows, candidate)))
    u, sizes, vt = np.linalg.svd(basis, full_matrices=False)
    if not sizes[-1] > _DETERMINED * sizes[0]:
        return None
    outputs = layout.mean_by_point(np.stack([rows.outputs[label] for label in labels], axis=1))
    found = vt.T @ ((u.T @ outputs) / sizes[:, None])
    residuals = outputs - basis @ found
    squares = np.sum((outputs - outputs.mean(axis=0)) ** 2, axis=0)
    sums = np.maximum(np.sum(residuals**2, axis=0), _ROUNDING * np.sum(outputs**2, axis=0))
    at = component_indices(models[0].primary_names)
    k = found[[at[axis] for axis in AXES]].T
    convention = models[0].convention
    return _Fit(
        candidate,
        np.divide(sums, squares, out=np.ones_like(sums), where=squares > 0.0),
        np.sqrt(sums / max(layout.points - basis.shape[1], 1)),
        np.linalg.norm(k, axis=1),
        sum(int(np.argmax(np.abs(row))) != entry.index for row, entry in zip(k, declared, strict=True)),
        _reversed_axes(labels, k, declared, convention),
    )


def _reversed_axes(
    labels: Sequence[str], k: FloatArray, declared: Sequence[DeclaredDirection], convention: str
) -> tuple[str, ...]:
    """Return the axes that read with another polarity than declared, or, by CR, than most of the others."""
    along = np.array([row[entry.index] * entry.sense for row, entry in zip(k, declared, strict=True)])
    polarity = np.array([0 if entry.polarity is None else entry.polarity for entry in declared])
    if convention != _PER_GRAVITY:
        return tuple(label for label, sign in zip(labels, np.sign(along) * polarity, strict=True) if sign < 0)
    with_gravity = along * np.where(polarity == 0, 1, polarity) > 0.0
    is_odd = ~with_gravity if 2 * int(with_gravity.sum()) >= len(labels) else with_gravity
    return tuple(label for label, odd in zip(labels, is_odd, strict=True) if odd)


def is_plainly_less(less: float, more: float, freedom: int) -> bool:
    """Return whether one sum of squares is less than another by more than chance or a real lack of fit would have it.

    ``freedom``: degrees of freedom of either.
    """
    ratio = float(more) / float(less)
    return ratio > _MANY_TIMES and float(f_tail(ratio, float(freedom), float(freedom))) < _CHANCE


def _of_other_angles(
    package: Package, stated: _Fit, simplest: Sequence[_Fit], otherwise: str, freedom: int
) -> Mapping[str, Finding]:
    """Return the finding of every axis whose lack of fit the other angles explain; of the worst at least."""
    other, of_each = simplest[0], freedom // len(package.labels)
    ratio = stated.left / other.left
    of = [
        label
        for label, less, more in zip(package.labels, other.left.tolist(), stated.left.tolist(), strict=True)
        if is_plainly_less(less, more, of_each)
    ] or [package.labels[int(np.argmax(ratio))]]
    worst = int(np.argmax(stated.size / other.length))
    found = [sized(fit.size[worst], other.length[worst], package.models[0]) for fit in (other, stated)]
    fits_with = _either([_words(fit) for fit in simplest])
    fact = (
        f"the readings fit with {fits_with} to {found[0]}, as declared to {found[1]} (axis {package.labels[worst]}, "
        f"standard deviation over the points){otherwise}: the sign or the order of the angles is not the declared one; "
        "offset and sensitivities belong to other attitudes, which the stated uncertainties do not hold"
    )
    what_to_do = "correct the angles, or the sign of the axis in the rig file, and solve again"
    details: dict[str, float | str | None] = {
        FITS_WITH: fits_with,
        "fits_to_v": float(other.size[worst]),
        AS_DECLARED_TO: float(stated.size[worst]),
    }
    finding = Finding(KIND, fact, True, None, details=details, is_held=False, what_to_do=what_to_do)
    return dict.fromkeys(of, finding)


def _of_unlike_polarities(package: Package, alike: Sequence[_Fit], simplest: Sequence[_Fit]) -> str:
    """Return what else is as simple where axes of undeclared polarity may read with several."""
    if all(entry.polarity is not None for entry in package.declared):
        return ""
    fewest = min(fit.candidate.changes for fit in alike)
    named = {fit.candidate for fit in simplest}
    others = [fit.candidate.words() for fit in alike if fit.candidate.changes == fewest and fit.candidate not in named]
    unlike = f"; with {_either(others)} as well, were the polarities of the axes unlike, which nobody declared"
    return unlike if others else ""


def _of_polarities(package: Package, stated: _Fit, simplest: Sequence[_Fit]) -> Mapping[str, Finding]:
    """Return the finding of the axes that do not read with the polarity of the others."""
    is_declared = all(entry.polarity is not None for entry in package.declared)
    is_per_gravity = package.models[0].convention == _PER_GRAVITY
    if not (is_per_gravity and stated.reversed_axes):
        return {}  # a declared polarity of one axis is held against it by itself
    others = tuple(label for label in package.labels if label not in stated.reversed_axes)
    is_tied = len(others) == len(stated.reversed_axes)
    fits_with = _either(_of_outputs(package, simplest, stated, is_tied=is_tied))
    counted = ", polarities counted as they are declared" if is_declared else ""
    is_of_rates = package.rows.euler_rate_rad_s is not None
    key = "nominal_sensitivity_v_per_dps" if is_of_rates else "nominal_sensitivity_v_per_g"
    declare = "" if is_declared else f", or declare the polarity ({key} of the rig file, --polarity of calrig fit)"
    file = "the file (the signs of its rates as well)" if is_of_rates else "the file"
    fact = (
        f"the axes do not read with one polarity: {' and '.join(others)} one way, "
        f"{' and '.join(stated.reversed_axes)} the other{counted}; they read with one with {fits_with}; angles "
        "inferred with such a set may have that sign"
    )
    what_to_do = f"correct {file}, the sign of the axis in the rig file or the wiring{declare}, and solve again"
    finding = Finding(
        KIND, fact, True, None, details={FITS_WITH: fits_with}, is_held=not is_declared, what_to_do=what_to_do
    )
    return dict.fromkeys(package.labels if is_tied else stated.reversed_axes, finding)


def _of_outputs(package: Package, simplest: Sequence[_Fit], stated: _Fit, *, is_tied: bool) -> list[str]:
    """Return the ways out in words, the outputs that may be reversed in one of them."""
    angles = [_words(fit) for fit in simplest if fit.candidate != _AS_DECLARED]
    if not any(fit.candidate == _AS_DECLARED for fit in simplest):
        return angles
    outputs = package.labels if is_tied else stated.reversed_axes
    reversed_ones = " or ".join(outputs) if is_tied else " and ".join(outputs)
    return [*angles, f"output {reversed_ones} of the opposite polarity"]


def _words(fit: _Fit) -> str:
    parts = [fit.candidate.words()]
    if fit.reversed_axes:
        parts.append(f"output {' and '.join(fit.reversed_axes)} of the opposite polarity")
    return " and ".join(part for part in parts if part)


def _either(ways: Sequence[str]) -> str:
    """Return the ways out, those that turn one sign round in one phrase."""
    end = " of the opposite sign"
    turned = [name for name in ANGLES if f"{name}{end}" in ways]
    merged = [f"{' or '.join(turned)}{end}"] if turned else []
    merged += [way for way in ways if way.removesuffix(end) not in ANGLES]
    more = [", or in other ways"] if len(merged) > _MOST_NAMED else []
    return ", or with ".join(merged[:_MOST_NAMED]) + "".join(more)


def sized(size_v: float, length: float, model: Model) -> str:
    """Return what is left of an output of a sensitivity in words: as an angle of an accelerometer."""
    if "k_x_v_per_g" not in model.primary_names:
        return f"{significant(size_v)} {printed(model.measured_unit)}"
    away_deg = float(np.rad2deg(size_v / length))
    return f"{significant(away_deg)}°" if away_deg >= 1.0 else f"{significant(away_deg * ARCSEC_PER_DEG)}″"
