"""How uncertain outputs are at every attitude, as polynomials in the specific force.

The prediction of an output errs by φᵀε with φ the functions that its parameters multiply, (1, f) for a straight line,
and ε the errors of these parameters. A covariance between outputs is then a polynomial in f, of second degree for
lines, of fourth with quadratic terms. Its coefficients are found once; on |f| = 1, where f_z² = 1 − f_x² − f_y², a
block of attitudes costs one product of its monomials with them. Symmetric 3 × 3 matrices stand as their six different
elements xx, yy, zz, xy, xz, yz, channels first. Source: TP (52), (73).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from ams.arrays import FloatArray

Polynomial = Mapping[tuple[int, int, int], float]
"""Powers of f_x, f_y, f_z to their coefficient."""

LINE_BASIS: Final[tuple[Polynomial, ...]] = ({(0, 0, 0): 1.0}, {(1, 0, 0): 1.0}, {(0, 1, 0): 1.0}, {(0, 0, 1): 1.0})
"""Of offset, k_x, k_y and k_z."""
_OF_LINES: Final = (
    (0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (2, 0, 0), (0, 2, 0), (1, 1, 0), (1, 0, 1), (0, 1, 1)
)  # fmt: skip
PACKED: Final = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


class ForceErrors(Protocol):
    """What is not known of K⁻¹(v − b), the specific force as three outputs give it, in g²."""

    def total(self, force: FloatArray) -> FloatArray:
        """Return the (6, n) covariance at (3, n) unit force, calibration and readings together."""

    def parts(self, force: FloatArray, rows: NDArray[np.intp]) -> FloatArray:
        """Return (C, 6, m) independent parts of the covariance in some of the rows."""

    def dof(self, rows: NDArray[np.intp]) -> FloatArray:
        """Return the (C, m), or (C, 1), degrees of freedom of the parts; infinite for the readings' own."""

    def weighing(self, sensed: FloatArray, square: FloatArray) -> "Weighing":
        """Return what to weigh the outputs by at (3, n) sensed force, given its (n,) squared length."""


class Weighing(Protocol):
    """The covariance C_w that n rows are weighed by, up to a factor of each."""

    def times(self, force: FloatArray) -> FloatArray:
        """Return (3, n) C_w f."""

    def of(self, rows: NDArray[np.intp]) -> "Weighing":
        """Return the weighing of some of the rows."""


@dataclass(frozen=True)
class SharedWeighing:
    """Readings of their own sharpness, calibrations of a common one: C_w = R + p C, R and C the same in all rows."""

    matrices: FloatArray
    """(6, 3) R above C."""
    share: FloatArray
    """(n,) p."""

    def times(self, force: FloatArray) -> FloatArray:
        both = self.matrices @ force
        product, of_calibration = both[:3], both[3:]
        of_calibration *= self.share
        product += of_calibration
        return product

    def of(self, rows: NDArray[np.intp]) -> "SharedWeighing":
        return SharedWeighing(self.matrices, self.share[rows])


@dataclass(frozen=True)
class PackedWeighing:
    """Any covariance."""

    packed: FloatArray
    """(6, n)"""

    def times(self, force: FloatArray) -> FloatArray:
        return times(self.packed, force)

    def of(self, rows: NDArray[np.intp]) -> "PackedWeighing":
        return PackedWeighing(self.packed[:, rows])


@dataclass(frozen=True)
class ParameterErrors:
    """What is not known of S outputs."""

    covariances_v2: FloatArray
    """(C, S P, S P) independent parts of the covariance of the parameters of every output in turn."""
    dof: FloatArray
    """(C,); infinite where a part is known as it stands."""
    reading_v2: FloatArray
    """(S,) variance of a reading where the sensors are used."""
    basis: Sequence[Polynomial] = LINE_BASIS
    """(P,) what the parameters of an output multiply."""


@dataclass(frozen=True)
class PolynomialErrors:
    """:class:`ForceErrors` of three outputs that stay the same from row to row."""

    powers: Sequence[tuple[int, int, int]]
    """(M,) of the monomials."""
    total_g2: FloatArray
    """(6, M)"""
    parts_g2: FloatArray
    """(C, 6, M)"""
    weighing_matrices: FloatArray
    """(6, 3) of :class:`SharedWeighing`."""
    share: FloatArray
    """(M,) polynomial of its p."""
    parts_dof: FloatArray
    """(C,)"""

    def total(self, force: FloatArray) -> FloatArray:
        return self.total_g2 @ monomials(force, self.powers)

    def parts(self, force: FloatArray, rows: NDArray[np.intp]) -> FloatArray:
        return np.asarray(self.parts_g2 @ monomials(force[:, rows], self.powers))

    def dof(self, rows: NDArray[np.intp]) -> FloatArray:  # noqa: ARG002 the same in all rows
        return self.parts_dof[:, None]

    def weighing(self, sensed: FloatArray, square: FloatArray) -> SharedWeighing:
        inverse = 1.0 / np.sqrt(square)
        if len(self.powers) > len(_OF_LINES):
            return SharedWeighing(self.weighing_matrices, self.share @ monomials(sensed * inverse, self.powers))
        form, constant = self._share_of_lines
        both = form @ sensed
        share = np.einsum("in,in->n", both[:3], sensed)
        share *= inverse
        share += both[3]
        share *= inverse
        share += constant
        return SharedWeighing(self.weighing_matrices, share)

    @cached_property
    def _share_of_lines(self) -> tuple[FloatArray, float]:
        """(4, 3) the quadratic form of p for straight lines above its slopes, and its constant."""
        constant, x, y, z, xx, yy, xy, xz, yz = (self.share[self.powers.index(name)] for name in _OF_LINES)
        form = np.array([[xx, xy / 2.0, xz / 2.0], [xy / 2.0, yy, yz / 2.0], [xz / 2.0, yz / 2.0, 0.0], [x, y, z]])
        return form, float(constant)


def errors_of_force(k_v_per_g: FloatArray, errors: ParameterErrors) -> PolynomialErrors:
    """Return the errors of K⁻¹(v − b) for (3, 3) sensitivities.

    Outputs are weighed by their reading's own variance and, of the calibrations, by their mean in units of g: a
    calibration's own variance rests on a few replications and would prefer the axis that happened to look sharp.
    """
    powers, by_output = output_polynomials(errors)
    inverse = np.linalg.inv(k_v_per_g)
    by_reading = np.zeros((1, *by_output.shape[1:]))
    constant = powers.index((0, 0, 0))
    by_reading[0, range(3), range(3), constant] = errors.reading_v2
    parts = np.concatenate([by_output, by_reading])
    squares = np.sum(k_v_per_g**2, axis=1)
    mean = np.mean(np.einsum("ciim->im", by_output) / squares[:, None], axis=0)
    reading = errors.reading_v2 if mean.any() or errors.reading_v2.any() else np.ones(3)
    packed = _packed(np.einsum("ai,cijm,bj->cabm", inverse, parts, inverse))
    return PolynomialErrors(
        powers,
        packed.sum(axis=0),
        packed,
        np.concatenate([inverse * reading @ inverse.T, inverse * squares @ inverse.T]),
        mean,
        np.append(errors.dof, np.inf),
    )


def output_polynomials(errors: ParameterErrors) -> tuple[list[tuple[int, int, int]], FloatArray]:
    """Return the M powers and the coefficients (C, S, S, M) of the calibration's covariance between outputs, volts²."""
    products = [[_on_sphere(_product(p, q)) for q in errors.basis] for p in errors.basis]
    names = sorted({name for row in products for product in row for name in product} | {(0, 0, 0)})
    values = np.array([[[product.get(name, 0.0) for name in names] for product in row] for row in products])
    outputs, terms = errors.reading_v2.size, len(errors.basis)
    blocks = errors.covariances_v2.reshape(-1, outputs, terms, outputs, terms)
    found = np.einsum("cipjq,pqm->cijm", blocks, values)
    return names, (found + np.swapaxes(found, 1, 2)) / 2.0


def monomials(force: FloatArray, powers: Sequence[tuple[int, int, int]]) -> FloatArray:
    """Return (M, n) products of powers of (3, n) force."""
    highest = map(max, zip(*powers, strict=True))
    by_axis = [[component] for component in force]
    for raised, high in zip(by_axis, highest, strict=True):
        for _ in range(1, high):
            raised.append(raised[-1] * raised[0])
    values = np.empty((len(powers), force.shape[1]))
    for row, each in zip(values, powers, strict=True):
        factors = [raised[power - 1] for raised, power in zip(by_axis, each, strict=True) if power]
        row[:] = factors[0] if factors else 1.0
        for factor in factors[1:]:
            row *= factor
    return values


def quadratic_form(packed: FloatArray, vector: FloatArray) -> FloatArray:
    """Return (…, n) vᵀCv of (…, 6, n) matrices and (3, n) vectors."""
    x, y, z = vector
    products = np.empty((6, vector.shape[1]))
    np.multiply(vector, vector, out=products[:3])
    twice = x + x
    np.multiply(twice, y, out=products[3])
    np.multiply(twice, z, out=products[4])
    np.multiply(y + y, z, out=products[5])
    return np.asarray(np.einsum("...in,in->...n", packed, products))


def times(packed: FloatArray, vector: FloatArray) -> FloatArray:
    """Return (3, n) products Cv of (6, n) matrices and (3, n) vectors."""
    xx, yy, zz, xy, xz, yz = packed
    x, y, z = vector
    product = np.empty_like(vector)
    product[0] = xx * x + xy * y + xz * z
    product[1] = xy * x + yy * y + yz * z
    product[2] = xz * x + yz * y + zz * z
    return product


def _packed(matrices: FloatArray) -> FloatArray:
    """Return the six elements (…, 6, M) of symmetric matrices (…, 3, 3, M)."""
    return np.stack([(matrices[:, a, b] + matrices[:, b, a]) / 2.0 for a, b in PACKED], axis=1)


def _product(first: Polynomial, second: Polynomial) -> dict[tuple[int, int, int], float]:
    found: dict[tuple[int, int, int], float] = {}
    for (a, b, c), value in first.items():
        for (d, e, f), other in second.items():
            name = (a + d, b + e, c + f)
            found[name] = found.get(name, 0.0) + value * other
    return found


def _on_sphere(polynomial: Polynomial) -> dict[tuple[int, int, int], float]:
    """Return a polynomial with the same values on |f| = 1 and f_z to the first power at most."""
    found: dict[tuple[int, int, int], float] = {}
    left = dict(polynomial)
    while left:
        (a, b, c), value = left.popitem()
        if c < 2:
            found[a, b, c] = found.get((a, b, c), 0.0) + value
            continue
        for name, share in (((a, b, c - 2), value), ((a + 2, b, c - 2), -value), ((a, b + 2, c - 2), -value)):
            left[name] = left.get(name, 0.0) + share
    return found
